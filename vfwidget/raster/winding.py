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

from typing import Any

from ..arrays import (
    count_up,
    greatest_at,
    integers,
    namespace,
    repeat,
    sorting,
    stacked,
    sum_at,
    take,
    where_true,
)
from .crossings import Split, split
from .cuts import Pieces

BESIDE = 1e-6
"""In pixels, how far from a piece its sides are looked at."""
OPEN = 1e-7
"""In pixels, how far from closed the boundary may be along a row."""


def resolve(curves: Any, pieces: Pieces, rows: int, width: int) -> tuple[Pieces, Any]:
    """Pieces cut where contours cross, and their weights (N,).

    Parameters
    ----------
    curves : (4, 2, C) array
    pieces : Pieces
    rows, width : int
        Rows of all images together, and columns of one.
    """
    if not len(pieces.row):
        return pieces, pieces.start
    pieces, parts = split(curves, pieces, width)
    weight = _weights(pieces, rows, parts, parts.breaks.cumsum(0) - 1)
    height = (parts.pieces.last[1] - parts.pieces.first[1]) * weight
    if (abs(sum_at(parts.pieces.row, height, rows)) > OPEN).any():
        # Some touch was overlooked: let every piece speak for itself.
        weight = _weights(pieces, rows, parts, count_up(len(weight), weight))
    return parts.pieces, weight


def _weights(pieces: Pieces, rows: int, parts: Split, run: Any) -> Any:
    """The weight of each part (N,), taken at the steepest of its run (N,)."""
    xp = namespace(run)
    steepness = take(abs(pieces.last[1] - pieces.first[1]), parts.whole)
    runs = int(run[-1]) + 1
    steepest = where_true(steepness == take(greatest_at(run, steepness, runs), run))
    chosen = count_up(runs, run)
    chosen[take(run, steepest)] = steepest

    piece = take(parts.whole, chosen)
    first = take(pieces.first, piece)
    chord = take(pieces.last, piece) - first
    place = first + take(parts.middle, chosen) * chord
    length = xp.hypot(chord[0], chord[1])
    beside = stacked([chord[1], -chord[0]]) * (BESIDE / xp.where(length > 0, length, 1.0))
    sides = xp.concatenate([place + beside, place - beside], -1)
    # A side may lie in the next row.
    shift = xp.floor(sides[1]) - xp.floor(xp.concatenate([place[1], place[1]]))
    there = xp.concatenate([take(pieces.row, piece)] * 2) + integers(shift)
    winding = _winding(pieces, rows, sides, there)
    plus, minus = winding[: len(piece)], winding[len(piece) :]
    turn = plus - minus
    inside = (plus != 0) * 1.0 - (minus != 0) * 1.0
    return take(inside / xp.where(turn != 0, turn, 1.0), run)


def _winding(pieces: Pieces, rows: int, points: Any, there: Any) -> Any:
    """The winding number (P,) at points (2, P), each in a row: what a ray to the left crosses."""
    xp = namespace(points)
    # Only the pieces of those rows, row by row; a row above or below the images has none.
    asked = count_up(rows + 1, there) < 0
    asked[there] = True
    met = where_true(take(asked, pieces.row))
    met = take(met, sorting(take(pieces.row, met)))
    row = take(pieces.row, met)
    begin = xp.searchsorted(row, there)
    count = xp.searchsorted(row, there, side="right") - begin
    ray = repeat(count)
    met = take(met, count_up(len(ray), ray) - take(count.cumsum(0) - count - begin, ray))
    x, y = take(points, ray)
    x0, y0 = take(pieces.first, met)
    x1, y1 = take(pieces.last, met)
    spans = (y0 <= y) != (y1 <= y)
    crossed = spans & (x0 + (y - y0) * (x1 - x0) / xp.where(spans, y1 - y0, 1.0) < x)
    return sum_at(ray, xp.where(crossed, xp.sign(y1 - y0), 0.0), len(there))
