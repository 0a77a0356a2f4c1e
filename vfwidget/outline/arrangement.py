r"""The parts of overlapping outlines that bound a shape, such as their union or common area.

**Slabs.** A *slab* lies between two neighbouring heights at which an arc ends. The arcs in a slab
do not end in it, so they lie side by side. From left to right the winding numbers are running sums
of the arcs' directions. Therefore the parts that are chosen for the boundary of a shape always
close along every horizontal line. Arcs that coincide, or nearly do, may be taken in either order:
this changes the shape by no more than the gap between them. No point beside an edge is looked at,
and no tolerance takes part in the decision.

**Tilt.** The outlines are first turned by a small angle, because many edges of letters are level,
and a level edge is in no slab. If an edge is nearly level after that, other angles are tried.

**Strips.** Long texts are also cut into vertical strips, so that the number of parts grows in
proportion to the length of the text. The winding number at the left border of a strip is the sum of
the crossings of that border below.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..arrays import (
    Array,
    begins,
    between,
    count_up,
    expand,
    following,
    integers,
    lexicographic,
    like,
    namespace,
    rotation_matrices,
    running_maximum,
    sum_at,
    take,
    where_true,
    zeros,
)
from .crossings import Climbers, climbers, crossings
from .monotone import Arcs, join, monotone_arcs
from .near import check_pairs

TURNS = [rotation_matrices(-angle) for angle in (0.0619, 0.0871, 0.1123, 0.1367)]
"""Rotations by angles at which letters have no straight edges."""
LEVEL = 1e-5
"""An arc that climbs less than this share of its width is nearly level."""
SHORT = 1e-9
"""Arcs whose width is not larger than this do not matter."""
PER_STRIP = 100
"""Mean number of cubics in a strip."""
PARTS = 16
"""To sort this many parts of arcs takes as long as to compare a pair of arcs."""


class Slabs(NamedTuple):
    """The M parts of N arcs in L - 1 slabs, arc after arc and upwards within an arc.

    Attributes
    ----------
    levels : (L,) array
        The heights, strip after strip, ascending within a strip. Slab i lies between levels i and
        i + 1.
    low, high : (N,) int arrays
        The levels of each arc's lower and upper end.
    arc, slab : (M,) int arrays
    """

    levels: Any
    low: Any
    high: Any
    arc: Any
    slab: Any


class Spans(NamedTuple):
    """N parts of cubics, each with a weight. They are in order and together cover every cubic.

    Attributes
    ----------
    cubic : (N,) int array
    start, end : (N,) arrays
        Parameters on the cubic.
    weight : (N,) array
        1 or -1 on the boundary of the shape: 1 where the shape lies on the right of the cubic's
        direction if y points up (on the left if y points down). 0 elsewhere.
    """

    cubic: Any
    start: Any
    end: Any
    weight: Any


def nonzero(winding: Any) -> Any:
    """Where the winding number (1, N) is not zero: the union of all outlines."""
    return winding[0] != 0


def in_both(winding: Any) -> Any:
    """Where neither of two winding numbers (2, N) is zero: what two groups have in common."""
    return winding[0] * winding[1] != 0


def boundary(
    curves: Any,
    sizes: Sequence[int],
    image: Any = None,
    inside: Callable[[Any], Any] = nonzero,
    layer: Any = None,
) -> Spans:
    """The parts of closed outlines that bound a shape, given by the winding numbers inside it.

    Parameters
    ----------
    curves : (4, 2, C) array
        Coefficients of 1, t, t², t³ of x and y, contour after contour.
    sizes : sequence of int
        Cubics of each contour.
    image : (C,) int array, optional
        The image of each cubic, in ascending order; outlines of different images do not meet. By
        default there is one image.
    inside : callable
        From winding numbers (G, N) to whether a point is in the shape, (N,).
    layer : (C,) int array, optional
        Which of the G winding numbers each cubic belongs to; by default all to the first.

    Raises
    ------
    OverlapError
        Too many curves cross or lie side by side, by ``limits.curve_pairs``.
    """
    xp = namespace(curves)
    if image is None:
        image = xp.zeros_like(count_up(curves.shape[-1], curves))
    with np.errstate(all="ignore"):
        images = int(image[-1]) + 1
        turned, strips, arcs = _tilted(curves, sizes, images)
        lines = climbers(turned, arcs)
        cubic, t = crossings(lines, arcs, take(image, arcs.cubic))
        if len(cubic):
            cubic = xp.concatenate([arcs.cubic, cubic])
            arcs = join(turned, sizes, cubic, xp.concatenate([arcs.start, t]))
            lines = climbers(turned, arcs)
        strip = take(image, arcs.cubic)
        if strips > 1:
            column = between(integers((arcs.first[0] + arcs.last[0]) / 2), 0, strips - 1)
            strip = column + strips * strip
        cells = _slabs(arcs, strip, images)
        return _spans(lines, arcs, strip if strips > 1 else None, cells, inside, layer)


def _tilted(curves: Any, sizes: Sequence[int], images: int) -> tuple[Any, int, Arcs]:
    """The curves, turned so that no arc is nearly level; the number of strips; and the arcs."""
    xp = namespace(curves)
    best, most = None, -1.0
    for turn in TURNS:
        turned, strips = _turn(curves, images, turn)
        arcs = monotone_arcs(turned, sizes, (strips if strips > 1 else -1, -1))
        width, height = abs(arcs.last - arcs.first)
        slope = float(xp.where(width > SHORT, height / width, 1.0).min())
        if best is None or slope > most:
            best, most = (turned, strips, arcs), slope
        if slope > LEVEL:
            break
    assert best is not None
    return best


def _turn(curves: Any, images: int, turn: Array) -> tuple[Any, int]:
    """The curves, turned and scaled so that strips are one wide, and the number of strips."""
    turned = like(turn, curves) @ curves
    least, most = turned[0, 0].min(), turned[0, 0].max()
    strips = 1 + curves.shape[-1] // images // PER_STRIP
    width = float(most - least) or 1.0
    if strips > 1:
        # Curves are cut into two on average at most.
        widths = float(abs(turned[1:, 0].sum(0)).sum())
        strips = int(min(strips, 1 + curves.shape[-1] * width / max(widths, 1e-300)))
    turned[0, 0] -= least
    return turned * (strips / width), strips


def _slabs(arcs: Arcs, strip: Any, images: int) -> Slabs:
    """Cut arcs at the heights of all ends of arcs in the same strip (N,)."""
    xp = namespace(arcs.first)
    count = len(strip)
    height = xp.concatenate([arcs.first[1], arcs.last[1]])
    strips = xp.concatenate([strip, strip])
    order = lexicographic(strips, height)
    height, strips = take(height, order), take(strips, order)
    new = height[1:] != height[:-1]
    new |= strips[1:] != strips[:-1]
    rank = zeros(2 * count, order)
    rank[order[1:]] = new.cumsum(0)
    distinct = xp.concatenate([count_up(1, order), where_true(new) + 1])
    first, last = rank[:count], rank[count:]
    low, high = xp.minimum(first, last), xp.maximum(first, last)
    check_pairs(int((high - low).sum()) / PARTS, images)
    return Slabs(take(height, distinct), low, high, *expand(low, high - low))


def _spans(
    lines: Climbers, arcs: Arcs, strip: Any | None, cells: Slabs, inside: Any, layer: Any
) -> Spans:
    """Spans of arcs that have been cut where they cross, with their strips if there are several."""
    xp = namespace(arcs.first)
    turn = xp.sign(arcs.last[1] - arcs.first[1])
    member = (zeros(len(turn), turn) + 1)[None]
    if layer is not None:
        layers = count_up(int(layer.max()) + 1, layer)[:, None]
        member = member * (layers == take(layer, arcs.cubic))

    middle = take((cells.levels[1:] + cells.levels[:-1]) / 2, cells.slab)
    order = lexicographic(cells.slab, lines.across(cells.arc, middle))
    slab, arc = take(cells.slab, order), take(cells.arc, order)
    own, turned = take(member * turn, arc), take(turn, arc)
    after = own.cumsum(-1)
    before = after - own
    # Every slab begins with no winding.
    leftmost = running_maximum(xp.where(begins(slab), count_up(len(slab), slab), 0))
    shift = take(before, leftmost)
    if strip is not None:
        shift = shift - take(_base(arcs, cells, strip, member), slab)
    before, after = before - shift, after - shift
    weight = zeros(len(middle), middle)
    weight[order] = inside(after) * turned - inside(before) * turned
    return _merged(arcs, lines, cells, weight)


def _base(arcs: Arcs, cells: Slabs, strip: Any, member: Any) -> Any:
    """The winding numbers (G, L) at the left border of a strip, right above each level."""
    xp = namespace(member)
    step = take(strip, arcs.follower) - strip
    moves = where_true(step)
    rising = arcs.last[1] > arcs.first[1]
    starts, ends = xp.where(rising, cells.low, cells.high), xp.where(rising, cells.high, cells.low)
    # To the right an outline enters the follower's strip, to the left it leaves its own one.
    level = xp.where(step > 0, take(starts, arcs.follower), ends)
    change = take(-member * xp.sign(step), moves)
    return sum_at(take(level, moves), change, len(cells.levels)).cumsum(-1)


def _merged(arcs: Arcs, lines: Climbers, cells: Slabs, weight: Any) -> Spans:
    """Neighbouring cells of equal weight (M,) as one span."""
    xp = namespace(weight)
    fresh = begins(cells.arc)
    run = where_true(fresh | begins(weight))
    fresh, arc, weight = take(fresh, run), take(cells.arc, run), take(weight, run)
    start, rising = take(arcs.start, arc), take(arcs.last[1] > arcs.first[1], arc)
    inner = where_true(~fresh)
    if len(inner):
        # Arcs that lie very close to each other change sides within an arc. Of two neighbours the
        # later one along the arc starts there.
        level = take(cells.levels, take(cells.slab, take(run, inner)))
        later = xp.where(take(rising, inner), inner, inner - 1)
        start[later] = lines.at(take(arc, inner), level)
    turned = xp.where(rising, run, -run)
    flat = where_true(cells.low == cells.high)
    if len(flat):
        # Arcs without height are in no slab. They bound nothing.
        arc, turned = xp.concatenate([arc, flat]), xp.concatenate([turned, flat])
        start = xp.concatenate([start, take(arcs.start, flat)])
        weight = xp.concatenate([weight, zeros(len(flat), weight)])
    order = lexicographic(arc, turned)
    cubic = take(arcs.cubic, take(arc, order))
    start, weight = take(start, order), take(weight, order)
    if len(inner):
        # Near a turn, rounding may put levels that nearly coincide in the wrong order.
        start = take(start, lexicographic(cubic, start))
    opening = begins(cubic)
    kept = where_true(opening | begins(weight))
    opening = take(opening, kept)
    cubic, start, weight = (take(values, kept) for values in (cubic, start, weight))
    start[where_true(opening)] = 0.0
    end = following(start)
    end[following(opening)] = 1.0
    return Spans(cubic, start, end, weight)
