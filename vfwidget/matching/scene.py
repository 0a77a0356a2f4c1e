r"""The picture that a text would make: its forward model, and that model's derivative.

    image = light · (1 − C) + ink · C,   C = blur ∗ coverage(placed outline),

as a function of Θ, of where and how large the text stands, of the blur, and of the light. The
outline is placed by p ↦ t + s R(φ) (p − c), y turned down, c being the middle of the text.

Blur is the discrete Gaussian of variance v (Lindeberg 1990), whose derivative by v is half the
discrete Laplacian: so a fit can leave v = 0, where that of a sampled Gaussian has no slope.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Array, IntArray
from ..errors import ImageError
from ..outline.contours import Contours
from ..raster.coverage import Boundary, fill
from ..text import Text
from ..text.place import AXES, OFFSETS, TRACKING
from .displacements import Displacements, displacements
from .images import Levels, basis

PLACEMENT = ("x", "y", "size", "rotation")
"""t in pixels, log s and φ."""
BESIDE = 1e-7
"""Two states this close share a picture: the solver evaluates slopes 1e-8 away from a kink."""
BATCH = 2**15
"""Curves of the candidates that are drawn together: more take more memory and no less time."""
BAND = 512
"""Pixels of a side that are blurred together, as many as a match has by default."""
LEAST_BLUR = 1e-6
"""A variance, in pixels², that is not worth a convolution."""


@dataclass(frozen=True)
class State:
    """Everything that a picture of a text depends on.

    Attributes
    ----------
    theta : (parameters, n) array
    placement : (4,) array
        t in pixels, log s in pixels per font unit, φ in radians.
    blur : float
        Variance in pixels².
    light : (terms,) array
        Coefficients of the paper's brightness in :func:`.images.basis`.
    ink : float
        Brightness of the ink.
    offsets : (l, 2) array
        Displacements of the letters, in font units.
    tracking : (1,) array
        Space after each grapheme, in font units.
    """

    theta: Array
    placement: Array
    blur: float
    light: Array
    ink: float
    offsets: Array
    tracking: Array

    @property
    def place(self) -> dict[str, Array]:
        """The text's own unknowns."""
        return {AXES: self.theta, OFFSETS: self.offsets, TRACKING: self.tracking}

    def is_near(self, other: State, slack: float) -> bool:
        """Whether no number differs by more than ``slack``."""
        return bool(abs(self.flat() - other.flat()).max() <= slack)

    def flat(self) -> Array:
        """All numbers in one vector."""
        own = (block.ravel() for block in self.place.values())
        return np.concatenate([*own, self.placement, self.light, [self.blur, self.ink]])


class Scene:
    """Pictures of one text at one resolution, at any location: with the glyphs that it has there.

    Parameters
    ----------
    text : Text
    size : (H, W)
        Of the picture at full resolution.
    factor : int
        How many pixels of that make one here, in x and in y.

    Raises
    ------
    ImageError
        The text has no outline.
    """

    def __init__(self, text: Text, size: tuple[int, int], factor: int = 1) -> None:
        self.text, self.factor = text, factor
        height, width = size
        self.shape = -(-height // factor), -(-width // factor)
        if not text.word.contours:
            raise ImageError(f"There is no ink to match: {text.string!r} is blank.")
        self.centre = middle(text)
        self._latest: tuple[State, _Picture] | None = None

    def matrix(self, placement: Array) -> Array:
        """A placement as the affine map (2, 3) from the text's units to full pixels."""
        x, y, size, rotation = placement
        c, s = math.exp(size) * math.cos(rotation), math.exp(size) * math.sin(rotation)
        linear = np.array([[c, s], [s, -c]])
        return np.concatenate([linear, (np.array([x, y]) - linear @ self.centre)[:, None]], 1)

    def coverage(self, thetas: Array, placements: Array) -> Array:
        """Ink without blur of B candidates, (B, H, W), from (B, parameters, n) and (B, 4)."""
        covered = np.empty((len(thetas), *self.shape))
        for text, found in by_glyphs(self.text, thetas):
            contours = text.word.contours
            batches = min(len(found), -(-len(found) * len(contours.segments) // BATCH))
            for at in np.array_split(found, batches):
                points = text.positions(text.point_set(), thetas[at])
                covered[at] = self._fill(contours, points, placements[at])[0]
        return covered

    def _fill(self, contours: Contours, points: Array, placements: Array) -> tuple[Array, Boundary]:
        """Coverage of B placed outlines with control points (B, K, 2)."""
        maps = np.stack([self.matrix(placement) for placement in placements]) / self.factor
        points = points @ np.swapaxes(maps[:, :, :2], 1, 2) + maps[:, None, :, 2]
        return fill(points[:, contours.segments], contours, *self.shape)

    def image(self, state: State, slack: float = 0.0) -> Array:
        """The picture (H, W), or the latest one if its state was no farther away than ``slack``."""
        return self._picture(state, slack).image

    def paper(self, state: State) -> Array:
        """The picture without ink, (H, W)."""
        return Levels(state.light, state.ink).paper(*self.shape)

    def covered(self, state: State) -> Array:
        """How much ink is in each pixel, blur included, (H, W)."""
        return self._picture(state).covered

    def jacobian(self, state: State, wanted: Sequence[str]) -> Array:
        """The picture's derivative by parts of the state, (size, H, W).

        Parameters
        ----------
        state : State
        wanted : sequence of str
            Some of ``"axes"``, ``"offsets"``, ``"tracking"``, ``"x"``, ``"y"``, ``"size"``,
            ``"rotation"``, ``"blur"``, ``"background"`` (the paper's brightness) and ``"ink"``,
            in this order.

        Returns
        -------
        (size, H, W) array
            The parts follow one another as in ``wanted``.
        """
        # The solver may evaluate the slope beside a kink; the picture is that of the kink.
        picture = self._picture(state, BESIDE)
        text = self.text.moved_to(state.place)
        moves = self._moves(text, state.placement, wanted)
        terms = len(state.light) if "background" in wanted else 0
        # One large array, whose parts are written in place.
        sizes = moves.size, int("blur" in wanted), terms, int("ink" in wanted)
        rows = np.zeros((sum(sizes), *self.shape))
        outline, blur, paper, ink = np.split(rows, np.cumsum(sizes[:-1]))
        if moves.size:
            moves.add_to(outline, picture.boundary, text.word.contours.segments)
            if picture.variance >= LEAST_BLUR:
                outline[:] = _blur(outline, picture.variance)
        if len(blur):
            blur[:] = _laplacian(picture.covered) / (2 * self.factor**2)
        rows[: moves.size + len(blur)] *= state.ink - picture.light
        if terms:
            over = np.moveaxis(basis(*self.shape, terms), -1, 0)
            np.multiply(over, 1 - picture.covered, out=paper)
        if len(ink):
            ink[:] = picture.covered
        return rows

    def _moves(self, text: Text, placement: Array, wanted: Sequence[str]) -> Displacements:
        """How the control points move in the picture by parts of the state."""
        points, by_axes = text.point_set().positions_and_jacobian(text.place)
        linear = self.matrix(placement)[:, :2] / self.factor
        placed = (points - self.centre) @ linear.T
        ahead = np.broadcast_to(np.eye(2) / self.factor, (len(points), 2, 2))
        turned = np.stack([-placed[:, 1], placed[:, 0]], -1)
        by_placement = np.concatenate([ahead, placed[..., None], turned[..., None]], -1)
        by_placement = by_placement[..., [name in wanted for name in PLACEMENT]]
        return displacements(text, by_axes, linear, by_placement, wanted)

    def _picture(self, state: State, slack: float = 0.0) -> _Picture:
        """The latest picture, if its state was no farther away than ``slack``, or a new one."""
        if self._latest is None or not state.is_near(self._latest[0], slack):
            self._latest = state, self._draw(state)
        return self._latest[1]

    def _draw(self, state: State) -> _Picture:
        text = self.text.moved_to(state.place)
        points = text.point_set().positions(text.place)
        sharp, boundary = self._fill(text.word.contours, points[None], state.placement[None])
        variance = state.blur / self.factor**2
        covered = _blur(sharp, variance)[0]
        light = self.paper(state)
        image = light + (state.ink - light) * covered
        return _Picture(image, covered, light, variance, boundary)


@dataclass(frozen=True)
class _Picture:
    image: Array
    covered: Array
    light: Array
    variance: float
    boundary: Boundary


def middle(text: Text) -> Array:
    """The middle of the box around the control points at the default, (2,), wherever text is.

    Tracking is not counted, so that the middle is the same before and after it is fitted.
    """
    default = {AXES: np.zeros_like(text.coordinates), TRACKING: np.zeros(1)}
    text = text.moved_to({**text.place, **default})
    points = text.positions(text.point_set(), text.coordinates)
    return (points.min(0) + points.max(0)) / 2


def by_glyphs(text: Text, thetas: Array) -> Iterator[tuple[Text, IntArray]]:
    """The text at one location of each row of glyphs that occurs, and which Θ (B, …) have it."""
    words = [text.composition.word_at(theta) for theta in thetas]
    for word in dict.fromkeys(words):
        at = np.array([i for i, other in enumerate(words) if other is word])
        yield text.moved(thetas[at[0]]), at


def _blur(images: Array, variance: float) -> Array:
    """Images (a, H, W) blurred by the discrete Gaussian; outside them is nothing."""
    if variance < LEAST_BLUR:
        return images
    reach = math.ceil(4 * math.sqrt(variance)) + 2
    around = 2 * np.pi * np.arange(reach + 1) / (2 * reach + 1)
    kernel = np.fft.fftshift(np.fft.irfft(np.exp(variance * (np.cos(around) - 1)), 2 * reach + 1))
    across = _along_rows(images, kernel)
    return _along_rows(across.swapaxes(1, 2), kernel).swapaxes(1, 2)


def _along_rows(images: Array, kernel: Array) -> Array:
    """The convolution of each row of images (a, H, W) with a kernel."""
    rows = images.reshape(-1, images.shape[2])
    parts = [rows[:, near] @ band for near, band in _bands(rows.shape[1], kernel)]
    return np.concatenate(parts, 1).reshape(images.shape)


def _bands(size: int, kernel: Array) -> Iterator[tuple[slice, Array]]:
    """A convolution along a side as products of matrices, for a part of the side at a time.

    Functions for convolutions take many times as long for a wide kernel, and much memory.

    Yields
    ------
    near : slice
        The pixels that contribute to a part.
    band : array
        Their shares, in rows, in each pixel of the part.
    """
    reach = len(kernel) // 2
    for start in range(0, size, BAND):
        end = min(start + BAND, size)
        first, last = max(0, start - reach), min(size, end + reach)
        distance = np.arange(first, last)[:, None] - np.arange(start, end)
        shares = kernel.take(distance + reach, mode="clip")
        band = np.where(abs(distance) <= reach, shares, 0.0)
        yield slice(first, last), band


def _laplacian(image: Array) -> Array:
    around = np.pad(image, 1)
    sides = around[:-2, 1:-1] + around[2:, 1:-1] + around[1:-1, :-2] + around[1:-1, 2:]
    return sides - 4 * image
