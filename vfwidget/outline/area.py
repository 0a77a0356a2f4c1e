r"""Exact area of what weighted parts of cubics bound, and its exact derivative.

With the shape on the right of the parts, its area is :math:`\int y\,dx`. Moving the boundary by δ
sweeps over area: the derivative is :math:`\int \delta_y\,dx - \delta_x\,dy` (Reynolds' transport
theorem). For δ a combination of Bernstein polynomials both are integrals of polynomials. Per cubic
they are fixed combinations of :math:`t_b^k - t_a^k`, k = 1 … 6, where t_a and t_b are the ends of a
part.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..arrays import like, namespace, stacked, sum_runs, take
from .arrangement import Spans
from .monotone import POWER

SLOPE = np.array([1.0, 2, 3])[:, None, None]
"""Factors of the coefficients of t, t², t³ in a derivative."""
ORDERS = np.arange(1.0, 7)
"""Divisors of the powers in an antiderivative."""
PRODUCT = (np.add.outer(range(4), range(3)).ravel() == np.arange(6)[:, None]) / ORDERS[:, None]
"""From products of two polynomials' coefficients to the antiderivative of their product."""


def weighted_powers(start: Any, end: Any, weight: Any) -> Any:
    """(end^k - start^k) · weight for k = 1 … 6, of N parts: (6, N)."""
    total, product = start + end, start * end
    powers = [(end - start) * weight]
    powers.append(total * powers[0])
    while len(powers) < len(ORDERS):
        # At both ends t² = total · t - product.
        powers.append(total * powers[-1] - product * powers[-2])
    return stacked(powers)


def antiderivative(first: Any, second: Any) -> Any:
    """The antiderivative, t to t⁶ (6, …), of the product of polynomials (4, …) and (3, …)."""
    both = first[:, None] * second
    return (like(PRODUCT, both) @ both.reshape(12, -1)).reshape(6, *both.shape[2:])


def slopes(curves: Any) -> Any:
    """Coefficients of 1, t, t² of the derivatives of curves (4, 2, C): (3, 2, C)."""
    return curves[1:] * like(SLOPE, curves)


def areas(curves: Any, spans: Spans) -> Any:
    """What each span (N,) of curves (4, 2, C) adds to the area of the shape that they bound."""
    powers = weighted_powers(spans.start, spans.end, spans.weight)
    integral = antiderivative(curves[:, 1], slopes(curves)[:, 0])
    return namespace(curves).einsum("kn,kn->n", powers, take(integral, spans.cubic))


def swept(curves: Any, cubic: Any, powers: Any) -> Any:
    """How weighted area changes with the control points of curves (4, 2, C): (C, 4, 2).

    ``cubic`` (N,), in ascending order, and ``powers`` (6, N) are of the parts of the boundary.
    """
    return swept_by(curves, sum_runs(cubic, powers, curves.shape[-1]))


def swept_by(curves: Any, powers: Any) -> Any:
    """As :func:`swept`, from the sum of the powers for each curve, (6, C)."""
    xp = namespace(curves)
    moments = powers / like(ORDERS[:, None], powers)
    # ∫ tʲ (−y′, x′) dt for j = 0 … 3, from ∫ tᵏ dt for k = 0 … 5.
    windows = stacked([moments[j : j + 3] for j in range(4)])
    along = xp.einsum("jkc,kdc->djc", windows, slopes(curves))
    across = stacked([-along[1], along[0]])
    return xp.einsum("ji,djc->cid", like(POWER, across), across)
