"""Cubic Béziers: evaluate, bound and find the nearest point. Arrays (..., 4, 2)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..arrays import Array

if TYPE_CHECKING:
    import torch

SAMPLES = 16
"""Parameters tried on each segment before the nearest is refined."""
REFINEMENTS = 24


AREA = np.array([[-10, 6, 3, 1], [-6, 0, 3, 3], [-3, -3, 0, 6], [-1, -3, -6, 10]]) / 20
"""∫ x dy along a cubic is xᵀ AREA y: the integrals of Bᵢ Bⱼ′ over 0 … 1."""


def bernstein(t: float | Array) -> Array:
    """The four weights of a cubic's control points at parameters t (…) in 0 … 1: (4, …)."""
    u = 1 - t
    return np.array([u * u * u, 3 * u * u * t, 3 * u * t * t, t * t * t])


def chord(start: Array, end: Array) -> Array:
    """Straight lines (..., 4, 2) between points (..., 2) as cubics."""
    return np.stack([start, (2 * start + end) / 3, (start + 2 * end) / 3, end], -2)


def nearest(segments: Array, point: Array) -> tuple[int, float]:
    """The segment and parameter whose point lies nearest.

    Parameters
    ----------
    segments : (s, 4, 2) array
    point : (2,) array

    Returns
    -------
    index : int
    t : float

    Notes
    -----
    Every segment is sampled; then the best sample of each is refined by a ternary search between
    its neighbours, all segments at once. It needs no derivative, so cusps and segments of zero
    length do it no harm.
    """
    t = np.linspace(0, 1, SAMPLES + 1)
    best = _distance(segments, np.broadcast_to(t, (len(segments), len(t))), point).argmin(1)
    low, high = t[np.maximum(best - 1, 0)], t[np.minimum(best + 1, SAMPLES)]
    for _ in range(REFINEMENTS):
        thirds = np.stack([low + (high - low) / 3, high - (high - low) / 3], axis=1)
        left, right = _distance(segments, thirds, point).T
        low, high = (
            np.where(left > right, thirds[:, 0], low),
            np.where(left > right, high, thirds[:, 1]),
        )
    # An end of the bracket may be an end of the segment, which the search only approaches.
    candidates = np.stack([low, (low + high) / 2, high], axis=1)
    distance = _distance(segments, candidates, point)
    index, choice = np.unravel_index(distance.argmin(), distance.shape)
    return int(index), float(candidates[index, choice])


def _distance(segments: Array, t: Array, point: Array) -> Array:
    """Squared distance to ``point`` at parameters t (s, j) of each segment, (s, j)."""
    u = 1 - t
    weights = np.stack([u**3, 3 * u * u * t, 3 * u * t * t, t**3], axis=-1)
    offset = weights @ segments - point
    return (offset * offset).sum(-1)


def x_extent(contours: Sequence[torch.Tensor]) -> tuple[torch.Tensor, torch.Tensor]:
    """Least and greatest x over contours (..., s, 4, 2): two (...) tensors, differentiable.

    A cubic's extreme lies at an end or where its derivative, a quadratic, vanishes.
    """
    import torch

    x = torch.cat(list(contours), -3)[..., 0]
    p0, p1, p2, p3 = x.unbind(-1)
    a, b, c = p3 - 3 * p2 + 3 * p1 - p0, p2 - 2 * p1 + p0, p1 - p0
    # Roots of a t² + 2 b t + c, in the form that survives a = 0. At an extreme the value does not
    # depend on t to first order, so t needs no gradient.
    with torch.no_grad():
        q = -(b + torch.where(b < 0, -1.0, 1.0) * (b * b - a * c).clip(0).sqrt())
        roots = [q / torch.where(a == 0, 1.0, a), c / torch.where(q == 0, 1.0, q)]
        t = torch.stack([*roots, torch.zeros_like(a)]).clip(0, 1)
    u = 1 - t
    values = u**3 * p0 + 3 * u * u * t * p1 + 3 * u * t * t * p2 + t**3 * p3
    return values.amin((0, -1)), values.amax((0, -1))
