"""Whole solves: step until there is a reason to stop, for one problem or for many at once."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from time import perf_counter
from typing import Any, TypeAlias, cast

import numpy as np

from ..arrays import Array, holds_anywhere
from ..errors import SolveError
from .levenberg_marquardt import init, step
from .linearize import OFFSET, near_kinks
from .problem import Kind, Problem, Requests, State, is_count
from .renewal import Renewal
from .status import OUT_OF_TIME, out_of_iterations

Function: TypeAlias = Callable[[Array], Array]
History: TypeAlias = list[tuple[Array, float]]
"""x and the cost at the start and after each accepted step."""


def solve_whole(
    problem: Problem,
    start: Array,
    max_iterations: int,
    history: History,
    deadline: float = math.inf,
) -> Requests:
    """Step until there is a reason to stop, and return the final State.

    The start, each accepted point and its cost are appended to ``history``; the result is its
    last entry. ``deadline`` is a value of ``time.perf_counter()``.
    """
    if not is_count(max_iterations):
        raise SolveError(f"max_iterations must be a whole number ≥ 0; received {max_iterations!r}.")
    state: State = yield from init(problem, start)
    history.append((state.x, state.cost))
    renewal = Renewal(problem, state.x, state.cost) if problem.renews else None
    while state.outcome is None:
        if state.iterations >= max_iterations:
            state.outcome = out_of_iterations(max_iterations)
            break
        if perf_counter() > deadline:
            state.outcome = OUT_OF_TIME
            break
        count, damping = state.iterations, state.damping
        yield from step(problem, state)
        if state.iterations > count:
            if renewal is not None:
                yield from renewal.after_step(state, damping)
            history.append((state.x, state.cost))
    if renewal is not None:
        yield from renewal.finish(state)
        if state.x is not history[-1][0]:
            history.append((state.x, state.cost))
    return state


def answer(requests: Requests, functions: Mapping[Kind, Function]) -> Any:
    """Evaluate the functions that a generator requests until it returns; its return value."""
    try:
        kind, x = next(requests)
        while True:
            kind, x = requests.send(functions[kind](x))
    except StopIteration as end:
        return end.value


def minimise(
    problem: Problem,
    start: Array,
    residual: Function,
    jacobian: Function,
    renew: Function | None = None,
    *,
    max_iterations: int = 100,
    history: History | None = None,
    deadline: float = math.inf,
    quiet: bool = True,
) -> State:
    """Solve one problem.

    Parameters
    ----------
    problem : Problem
    start : (n,) array
        A point within the bounds.
    residual, jacobian : callable
        x (n,) to (m,), and x to (m, n).
    renew : callable, optional
        x to (m,), where m may change. Required if ``problem.renews``: it updates what the
        residual depends on, and returns the residual (see :class:`.problem.Kind`).
    max_iterations : int
        The largest number of accepted steps. Default 100.
    history : list, optional
        x and the cost are appended at the start and after each accepted step.
    deadline : float
        The value of ``time.perf_counter()`` after which no further step is tried. The step that
        runs at that time is finished. Default: no limit.

    Returns
    -------
    State

    Raises
    ------
    SolveError
        The residual at the start or a Jacobian is not finite, or has the wrong shape; or
        ``renew`` is missing.
    """
    if problem.renews and renew is None:
        raise SolveError("This problem renews its residual between steps; pass the function renew.")
    history = [] if history is None else history
    requests = solve_whole(problem, start, max_iterations, history, deadline)
    functions = {Kind.RESIDUAL: residual, Kind.JACOBIAN: jacobian}
    if renew is not None:
        functions[Kind.RENEW] = renew
    if not quiet:
        return cast(State, answer(requests, functions))
    with _quiet():
        return cast(State, answer(requests, functions))


def minimise_batch(
    problems: Sequence[Problem],
    starts: Array,
    residual: Function,
    jacobian: Function,
    max_iterations: int,
    histories: Sequence[History],
) -> list[State]:
    """Solve B problems whose functions are evaluated together: (B, n) to (B, m) and (B, m, n)."""
    functions = {Kind.RESIDUAL: residual, Kind.JACOBIAN: jacobian}
    solves = [
        solve_whole(problem, start, max_iterations, history)
        for problem, start, history in zip(problems, starts, histories, strict=True)
    ]
    states: dict[int, State] = {}
    points = starts.copy()
    requests = {row: next(solve) for row, solve in enumerate(solves)}
    with _quiet():
        while requests:
            # A row without a request of this kind is evaluated at its last point, and ignored.
            for row, (_, x) in requests.items():
                points[row] = x
            kinds = {kind for kind, _ in requests.values()}
            values = {kind: functions[kind](points) for kind in kinds}
            for row, (kind, _) in list(requests.items()):
                try:
                    requests[row] = solves[row].send(values[kind][row])
                except StopIteration as end:
                    states[row] = end.value
                    del requests[row]
    return [states[row] for row in range(len(solves))]


def _quiet() -> np.errstate:
    """Silence NumPy's warnings: a trial whose residual overflows has an infinite cost."""
    return np.errstate(over="ignore", invalid="ignore")


def active_bounds(
    problem: Problem, state: State, jacobian: Function, inward: bool = False
) -> Array:
    """-1 or 1, (n,), for a variable that its lower or upper bound keeps from moving, else 0.

    The cost would fall if the variable could pass the bound. The Jacobian is evaluated if the
    state holds no model. If it is the derivative into the range at bounds that are no kinks
    (``inward``), it is evaluated at x, where it may be known; else just within the bounds.
    """
    at_lower, at_upper = state.x <= problem.lower, state.x >= problem.upper
    if not holds_anywhere(at_lower | at_upper):
        return np.zeros(len(state.x), dtype=int)
    if state.model is not None:
        gradient = state.model.gradient
    else:
        known = inward and near_kinks(problem, state.x) is None
        place = state.x if known else within_bounds(problem, state.x)
        gradient = problem.half_gradient(state.residual, jacobian(place), state.x)
    return (at_upper & (gradient < 0)).astype(int) - (at_lower & (gradient > 0))


def within_bounds(problem: Problem, x: Array) -> Array:
    """The point x (n,), moved off the bounds: the slope within them is the one that counts."""
    inside: Array = x + OFFSET * (x <= problem.lower) - OFFSET * (x >= problem.upper)
    return inside
