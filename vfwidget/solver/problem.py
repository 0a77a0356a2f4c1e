"""The data of a solve: the problem, the requests of the iteration, and its state."""

from __future__ import annotations

import math
import sys
from collections.abc import Generator
from dataclasses import dataclass
from enum import Enum
from numbers import Integral, Real
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from ..arrays import Array, IntArray
from ..errors import SolveError
from ..limits import limits
from .loss import rescale, robust_cost
from .model import Model
from .status import Outcome


def is_number(value: object) -> bool:
    """Whether a value is a real number of Python or NumPy; True and False are not.

    An integer beyond the range of floating-point numbers is none either.
    """
    # The first test is much the faster, and nearly always enough.
    if type(value) is float:
        return True
    if isinstance(value, Integral):
        return not isinstance(value, bool) and abs(int(value)) <= sys.float_info.max
    return isinstance(value, Real)


def is_count(value: object) -> bool:
    """Whether a value is a whole number ≥ 0."""
    whole = type(value) is int or (isinstance(value, Integral) and not isinstance(value, bool))
    return whole and int(value) >= 0  # type: ignore[call-overload]


def products(residuals: int, unknowns: int) -> int:
    """The multiplications of a step of the solver."""
    return residuals * unknowns * min(residuals, unknowns)


def check_size(residuals: int, unknowns: int) -> None:
    """Refuse a solve whose steps would take too much time and memory.

    Raises
    ------
    SolveError
        Residuals × unknowns × the smaller of both exceed ``limits.step_products``.
    """
    needed = products(residuals, unknowns)
    if needed > limits.step_products:
        raise SolveError(
            f"This solve is too large: a step with {residuals:,} residuals and {unknowns:,} "
            f"unknowns takes {needed:,} multiplications, and the limit is "
            f"{limits.step_products:,}. Use fewer terms or pixels, or fewer unknowns, for example "
            "letters that share their axes; or raise vf.limits.step_products."
        )


def read_limit(name: str, value: Any) -> float:
    """A limit at which a solve ends, given by the user.

    Raises
    ------
    SolveError
        It is not a finite number ≥ 0.
    """
    if not (is_number(value) and 0 <= value < math.inf):
        raise SolveError(f"{name} must be a finite number ≥ 0; received {value!r}.")
    return float(value)


class Kind(str, Enum):
    """What the solver requests from the caller.

    ``RENEW`` asks for the residual after the caller has updated what it depends on, such as the
    contacts between shapes. The residual may then have another length. It stays valid, together
    with its Jacobian, until the next such request.
    """

    RESIDUAL = "residual"
    JACOBIAN = "jacobian"
    RENEW = "renew"


Request: TypeAlias = tuple[Kind, Array]
"""A request to evaluate the function of this kind at x, (n,)."""
Requests: TypeAlias = Generator[Request, Array, Any]
"""A computation that yields requests, receives the values, and returns a result."""


class Tolerances(NamedTuple):
    """The limits at which a solve ends; :func:`vfwidget.least_squares` explains each."""

    relative_cost: float = 1e-12
    absolute_cost: float = 0.0
    step: float = 1e-10
    gradient: float = 1e-10
    cost_floor: float = 0.0

    def least_decrease(self, cost: float) -> float:
        """The decrease of this cost below which a step is not worth taking."""
        return max(self.relative_cost * cost, self.absolute_cost)


class Proximity(NamedTuple):
    """The term Σ wᵢ (xᵢ − refᵢ)² of the cost.

    Attributes
    ----------
    weights : (n,) array
        w ≥ 0.
    reference : (n,) array
        ref.
    """

    weights: Array
    reference: Array


def pooled(
    weights: Array, reference: Array, owner: IntArray, count: int
) -> tuple[Proximity, float]:
    """One square for each unknown in place of several, and what these add to the cost besides.

    It is around their weighted mean.

    Parameters
    ----------
    weights, reference : (m,) arrays
    owner : (m,) int array
        The unknown that each square is of.
    count : int
        The number of unknowns.
    """
    total, mean = np.zeros(count), np.zeros(count)
    np.add.at(total, owner, weights)
    np.add.at(mean, owner, weights * reference)
    np.divide(mean, total, out=mean, where=total > 0)
    away = reference - mean[owner]
    return Proximity(total, mean), float((weights * away).dot(away))


class Problem(NamedTuple):
    """A least-squares problem in n variables; the residual is passed separately.

    Attributes
    ----------
    lower, upper : (n,) arrays
        The bounds; infinite for a variable without one.
    kinks : (n, q) array, optional
        The values of each variable at which the residual may have a kink, padded with infinity.
    scale_by_columns : bool
        Whether the damping of each variable is proportional to its squared column norm.
    accelerate : bool
        Whether steps are corrected by geodesic acceleration.
    loss, loss_scale : str, float
        The robust loss; see :mod:`vfwidget.solver.loss`.
    tolerances : Tolerances
    proximity : Proximity, optional
        Added to the cost without rows in the residual. With few residuals, a step then takes
        time proportional to n.
    constant : float
        Added to the cost.
    renews : bool
        Whether the residual changes between steps: it is renewed at the start and after every
        accepted step (see :class:`Kind`).
    """

    lower: Array
    upper: Array
    kinks: Array | None = None
    scale_by_columns: bool = True
    accelerate: bool = False
    loss: str = "linear"
    loss_scale: float = 1.0
    tolerances: Tolerances = Tolerances()
    proximity: Proximity | None = None
    constant: float = 0.0
    renews: bool = False

    def cost(self, residual: Array, x: Array) -> float:
        """The cost of a residual (m,) at x (n,); infinite if it is not finite."""
        value = robust_cost(residual, self.loss, self.loss_scale) + self.constant
        if self.proximity is not None:
            weights, reference = self.proximity
            away = x - reference
            value = value + (away * weights).dot(away)
        return float(value) if math.isfinite(value) else math.inf

    def model(self, residual: Array, jacobian: Array, x: Array, low: Array, high: Array) -> Model:
        """The linear model at x for steps between low and high."""
        residual, jacobian = rescale(residual, jacobian, self.loss, self.loss_scale)
        if self.proximity is None:
            weights = pull = np.zeros(len(x))
        else:
            weights, reference = self.proximity
            pull = weights * (x - reference)
        return Model(jacobian, residual, weights, pull, low, high)

    def half_gradient(self, residual: Array, jacobian: Array, x: Array) -> Array:
        """Half the gradient of the cost, (n,)."""
        residual, jacobian = rescale(residual, jacobian, self.loss, self.loss_scale)
        gradient: Array = residual.dot(jacobian)
        if self.proximity is not None:
            gradient += self.proximity.weights * (x - self.proximity.reference)
        return gradient


@dataclass
class State:
    """The current iterate; ``init`` creates it and ``step`` changes it.

    Attributes
    ----------
    x : (n,) array
    residual : (m,) array
    cost : float
    damping, growth : float
        The present damping relative to ``scale``, and the factor by which a rejected step
        multiplies it.
    scale : (n,) array or float
        The largest squared norm of each column so far, or of all columns.
    iterations : int
        The number of accepted steps.
    outcome : Outcome, optional
        How the solve has ended; None until then.
    model : Model, optional
        The linear model at x, which is kept while steps are rejected.
    """

    x: Array
    residual: Array
    cost: float
    damping: float = 0.0
    growth: float = 2.0
    scale: Any = 0.0
    iterations: int = 0
    outcome: Outcome | None = None
    model: Model | None = None
