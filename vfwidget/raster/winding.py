r"""Nonzero fill: which pieces of the contours bound the filled shape.

A piece has a winding number on either side of it, w₋ and w₊, and *inside* is where that is not
zero. Its weight is by how much inside changes across it for each turn the winding changes,

    weight = ([w₊ ≠ 0] − [w₋ ≠ 0]) / (w₊ − w₋),

1 or −1 on the boundary of the shape, 0 within it, ½ on each of two edges that coincide. Along a
contour the winding can only change where another contour crosses or touches it, so the pieces
from one such place to the next, a *run*, have one weight, found at one of them by counting what
a ray to the left crosses.

A contour can only be crossed in a pixel that both pass through. There the chords of the pieces
cross as often, modulo two, as the arcs do, for both end on the pixel's border; so the chords
decide where runs begin, and the arcs where exactly.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..arrays import count_up, integers, like, namespace, repeat, sorting, sum_at, take, where_true
from .cuts import SLOPE, Pieces, evaluate, evaluate_slope

BESIDE = 1e-6
"""In pixels, how far from a piece its sides are looked at."""
TOUCH = 1e-9
"""In pixels, how near counts as touching."""
ROUNDS = 6
"""Of Newton's method, from where chords cross to where arcs do."""
CROSSED = 1e-10
"""In pixels, how near to each other arcs that cross have come then."""
OPEN = 1e-7
"""In pixels, how far from closed the boundary may be along a row."""


class Meetings(NamedTuple):
    """Where chords meet that do not follow one another: M pairs of pieces.

    Attributes
    ----------
    pair : (2, M) int array
    where : (2, M) array
        How far along each chord, 0 … 1.
    at_first, at_last : (2, M) bool arrays
        Whether that is at an end of it; parallel pieces that coincide may part at either.
    """

    pair: Any
    where: Any
    at_first: Any
    at_last: Any


class Split(NamedTuple):
    """Pieces cut in two, or more, where others cross or touch them.

    Attributes
    ----------
    pieces : Pieces
    whole : (N,) int array
        Which of the uncut pieces each was, or was a part of.
    middle : (N,) array
        How far along that one's chord its own middle is.
    breaks : (N,) bool array
        Whether a run begins with it.
    """

    pieces: Pieces
    whole: Any
    middle: Any
    breaks: Any


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
    order = sorting(pieces.cell)
    cell = take(pieces.cell, order)
    rays = _Rays(pieces, order, cell // (width + 2), width + 2)
    split = _split(curves, pieces, _meetings(pieces, *_neighbours(pieces, cell, order)))
    weight = rays.weights(split, split.breaks.cumsum(0) - 1)
    height = (split.pieces.last - split.pieces.first)[:, 1] * weight
    if (abs(sum_at(split.pieces.cell // (width + 2), height, rows)) > OPEN).any():
        # Some touch was overlooked: let every piece speak for itself.
        weight = rays.weights(split, count_up(len(weight), weight))
    return split.pieces, weight


class _Rays(NamedTuple):
    """Counts what rays to the left cross: chords of pieces, in the order of their rows."""

    pieces: Pieces
    order: Any
    row: Any
    columns: int

    def weights(self, split: Split, run: Any) -> Any:
        """The weight of each piece (N,), taken at the steepest piece of its run (N,)."""
        own, xp = self.pieces, namespace(run)
        steepness = take(abs((own.last - own.first)[:, 1]), split.whole)
        # Within a row a piece climbs no more than 1, so the steepest is the last of its run.
        order = sorting(run + 0.99 * steepness)
        ends = xp.ones_like(order, dtype=xp.bool)
        ends[:-1] = run[1:] != run[:-1]
        chosen = take(order, where_true(ends))

        piece = take(split.whole, chosen)
        first = take(own.first, piece)
        chord = take(own.last, piece) - first
        place = first + take(split.middle, chosen)[:, None] * chord
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
        ray, met = _expand(begin, end)
        met = take(self.order, met)
        x, y = take(points, ray).T
        x0, y0 = take(self.pieces.first, met).T
        x1, y1 = take(self.pieces.last, met).T
        spans = (y0 <= y) != (y1 <= y)
        crossed = spans & (x0 + (y - y0) * (x1 - x0) / xp.where(spans, y1 - y0, 1.0) < x)
        return sum_at(ray, xp.where(crossed, xp.sign(y1 - y0), 0.0), len(points))


def _expand(begin: Any, end: Any) -> tuple[Any, Any]:
    """All (i, j) with begin[i] ≤ j < end[i]."""
    count = end - begin
    i = repeat(count)
    return i, count_up(len(i), count) - take(count.cumsum(0) - count - begin, i)


def _neighbours(pieces: Pieces, cell: Any, order: Any) -> tuple[Any, Any]:
    """Pairs of pieces that share a cell, but not the same passage through it."""
    xp = namespace(cell)
    enters = pieces.fresh.copy() if xp is np else pieces.fresh.clone()
    enters[1:] |= pieces.cell[1:] != pieces.cell[:-1]
    passage = take(enters.cumsum(0), order)
    new = xp.ones_like(cell, dtype=xp.bool)
    new[1:] = cell[1:] != cell[:-1]
    begin = where_true(new)
    end = xp.roll(begin, -1)
    end[-1] = len(cell)
    # A cell's first and last passage differ if there are several.
    busy = where_true(take(passage, begin) != take(passage, end - 1))
    end = take(end, busy)
    group, here = _expand(take(begin, busy), end)
    first, second = _expand(here + 1, take(end, group))
    first = take(here, first)
    other = where_true(take(passage, first) != take(passage, second))
    return take(order, take(first, other)), take(order, take(second, other))


def _meetings(pieces: Pieces, a: Any, b: Any) -> Meetings:
    """Which of these pairs meet."""
    xp = namespace(pieces.first)
    p, q = take(pieces.first, a), take(pieces.first, b)
    r, s = take(pieces.last, a) - p, take(pieces.last, b) - q
    length, other = xp.hypot(r[:, 0], r[:, 1]), xp.hypot(s[:, 0], s[:, 1])
    across, beside = _cross(r, s), _cross(q - p, r)
    parallel = abs(across) <= TOUCH * length * other
    where = xp.stack([_cross(q - p, s), beside]) / xp.where(parallel, 1.0, across)
    slack = TOUCH / xp.clip(xp.stack([length, other]), TOUCH, None)
    meet = ((where >= -slack) & (where <= 1 + slack)).all(0) & ~parallel
    meet = meet | (parallel & (abs(beside) <= TOUCH * xp.clip(length, TOUCH, None)))
    meet = where_true(meet)
    where, slack, parallel = where[:, meet], slack[:, meet], parallel[meet]
    pair = xp.stack([a[meet], b[meet]])
    return Meetings(pair, where, (where <= slack) | parallel, (where >= 1 - slack) | parallel)


def _cross(a: Any, b: Any) -> Any:
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


def _split(curves: Any, pieces: Pieces, meetings: Meetings) -> Split:
    xp = namespace(curves)
    count = len(pieces.cell)
    whole = count_up(count, pieces.cell)
    # One more than there are pieces, for what ends with the last.
    breaks = xp.concatenate([pieces.fresh, pieces.fresh[:1]])
    breaks[meetings.pair[meetings.at_first]] = True
    breaks[meetings.pair[meetings.at_last] + 1] = True
    breaks = breaks[:-1]
    through = ~(meetings.at_first | meetings.at_last)
    cut, where = meetings.pair[through], meetings.where[through]
    if not len(cut):
        return Split(pieces, whole, xp.zeros_like(pieces.start) + 0.5, breaks)
    t = _refine(curves, pieces, meetings)[through]
    order = sorting(cut + where)
    cut, where, t = take(cut, order), take(where, order), take(t, order)
    place = evaluate(take(curves, take(pieces.cubic, cut)), t[:, None])
    whole = repeat(integers(1 + sum_at(cut, xp.ones_like(where), count)))
    here = cut + count_up(len(cut), cut) + 1

    def parted(begin: Any, end: Any, at: Any) -> tuple[Any, Any]:
        begin, end = take(begin, whole), take(end, whole)
        begin[here], end[here - 1] = at, at
        return begin, end

    start, end = parted(pieces.start, pieces.end, t)
    first, last = parted(pieces.first, pieces.last, place)
    begin, finish = parted(xp.zeros_like(pieces.start), xp.ones_like(pieces.start), where)
    breaks = take(breaks, whole)
    breaks[here] = True
    cubic, cell = take(pieces.cubic, whole), take(pieces.cell, whole)
    parts = Pieces(cubic, start, end, first, last, cell, breaks)
    return Split(parts, whole, (begin + finish) / 2, breaks)


def _refine(curves: Any, pieces: Pieces, meetings: Meetings) -> Any:
    """Parameters (2, M) at which arcs meet, from where their chords do."""
    xp = namespace(curves)
    low, high = pieces.start[meetings.pair], pieces.end[meetings.pair]
    one, other = (take(curves, take(pieces.cubic, piece)) for piece in meetings.pair)
    slopes = [own[:, 1:] * like(SLOPE, curves) for own in (one, other)]
    t = low + meetings.where * (high - low)
    for _ in range(ROUNDS):
        gap = evaluate(other, t[1, :, None]) - evaluate(one, t[0, :, None])
        if (abs(gap) < CROSSED).all():
            break
        along, across = (evaluate_slope(s, u[:, None]) for s, u in zip(slopes, t, strict=True))
        step = xp.stack([_cross(gap, across), _cross(gap, along)]) / _cross(along, across)
        t = xp.clip(t + xp.nan_to_num(step, posinf=0.0, neginf=0.0), low, high)
    return t
