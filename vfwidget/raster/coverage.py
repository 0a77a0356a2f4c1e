r"""Anti-aliased coverage of closed cubic contours by exact area, and its exact derivative.

**Boundary.** :mod:`..outline.arrangement` gives the parts of the cubics that bound the filled
shape. Signed areas of whole contours would add up where contours overlap, and limiting the sum to 1
is wrong in pixels in which contours cross.

**Pieces.** Every cubic is also cut wherever it crosses a border between pixels and where it turns
in x or in y. Nothing is flattened: the cuts are roots of the cubic itself. A piece then lies in one
pixel, and its contribution to coverage is an integral of a polynomial along it,

    ∫ (column + 1 − x) dy   (to its own pixel),   ∫ dy   (to all pixels on its right),

the signed areas of scan converters, here without a chord in place of the arc. A running sum
along the rows makes them an image.

**Derivative.** Moving the boundary by δ sweeps over area: the derivative of a pixel's coverage is
:math:`\int \delta_y\,dx - \delta_x\,dy` along the weighted pieces in it (Reynolds' transport
theorem; :mod:`..outline.area`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ..arrays import (
    add_at,
    between,
    count_up,
    following,
    integers,
    like,
    namespace,
    repeat,
    running_sum,
    take,
    where_true,
    zeros,
)
from ..outline.area import antiderivative, slopes, swept, weighted_powers
from ..outline.arrangement import boundary
from ..outline.monotone import BEFORE_NEXT, POWER, coefficients, monotone_arcs

LEAST_COORDINATE = 2.0**-1000
"""A coordinate nearer to 0 counts as 0."""


class Boundary(NamedTuple):
    """The boundary of the filled shapes of B images, as N weighted pieces of C cubics.

    Attributes
    ----------
    curves : (4, 2, C) array
        Coefficients of 1, t, t², t³ of x and y.
    cubic : (N,) int array
    pixel : (N,) int array
        ``(image · H + row) · W + column``.
    powers : (6, N) array
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
        here = take(image.reshape(-1), self.pixel)
        return swept(self.curves, self.cubic, self.powers * here)

    def apart(self, group: Any, groups: int) -> Boundary:
        """Split the boundary of one image (B = 1) into one image for each group of cubics.

        Parameters
        ----------
        group : (C,) int array
            The group of each cubic.
        groups : int
            The number of groups, and of images.
        """
        _, height, width = self.size
        pixel = self.pixel + height * width * take(group, self.cubic)
        return self._replace(pixel=pixel, size=(groups, height, width))

    def derivative(self, tangents: Any, out: Any = None) -> Any:
        """How the images change, (a, B, H, W), as the control points move by (C, 4, 2, a).

        It is added to ``out``, where that is given.
        """
        xp = namespace(tangents)
        moved = xp.einsum("ij,cjda->idac", like(POWER, tangents), tangents)
        x, y = xp.swapaxes(slopes(self.curves), 0, 1)[:, :, None]
        area = antiderivative(moved[:, 1], x) - antiderivative(moved[:, 0], y)
        each = xp.einsum("kn,kan->an", self.powers, take(area, self.cubic))
        count, pixels = len(each), math.prod(self.size)
        if out is None:
            out = zeros(count * pixels, each).reshape(count, *self.size)
        for image, values in zip(out.reshape(count, pixels), each, strict=True):
            add_at(image, self.pixel, values)
        return out


class Pieces(NamedTuple):
    """N pieces of the boundary, each in one pixel.

    Those above or below the image are left out. Those beside it are kept, because pixels on their
    right depend on them.

    Attributes
    ----------
    cubic : (N,) int array
    start, end : (N,) arrays
        Parameters on the cubic.
    first, last : (2, N) arrays
        The two end points, in pixels.
    row, column : (N,) int arrays
        The pixel: the rows of all images counted on, the column below 0 left of an image and W
        or more right of it.
    weight : (N,) array
        As in :class:`~.outline.arrangement.Spans`.
    """

    cubic: Any
    start: Any
    end: Any
    first: Any
    last: Any
    row: Any
    column: Any
    weight: Any


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
    # Coordinates this small have too few digits for a division, and they change no pixel.
    points = points * (abs(points) >= LEAST_COORDINATE)
    # Where nothing turns, or lines are parallel, a division by zero is told apart afterwards.
    with np.errstate(all="ignore"):
        return _fill(points, sizes, height, width)


def _fill(points: Any, sizes: Sequence[int], height: int, width: int) -> tuple[Any, Boundary]:
    xp = namespace(points)
    images = len(points)
    curves = coefficients(points)
    pieces = _pieces(curves, list(sizes), images, height, width)
    weight, cubic, row, column = pieces.weight, pieces.cubic, pieces.row, pieces.column
    powers = weighted_powers(pieces.start, pieces.end, weight)

    # ∫ (x − column) dy: what a piece's own pixel has less than those on its right. Where a chord
    # stands in for an arc, it climbs less or more than that.
    area = antiderivative(curves[:, 0], slopes(curves)[:, 1])
    area = xp.einsum("kn,kn->n", powers, take(area, cubic))
    climb = xp.einsum("kn,kn->n", powers[:3], take(curves[1:, 1], cubic))
    cover = weight * (pieces.last[1] - pieces.first[1])
    middle = (pieces.first[0] + pieces.last[0]) / 2
    missed = area - climb * middle + cover * (middle - column)
    # What lies left of the image counts in full, what lies right of it not at all.
    nearest = between(column, 0, width - 1)
    pixel = row * width + nearest
    inside = nearest == column
    if not inside.all():
        missed, cover = xp.where(inside, missed, 0.0), xp.where(column < width, cover, 0.0)
    signed = zeros(images * height * width + 1, missed)
    add_at(signed, pixel, cover - missed)
    add_at(signed[1:], pixel, xp.where(column < width - 1, missed, 0.0))
    image = signed[:-1].reshape(images, height, width)
    if len(row):
        # Rows above or below all pieces are empty. Nothing but rounding is outside 0 … 1.
        rows = image.reshape(-1, width)[int(row.min()) : int(row.max()) + 1]
        running_sum(rows, 0.0, 1.0)
    if not inside.all():
        # But moving it a little changes nothing.
        inside = where_true(inside)
        cubic, pixel, powers = (take(values, inside) for values in (cubic, pixel, powers))
    return image, Boundary(curves, cubic, pixel, powers, (images, height, width))


def _pieces(curves: Any, sizes: list[int], images: int, height: int, width: int) -> Pieces:
    xp = namespace(curves)
    image = count_up(curves.shape[-1], curves) // (curves.shape[-1] // images)
    spans = boundary(curves, sizes * images, image)
    cubic, start, end, first, last, _ = monotone_arcs(
        curves, sizes * images, (width, height), spans.cubic, spans.start
    )
    middles = cubic + BEFORE_NEXT * (start + end) / 2
    opening = xp.searchsorted(middles, spans.cubic + BEFORE_NEXT * spans.start)
    closing = following(opening)
    closing[-1:] = len(middles)
    weight = take(spans.weight, repeat(closing - opening))
    column, row = integers(xp.floor((first + last) / 2))
    kept = (row >= 0) & (row < height)
    if images > 1:
        row = row + take(image, cubic) * height
    pieces = Pieces(cubic, start, end, first, last, row, column, weight)
    if kept.all():
        return pieces
    kept = where_true(kept)
    return Pieces(*(take(values, kept) for values in pieces))
