r"""How far shapes can move along a straight way before they meet.

Between two states every corner of the flattened outlines moves along a straight line. A corner
crosses an edge where :math:`(b - a) × (p - a) = 0`, which is a quadratic equation in the time.
Between two such events nothing begins or ends to overlap. Therefore the exact common area is
computed soon after each event and midway to the next one, and no bar is passed unseen, however thin
it is and however long the step. Shapes without an event are not looked at.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from ..arrays import Array, IntArray, begins, expand
from ..outline.contours import Contours
from ..outline.cubics import bernstein
from ..outline.near import near_pairs
from .common_area import common_area, pairs_nearby
from .overlaps import TOUCH
from .shape import Shape

SAG = 0.05
"""Font units: a curve is at most so far away from the edges that replace it."""
MOST_CHORDS = 32
"""Edges that replace one segment, at most."""
STRAIGHT = 0.25
"""Font units: a way is divided until the ways of all points are straight to within this."""
MOST_PIECES = 16
DEEP = 0.01
"""Font units: a corner that stays nearer to an edge slides along it, and does not cross it."""
BEYOND = 0.3
"""Font units by which points move on after an event until the common area is computed."""
MARGIN = 0.3
"""Font units that a corner stays away from an edge, because edges replace curves; but it comes at
least half of the way."""
LEAST = 1e-9
"""Font units: keeps a quotient finite."""
SAME = 1e-6
"""Events of a pair that follow each other within this part of the way are one."""
MOST_EVENTS = 48
"""Of a pair in one piece of the way; if there are more, they are thinned out evenly."""
WAVE = 4
"""Common areas that are computed together at first. Their number doubles until one is too large."""


class Contact(NamedTuple):
    """Where a way is blocked.

    Attributes
    ----------
    free : float
        The way is free up to this part of it; 1 if all of it is free.
    beyond : float
        At this part something overlaps, a little farther on; 1 if the way is free.
    """

    free: float
    beyond: float


CLEAR_WAY = Contact(1.0, 1.0)


def first_contact(
    at: Callable[[float], Array],
    letters: Sequence[Contours],
    obstacles: Sequence[Shape] = (),
    between_glyphs: bool = True,
) -> Contact:
    """Where a way of letters is first blocked.

    Parameters
    ----------
    at : callable
        From a time 0 … 1 to the segments (S, 4, 2) of all letters. Letters that overlap at time 0
        may overlap on the way, by no more than then.
    letters : sequence of Contours
        The contours of each letter.
    obstacles : sequence of Shape
    between_glyphs : bool
        Whether letters must not meet each other. Default True.

    Notes
    -----
    Every overlap that begins on the way is found. One that exists at the beginning, and becomes
    larger at the end without an event in between, is not.
    """
    still = [np.zeros((0, 4, 2)), *(shape.segments for shape in obstacles)]
    sizes = [*letters, *(shape.sizes for shape in obstacles)]
    before, middle, last = at(0.0), at(0.5), at(1.0)
    pieces = _pieces(before, middle, last)
    for i in range(pieces):
        after = last if i + 1 == pieces else at((i + 1) / pieces)
        both = np.stack([np.concatenate([part, *still]) for part in (before, after)])
        contact = Motion(both, sizes).first_contact(len(letters), between_glyphs)
        if contact.free < 1:
            return Contact((i + contact.free) / pieces, (i + contact.beyond) / pieces)
        before = after
    return CLEAR_WAY


def _pieces(first: Array, middle: Array, last: Array) -> int:
    """The number of steps into which a way is divided, so that points move straight in each."""
    bent = float(abs(middle - (first + last) / 2).max(initial=0.0))
    return min(MOST_PIECES, max(1, math.ceil(math.sqrt(bent / STRAIGHT))))


class Edges(NamedTuple):
    """Straight edges that move, each for one pair of shapes.

    Attributes
    ----------
    start, end : (2, E, 2) arrays
        Their corners at both times.
    pair : (E,) int array
    side : (E,) int array
        0 if an edge belongs to the first shape of its pair, 1 if to the second.
    """

    start: Array
    end: Array
    pair: IntArray
    side: IntArray


class Events(NamedTuple):
    """Times at which a corner of one shape crosses an edge of another, pair after pair, ascending.

    Attributes
    ----------
    pair : (m,) int array
    time : (m,) array
    free : (m,) array
        A time shortly before, at which the shapes are apart if they meet then.
    """

    pair: IntArray
    time: Array
    free: Array


class Motion:
    """Shapes that move, each control point along a straight line, from time 0 to 1.

    Parameters
    ----------
    segments : (2, S, 4, 2) array
        Control points at both times: those of letters first, then those of obstacles.
    sizes : sequence of Contours
        The contours of each shape.
    """

    def __init__(self, segments: Array, sizes: Sequence[Contours]) -> None:
        self.segments, self.sizes = segments, sizes
        self.counts = np.array([sum(contours) for contours in sizes], dtype=np.intp)
        self.first = np.cumsum(self.counts) - self.counts
        self.low, self.high = segments.min((0, 2)), segments.max((0, 2))
        self.longest = float(np.hypot(*(segments[1] - segments[0]).T).max(initial=0.0))
        """The longest way of a control point, in font units."""

    def at(self, i: int, t: float) -> Shape:
        """A shape at a time."""
        before, after = self.segments[:, self.first[i] : self.first[i] + self.counts[i]]
        return Shape((1 - t) * before + t * after, self.sizes[i])

    def boxes(self) -> Array:
        """A box around the way of each shape, (n, 2, 2)."""
        boxes = np.full((len(self.counts), 2, 2), [[[np.inf], [-np.inf]]])
        filled = np.flatnonzero(self.counts)
        if len(filled):
            boxes[filled, 0] = np.minimum.reduceat(self.low, self.first[filled])
            boxes[filled, 1] = np.maximum.reduceat(self.high, self.first[filled])
        return boxes

    def first_contact(self, letters: int, between_glyphs: bool) -> Contact:
        """Where a letter first meets another letter or an obstacle, among ``letters`` letters."""
        boxes = self.boxes()
        pairs = pairs_nearby(boxes, letters, between_glyphs)
        events = self.events(pairs, boxes)
        return self._first_overlap(pairs, events) if len(events.pair) else CLEAR_WAY

    def events(self, pairs: IntArray, boxes: Array) -> Events:
        """When pairs (P, 2) may begin or end to overlap."""
        edges = self.edges(pairs, boxes)
        if not len(edges.pair):
            return Events(edges.pair, np.zeros(0), np.zeros(0))
        both = np.concatenate([edges.start, edges.end])
        low, high = both.min(0).T - SAME, both.max(0).T + SAME
        (one, other), _, _ = near_pairs(low, high, edges.pair)
        apart = edges.side[one] != edges.side[other]
        one, other = one[apart], other[apart]
        # Every corner is the start of one edge.
        corner, edge = np.concatenate([one, other]), np.concatenate([other, one])
        found, time, speed = crossings(
            edges.start[:, corner], edges.start[:, edge], edges.end[:, edge]
        )
        pair = edges.pair[edge[found]]
        order = np.lexsort((time, pair))
        pair, time, speed = pair[order], time[order], speed[order]
        fresh = begins(pair)
        fresh[1:] |= np.diff(time) > SAME
        margin = np.minimum(MARGIN / np.maximum(speed, LEAST), time / 2)
        return Events(pair[fresh], time[fresh], (time - margin)[fresh])

    def edges(self, pairs: IntArray, boxes: Array) -> Edges:
        """The edges of each of the pairs (P, 2) that come near the other shape."""
        low = np.maximum(boxes[pairs[:, 0], 0], boxes[pairs[:, 1], 0])
        high = np.minimum(boxes[pairs[:, 0], 1], boxes[pairs[:, 1], 1])
        shape = pairs.ravel()
        place, segment = expand(self.first[shape], self.counts[shape])
        pair = place // 2
        near = (self.low[segment] <= high[pair]) & (self.high[segment] >= low[pair])
        kept = np.flatnonzero(near.all(1))
        place, points = place[kept], self.segments[:, segment[kept]]
        # A cubic is at most an eighth of its largest second derivative away from its chord.
        bend = np.hypot(*np.moveaxis(np.diff(points, 2, axis=2), -1, 0)).max((0, 2), initial=0.0)
        chords = np.ceil(np.sqrt(0.75 * bend / SAG)).astype(np.intp).clip(1, MOST_CHORDS)
        which, k = expand(np.zeros_like(chords), chords)
        points, place = points[:, which], place[which]
        start, end = (
            np.einsum("je,tejd->ted", bernstein((k + step) / chords[which]), points)
            for step in (0, 1)
        )
        return Edges(start, end, place // 2, place % 2)

    def _first_overlap(self, pairs: IntArray, events: Events) -> Contact:
        """The first of the times after events at which a pair overlaps more than at 0."""
        looks = _looks(events, BEYOND / self.longest)
        known, place = np.unique(looks.pair, return_inverse=True)
        limit, begun, wave = np.zeros(len(known)), 0, WAVE
        while begun < len(looks.time):
            some = slice(begun, begun + wave)
            cases = list(zip(looks.pair[some].tolist(), looks.time[some].tolist(), strict=True))
            if not begun:
                cases = [(p, 0.0) for p in known.tolist()] + cases
            areas = common_area(
                [(self.at(pairs[p, 0], t), self.at(pairs[p, 1], t)) for p, t in cases]
            ).area
            if not begun:
                limit, areas = np.maximum(areas[: len(known)], 0.0) + TOUCH, areas[len(known) :]
            over = np.flatnonzero(areas > limit[place[some]])
            if len(over):
                first = begun + int(over[0])
                return Contact(float(looks.free[first]), float(looks.time[first]))
            begun, wave = begun + wave, 2 * wave
        return CLEAR_WAY


class Looks(NamedTuple):
    """Times at which common areas are computed, ascending.

    Attributes
    ----------
    time : (c,) array
    free : (c,) array
        The time up to which the way is free if it is blocked at this one.
    pair : (c,) int array
    """

    time: Array
    free: Array
    pair: IntArray


def _looks(events: Events, soon: float) -> Looks:
    """Times soon after the beginning and after each event, and midway to the next event."""
    fresh = np.flatnonzero(begins(events.pair))
    counts = np.diff(np.append(fresh, len(events.pair)))
    pairs, begun, free, ends = [], [], [], []
    for first, count in zip(fresh.tolist(), counts.tolist(), strict=True):
        own = slice(first, first + count)
        kept = np.arange(count + 1)
        if count > MOST_EVENTS:
            kept = np.linspace(0, count, MOST_EVENTS).astype(np.intp)
        pairs.append(np.full(len(kept), events.pair[first]))
        begun.append(np.concatenate([[0.0], events.time[own]])[kept])
        free.append(np.concatenate([[0.0], events.free[own]])[kept])
        ends.append(np.concatenate([events.time[own], [1.0]])[kept])
    begin, end = np.concatenate(begun), np.concatenate(ends)
    middle = np.where(end == 1.0, 1.0, (begin + end) / 2)
    time = np.concatenate([np.minimum(begin + soon, middle), middle])
    order = np.argsort(time, kind="stable")
    both = (np.tile(np.concatenate(values), 2)[order] for values in (free, pairs))
    return Looks(time[order], *both)


def crossings(corners: Array, starts: Array, ends: Array) -> tuple[IntArray, Array, Array]:
    """Which corners (2, M, 2) cross edges between ``starts`` and ``ends``, when, and how fast.

    All of them move along straight lines from time 0 to 1. An edge may be crossed twice. The speed
    is that across the edge, in font units.
    """
    side, away = ends - starts, corners - starts
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
    root, at = np.nonzero(crossed)
    time = t[root, at]
    across = abs(slope[at] + 2 * bend[at] * time)
    return at, time, across / np.hypot(*(side[0][at] + time[:, None] * turn[at]).T)


def _cross(one: Array, other: Array) -> Array:
    return one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0]
