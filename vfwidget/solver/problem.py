"""The data of a solve: the problem, its linear model, and the state of the iteration."""

from __future__ import annotations

import math
from collections.abc import Generator
from dataclasses import dataclass, field
from enum import Enum
from typing import Any, NamedTuple, TypeAlias

from ..arrays import Array
from .loss import robust_cost


class Kind(Enum):
    """The function that the solver needs evaluated."""

    RESIDUAL = "residual"
    JACOBIAN = "jacobian"


class Request(NamedTuple):
    """A request to evaluate the residual or the Jacobian at x, (n,)."""

    kind: Kind
    x: Array


Requests: TypeAlias = Generator[Request, Array, Any]
"""A computation that yields requests, receives the values, and returns a result."""


@dataclass(frozen=True)
class Tolerances:
    """The limits at which a solve ends; :func:`vfwidget.least_squares` explains each."""

    cost: float = 1e-12
    step: float = 1e-10
    gain: float = 0.0
    gradient: float = 1e-10
    zero: float = 0.0


@dataclass(frozen=True)
class Problem:
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
    """

    lower: Array
    upper: Array
    kinks: Array | None = None
    scale_by_columns: bool = True
    accelerate: bool = False
    loss: str = "linear"
    loss_scale: float = 1.0
    tolerances: Tolerances = field(default_factory=Tolerances)

    def cost(self, residual: Array) -> float:
        """The cost of a residual (m,); infinite if a value is not finite."""
        value = float(robust_cost(residual, self.loss, self.loss_scale))
        return value if math.isfinite(value) else math.inf


class Model(NamedTuple):
    """The linear model of the residual at an iterate.

    Attributes
    ----------
    jacobian : (m, n) array
        Each column belongs to the side of a kink to which the model applies.
    gradient : (n,) array
        Half the gradient of the cost.
    normal : (n, n) array
        JᵀJ.
    columns : (n,) array
        The squared column norms of the Jacobian.
    unit : float
        The unit of the damping.
    low, high : (n,) arrays
        The range of a step: low ≤ 0 ≤ high.
    """

    jacobian: Array
    gradient: Array
    normal: Array
    columns: Array
    unit: float
    low: Array
    high: Array


@dataclass
class State:
    """The current iterate; ``init`` creates it and ``step`` changes it.

    Attributes
    ----------
    x : (n,) array
        The best point so far.
    residual : (m,) array
    cost : float
    damping, growth : float
        The present damping, and the factor by which a rejected step multiplies it.
    scale : (n,) array or 0
        The largest squared norm of each column so far, by which the damping is scaled.
    iterations : int
        The number of accepted steps.
    reason : str
        The reason why the solve has ended; empty until then.
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
    reason: str = ""
    model: Model | None = None
