"""The parts of outlines that matter to what pairs of shapes have in common.

The common area of two shapes lies in the boxes around both of them. Successive segments of one
shape that lie beyond the same side of the other one's box are replaced by their chord, which leaves
all winding numbers inside the box as they are.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ..arrays import Array, BoolArray, IntArray, begins, following
from ..outline.near import near_pairs
from .shape import CLOSED, Shape

THIRDS = np.arange(4)[:, None, None] / 3
NEAR = 4
"""Stands for no side of a box; 0 to 3 are left, below, right and above."""
KEPT = 256
"""Lists of shapes whose indices are kept, because they do not change while letters move."""


class Outlines(NamedTuple):
    """C curves of P pairs of shapes, contour after contour.

    Attributes
    ----------
    points : (4, 2, C) array
        Control points.
    shape : (C,) int array
        The shape of each curve: 2 i and 2 i + 1 for those of pair i.
    contour : (C,) int array
        The contour that each curve belongs to. Not every number occurs.
    segment : (C,) int array
        The index of the curve in its shape; for a chord, that of the first segment it replaces.
    """

    points: Array
    shape: IntArray
    contour: IntArray
    segment: IntArray


class _Indices(NamedTuple):
    """The shape and contour of each of S segments, and the first segment of each of those.

    Attributes
    ----------
    shape, contour, segment : (S,) int arrays
        ``segment`` counts within a shape.
    first, opening : int arrays
        The first segment of each shape, and of each contour.
    opens : (S,) bool array
        Whether a segment is the first one of a contour.
    """

    shape: IntArray
    contour: IntArray
    segment: IntArray
    first: IntArray
    opening: IntArray
    opens: BoolArray


@lru_cache(KEPT)
def _indices(sizes: tuple[Sequence[int], ...]) -> _Indices:
    shape, first = _blocks([sum(contours) for contours in sizes])
    contour, opening = _blocks([size for contours in sizes for size in contours])
    return _Indices(
        shape, contour, np.arange(len(shape)) - first[shape], first, opening, begins(contour)
    )


def _blocks(counts: Sequence[int]) -> tuple[IntArray, IntArray]:
    """The block of each element, and the first element of each block, for blocks of given sizes."""
    sizes = np.array(counts, dtype=np.intp)
    return np.repeat(np.arange(len(sizes)), sizes), np.cumsum(sizes) - sizes


def shortened(pairs: list[tuple[Shape, Shape]]) -> tuple[Outlines, Array]:
    """What matters of the outlines, and the middle (2, P) of what the boxes have in common.

    Pairs of which no two segments come near each other are left out, unless a contour may lie
    inside the other shape.
    """
    if not pairs:
        none = np.zeros(0, dtype=np.intp)
        return Outlines(np.zeros((4, 2, 0)), none, none, none), np.zeros((2, 0))
    shapes = [shape for pair in pairs for shape in pair]
    of = _indices(tuple(shape.sizes for shape in shapes))
    points = np.concatenate([shape.segments.reshape(-1, 8) for shape in shapes])
    points = np.ascontiguousarray(points.T).reshape(4, 2, -1)
    low, high = points.min(0), points.max(0)
    least = np.minimum.reduceat(low, of.first, axis=1)
    most = np.maximum.reduceat(high, of.first, axis=1)
    middle = (
        np.maximum(least[:, ::2], least[:, 1::2]) + np.minimum(most[:, ::2], most[:, 1::2])
    ) / 2
    # The other shape of the pair.
    other = of.shape ^ 1
    least, most = least.take(other, 1), most.take(other, 1)
    beyond = np.ones((NEAR + 1, len(other)), dtype=bool)
    np.less(high, least, out=beyond[:2])
    np.greater(low, most, out=beyond[2:NEAR])
    side = beyond.argmax(0)
    near = side == NEAR
    matters = np.zeros(len(pairs), dtype=bool)
    within = ((low >= least) & (high <= most)).all(0)
    inside = np.logical_and.reduceat(within, of.opening)
    matters[of.shape[of.opening[inside]] // 2] = True
    matters[_meeting(low, high, of.shape, near.nonzero()[0])] = True

    start = (near | begins(side) | of.opens).nonzero()[0]
    # The last one ends at index -1, which is the last segment.
    end = following(start) - 1
    shape, contour, near = of.shape.take(start), of.contour.take(start), near.take(start)
    # A contour that is one chord bounds nothing.
    alone = np.bincount(contour).take(contour) == 1
    kept = (matters.take(shape // 2) & (near | ~alone)).nonzero()[0]
    start, end, near = start.take(kept), end.take(kept), near.take(kept)
    curves = points.take(start, 2)
    straight = curves[0] + THIRDS * (points[3].take(end, 1) - curves[0])
    curves = np.where(near, curves, straight)
    found = Outlines(curves, shape.take(kept), contour.take(kept), of.segment.take(start))
    return found, middle


def _meeting(low: Array, high: Array, shape: IntArray, near: IntArray) -> IntArray:
    """The pairs in which boxes around segments ``near`` of both shapes overlap or touch."""
    if not len(near):
        return near
    shape = shape.take(near)
    (one, other), _, _ = near_pairs(
        low.take(near, 1) - CLOSED, high.take(near, 1) + CLOSED, shape // 2
    )
    one, other = shape.take(one), shape.take(other)
    return np.asarray(one[one != other] // 2)
