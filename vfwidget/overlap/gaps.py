"""Gaps: where the outlines of two shapes are nearest to each other.

A gap is the distance of a point of one outline from another shape, and negative inside the shape.
Gaps are measured at the corners and at samples of curves, and at the nearest points of curves. The
projection onto the other outline is exact: it starts from the nearest chord and ends by Newton's
method. At a corner, the sum of the two normals decides between inside and outside (Bærentzen and
Aanæs 2005).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array, BoolArray, IntArray
from ..outline.cubics import bernstein
from ..outline.monotone import coefficients, evaluate, evaluate_slope
from ..text.memo import Memo
from .contacts import LEAST, nearest_chord, step_toward, straight
from .shape import Shape

CHORDS = 8
"""Samples of a curve, and chords that replace it in the search for the nearest point."""
NEWTON = 3
"""Newton steps for a projection; twice as many for the nearest points of two curves."""
SETTLED = 1e-3
"""Newton's method ends when all parameters change by less than this.

It converges quadratically, so the remaining error is about 1e-6. Where it takes the step of a
straight line instead, it converges linearly.
"""
SAG = 4.0
"""A curve is at most so many font units away from its chords."""
_GRID = bernstein(np.linspace(0, 1, CHORDS + 1)).T


class Gaps(NamedTuple):
    """C points of outlines, each with the nearest point on another outline.

    Attributes
    ----------
    shape : (C, 2) int array
        The shape of the point, and that of the nearest point.
    segment : (C, 2) int array
        The segments on which both lie, among all segments.
    t : (C, 2) array
        Their parameters.
    normal : (C, 2) array
        Unit normal of the second shape, outwards.
    gap : (C,) array
        In font units; negative if the point lies inside the second shape.
    """

    shape: IntArray
    segment: IntArray
    t: Array
    normal: Array
    gap: Array

    def some(self, which: Any) -> Gaps:
        """Those that an index or mask names."""
        return Gaps(*(values[which] for values in self))

    def ends(self, segments: Array) -> tuple[Array, Array]:
        """Both points of every gap, two (C, 2) arrays, on segments (S, 4, 2) of an outline."""
        weights = np.moveaxis(bernstein(self.t), 0, -1)
        points = (weights[:, :, None] @ segments[self.segment])[:, :, 0]
        return points[:, 0], points[:, 1]


class Outlines:
    """Closed outlines of several shapes whose points may move.

    Parameters
    ----------
    shapes : sequence of Shape
        Letters first, then obstacles.
    letters : int
        How many of them are letters. Two obstacles have no gap.

    Attributes
    ----------
    owner : (S,) int array
        The shape of each segment.
    """

    def __init__(self, shapes: Sequence[Shape], letters: int) -> None:
        self.letters = letters
        counts = [sum(shape.sizes) for shape in shapes]
        self.owner = np.repeat(np.arange(len(shapes)), counts)
        # A space has no segments.
        self._filled = np.flatnonzero(counts)
        self._starts = np.cumsum([0, *counts])[self._filled]
        self._chords: Memo[_Chords] = Memo(4)
        sizes = np.array([size for shape in shapes for size in shape.sizes], dtype=np.intp)
        ends = np.cumsum(sizes)
        self._after, self._before = (np.arange(len(self.owner)) + step for step in (1, -1))
        self._after[ends - 1], self._before[ends - sizes] = ends - sizes, ends - 1
        contour = np.repeat(np.arange(len(sizes)), sizes)
        self._sign = _sides(shapes, contour)

    def gaps(self, segments: Array, reach: float) -> Gaps:
        """All gaps that are smaller than ``reach``, in font units.

        Parameters
        ----------
        segments : (S, 4, 2) array
            Control points of all shapes. Inside a shape, points up to ``reach`` deep are found.
        """
        low, high = segments.min(1), segments.max(1)
        bottom, top = self._boxes(low, high)
        pairs = self._near(bottom, top, reach)
        if not len(pairs):
            return _NONE
        bent = ~straight(segments)
        chords = self._chords.get(bent.tobytes(), lambda: _Chords(bent, self._starts))
        start, along = chords.at(segments)
        found, others = [], {}
        for i, j in pairs.tolist():
            box = np.maximum(bottom[i], bottom[j]) - reach, np.minimum(top[i], top[j]) + reach
            within = ((start >= box[0]) & (start <= box[1])).all(1)
            reached = ((low <= box[1]) & (high >= box[0])).all(1)[chords.index]
            for a, b in ((i, j), (j, i)):
                own, other = chords.some(within, a), chords.some(reached, b)
                if len(own) and len(other):
                    best, part, distance = nearest_chord(start[own], start[other], along[other])
                    kept = distance < reach + SAG
                    found.append((own[kept], *chords.point(other[best[kept]], part[kept])))
                    others[self._filled[a], self._filled[b]] = other
        if not found:
            return _NONE
        own, index, s = (np.concatenate(values) for values in zip(*found, strict=True))
        curves = coefficients(segments)
        samples = self._project(curves, chords.index[own], chords.first[own], index, s)
        samples = samples.some(abs(samples.gap) < reach)
        segment, t, index, s = self._nearest(curves, samples, bent)
        if not len(segment):
            return samples
        # On the way another part of the outline may have become the nearest one.
        position = evaluate(curves[..., segment], t).T
        shape = self.owner[np.stack([segment, index], 1)]
        for pair, other in others.items():
            rows = np.flatnonzero((shape == pair).all(1))
            if len(rows):
                best, part, _ = nearest_chord(position[rows], start[other], along[other])
                index[rows], s[rows] = chords.point(other[best], part)
        nearest = self._project(curves, segment, t, index, s)
        nearest = nearest.some(abs(nearest.gap) < reach)
        return Gaps(*(np.concatenate(both) for both in zip(samples, nearest, strict=True)))

    def boxes_overlap(self, segments: Array, depth: float) -> bool:
        """Whether the boxes of two shapes overlap by more than ``depth`` in both directions."""
        boxes = self._boxes(segments.min(1), segments.max(1))
        return bool(len(self._near(*boxes, -depth)))

    def _boxes(self, low: Array, high: Array) -> tuple[Array, Array]:
        """The lower and upper corners of the shapes from those of the segments."""
        return np.minimum.reduceat(low, self._starts), np.maximum.reduceat(high, self._starts)

    def _near(self, bottom: Array, top: Array, reach: float) -> IntArray:
        """The pairs of shapes whose boxes are less than ``reach`` apart."""
        near = ((bottom[:, None] - reach < top) & (bottom - reach < top[:, None])).all(-1)
        letters = int(np.searchsorted(self._filled, self.letters))
        return np.argwhere(np.triu(near, 1)[:letters])

    def _project(
        self, curves: Array, segment: IntArray, t: Array, index: IntArray, s: Array
    ) -> Gaps:
        """The gaps of points of outlines, with first guesses s of the nearest points."""
        position, other = evaluate(curves[..., segment], t), curves[..., index]
        for _ in range(NEWTON):
            step = step_toward(other, s, position)
            before, s = s, np.clip(s - step, 0.0, 1.0)
            if abs(s - before).max(initial=0.0) < SETTLED:
                break
        offset = (position - evaluate(other, s)).T
        outward = self._normals(curves, index, s)
        length = np.hypot(*offset.T)
        side = np.where((offset * outward).sum(1) < 0, -1.0, 1.0)
        normal = side[:, None] * _unit(offset, side[:, None] * outward)
        pairs = np.stack([segment, index], 1)
        return Gaps(self.owner[pairs], pairs, np.stack([t, s], 1), normal, side * length)

    def _nearest(
        self, curves: Array, samples: Gaps, bent: BoolArray
    ) -> tuple[IntArray, Array, IntArray, Array]:
        """The points of curves that are nearest to the other shape, from the nearest samples.

        At the ends (t, s) of a least gap, both curves are parallel, and the gap is perpendicular
        to the second one. Newton's method solves both equations together.
        """
        order = np.lexsort((samples.gap, samples.shape[:, 1], samples.segment[:, 0]))
        key = np.stack([samples.segment[order, 0], samples.shape[order, 1]])
        first = np.concatenate([[True], (key[:, 1:] != key[:, :-1]).any(0)])[: len(order)]
        best = samples.some(order[first])
        # A corner that is nearest belongs to two curves.
        corner = best.some(best.t[:, 0] == 0)
        segment = np.concatenate([best.segment[:, 0], self._before[corner.segment[:, 0]]])
        t = np.concatenate([best.t[:, 0], np.ones(len(corner.t))])
        index = np.concatenate([best.segment[:, 1], corner.segment[:, 1]])
        s = np.concatenate([best.t[:, 1], corner.t[:, 1]])
        curved = np.flatnonzero(bent[segment])
        segment, t, index, s = (v[curved] for v in (segment, t, index, s))
        own, other = curves[..., segment], curves[..., index]
        low, high = np.maximum(t - 1 / CHORDS, 0), np.minimum(t + 1 / CHORDS, 1)
        for _ in range(2 * NEWTON if len(t) else 0):
            before = t, s
            t_step, s_step, by_t = _parallel(own, other, t, s, self._sign[index])
            t = np.clip(t + t_step, low, high)
            s = np.clip(s + s_step + by_t * (t - before[0]), 0, 1)
            if max(abs(t - before[0]).max(), abs(s - before[1]).max()) < SETTLED:
                break
        return segment, t, index, s

    def _normals(self, curves: Array, index: IntArray, t: Array) -> Array:
        """Unit normals (p, 2) that point out of the shape; at a corner, along their bisector."""
        normal = self._normal(curves, index, t)
        for end, neighbour, there in ((1.0, self._after, 0.0), (0.0, self._before, 1.0)):
            at = np.flatnonzero(t == end)
            if len(at):
                other = neighbour[index[at]]
                # A segment without length has no normal; the one beyond it forms the corner.
                long = curves[1:, :, other].any((0, 1))
                other = np.where(long, other, neighbour[other])
                next_to = self._normal(curves, other, np.full(len(at), there))
                normal[at] = _unit(normal[at] + next_to, normal[at])
        return normal

    def _normal(self, curves: Array, index: IntArray, t: Array) -> Array:
        curves, side = curves[..., index], self._sign[index]
        along, chord = evaluate_slope(curves, t), curves[1:].sum(0)
        return _unit(_left(along, side), _left(chord, side))


class _Chords:
    """Chords that replace the segments in the search for the nearest point, shape after shape.

    Attributes
    ----------
    index : (R,) int array
        The segment of each chord.
    first, length : (R,) arrays
        Where the chord starts on its segment, and which part of it the chord replaces.
    """

    def __init__(self, bent: BoolArray, starts: IntArray) -> None:
        counts = np.where(bent, CHORDS, 1)
        self.index = np.repeat(np.arange(len(bent)), counts)
        begins = np.cumsum(counts) - counts
        self.length = 1 / counts[self.index]
        self.first = (np.arange(len(self.index)) - begins[self.index]) * self.length
        ends = np.stack([self.first, self.first + self.length])
        self._ends = np.rint(CHORDS * ends).astype(int)
        self._rows = [*begins[starts], len(self.index)]

    def at(self, segments: Array) -> tuple[Array, Array]:
        """The start of each chord and the way to its end, (R, 2) each."""
        points = _GRID @ segments.swapaxes(0, 1).reshape(4, -1)
        start, end = points.reshape(-1, len(segments), 2)[self._ends, self.index]
        return start, end - start

    def some(self, which: BoolArray, shape: int) -> IntArray:
        """Those of a shape for which a mask (R,) is set."""
        low, high = self._rows[shape : shape + 2]
        return np.flatnonzero(which[low:high]) + low

    def point(self, which: IntArray, part: Array) -> tuple[IntArray, Array]:
        """Segment and parameter of points at a part of some chords, (p,) each."""
        return self.index[which], self.first[which] + part * self.length[which]


def _parallel(
    own: Array, other: Array, t: Array, s: Array, side: Array
) -> tuple[Array, Array, Array]:
    """A Newton step towards parallel tangents at the nearest points of pairs of curves.

    Returns
    -------
    t_step, s_step : (p,) arrays
        The step of t, and that of s if t stays.
    by_t : (p,) array
        The step of s for a unit step of t.
    """
    away = evaluate(own, t) - evaluate(other, s)
    along, tangent = evaluate_slope(own, t), evaluate_slope(other, s)
    bend, turn = 2 * own[2] + 6 * own[3] * t, 2 * other[2] + 6 * other[3] * s
    across, square = (away * tangent).sum(0), (tangent * tangent).sum(0)
    # Where the distance is not convex, the step of a straight line is taken.
    convex = square - (away * turn).sum(0)
    convex = np.where(convex > 0.1 * square, convex, np.maximum(square, LEAST))
    by_t, s_step = (along * tangent).sum(0) / convex, across / convex
    apart = _cross(tangent, along) + s_step * _cross(turn, along)
    grows = _cross(tangent, bend) + by_t * _cross(turn, along)
    steps = np.divide(-apart, grows, out=np.zeros_like(t), where=side * grows > 0)
    return steps, s_step, by_t


def _cross(first: Array, second: Array) -> Array:
    """The cross product of vectors (2, p)."""
    return np.asarray(first[0] * second[1] - first[1] * second[0])


def _left(vectors: Array, side: Array) -> Array:
    """Vectors (2, p), turned to the left and multiplied by numbers (p,), as (p, 2)."""
    return np.stack([-side * vectors[1], side * vectors[0]], 1)


_NONE = Gaps(
    np.zeros((0, 2), dtype=np.intp),
    np.zeros((0, 2), dtype=np.intp),
    np.zeros((0, 2)),
    np.zeros((0, 2)),
    np.zeros(0),
)


def _sides(shapes: Sequence[Shape], contour: IntArray) -> Array:
    """1 for a segment that has its shape on the right, -1 for one that has it on the left.

    A segment inside the shape takes the side of its contour.
    """
    weights = np.zeros(len(contour))
    first = 0
    # Nothing bounds the shape of a space.
    for shape in (one for one in shapes if one.sizes):
        spans = shape.union()
        np.add.at(weights, first + spans.cubic, spans.weight * (spans.end - spans.start))
        first += sum(shape.sizes)
    sums = np.bincount(contour, weights)[contour]
    return np.where(np.where(weights == 0, sums, weights) < 0, -1.0, 1.0)


def _unit(vectors: Array, instead: Array) -> Array:
    """Vectors (p, 2) of length 1; where one vanishes, another vector takes its place."""
    length = np.hypot(*vectors.T)[:, None]
    if length.min(initial=np.inf) <= LEAST:
        vectors = np.where(length > LEAST, vectors, instead)
        length = np.hypot(*vectors.T)[:, None]
        length = np.where(length > 0, length, 1.0)
    return np.asarray(vectors / length)
