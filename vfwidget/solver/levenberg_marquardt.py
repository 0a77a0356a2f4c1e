r"""The iteration of :func:`vfwidget.least_squares`: how it starts, and what one step does.

**The step.** At each iterate the linear model replaces the residual, and the solver minimises the
damped model exactly over the box (:mod:`vfwidget.solver.quadratic`). Bounds that the model pushes
against are active, and their variables leave the linear system; the other bounds are released
again. The iterates therefore reach bound-constrained optima, which clamping or projecting an
unbounded step does not. The gain ratio controls the damping (Nielsen 1999; Madsen, Nielsen and
Tingleff 2004).

**Kinks.** :mod:`vfwidget.solver.linearize` describes the slopes at a kink. A step is first tried
over the whole box. If it crosses a kink and the model is poor, the step is repeated within the
cell, whose sides act as bounds. The step then ends exactly on the kink, and the next iterate looks
at both sides from there. (Coleman and Conn 1982 cross lines of non-differentiability one at a time
for polyhedral norms.)

**Geodesic acceleration** (Transtrum and Sethna 2012) is optional. It bends the step d by half of a
correction that cancels the second derivative of the residual along d; measuring that derivative
takes one more residual. It shortens the path along curved valleys.

**Requests.** The iteration calls none of the caller's functions. It is a generator that yields a
request for a residual or a Jacobian at some x, and receives the value. The same code therefore
serves a drag, where every microsecond counts, and a batch, whose requests are evaluated together.
"""

from __future__ import annotations

import math
from collections.abc import Generator
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..errors import SolveError
from .linearize import cell, linearize
from .problem import Kind, Model, Problem, Request, Requests, State, Tolerances
from .quadratic import minimise_quadratic

INITIAL_DAMPING, LEAST_DAMPING = 1e-4, 1e-14
"""Relative to the unit of the damping: 1 if the damping is scaled by columns, else the largest
squared column norm. The least damping exceeds rounding errors, so that a rank-deficient matrix
becomes regular."""
FIRST_TRIED_DAMPING = 1e-12
"""The value at which the search for the first damping begins."""
GOOD_GAIN = 0.75
"""A step that crosses kinks is repeated within its cell if its gain ratio is below this."""
LEAST_GAIN = 1e-3
"""The gain ratio that an accepted step must exceed."""
GREAT_GAIN, GREAT_GAIN_FACTOR = 0.9, 0.03
"""A step with a gain ratio above the first number multiplies the damping by the second."""
LARGEST_GROWTH = 2.0**40
"""The solve ends when rejections have raised the growth of the damping to this factor."""
PROBE, LARGEST_BEND = 0.1, 0.75
"""The part of a step at which its second derivative is measured, and the largest relative length
of the correction."""

ZERO = "converged: the cost is zero"
AT_REST = "converged: no direction lowers the cost"
SHORT = "converged: steps have become too short to matter"
STUCK = "converged: no step lowers the cost"


def init(problem: Problem, start: Array) -> Requests:
    """The state before the first step.

    Raises
    ------
    SolveError
        The residual is not a vector of finite numbers.
    """
    residual = yield Request(Kind.RESIDUAL, start)
    if residual.ndim != 1 or not np.isfinite(residual).all():
        raise SolveError("The residual at the start is not a vector of finite numbers.")
    return State(start, residual, problem.cost(residual))


def step(problem: Problem, state: State) -> Requests:
    """Linearise the residual if x is new, then try one step; ``state`` is changed."""
    tolerances = problem.tolerances
    if state.cost <= max(tolerances.zero, tolerances.gain):
        state.reason = ZERO if state.cost <= tolerances.zero else SHORT
        return
    model = state.model
    if model is None:
        model = state.model = yield from linearize(problem, state)
    if _is_at_rest(model, state.cost, tolerances.gradient):
        state.reason = AT_REST
        return
    system = _damped(problem, state, model)
    trial = yield from _try(problem, state, model, system, model.low, model.high)
    if trial.predicted <= tolerances.gain and trial.x is state.x:
        state.reason = SHORT
        return
    if trial.gain < GOOD_GAIN and problem.kinks is not None:
        below, above = cell(problem.kinks, state.x)
        low, high = np.maximum(model.low, below), np.minimum(model.high, above)
        if ((trial.d < low) | (trial.d > high)).any():
            inside = yield from _try(problem, state, model, system, low, high)
            trial = inside if inside.cost < trial.cost else trial
    _judge(tolerances, state, trial)


class _Trial(NamedTuple):
    """A step d to x, the decrease of the cost that the model predicts, and the gain ratio."""

    d: Any
    x: Any
    residual: Array
    cost: float
    predicted: float
    gain: float


def _damped(problem: Problem, state: State, model: Model) -> Array:
    """The matrix of the normal equations with the damping on its diagonal."""
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
    """The least damping whose first step is at most as long as the distance of x from zero.

    Both lengths are measured by their effect on the linear model and by the largest coordinate
    (MINPACK starts its trust region so and, with other weights, trf of scipy). No residual is
    evaluated.
    """
    root, damping = np.sqrt(weights), FIRST_TRIED_DAMPING
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
    """Minimise the damped model over low ≤ d ≤ high, and evaluate the cost of the step."""
    d = -np.linalg.solve(system, model.gradient)
    bounded = ((d < low) | (d > high)).any()
    if bounded:
        d = minimise_quadratic(system, model.gradient, low, high)
    # The prediction is that of the straight step; a bent step must do at least as well.
    predicted = -float(2 * model.gradient.dot(d) + d.dot(model.normal).dot(d))
    free = not bounded and state.damping <= INITIAL_DAMPING * model.unit
    if free and predicted <= problem.tolerances.gain:
        # Neither damping nor bounds shorten the step, and it gains too little to be evaluated.
        return _Trial(d, state.x, state.residual, state.cost, predicted, 0.0)
    if problem.accelerate:
        d = yield from _bend(state, model, system, d, low, high)
    x = state.x + d
    if bounded:
        # The step meets a bound exactly, so that the next iterate is found to lie on it.
        x = np.where(d >= high, state.x + high, np.where(d <= low, state.x + low, x))
    x = np.minimum(np.maximum(x, problem.lower), problem.upper)
    residual = yield Request(Kind.RESIDUAL, x)
    cost = problem.cost(residual)
    gain = (state.cost - cost) / predicted if predicted > 0 else -math.inf
    return _Trial(d, x, residual, cost, predicted, gain)


def _bend(
    state: State, model: Model, system: Array, d: Any, low: Array, high: Array
) -> Generator[Request, Array, Array]:
    """The step plus half its geodesic acceleration, if that is a small enough correction."""
    ahead = yield Request(Kind.RESIDUAL, state.x + PROBE * d)
    if not np.isfinite(ahead).all():
        return d
    second = 2 / PROBE * ((ahead - state.residual) / PROBE - model.jacobian @ d)
    # A variable that has reached its bound stays there.
    room = np.where((d > low) & (d < high), math.inf, 0.0)
    bend = minimise_quadratic(system, second @ model.jacobian, -room, room)
    if 2 * np.linalg.norm(bend) > LARGEST_BEND * np.linalg.norm(d):
        return d
    return np.clip(d + bend / 2, low, high)


def _judge(tolerances: Tolerances, state: State, trial: _Trial) -> None:
    """Accept or reject a trial step, update the damping, and decide whether the solve ends."""
    length = float(abs(trial.x - state.x).max())
    short = length <= tolerances.step * (1 + float(abs(state.x).max()))
    if trial.gain > LEAST_GAIN and trial.cost < state.cost:
        least = max(tolerances.cost * state.cost, tolerances.gain)
        idle = state.cost - trial.cost <= least and trial.predicted <= 10 * least
        state.x, state.residual, state.cost = trial.x, trial.residual, trial.cost
        state.damping *= (
            GREAT_GAIN_FACTOR if trial.gain > GREAT_GAIN else 1 - (2 * trial.gain - 1) ** 3
        )
        state.growth = 2.0
        state.iterations += 1
        state.model = None
        # No later step can gain more than the cost that is left.
        if short or idle or state.cost <= tolerances.gain:
            state.reason = SHORT
    elif short or trial.predicted <= 2e-16 * state.cost:
        state.reason = SHORT
    else:
        state.damping *= state.growth
        state.growth *= 2
        if state.growth > LARGEST_GROWTH:
            state.reason = STUCK


def _is_at_rest(model: Model, cost: float, tolerance: float) -> bool:
    """Whether no coordinate can move and lower the cost."""
    slopes = abs(model.gradient)
    movable = np.where(model.gradient > 0, model.low < 0, model.high > 0)
    steep = slopes > tolerance * np.sqrt(model.columns * cost)
    return not (movable & steep).any()
