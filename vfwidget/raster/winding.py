r"""Nonzero fill: which pieces of the contours bound the filled shape.

A piece has a winding number on either side of it, w₋ and w₊, and *inside* is where that is not
zero. Its weight is by how much inside changes across it for each turn the winding changes,

    weight = ([w₊ ≠ 0] − [w₋ ≠ 0]) / (w₊ − w₋),

1 or −1 on the boundary of the shape, 0 within it, ½ on each of two edges that coincide. Along a
contour the winding can only change where another contour crosses or touches it, so the pieces
from one such place to the next, a *run*, have one weight, found at one of them by counting what
a ray to the left crosses.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from ..arrays import begins, count_up, integers, namespace, sorting, sum_at, take, where_true
from .crossings import Split, expand, split
from .cuts import Pieces

BESIDE = 1e-6
"""In pixels, how far from a piece its sides are looked at."""
OPEN = 1e-7
"""In pixels, how far from closed the boundary may be along a row."""


def resolve(curves: Any, pieces: Pieces, rows: int, width: int) -> tuple[Pieces, Any]:
    """Pieces cut where contours cross, and their weights (N,).

    Parameters
    ----------
    curves : (C, 4, 2) array
    pieces : Pieces
    rows, width : int
        Rows of all images together, and columns of one.
    """
    if not len(pieces.cell):
        return pieces, pieces.start
    pieces, parts = split(curves, pieces, width)
    order = sorting(pieces.cell)
    rays = _Rays(pieces, order, take(pieces.cell, order) // (width + 2), width + 2)
    weight = rays.weights(parts, parts.breaks.cumsum(0) - 1)
    height = (parts.pieces.last - parts.pieces.first)[:, 1] * weight
    if (abs(sum_at(parts.pieces.cell // (width + 2), height, rows)) > OPEN).any():
        # Some touch was overlooked: let every piece speak for itself.
        weight = rays.weights(parts, count_up(len(weight), weight))
    return parts.pieces, weight


class _Rays(NamedTuple):
    """Counts what rays to the left cross: chords of pieces, in the order of their rows."""

    pieces: Pieces
    order: Any
    row: Any
    columns: int

    def weights(self, parts: Split, run: Any) -> Any:
        """The weight of each piece (N,), taken at the steepest piece of its run (N,)."""
        own, xp = self.pieces, namespace(run)
        steepness = take(abs((own.last - own.first)[:, 1]), parts.whole)
        # Within a row a piece climbs no more than 1, so the steepest is the last of its run.
        order = sorting(run + 0.99 * steepness)
        chosen = take(order, where_true(xp.roll(begins(run), -1)))

        piece = take(parts.whole, chosen)
        first = take(own.first, piece)
        chord = take(own.last, piece) - first
        place = first + take(parts.middle, chosen)[:, None] * chord
        length = xp.hypot(chord[:, 0], chord[:, 1])
        normal = xp.stack([chord[:, 1], -chord[:, 0]], -1)
        normal = normal / xp.where(length > 0, length, 1.0)[:, None]
        sides = xp.concatenate([place + BESIDE * normal, place - BESIDE * normal])
        # A side may lie in the next row.
        row = take(own.cell, piece) // self.columns - integers(xp.floor(place[:, 1]))
        rows = xp.concatenate([row, row]) + integers(xp.floor(sides[:, 1]))
        winding = self.winding(sides, rows)
        plus, minus = winding[: len(piece)], winding[len(piece) :]
        inside = (plus != 0) * 1.0 - (minus != 0) * 1.0
        turn = plus - minus
        return take(inside / xp.where(turn != 0, turn, 1.0), run)

    def winding(self, points: Any, rows: Any) -> Any:
        """The winding number (P,) at points (P, 2), each in a row."""
        xp = namespace(points)
        begin = xp.searchsorted(self.row, rows)
        end = xp.searchsorted(self.row, rows, side="right")
        ray, met = expand(begin, end)
        met = take(self.order, met)
        x, y = take(points, ray).T
        x0, y0 = take(self.pieces.first, met).T
        x1, y1 = take(self.pieces.last, met).T
        spans = (y0 <= y) != (y1 <= y)
        crossed = spans & (x0 + (y - y0) * (x1 - x0) / xp.where(spans, y1 - y0, 1.0) < x)
        return sum_at(ray, xp.where(crossed, xp.sign(y1 - y0), 0.0), len(points))
