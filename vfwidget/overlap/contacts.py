"""Contacts: points of one shape inside another, and the nearest way out."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array, BoolArray, IntArray
from ..outline.arrangement import Spans
from ..outline.monotone import coefficients, evaluate, evaluate_slope
from .shape import Shape

SAMPLES = 8
"""Points, or chords, on each part of an outline that are looked at."""
NEWTON = 6
"""Newton steps from the nearest chord to the nearest point."""
STRAIGHT = 1e-3
"""A segment is straight if its handles are at the thirds of its chord, up to so many font units."""
TOGETHER = 2**19
"""Pairs of points and chords that are compared at once. More would take much memory, and most of
them are far from each other."""
THIRDS = np.array([[2.0, 1.0], [1.0, 2.0]]) / 3
"""Weights of the ends of a straight segment at its handles."""
ROUNDING = 1e-9
"""Relative to a distance: a chord that is farther by less may be the nearest one."""
TOLERANCE, SHALLOW = 0.01, 0.02
"""The farthest point is found up to so large a part of its distance, or so many font units."""
MOST_PARTS = 1024
"""Parts of outlines that are halved at once on the way to the farthest point."""
LEAST = 1e-9
"""Font units: a way that is shorter has no direction."""


class Points(NamedTuple):
    """Points on segments of a shape.

    Attributes
    ----------
    segment : (p,) int array
    t : (p,) array
    position : (p, 2) array
    outward : (p, 2) array
        Unit normals that point out of the shape.
    """

    segment: IntArray
    t: Array
    position: Array
    outward: Array

    def some(self, which: Any) -> Points:
        """Those that an index or mask names."""
        return Points(*(values[which] for values in self))


def sampled(shape: Shape, spans: Spans) -> Points:
    """Points in the middle of equal steps of t along the spans of a shape that have a weight."""
    bound = np.flatnonzero(spans.weight)
    part = (np.arange(SAMPLES) + 0.5) / SAMPLES
    start, length = spans.start[bound], (spans.end - spans.start)[bound]
    t = (start[:, None] + length[:, None] * part).ravel()
    segment, weight = (np.repeat(v[bound], SAMPLES) for v in (spans.cubic, spans.weight))
    return _points(shape, segment, t, weight)


def farthest(
    shape: Shape, spans: Spans, other: Shape, boundary: Spans, distance: Array
) -> tuple[Points, Points]:
    """The point on the spans of a shape that is farthest from another boundary.

    The points between two of :func:`sampled` can be farther than both, at most by the way to them.
    Parts in which that may be so are halved until their points differ by less than 1 %.

    Parameters
    ----------
    distance : array
        That of the points of :func:`sampled`.

    Returns
    -------
    point, nearest : Points
        One point, and the nearest one on the other boundary.
    """
    bound = np.flatnonzero(spans.weight)
    length = (spans.end - spans.start)[bound] / SAMPLES
    low = (spans.start[bound][:, None] + length[:, None] * np.arange(SAMPLES)).ravel()
    # Segment, weight, length in t, and the speed by t, which no point of the segment exceeds.
    speed = 3 * np.linalg.norm(np.diff(shape.segments, axis=1), axis=2).max(1)
    segment, weight, step = (
        np.repeat(v, SAMPLES) for v in (spans.cubic[bound], spans.weight[bound], length)
    )
    best = int(distance.argmax())
    found = _points(shape, segment[[best]], (low + step / 2)[[best]], weight[[best]])
    largest = float(distance[best])
    while True:
        room = distance + speed[segment] * abs(step) / 2
        kept = room > largest + max(TOLERANCE * largest, SHALLOW)
        if not 0 < np.count_nonzero(kept) <= MOST_PARTS:
            return found, nearest(found.position, other, boundary)
        low, step = low[kept], step[kept] / 2
        low, step = np.concatenate([low, low + step]), np.tile(step, 2)
        segment, weight = (np.tile(v[kept], 2) for v in (segment, weight))
        points = _points(shape, segment, low + step / 2, weight)
        way = nearest(points.position, other, boundary).position - points.position
        distance = np.hypot(*way.T)
        best = int(distance.argmax())
        if distance[best] > largest:
            largest, found = float(distance[best]), points.some([best])


def _points(shape: Shape, segment: IntArray, t: Array, weight: Array) -> Points:
    curves = coefficients(shape.segments)[..., segment]
    along = evaluate_slope(curves, t)
    # The shape lies on the right of a part of weight 1, and outside is on its left.
    outward = np.stack([-along[1], along[0]]) * np.sign(weight)
    length = np.hypot(*outward)
    outward = outward / np.where(length > 0, length, 1.0)
    return Points(segment, t, evaluate(curves, t).T, outward.T)


def nearest(points: Array, shape: Shape, spans: Spans) -> Points:
    """The point on the boundary of a shape that is nearest to each of the points (p, 2)."""
    bound = np.flatnonzero(spans.weight)
    segments = shape.segments[spans.cubic[bound]]
    counts = np.where(straight(segments), 1, SAMPLES)
    chord = np.repeat(np.arange(len(bound)), counts)
    step = ((spans.end - spans.start)[bound] / counts)[chord]
    number = np.arange(len(chord)) - np.repeat(np.cumsum(counts) - counts, counts)
    first = spans.start[bound][chord] + number * step
    curves = coefficients(segments)[..., chord]
    low = evaluate(curves, first).T
    along = evaluate(curves, first + step).T - low
    # A sample of another segment may be nearer than those of the nearest one, so chords decide.
    best, part, _ = nearest_chord(points, low, along)
    span = bound[chord[best]]
    t = first[best] + part * step[best]
    curves = coefficients(shape.segments)[..., spans.cubic[span]]
    low, high = spans.start[span], spans.end[span]
    for _ in range(NEWTON):
        t = np.clip(t - step_toward(curves, t, points.T), low, high)
    return _points(shape, spans.cubic[span], t, spans.weight[span])


def nearest_chord(points: Array, start: Array, along: Array) -> tuple[IntArray, Array, Array]:
    """The chord that is nearest to each of the points (p, 2), of c chords.

    Parameters
    ----------
    start, along : (c, 2) arrays
        The beginnings of the chords, and the ways to their ends.

    Returns
    -------
    chord : (p,) int array
    part : (p,) array
        Where on the chord the nearest point lies, 0 … 1.
    distance : (p,) array
    """
    if len(points) * len(start) > TOGETHER and len(points) > 1:
        halves = [_among(half, start, along) for half in np.array_split(points, 2)]
        chord, part, distance = (np.concatenate(both) for both in zip(*halves, strict=True))
        return chord, part, distance
    away = points[:, None] - start
    square = np.maximum((along * along).sum(-1), LEAST**2)
    part = np.clip((away * along).sum(-1) / square, 0, 1)
    away -= part[..., None] * along
    distance = (away * away).sum(-1)
    best = distance.argmin(1)
    row = np.arange(len(best))
    return best, part[row, best], np.sqrt(distance[row, best])


def _among(points: Array, start: Array, along: Array) -> tuple[IntArray, Array, Array]:
    """:func:`nearest_chord`, without the chords that are farther than another from all points."""
    low, high = points.min(0), points.max(0)
    ends = np.stack([start, start + along])
    clear = np.maximum(np.maximum(ends.min(0) - high, low - ends.max(0)), 0.0)
    farthest = np.maximum(abs(start - low), abs(start - high))
    limit = np.hypot(*farthest.T).min() * (1 + ROUNDING)
    kept = np.flatnonzero(np.hypot(*clear.T) <= limit)
    chord, part, distance = nearest_chord(points, start[kept], along[kept])
    return kept[chord], part, distance


def straight(segments: Array) -> BoolArray:
    """Which of the segments (S, 4, 2) are straight."""
    thirds = THIRDS @ segments[:, ::3]
    return np.asarray((abs(segments[:, 1:3] - thirds) <= STRAIGHT).all((1, 2)))


def step_toward(curves: Array, t: Array, position: Array) -> Array:
    """How far a Newton step lowers t (p,) on the way to the points of curves nearest to positions.

    Parameters
    ----------
    curves : (4, 2, p) array
        Coefficients.
    position : (2, p) array
    """
    away, along = evaluate(curves, t) - position, evaluate_slope(curves, t)
    slope = (along * along).sum(0)
    curvature = slope + (away * (2 * curves[2] + 6 * curves[3] * t)).sum(0)
    # Where the distance is not convex, the step of a straight line is taken.
    curvature = np.where(curvature > 0.1 * slope, curvature, slope)
    return np.asarray((away * along).sum(0) / np.where(curvature > 0, curvature, np.inf))
