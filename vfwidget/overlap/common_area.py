r"""The area that two shapes have in common, and its derivative by their control points.

The boundary of the common area consists of the parts of either outline that lie in the other shape:
A = ½ Σ ∮ (x dy − y dx) over ∂A∩B and A∩∂B. :mod:`..outline.arrangement` finds those parts so that
they always close, and :mod:`..outline.area` integrates along them, without flattening.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arrays import Array, IntArray, at_least_zero, expand, sum_at
from ..outline.area import areas, swept, swept_by, weighted_powers
from ..outline.arrangement import Spans, boundary, in_both
from ..outline.monotone import POWER, evaluate
from .shape import CLOSED, Shape, with_length
from .shortened import shortened


class Pieces(NamedTuple):
    """The M pieces of common areas, of which a pair of shapes may have several.

    Attributes
    ----------
    pair : (M,) int array
    area : (M,) array
    segment : (U,) int array
        The segment of each part of a boundary, as an index of :attr:`Common.segment`.
    piece : (U,) int array
        The piece that each of the parts belongs to.
    gradient : (U, 4, 2) array
        The contribution of the part to the derivative of the piece's area, by the control points
        of the part's segment. A segment may occur several times, so add the contributions.
    """

    pair: IntArray
    area: Array
    segment: IntArray
    piece: IntArray
    gradient: Array


class Common(NamedTuple):
    """The common area of each of P pairs of shapes.

    Attributes
    ----------
    area : (P,) array
    pair : (C,) int array
        The pair that each of the C segments belongs to, pair after pair.
    layer : (C,) int array
        0 for the first shape of its pair, 1 for the second.
    segment : (C,) int array
        The segment's index in its shape.
    curves : (4, 2, C) array
        Coefficients, measured from ``origin``.
    origin : (P, 2) array
    spans : Spans
        The boundary of the common areas.
    parts : (N,) array
        What each of the N spans adds to the area.
    """

    area: Array
    pair: IntArray
    layer: IntArray
    segment: IntArray
    curves: Array
    origin: Array
    spans: Spans
    parts: Array

    def gradient(self) -> Array:
        """The derivative of the area of a segment's pair by its control points, (C, 4, 2)."""
        spans = self.spans
        powers = weighted_powers(spans.start, spans.end, spans.weight)
        return swept(self.curves, spans.cubic, powers)

    def pieces(self) -> Pieces:
        """The common areas, divided where a level or an upright line does not meet them."""
        bound = self.spans.weight.nonzero()[0]
        cubic, start, end, weight = (values.take(bound) for values in self.spans)
        curves = self.curves.take(cubic, 2)
        ends = evaluate(curves[:, None], np.array([start, end])[:, None])
        low, high = np.minimum(ends[0], ends[1]), np.maximum(ends[0], ends[1])
        piece = _clusters(_clusters(self.pair[cubic], low[1], high[1]), low[0], high[0])
        count = piece.max(initial=-1) + 1
        pair = np.zeros(count, dtype=np.intp)
        pair[piece] = self.pair[cubic]
        return Pieces(
            pair,
            np.bincount(piece, self.parts.take(bound), count).astype(np.float64),
            cubic,
            piece,
            swept_by(curves, weighted_powers(start, end, weight)),
        )

    def spans_of(self, pair: int, layer: int) -> Spans:
        """The parts of one shape of a pair that bound the common area, by the shape's segments."""
        of = (self.pair == pair) & (self.layer == layer)
        kept = of[self.spans.cubic] & (self.spans.weight != 0)
        spans = with_length(Spans(*(values[kept] for values in self.spans)), self.curves)
        return spans._replace(cubic=self.segment[spans.cubic])


def pairs_nearby(
    boxes: Array, letters: int, between_glyphs: bool = True, gap: float = 0.0
) -> IntArray:
    """Pairs (P, 2) of letters, and of letters and obstacles, whose boxes are near each other.

    Parameters
    ----------
    boxes : (n, 2, 2) array
        The lower left and upper right corner of each box; letters first, then obstacles.
    letters : int
        How many of them are letters.
    between_glyphs : bool
        Whether pairs of letters count. They come first. Default True.
    gap : float
        Boxes that are closer than this are near.
    """
    own, others = boxes[:letters], boxes[letters:]
    outer = _nearby(own, others, gap)
    outer[:, 1] += letters
    if not between_glyphs:
        return outer
    inner = _nearby(own, own, gap)
    return np.concatenate([inner[inner[:, 0] < inner[:, 1]], outer])


def _nearby(first: Array, second: Array, gap: float) -> IntArray:
    """Pairs of a box of ``first`` and one of ``second`` that are closer than a gap, in order.

    The boxes are sorted from left to right, so a long line costs little more than its neighbours.
    """
    if not len(first) or not len(second):
        return np.zeros((0, 2), dtype=np.intp)
    left = second[:, 0, 0]
    order = left.argsort(kind="stable")
    least, widest = left[order], (second[:, 1, 0] - left).max()
    begin = least.searchsorted(first[:, 0, 0] - gap - widest)
    end = least.searchsorted(first[:, 1, 0] + gap)
    i, at = expand(begin, np.maximum(end - begin, 0))
    j = order[at]
    one, other = first[i], second[j]
    near = (one[:, 0] - gap < other[:, 1]) & (other[:, 0] - gap < one[:, 1])
    number = (i * len(second) + j)[near.all(1)]
    number.sort()
    return np.array(np.divmod(number, len(second))).T


def common_area(pairs: list[tuple[Shape, Shape]]) -> Common:
    """The common areas of pairs of shapes, each of which has an outline."""
    outlines, origin = shortened(pairs)
    pair, layer = outlines.shape >> 1, outlines.shape & 1
    points = outlines.points - origin.take(pair, 1)
    curves = (POWER @ points.reshape(4, -1)).reshape(points.shape)
    if len(pair):
        sizes = [size for size in np.bincount(outlines.contour).tolist() if size]
        spans = boundary(curves, sizes, pair, in_both, layer)
    else:
        spans = Spans(pair, *[np.zeros(0)] * 3)
    parts = areas(curves, spans)
    # Nothing but rounding is below zero.
    area = at_least_zero(sum_at(pair.take(spans.cubic), parts, len(pairs)))
    return Common(area, pair, layer, outlines.segment, curves, origin.T, spans, parts)


def _clusters(group: IntArray, low: Array, high: Array) -> IntArray:
    """The number of the run of overlapping intervals of the same group to which each belongs."""
    if not len(group):
        return group
    # One group lies to the right of the one before.
    shift = group * (1 + high.max() - low.min())
    low, high = low + shift, high + shift
    order = low.argsort(kind="stable")
    opens = np.zeros(len(order), dtype=np.intp)
    opens[1:] = low[order[1:]] > np.maximum.accumulate(high[order])[:-1] + CLOSED
    number = np.empty_like(group)
    number[order] = opens.cumsum()
    return number
