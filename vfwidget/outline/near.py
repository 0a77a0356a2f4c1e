"""Pairs of boxes that overlap, found without comparing every box with every other one.

The boxes are sorted by their left sides, so that the boxes that begin within another one follow it.
Where most of those lie above or below it, the boxes are listed by horizontal bands, each about as
tall as a box is on average. A few boxes are compared with one another directly, which is quicker.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ..arrays import (
    between,
    count_up,
    expand,
    integers,
    namespace,
    stacked,
    take,
    where_true,
)
from ..errors import OverlapError
from ..limits import limits

FEW = 40
"""So many boxes, or fewer, are compared directly."""
CROWDED = 64
"""Mean number of boxes above or below a box from which on bands are worth their cost."""
BLOCK = 2**20
"""Candidates that are compared at a time, so that the memory does not grow with their number."""


def near_pairs(low: Any, high: Any, group: Any) -> tuple[Any, Any, Any]:
    """The pairs of boxes of the same group that overlap.

    Parameters
    ----------
    low, high : (2, N) arrays
        The lower left and upper right corners.
    group : (N,) int array
        From 0; boxes of different groups do not count as near.

    Returns
    -------
    pairs : (2, P) int array
    bottom, top : (P,) arrays
        The heights between which both boxes lie.

    Raises
    ------
    OverlapError
        There are more than ``limits.curve_pairs`` pairs for each group.
    """
    xp = namespace(low)
    groups = int(group.max()) + 1 if len(group) else 1
    candidates = _compared if len(group) <= FEW else _swept
    found, total = [], 0
    for one, other in candidates(low, high, group):
        bottom = xp.maximum(take(low[1], one), take(low[1], other))
        top = xp.minimum(take(high[1], one), take(high[1], other))
        meet = where_true(bottom < top)
        total += len(meet)
        check_pairs(total, groups)
        pairs = stacked([take(one, meet), take(other, meet)])
        found.append((pairs, take(bottom, meet), take(top, meet)))
    if len(found) == 1:
        return found[0]
    pairs, bottom, top = (xp.concatenate(parts, -1) for parts in zip(*found, strict=True))
    return pairs, bottom, top


def check_pairs(count: float, images: int) -> None:
    """Refuse curves that are near each other in more pairs than ``limits.curve_pairs`` an image.

    Raises
    ------
    OverlapError
        There are too many.
    """
    if count > limits.curve_pairs * images:
        raise OverlapError(
            f"At least {count:,.0f} pairs of curves are near enough to cross, and at most "
            f"{limits.curve_pairs * images:,} are compared; simplify the outlines or raise "
            "vf.limits.curve_pairs."
        )


def _compared(low: Any, high: Any, group: Any) -> Iterator[tuple[Any, Any]]:
    """The pairs of boxes of the same group that overlap from left to right."""
    count, index = len(group), count_up(len(group), group)
    begins_before = low[0][:, None] < high[0]
    meet = begins_before & begins_before.T & (group[:, None] == group) & (index[:, None] < index)
    meet = where_true(meet.reshape(-1))
    yield meet // max(count, 1), meet % max(count, 1)


def _swept(low: Any, high: Any, group: Any) -> Iterator[tuple[Any, Any]]:
    """As :func:`_compared`, a block at a time; each of them may be above or below the other one."""
    xp = namespace(low)
    box, after, counts = _sweep(low[0], high[0], group)
    candidates, band = int(counts.sum()), None
    if candidates > CROWDED * len(group):
        bands, listed, band, first = _bands(low[1], high[1])
        key = take(group, listed) * bands + band
        order, after, counts = _sweep(take(low[0], listed), take(high[0], listed), key)
        box, band = take(listed, order), take(band, order)
        candidates = int(counts.sum())
    for block in _blocks(counts, candidates):
        at, other = expand(after[block], counts[block])
        one, other = take(box[block], at), take(box, other)
        if band is not None:
            # Two boxes may share several bands, and count in the lowest of them.
            lowest = xp.maximum(take(first, one), take(first, other))
            once = where_true(lowest == take(band[block], at))
            one, other = take(one, once), take(other, once)
        yield one, other


def _sweep(left: Any, right: Any, key: Any) -> tuple[Any, Any, Any]:
    """The order of boxes, and for each the next place and how many there begin within it."""
    # One after the other from left to right, and one key to the right of the other.
    if key.any():
        shift = key * (1 + right.max() - left.min())
        left, right = left + shift, right + shift
    order = left.argsort()
    left, right = take(left, order), take(right, order)
    after = count_up(len(order), order) + 1
    xp = namespace(left)
    # A box without width begins where it ends, and nothing follows within it.
    counts = xp.maximum(xp.searchsorted(left, right), after) - after
    return order, after, counts


def _bands(low: Any, high: Any) -> tuple[int, Any, Any, Any]:
    """How many bands, the boxes and bands of all that touch, and the lowest band of each box."""
    base, height = low.min(), float(high.max() - low.min())
    most = 1 + len(low) // CROWDED
    bands = int(min(most, 1 + height * len(low) / max(float((high - low).sum()), 1e-300)))
    scale = bands / (height or 1.0)
    first, last = (
        integers(between((level - base) * scale, 0.0, bands - 1.0)) for level in (low, high)
    )
    return bands, *expand(first, last - first + 1), first


def _blocks(counts: Any, total: int) -> Iterator[slice]:
    """Slices with about :data:`BLOCK` of all candidates each."""
    if total <= BLOCK:
        yield slice(0, len(counts))
        return
    ends = counts.cumsum(0)
    start, done = 0, 0
    while start < len(counts):
        stop = start + 1 + int((ends[start + 1 :] <= done + BLOCK).sum())
        yield slice(start, stop)
        start, done = stop, ends[stop - 1]
