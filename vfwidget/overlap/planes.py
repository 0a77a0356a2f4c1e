r"""Contact planes: points of one shape that must stay on the outer side of a line (Sec. 5.2).

Each sampled point p that lies in another shape has a nearest point b on that shape, where N is the
outward normal. The residual is the paper's :math:`\max(0, N^T(b - p))`, with the gap added. Points
outside that are nearer to a shape than the gap have planes too. These points come from
:mod:`.gaps`, because samples would miss the nearest ones. Both p and b move with their letters.
N and the pairs (p, b) are kept until the planes are found again.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arrays import Array, BoolArray, IntArray
from ..outline.arrangement import Spans
from ..outline.contours import Contours
from ..outline.cubics import bernstein
from .collisions import Collisions
from .contacts import nearest, sampled
from .gaps import SAG, Gaps, Outlines
from .shape import Shape

REACH = 2 * SAG
"""Font units: samples of outlines that are farther apart than a gap by this much may lie next
to points that are nearer."""
ROUNDING = 1e-9
"""Of a parameter: a point that is so near to the end of a part lies on it."""


class Carried(NamedTuple):
    """Q points that move with control points, or are fixed.

    Attributes
    ----------
    points : (Q, 4) int array
        The control points of the segment on which each point lies.
    weights : (Q, 4) array
        Their weights; zero for a point that is fixed.
    fixed : (Q, 2) array
        The position of a point that is fixed, else zero.
    """

    points: IntArray
    weights: Array
    fixed: Array

    def positions(self, points: Array) -> Array:
        """The positions (Q, 2) for control points (K, 2)."""
        return (self.weights[..., None] * points[self.points]).sum(1) + self.fixed


class Planes(NamedTuple):
    """Q planes with normals (Q, 2) at ``bases``, of which ``points`` stay on the outer side."""

    points: Carried
    bases: Carried
    normals: Array
    gap: float

    def residual(self, points: Array) -> Array:
        """How far each point is beyond its plane, (Q,), in font units; 0 on the outer side."""
        away = self.points.positions(points) - self.bases.positions(points)
        return np.maximum(self.gap - (away * self.normals).sum(1), 0.0)

    def derivative(self, points: Array) -> Array:
        """The derivative of :meth:`residual` by the control points, (Q, K, 2)."""
        by = np.zeros((len(self.normals), *points.shape))
        beyond = self.residual(points) > 0
        row = np.arange(len(by))[:, None]
        for carried, sign in ((self.points, -1.0), (self.bases, 1.0)):
            weights = sign * beyond[:, None] * carried.weights
            np.add.at(by, (row, carried.points), weights[..., None] * self.normals[:, None])
        return by


def find_planes(
    letters: list[Shape], obstacles: list[Shape], nearby: Collisions, contours: Contours, gap: float
) -> Planes:
    """The planes of all contacts of letters with each other and with obstacles.

    Parameters
    ----------
    letters, obstacles : list of Shape
    nearby : Collisions
        The pairs to look at.
    contours : Contours
        Those of all letters.
    gap : float
        Points outside the other shape count if they are nearer than this, in font units.
    """
    shapes = letters + obstacles
    counts = [sum(shape.sizes) for shape in shapes]
    starts, own = np.cumsum([0, *counts]), sum(counts[: len(letters)])
    segments = np.concatenate([np.zeros((0, 4, 2)), *(shape.segments for shape in shapes)])
    pairs = nearby.pairs + nearby.obstacle[:, None] * np.array([0, len(letters)])
    unions = {i: shapes[i].union() for i in set(pairs.ravel().tolist())}
    ends = _inside(shapes, pairs, unions, nearby, starts)
    if gap and len(pairs):
        beside = Outlines(shapes, len(letters)).gaps(segments, gap + REACH)
        beside = beside.some((beside.gap < gap) & _between(beside, pairs, unions, starts))
        ends.append(_Ends(beside.segment, beside.t, beside.normal))
    segment, t, normal = (np.concatenate(values) for values in zip(*ends, strict=True))

    def carried(segment: IntArray, t: Array) -> Carried:
        weights, moves = bernstein(t).T, segment < own
        index = contours.segments[np.where(moves, segment, 0)]
        places = (weights[:, None] @ segments[segment])[:, 0]
        moves = moves[:, None]
        return Carried(index, np.where(moves, weights, 0.0), np.where(moves, 0.0, places))

    return Planes(carried(segment[:, 0], t[:, 0]), carried(segment[:, 1], t[:, 1]), normal, gap)


class _Ends(NamedTuple):
    """Q points p and b: segments (Q, 2) among all segments, parameters (Q, 2), and N (Q, 2)."""

    segment: IntArray
    t: Array
    normal: Array


def _inside(
    shapes: list[Shape],
    pairs: IntArray,
    unions: dict[int, Spans],
    nearby: Collisions,
    starts: IntArray,
) -> list[_Ends]:
    """The sampled points of each shape that lie in another one."""
    found = [_Ends(np.zeros((0, 2), dtype=np.intp), np.zeros((0, 2)), np.zeros((0, 2)))]
    for p, pair in enumerate(pairs.tolist()):
        for layer, (a, b) in enumerate((pair, pair[::-1])):
            point = sampled(shapes[a], unions[a])
            point = point.some(_on(nearby.common.spans_of(p, layer), point.segment, point.t))
            if len(point.t):
                base = nearest(point.position, shapes[b], unions[b])
                way = base.position - point.position
                length = np.hypot(*way.T)[:, None]
                normal = np.where(length > 0, way / np.where(length > 0, length, 1), base.outward)
                segment = np.stack([starts[a] + point.segment, starts[b] + base.segment], 1)
                found.append(_Ends(segment, np.stack([point.t, base.t], 1), normal))
    return found


def _between(gaps: Gaps, pairs: IntArray, unions: dict[int, Spans], starts: IntArray) -> BoolArray:
    """Which gaps are between the boundaries of two shapes of a pair, and not inside one."""
    asked = np.zeros((len(starts), len(starts)), dtype=bool)
    asked[pairs, pairs[:, ::-1]] = True
    kept = asked[gaps.shape[:, 0], gaps.shape[:, 1]]
    for i, union in unions.items():
        for end in (0, 1):
            at = np.flatnonzero(kept & (gaps.shape[:, end] == i))
            kept[at] = _on(union, gaps.segment[at, end] - starts[i], gaps.t[at, end])
    return kept


def _on(spans: Spans, segment: IntArray, t: Array) -> BoolArray:
    """Which points of a shape lie on the spans that have a weight, and so bound an area."""
    bound = np.flatnonzero(spans.weight)
    low, high = spans.start[bound] - ROUNDING, spans.end[bound] + ROUNDING
    t = t[:, None]
    on = (segment[:, None] == spans.cubic[bound]) & (low <= t) & (t <= high)
    return np.asarray(on.any(1))
