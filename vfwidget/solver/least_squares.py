"""Bounded Levenberg–Marquardt for piecewise smooth residuals; knows nothing of fonts.

The iteration itself, and the sources of its method, are in :mod:`.levenberg_marquardt`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any, NamedTuple, cast

import numpy as np

from ..arrays import Array, ArrayLike, is_tensor, padded_table, to_array
from ..errors import SolveError
from .drivers import History, active_bounds, minimise, minimise_batch
from .loss import LOSSES
from .problem import Problem, State, Tolerances
from .status import CONVERGED, Outcome

LEAST_REACH = 1e-3


class Iterate(NamedTuple):
    """A place the solver stood at, and its cost."""

    x: Any
    cost: Any


@dataclass(frozen=True)
class Result:
    """What :func:`least_squares` found; with a leading dimension B where the start had one.

    Attributes
    ----------
    x : (n,) array or tensor
        The best point; of the kind ``x0`` was.
    cost : float
        Sum of squared residuals there (scipy reports half of it), or of the loss.
    residual : (m,) array or tensor
    iterations : int
        Accepted steps.
    status : str
        How the solve has ended, in a word of :mod:`vfwidget.solver.status`.
    message : str
        The reason, in a sentence.
    converged : bool
        Whether the status is ``"converged"``.
    history : list of Iterate
        The start and the best point after every step that was accepted.
    """

    x: Any
    cost: Any
    residual: Any
    iterations: Any
    status: Any
    message: Any
    converged: Any
    history: list[Iterate]
    _active: Callable[[], Array] = field(repr=False, compare=False)

    @cached_property
    def active(self) -> Array:
        """-1 or 1, (n,), where the lower or upper bound holds the point, else 0.

        To say so may take a Jacobian, which is evaluated when first asked for.
        """
        return self._active()


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
    cost_tolerance: float = 1e-12,
    step_tolerance: float = 1e-10,
    gain_tolerance: float = 0.0,
    gradient_tolerance: float = 1e-10,
    zero: float = 0.0,
) -> Result:
    """Minimise a sum of squared residuals over a box; one problem, or many at once.

    Parameters
    ----------
    residual : callable
        x (n,) to residuals (m,); for a batch, (B, n) to (B, m), row by row independent. Called
        with tensors if ``x0`` is one (on its device), else with arrays; float64 in either case.
    x0 : (n,) or (B, n) array or tensor
        The start, or B of them; within the bounds.
    jacobian : callable, optional
        x to the derivative (m, n), or (B, m, n). By default forward-mode autodiff for tensors
        and central differences for arrays.
    bounds : (lower, upper), optional
        Each a number, (n,) or (B, n); infinite where there is none.
    kinks : sequence of n arrays, optional
        For each variable the values at which the residual may have a kink. ``jacobian`` is then
        asked at points a hair beside them, never on them.
    scale : {"columns", "none"}
        Damping weighs each variable by the greatest size of its column of the Jacobian so far
        (Marquardt, Moré), which makes the solver indifferent to units, or all alike, which
        prefers short steps.
    loss : {"linear", "soft_l1", "huber", "cauchy", "arctan"}
        How much large residuals count.
    loss_scale : float
        The size of residual from which a robust loss holds back.
    acceleration : bool
        Geodesic acceleration: one more residual for each trial, fewer steps along curved valleys.
    max_iterations : int
    cost_tolerance : float
        Stop when a step lowers the cost by less than this share of it.
    step_tolerance : float
        Stop when a step is shorter than this, relative to x.
    gain_tolerance : float
        Stop when a step lowers the cost by less than this, in the cost's own unit.
    gradient_tolerance : float
        Stop when residual and every column that may still move are this near to perpendicular.
    zero : float
        A cost that counts as none.

    Returns
    -------
    Result

    Raises
    ------
    SolveError
        NaN or infinity in the start or its residual, lower > upper, a start outside the bounds,
        a Jacobian of the wrong shape, or an unknown loss or scale.

    Examples
    --------
    >>> import numpy as np, vfwidget as vf
    >>> rosenbrock = lambda x: np.array([10 * (x[1] - x[0] ** 2), 1 - x[0]])
    >>> vf.least_squares(rosenbrock, [-1.2, 0.5], bounds=(-2, 0.8)).x.round(3)
    array([0.8 , 0.64])
    """
    start = to_array(x0)
    if start.ndim not in (1, 2):
        raise SolveError(f"The start is (n,) or (B, n), not of shape {start.shape}.")
    if scale not in ("columns", "none"):
        raise SolveError(f"scale is 'columns' or 'none', not {scale!r}.")
    if loss not in LOSSES:
        raise SolveError(f"There is no loss {loss!r}: choose one of {', '.join(LOSSES)}.")
    lower, upper = _checked_bounds(bounds, start)
    table = None if kinks is None else kink_table(kinks, start.shape[-1])
    outside = _as_tensors(x0) if is_tensor(x0) else _as_they_are
    # Differences are of the size of x, and near zero of that of the start.
    floor = LEAST_REACH * np.where(start != 0, abs(start), 1.0)
    derivative = _derivative(residual, jacobian, outside, is_tensor(x0), lower, upper, table, floor)
    tolerances = Tolerances(
        cost_tolerance, step_tolerance, gain_tolerance, gradient_tolerance, zero
    )

    def problem(low: Array, high: Array) -> Problem:
        return Problem(
            low, high, table, scale == "columns", acceleration, loss, loss_scale, tolerances
        )

    def answer(x: Array) -> Array:
        return to_array(residual(outside(x)))

    if start.ndim == 1:
        history: History = []
        alone = problem(lower, upper)
        state = minimise(
            alone, start, answer, derivative, max_iterations=max_iterations, history=history
        )
        active = partial(active_bounds, alone, state, derivative)
        return _result([state], active, [history], outside, single=True)
    histories: list[History] = [[] for _ in start]
    problems = [problem(*sides) for sides in zip(lower, upper, strict=True)]
    states = minimise_batch(problems, start, answer, derivative, max_iterations, histories)

    def actives() -> Array:
        slopes = derivative(np.stack([state.x for state in states]))
        return np.stack(
            [
                active_bounds(problem, state, partial(lambda own, _: own, own))
                for problem, state, own in zip(problems, states, slopes, strict=True)
            ]
        )

    return _result(states, actives, histories, outside, single=False)


def _as_they_are(x: Array) -> Any:
    return x


def _as_tensors(x0: Any) -> Callable[[Array], Any]:
    """Arrays to float64 tensors on the device of ``x0``."""
    import torch

    return lambda x: torch.as_tensor(x, dtype=torch.float64, device=x0.device)


def _result(
    states: list[State],
    active: Callable[[], Array],
    histories: list[History],
    outside: Callable[[Array], Any],
    single: bool,
) -> Result:
    outcomes = [cast(Outcome, state.outcome) for state in states]
    # A solve that ended early stands still in the histories of those that went on.
    length = max(len(history) for history in histories)
    padded = [history + history[-1:] * (length - len(history)) for history in histories]
    result = Result(
        x=outside(np.stack([state.x for state in states])),
        cost=outside(np.array([state.cost for state in states])),
        residual=outside(np.stack([state.residual for state in states])),
        iterations=np.array([state.iterations for state in states]),
        status=[outcome.status for outcome in outcomes],
        message=[outcome.message for outcome in outcomes],
        converged=np.array([outcome.status == CONVERGED for outcome in outcomes]),
        history=[
            Iterate(
                outside(np.stack([x for x, _ in moment])),
                outside(np.array([cost for _, cost in moment])),
            )
            for moment in zip(*padded, strict=True)
        ],
        _active=active,
    )
    if not single:
        return result
    return Result(
        x=result.x[0],
        cost=states[0].cost,
        residual=result.residual[0],
        iterations=states[0].iterations,
        status=result.status[0],
        message=result.message[0],
        converged=bool(result.converged[0]),
        history=[Iterate(x[0], float(cost[0])) for x, cost in result.history],
        _active=active,
    )


def _checked_bounds(
    bounds: tuple[ArrayLike, ArrayLike] | None, start: Array
) -> tuple[Array, Array]:
    sides = bounds if bounds is not None else (-np.inf, np.inf)
    try:
        lower, upper = (np.broadcast_to(to_array(side), start.shape) for side in sides)
    except ValueError:
        raise SolveError(f"The bounds do not fit a start of {start.shape[-1]} numbers.") from None
    if not (lower <= upper).all():
        raise SolveError("A lower bound lies above its upper bound, or is NaN.")
    if not ((start >= lower) & (start <= upper)).all():
        raise SolveError("The start lies outside the bounds, or holds NaN.")
    return lower, upper


def kink_table(kinks: Sequence[ArrayLike], n: int) -> Array:
    """The kinks of each of n variables as rows of one table, (n, q), padded with infinity.

    Raises
    ------
    SolveError
        ``kinks`` names another number of variables.
    """
    if len(kinks) != n:
        raise SolveError(f"kinks names {len(kinks)} variables; there are {n}.")
    return padded_table([np.unique(to_array(row)) for row in kinks])


def _derivative(
    residual: Callable[[Any], Any],
    jacobian: Callable[[Any], Any] | None,
    outside: Callable[[Array], Any],
    tensors: bool,
    lower: Array,
    upper: Array,
    kinks: Array | None,
    floor: Array,
) -> Callable[[Array], Array]:
    """The Jacobian the caller gave, else forward mode for tensors, differences for arrays."""
    if jacobian is not None:
        return lambda x: to_array(jacobian(outside(x)))
    if tensors:
        return lambda x: to_array(_forward_mode(residual, outside(x)))

    def differences(x: Array) -> Array:
        left, right = lower, upper
        if kinks is not None:
            # A difference across a kink is no derivative of either side.
            gaps = kinks - x[..., None]
            left = np.maximum(left, np.where(gaps < 0, kinks, -np.inf).max(-1))
            right = np.minimum(right, np.where(gaps > 0, kinks, np.inf).min(-1))
        return _central_differences(residual, x, left, right, floor)

    return differences


def _forward_mode(residual: Callable[[Any], Any], x: Any) -> Any:
    """One directional derivative for each variable; variables are few, residuals many."""
    import torch

    columns = []
    for i in range(x.shape[-1]):
        tangent = torch.zeros_like(x)
        tangent[..., i] = 1
        columns.append(torch.func.jvp(residual, (x,), (tangent,))[1])
    return torch.stack(columns, -1)


def _central_differences(
    residual: Callable[[Any], Any], x: Array, lower: Array, upper: Array, floor: Array
) -> Array:
    columns = []
    for i in range(x.shape[-1]):
        reach = np.finfo(float).eps ** (1 / 3) * np.maximum(floor[..., i], np.abs(x[..., i]))
        left, right = x.copy(), x.copy()
        left[..., i] = np.maximum(x[..., i] - reach, lower[..., i])
        right[..., i] = np.minimum(x[..., i] + reach, upper[..., i])
        width = (right - left)[..., i, None]
        columns.append(
            (to_array(residual(right)) - to_array(residual(left))) / np.where(width > 0, width, 1)
        )
    return np.stack(columns, axis=-1)
