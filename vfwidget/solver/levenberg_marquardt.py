r"""The iteration of :func:`vfwidget.least_squares`: init, step, and the drivers that feed them.

**The step.** At each iterate the residual is replaced by its linear model and the damped model
is minimised over the box exactly (:mod:`vfwidget.solver.quadratic`). Bounds that the model pushes
against are active and leave the system; those it does not are let go again, so the iterates
reach bound-constrained optima, which clamping or projecting an unbounded step does not. Damping
follows the gain ratio (Nielsen 1999; Madsen, Nielsen and Tingleff 2004).

**Kinks.** The residual may have kinks on planes ``x_i = c``; the caller names the numbers ``c``.
They cut the box into cells in each of which the residual is smooth. Where an iterate stands on a
kink it has a slope to either side, and as the kinks are parallel to the axes the slope in any
direction is the sum of the one-sided partial slopes. So each coordinate takes the side that goes
down (the steeper, should both), or rests, should neither; where all rest no direction goes down
and the point is stationary. A step is first tried over the whole box; where that crosses a kink
and the model proves poor, the step is confined to the cell, whose walls act as bounds: it ends
exactly on the kink, and the next iterate looks at the far side from there. (Crossing lines of
non-differentiability one at a time is the idea of Coleman and Conn 1982 for polyhedral norms.)

**Geodesic acceleration** (Transtrum and Sethna 2012), when asked for: the step d is bent by half
of a correction that cancels the residual's second derivative along d, measured with one more
residual. It shortens the way along curved valleys.

**Requests.** The iteration calls no function of the caller's. It is a generator that asks for a
residual or a Jacobian at some x and is sent the answer, so that one text serves a drag, where
every microsecond counts, and a batch, whose requests are answered many at once.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator
from dataclasses import dataclass, field
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from ..arrays import Array
from ..errors import SolveError
from .loss import rescale, robust_cost
from .quadratic import minimise_quadratic

NUDGE = 1e-8
"""How far beside a kink its one-sided derivative is asked for."""
INITIAL_DAMPING, LEAST_DAMPING = 1e-4, 1e-14
"""Relative to the damping's unit: 1 where it weighs by columns, else the largest of them. The
least must outlast rounding, or a matrix that has no full rank stays singular."""
FAINTEST = 1e-12
"""Where the search for a first damping begins."""
GOOD_GAIN = 0.75
"""A step that crosses kinks and gains less than this share of the promised is tried confined."""
LEAST_GAIN = 1e-3
GREAT_GAIN, BOLD = 0.9, 0.03
"""A step that keeps this much of its promise lets the damping fall by that factor."""
GROWN_OUT = 2.0**40
"""The damping's growth at which no step helps any more."""
PROBE, MOST_BENT = 0.1, 0.75
"""Where along a step its second derivative is measured, and how much of one it may correct."""

ZERO = "converged: the cost is zero"
AT_REST = "converged: no direction lowers the cost"
SHORT = "converged: steps have become too short to matter"
STUCK = "converged: no step lowers the cost"

Request: TypeAlias = tuple[bool, Array]
"""(whether the Jacobian is asked for, else the residual; where)."""
Asking: TypeAlias = Generator[Request, Array, Any]


@dataclass(frozen=True)
class Tolerances:
    """When to stop; see :func:`vfwidget.least_squares`."""

    cost: float = 1e-12
    step: float = 1e-10
    gain: float = 0.0
    gradient: float = 1e-10
    zero: float = 0.0


@dataclass(frozen=True)
class Problem:
    """Everything about a problem of n variables but its residual.

    Attributes
    ----------
    lower, upper : (n,) arrays
    kinks : (n, q) array, optional
        Padded with infinity.
    scale_by_columns, accelerate : bool
    loss, loss_scale
        See :mod:`vfwidget.solver.loss`.
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
        """Cost of a residual; infinite where it is not finite."""
        value = float(robust_cost(residual, self.loss, self.loss_scale))
        return value if math.isfinite(value) else math.inf


class Model(NamedTuple):
    """The linear model at an iterate, its unit of damping, and how far each coordinate may go."""

    jacobian: Array
    gradient: Array
    normal: Array
    columns: Array
    unit: float
    low: Array
    high: Array


@dataclass
class State:
    """Where a solve stands; :func:`init` makes it, :func:`step` moves it.

    Attributes
    ----------
    x : (n,) array
        The best point so far.
    residual : (m,) array
    cost : float
    damping, growth : float
        Of Levenberg–Marquardt: the present damping and what a rejection multiplies it by.
    scale : (n,) array or 0
        Squared column norms that damping weighs by, their greatest so far.
    iterations : int
        Accepted steps.
    reason : str
        Why it has ended; empty while there is more to do.
    model : Model, optional
        Kept while steps are being rejected.
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


def init(problem: Problem, start: Array) -> Asking:
    """The state before the first step.

    Raises
    ------
    SolveError
        The residual is not a vector of finite numbers.
    """
    residual = yield False, start
    if residual.ndim != 1 or not np.isfinite(residual).all():
        raise SolveError("The residual at the start is not a vector of finite numbers.")
    return State(start, residual, problem.cost(residual))


def step(problem: Problem, state: State) -> Asking:
    """Linearise if need be, then try one step; ``state`` is changed."""
    tolerances = problem.tolerances
    if state.cost <= max(tolerances.zero, tolerances.gain):
        state.reason = ZERO if state.cost <= tolerances.zero else SHORT
        return
    model = state.model
    if model is None:
        model = state.model = yield from _linearise(problem, state)
    if _is_at_rest(model, state.cost, tolerances.gradient):
        state.reason = AT_REST
        return
    system = _damped(problem, state, model)
    trial = yield from _try(problem, state, model, system, model.low, model.high)
    if trial.promised <= tolerances.gain and trial.x is state.x:
        state.reason = SHORT
        return
    if trial.gain < GOOD_GAIN and problem.kinks is not None:
        below, above = _cell(problem.kinks, state.x)
        low, high = np.maximum(model.low, below), np.minimum(model.high, above)
        if ((trial.d < low) | (trial.d > high)).any():
            inside = yield from _try(problem, state, model, system, low, high)
            trial = inside if inside.cost < trial.cost else trial
    _judge(tolerances, state, trial)


def finish(problem: Problem, start: Array, max_iterations: int, history: list[Any]) -> Asking:
    """A whole solve: steps until there is a reason to stop; each accepted x joins ``history``."""
    state = yield from init(problem, start)
    history.append((state.x, state.cost))
    while not state.reason and state.iterations < max_iterations:
        count = state.iterations
        yield from step(problem, state)
        if state.iterations > count:
            history.append((state.x, state.cost))
    return state


def drive(
    asking: Asking, residual: Callable[[Array], Array], jacobian: Callable[[Array], Array]
) -> Any:
    """Answer a generator's requests until it returns; its value."""
    with _quiet():
        try:
            wants_jacobian, x = next(asking)
            while True:
                wants_jacobian, x = asking.send(jacobian(x) if wants_jacobian else residual(x))
        except StopIteration as end:
            return end.value


def drive_many(
    asking: list[Asking],
    starts: Array,
    residual: Callable[[Array], Array],
    jacobian: Callable[[Array], Array],
) -> list[Any]:
    """Answer B generators' requests together, (B, n) to (B, m) and (B, m, n); their values."""
    values: list[Any] = [None] * len(asking)
    places = starts.copy()
    requests = {row: next(generator) for row, generator in enumerate(asking)}
    with _quiet():
        while requests:
            # Rows that ask for the other thing, or nothing, are evaluated where they last stood.
            for row, (_, x) in requests.items():
                places[row] = x
            wanted = {wants for wants, _ in requests.values()}
            answers = {wants: (jacobian if wants else residual)(places) for wants in wanted}
            for row, (wants, _) in list(requests.items()):
                try:
                    requests[row] = asking[row].send(answers[wants][row])
                except StopIteration as end:
                    values[row] = end.value
                    del requests[row]
    return values


def _quiet() -> np.errstate:
    """Where a trial overflows, its infinite cost is answer enough."""
    return np.errstate(over="ignore", invalid="ignore")


def active_bounds(problem: Problem, state: State, jacobian: Callable[[Array], Array]) -> Array:
    """-1 or 1, (n,), where the lower or upper bound holds the point against its slope, else 0."""
    at_lower, at_upper = state.x <= problem.lower, state.x >= problem.upper
    if not (at_lower | at_upper).any():
        return np.zeros(len(state.x), dtype=int)
    model = state.model
    # The slope that counts is that of the side within the bounds.
    gradient = (
        model.gradient
        if model is not None
        else _pull(problem, state, jacobian(state.x + NUDGE * at_lower - NUDGE * at_upper))
    )
    return (at_upper & (gradient < 0)).astype(int) - (at_lower & (gradient > 0))


class _Trial(NamedTuple):
    d: Any
    x: Any
    residual: Array
    cost: float
    promised: float
    gain: float


def _damped(problem: Problem, state: State, model: Model) -> Array:
    """The normal equations' matrix with the damping on its diagonal."""
    weights: Any = 1.0
    if problem.scale_by_columns:
        weights = np.where(state.scale > 0, state.scale, 1.0)
        if not state.damping:
            state.damping = _first_damping(state, model, weights)
    state.damping = max(state.damping or INITIAL_DAMPING * model.unit, LEAST_DAMPING * model.unit)
    return _with_diagonal(model.normal, state.damping * weights)


def _with_diagonal(matrix: Array, more: Any) -> Array:
    system = matrix.copy()
    system.ravel()[:: len(system) + 1] += more
    return system


def _first_damping(state: State, model: Model, weights: Array) -> float:
    """The least damping with which the first step is no longer than the start is far from zero.

    Measured both by what it does to the linear model and by its greatest coordinate (the start
    of a trust region in MINPACK and, with other weights, in scipy's trf). Costs no residual.
    """
    root, damping = np.sqrt(weights), FAINTEST
    reach = float(np.linalg.norm(root * state.x)) or 1.0
    far = float(abs(state.x).max()) or math.inf
    while damping < 1e12:
        system = _with_diagonal(model.normal, damping * weights)
        d = minimise_quadratic(system, model.gradient, model.low, model.high)
        if np.linalg.norm(root * d) <= reach and abs(d).max() <= far:
            break
        damping *= 4
    return damping


def _try(
    problem: Problem, state: State, model: Model, system: Array, low: Array, high: Array
) -> Generator[Request, Array, _Trial]:
    """Minimise the damped model between two walls, and see what the step is worth."""
    d = -np.linalg.solve(system, model.gradient)
    walled = ((d < low) | (d > high)).any()
    if walled:
        d = minimise_quadratic(system, model.gradient, low, high)
    # What the model promises is for the straight step; the bent one is to keep it better.
    promised = -float(2 * model.gradient.dot(d) + d.dot(model.normal).dot(d))
    freely = not walled and state.damping <= INITIAL_DAMPING * model.unit
    if freely and promised <= problem.tolerances.gain:
        # Nothing holds the step back, and it is not worth the look.
        return _Trial(d, state.x, state.residual, state.cost, promised, 0.0)
    if problem.accelerate:
        d = yield from _bend(state, model, system, d, low, high)
    x = state.x + d
    if walled:
        # A wall is met exactly, so that the next iterate knows where it stands.
        x = np.where(d >= high, state.x + high, np.where(d <= low, state.x + low, x))
    x = np.minimum(np.maximum(x, problem.lower), problem.upper)
    residual = yield False, x
    cost = problem.cost(residual)
    gain = (state.cost - cost) / promised if promised > 0 else -math.inf
    return _Trial(d, x, residual, cost, promised, gain)


def _bend(
    state: State, model: Model, system: Array, d: Any, low: Array, high: Array
) -> Generator[Request, Array, Array]:
    """The step with half its geodesic acceleration, where that is no more than a correction."""
    ahead = yield False, state.x + PROBE * d
    if not np.isfinite(ahead).all():
        return d
    second = 2 / PROBE * ((ahead - state.residual) / PROBE - model.jacobian @ d)
    # What a wall holds stays there.
    room = np.where((d > low) & (d < high), math.inf, 0.0)
    bend = minimise_quadratic(system, second @ model.jacobian, -room, room)
    if 2 * np.linalg.norm(bend) > MOST_BENT * np.linalg.norm(d):
        return d
    return np.clip(d + bend / 2, low, high)


def _judge(tolerances: Tolerances, state: State, trial: _Trial) -> None:
    """Accept or reject a trial, set the damping, and see whether there is reason to stop."""
    length = float(abs(trial.x - state.x).max())
    short = length <= tolerances.step * (1 + float(abs(state.x).max()))
    if trial.gain > LEAST_GAIN and trial.cost < state.cost:
        least = max(tolerances.cost * state.cost, tolerances.gain)
        idle = state.cost - trial.cost <= least and trial.promised <= 10 * least
        state.x, state.residual, state.cost = trial.x, trial.residual, trial.cost
        state.damping *= BOLD if trial.gain > GREAT_GAIN else 1 - (2 * trial.gain - 1) ** 3
        state.growth = 2.0
        state.iterations += 1
        state.model = None
        # No step gains more than there is.
        if short or idle or state.cost <= tolerances.gain:
            state.reason = SHORT
    elif short or trial.promised <= 2e-16 * state.cost:
        state.reason = SHORT
    else:
        state.damping *= state.growth
        state.growth *= 2
        if state.growth > GROWN_OUT:
            state.reason = STUCK


def _is_at_rest(model: Model, cost: float, tolerance: float) -> bool:
    """Whether no coordinate may move and lower the cost."""
    slopes = abs(model.gradient)
    movable = np.where(model.gradient > 0, model.low < 0, model.high > 0)
    steep = slopes > tolerance * np.sqrt(model.columns * cost)
    return not (movable & steep).any()


def _linearise(problem: Problem, state: State) -> Generator[Request, Array, Model]:
    """The Jacobian of the sides that go down, and the room there is on them."""
    x = state.x
    low, high = problem.lower - x, problem.upper - x
    near = problem.kinks is not None and abs(problem.kinks - x[:, None]) < NUDGE
    if near is False or not near.any():
        jacobian = yield True, x
    else:
        on_kink = near.any(1)
        right, left = on_kink & (high > 0), on_kink & (low < 0)
        ahead = x + NUDGE * right - NUDGE * (on_kink & ~right)
        jacobian = yield True, np.clip(ahead, problem.lower, problem.upper)
        both = left & right
        if both.any():
            beside = x - NUDGE * left + NUDGE * (on_kink & ~left)
            behind = yield True, np.clip(beside, problem.lower, problem.upper)
            falls_ahead = -_pull(problem, state, jacobian)
            falls_behind = _pull(problem, state, behind)
            ahead_down, behind_down = both & (falls_ahead > 0), both & (falls_behind > 0)
            take_behind = behind_down & (~ahead_down | (falls_behind > falls_ahead))
            take_ahead = ahead_down & ~take_behind
            jacobian = np.where(take_behind, behind, jacobian)
            low = np.where(both & ~take_behind, 0.0, low)
            high = np.where(both & ~take_ahead, 0.0, high)
    if jacobian.shape != (len(state.residual), len(x)):
        raise SolveError(
            f"The Jacobian has shape {jacobian.shape}; {len(state.residual)} residuals of "
            f"{len(x)} variables need {(len(state.residual), len(x))}."
        )
    residual, jacobian = rescale(state.residual, jacobian, problem.loss, problem.loss_scale)
    # On arrays this small a call of dot costs half of what @ does.
    normal = jacobian.T.dot(jacobian)
    columns = normal.diagonal()
    unit = float(columns.max())
    if not math.isfinite(unit):
        raise SolveError("The Jacobian holds NaN or infinity.")
    if problem.scale_by_columns:
        state.scale = np.maximum(state.scale, columns)
        unit = 1.0
    return Model(jacobian, residual.dot(jacobian), normal, columns, unit, low, high)


def _pull(problem: Problem, state: State, jacobian: Array) -> Array:
    """Half the cost's slope, (n,), by this Jacobian."""
    residual, jacobian = rescale(state.residual, jacobian, problem.loss, problem.loss_scale)
    return residual @ jacobian


def _cell(kinks: Array, x: Array) -> tuple[Array, Array]:
    """How far the next kinks are, below (negative) and above."""
    gaps = kinks - x[:, None]
    below = np.where(gaps < -NUDGE, gaps, -math.inf).max(1)
    above = np.where(gaps > NUDGE, gaps, math.inf).min(1)
    return below, above
