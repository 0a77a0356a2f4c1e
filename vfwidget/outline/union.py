"""Outlines without overlaps: the boundary of a shape as closed contours of its own."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ..arrays import Array, IntArray
from .area import areas
from .arrangement import Spans, boundary, nonzero
from .contours import Contours
from .monotone import coefficients
from .near import near_pairs

SHORT = 1e-9
"""Parts shorter than this, relative to the size of the outline, are left out."""
WIDER = 100
"""Factor of the distance within which the next part is searched, if none is found."""


def odd(winding: Any) -> Any:
    """Where the winding number (1, N) is odd: the even-odd rule."""
    return winding[0] % 2 == 1


def without_overlaps(
    segments: Array,
    sizes: Sequence[int],
    inside: Callable[[Any], Any] = nonzero,
    image: IntArray | None = None,
    layer: IntArray | None = None,
) -> list[Array]:
    """The boundary of a shape as closed contours that neither cross nor overlap.

    Parameters
    ----------
    segments : (S, 4, 2) array
        Cubic segments of closed contours, contour after contour.
    sizes : sequence of int
        Segments of each contour.
    inside : callable
        From winding numbers (G, N) to whether a point is in the shape, (N,).
    image, layer : (S,) int arrays, optional
        As for :func:`~.arrangement.boundary`. Each image is a shape of its own.

    Returns
    -------
    list of (s, 4, 2) arrays
        The shape is on the right of each contour (y up), as in TrueType fonts.

    Raises
    ------
    OverlapError
        Too many curves cross or lie side by side, by ``limits.curve_pairs``.
    """
    if not len(segments):
        return []
    if image is None:
        image = np.zeros(len(segments), dtype=np.intp)
    spans = boundary(coefficients(segments), sizes, image, inside, layer)
    kept = np.flatnonzero(spans.weight)
    parts = _parts(segments[spans.cubic[kept]], spans.start[kept], spans.end[kept])
    backwards = spans.weight[kept] < 0
    parts[backwards] = parts[backwards, ::-1]
    short = SHORT * np.ptp(segments, (0, 1)).max()
    long = np.ptp(parts, 1).max(1) > short
    following, image = _next_spans(spans.cubic, sizes), image[spans.cubic[kept]]
    follower = _followers(parts, following, kept, backwards, image)
    contours = [contour for contour in _walk(parts, follower, long) if len(contour)]
    return _with_area(contours, short**2)


def _with_area(contours: list[Array], least: float) -> list[Array]:
    """The contours around more than this area; where outlines cross, rounding leaves others."""
    if not contours:
        return []
    curves = coefficients(np.concatenate(contours) - contours[0][0, 0])
    whole = np.ones(curves.shape[-1])
    parts = areas(curves, Spans(np.arange(len(whole)), 0 * whole, whole, whole))
    ends = np.cumsum([len(contour) for contour in contours])
    kept = abs(np.add.reduceat(parts, np.append(0, ends[:-1]))) > least
    return [contour for contour, keep in zip(contours, kept.tolist(), strict=True) if keep]


def _parts(segments: Array, start: Array, end: Array) -> Array:
    """The control points (N, 4, 2) of segments between two parameters, by polar forms."""
    columns = np.stack([start, end], -1)
    points = []
    for ends in range(4):
        blend = segments
        for step in range(3):
            t = columns[:, 1 if step < ends else 0, None, None]
            blend = blend[:, :-1] * (1 - t) + blend[:, 1:] * t
        points.append(blend[:, 0])
    return np.stack(points, 1)


def _next_spans(cubic: Any, sizes: Sequence[int]) -> Any:
    """The span that continues each span along its contour, (N,)."""
    owner = Contours(sizes).owners[cubic]
    following = np.arange(1, len(cubic) + 1)
    last = np.flatnonzero(np.append(owner[1:] != owner[:-1], True))
    first = np.append(0, last[:-1] + 1)
    following[last] = first
    return following


def _followers(parts: Array, following: Any, kept: Any, backwards: Any, image: IntArray) -> Any:
    """The part that each part continues with: along its contour, or where contours cross."""
    place = np.full(len(following), -1)
    place[kept] = np.arange(len(kept))
    follower = np.full(len(kept), -1)
    # A part and the next one of its contour, if both bound the shape on the same side.
    after = place[following[kept]]
    joined = np.flatnonzero(after >= 0)
    joined = joined[backwards[joined] == backwards[after[joined]]]
    one, other = joined, after[joined]
    turned = backwards[one]
    follower[np.where(turned, other, one)] = np.where(turned, one, other)
    ends = np.flatnonzero(follower < 0)
    starts = np.setdiff1d(np.arange(len(kept)), follower)
    # Where contours cross, an end continues with the nearest start.
    nearest = _matched(parts[ends, 3], parts[starts, 0], image[ends], image[starts])
    follower[ends] = starts[nearest]
    return follower


def _matched(ends: Array, starts: Array, image: IntArray, image_of_start: IntArray) -> IntArray:
    """For each end (n, 2) one start (n, 2) of the same image; the nearest pairs come first."""
    match = np.full(len(ends), -1)
    left, free = np.arange(len(ends)), np.arange(len(starts))
    distance = SHORT * float(np.ptp(ends, 0).max()) if len(ends) else 0.0
    distance = distance or 1.0
    while len(left):
        points = np.concatenate([ends[left], starts[free]]).T
        images = np.concatenate([image[left], image_of_start[free]])
        pairs, *_ = near_pairs(points - distance / 2, points + distance / 2, images)
        pairs = np.sort(pairs, 0)
        one, other = pairs[:, (pairs[0] < len(left)) & (pairs[1] >= len(left))]
        one, other = left[one], free[other - len(left)]
        gap = np.hypot(*(ends[one] - starts[other]).T)
        taken = np.zeros(len(starts), dtype=bool)
        for i in np.argsort(gap, kind="stable")[: int((gap <= distance).sum())]:
            if match[one[i]] < 0 and not taken[other[i]]:
                match[one[i]] = other[i]
                taken[other[i]] = True
        left, free = left[match[left] < 0], free[~taken[free]]
        distance *= WIDER
    return match


def _walk(parts: Array, follower: Any, long: Any) -> list[Array]:
    """Contours from parts (N, 4, 2) that continue with their followers."""
    contours, seen = [], np.zeros(len(parts), dtype=bool)
    for first in range(len(parts)):
        chain = []
        at = first
        while not seen[at]:
            seen[at] = True
            if long[at]:
                chain.append(at)
            at = follower[at]
        contour = parts[chain]
        # The ends of two parts that meet at a crossing differ by rounding.
        contour[:, 3] = np.roll(contour[:, 0], -1, 0)
        contours.append(contour)
    return contours
