r"""Anti-aliased coverage of closed cubic contours by exact area, and its exact derivative.

**Pieces.** Every cubic is cut wherever it crosses a border between pixels, turns in x or in y, or
crosses another contour. Nothing is flattened: the cuts are roots of the cubic itself. A piece
then lies in one pixel, and what it adds to coverage is an integral of a polynomial along it,

    ∫ (column + 1 − x) dy   (to its own pixel),   ∫ dy   (to all pixels on its right),

the signed areas of scan converters, here without a chord in place of the arc. A running sum
along the rows makes them an image.

**Nonzero fill.** Signed areas add up where contours overlap, and a clamp of the sum is wrong in
pixels in which contours cross. So each piece has a weight (:mod:`.winding`): the weighted pieces
bound the filled shape itself, whose signed area is its coverage.

**Derivative.** Moving the boundary by δ sweeps over area: the derivative of a pixel's coverage is
:math:`\int \delta_y\,dx - \delta_x\,dy` along the weighted pieces in it (Reynolds' transport
theorem). For δ a combination of Bernstein polynomials these are again integrals of polynomials.

All of these integrals are, per cubic, fixed combinations of :math:`t_b^k - t_a^k`, k = 1 … 6,
t_a and t_b being the ends of a piece.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ..arrays import like, namespace, running_sum, sum_at, take, where_true
from .cuts import POWER, SLOPE, cut
from .winding import resolve

ORDERS = np.arange(1.0, 7)
"""What the powers in an antiderivative are divided by."""


class Boundary(NamedTuple):
    """The boundary of the filled shapes of B images, as N weighted pieces of C cubics.

    Attributes
    ----------
    curves : (C, 4, 2) array
        Coefficients of 1, t, t², t³ of x and y.
    cubic : (N,) int array
    pixel : (N,) int array
        ``(image · H + row) · W + column``.
    powers : (N, 6) array
        t_bᵏ − t_aᵏ, times the piece's weight.
    size : (B, H, W)
    """

    curves: Any
    cubic: Any
    pixel: Any
    powers: Any
    size: tuple[int, int, int]

    def gradient(self, image: Any) -> Any:
        """What a slope by the images (B, H, W) is by the control points, (C, 4, 2)."""
        xp = namespace(image)
        here = take(image.reshape(-1), self.pixel)
        moments = sum_at(self.cubic, self.powers * here[:, None], len(self.curves))
        moments = moments / like(ORDERS, moments)
        # ∫ tʲ (−y′, x′) dt for j = 0 … 3, from ∫ tᵏ dt for k = 0 … 5.
        windows = xp.stack([moments[:, j : j + 3] for j in range(4)], 1)
        slopes = self.curves[:, 1:] * like(SLOPE, moments)
        normal = xp.stack([-slopes[..., 1], slopes[..., 0]], -1)
        return like(POWER.T, moments) @ (windows @ normal)

    def derivative(self, tangents: Any) -> Any:
        """How the images change, (B, H, W, a), as the control points move by (C, 4, 2, a)."""
        slopes = self.curves[:, 1:] * like(SLOPE, tangents)
        moved = namespace(tangents).einsum("ij,cjda->cida", like(POWER, tangents), tangents)
        swept = _product(moved[:, :, 1], slopes[:, :, 0, None])
        swept = swept - _product(moved[:, :, 0], slopes[:, :, 1, None])
        swept = swept / like(ORDERS[:, None], swept)
        each = (self.powers[:, :, None] * take(swept, self.cubic)).sum(1)
        return sum_at(self.pixel, each, math.prod(self.size)).reshape(*self.size, -1)


def fill(points: Any, sizes: Sequence[int], height: int, width: int) -> tuple[Any, Boundary]:
    """Coverage of each image, (B, H, W), and the boundary of its shape.

    Parameters
    ----------
    points : (B, S, 4, 2) float64 array or tensor
        Control points, contour after contour, in pixels, y down.
    sizes : sequence of int
        Cubics of each contour.
    height, width : int
    """
    # Where nothing turns, or lines are parallel, a division by zero is told apart afterwards.
    with np.errstate(all="ignore"):
        return _fill(points, sizes, height, width)


def _fill(points: Any, sizes: Sequence[int], height: int, width: int) -> tuple[Any, Boundary]:
    xp = namespace(points)
    images = len(points)
    curves = like(POWER, points) @ points.reshape(-1, 4, 2)
    pieces = cut(curves, sizes, images, height, width)
    pieces, weight = resolve(curves, pieces, images * height, width)
    cubic, cell = pieces.cubic, pieces.cell
    powers = (_powers(pieces.end) - _powers(pieces.start)) * weight[:, None]

    cover = weight * (pieces.last - pieces.first)[:, 1]
    # ∫ (x − column) dy: what the piece's own pixel has less than those on its right. x is taken
    # from the cubic's first point, lest large numbers cancel.
    origin, x = curves[:, 0, 0], curves[:, :, 0] * like(np.array([0.0, 1, 1, 1]), curves)
    area = _product(x, curves[:, 1:, 1] * like(SLOPE[:, 0], curves)) / like(ORDERS, curves)
    column = cell % (width + 2) - 1
    climb = (powers[:, :3] * take(curves[:, 1:, 1], cubic)).sum(1)
    missed = (powers * take(area, cubic)).sum(1) + climb * (take(origin, cubic) - column)
    # An arc climbs less or more than its piece only where a chord stands in for it.
    middle = (pieces.first[:, 0] + pieces.last[:, 0]) / 2
    missed = missed + (cover - climb) * (middle - column)
    inside = (column >= 0) & (column < width)
    missed = xp.where(inside, missed, 0.0)
    length = images * height * (width + 2)
    signed = sum_at(cell, cover - missed, length + 1) + sum_at(cell + 1, missed, length + 1)
    signed = running_sum(signed[:-1].reshape(images, height, width + 2))
    # Nothing but rounding is outside 0 … 1.
    image = xp.clip(signed[..., 1:-1], 0, 1)
    # What lies left of the image counts, but moving it a little changes nothing.
    pixel = cell // (width + 2) * width + column
    if not inside.all():
        inside = where_true(inside)
        cubic, pixel, powers = (take(values, inside) for values in (cubic, pixel, powers))
    return image, Boundary(curves, cubic, pixel, powers, (images, height, width))


def _powers(t: Any) -> Any:
    """t, t², … t⁶, (N, 6)."""
    square = t * t
    cube = square * t
    return namespace(t).stack([t, square, cube, square * square, square * cube, cube * cube], -1)


def _product(first: Any, second: Any) -> Any:
    """Coefficients (C, 6, …) of the product of polynomials (C, 4, …) and (C, 3, …)."""
    a, b = first, second
    return namespace(a).stack(
        [
            a[:, 0] * b[:, 0],
            a[:, 1] * b[:, 0] + a[:, 0] * b[:, 1],
            a[:, 2] * b[:, 0] + a[:, 1] * b[:, 1] + a[:, 0] * b[:, 2],
            a[:, 3] * b[:, 0] + a[:, 2] * b[:, 1] + a[:, 1] * b[:, 2],
            a[:, 3] * b[:, 1] + a[:, 2] * b[:, 2],
            a[:, 3] * b[:, 2],
        ],
        1,
    )
