"""Convex quadratics over boxes: the step of a bounded solver."""

from __future__ import annotations

from typing import Any

from ..arrays import like, namespace

HALVINGS = 30
SUFFICIENT = 0.1
"""Share of the linear decrease that a step along the projected path must achieve."""


def minimise_quadratic(system: Any, gradient: Any, low: Any, high: Any) -> Any:
    """Minimise ½ dᵀ A d + gᵀ d over low ≤ d ≤ high, where low ≤ 0 ≤ high; many at once.

    Parameters
    ----------
    system : (..., n, n) array or tensor
        A, symmetric positive definite.
    gradient, low, high : (..., n) arrays or tensors

    Returns
    -------
    (..., n) array or tensor

    Notes
    -----
    Projected Newton (Bertsekas 1982; Tassa, Mansard and Todorov 2014): variables at a bound that
    the slope holds there are fixed, the others take the Newton step of their own system, clipped
    to the box and halved until the quadratic falls enough. The set of fixed variables settles in
    a few rounds.
    """
    xp = namespace(gradient)
    n = gradient.shape[-1]
    identity = like(xp.eye(n), gradient)
    d = xp.zeros_like(gradient)
    slope = gradient
    small = 1e-13 * xp.amax(abs(gradient), -1)[..., None]
    for _ in range(10 + 4 * n):
        free = ~(((d <= low) & (slope >= 0)) | ((d >= high) & (slope <= 0)))
        if not (free & (abs(slope) > small)).any():
            break
        own = xp.where(free[..., :, None] & free[..., None, :], system, identity)
        newton = -xp.linalg.solve(own, xp.where(free, slope, 0.0)[..., None])[..., 0]
        length: Any = 1.0
        for _ in range(HALVINGS):
            new = xp.clip(d + length * newton, low, high)
            change = new - d
            linear = (change * slope).sum(-1)[..., None]
            bent = (change * (system @ change[..., None])[..., 0]).sum(-1)[..., None]
            poor = linear + bent / 2 > SUFFICIENT * linear
            if not poor.any():
                break
            length = xp.where(poor, length / 2, length)
        d = new
        slope = gradient + (system @ d[..., None])[..., 0]
    return d
