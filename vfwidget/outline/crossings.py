r"""The crossings of outlines.

Two arcs that are monotone in x and y, and whose boxes overlap, are functions x(y) over a common
range of heights. They are compared at a few heights. Between two heights at which they change sides
they cross. Where the arcs come near each other without changing sides, the height is searched at
which they are nearest, so that the two crossings of a lens are found. The number of comparisons is
bounded, so arcs that coincide cost no more than others.

Gaps below :data:`RESOLUTION` count as zero. A crossing that is missed for that reason does no harm,
because :mod:`.arrangement` sorts the arcs again in every slab.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..arrays import (
    between,
    count_up,
    integers,
    like,
    namespace,
    running_maximum,
    stacked,
    take,
    where_true,
)
from .monotone import SAME, Arcs, climbs, evaluate, evaluate_slope, reach
from .near import near_pairs

RESOLUTION = 1e-12
"""Smallest distance that counts, relative to the largest coordinate."""
HEIGHTS = (1 - np.cos(np.linspace(0, np.pi, 9))) / 2
"""Relative heights at which two arcs are compared; dense at the ends, near which arcs may turn."""
DIPS = 8
"""Most steps of parabolic interpolation towards the height at which two arcs are nearest."""
NEWTON, ENCLOSURES = 5, 48
"""Steps towards a crossing: first of Newton's method, then in a bracket where that fails."""


class Climbers(NamedTuple):
    """Arcs as functions of height.

    Attributes
    ----------
    curves : (4, 2, N) array
        Coefficients of x and y.
    about : (7, N) array
        What :func:`~.monotone.reach` needs to find a height.
    """

    curves: Any
    about: Any

    def at(self, which: Any, height: Any) -> Any:
        """The parameters (M,) at which arcs (M,) have a height."""
        return reach(take(self.curves[:, 1], which), take(self.about, which), height)

    def across(self, which: Any, height: Any) -> Any:
        """The x (M,) at which arcs (M,) have a height."""
        curves = take(self.curves, which)
        t = reach(curves[:, 1], take(self.about, which), height)
        return evaluate(curves[:, 0], t)


def climbers(curves: Any, arcs: Arcs) -> Climbers:
    """The arcs of cubics (4, 2, C) as functions of height."""
    own = take(curves, arcs.cubic)
    about = climbs(own[:, 1], arcs.start, arcs.end, arcs.first[1], arcs.last[1])
    return Climbers(own, about)


def crossings(lines: Climbers, arcs: Arcs, image: Any) -> tuple[Any, Any]:
    """Where arcs of the same image cross: cubics (M,) and parameters (M,) to cut them at.

    Parameters
    ----------
    lines : Climbers
        The arcs as functions of height.
    arcs : Arcs
        Monotone in x and y.
    image : (N,) int array
        Arcs of different images do not cross.

    Raises
    ------
    OverlapError
        More than ``limits.curve_pairs`` pairs of arcs are near enough to cross.
    """
    xp = namespace(image)
    low, high = xp.minimum(arcs.first, arcs.last), xp.maximum(arcs.first, arcs.last)
    pairs, bottom, top = near_pairs(low, high, image)
    resolution = RESOLUTION * max(float(abs(arcs.first).max()), 1e-300)
    height = bottom + like(HEIGHTS[:, None], bottom) * (top - bottom)
    gap = _gaps(lines, pairs, height)
    # Pairs of which one arc stays on one side, as far as is known, and the others.
    changes_side = (gap > resolution).any(0) & (gap < -resolution).any(0)
    changing, near = where_true(changes_side), where_true(~changes_side & _may_dip(gap, resolution))
    found = []
    if len(changing):
        some = take(pairs, changing)
        found.append(_changes(some, take(height, changing), take(gap, changing), resolution))
    if len(near):
        some = take(pairs, near)
        heights, gaps = _dips(lines, some, take(height, near), take(gap, near))
        found.append(_changes(some, heights, gaps, resolution))
    found = [changes for changes in found if changes.pairs.shape[1]]
    if not found:
        return arcs.cubic[:0], arcs.start[:0]
    changes = found[0]
    if len(found) > 1:
        changes = Changes(*(xp.concatenate(parts, -1) for parts in zip(*found, strict=True)))
    t = _meet(lines, changes, resolution)
    return take(arcs.cubic, changes.pairs.reshape(-1)), t.reshape(-1)


def _gaps(lines: Climbers, pairs: Any, height: Any) -> Any:
    """How far right of the first arc of each pair (2, P) the second one is at heights (H, P)."""
    xp = namespace(height)
    which = xp.concatenate([pairs[:, None]] * len(height), 1).reshape(-1)
    x = lines.across(which, xp.concatenate([height.reshape(-1)] * 2))
    half = len(x) // 2
    return (x[half:] - x[:half]).reshape(height.shape)


class Changes(NamedTuple):
    """Where two arcs change sides: the pair, two heights, and the gap at either, (2, Q) each.

    ``part`` (Q,) is about the share of the way between the two heights at which they cross.
    """

    pairs: Any
    height: Any
    gap: Any
    part: Any


def _changes(pairs: Any, height: Any, gap: Any, resolution: float) -> Changes:
    """Where gaps (H, P) of pairs (2, P) at ascending heights (H, P) change sign."""
    xp = namespace(gap)
    decided = xp.where(abs(gap) > resolution, gap, 0.0)
    row, every = count_up(len(gap), gap)[:, None], count_up(gap.shape[1], gap)
    # What counts is the last height at which the two were apart.
    last = running_maximum(xp.where(decided != 0, row, 0))[:-1]
    here = where_true((decided[last, every] * decided[1:] < 0).reshape(-1))
    pair = here % gap.shape[1]
    rows = stacked([last.reshape(-1)[here], here // gap.shape[1] + 1])
    heights, gaps = height[rows, pair], gap[rows, pair]
    third = between(xp.where(rows[0] > 0, rows[0] - 1, rows[1] + 1), 0, len(gap) - 1)
    part = _zero(heights, gaps, height[third, pair], gap[third, pair])
    return Changes(take(pairs, pair), heights, gaps, part)


def _zero(height: Any, gap: Any, third_height: Any, third_gap: Any) -> Any:
    """Where between two heights (2, Q) a parabola is zero, as a share (Q,) of the way.

    It runs through the gaps (2, Q) there, which differ in sign, and that at a third height (Q,).
    A line takes its place where the third height is one of the two.
    """
    xp = namespace(gap)
    u, rise = (third_height - height[0]) / (height[1] - height[0]), gap[1] - gap[0]
    bend = (third_gap - gap[0] - rise * u) / (u * (u - 1))
    slope = rise - bend
    root = xp.sqrt(slope * slope - 4 * bend * gap[0])
    part = 2 * gap[0] / (xp.sign(gap[0]) * root - slope)
    return xp.where((part > 0) & (part < 1), part, -gap[0] / rise)


def _may_dip(gap: Any, resolution: float) -> Any:
    """Which gaps (H, P) of one sign may change sign twice between two of their heights."""
    xp = namespace(gap)
    gap = gap * xp.sign(gap.sum(0))
    rise = gap[1:] - gap[:-1]
    bend = rise[1:] - rise[:-1]
    slope = (gap[2:] - gap[:-2]) / 2
    # The vertex of the parabola through three values, and what a cubic may differ from it.
    vertex = gap[1:-1] - slope * slope / (2 * bend)
    doubt = abs(bend[1:] - bend[:-1]).sum(0) / 4
    return ((bend > resolution) & (abs(slope) <= bend) & (vertex < doubt)).any(0)


def _dips(lines: Climbers, pairs: Any, height: Any, gap: Any) -> tuple[Any, Any]:
    """The least gap of each pair (2, P), between one on either side: heights and gaps (3, P)."""
    xp = namespace(gap)
    every = count_up(len(pairs[0]), pairs)
    side = xp.sign(gap.sum(0))
    # In the angle, of which the height is the cosine, arcs that turn at a level are smooth.
    middle = between(integers((gap * side).argmin(0)), 1, len(gap) - 2)
    bottom, tall = height[0], height[-1] - height[0]
    step = math.pi / (len(gap) - 1)
    angles = [(middle + i) * step for i in (-1, 0, 1)]
    values = [gap[middle + i, every] * side for i in (-1, 0, 1)]

    def level(angle: Any) -> Any:
        return bottom + tall * (1 - xp.cos(angle)) / 2

    ends, sides = angles[::2], values[::2]
    for _ in range(DIPS):
        (a, b, c), (low, mid, high) = angles, values
        rise, fall = (high - mid) * (b - a), (low - mid) * (c - b)
        # A dip is convex, so it lies above the lines through its middle and either end.
        least = mid - xp.maximum(rise / (c - b), fall / (b - a))
        # End if the sign of every least gap is known.
        if ((mid < 0) | (least > 0)).all():
            break
        vertex = b + (fall * (c - b) - rise * (b - a)) / (2 * (rise + fall))
        vertex = between(xp.where(xp.isfinite(vertex), vertex, b), a, c)
        value = _gaps(lines, pairs, level(vertex)[None])[0] * side
        better = value < mid
        # The better of the two is the new middle, and the other one a new end.
        inner, worse = xp.where(better, vertex, b), xp.where(better, b, vertex)
        kept, lost = xp.where(better, value, mid), xp.where(better, mid, value)
        left = worse < inner
        angles = [xp.where(left, worse, a), inner, xp.where(left, c, worse)]
        values = [xp.where(left, lost, low), kept, xp.where(left, high, lost)]
    # The gap may be below zero at both ends of the narrowed range, so the first ends are returned.
    angles, values = [ends[0], angles[1], ends[1]], [sides[0], values[1], sides[1]]
    return stacked([level(angle) for angle in angles]), stacked(values) * side


def _meet(lines: Climbers, changes: Changes, resolution: float) -> Any:
    """Parameters (2, Q) at which the pairs meet, each between its two heights."""
    pairs, height, gap, part = changes
    xp = namespace(gap)
    first = height[0] + (height[1] - height[0]) * part
    curves, about = (take(values, pairs.reshape(-1)) for values in lines)
    t = reach(curves[:, 1], about, xp.concatenate([first, first])).reshape(2, -1)
    # (4, 2, 2, Q): coefficients of x and y of the first and the second arc.
    cubics = curves.reshape(4, 2, 2, -1)
    for rounds in range(NEWTON + 1):
        place = evaluate(cubics, t)
        away = place[:, 1] - place[:, 0]
        met = abs(away[0]) + abs(away[1]) <= resolution
        if rounds == NEWTON or met.all():
            break
        along = evaluate_slope(cubics, t)
        # Each arc's step is measured by the direction of the other one.
        across = away[0] * along[1] - away[1] * along[0]
        turn = along[0, 0] * along[1, 1] - along[0, 1] * along[1, 0]
        step = stacked([across[1], across[0]]) / turn
        t = t + xp.where(xp.isfinite(step), step, 0.0)
    middle = (height[0] + height[1]) / 2
    slack = (height[1] - height[0]) * (0.5 + 1e-9) + resolution
    # Beyond its ends a cubic may return to these heights, and may cross the other one again.
    start, end = about[:2].reshape(2, 2, -1)
    on_arcs = ((t >= start - SAME) & (t <= end + SAME)).all(0)
    rest = where_true(~(met & on_arcs & (abs(place[1, 0] - middle) <= slack)))
    if len(rest):
        some = Changes(*(take(values, rest) for values in changes))
        t[:, rest] = _enclose(lines, some, resolution)
    return t


def _enclose(lines: Climbers, changes: Changes, resolution: float) -> Any:
    """As :func:`_meet`, by the rule of false position, with the weights of the Illinois variant."""
    pairs, (low, high), (below, above), _ = changes
    xp = namespace(below)
    held = xp.zeros_like(below)
    for _ in range(ENCLOSURES):
        middle = high - (high - low) * above / (above - below)
        gap = _gaps(lines, pairs, middle[None])[0]
        if (abs(gap) <= resolution).all():
            break
        side = xp.sign(gap * above)
        # An end that stays twice loses half of its weight.
        half = xp.where(side == held, 0.5, 1.0)
        upper, held = side > 0, side
        low, high = xp.where(upper, low, middle), xp.where(upper, middle, high)
        below, above = xp.where(upper, below * half, gap), xp.where(upper, gap, above * half)
    return lines.at(pairs.reshape(-1), xp.concatenate([middle, middle])).reshape(2, -1)
