"""Whole solves: step until there is a reason to stop, for one problem or for many at once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias, cast

import numpy as np

from ..arrays import Array
from .levenberg_marquardt import init, step
from .linearize import OFFSET, half_gradient
from .problem import Kind, Problem, Requests, State

Function: TypeAlias = Callable[[Array], Array]
History: TypeAlias = list[tuple[Array, float]]
"""x and the cost at the start and after each accepted step."""


def solve_whole(problem: Problem, start: Array, max_iterations: int, history: History) -> Requests:
    """Step until there is a reason to stop or the iteration limit is reached.

    The start and each accepted point are appended to ``history``. Returns the final State.
    """
    state: State = yield from init(problem, start)
    history.append((state.x, state.cost))
    while not state.reason and state.iterations < max_iterations:
        count = state.iterations
        yield from step(problem, state)
        if state.iterations > count:
            history.append((state.x, state.cost))
    return state


def answer(requests: Requests, residual: Function, jacobian: Function) -> Any:
    """Evaluate the functions that a generator requests until it returns; its return value."""
    functions = {Kind.RESIDUAL: residual, Kind.JACOBIAN: jacobian}
    with _quiet():
        try:
            request = next(requests)
            while True:
                request = requests.send(functions[request.kind](request.x))
        except StopIteration as end:
            return end.value


def minimise(
    problem: Problem,
    start: Array,
    residual: Function,
    jacobian: Function,
    max_iterations: int = 100,
    history: History | None = None,
) -> State:
    """Solve one problem.

    Parameters
    ----------
    problem : Problem
    start : (n,) array
        A point within the bounds.
    residual, jacobian : callable
        x (n,) to (m,), and x to (m, n).
    max_iterations : int
        The largest number of accepted steps. Default 100.
    history : list, optional
        x and the cost are appended at the start and after each accepted step.

    Returns
    -------
    State
    """
    history = [] if history is None else history
    requests = solve_whole(problem, start, max_iterations, history)
    return cast(State, answer(requests, residual, jacobian))


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
            for row, request in requests.items():
                points[row] = request.x
            kinds = {request.kind for request in requests.values()}
            values = {kind: functions[kind](points) for kind in kinds}
            for row, request in list(requests.items()):
                try:
                    requests[row] = solves[row].send(values[request.kind][row])
                except StopIteration as end:
                    states[row] = end.value
                    del requests[row]
    return [states[row] for row in range(len(solves))]


def _quiet() -> np.errstate:
    """Silence NumPy's warnings: a trial whose residual overflows has an infinite cost."""
    return np.errstate(over="ignore", invalid="ignore")


def active_bounds(problem: Problem, state: State, jacobian: Function) -> Array:
    """-1 or 1, (n,), for a variable that its lower or upper bound keeps from moving, else 0.

    The cost would fall if the variable could pass the bound. The Jacobian is evaluated if the
    state holds no model.
    """
    at_lower, at_upper = state.x <= problem.lower, state.x >= problem.upper
    if not (at_lower | at_upper).any():
        return np.zeros(len(state.x), dtype=int)
    if state.model is not None:
        gradient = state.model.gradient
    else:
        # The slope within the bounds is the one that counts.
        inside = state.x + OFFSET * at_lower - OFFSET * at_upper
        gradient = half_gradient(problem, state, jacobian(inside))
    return (at_upper & (gradient < 0)).astype(int) - (at_lower & (gradient > 0))
