"""Jacobians of a residual for which the caller gives none."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..arrays import Array, to_array

STEP = float(np.finfo(float).eps ** (1 / 3))
"""The step of a central difference relative to the size of x."""
LEAST_SIZE = 1e-3
"""Near zero, the size of x is this share of its size at the start."""
VISIBLE = 1e4 * float(np.finfo(float).eps)
"""A change of the residual below this share of it is lost in rounding errors."""
WIDER = 10.0
"""The factor by which a step is lengthened if the change is lost."""
ROUNDED = 8 * float(np.finfo(float).eps)
"""A second difference below this share of the residual is a rounding error."""
EVEN = 1e-3
"""A difference is central if x is no farther from its middle than this share of half its width."""


def forward_mode(residual: Callable[[Any], Any], x: Any) -> Any:
    """The Jacobian (…, m, n) at a tensor x (…, n), one directional derivative for each variable.

    Forward mode is chosen because there are few variables and many residuals.
    """
    import torch

    columns = []
    for i in range(x.shape[-1]):
        tangent = torch.zeros_like(x)
        tangent[..., i] = 1
        columns.append(torch.func.jvp(residual, (x,), (tangent,))[1])
    return torch.stack(columns, -1)


class CentralDifferences:
    """The Jacobian (…, m, n) at an array x (…, n) by differences that stay within the bounds.

    Parameters
    ----------
    residual : callable
        x (…, n) to (…, m).
    start : (…, n) array
        Gives the size of variables that come close to zero.
    lower, upper : (…, n) arrays
    kinks : (n, q) array, optional
        A difference does not cross a kink, because it would mix the slopes of both sides.

    Notes
    -----
    A start may lie much closer to zero than the variable will later (1e-12, say). Its difference
    is then lost in the rounding errors of the residual, and is repeated with longer steps.
    """

    def __init__(
        self,
        residual: Callable[[Any], Any],
        start: Array,
        lower: Array,
        upper: Array,
        kinks: Array | None,
    ) -> None:
        self._residual, self._lower, self._upper, self._kinks = residual, lower, upper, kinks
        self._sizes = np.where(start != 0, LEAST_SIZE * abs(start), LEAST_SIZE)

    def __call__(self, x: Array) -> Array:
        """The Jacobian at x."""
        left, right = self._lower, self._upper
        if self._kinks is not None:
            gaps = self._kinks - x[..., None]
            left = np.maximum(left, np.where(gaps < 0, self._kinks, -np.inf).max(-1))
            right = np.minimum(right, np.where(gaps > 0, self._kinks, np.inf).min(-1))
        return np.stack([self._column(x, i, left, right) for i in range(x.shape[-1])], axis=-1)

    def _column(self, x: Array, i: int, left: Array, right: Array) -> Array:
        """The derivative (…, m) by variable i."""
        best: Array | None = None
        while True:
            size = np.maximum(self._sizes[..., i], abs(x[..., i]))
            before, after = x.copy(), x.copy()
            before[..., i] = np.maximum(x[..., i] - STEP * size, left[..., i])
            after[..., i] = np.minimum(x[..., i] + STEP * size, right[..., i])
            width = (after - before)[..., i, None]
            high, low = to_array(self._residual(after)), to_array(self._residual(before))
            slope: Array = (high - low) / np.where(width > 0, width, 1)
            middle = (before + after) / 2
            aside = 2 * (x - middle)[..., i, None]
            if abs(aside).max() > EVEN * width.max():
                # The slope is that in the middle. A parabola gives the one at x.
                bend = high - 2 * to_array(self._residual(middle)) + low
                bend = np.where(abs(bend) > ROUNDED * (abs(high) + abs(low)), bend, 0.0)
                slope = slope + 2 * bend * aside / np.where(width > 0, width, 1) ** 2
            if best is not None and not np.isfinite(slope).all():
                # The residual ends within the longer step.
                return best
            best = slope
            lost = abs(high - low).max(-1, initial=0.0) <= VISIBLE * abs(high).max(-1, initial=0.0)
            lost &= size < LEAST_SIZE
            if not lost.any():
                return slope
            self._sizes[..., i] = np.where(lost, WIDER * size, self._sizes[..., i])
