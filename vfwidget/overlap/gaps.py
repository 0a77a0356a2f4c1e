"""Gaps: where the outlines of two shapes are nearest to each other.

A gap is the distance of a point of one outline from another shape, and negative inside the shape.
Gaps are measured at the corners and at samples of curves, and at the nearest points of curves. The
projection onto the other outline is exact: it starts from the nearest chord and ends by Newton's
method. At a corner, the sum of the two normals decides between inside and outside (Bærentzen and
Aanæs 2005).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array, BoolArray, IntArray
from ..outline.monotone import coefficients, evaluate, evaluate_slope
from .contacts import LEAST, nearest_chord, step_toward
from .shape import Shape

CHORDS = 8
"""Samples of a curve, and chords that replace it in the search for the nearest point."""
STRAIGHT = 1e-3
"""A segment is straight if its handles deviate from its chord by at most so many font units."""
NEWTON = 3
"""Newton steps for a projection, and for the nearest point of a curve."""
SETTLED = 1e-9
"""Newton's method ends when no parameter moves farther. Its next step would be far smaller."""
SAG = 4.0
"""A curve is at most so many font units away from its chords."""


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
        first, second = ((_bernstein(self.t[:, i])) for i in range(2))
        points = segments[self.segment]
        return (
            (first[..., None] * points[:, 0]).sum(1),
            (second[..., None] * points[:, 1]).sum(1),
        )


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
        self.slices = np.cumsum([0, *counts])
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
        bent = ~straight(segments)
        filled = np.flatnonzero(np.diff(self.slices))
        starts = self.slices[filled]
        bottom, top = np.minimum.reduceat(low, starts), np.maximum.reduceat(high, starts)
        near = ((bottom[:, None] - reach < top) & (bottom - reach < top[:, None])).all(-1)
        found, chords = [], {}
        for i, j in np.argwhere(np.triu(near, 1)).tolist():
            if filled[i] >= self.letters:
                continue
            box = np.maximum(bottom[i], bottom[j]) - reach, np.minimum(top[i], top[j]) + reach
            inside = ((low <= box[1]) & (high >= box[0])).all(1)
            for a, b in ((i, j), (j, i)):
                own, other = (
                    np.flatnonzero(inside[starts[k] : self.slices[filled[k] + 1]]) + starts[k]
                    for k in (a, b)
                )
                if len(own) and len(other):
                    known = chords[filled[a], filled[b]] = _Chords(segments, other, bent)
                    found.append(_nearby(segments, own, bent, known, box, reach))
        if not found:
            return _NONE
        samples = self._project(segments, *(np.concatenate(v) for v in zip(*found, strict=True)))
        samples = samples.some(abs(samples.gap) < reach)
        nearest = self._nearest(segments, samples, bent, chords)
        return _joined([samples, nearest.some(abs(nearest.gap) < reach)])

    def _project(
        self, segments: Array, segment: IntArray, t: Array, index: IntArray, s: Array
    ) -> Gaps:
        """The gaps of points of outlines, with first guesses s of the nearest points."""
        curves = coefficients(segments[index])
        position = evaluate(coefficients(segments[segment]), t)
        for _ in range(NEWTON):
            before, s = s, _toward(curves, s, position)
            if abs(s - before).max(initial=0.0) < SETTLED:
                break
        return self._measured(segments, segment, t, index, s)

    def _nearest(
        self,
        segments: Array,
        samples: Gaps,
        bent: BoolArray,
        chords: Mapping[tuple[int, int], _Chords],
    ) -> Gaps:
        """The points of curves that are nearest to the other shape, from the nearest samples."""
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
        normal = np.concatenate([best.normal, corner.normal])
        curved = np.flatnonzero(bent[segment])
        if not len(curved):
            return _NONE
        segment, t, index, s, normal = (v[curved] for v in (segment, t, index, s, normal))
        own, other = coefficients(segments[segment]), coefficients(segments[index])
        low, high = np.maximum(t - 1 / CHORDS, 0), np.minimum(t + 1 / CHORDS, 1)
        for _ in range(2 * NEWTON):
            slope = (evaluate_slope(own, t) * normal.T).sum(0)
            bend = ((2 * own[2] + 6 * own[3] * t) * normal.T).sum(0)
            before = t, s
            t = np.clip(t - slope / np.where(bend > 0, bend, np.inf), low, high)
            position = evaluate(own, t)
            s = _toward(other, s, position)
            away = (position - evaluate(other, s)).T
            turned = _unit(away, normal)
            normal = np.where((turned * normal).sum(1, keepdims=True) < 0, -turned, turned)
            if abs(np.stack([t, s]) - before).max() < SETTLED:
                break
        # On the way another part of the outline may have become the nearest one.
        shape = self.owner[np.stack([segment, index], 1)]
        for pair, others in chords.items():
            rows = np.flatnonzero((shape == pair).all(1))
            index[rows], s[rows], _ = others.nearest(position.T[rows])
        return self._project(segments, segment, t, index, s)

    def _measured(
        self, segments: Array, segment: IntArray, t: Array, index: IntArray, s: Array
    ) -> Gaps:
        """The gaps between given points."""
        own, other = coefficients(segments[segment]), coefficients(segments[index])
        offset = (evaluate(own, t) - evaluate(other, s)).T
        outward = self.normals(segments, index, s)
        length = np.hypot(*offset.T)
        side = np.where((offset * outward).sum(1) < 0, -1.0, 1.0)
        normal = side[:, None] * _unit(offset, side[:, None] * outward)
        pairs = np.stack([segment, index], 1)
        return Gaps(self.owner[pairs], pairs, np.stack([t, s], 1), normal, side * length)

    def normals(self, segments: Array, index: IntArray, t: Array) -> Array:
        """Unit normals (p, 2) that point out of the shape; at a corner, along their bisector."""
        normal = self._normal(segments, index, t)
        for end, beside, there in ((1.0, self._after, 0.0), (0.0, self._before, 1.0)):
            at = np.flatnonzero(t == end)
            if len(at):
                other = beside[index[at]]
                # A segment without length has no normal; the one beyond it forms the corner.
                other = np.where(np.ptp(segments[other], axis=1).any(1), other, beside[other])
                next_to = self._normal(segments, other, np.full(len(at), there))
                normal[at] = _unit(normal[at] + next_to, normal[at])
        return normal

    def _normal(self, segments: Array, index: IntArray, t: Array) -> Array:
        curves = coefficients(segments[index])
        along = evaluate_slope(curves, t)
        chord = (curves[1] + curves[2] + curves[3]).T
        side = self._sign[index, None]
        outward = np.stack([-along[1], along[0]], 1)
        return _unit(side * outward, side * np.stack([-chord[:, 1], chord[:, 0]], 1))


class _Chords:
    """Chords that replace some segments in the search for the nearest point."""

    def __init__(self, segments: Array, which: IntArray, bent: BoolArray) -> None:
        bent = bent[which]
        self.index = np.concatenate([which[~bent], np.repeat(which[bent], CHORDS)])
        curved = int(bent.sum())
        self.first = np.zeros(len(self.index))
        self.first[len(which) - curved :] = np.tile(np.arange(CHORDS) / CHORDS, curved)
        self.length = np.repeat([1.0, 1 / CHORDS], [len(which) - curved, CHORDS * curved])
        ends = _bernstein(np.concatenate([self.first, self.first + self.length]))
        self.start, end = (ends.reshape(2, -1, 4)[..., None] * segments[self.index]).sum(2)
        self.along = end - self.start

    def nearest(self, points: Array) -> tuple[IntArray, Array, Array]:
        """The segment, the parameter and the distance of the chord nearest to points (p, 2)."""
        best, part, distance = nearest_chord(points, self.start, self.along)
        return self.index[best], self.first[best] + part * self.length[best], distance


def _nearby(
    segments: Array,
    own: IntArray,
    bent: BoolArray,
    chords: _Chords,
    box: tuple[Array, Array],
    reach: float,
) -> tuple[IntArray, Array, IntArray, Array]:
    """Points of some segments that are near chords of others: segment, t, segment, parameter."""
    inner = own[bent[own]]
    segment = np.concatenate([own, np.repeat(inner, CHORDS - 1)])
    t = np.concatenate([np.zeros(len(own)), np.tile(np.arange(1, CHORDS) / CHORDS, len(inner))])
    position = (_bernstein(t)[..., None] * segments[segment]).sum(1)
    kept = np.flatnonzero(((position >= box[0]) & (position <= box[1])).all(1))
    index, s, distance = chords.nearest(position[kept])
    near = distance < reach + SAG
    kept = kept[near]
    return segment[kept], t[kept], index[near], s[near]


def _toward(curves: Array, s: Array, position: Array) -> Array:
    """One Newton step of parameters s (p,) towards the points of curves nearest to positions."""
    return np.asarray(np.clip(s - step_toward(curves, s, position), 0.0, 1.0))


_NONE = Gaps(
    np.zeros((0, 2), dtype=np.intp),
    np.zeros((0, 2), dtype=np.intp),
    np.zeros((0, 2)),
    np.zeros((0, 2)),
    np.zeros(0),
)


def straight(segments: Array) -> BoolArray:
    """Which of the segments (S, 4, 2) are straight."""
    chord = segments[:, 3] - segments[:, 0]
    length = np.maximum(np.hypot(*chord.T), LEAST)
    handles = segments[:, 1:3] - segments[:, :1]
    across = handles[..., 0] * chord[:, None, 1] - handles[..., 1] * chord[:, None, 0]
    inside = (handles * chord[:, None]).sum(-1)
    within = (inside >= -STRAIGHT * length[:, None]) & (
        inside <= (length * (length + STRAIGHT))[:, None]
    )
    straight: BoolArray = (within & (abs(across) <= STRAIGHT * length[:, None])).all(1)
    return straight


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


def _joined(parts: Sequence[Gaps]) -> Gaps:
    return Gaps(*(np.concatenate(values) for values in zip(*parts, strict=True)))


def _bernstein(t: Array) -> Array:
    """The weights (p, 4) of the control points at parameters t (p,)."""
    s = 1 - t
    return np.stack([s**3, 3 * s * s * t, 3 * s * t * t, t**3], 1)


def _unit(vectors: Array, instead: Array) -> Array:
    """Vectors (p, 2) of length 1; where one vanishes, another vector takes its place."""
    length = np.hypot(*vectors.T)
    vectors = np.where((length > LEAST)[:, None], vectors, instead)
    length = np.hypot(*vectors.T)[:, None]
    return np.asarray(vectors / np.where(length > 0, length, 1.0))
