"""The parts of outlines that matter to what pairs of shapes have in common.

The common area of two shapes lies in the boxes around both of them. Successive segments of one
shape that lie beyond the same side of the other one's box are replaced by their chord, which leaves
all winding numbers inside the box as they are.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..arrays import Array, IntArray, begins
from ..outline.near import near_pairs
from .shape import CLOSED, Shape

THIRDS = np.arange(4)[:, None] / 3


class Outlines(NamedTuple):
    """C curves of P pairs of shapes, contour after contour.

    Attributes
    ----------
    points : (C, 4, 2) array
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


def shortened(pairs: list[tuple[Shape, Shape]]) -> tuple[Outlines, Array]:
    """What matters of the outlines, and the middle (P, 2) of what the boxes have in common.

    Pairs of which no two segments come near each other are left out, unless a contour may lie
    inside the other shape.
    """
    if not pairs:
        none = np.zeros(0, dtype=np.intp)
        return Outlines(np.zeros((0, 4, 2)), none, none, none), np.zeros((0, 2))
    shapes = [shape for pair in pairs for shape in pair]
    points = np.concatenate([shape.segments for shape in shapes])
    shape, first = _blocks([len(shape.segments) for shape in shapes])
    contour, opening = _blocks([size for shape in shapes for size in shape.sizes])
    low, high = points.min(1), points.max(1)
    least, most = np.minimum.reduceat(low, first), np.maximum.reduceat(high, first)
    middle = (np.maximum(least[::2], least[1::2]) + np.minimum(most[::2], most[1::2])) / 2
    # The other shape of the pair.
    other = shape ^ 1
    least, most = least[other], most[other]
    beyond = np.concatenate([high < least, low > most], 1)
    side = np.where(beyond.any(1), beyond.argmax(1), -1)
    near = np.flatnonzero(side < 0)
    matters = np.zeros(len(pairs), dtype=bool)
    inside = np.logical_and.reduceat(((low >= least) & (high <= most)).all(1), opening)
    matters[shape[opening[inside]] // 2] = True
    matters[_meeting(low[near], high[near], shape[near])] = True

    start = np.flatnonzero((side < 0) | begins(side) | begins(contour))
    end = np.append(start[1:], len(points)) - 1
    chord = side[start] >= 0
    # A contour that is one chord bounds nothing.
    alone = np.bincount(contour[start])[contour[start]] == 1
    kept = matters[shape[start] // 2] & ~(chord & alone)
    start, end, chord = start[kept], end[kept], chord[kept]
    curves, way = points[start], points[end, 3] - points[start, 0]
    straight = curves[:, :1] + THIRDS * way[:, None]
    curves = np.where(chord[:, None, None], straight, curves)
    return Outlines(curves, shape[start], contour[start], start - first[shape[start]]), middle


def _meeting(low: Array, high: Array, shape: IntArray) -> IntArray:
    """The pairs in which boxes around segments of both shapes overlap or touch."""
    if not len(shape):
        return shape
    (one, other), _, _ = near_pairs(low.T - CLOSED, high.T + CLOSED, shape // 2)
    return np.asarray(shape[one[shape[one] != shape[other]]] // 2)


def _blocks(counts: Sequence[int]) -> tuple[IntArray, IntArray]:
    """The block of each element, and the first element of each block, for blocks of given sizes."""
    sizes = np.array(counts, dtype=np.intp)
    return np.repeat(np.arange(len(sizes)), sizes), np.cumsum(sizes) - sizes
