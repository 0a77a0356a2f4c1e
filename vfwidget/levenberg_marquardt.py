r"""The iteration of :func:`vfwidget.least_squares`: init, step, terminate; many problems at once.

**The step.** At each iterate the residual is replaced by its linear model and the damped model
is minimised over the box exactly (:mod:`vfwidget.quadratic`). Bounds that the model pushes
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
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from .arrays import namespace
from .errors import SolveError
from .loss import rescale, robust_cost
from .quadratic import minimise_quadratic

NUDGE = 1e-8
"""How far beside a kink its one-sided derivative is asked for."""
INITIAL_DAMPING, LEAST_DAMPING = 1e-4, 1e-13
"""Relative to the largest squared column of the Jacobian."""
WEAKEST = 1e-12
"""A column this small, squared and relative, is damped as if it were larger."""
GOOD_GAIN = 0.75
"""A step that crosses kinks and gains less than this share of the promised is tried confined."""
LEAST_GAIN = 1e-3
GROWN_OUT = 2.0**40
"""The damping's growth at which no step helps any more."""
PROBE, MOST_BENT = 0.1, 0.75
"""Where along a step its second derivative is measured, and how much of one it may correct."""

REASONS = (
    "running",
    "converged: the cost is zero",
    "converged: no direction lowers the cost",
    "converged: steps have become too short to matter",
    "converged: no step lowers the cost",
)
RUNNING, ZERO, STATIONARY, SHORT, STUCK = range(5)


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
    """B problems of n variables and m residuals, all numpy or all torch.

    Attributes
    ----------
    residual, jacobian : callable
        (B, n) to (B, m) and to (B, m, n).
    lower, upper : (n,) or (B, n)
    kinks : (n, q), optional
        Padded with infinity.
    scale_by_columns, accelerate : bool
    loss, loss_scale
        See :mod:`vfwidget.loss`.
    tolerances : Tolerances
    """

    residual: Callable[[Any], Any]
    jacobian: Callable[[Any], Any]
    lower: Any
    upper: Any
    kinks: Any | None = None
    scale_by_columns: bool = True
    accelerate: bool = False
    loss: str = "linear"
    loss_scale: float = 1.0
    tolerances: Tolerances = field(default_factory=Tolerances)

    def evaluate(self, x: Any) -> tuple[Any, Any]:
        """Residuals (B, m) and costs (B,); a cost that is not finite counts as infinite."""
        residual = self.residual(x)
        cost = robust_cost(residual, self.loss, self.loss_scale)
        xp = namespace(x)
        return residual, xp.where(xp.isfinite(cost), cost, xp.inf)


class Model(NamedTuple):
    """The linear model at the present iterates, and how far each coordinate may go in it."""

    jacobian: Any
    gradient: Any
    normal: Any
    low: Any
    high: Any
    cell_low: Any
    cell_high: Any


@dataclass
class State:
    """Where B solves stand; :func:`init` makes it, :func:`step` moves it.

    Attributes
    ----------
    x : (B, n)
        The best points so far.
    residual : (B, m)
    cost : (B,)
    damping, growth : (B,)
        Of Levenberg–Marquardt: the present damping and what a rejection multiplies it by.
    scale : (B, n)
        Squared column norms that damping weighs by, their greatest so far.
    iterations : (B,)
        Accepted steps.
    reason : (B,)
        Index into :data:`REASONS`; 0 while there is more to do.
    model : Model, optional
        Kept while steps are being rejected.
    """

    x: Any
    residual: Any
    cost: Any
    damping: Any
    growth: Any
    scale: Any
    iterations: Any
    reason: Any
    model: Model | None = None


def init(problem: Problem, start: Any) -> State:
    """The state before the first step, at starts (B, n).

    Raises
    ------
    SolveError
        A residual is not a vector of finite numbers.
    """
    xp = namespace(start)
    residual, cost = problem.evaluate(start)
    if residual.ndim != 2 or not xp.isfinite(residual).all():
        raise SolveError("The residual at the start is not a vector of finite numbers.")
    zero = xp.zeros_like(cost)
    return State(
        start, residual, cost, zero, zero + 2, xp.zeros_like(start), zero + 0, zero + RUNNING
    )  # fmt: skip


def step(problem: Problem, state: State) -> State:
    """Try one step of every solve that is running; ``state`` is changed and returned."""
    xp = namespace(state.x)
    model = state.model or _linearise(problem, state)
    _terminate_at_rest(problem, state, model)
    running = state.reason == RUNNING
    if not running.any():
        return state
    strongest = xp.amax(_diagonal(model.normal), -1)
    state.damping = xp.where(state.damping == 0, INITIAL_DAMPING * strongest, state.damping)
    state.damping = xp.maximum(state.damping, LEAST_DAMPING * strongest)
    weights = xp.ones_like(state.scale)
    if problem.scale_by_columns:
        largest = xp.amax(state.scale, -1)[:, None]
        weights = xp.maximum(state.scale, WEAKEST * largest) / xp.where(largest > 0, largest, 1.0)
    damp = state.damping[:, None] * xp.where(weights > 0, weights, 1.0)
    system = model.normal + damp[:, :, None] * xp.eye(damp.shape[-1], **_kind(damp))

    trial = _try(problem, state, model, system, model.low, model.high)
    if problem.kinks is not None:
        poor = running & trial.crosses & (trial.gain < GOOD_GAIN)
        if poor.any():
            inside = _try(problem, state, model, system, model.cell_low, model.cell_high)
            trial = _choose(poor & (inside.cost < trial.cost), inside, trial)
    _judge(problem, state, trial, running)
    return state


def terminate(problem: Problem, state: State, max_iterations: int) -> bool:
    """Whether every solve has a reason to stop or has used up its iterations."""
    return bool(((state.reason != RUNNING) | (state.iterations >= max_iterations)).all())


def active_bounds(problem: Problem, state: State) -> Any:
    """-1 or 1, (B, n), where the lower or upper bound holds a solve against its slope, else 0."""
    model = state.model or _linearise(problem, state)
    lower = (state.x <= problem.lower) & (model.gradient > 0)
    upper = (state.x >= problem.upper) & (model.gradient < 0)
    return upper * 1 - lower * 1


class _Trial(NamedTuple):
    x: Any
    residual: Any
    cost: Any
    promised: Any
    gain: Any
    crosses: Any


def _try(problem: Problem, state: State, model: Model, system: Any, low: Any, high: Any) -> _Trial:
    """Minimise the damped model between two walls, and see what the step is worth."""
    xp = namespace(state.x)
    d = minimise_quadratic(system, model.gradient, low, high)
    curve = (d * (model.normal @ d[..., None])[..., 0]).sum(-1)
    # What the model promises is for the straight step; the bent one is to keep it better.
    promised = -(2 * (model.gradient * d).sum(-1) + curve)
    if problem.accelerate:
        d = _bend(problem, state, model, system, d, low, high)
    # Walls are met exactly, so that the next iterate knows where it stands.
    x = xp.where(d >= high, state.x + high, xp.where(d <= low, state.x + low, state.x + d))
    x = _snap(problem, xp.clip(x, problem.lower, problem.upper))
    residual, cost = problem.evaluate(x)
    gain = xp.where(promised > 0, state.cost - cost, -xp.inf) / xp.where(
        promised > 0, promised, 1.0
    )
    crosses = ((d < model.cell_low) | (d > model.cell_high)).any(-1)
    return _Trial(x, residual, cost, promised, gain, crosses)


def _bend(
    problem: Problem, state: State, model: Model, system: Any, d: Any, low: Any, high: Any
) -> Any:
    """The step with half its geodesic acceleration, where that is no more than a correction."""
    xp = namespace(d)
    ahead = problem.residual(state.x + PROBE * d)
    straight = (model.jacobian @ d[..., None])[..., 0]
    second = 2 / PROBE * ((ahead - state.residual) / PROBE - straight)
    pull = (second[..., None, :] @ model.jacobian)[..., 0, :]
    # What a wall holds stays there.
    room = (d > low) & (d < high)
    bend = minimise_quadratic(
        system, pull, xp.where(room, -xp.inf, 0.0), xp.where(room, xp.inf, 0.0)
    )
    size = (d * d).sum(-1) ** 0.5
    small = 2 * (bend * bend).sum(-1) ** 0.5 <= MOST_BENT * size
    small = small & xp.isfinite(ahead).all(-1)
    return xp.where(small[:, None], xp.clip(d + bend / 2, low, high), d)


def _choose(mask: Any, first: _Trial, second: _Trial) -> _Trial:
    xp = namespace(mask)
    fields = []
    for a, b in zip(first, second, strict=True):
        fields.append(xp.where(mask[:, None] if a.ndim == 2 else mask, a, b))
    return _Trial(*fields)


def _judge(problem: Problem, state: State, trial: _Trial, running: Any) -> None:
    """Accept or reject each trial, set the damping, and see whether there is reason to stop."""
    xp = namespace(state.x)
    tolerances = problem.tolerances
    accepted = running & (trial.gain > LEAST_GAIN) & (trial.cost < state.cost)
    rejected = running & ~accepted
    length = xp.amax(abs(trial.x - state.x), -1)
    short = length <= tolerances.step * (1 + xp.amax(abs(state.x), -1))
    least = xp.clip(tolerances.cost * state.cost, tolerances.gain, None)
    idle = (state.cost - trial.cost <= least) & (trial.promised <= 10 * least)
    nothing = trial.promised <= 2e-16 * state.cost
    ended = (accepted & (short | idle)) | (rejected & (short | nothing))

    shrink = xp.clip(1 - (2 * xp.clip(trial.gain, -1.0, 1.5) - 1) ** 3, 0.1, None)
    state.damping = state.damping * xp.where(
        accepted, shrink, xp.where(rejected, state.growth, 1.0)
    )
    state.growth = xp.where(accepted, 2.0, xp.where(rejected, 2 * state.growth, state.growth))
    state.reason = xp.where(ended, SHORT, state.reason)
    state.reason = xp.where(rejected & ~ended & (state.growth > GROWN_OUT), STUCK, state.reason)
    state.iterations = state.iterations + accepted
    if accepted.any():
        state.x = xp.where(accepted[:, None], trial.x, state.x)
        state.residual = xp.where(accepted[:, None], trial.residual, state.residual)
        state.cost = xp.where(accepted, trial.cost, state.cost)
        state.model = None


def _terminate_at_rest(problem: Problem, state: State, model: Model) -> None:
    """Stop where the cost is nothing, or where no coordinate may move and lower it."""
    xp = namespace(state.x)
    movable = ((model.gradient > 0) & (model.low < 0)) | ((model.gradient < 0) & (model.high > 0))
    sizes = (_diagonal(model.normal) * state.cost[:, None]) ** 0.5
    slopes = xp.where(movable, abs(model.gradient), 0.0) / xp.where(sizes > 0, sizes, 1.0)
    at_rest = xp.amax(slopes, -1) <= problem.tolerances.gradient
    running = state.reason == RUNNING
    state.reason = xp.where(running & at_rest, STATIONARY, state.reason)
    state.reason = xp.where(running & (state.cost <= problem.tolerances.zero), ZERO, state.reason)


def _linearise(problem: Problem, state: State) -> Model:
    """The Jacobian of the sides that go down, and the room there is on them."""
    xp = namespace(state.x)
    x = state.x
    low, high = problem.lower - x, problem.upper - x
    if problem.kinks is None:
        jacobian = _checked_jacobian(problem, state, x)
        below, above = low, high
    else:
        gaps = problem.kinks - x[..., None]
        on_kink = (abs(gaps) < NUDGE).any(-1)
        right, left = on_kink & (high > 0), on_kink & (low < 0)
        both = left & right
        jacobian = _checked_jacobian(problem, state, x + NUDGE * right - NUDGE * (on_kink & ~right))
        if both.any():
            behind = _checked_jacobian(problem, state, x - NUDGE * left + NUDGE * (on_kink & ~left))
            falls_ahead = -_pull(problem, state, jacobian)
            falls_behind = _pull(problem, state, behind)
            ahead_down, behind_down = both & (falls_ahead > 0), both & (falls_behind > 0)
            take_behind = behind_down & (~ahead_down | (falls_behind > falls_ahead))
            take_ahead = ahead_down & ~take_behind
            jacobian = xp.where(take_behind[..., None, :], behind, jacobian)
            low = xp.where(both & ~take_behind, 0.0, low)
            high = xp.where(both & ~take_ahead, 0.0, high)
        # The cell's walls are the next kinks on either side.
        above = xp.amin(xp.where(gaps > NUDGE, gaps, xp.inf), -1)
        below = xp.amax(xp.where(gaps < -NUDGE, gaps, -xp.inf), -1)
    residual, jacobian = rescale(state.residual, jacobian, problem.loss, problem.loss_scale)
    transposed = xp.swapaxes(jacobian, -1, -2)
    normal = transposed @ jacobian
    state.scale = xp.maximum(state.scale, _diagonal(normal))
    state.model = Model(
        jacobian,
        (transposed @ residual[..., None])[..., 0],
        normal,
        low,
        high,
        xp.maximum(low, below),
        xp.minimum(high, above),
    )
    return state.model


def _pull(problem: Problem, state: State, jacobian: Any) -> Any:
    """Half the cost's slope, (B, n), by this Jacobian."""
    residual, jacobian = rescale(state.residual, jacobian, problem.loss, problem.loss_scale)
    return (residual[..., None, :] @ jacobian)[..., 0, :]


def _checked_jacobian(problem: Problem, state: State, x: Any) -> Any:
    jacobian = problem.jacobian(x)
    wanted = (*state.residual.shape, x.shape[-1])
    if tuple(jacobian.shape) != wanted:
        raise SolveError(
            f"The Jacobian has shape {tuple(jacobian.shape)[1:]}; {wanted[1]} residuals of "
            f"{wanted[2]} variables need {wanted[1:]}."
        )
    if not namespace(x).isfinite(jacobian).all():
        raise SolveError("The Jacobian holds NaN or infinity.")
    return jacobian


def _snap(problem: Problem, x: Any) -> Any:
    """Put coordinates that lie within rounding of a kink onto it."""
    if problem.kinks is None:
        return x
    xp = namespace(x)
    near = abs(problem.kinks - x[..., None]) < NUDGE
    kink = xp.amax(xp.where(near, problem.kinks, -xp.inf), -1)
    return xp.where(near.any(-1), xp.clip(kink, problem.lower, problem.upper), x)


def _diagonal(matrices: Any) -> Any:
    return namespace(matrices).einsum("...ii->...i", matrices)


def _kind(array: Any) -> dict[str, Any]:
    kind = {"dtype": array.dtype}
    if namespace(array).__name__ == "torch":
        kind["device"] = array.device
    return kind
