r"""Robust losses: how much a large residual counts.

A loss ρ replaces the square: the cost is :math:`\sum_i s^2 \rho((r_i/s)^2)`, with ρ(z) = z for
least squares, so that residuals far beyond the scale s, outliers, pull less. The solver sees a
rescaled residual and Jacobian whose Gauss–Newton model has the loss's gradient and, as far as it
stays convex, its curvature (Triggs, McLauchlan, Hartley and Fitzgibbon 2000, Sec. 4.3).
"""

from __future__ import annotations

from typing import Any

from ..arrays import namespace
from ..errors import SolveError

LOSSES = ("linear", "soft_l1", "huber", "cauchy", "arctan")
LEAST_WEIGHT = 1e-10
TINY = 1e-6
"""A residual, relative to the scale, that every loss takes as it is."""


def rho(z: Any, loss: str) -> tuple[Any, Any, Any]:
    """ρ(z) and its first two derivatives, for z = (r/s)² ≥ 0.

    Raises
    ------
    SolveError
        No such loss.
    """
    xp = namespace(z)
    if loss == "linear":
        return z, 1 + 0 * z, 0 * z
    if loss == "soft_l1":
        root = (1 + z) ** 0.5
        return 2 * (root - 1), 1 / root, -0.5 / root**3
    if loss == "huber":
        near = z <= 1
        far = xp.where(near, 1.0, z)
        return (
            xp.where(near, z, 2 * far**0.5 - 1),
            xp.where(near, 1.0, far**-0.5),
            xp.where(near, 0.0, -0.5 * far**-1.5),
        )
    if loss == "cauchy":
        return xp.log1p(z), 1 / (1 + z), -1 / (1 + z) ** 2
    if loss == "arctan":
        return xp.arctan(z), 1 / (1 + z * z), -2 * z / (1 + z * z) ** 2
    raise SolveError(f"There is no loss {loss!r}: choose one of {', '.join(LOSSES)}.")


def robust_cost(residual: Any, loss: str, scale: float) -> Any:
    """The cost of residuals (m,)."""
    if loss == "linear":
        return residual.dot(residual)
    return scale**2 * rho((residual / scale) ** 2, loss)[0].sum()


def rescale(residual: Any, jacobian: Any, loss: str, scale: float) -> tuple[Any, Any]:
    """Residuals (m,) and Jacobian (m, n) that a least-squares step may take as linear."""
    if loss == "linear":
        return residual, jacobian
    xp = namespace(residual)
    z = (residual / scale) ** 2
    _, first, second = rho(z, loss)
    curvature = xp.clip(first + 2 * second * z, LEAST_WEIGHT, None) ** 0.5
    return residual * first / curvature, jacobian * curvature[..., None]


def signed_root(residual: Any, loss: str, scale: float) -> tuple[Any, Any]:
    """Residuals F (m,) whose squares add up to the robust cost, and their slopes dF/dr (m,).

    With them a robust energy is a sum of squares like every other, and may be added to others.
    """
    if loss == "linear":
        return residual, namespace(residual).ones_like(residual)
    xp = namespace(residual)
    value, first, _ = rho((residual / scale) ** 2, loss)
    size = scale * value**0.5
    near = size < TINY * scale
    slope = xp.where(near, 1.0, first * abs(residual) / xp.where(near, 1.0, size))
    return xp.where(near, residual, xp.copysign(size, residual)), slope
