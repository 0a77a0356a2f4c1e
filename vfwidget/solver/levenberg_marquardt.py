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

from ..arrays import Array, holds_anywhere
from ..errors import SolveError
from .linearize import cell, linearize, linearize_closely, near_kinks
from .model import Model
from .problem import Kind, Problem, Request, Requests, State, check_size
from .quadratic import Quadratic, minimise_over_box
from .status import (
    COST_FLOOR,
    NO_DECREASE,
    SMALL_DECREASE,
    SMALL_STEP,
    STATIONARY,
    Outcome,
)

INITIAL_DAMPING = 1e-4
"""The first damping, if it is not scaled by columns."""
FIRST_DAMPING, FIRST_FACTOR, LAST_DAMPING = 1e-12, 4.0, 1e12
"""Range and factor of the search for a first damping that is scaled by columns."""
FIRST_DECREASE = 1e-3
"""The first step achieves at least this share of the decrease that is predicted without damping."""
GOOD_GAIN = 0.75
"""A step that crosses kinks is repeated within its cell if its gain ratio is below this."""
LEAST_GAIN, FAIR_GAIN = 1e-3, 0.25
"""The gain ratio that an accepted step must exceed, and the one above which a small decrease
means convergence."""
GREAT_GAIN, GREAT_FACTOR, GREAT_GRADED_FACTOR = 0.9, 0.03, 1e-4
"""A step with a gain ratio above the first number multiplies the damping by the second, or by the
third if the rows are graded: the damping then has to fall by many orders of magnitude."""
LARGEST_GROWTH = 2.0**40
"""The solve ends when rejections have raised the growth of the damping to this factor."""
PROBE, LARGEST_BEND = 0.1, 0.75
"""The part of a step at which its second derivative is measured, and the largest relative length
of the correction."""
NEGLIGIBLE = 1e-15
"""A decrease by a smaller share of the cost is within the rounding errors of the cost."""
SMALLEST = 1e-275
"""A squared column norm below this counts as zero."""
MUCH, MANY = 1e-3, 1e3
"""Where steps gain little, the solve has stalled if the model promises more without damping than
this share of the cost, and than so many times the least decrease."""
CLOSER = 1e-5
"""A solve that has stalled on a kink goes on if the limits of the slopes promise more than this
share of the cost."""
LATE = 1e-10
"""The solve may be about to end if the predicted decrease is below this share of the cost."""


def init(problem: Problem, start: Array) -> Requests:
    """The state before the first step.

    Raises
    ------
    SolveError
        The residual is not a vector of finite numbers, or the problem is too large.
    """
    residual = yield Kind.RENEW if problem.renews else Kind.RESIDUAL, start
    check_size(residual.size, start.size)
    return State(start, residual, finite_cost(problem, residual, start, "at the start"))


def finite_cost(problem: Problem, residual: Array, x: Array, when: str) -> float:
    """The cost at the start, or after the residual has been renewed, as ``when`` says.

    Raises
    ------
    SolveError
        The residual is not a vector of finite numbers.
    """
    cost = problem.cost(residual, x) if residual.ndim == 1 else math.inf
    if not math.isfinite(cost):
        bad = np.count_nonzero(~np.isfinite(residual**2))
        raise SolveError(
            f"The residual {when} must be a vector of finite numbers; it has the shape "
            f"{residual.shape}, and {bad} of its values are NaN, infinite or too large to square."
        )
    return cost


def step(problem: Problem, state: State) -> Requests:
    """Linearise the residual if x is new, then try one step; ``state`` is changed."""
    if state.cost <= problem.tolerances.cost_floor:
        state.outcome = COST_FLOOR
        return
    if state.cost <= problem.tolerances.absolute_cost:
        # No step can lower the cost by more than the cost itself.
        state.outcome = SMALL_DECREASE
        return
    if state.model is None:
        state.model = yield from linearize(problem, state)
    model = state.model
    quadratic = _damped(problem, state, model)
    proposal = _propose(model, quadratic, model.low, model.high)
    if proposal.predicted <= max(problem.tolerances.absolute_cost, LATE * state.cost):
        state.outcome = _outcome_before_step(problem, state, model, proposal)
        if state.outcome is not None:
            return
    trial = yield from _try(problem, state, quadratic, proposal)
    if trial.gain < GOOD_GAIN and problem.kinks is not None:
        below, above = cell(problem.kinks, state.x)
        if ((proposal.d < below) | (proposal.d > above)).any():
            low, high = np.maximum(model.low, below), np.minimum(model.high, above)
            confined = _propose(model, quadratic, low, high)
            inside = yield from _try(problem, state, quadratic, confined)
            trial = inside if inside.cost < trial.cost else trial
    if trial.gain > LEAST_GAIN and trial.cost < state.cost:
        _accept(problem, state, model, trial)
    else:
        _reject(problem, state, model, trial)
        if state.outcome is NO_DECREASE and not model.holds_limits:
            yield from _look_closely(problem, state)


def _look_closely(problem: Problem, state: State) -> Requests:
    """On a kink, replace a model whose decrease no step finds; the new one may be stationary."""
    if near_kinks(problem, state.x) is None:
        return
    state.model = model = yield from linearize_closely(problem, state)
    model.holds_limits = True
    if _is_stationary(model, state.cost, problem.tolerances.gradient):
        state.outcome = STATIONARY
    elif _is_near(problem, state, model):
        state.outcome = SMALL_DECREASE
    elif _without_damping(state, model).predicted > CLOSER * state.cost:
        # Rejections have raised the damping, so that a new one is chosen.
        state.outcome, state.damping, state.growth = None, 0.0, 2.0


class _Proposal(NamedTuple):
    """A step d between low and high, and the decrease of the cost that the model predicts.

    ``bounded`` says whether the range shortens the step.
    """

    d: Array
    low: Array
    high: Array
    bounded: bool
    predicted: float


class _Trial(NamedTuple):
    """The result of a step: the new x, its cost, the predicted decrease and the gain ratio."""

    x: Array
    residual: Array
    cost: float
    predicted: float
    gain: float


def _propose(model: Model, quadratic: Quadratic, low: Array, high: Array) -> _Proposal:
    start = model.latest
    if start is not None:
        start = np.minimum(np.maximum(start, low), high)
    d, bounded = minimise_over_box(quadratic, low, high, start)
    if low is model.low:
        model.latest = d
    return _Proposal(d, low, high, bounded, model.decrease(d))


def _damped(problem: Problem, state: State, model: Model) -> Quadratic:
    """The model with the damping of the state, which is chosen at the first step."""
    if problem.scale_by_columns:
        state.scale = np.maximum(state.scale, model.columns)
        weights = _nonzero(state.scale)
        state.damping = state.damping or _first_damping(state, model, weights)
    else:
        state.scale = max(state.scale, model.steepest)
        weights = _nonzero(state.scale)
        state.damping = state.damping or INITIAL_DAMPING * model.spread
    state.damping = max(state.damping, model.least_damping)
    return model.damped(state.damping * weights)


def _nonzero(scale: Any) -> Any:
    """The scale of the damping; 1 for a column that is zero or too small to divide by."""
    if isinstance(scale, float):
        return scale if scale > SMALLEST else 1.0
    return np.where(scale > SMALLEST, scale, 1.0)


def _first_damping(state: State, model: Model, weights: Array) -> float:
    """The least damping whose first step is at most as long as the distance of x from zero.

    Both lengths are measured by their effect on the linear model and by the largest coordinate
    (MINPACK starts its trust region so and, with other weights, trf of scipy). No residual is
    evaluated. A start very close to zero would allow only tiny steps, so the decrease that the
    model predicts is a second criterion.
    """
    root = np.sqrt(weights)
    reach = float(np.linalg.norm(root * state.x)) or 1.0
    far = float(abs(state.x).max()) or math.inf
    damping, most = 100 * model.least_damping, None
    while damping < LAST_DAMPING:
        d, _, _, _, decrease = _propose(
            model, model.damped(damping * weights), model.low, model.high
        )
        most = decrease if most is None else most
        near = np.linalg.norm(root * d) <= reach and abs(d).max() <= far
        if near or decrease <= FIRST_DECREASE * most:
            break
        damping = max(FIRST_FACTOR * damping, FIRST_DAMPING)
    return damping


def _without_damping(state: State, model: Model) -> _Proposal:
    """The step that damping does not shorten."""
    least = model.damped(model.least_damping * _nonzero(state.scale))
    return _propose(model, least, model.low, model.high)


def _outcome_before_step(
    problem: Problem, state: State, model: Model, proposal: _Proposal
) -> Outcome | None:
    """The outcome if the step is not worth the evaluation of a residual, else None."""
    tolerances = problem.tolerances
    if _is_stationary(model, state.cost, tolerances.gradient):
        return STATIONARY
    if proposal.predicted <= tolerances.absolute_cost:
        most = _without_damping(state, model).predicted
        if most <= tolerances.absolute_cost:
            return SMALL_DECREASE
    return None


def _is_stationary(model: Model, cost: float, tolerance: float) -> bool:
    """Whether no coordinate can move and lower the cost."""
    slopes = abs(model.gradient)
    movable = np.where(model.gradient > 0, model.low < 0, model.high > 0)
    steep = slopes > tolerance * math.sqrt(cost) * np.sqrt(model.columns)
    return not (movable & steep).any()


def _try(
    problem: Problem, state: State, quadratic: Quadratic, proposal: _Proposal
) -> Generator[Request, Array, _Trial]:
    """Evaluate the cost of a step."""
    d, low, high, bounded, predicted = proposal
    if problem.accelerate:
        d = yield from _bend(state, quadratic, proposal)
    x = state.x + d
    if bounded:
        # The step meets a bound exactly, so that the next iterate is found to lie on it. The sum
        # of x and the distance to the bound may be the number next to it.
        for met, end, bound in (d <= low, low, problem.lower), (d >= high, high, problem.upper):
            if not holds_anywhere(met):
                continue
            x = np.where(met, np.where(end == bound - state.x, bound, state.x + end), x)
    x = np.minimum(np.maximum(x, problem.lower), problem.upper)
    residual = yield Kind.RESIDUAL, x
    cost = problem.cost(residual, x)
    # The prediction is that of the straight step; a bent step must do at least as well.
    gain = (state.cost - cost) / predicted if predicted > 0 else -math.inf
    return _Trial(x, residual, cost, predicted, gain)


def _bend(
    state: State, quadratic: Quadratic, proposal: _Proposal
) -> Generator[Request, Array, Array]:
    """The step plus half its geodesic acceleration, if that is a small enough correction."""
    d, low, high = proposal.d, proposal.low, proposal.high
    ahead = yield Kind.RESIDUAL, state.x + PROBE * d
    if not np.isfinite(ahead).all():
        return d
    assert state.model is not None
    jacobian = state.model.jacobian
    second = 2 / PROBE * ((ahead - state.residual) / PROBE - jacobian.dot(d))
    # A variable that has reached its bound stays there.
    room = np.where((d > low) & (d < high), math.inf, 0.0)
    bend, _ = minimise_over_box(quadratic.with_linear(second.dot(jacobian)), -room, room)
    if 2 * np.linalg.norm(bend) > LARGEST_BEND * np.linalg.norm(d):
        return d
    return np.clip(d + bend / 2, low, high)


def _accept(problem: Problem, state: State, model: Model, trial: _Trial) -> None:
    """Move to the trial point, update the damping, and decide whether the solve ends."""
    least = problem.tolerances.least_decrease(state.cost)
    small = state.cost - trial.cost <= least and trial.predicted <= 10 * least
    short = _is_short(problem, state, trial.x - state.x)
    if short or (small and trial.gain > FAIR_GAIN):
        # A short step means convergence, unless only the damping keeps it short.
        if _is_near(problem, state, model):
            state.outcome = SMALL_STEP if short else SMALL_DECREASE
        elif trial.gain <= GREAT_GAIN:
            # A model that promises much does not hold: x zigzags along a kink that is not listed.
            much = max(MUCH * state.cost, MANY * least)
            far = _without_damping(state, model).predicted if small else math.inf
            state.outcome = SMALL_DECREASE if far <= much else NO_DECREASE
    state.x, state.residual, state.cost = trial.x, trial.residual, trial.cost
    if trial.gain > GREAT_GAIN:
        state.damping *= GREAT_GRADED_FACTOR if model.graded else GREAT_FACTOR
    else:
        state.damping *= 1 - (2 * trial.gain - 1) ** 3
    state.growth = 2.0
    state.iterations += 1
    state.model = None


def _reject(problem: Problem, state: State, model: Model, trial: _Trial) -> None:
    """Increase the damping, or end the solve if no shorter step can help."""
    short = _is_short(problem, state, trial.x - state.x)
    if short or trial.predicted <= NEGLIGIBLE * state.cost or state.growth > LARGEST_GROWTH:
        converged = SMALL_STEP if short else SMALL_DECREASE
        state.outcome = converged if _is_near(problem, state, model) else NO_DECREASE
    state.damping *= state.growth
    state.growth *= 2


def _is_short(problem: Problem, state: State, d: Array) -> bool:
    length, size = math.sqrt(d.dot(d)), math.sqrt(state.x.dot(state.x))
    return length <= problem.tolerances.step * (1 + size)


def _is_near(problem: Problem, state: State, model: Model) -> bool:
    """Whether even a step without damping is short, or is predicted to gain little."""
    far = _without_damping(state, model)
    least = max(problem.tolerances.least_decrease(state.cost), NEGLIGIBLE * state.cost)
    return far.predicted <= 10 * (least + model.rounding(state.x)) or _is_short(
        problem, state, far.d
    )
