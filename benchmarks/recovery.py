"""Instance recovery: find the axes of a random instance from its picture.

``vf.match`` receives a picture of a letter or word at a random location of the design space. An
axis is identifiable if its standard deviation, computed from the picture, is below 0.01. A picture
counts as recovered if every identifiable axis is within 0.01 of its true normalized value. Two
baselines get the same time for the same picture: a grid over the axes, with each rendering moved to
the ink, and Nelder–Mead over axes and placement from the best result of our coarse search.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

import numpy as np
import torch
from scipy.optimize import minimize

import vfwidget as vf
from vfwidget.matching.images import part
from vfwidget.matching.placement import place_on_ink
from vfwidget.matching.scene import Scene
from vfwidget.matching.start import candidates, rank
from vfwidget.raster import frame

from .table import Row
from .timing import Array

TEXTS = ("a", "g", "R", "S", "e", "and", "Q&")
PLACES = 100
"""Pictures of each font."""
RIVALRIES = 20
"""Pictures of each font for which the baselines run as well."""
SIDE, SMALL = 128, 32
NEAR = 0.01
EXTRA = "VFWIDGET_FONTS"
"""Environment variable that names a folder of additional fonts."""


@dataclass(frozen=True)
class Picture:
    """A picture of a text, and the transform from font units to its pixels."""

    text: vf.Text
    transform: Array
    image: Array


def _draw(text: vf.Text, side: int, transform: torch.Tensor | None = None) -> Picture:
    placed = frame(text, (side, side)) if transform is None else transform
    image = 1 - vf.rasterize(text, (side, side), placed).numpy()
    return Picture(text, placed.numpy(), image)


def clean(text: vf.Text, chance: np.random.Generator) -> Picture:
    """Draw the text without changes."""
    return _draw(text, SIDE)


def blurred(text: vf.Text, chance: np.random.Generator) -> Picture:
    """Blur the picture by 1.5 pixels."""
    picture = _draw(text, SIDE)
    t = np.arange(-8, 9)
    kernel = np.exp(-(t**2) / (2 * 1.5**2))
    kernel /= kernel.sum()
    image = picture.image
    for _ in range(2):
        padded = np.pad(image, ((8, 8), (0, 0)), mode="edge")
        image = sum(k * padded[i : i + SIDE] for i, k in enumerate(kernel)).T
    return Picture(text, picture.transform, image)


def noisy(text: vf.Text, chance: np.random.Generator) -> Picture:
    """Add noise of a tenth of the contrast."""
    picture = _draw(text, SIDE)
    image = picture.image + chance.normal(0, 0.1, picture.image.shape)
    return Picture(text, picture.transform, np.clip(image, 0, 1))


def moved(text: vf.Text, chance: np.random.Generator) -> Picture:
    """Draw the text smaller and off centre."""
    transform = frame(text, (SIDE, SIDE)) * chance.uniform(0.5, 0.8)
    transform[:, 2] += torch.from_numpy(chance.uniform(0.05, 0.35, 2) * SIDE)
    return _draw(text, SIDE, transform)


def small(text: vf.Text, chance: np.random.Generator) -> Picture:
    """Draw the text 32 pixels high."""
    return _draw(text, SMALL)


CONDITIONS: dict[str, Callable[[vf.Text, np.random.Generator], Picture]] = {
    "clean": clean,
    "blur": blurred,
    "noise": noisy,
    "moved": moved,
    "small": small,
}


@dataclass(frozen=True)
class Trial:
    """One recovery: success, overlap of the shapes, error of the outline, and seconds."""

    recovered: bool
    overlap: float
    farthest: float
    seconds: float


def run(quick: bool) -> Iterator[Row]:
    """Yield a line for each font and condition, with the baselines on clean pictures."""
    for name in (*vf.bundled_fonts(), *_extra()):
        font = vf.load_font(name)
        for condition in CONDITIONS:
            count = 5 if quick else PLACES
            trials, rivals = _trials(font, condition, count, 2 if quick else RIVALRIES)
            yield _row(font, condition, trials, rivals)


def _extra() -> list[str]:
    folder = os.environ.get(EXTRA)
    return sorted(str(path) for path in Path(folder).iterdir()) if folder else []


def _trials(
    font: vf.Font, condition: str, count: int, rivalries: int
) -> tuple[list[Trial], list[tuple[bool, bool]]]:
    chance = np.random.default_rng(1)
    lower, upper = font.bounds
    trials, rivals = [], []
    for number in range(count):
        string = TEXTS[number % len(TEXTS)]
        text = vf.Text(font, string).at(theta=chance.uniform(lower, upper)[None])
        picture = CONDITIONS[condition](text, chance)
        begun = perf_counter()
        found = vf.match(picture.image, string, font, progress=False)
        seconds = perf_counter() - begun
        seen = found.outcome.deviation[0] < NEAR
        trials.append(_trial(picture, found, seen, seconds))
        if condition == "clean" and number < rivalries:
            rivals.append((_grid(picture, seen, seconds), _simplex(picture, seen, seconds)))
    return trials, rivals


def _trial(picture: Picture, found: vf.Match, seen: Array, seconds: float) -> Trial:
    text, size = picture.text, picture.image.shape
    placed = found.placement.numpy()
    ours = vf.rasterize(found.text, size, placed).numpy()
    theirs = vf.rasterize(text, size, picture.transform).numpy()
    overlap = float(np.minimum(ours, theirs).sum() / np.maximum(ours, theirs).sum())
    points = [
        t.points().numpy() @ m[:, :2].T + m[:, 2]
        for t, m in ((found.text, placed), (text, picture.transform))
    ]
    em = text.font.units_per_em * float(np.hypot(*picture.transform[:, 0]))
    farthest = float(np.hypot(*(points[0] - points[1]).T).max()) / em
    return Trial(_near(found.text.coordinates, text, seen), overlap, farthest, seconds)


def _near(theta: Array, text: vf.Text, seen: Array) -> bool:
    return bool((abs(theta - text.coordinates)[0][seen] <= NEAR).all())


def _grid(picture: Picture, seen: Array, seconds: float) -> bool:
    """Search a grid over the axes, as fine as the time allows."""
    text, begun = picture.text, perf_counter()
    scene = Scene(text, picture.image.shape)
    ink = part(picture.image, 1, None)[1]
    lower, upper = text.font.bounds
    one = text.coordinates[None]
    _fitted(scene, one, picture.image, ink)
    each = perf_counter() - begun
    per_axis = max(2, int((seconds / each) ** (1 / len(lower))))
    sides = [np.linspace(a, b, per_axis) for a, b in zip(lower, upper, strict=True)]
    best, best_left, begun = one[0], np.inf, perf_counter()
    for place in np.stack(np.meshgrid(*sides, indexing="ij"), -1).reshape(-1, 1, len(lower)):
        left, _ = _fitted(scene, place[None], picture.image, ink)
        if left < best_left:
            best, best_left = place, left
        if perf_counter() - begun > seconds:
            break
    return _near(best, text, seen)


def _fitted(scene: Scene, thetas: Array, image: Array, ink: Array) -> tuple[float, Array]:
    places = place_on_ink(scene.text, thetas, ink, 1, False)
    return float(rank(scene, thetas, places, image, 1)[0]), places[0]


def _simplex(picture: Picture, seen: Array, seconds: float) -> bool:
    """Run Nelder–Mead from the best result of the coarse search until the time is up."""
    text, begun = picture.text, perf_counter()
    scene = Scene(text, picture.image.shape)
    ink = part(picture.image, 1, None)[1]
    thetas = candidates(text)
    places = place_on_ink(text, thetas, ink, 1, False)
    first = int(rank(scene, thetas, places, picture.image, 1).argmin())
    n = len(text.font.axes)
    start = np.concatenate([thetas[first, 0], places[first]])
    unit = np.concatenate([np.ones(n), [SIDE / 10, SIDE / 10, 0.2, 0.1]])
    lower, upper = text.font.bounds
    best, best_left = start, np.inf

    def left(values: Array) -> float:
        nonlocal best, best_left
        if perf_counter() - begun > seconds:
            raise TimeoutError
        x = values * unit
        theta = np.clip(x[:n], lower, upper)[None, None]
        share = float(rank(scene, theta, x[None, n:], picture.image, 1)[0])
        if share < best_left:
            best, best_left = x, share
        return share

    try:
        minimize(left, start / unit, method="Nelder-Mead", options={"maxfev": 10**6})
    except TimeoutError:
        pass
    return _near(np.clip(best[:n], lower, upper)[None], text, seen)


def _row(
    font: vf.Font, condition: str, trials: list[Trial], rivals: list[tuple[bool, bool]]
) -> Row:
    recovered = 100 * np.mean([trial.recovered for trial in trials])
    overlap = np.quantile([trial.overlap for trial in trials], [0.5, 0.05])
    farthest = np.quantile([trial.farthest for trial in trials], [0.5, 0.95])
    seconds = np.median([trial.seconds for trial in trials])
    baseline = ""
    if rivals:
        grid, simplex = 100 * np.mean(rivals, axis=0)
        baseline = f"grid {grid:.0f} %, simplex {simplex:.0f} %"
    return Row(
        benchmark="recovery",
        case=f"{font.family_name}, {condition}",
        ours=f"{recovered:.0f} %",
        baseline=baseline,
        ratio="",
        notes=f"of {len(trials)}; {seconds:.2f} s; IoU {overlap[0]:.4f}, worst 5 % below "
        f"{overlap[1]:.3f}; outline off by {1e3 * farthest[0]:.2g} ‰ of the em, worst 5 % beyond "
        f"{1e3 * farthest[1]:.2g} ‰",
    )
