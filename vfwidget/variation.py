r"""Support functions and scaling factors: from normalized coordinates to delta-set scalars.

A region gives each axis a *support* ``(start, peak, end)``. The support function
:math:`\varphi` is 1 at the peak, falls linearly to 0 at start and end, and is constantly 1
where the axis takes no part. The scalar of a delta set is the product over axes,
:math:`\gamma(w) = \prod_i \varphi_i(w_i)` (paper, Eq. 2), and everything a variable font
moves is affine in those scalars (Eq. 1):

    p(w) = default + deltas · γ(w).

Definitions follow OpenType ("OpenType Font Variations Common Table Formats", algorithm for
interpolation of instance values), which differs from the paper's printed :math:`\varphi` at
``w = peak = end``: there OpenType says 1.

The map has *kinks* at every start, peak and end. Derivatives are taken from the right,
except at the upper end of the axis (w = 1), where only the left exists. The other one-sided
derivative is had by asking a hair to the left; the solver does so.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .arrays import Array, ArrayLike, IntArray, like, namespace, to_array

ON_KINK = 1e-9
"""How close, in normalized units, a coordinate counts as standing on a breakpoint."""


class Regions:
    """The supports of m delta sets over n axes, made ready for evaluation.

    Each support function is held as two lines, ``a + b·w``: one that rises on
    ``(start, peak)`` and one that falls on ``(peak, end)``. An axis that takes no part is a
    rising line of height 1 and slope 0 that never ends, so it needs no case of its own.

    Parameters
    ----------
    support : (m, n, 3) array or tensor
        start, peak, end of each delta set on each axis, in normalized coordinates.
    """

    def __init__(self, support: ArrayLike) -> None:
        support = to_array(support)
        start, peak, end = support[..., 0], support[..., 1], support[..., 2]
        idle = (peak == 0) | (start > peak) | (peak > end) | ((start < 0) & (end > 0))
        rise = np.where(peak > start, peak - start, 1.0)
        fall = np.where(end > peak, end - peak, 1.0)
        self.support = support
        self.breakpoints = [
            np.unique(support[:, axis][~idle[:, axis]]) for axis in range(support.shape[1])
        ]
        """Sorted coordinates at which each axis has a kink."""
        self._start = np.where(idle, -np.inf, start)
        self._peak = np.where(idle, np.inf, peak)
        self._end = np.where(idle, np.inf, end)
        self._rise = np.where(idle, 1.0, -start / rise), np.where(idle, 0.0, 1 / rise)
        self._fall = end / fall, -1 / fall
        # A support that ends (or starts) at its peak drops from 1 to 0 there: at the peak itself
        # it is 1, so there the question is moved a hair to the side on which it has a line.
        cliff, wall = ~idle & (peak == end), ~idle & (peak == start)
        spike = cliff & wall
        self._start = np.where(spike, peak - 2 * ON_KINK, self._start)
        self._rise = np.where(spike, 1.0, self._rise[0]), np.where(spike, 0.0, self._rise[1])
        self._steep = cliff | wall
        self._inside = np.where(cliff, peak - ON_KINK, peak + ON_KINK)
        self._any_steep = bool(self._steep.any())
        self._identity = np.eye(support.shape[1])

    def _pieces(self, w: Any) -> tuple[Any, Any]:
        """φ and its slope for every delta set and axis: two (..., m, n) arrays."""
        xp = namespace(w)
        start, peak, end, rise_a, rise_b, fall_a, fall_b = (
            like(line, w) for line in (self._start, self._peak, self._end, *self._rise, *self._fall)
        )
        w = w[..., None, :]
        v = w + xp.where(w < 1, ON_KINK, -ON_KINK)
        if self._any_steep:
            at_peak = (abs(w - peak) <= ON_KINK) & (like(self._steep, w) > 0)
            v = xp.where(at_peak, like(self._inside, w), v)
        rising = (v > start) & (v < peak)
        falling = (v > peak) & (v < end)
        phi = xp.where(rising, rise_a + rise_b * w, xp.where(falling, fall_a + fall_b * w, 0.0))
        slope = xp.where(rising, rise_b, xp.where(falling, fall_b, 0.0))
        return phi, slope

    def factors(self, w: Any) -> Any:
        """φ of every delta set on every axis, (..., m, n), at w (..., n)."""
        return self._pieces(w)[0]

    def scalars(self, w: Any) -> Any:
        """γ(w) of Eq. 2, (..., m), at normalized coordinates w (..., n); autograd passes."""
        return self._pieces(w)[0].prod(-1)

    def scalars_and_jacobian(self, w: Any) -> tuple[Any, Any]:
        """γ(w), (..., m), and its closed-form derivative ∂γ/∂w, (..., m, n).

        By the product rule each entry is one axis's slope times the other axes' factors.
        """
        xp = namespace(w)
        phi, slope = self._pieces(w)
        own = like(self._identity, w) > 0
        replaced = xp.where(own, slope[..., :, None], phi[..., None, :])
        return phi.prod(-1), replaced.prod(-1)


def merge_regions(supports: list[Array]) -> tuple[Array, list[IntArray]]:
    """Join several (m, n, 3) supports into one without repeats.

    Returns
    -------
    support : (M, n, 3) array
        The distinct regions, in order of first appearance.
    indices : list of (m,) int arrays
        Where each input region is found in ``support``.
    """
    position: dict[bytes, int] = {}
    kept: list[Array] = []
    indices = []
    for support in supports:
        found = []
        for region in support:
            key = region.tobytes()
            if key not in position:
                position[key] = len(kept)
                kept.append(region)
            found.append(position[key])
        indices.append(np.asarray(found, dtype=np.intp))
    n = supports[0].shape[1] if supports else 0
    return np.asarray(kept, dtype=np.float64).reshape(len(kept), n, 3), indices


def selection(indices: IntArray, count: int) -> Array:
    """The (m, count) matrix that spreads m delta sets over merged regions; repeats add up."""
    matrix = np.zeros((len(indices), count))
    matrix[np.arange(len(indices)), indices] = 1
    return matrix
