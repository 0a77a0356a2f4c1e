r"""How far letters can move along a straight way before they meet each other or an obstacle.

Between two states every corner of the flattened outlines moves along a straight line. A corner
crosses an edge where :math:`(b - a) × (p - a) = 0`, which is a quadratic equation in the time.
Between two such events nothing begins or ends to overlap. Therefore the common area is computed
once between any two events that follow each other, and no bar is passed unseen, however thin it
is and however long the step.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from ..arrays import Array, IntArray
from ..outline.cubics import bernstein
from ..text import Text
from .common_area import common_area, pairs_nearby
from .shape import Shape, letters

PASSING = 1.0
"""Square font units: two shapes that slide along each other may overlap by less on the way."""
CHORDS = 4
"""Straight edges that replace a curved segment where events are searched."""
STRAIGHT = 0.25
"""Font units: a step is divided until the ways of all points are straight to within this."""
MOST_PIECES = 16
DEEP = 0.01
"""Font units: a corner that stays nearer to an edge slides along it, and does not cross it."""
BISECTIONS = 20
"""Most halvings towards the time at which the common area of a pair is the largest allowed."""
MOST_EVENTS = 48
"""Of a pair in one piece of the way; if there are more, they are thinned out evenly."""


class Edges(NamedTuple):
    """Edges of flattened outlines: their starts and ends (2, E, 2) at two times."""

    start: Array
    end: Array


def free_part(
    text: Text,
    end: Mapping[str, Array],
    obstacles: Sequence[Shape] = (),
    between_glyphs: bool = True,
    allowed: float = PASSING,
) -> float:
    """The largest t in 0 … 1 for which the straight way to another place is free up to t.

    Parameters
    ----------
    text : Text
        Where the way begins. Letters that overlap there may overlap on the way, by no more than
        at the beginning.
    end : mapping of block name to array
        Where it ends, as :attr:`Text.place`.
    obstacles : sequence of Shape
    between_glyphs : bool
        Whether letters must not meet each other. Default True.
    allowed : float
        Common area of a pair that counts as none, in square font units.

    Returns
    -------
    float
        1.0 if the whole way is free. Otherwise the time of the contact, at which the common area
        is at most ``allowed``, and more than half of it if it grows slowly enough.
    """
    points, start, others = text.point_set(), text.place, list(obstacles)

    def at(t: float) -> list[Shape]:
        place = {name: start[name] + t * (end[name] - start[name]) for name in start}
        return letters(text, points.positions(place))

    first, middle, last = at(0.0), at(0.5), at(1.0)
    pieces = _pieces(first, middle, last)
    before = first
    for i in range(pieces):
        after = last if i + 1 == pieces else at((i + 1) / pieces)
        state = partial(_within, at, i, pieces)
        contact = _first_contact(before, after, others, between_glyphs, allowed, state)
        if contact is not None:
            return (i + contact) / pieces
        before = after
    return 1.0


def _within(at: Callable[[float], list[Shape]], piece: int, pieces: int, t: float) -> list[Shape]:
    """The letters at a time 0 … 1 of one piece of the way."""
    return at((piece + t) / pieces)


def _pieces(first: list[Shape], middle: list[Shape], last: list[Shape]) -> int:
    """The number of steps into which a way is divided, so that points move straight in each."""
    bent = [
        abs(m.segments - (a.segments + b.segments) / 2).max(initial=0.0)
        for a, m, b in zip(first, middle, last, strict=True)
    ]
    return min(MOST_PIECES, max(1, math.ceil(math.sqrt(max(bent, default=0.0) / STRAIGHT))))


def _first_contact(
    before: list[Shape],
    after: list[Shape],
    obstacles: list[Shape],
    between_glyphs: bool,
    allowed: float,
    state: Callable[[float], list[Shape]],
) -> float | None:
    """The time in 0 … 1 at which a pair meets, if any; ``state`` gives the letters at a time."""
    moved = [_hull(a, b) for a, b in zip(before, after, strict=True)]
    inner = pairs_nearby(moved) if between_glyphs else np.zeros((0, 2), dtype=np.intp)
    outer = pairs_nearby(moved, obstacles)
    outer[:, 1] += len(moved)
    near = np.concatenate([inner, outer])
    if not len(near):
        return None
    starts, ends = [*before, *obstacles], [*after, *obstacles]
    edges = {i: _edges(starts[i], ends[i]) for i in set(near.ravel().tolist())}
    limit = np.maximum(common_area([(starts[i], starts[j]) for i, j in near]).area, allowed)
    # Times with one between any two events; and the pairs to which they belong.
    looked: dict[float, list[Shape]] = {0.0: starts, 1.0: ends}
    cases = []
    for pair, (i, j) in enumerate(near):
        times = np.array([0.0, *_events(edges[i], edges[j]), 1.0])
        cases += [(t, pair) for t in [*(times[1:] + times[:-1]) / 2, 1.0]]

    def excess(cases: list[tuple[float, int]]) -> Array:
        for t, _ in cases:
            if t not in looked:
                looked[t] = [*state(t), *obstacles]
        both = [(looked[t][near[pair, 0]], looked[t][near[pair, 1]]) for t, pair in cases]
        return common_area(both).area - limit[[pair for _, pair in cases]]

    over = [case for case, value in zip(cases, excess(cases), strict=True) if value > 0]
    if not over:
        return None
    high, pair = min(over)
    low = max([t for t, other in cases if other == pair and t < high], default=0.0)
    for _ in range(BISECTIONS):
        t = (low + high) / 2
        value = excess([(t, pair)])[0]
        low, high = (low, t) if value > 0 else (t, high)
        if -limit[pair] / 2 < value <= 0:
            break
    return low


def _hull(one: Shape, other: Shape) -> Shape:
    """Both shapes together: their box contains the way from one to the other."""
    return Shape(np.concatenate([one.segments, other.segments]), [*one.sizes, *other.sizes])


def _edges(before: Shape, after: Shape) -> Edges:
    """The edges of a shape that moves, flattened at the same parameters at both times."""
    segments = np.stack([before.segments, after.segments])
    thirds = np.stack([(2 * s[:, :1] + s[:, 3:]) / 3 for s in segments])
    bent = abs(segments[:, :, 1:2] - thirds).max((0, 2, 3)) > STRAIGHT
    weights = np.stack([bernstein(t) for t in np.arange(CHORDS + 1) / CHORDS])
    curved = np.einsum("cj,tsjd->tscd", weights, segments[:, bent])
    straight = segments[:, ~bent][:, :, [0, 3]]
    return Edges(
        np.concatenate([straight[:, :, 0], curved[:, :, :-1].reshape(2, -1, 2)], 1),
        np.concatenate([straight[:, :, 1], curved[:, :, 1:].reshape(2, -1, 2)], 1),
    )


def _events(one: Edges, other: Edges) -> Array:
    """The times in 0 … 1, ascending, at which a corner of either crosses an edge of the other."""
    times = np.sort(np.concatenate([_crossings(one.start, other), _crossings(other.start, one)]))
    if len(times):
        times = times[np.append(True, np.diff(times) > 1e-6)]
    if len(times) > MOST_EVENTS:
        times = times[np.linspace(0, len(times) - 1, MOST_EVENTS).astype(np.intp)]
    return times


def _crossings(corners: Array, edges: Edges) -> Array:
    """The times at which moving corners (2, V, 2) cross moving edges."""
    corner, edge = _meeting(corners, edges)
    point, start, end = corners[:, corner], edges.start[:, edge], edges.end[:, edge]
    side, away = end - start, point - start
    turn, way = side[1] - side[0], away[1] - away[0]
    constant, slope, bend = (
        _cross(side[0], away[0]),
        _cross(turn, away[0]) + _cross(side[0], way),
        _cross(turn, way),
    )
    length = np.hypot(*side[0].T), np.hypot(*side[1].T)
    apart = np.maximum(abs(constant), abs(constant + slope + bend))
    with np.errstate(all="ignore"):
        root = np.sqrt(slope * slope - 4 * bend * constant)
        q = -(slope + np.where(slope < 0, -root, root)) / 2
        t = np.stack([q / bend, constant / q])
        along = (side[0] + t[..., None] * turn), (away[0] + t[..., None] * way)
        part = (along[0] * along[1]).sum(-1) / (along[0] ** 2).sum(-1)
    crossed = (t >= 0) & (t <= 1) & (part >= -1e-9) & (part <= 1 + 1e-9)
    crossed &= apart > DEEP * np.maximum(*length)
    return t[crossed]


def _meeting(corners: Array, edges: Edges) -> tuple[IntArray, IntArray]:
    """Corners and edges whose boxes over both times overlap."""
    if not (corners.size and edges.start.size):
        return np.zeros(0, dtype=np.intp), np.zeros(0, dtype=np.intp)
    low, high = corners.min(0), corners.max(0)
    both = np.concatenate([edges.start, edges.end])
    bottom, top = both.min(0), both.max(0)
    # Most corners and edges are far from the other shape altogether.
    corner = np.flatnonzero(((low <= top.max(0)) & (high >= bottom.min(0))).all(1))
    edge = np.flatnonzero(((bottom <= high.max(0)) & (top >= low.min(0))).all(1))
    near = (low[corner, None] <= top[edge]).all(-1) & (high[corner, None] >= bottom[edge]).all(-1)
    i, j = np.nonzero(near)
    return corner[i], edge[j]


def _cross(one: Array, other: Array) -> Array:
    return one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0]
