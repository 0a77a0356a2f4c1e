"""Pictures of letters with known axes, defects of pictures, and the error of a match."""

from __future__ import annotations

import math

import numpy as np

import vfwidget as vf
from vfwidget.matching import Match
from vfwidget.raster import frame

SIZE = (64, 64)
CLEAN = 0.01
"""Every axis that can be told is found within this in a clean picture; it is normalized."""
SEEN = 0.02
"""A standard deviation, in normalized coordinates, below which an axis is to be found."""


def match(image: np.ndarray, string: str, font, **options) -> Match:
    return vf.match(image, string, font, progress=False, **options)


def random_place(text: vf.Text, rng: np.random.Generator) -> vf.Text:
    """Anywhere in the design space; axes that move nothing of the text stay at their default."""
    lower, upper = text.font.bounds
    felt = np.array([len(kinks) > 0 for kinks in text.breakpoints])
    return text.at(theta=rng.uniform(lower, upper, tuple(text.theta.shape)) * felt)


def draw(text: vf.Text, size: tuple[int, int], matrix=None) -> np.ndarray:
    """Black on white."""
    return 1 - vf.rasterize(text, size, matrix).numpy()


def turned(text: vf.Text, size: tuple[int, int], degrees: float, scale=1.0, shift=(0, 0)):
    """The usual placement, turned about the picture's middle, made larger and moved."""
    matrix = frame(text, size).numpy()
    angle = math.radians(degrees)
    turn = scale * np.array(
        [[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]]
    )
    middle = np.array(size[::-1]) / 2
    matrix[:, 2] -= middle
    matrix = turn @ matrix
    matrix[:, 2] += middle + shift
    return matrix


def blurred(image: np.ndarray, sigma: float) -> np.ndarray:
    """Blurred by a Gaussian, by way of its Fourier transform; outside is as at the border."""
    around = np.pad(image, math.ceil(4 * sigma), mode="edge")
    y, x = np.meshgrid(*(np.fft.fftfreq(side) for side in around.shape), indexing="ij")
    window = np.exp(-2 * (np.pi * sigma) ** 2 * (x * x + y * y))
    edge = math.ceil(4 * sigma)
    return np.fft.ifft2(np.fft.fft2(around) * window).real[edge:-edge, edge:-edge]


def axis_error(found: vf.Match, truth: vf.Text) -> float:
    """Largest |Δw| of the axes that the picture shows."""
    seen = found.outcome.deviation < SEEN
    assert seen.any()
    return float(abs(found.text.theta.numpy() - truth.theta.numpy())[seen].max())


def miss(found: vf.Match, truth: vf.Text, matrix: np.ndarray) -> float:
    """How far, in pixels, a control point of the outline is from where it belongs, at most."""
    placed = found.placement.numpy()
    here = found.text.points().numpy() @ placed[:, :2].T + placed[:, 2]
    there = truth.points().numpy() @ matrix[:, :2].T + matrix[:, 2]
    return float(np.hypot(*(here - there).T).max())
