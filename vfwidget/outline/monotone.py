"""Cubics cut into arcs that are monotone in both coordinates, and the roots on such arcs.

Arrays are numpy's or torch's (:mod:`..arrays`). The number of cubics or arcs is the last dimension,
so that arithmetic runs along memory. A polynomial is given by its coefficients of 1, t, t², t³.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ..arrays import (
    ascending,
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
    zeros,
)

POWER = np.array([[1.0, 0, 0, 0], [-3, 3, 0, 0], [3, -6, 3, 0], [-1, 3, -3, 1]])
"""Control points to coefficients of 1, t, t², t³."""
ROUNDS, MOST_ROUNDS = 5, 60
"""Newton steps for all roots together, and for the few roots that need more."""
FEW = 8
"""When at most one root in this many is left, those are refined separately."""
SAME = 1e-11
"""Two parameters that differ by less are one."""
CLOSE = 1e-11
"""A root is found when the polynomial is within this of its goal."""
TINY = 1e-300
"""Keeps a quotient of two zeros at zero."""
BEFORE_NEXT = 0.999999
"""Factor of t in sort keys: a cut at the end of a cubic comes before the start of the next one."""


class Arcs(NamedTuple):
    """N arcs of cubics, in the order in which they follow one another along the contours.

    Attributes
    ----------
    cubic : (N,) int array
    start, end : (N,) arrays
        Parameters on the cubic.
    first, last : (2, N) arrays
        The two end points.
    follower : (N,) int array
        The arc that starts where this one ends.
    """

    cubic: Any
    start: Any
    end: Any
    first: Any
    last: Any
    follower: Any


def evaluate(coefficients: Any, t: Any) -> Any:
    """Polynomials with coefficients (4, …), at t."""
    c = coefficients
    return ((c[3] * t + c[2]) * t + c[1]) * t + c[0]


def evaluate_slope(coefficients: Any, t: Any) -> Any:
    """Derivatives of polynomials with coefficients (4, …), at t."""
    c = coefficients
    return (3 * c[3] * t + 2 * c[2]) * t + c[1]


def coefficients(points: Any) -> Any:
    """Coefficients (4, 2, C) of the cubics with control points (…, 4, 2), C of them."""
    across = namespace(points).swapaxes(points.reshape(-1, 8), 0, 1).reshape(4, -1)
    return (like(POWER, points) @ across).reshape(4, 2, -1)


def monotone_arcs(
    curves: Any, sizes: Sequence[int], grid: tuple[int, int], cubic: Any = None, t: Any = None
) -> Arcs:
    """Cubics cut where x or y turns, at integer coordinates, and at further given parameters.

    Parameters
    ----------
    curves : (4, 2, C) array
        Coefficients of x and y, contour after contour.
    sizes : sequence of int
        Number of cubics of each contour.
    grid : (int, int)
        Cubics are cut at x = 0, 1, …, grid[0] and y = 0, 1, …, grid[1]; -1 means no cut.
    cubic, t : (M,) arrays, optional
        Further cuts.
    """
    xp = namespace(curves)
    count = curves.shape[-1]
    turns = _turns(curves)
    flat = turns.reshape(-1)
    inner = where_true(flat)
    cubics = [count_up(count, curves), inner % count]
    starts = [zeros(count, flat), take(flat, inner)]
    if max(grid) >= 0:
        crossing, at = _grid_crossings(curves, turns, grid)
        cubics, starts = [*cubics, crossing], [*starts, at]
    if cubic is not None:
        cubics, starts = [*cubics, cubic], [*starts, t]
    return join(curves, sizes, xp.concatenate(cubics), xp.concatenate(starts))


def join(curves: Any, sizes: Sequence[int], cubic: Any, start: Any) -> Arcs:
    """The arcs between cuts (M,), which include the start of every cubic, in any order.

    Every contour is closed: its last arc ends at the point at which its first arc starts.
    """
    order = ascending(cubic + BEFORE_NEXT * start)
    cubic, start = take(cubic, order), take(start, order)
    # Cuts at one parameter, such as a turn on a grid line, are one.
    distinct, fresh = start < 1 - SAME, begins(cubic)
    distinct[1:] &= (start[1:] - start[:-1] > SAME) | fresh[1:]
    if not distinct.all():
        distinct = where_true(distinct)
        cubic, start, fresh = (take(values, distinct) for values in (cubic, start, fresh))
    first = evaluate(take(curves, cubic), start)
    end, follower = following(start), count_up(len(cubic), cubic) + 1
    opening = where_true(fresh)
    end[opening - 1] = 1.0
    begin = take(opening, _first_cubics(sizes, opening))
    closing = following(begin) - 1
    follower[closing] = begin
    last = following(first)
    last[:, closing] = take(first, begin)
    return Arcs(cubic, start, end, first, last, follower)


def _first_cubics(sizes: Sequence[int], reference: Any) -> Any:
    """The first cubic of each contour, where ``reference`` lives."""
    size = np.asarray(sizes)
    first = size.cumsum() - size
    if type(reference) is np.ndarray:
        return first
    return namespace(reference).as_tensor(first, device=reference.device)


def _turns(curves: Any) -> Any:
    """Where x and y turn, (2, 2, C), in any order; 0 in place of a turn outside 0 … 1."""
    xp = namespace(curves)
    c, b, a = curves[1], curves[2], 3 * curves[3]
    # Roots of a t² + 2 b t + c, in the form that survives a = 0.
    root = xp.sqrt(at_least_zero(b * b - a * c))
    q = -(b + xp.copysign(root, b))
    t = stacked([q / a, c / q])
    return xp.where((t > 0) & (t < 1), t, 0.0)


def _grid_crossings(curves: Any, turns: Any, grid: tuple[int, int]) -> tuple[Any, Any]:
    """Where cubics cross grid lines: which cubic, and at which t."""
    xp = namespace(curves)
    count = curves.shape[-1]
    earlier, later = xp.minimum(*turns), xp.maximum(*turns)
    knots = stacked([0 * earlier, earlier, later, 0 * later + 1])
    values = evaluate(curves[:, None], knots)
    begin, end = values[:-1], values[1:]
    about = climbs(curves[:, None], knots[:-1], knots[1:], begin, end)
    way = about[3]
    limit = like(np.array(grid, dtype=float)[:, None], curves)
    lowest = at_least_zero(xp.ceil(xp.minimum(begin, end)))
    crossed = xp.minimum(xp.floor(xp.maximum(begin, end)), limit) - lowest + 1
    crossed = integers(xp.where(way != 0, at_least_zero(crossed), 0.0)).reshape(-1)
    # Of each monotone stretch, one crossing for each line between its two ends.
    stretch, line = expand(lowest.reshape(-1), crossed)
    stretches = len(way)
    polynomials = xp.concatenate([curves.reshape(4, -1)] * stretches, -1)
    cubic = xp.concatenate([count_up(count, curves)] * 2 * stretches)
    about = about.reshape(7, -1)
    t = reach(take(polynomials, stretch), take(about, stretch), line)
    return take(cubic, stretch), t


def climbs(polynomials: Any, low: Any, high: Any, begin: Any, end: Any) -> Any:
    """What :func:`reach` needs of monotone stretches low … high of polynomials, (7, …).

    The first and the last parameter, the first value, the change of value, and three numbers of
    the parabola through both ends: its slope at the beginning over twice the mean slope, 0 … 1
    (0.5 for a line, 0 or 1 next to a turn), the square of that, and the rest of twice that to 1.
    The values at low and high are ``begin`` and ``end``.
    """
    length, way = high - low, end - begin
    # Half the difference of the slopes at both ends, over the length.
    bend = 1.5 * polynomials[3] * (low + high) + polynomials[2]
    lead = between(0.5 - length * length * bend / (2 * way), 0.0, 1.0)
    return stacked([low, high, begin, way, lead, lead * lead, 1 - 2 * lead])


def reach(polynomials: Any, about: Any, goal: Any) -> Any:
    """The parameters (N,) at which polynomials (4, N) reach a goal (N,) on monotone stretches.

    ``about`` (7, N) is from :func:`climbs`. A goal outside a stretch gives the nearer end.
    """
    xp = namespace(polynomials)
    low, high, begin, way, lead, square, rest = about
    part = between((goal - begin) / way, 0.0, 1.0)
    # Exact for a parabola, such as a quadratic curve raised to a cubic. At a turn, where ``lead``
    # and ``part`` are zero, it is zero as well.
    part = part / (lead + xp.sqrt(at_least_zero(square + rest * part) + TINY))
    t = xp.minimum(low + part * (high - low), high)
    constant = polynomials[0] - goal
    for rounds in range(ROUNDS + 1):
        value = ((polynomials[3] * t + polynomials[2]) * t + polynomials[1]) * t + constant
        # NaN, where Newton's method met a slope of zero, is not close.
        rest = where_true(~(abs(value) < CLOSE))
        if FEW * len(rest) <= len(t) or rounds == ROUNDS:
            break
        t = between(t - value / evaluate_slope(polynomials, t), low, high)
    if len(rest):
        shifted = take(polynomials, rest)
        shifted[0] = take(constant, rest)
        t[rest] = _search(shifted, *(take(values, rest) for values in (low, high, t)))
    return t


def _search(polynomials: Any, low: Any, high: Any, t: Any) -> Any:
    """Roots of monotone polynomials by Newton's method within brackets that are also halved."""
    xp = namespace(polynomials)
    rising = evaluate(polynomials, high) > evaluate(polynomials, low)
    t = xp.where((t >= low) & (t <= high), t, (low + high) / 2)
    for _ in range(MOST_ROUNDS):
        value = evaluate(polynomials, t)
        if (abs(value) < CLOSE).all():
            break
        beyond = (value > 0) == rising
        low, high = xp.where(beyond, low, t), xp.where(beyond, t, high)
        newton = t - value / evaluate_slope(polynomials, t)
        held = (newton >= low) & (newton <= high)
        t = xp.where(held, newton, (low + high) / 2)
    return t
