"""Cubics cut at pixel borders, so that each piece lies in one pixel and is monotone in x and y.

Arrays are numpy's or torch's, as everywhere in this package's arithmetic (:mod:`..arrays`).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ..arrays import begins, count_up, integers, like, namespace, repeat, sorting, take, where_true

POWER = np.array([[1.0, 0, 0, 0], [-3, 3, 0, 0], [3, -6, 3, 0], [-1, 3, -3, 1]])
"""Control points to coefficients of 1, t, t², t³."""
SLOPE = np.array([[1.0], [2], [3]])
"""What the last three of them are multiplied by in a derivative."""
ROUNDS, MOST_ROUNDS = 5, 60
"""Of Newton's method for all borders' crossings, and for the few that want more."""
SAME = 1e-11
"""How near to each other two parameters count as one."""
ON_BORDER = 1e-11
"""In pixels, how near a border counts as on it."""


class Pieces(NamedTuple):
    """N pieces of cubics, in the order they follow one another along the contours.

    Those above or below the image are left out; those beside it are kept, for what lies left of
    a pixel matters to it.

    Attributes
    ----------
    cubic : (N,) int array
    start, end : (N,) arrays
        Parameters on the cubic.
    first, last : (N, 2) arrays
        Its two ends, in pixels.
    cell : (N,) int array
        Its pixel, in images that have a column more at each side:
        ``row · (W + 2) + column + 1``, rows of all images counted on.
    fresh : (N,) bool array
        Whether the piece does not go on from the one before it.
    """

    cubic: Any
    start: Any
    end: Any
    first: Any
    last: Any
    cell: Any
    fresh: Any


def evaluate(coefficients: Any, t: Any) -> Any:
    """Polynomials c₀ + c₁ t + c₂ t² + c₃ t³, their coefficients (N, 4, …), at t."""
    c = coefficients
    return ((c[:, 3] * t + c[:, 2]) * t + c[:, 1]) * t + c[:, 0]


def evaluate_slope(slopes: Any, t: Any) -> Any:
    """Their derivatives, from the coefficients (N, 3, …) of those."""
    return (slopes[:, 2] * t + slopes[:, 1]) * t + slopes[:, 0]


def cut(curves: Any, sizes: Sequence[int], images: int, height: int, width: int) -> Pieces:
    """Cut the cubics of all images.

    Parameters
    ----------
    curves : (C, 4, 2) array
        Coefficients of 1, t, t², t³ of x and y, in pixels, y down; image after image, contour
        after contour.
    sizes : sequence of int
        Cubics of each contour of an image.
    images, height, width : int
    """
    xp = namespace(curves)
    count = len(curves)
    turns = _turns(curves)
    crossing, t = _border_crossings(curves, turns, height, width)
    flat = turns.reshape(-1)
    inner = where_true((flat > 0) & (flat < 1))
    owner = count_up(count, curves)
    cubic = xp.concatenate([owner, inner // 4, crossing])
    start = xp.concatenate([xp.zeros_like(flat[:count]), take(flat, inner), t])
    # A cut at a cubic's very end still comes before the next one's beginning.
    order = sorting(cubic + 0.999999 * start)
    cubic, start = take(cubic, order), take(start, order)
    # Cuts at one place, such as a turn on a border, are one.
    again = (start > 0) & ((start - xp.roll(start, 1) < SAME) & (cubic == xp.roll(cubic, 1)))
    again |= start > 1 - SAME
    if again.any():
        distinct = where_true(~again)
        cubic, start = take(cubic, distinct), take(start, distinct)

    first = evaluate(take(curves, cubic), start[:, None])
    opening = begins(cubic)
    ends = xp.roll(opening, -1)
    end = xp.where(ends, 1.0, xp.roll(start, -1))
    opens, follower = _contours(owner, sizes, images)
    # A cubic ends where the next one of its contour begins.
    corner = take(take(first, where_true(opening)), follower)
    last = xp.where(ends[:, None], take(corner, cubic), xp.roll(first, -1, 0))

    place = integers(xp.floor((first + last) / 2))
    column, row = place[:, 0], place[:, 1]
    cell = (cubic // (count // images) * height + row) * (width + 2)
    cell = cell + xp.clip(column, -1, width) + 1
    kept = (row >= 0) & (row < height)
    fresh = (opening & take(opens, cubic)) | ~xp.roll(kept, 1)
    pieces = Pieces(cubic, start, end, first, last, cell, fresh)
    if kept.all():
        return pieces
    kept = where_true(kept)
    return Pieces(*(take(values, kept) for values in pieces))


def _contours(owner: Any, sizes: Sequence[int], images: int) -> tuple[Any, Any]:
    """Whether each cubic is its contour's first, and which cubic follows it there."""
    size = np.tile(np.asarray(sizes, dtype=np.intp), images)
    first = np.cumsum(size) - size
    opens, follower = np.zeros(len(owner), dtype=bool), np.arange(1, len(owner) + 1)
    opens[first] = True
    follower[first + size - 1] = first
    if type(owner) is np.ndarray:
        return opens, follower
    xp = namespace(owner)
    return tuple(xp.as_tensor(values, device=owner.device) for values in (opens, follower))


def _turns(curves: Any) -> Any:
    """Where x and y turn, (C, 2, 2) in order; 0 in place of a turn outside 0 … 1."""
    xp = namespace(curves)
    c, b, a = curves[:, 1], curves[:, 2], 3 * curves[:, 3]
    # Roots of a t² + 2 b t + c, in the form that survives a = 0.
    root = xp.sqrt(xp.clip(b * b - a * c, 0, None))
    q = -(b + xp.where(b < 0, -root, root))
    one, other = q / a, c / q
    one = xp.where((one > 0) & (one < 1), one, 0.0)
    other = xp.where((other > 0) & (other < 1), other, 0.0)
    return xp.stack([xp.minimum(one, other), xp.maximum(one, other)], -1)


def _border_crossings(curves: Any, turns: Any, height: int, width: int) -> tuple[Any, Any]:
    """Where cubics cross borders between pixels: which cubic, and at which t."""
    xp = namespace(curves)
    zero = xp.zeros_like(turns[..., :1])
    knots = xp.concatenate([zero, turns, zero + 1], -1)
    values = evaluate(curves[..., None], knots)
    begin, end = values[..., :-1], values[..., 1:]
    limit = like(np.array([[width], [height]]), curves)
    lowest = xp.clip(xp.ceil(xp.minimum(begin, end)), 0, None)
    count = xp.minimum(xp.floor(xp.maximum(begin, end)), limit) - lowest + 1
    count = integers(xp.clip(count, 0, None)).reshape(-1)
    # Of each monotone stretch, one crossing for each border between its two ends.
    stretch = repeat(count)
    before = count.cumsum(0) - count
    border = take(lowest.reshape(-1) - before, stretch) + count_up(len(stretch), count)
    polynomials = take(xp.swapaxes(curves, 1, 2).reshape(-1, 4), stretch // 3)
    polynomials[:, 0] -= border
    way = end - begin
    slopes = evaluate_slope((curves[:, 1:] * like(SLOPE, curves))[..., None], knots)
    length = knots[..., 1:] - knots[..., :-1]
    # How steeply a stretch begins and, inversely, ends: 1 for a line, 0 or 2 next to a turn.
    lead = 1 + (slopes[..., :-1] - slopes[..., 1:]) * length / (2 * way)
    about = xp.stack([knots[..., :-1], length, begin, way, xp.clip(lead, 0, 2)], -1)
    low, length, begin, way, lead = take(about.reshape(-1, 5), stretch).T
    part = (border - begin) / way
    # Exact for a parabola, such as a quadratic curve raised to a cubic.
    part = 2 * part / (lead + xp.sqrt(xp.clip(lead * lead + 4 * (1 - lead) * part, 0, None)))
    return stretch // 6, _root(polynomials, low, low + length, low + part * length)


def _root(polynomials: Any, low: Any, high: Any, t: Any) -> Any:
    """The root (N,), near t, of each cubic polynomial (N, 4) on a stretch where it is monotone."""
    xp = namespace(polynomials)
    slopes = polynomials[:, 1:] * like(SLOPE[:, 0], polynomials)
    t = xp.clip(t, low, high)
    for _ in range(ROUNDS):
        value = evaluate(polynomials, t)
        if (abs(value) < ON_BORDER).all():
            return t
        t = xp.clip(t - value / evaluate_slope(slopes, t), low, high)
    # NaN, where Newton's method fell on a flat place, is not near.
    rest = where_true(~(abs(evaluate(polynomials, t)) < ON_BORDER))
    if len(rest):
        t[rest] = _search(*(take(values, rest) for values in (polynomials, low, high)))
    return t


def _search(polynomials: Any, low: Any, high: Any) -> Any:
    """As :func:`_root`, surely: between two walls that close in, by halves where Newton leaves."""
    xp = namespace(polynomials)
    rising = evaluate(polynomials, high) > evaluate(polynomials, low)
    slopes, t = polynomials[:, 1:] * like(SLOPE[:, 0], polynomials), (low + high) / 2
    for _ in range(MOST_ROUNDS):
        value = evaluate(polynomials, t)
        if (abs(value) < ON_BORDER).all():
            break
        beyond = (value > 0) == rising
        low, high = xp.where(beyond, low, t), xp.where(beyond, t, high)
        newton = t - value / evaluate_slope(slopes, t)
        held = (newton >= low) & (newton <= high)
        t = xp.where(held, newton, (low + high) / 2)
    return t
