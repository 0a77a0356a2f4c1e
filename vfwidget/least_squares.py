r"""Bounded Levenberg–Marquardt for piecewise smooth residuals; knows nothing of fonts.

Minimises :math:`E(x) = \sum_i r_i(x)^2` over a box :math:`l \le x \le u`.

**The step.** At each iterate the residual is replaced by its linear model and the damped model
is minimised over the box exactly (a projected Newton method: Bertsekas 1982; Tassa, Mansard and
Todorov 2014, "Control-limited differential dynamic programming"). Bounds that the model pushes
against are active and leave the system; those it does not are let go again, so the iterates
reach bound-constrained optima, which clamping or projecting an unbounded step does not. Damping
follows the gain ratio (Nielsen 1999; Madsen, Nielsen and Tingleff 2004).

**Kinks.** The residual may have kinks on planes ``x_i = c``; the caller names the numbers ``c``.
They cut the box into cells in each of which the residual is smooth. Where an iterate stands on a
kink it has a slope to either side, and as the kinks are parallel to the axes the slope in any
direction is the sum of the one-sided partial slopes. So each coordinate takes the side that goes
down (the steeper, should both), or rests, should neither; where all rest no direction goes down
and the point is stationary. A step is first tried over the whole box; where that crosses a kink
and the model proves poor, the step is confined to the cell, whose walls act as bounds: it
ends exactly on the kink, and the next iterate looks at the far side from there. (A crossing
iteration of the kind in Coleman and Conn 1982 for polyhedral norms.)
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from .arrays import Array, ArrayLike, is_tensor, to_array, to_tensor
from .errors import SolveError
from .quadratic import minimise_quadratic

NUDGE = 1e-8
"""How far beside a kink its one-sided derivative is asked for."""
INITIAL_DAMPING = 1e-4
MAX_REJECTIONS = 40
GOOD_GAIN = 0.75
"""A step that crosses kinks and gains less than this share of the promised is tried confined."""


class Iterate(NamedTuple):
    """A place the solver stood at, and its cost."""

    x: Array
    cost: float


@dataclass
class State:
    """Where a solve stands; :func:`init` makes it, :func:`step` moves it.

    Attributes
    ----------
    x : (n,) array
        The best point so far.
    residual : (m,) array
    cost : float
        Sum of squared residuals at ``x``.
    damping, growth : float
        Of Levenberg–Marquardt: the present damping and what a rejection multiplies it by.
    iterations : int
        Accepted steps.
    status : str
        Empty while there is more to do.
    active : (n,) int array
        -1 where a lower bound holds the point, 1 where an upper one does, else 0.
    """

    x: Array
    residual: Array
    cost: float
    damping: float = 0.0
    growth: float = 2.0
    iterations: int = 0
    status: str = ""
    active: Array = field(default_factory=lambda: np.zeros(0, dtype=int))
    history: list[Iterate] = field(default_factory=list)


@dataclass(frozen=True)
class Result:
    """What :func:`least_squares` found.

    Attributes
    ----------
    x : (n,) array or tensor
        The best point; of the kind ``x0`` was.
    cost : float
        Sum of squared residuals there (scipy reports half of it).
    residual : (m,) array or tensor
    active : (n,) int array
        -1 or 1 where the lower or upper bound holds the point, else 0.
    iterations : int
    status : str
        Why it stopped, in words.
    converged : bool
        False when the iteration limit came first.
    history : list of Iterate
        Every accepted point, the start included.
    """

    x: Any
    cost: float
    residual: Any
    active: Array
    iterations: int
    status: str
    converged: bool
    history: list[Iterate]


@dataclass(frozen=True)
class Tolerances:
    """When to stop; see :func:`least_squares`."""

    cost: float = 1e-12
    step: float = 1e-10
    gain: float = 0.0
    gradient: float = 1e-10
    zero: float = 0.0


@dataclass(frozen=True)
class Problem:
    """A residual over a box, in numpy: what :func:`step` works on."""

    residual: Callable[[Array], Array]
    jacobian: Callable[[Array], Array]
    lower: Array
    upper: Array
    kinks: Array | None
    """(n, q) sorted, padded with infinity; None when smooth."""
    scale_by_columns: bool
    tolerances: Tolerances

    def evaluate(self, x: Array) -> tuple[Array, float]:
        """Residual and cost at x."""
        residual = np.asarray(self.residual(x), dtype=np.float64)
        return residual, float(residual @ residual)


def least_squares(
    residual: Callable[[Any], Any],
    x0: ArrayLike,
    jacobian: Callable[[Any], Any] | None = None,
    bounds: tuple[ArrayLike, ArrayLike] | None = None,
    *,
    kinks: Sequence[ArrayLike] | None = None,
    scale: str = "columns",
    max_iterations: int = 100,
    cost_tolerance: float = 1e-12,
    step_tolerance: float = 1e-10,
    gain_tolerance: float = 0.0,
    gradient_tolerance: float = 1e-10,
    zero: float = 0.0,
) -> Result:
    """Minimise a sum of squared residuals over a box.

    Parameters
    ----------
    residual : callable
        x (n,) to residuals (m,). Called with tensors if ``x0`` is one, else with arrays.
    x0 : (n,) array or tensor
        The start; it must lie within the bounds.
    jacobian : callable, optional
        x to the derivative (m, n). By default forward-mode autodiff for tensors and central
        differences for arrays.
    bounds : (lower, upper), optional
        Each a number or (n,); infinite where there is none.
    kinks : sequence of n arrays, optional
        For each variable the values at which the residual may have a kink. ``jacobian`` is then
        asked at points a hair beside them, never on them.
    scale : {"columns", "none"}
        Damping weighs each variable by its column of the Jacobian (Marquardt), which makes the
        solver indifferent to units, or all alike, which prefers short steps.
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
        or a Jacobian of the wrong shape.
    """
    start = to_array(x0).copy()
    problem = _problem(
        residual, jacobian, start, is_tensor(x0), bounds, kinks, scale,
        Tolerances(cost_tolerance, step_tolerance, gain_tolerance, gradient_tolerance, zero),
    )  # fmt: skip
    state = init(problem, start)
    while not state.status and state.iterations < max_iterations:
        state = step(problem, state)
    give = to_tensor if is_tensor(x0) else to_array
    return Result(
        x=give(state.x),
        cost=state.cost,
        residual=give(state.residual),
        active=state.active,
        iterations=state.iterations,
        status=state.status or f"stopped at the limit of {max_iterations} iterations",
        converged=bool(state.status),
        history=state.history,
    )


def _problem(
    residual: Callable[[Any], Any],
    jacobian: Callable[[Any], Any] | None,
    start: Array,
    tensors: bool,
    bounds: tuple[ArrayLike, ArrayLike] | None,
    kinks: Sequence[ArrayLike] | None,
    scale: str,
    tolerances: Tolerances,
) -> Problem:
    """Check the caller's words and put torch functions behind numpy ones."""
    if start.ndim != 1:
        raise SolveError(f"The start is one vector, not an array of shape {start.shape}.")
    if scale not in ("columns", "none"):
        raise SolveError(f"scale is 'columns' or 'none', not {scale!r}.")
    n = len(start)
    low, high = bounds if bounds is not None else (-np.inf, np.inf)
    try:
        lower = np.broadcast_to(to_array(low), (n,)).copy()
        upper = np.broadcast_to(to_array(high), (n,)).copy()
    except ValueError:
        raise SolveError(f"The bounds do not fit a start of {n} numbers.") from None
    if not (lower <= upper).all():
        raise SolveError("A lower bound lies above its upper bound, or is NaN.")
    if not ((start >= lower) & (start <= upper)).all():
        raise SolveError("The start lies outside the bounds, or holds NaN.")

    def numpy_residual(x: Array) -> Array:
        return to_array(residual(to_tensor(x))) if tensors else to_array(residual(x))

    table = None if kinks is None else _kink_table(kinks, n)

    def numpy_jacobian(x: Array) -> Array:
        if jacobian is not None:
            return to_array(jacobian(to_tensor(x) if tensors else x))
        if tensors:
            import torch

            return to_array(torch.func.jacfwd(residual)(to_tensor(x)))
        left, right = (lower, upper) if table is None else _cell(table, x)
        return _central_differences(
            numpy_residual, x, np.maximum(left, lower), np.minimum(right, upper)
        )

    return Problem(
        numpy_residual, numpy_jacobian, lower, upper, table, scale == "columns", tolerances
    )


def _kink_table(kinks: Sequence[ArrayLike], n: int) -> Array:
    """The kinks of each variable as rows of one table, padded with infinity."""
    if len(kinks) != n:
        raise SolveError(f"kinks names {len(kinks)} variables; there are {n}.")
    rows = [np.unique(to_array(row)) for row in kinks]
    table = np.full((n, max((len(row) for row in rows), default=0) + 1), np.inf)
    for i, row in enumerate(rows):
        table[i, : len(row)] = row
    return table


def _cell(kinks: Array, x: Array, beyond: float = 0.0) -> tuple[Array, Array]:
    """The nearest kinks below and above x, no nearer than ``beyond``; infinite without any."""
    gaps = kinks - x[:, None]
    below = np.where(gaps < -beyond, kinks, -np.inf).max(1)
    above = np.where(gaps > beyond, kinks, np.inf).min(1)
    return below, above


def _central_differences(
    residual: Callable[[Array], Array], x: Array, lower: Array, upper: Array
) -> Array:
    """Differences that leave neither the bounds nor the cell between two kinks."""
    columns = []
    for i in range(len(x)):
        reach = np.finfo(float).eps ** (1 / 3) * max(1.0, abs(x[i]))
        left, right = x.copy(), x.copy()
        left[i], right[i] = max(x[i] - reach, lower[i]), min(x[i] + reach, upper[i])
        width = right[i] - left[i]
        columns.append((residual(right) - residual(left)) / (width if width > 0 else 1.0))
    return np.stack(columns, axis=1)


def init(problem: Problem, start: Array) -> State:
    """The state before the first step.

    Raises
    ------
    SolveError
        The residual at the start is not a vector of finite numbers.
    """
    residual, cost = problem.evaluate(start)
    if residual.ndim != 1 or not np.isfinite(residual).all():
        raise SolveError("The residual at the start is not a vector of finite numbers.")
    return State(start, residual, cost, history=[Iterate(start, cost)])


class _Model(NamedTuple):
    """The linear model at x: its Jacobian and how far each coordinate may go in it."""

    jacobian: Array
    low: Array
    high: Array
    cell_low: Array
    cell_high: Array


def step(problem: Problem, state: State) -> State:
    """One iteration: linearise, then raise the damping until a step lowers the cost.

    ``state`` is changed and returned. Its ``status`` says whether and why the solve has ended.
    """
    tolerances = problem.tolerances
    if state.cost <= tolerances.zero:
        state.status = "reached: the cost is zero"
        return state
    model = _linearise(problem, state)
    jacobian = model.jacobian
    gradient = jacobian.T @ state.residual
    normal = jacobian.T @ jacobian
    columns = np.sqrt(np.diag(normal))
    movable = ((gradient > 0) & (model.low < 0)) | ((gradient < 0) & (model.high > 0))
    state.active = _active(problem, state.x, gradient)
    norm = np.sqrt(state.cost)
    slopes = np.abs(gradient) / np.where(columns > 0, columns * norm, 1.0)
    if not movable.any() or slopes[movable].max() <= tolerances.gradient:
        state.status = "converged: no direction lowers the cost"
        return state
    strongest = columns.max() ** 2
    if problem.scale_by_columns:
        damp = np.diag(np.maximum(columns**2, 1e-12 * strongest) / strongest)
    else:
        damp = np.eye(len(columns))
    if state.damping == 0:
        state.damping = INITIAL_DAMPING * strongest

    for _ in range(MAX_REJECTIONS):
        system = normal + state.damping * damp
        trial = _try(problem, state, model, system, gradient, normal, confined=False)
        if trial.crosses and trial.gain < GOOD_GAIN:
            inside = _try(problem, state, model, system, gradient, normal, confined=True)
            trial = inside if inside.cost < trial.cost else trial
        if trial.gain > 1e-3 and trial.cost < state.cost:
            break
        short = np.abs(trial.x - state.x).max() <= tolerances.step * (1 + np.abs(state.x).max())
        if short or trial.promised <= np.finfo(float).eps * state.cost:
            state.status = "converged: steps have become too short to matter"
            return state
        state.damping *= state.growth
        state.growth *= 2
    else:
        state.status = "converged: no step lowers the cost"
        return state

    moved = np.abs(trial.x - state.x).max() > tolerances.step * (1 + np.abs(state.x).max())
    least = max(tolerances.gain, tolerances.cost * state.cost)
    gained = state.cost - trial.cost > least or trial.promised > 10 * least
    state.damping *= max(0.1, 1 - (2 * min(trial.gain, 1.5) - 1) ** 3)
    state.growth = 2.0
    state.x, state.residual, state.cost = trial.x, trial.residual, trial.cost
    state.iterations += 1
    state.history.append(Iterate(trial.x, trial.cost))
    if not (moved and gained):
        state.status = "converged: steps have become too short to matter"
    return state


class _Trial(NamedTuple):
    x: Array
    residual: Array
    cost: float
    promised: float
    gain: float
    crosses: bool


def _try(
    problem: Problem,
    state: State,
    model: _Model,
    system: Array,
    gradient: Array,
    normal: Array,
    confined: bool,
) -> _Trial:
    """Minimise the damped model over the box or the cell, and see what the step is worth."""
    low, high = (model.cell_low, model.cell_high) if confined else (model.low, model.high)
    d = minimise_quadratic(system, gradient, low, high)
    # Walls are met exactly, so that the next iterate knows where it stands.
    x = np.where(d >= high, state.x + high, np.where(d <= low, state.x + low, state.x + d))
    x = _snap(problem, np.clip(x, problem.lower, problem.upper))
    residual, cost = problem.evaluate(x)
    if not np.isfinite(cost):
        cost = np.inf
    promised = -float(2 * gradient @ d + d @ normal @ d)
    gain = (state.cost - cost) / promised if promised > 0 else -np.inf
    crosses = bool((d < model.cell_low).any() or (d > model.cell_high).any())
    return _Trial(x, residual, cost, promised, gain, crosses)


def _snap(problem: Problem, x: Array) -> Array:
    """Put coordinates that lie within rounding of a kink onto it."""
    if problem.kinks is None:
        return x
    nearest = np.abs(problem.kinks - x[:, None]).argmin(1)
    kink = problem.kinks[np.arange(len(x)), nearest]
    return np.where(np.abs(x - kink) < NUDGE, np.clip(kink, problem.lower, problem.upper), x)


def _linearise(problem: Problem, state: State) -> _Model:
    """The Jacobian of the sides that go down, and the room there is on them."""
    x = state.x
    low, high = problem.lower - x, problem.upper - x
    if problem.kinks is None:
        jacobian = _checked_jacobian(problem, state, x)
        return _Model(jacobian, low, high, low, high)
    on_kink = (np.abs(problem.kinks - x[:, None]) < NUDGE).any(1)
    right = on_kink & (high > 0)
    left = on_kink & (low < 0)
    ahead = _checked_jacobian(problem, state, x + NUDGE * right - NUDGE * (on_kink & ~right))
    if (left & right).any():
        behind = _checked_jacobian(problem, state, x - NUDGE * left + NUDGE * (on_kink & ~left))
        slope_ahead = -(ahead.T @ state.residual)
        slope_behind = behind.T @ state.residual
        both = left & right
        ahead_down, behind_down = both & (slope_ahead > 0), both & (slope_behind > 0)
        take_behind = behind_down & (~ahead_down | (slope_behind > slope_ahead))
        take_ahead = ahead_down & ~take_behind
        jacobian = np.where(take_behind, behind, ahead)
        low = np.where(take_ahead | (both & ~take_behind), 0.0, low)
        high = np.where(take_behind | (both & ~take_ahead), 0.0, high)
    else:
        jacobian = ahead
    below, above = _cell(problem.kinks, x, beyond=NUDGE)
    return _Model(jacobian, low, high, np.maximum(low, below - x), np.minimum(high, above - x))


def _checked_jacobian(problem: Problem, state: State, x: Array) -> Array:
    jacobian = problem.jacobian(x)
    if jacobian.shape != (len(state.residual), len(x)):
        raise SolveError(
            f"The Jacobian has shape {jacobian.shape}; {len(state.residual)} residuals of "
            f"{len(x)} variables need ({len(state.residual)}, {len(x)})."
        )
    if not np.isfinite(jacobian).all():
        raise SolveError("The Jacobian holds NaN or infinity.")
    return jacobian


def _active(problem: Problem, x: Array, gradient: Array) -> Array:
    """Which bounds hold the point: it stands on them and the cost falls beyond them."""
    lower = (x <= problem.lower) & (gradient > 0)
    upper = (x >= problem.upper) & (gradient < 0)
    return upper.astype(int) - lower.astype(int)
