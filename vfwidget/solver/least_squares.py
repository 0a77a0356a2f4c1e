"""Bounded Levenberg–Marquardt for piecewise smooth residuals; it knows nothing of fonts.

:mod:`.levenberg_marquardt` holds the iteration, and names the sources of its method.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, cast

import numpy as np

from ..arrays import Array, ArrayLike, is_tensor, padded_table, to_array
from ..deprecation import renamed
from ..errors import SolveError
from .derivatives import CentralDifferences, forward_mode
from .drivers import Function, History, active_bounds, minimise, minimise_batch, within_bounds
from .loss import LOSSES
from .problem import Problem, State, Tolerances, is_number, read_limit
from .result import Iterate, Result
from .status import CONVERGED, Outcome

__all__ = ["Iterate", "Result", "kink_table", "least_squares"]


@renamed(
    cost_tolerance="relative_cost_tolerance",
    gain_tolerance="absolute_cost_tolerance",
    zero="cost_floor",
)
def least_squares(
    residual: Callable[[Any], Any],
    x0: ArrayLike,
    jacobian: Callable[[Any], Any] | None = None,
    bounds: tuple[ArrayLike, ArrayLike] | None = None,
    *,
    kinks: Sequence[ArrayLike] | None = None,
    scale: str = "columns",
    loss: str = "linear",
    loss_scale: float = 1.0,
    acceleration: bool = False,
    max_iterations: int = 100,
    relative_cost_tolerance: float = 1e-12,
    absolute_cost_tolerance: float = 0.0,
    step_tolerance: float = 1e-10,
    gradient_tolerance: float = 1e-10,
    cost_floor: float = 0.0,
) -> Result:
    """Minimise a sum of squared residuals over a box, for one problem or many at once.

    Parameters
    ----------
    residual : callable
        Maps x (n,) to residuals (m,). In a batch it maps (B, n) to (B, m), and each row depends
        on the same row of x only. It receives float64 tensors on the device of ``x0`` if that is
        a tensor, else float64 arrays.
    x0 : (n,) or (B, n) array or tensor
        The start, or B starts; within the bounds.
    jacobian : callable, optional
        Maps x to the derivative (m, n), or (B, m, n). Default: forward-mode autodiff for tensors,
        central differences for arrays.
    bounds : (lower, upper), optional
        Each is a number, (n,) or (B, n); infinite for a variable without a bound. Default: none.
    kinks : sequence of n arrays, optional
        The values of each variable at which the residual may have a kink. ``jacobian`` is then
        evaluated at a distance of 1e-8 from them, because it has two values on a kink.
    scale : {"columns", "none"}
        ``"columns"``, the default: the damping of each variable is proportional to the largest
        squared norm of its column of the Jacobian so far (Marquardt, Moré), so that the units of
        the variables do not matter. ``"none"``: the damping is equal for all variables, which
        prefers short steps.
    loss : {"linear", "soft_l1", "huber", "cauchy", "arctan"}
        The function of the squared residuals that is summed. All but ``"linear"``, the default,
        reduce the influence of outliers.
    loss_scale : float
        Scale of the robust loss: residuals well above it count less than their square. Default 1.
    acceleration : bool
        Whether steps are corrected by geodesic acceleration. It takes one more residual for each
        step, and fewer steps along curved valleys. Default False.
    max_iterations : int
        The largest number of accepted steps. Default 100.
    relative_cost_tolerance : float
        Stop when a step lowers the cost by less than this fraction of the cost. Default 1e-12.
    absolute_cost_tolerance : float
        Stop when a step lowers the cost by less than this amount. Default 0.
    step_tolerance : float
        Stop when a step is shorter than this times (1 + the norm of x). Default 1e-10.
    gradient_tolerance : float
        Stop when the cosine of the angle between the residual and each column of the Jacobian is
        at most this, apart from columns whose variable a bound keeps from moving. Default 1e-10.
    cost_floor : float
        Stop when the cost is at or below this value. Default 0.

    Returns
    -------
    Result

    Raises
    ------
    SolveError
        The start or its residual is not finite or not real, a lower bound exceeds its upper bound,
        the start lies outside the bounds, the Jacobian has the wrong shape, or another argument
        is not what is described above.

    Examples
    --------
    >>> import numpy as np, vfwidget as vf
    >>> rosenbrock = lambda x: np.array([10 * (x[1] - x[0] ** 2), 1 - x[0]])
    >>> vf.least_squares(rosenbrock, [-1.2, 0.5], bounds=(-2, 0.8)).x.round(3)
    array([0.8 , 0.64])
    """
    for name, function in (("residual", residual), ("jacobian", jacobian)):
        if not callable(function) and (name == "residual" or function is not None):
            raise SolveError(f"{name} must be a function of x; received {type(function).__name__}.")
    start = _real_array(x0, "x0")
    if start.ndim not in (1, 2) or start.size == 0:
        raise SolveError(f"x0 must have the shape (n,) or (B, n); received {start.shape}.")
    if scale not in ("columns", "none"):
        raise SolveError(f"scale must be 'columns' or 'none'; received {scale!r}.")
    if loss not in LOSSES:
        raise SolveError(f"loss must be one of {', '.join(LOSSES)}; received {loss!r}.")
    if not (is_number(loss_scale) and 0 < loss_scale < math.inf):
        raise SolveError(f"loss_scale must be a finite number > 0; received {loss_scale!r}.")
    lower, upper = _checked_bounds(bounds, start)
    table = None if kinks is None else kink_table(kinks, start.shape[-1])
    tolerances = Tolerances(
        relative_cost=read_limit("relative_cost_tolerance", relative_cost_tolerance),
        absolute_cost=read_limit("absolute_cost_tolerance", absolute_cost_tolerance),
        step=read_limit("step_tolerance", step_tolerance),
        gradient=read_limit("gradient_tolerance", gradient_tolerance),
        cost_floor=read_limit("cost_floor", cost_floor),
    )

    def problem(low: Array, high: Array) -> Problem:
        return Problem(
            low, high, table, scale == "columns", acceleration, loss, loss_scale, tolerances
        )

    convert = _as_tensors(x0) if is_tensor(x0) else _as_they_are

    shapes: set[tuple[int, ...]] = set()

    def values(x: Array) -> Array:
        found = _real_array(residual(convert(x)), "residual(x)")
        shapes.add(found.shape)
        if len(shapes) > 1:
            raise SolveError(
                f"residual(x) changed its shape between two points: {', '.join(map(str, shapes))}. "
                "Return as many values at every x."
            )
        return found

    derivative: Function
    if jacobian is not None:
        given = jacobian
        derivative = lambda x: _real_array(given(convert(x)), "jacobian(x)")  # noqa: E731
    elif is_tensor(x0):
        derivative = lambda x: to_array(forward_mode(residual, convert(x)))  # noqa: E731
    else:
        derivative = CentralDifferences(values, start, lower, upper, table)

    if start.ndim == 1:
        history: History = []
        alone = problem(lower, upper)
        state = minimise(
            alone, start, values, derivative, max_iterations=max_iterations, history=history
        )
        active = partial(active_bounds, alone, state, derivative)
        return _result([state], active, [history], convert, single=True)
    histories: list[History] = [[] for _ in start]
    problems = [problem(*sides) for sides in zip(lower, upper, strict=True)]
    states = minimise_batch(problems, start, values, derivative, max_iterations, histories)

    def actives() -> Array:
        inside = [within_bounds(one, own.x) for one, own in zip(problems, states, strict=True)]
        slopes = derivative(np.stack(inside))
        return np.stack(
            [
                active_bounds(problem, state, partial(lambda own, _: own, own))
                for problem, state, own in zip(problems, states, slopes, strict=True)
            ]
        )

    return _result(states, actives, histories, convert, single=False)


def _as_they_are(x: Array) -> Any:
    return x


def _as_tensors(x0: Any) -> Callable[[Array], Any]:
    """Arrays to float64 tensors on the device of ``x0``."""
    import torch

    return lambda x: torch.as_tensor(x, dtype=torch.float64, device=x0.device)


def _real_array(value: Any, name: str) -> Array:
    """A float64 array of real numbers."""
    is_complex = value.is_complex() if is_tensor(value) else np.iscomplexobj(value)
    if is_complex:
        raise SolveError(
            f"{name} must be real; received complex numbers. Pass their real and imaginary parts "
            "as separate numbers."
        )
    try:
        return to_array(value)
    except (TypeError, ValueError):
        raise SolveError(
            f"{name} must be an array of numbers; received {type(value).__name__}."
        ) from None


def _result(
    states: list[State],
    active: Callable[[], Array],
    histories: list[History],
    convert: Callable[[Array], Any],
    single: bool,
) -> Result:
    outcomes = [cast(Outcome, state.outcome) for state in states]
    converged = [outcome.status == CONVERGED for outcome in outcomes]
    if single:
        (state,), (outcome,), (history,) = states, outcomes, histories
        return Result(
            x=convert(state.x),
            cost=state.cost,
            residual=convert(state.residual),
            iterations=state.iterations,
            status=outcome.status,
            message=outcome.message,
            converged=converged[0],
            history=[Iterate(convert(x), cost) for x, cost in history],
            _active=active,
        )
    # A solve that has ended early repeats its last entry in the common history.
    length = max(len(history) for history in histories)
    padded = [history + history[-1:] * (length - len(history)) for history in histories]
    return Result(
        x=convert(np.stack([state.x for state in states])),
        cost=convert(np.array([state.cost for state in states])),
        residual=convert(np.stack([state.residual for state in states])),
        iterations=np.array([state.iterations for state in states]),
        status=[outcome.status for outcome in outcomes],
        message=[outcome.message for outcome in outcomes],
        converged=np.array(converged),
        history=[
            Iterate(
                convert(np.stack([x for x, _ in entries])),
                convert(np.array([cost for _, cost in entries])),
            )
            for entries in zip(*padded, strict=True)
        ],
        _active=active,
    )


def _checked_bounds(
    bounds: tuple[ArrayLike, ArrayLike] | None, start: Array
) -> tuple[Array, Array]:
    sides = bounds if bounds is not None else (-np.inf, np.inf)
    if not (isinstance(sides, Sequence) and len(sides) == 2):
        raise SolveError(f"bounds must be a pair (lower, upper); received {sides!r}.")
    low, high = (_real_array(side, "bounds") for side in sides)
    try:
        lower, upper = np.broadcast_to(low, start.shape), np.broadcast_to(high, start.shape)
    except ValueError:
        raise SolveError(
            f"The bounds do not fit x0: they must be numbers or have the shape {start.shape}."
        ) from None
    if not (lower <= upper).all():
        raise SolveError("A lower bound lies above its upper bound, or is NaN.")
    inside = (start >= lower) & (start <= upper)
    if not inside.all():
        first = tuple(int(i) for i in np.argwhere(~inside)[0])
        raise SolveError(
            f"x0 lies outside the bounds, or is NaN: entry {first} is {start[first]}, and must lie "
            f"between {lower[first]} and {upper[first]}."
        )
    return lower, upper


def kink_table(kinks: Sequence[ArrayLike], n: int) -> Array:
    """The kinks of each of n variables as rows of one table, (n, q), padded with infinity.

    Raises
    ------
    SolveError
        ``kinks`` has another length.
    """
    if len(kinks) != n:
        raise SolveError(
            f"kinks must hold a sequence for each of the {n} variables; received {len(kinks)}."
        )
    return padded_table([np.unique(to_array(row)) for row in kinks])
