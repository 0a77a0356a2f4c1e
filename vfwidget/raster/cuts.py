"""Cubics cut at pixel borders, so that each piece lies in one pixel and is monotone in x and y.

Arrays are numpy's or torch's, as everywhere in this package's arithmetic (:mod:`..arrays`). What
there are many of, cubics or pieces, is counted along the last dimension, so that arithmetic runs
along memory.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ..arrays import (
    at_least_zero,
    begins,
    between,
    count_up,
    expand,
    following,
    integers,
    like,
    namespace,
    stacked,
    take,
    where_true,
)

POWER = np.array([[1.0, 0, 0, 0], [-3, 3, 0, 0], [3, -6, 3, 0], [-1, 3, -3, 1]])
"""Control points to coefficients of 1, t, t², t³."""
ROUNDS, MOST_ROUNDS = 5, 60
"""Of Newton's method for all borders' crossings, and for the few that want more."""
FEW = 8
"""Once only one crossing in so many is left, those are looked at by themselves."""
SAME = 1e-11
"""How near to each other two parameters count as one."""
ON_BORDER = 1e-11
"""In pixels, how near a border counts as on it."""
BEFORE_NEXT = 0.999999
"""Times t, so that a cut at a cubic's very end is sorted before the next one's beginning."""


class Pieces(NamedTuple):
    """N pieces of cubics, in the order they follow one another along the contours.

    Those above or below the image are left out; those beside it are kept, for what lies left of
    a pixel matters to it.

    Attributes
    ----------
    cubic : (N,) int array
    start, end : (N,) arrays
        Parameters on the cubic.
    first, last : (2, N) arrays
        Its two ends, in pixels.
    row, column : (N,) int arrays
        Its pixel: the rows of all images counted on, the column -1 left of an image and W right
        of it.
    fresh : (N,) bool array
        Whether the piece does not go on from the one before it.
    """

    cubic: Any
    start: Any
    end: Any
    first: Any
    last: Any
    row: Any
    column: Any
    fresh: Any


def evaluate(coefficients: Any, t: Any) -> Any:
    """Polynomials c₀ + c₁ t + c₂ t² + c₃ t³, their coefficients (4, …), at t."""
    c = coefficients
    return ((c[3] * t + c[2]) * t + c[1]) * t + c[0]


def evaluate_slope(coefficients: Any, t: Any) -> Any:
    """Their derivatives at t."""
    c = coefficients
    return (3 * c[3] * t + 2 * c[2]) * t + c[1]


def cut(curves: Any, sizes: Sequence[int], images: int, height: int, width: int) -> Pieces:
    """Cut the cubics of all images.

    Parameters
    ----------
    curves : (4, 2, C) array
        Coefficients of 1, t, t², t³ of x and y, in pixels, y down; image after image, contour
        after contour.
    sizes : sequence of int
        Cubics of each contour of an image.
    images, height, width : int
    """
    xp = namespace(curves)
    count = curves.shape[-1]
    turns = _turns(curves)
    crossing, t = _border_crossings(curves, turns, height, width)
    turns = turns.reshape(-1)
    inner = where_true(turns)
    cubic = xp.concatenate([count_up(count, curves), inner % count, crossing])
    start = xp.concatenate([xp.zeros_like(turns[:count]), take(turns, inner), t])
    order = (cubic + BEFORE_NEXT * start).argsort()
    cubic, start = take(cubic, order), take(start, order)
    # Cuts at one place, such as a turn on a border, are one.
    distinct = start < 1 - SAME
    distinct[1:] &= (start[1:] - start[:-1] > SAME) | (cubic[1:] != cubic[:-1])
    if not distinct.all():
        distinct = where_true(distinct)
        cubic, start = take(cubic, distinct), take(start, distinct)

    first = evaluate(take(curves, cubic), start)
    end, last = following(start), following(first)
    opening = where_true(begins(cubic))
    end[opening - 1] = 1.0
    # A contour ends where it begins.
    begin = take(opening, _first_cubics(sizes, images, opening))
    last[:, following(begin) - 1] = take(first, begin)

    column, row = integers(xp.floor((first + last) / 2))
    kept = (row >= 0) & (row < height)
    if images > 1:
        row = row + cubic // (count // images) * height
    fresh = ~xp.concatenate([kept[:1], kept[:-1]])
    fresh[begin] = True
    pieces = Pieces(cubic, start, end, first, last, row, between(column, -1, width), fresh)
    if kept.all():
        return pieces
    kept = where_true(kept)
    return Pieces(*(take(values, kept) for values in pieces))


def _first_cubics(sizes: Sequence[int], images: int, reference: Any) -> Any:
    """The first cubic of each contour of all images, where ``reference`` lives."""
    size = np.asarray(list(sizes) * images)
    first = size.cumsum() - size
    if type(reference) is np.ndarray:
        return first
    return namespace(reference).as_tensor(first, device=reference.device)


def _turns(curves: Any) -> Any:
    """Where x and y turn, (2, 2, C), the earlier turn first; 0 in place of one outside 0 … 1."""
    xp = namespace(curves)
    c, b, a = curves[1], curves[2], 3 * curves[3]
    # Roots of a t² + 2 b t + c, in the form that survives a = 0.
    root = xp.sqrt(at_least_zero(b * b - a * c))
    q = -(b + xp.where(b < 0, -root, root))
    t = stacked([q / a, c / q])
    t = xp.where((t > 0) & (t < 1), t, 0.0)
    return stacked([xp.minimum(t[0], t[1]), xp.maximum(t[0], t[1])])


def _border_crossings(curves: Any, turns: Any, height: int, width: int) -> tuple[Any, Any]:
    """Where cubics cross borders between pixels: which cubic, and at which t."""
    xp = namespace(curves)
    count = curves.shape[-1]
    zero = xp.zeros_like(turns[:1])
    knots = xp.concatenate([zero, turns, zero + 1])
    values = evaluate(curves[:, None], knots)
    begin, end = values[:-1], values[1:]
    way = end - begin
    limit = like(np.array([[width], [height]]), curves)
    lowest = at_least_zero(xp.ceil(xp.minimum(begin, end)))
    crossed = xp.minimum(xp.floor(xp.maximum(begin, end)), limit) - lowest + 1
    crossed = integers(xp.where(way != 0, at_least_zero(crossed), 0.0)).reshape(-1)
    # Of each monotone stretch, one crossing for each border between its two ends.
    stretch, border = expand(lowest.reshape(-1), crossed)
    polynomials = take(curves.reshape(4, -1), stretch % (2 * count))
    polynomials[0] -= border
    slopes = evaluate_slope(curves[:, None], knots)
    length = knots[1:] - knots[:-1]
    # How steeply a stretch begins and, inversely, ends: 1 for a line, 0 or 2 next to a turn.
    lead = between(1 + (slopes[:-1] - slopes[1:]) * length / (2 * way), 0.0, 2.0)
    about = stacked([knots[:-1], length, begin, way, lead]).reshape(5, -1)
    low, length, begin, way, lead = take(about, stretch)
    part = (border - begin) / way
    # Exact for a parabola, such as a quadratic curve raised to a cubic.
    part = 2 * part / (lead + xp.sqrt(at_least_zero(lead * lead + 4 * (1 - lead) * part)))
    return stretch % count, _root(polynomials, low, low + length, low + part * length)


def _root(polynomials: Any, low: Any, high: Any, t: Any) -> Any:
    """The root (N,), near t, of each cubic polynomial (4, N) on a stretch where it is monotone."""
    t = between(t, low, high)
    for rounds in range(ROUNDS + 1):
        value = evaluate(polynomials, t)
        # NaN, where Newton's method fell on a flat place, is not near.
        rest = where_true(~(abs(value) < ON_BORDER))
        if FEW * len(rest) <= len(t) or rounds == ROUNDS:
            break
        t = between(t - value / evaluate_slope(polynomials, t), low, high)
    if len(rest):
        t[rest] = _search(*(take(values, rest) for values in (polynomials, low, high, t)))
    return t


def _search(polynomials: Any, low: Any, high: Any, t: Any) -> Any:
    """As :func:`_root`, surely: between two walls that close in, by halves where Newton leaves."""
    xp = namespace(polynomials)
    rising = evaluate(polynomials, high) > evaluate(polynomials, low)
    t = xp.where((t >= low) & (t <= high), t, (low + high) / 2)
    for _ in range(MOST_ROUNDS):
        value = evaluate(polynomials, t)
        if (abs(value) < ON_BORDER).all():
            break
        beyond = (value > 0) == rising
        low, high = xp.where(beyond, low, t), xp.where(beyond, t, high)
        newton = t - value / evaluate_slope(polynomials, t)
        held = (newton >= low) & (newton <= high)
        t = xp.where(held, newton, (low + high) / 2)
    return t
