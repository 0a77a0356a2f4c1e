r"""The picture that a text would make: its forward model, and that model's derivative.

    image = light · (1 − C) + ink · C,   C = blur ∗ coverage(placed outline),

as a function of Θ, of where and how large the text stands, of the blur, and of the light. The
outline is placed by p ↦ t + s R(φ) (p − c), y turned down, c being the middle of the text.

Blur is the discrete Gaussian of variance v (Lindeberg 1990), whose derivative by v is half the
discrete Laplacian: so a fit can leave v = 0, where that of a sampled Gaussian has no slope.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..arrays import Array, BoolArray
from ..errors import ImageError
from ..raster.coverage import Boundary, fill
from ..text import Text
from .images import Levels, basis

PLACEMENT = ("x", "y", "size", "turn")
"""t in pixels, log s and φ."""
BESIDE = 1e-7
"""How far apart two states may be whose pictures are alike: a solver's step off a kink."""
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
        Of the paper's brightness, in :func:`.images.basis`.
    ink : float
    """

    theta: Array
    placement: Array
    blur: float
    light: Array
    ink: float

    def flat(self) -> Array:
        """All in one vector."""
        parts = (self.theta.ravel(), self.placement, [self.blur], self.light, [self.ink])
        return np.concatenate(parts)

    def like(self, flat: Array) -> State:
        """The state that a vector spells."""
        ends = np.cumsum([self.theta.size, 4, 1, len(self.light)])
        theta, placement, blur, light, ink = np.split(flat, ends)
        return State(
            theta.reshape(self.theta.shape), placement, float(blur[0]), light, float(ink[0])
        )


class Scene:
    """Pictures of one text at one resolution.

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
        self._outline = text.point_set()
        self._sizes = text.word.contours
        if not self._sizes:
            raise ImageError(f"There is no ink to match: {text.string!r} is blank.")
        self._indices = self._sizes.segments
        self.centre = middle(text)
        self._latest: tuple[Array, _Picture] | None = None

    def matrix(self, placement: Array) -> Array:
        """A placement as the affine map (2, 3) from the text's units to full pixels."""
        x, y, size, turn = placement
        c, s = math.exp(size) * math.cos(turn), math.exp(size) * math.sin(turn)
        linear = np.array([[c, s], [s, -c]])
        return np.concatenate([linear, (np.array([x, y]) - linear @ self.centre)[:, None]], 1)

    def coverage(self, thetas: Array, placements: Array) -> Array:
        """Ink without blur of B candidates, (B, H, W), from (B, parameters, n) and (B, 4)."""
        return self._fill(thetas, placements)[0]

    def _fill(self, thetas: Array, placements: Array) -> tuple[Array, Boundary]:
        points = self.text.positions(self._outline, thetas)
        maps = np.stack([self.matrix(placement) for placement in placements]) / self.factor
        points = points @ np.swapaxes(maps[:, :, :2], 1, 2) + maps[:, None, :, 2]
        return fill(points[:, self._indices], self._sizes, *self.shape)

    def image(self, state: State) -> Array:
        """The picture (H, W)."""
        return self._picture(state).image

    def paper(self, state: State) -> Array:
        """The picture without ink, (H, W)."""
        return Levels(state.light, state.ink).paper(*self.shape)

    def covered(self, state: State) -> Array:
        """How much ink is in each pixel, blur included, (H, W)."""
        return self._picture(state).covered

    def jacobian(self, state: State, free: BoolArray) -> Array:
        """Its derivative by what is free of the state's :meth:`~State.flat` form, (f, H, W)."""
        # Where the derivative is asked for beside a kink, the picture is that of the kink.
        picture = self._picture(state, BESIDE)
        count = state.theta.size + len(PLACEMENT)
        kinds = np.split(free, [count, count + 1, len(free) - 1])
        # A large array, so none but itself is made: its parts are written in place.
        rows = np.zeros((free.sum(), *self.shape))
        outline, blur, paper, ink = np.split(rows, np.cumsum([kind.sum() for kind in kinds[:-1]]))
        steps = self._moves(state)[..., kinds[0]][self._indices]
        picture.boundary.derivative(steps, outline[:, None])
        if picture.variance >= LEAST_BLUR:
            outline[:] = _blur(outline, picture.variance)
        if len(blur):
            blur[:] = _laplacian(picture.covered) / (2 * self.factor**2)
        rows[: len(outline) + len(blur)] *= state.ink - picture.light
        over = np.moveaxis(basis(*self.shape, len(state.light)), -1, 0)
        np.multiply(over[kinds[2]], 1 - picture.covered, out=paper)
        ink[:] = picture.covered
        return rows

    def _moves(self, state: State) -> Array:
        """How the control points (K, 2) move by Θ and by the placement, (K, 2, size + 4)."""
        points, moves = self.text.positions_and_jacobian(self._outline, state.theta)
        linear = self.matrix(state.placement)[:, :2] / self.factor
        placed = (points - self.centre) @ linear.T
        count = len(points)
        turned = np.stack([-placed[:, 1], placed[:, 0]], -1)
        ahead = np.broadcast_to(np.eye(2) / self.factor, (count, 2, 2))
        by_theta = linear @ moves.reshape(count, 2, -1)
        return np.concatenate([by_theta, ahead, placed[..., None], turned[..., None]], -1)

    def _picture(self, state: State, slack: float = 0.0) -> _Picture:
        """The latest picture, if its state was no farther away than ``slack``, or a new one."""
        flat = state.flat()
        if self._latest is None or abs(flat - self._latest[0]).max() > slack:
            self._latest = flat, self._draw(state)
        return self._latest[1]

    def _draw(self, state: State) -> _Picture:
        sharp, boundary = self._fill(state.theta[None], state.placement[None])
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
    """The middle of the box around the control points at the default, (2,), wherever text is."""
    points = text.positions(text.point_set(), np.zeros_like(text.coordinates))
    return (points.min(0) + points.max(0)) / 2


def _blur(images: Array, variance: float) -> Array:
    """Images (a, H, W) blurred by the discrete Gaussian; outside them is nothing."""
    if variance < LEAST_BLUR:
        return images
    import torch

    reach = math.ceil(4 * math.sqrt(variance)) + 2
    around = 2 * np.pi * np.arange(reach + 1) / (2 * reach + 1)
    kernel = np.fft.irfft(np.exp(variance * (np.cos(around) - 1)), 2 * reach + 1)
    weights = torch.from_numpy(np.fft.fftshift(kernel))
    stack = torch.from_numpy(images)[:, None]
    stack = torch.nn.functional.conv2d(stack, weights[None, None, :, None], padding=(reach, 0))
    stack = torch.nn.functional.conv2d(stack, weights[None, None, None, :], padding=(0, reach))
    return stack[:, 0].numpy()


def _laplacian(image: Array) -> Array:
    around = np.pad(image, 1)
    sides = around[:-2, 1:-1] + around[2:, 1:-1] + around[1:-1, :-2] + around[1:-1, 2:]
    return sides - 4 * image
