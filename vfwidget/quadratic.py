"""A convex quadratic over a box: the step of a bounded solver."""

from __future__ import annotations

import numpy as np

from .arrays import Array


def minimise_quadratic(system: Array, gradient: Array, low: Array, high: Array) -> Array:
    """Minimise ½ dᵀ A d + gᵀ d over low ≤ d ≤ high, where low ≤ 0 ≤ high.

    Parameters
    ----------
    system : (n, n) array
        A, symmetric positive definite.
    gradient, low, high : (n,) arrays

    Returns
    -------
    (n,) array

    Notes
    -----
    Projected Newton (Bertsekas 1982): variables at a bound that the gradient holds there are
    fixed, the others take the Newton step of their own system, clipped to the box and halved
    until the quadratic falls enough. The set of fixed variables settles in a few rounds.
    """
    d = np.zeros_like(gradient)
    slope = gradient
    small = 1e-13 * (np.abs(gradient).max() if len(gradient) else 0.0)
    for _ in range(10 + 4 * len(d)):
        fixed = ((d <= low) & (slope >= 0)) | ((d >= high) & (slope <= 0))
        free = np.flatnonzero(~fixed)
        if not len(free) or np.abs(slope[free]).max() <= small:
            break
        newton = np.zeros_like(d)
        newton[free] = -np.linalg.solve(system[np.ix_(free, free)], slope[free])
        length = 1.0
        while True:
            new = np.minimum(np.maximum(d + length * newton, low), high)
            change = new - d
            if change @ slope + 0.5 * change @ system @ change <= 0.1 * (change @ slope):
                break
            length /= 2
            if length < 1e-9:
                return d
        d = new
        slope = gradient + system @ d
        if length == 1.0 and len(free) == len(d) and (d > low).all() and (d < high).all():
            break
    return d
