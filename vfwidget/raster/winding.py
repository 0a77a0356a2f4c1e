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
    between,
    count_up,
    expand,
    greatest_at,
    integers,
    namespace,
    stacked,
    sum_at,
    take,
    where_true,
    zeros,
)
from .crossings import TOUCH, Split, split
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
    weight = _weights(pieces, rows, width, parts, parts.breaks.cumsum(0) - 1)
    height = (parts.pieces.last[1] - parts.pieces.first[1]) * weight
    if (abs(sum_at(parts.pieces.row, height, rows)) > OPEN).any():
        # Some touch was overlooked: let every piece speak for itself.
        weight = _weights(pieces, rows, width, parts, count_up(len(weight), weight))
    return parts.pieces, weight


def _weights(pieces: Pieces, rows: int, width: int, parts: Split, run: Any) -> Any:
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
    winding = _winding(pieces, rows, width, sides, there)
    plus, minus = winding[: len(piece)], winding[len(piece) :]
    turn = plus - minus
    inside = (plus != 0) * 1.0 - (minus != 0) * 1.0
    return take(inside / xp.where(turn != 0, turn, 1.0), run)


def _winding(pieces: Pieces, rows: int, width: int, points: Any, there: Any) -> Any:
    """The winding number (P,) at points (2, P), each in a row: what a ray to the left crosses.

    Within its pixel these are chords. Along the pixel's left border the winding number is, in the
    mean, the sum of all climbs to the left; it changes where pieces come in or go out.
    """
    xp = namespace(points)
    column, top = between(xp.floor(points[0]), -1.0, float(width)), xp.floor(points[1])
    cell = there * (width + 2) + integers(column) + 1
    # Only the pieces of those rows, cell by cell; a row above or below the images has none.
    asked = count_up(rows + 1, there) < 0
    asked[there] = True
    met = where_true(take(asked, pieces.row))
    cells = take(pieces.row, met) * (width + 2) + take(pieces.column, met) + 1
    order = cells.argsort()
    met, cells = take(met, order), take(cells, order)
    climb = take(pieces.last[1] - pieces.first[1], met)
    # Of a whole row it is nothing, for what goes down comes up.
    climbed = xp.concatenate([zeros(1, climb), climb.cumsum(0)])
    begin = xp.searchsorted(cells, cell)
    count = xp.searchsorted(cells, cell, side="right") - begin
    ray, here = expand(begin, count)
    met = take(met, here)
    x0, y0 = take(pieces.first, met)
    x1, y1 = take(pieces.last, met)
    x, y, border, bottom = take(stacked([*points, column, top + 1]), ray)
    above, below = y0 <= y, y1 <= y
    spans = above != below
    crossed = spans & (x0 + (y - y0) * (x1 - x0) / xp.where(spans, y1 - y0, 1.0) < x)
    # What is left of the image has no border.
    comes = (abs(x0 - border) < TOUCH) & (border >= 0)
    goes = (abs(x1 - border) < TOUCH) & (border >= 0)
    turns = xp.where(crossed, xp.sign(y1 - y0), 0.0)
    turns = turns + xp.where(goes, below * 1.0 - (bottom - y1), 0.0)
    turns = turns - xp.where(comes, above * 1.0 - (bottom - y0), 0.0)
    return xp.round(take(climbed, begin) + sum_at(ray, turns, len(there)))
