"""One descent of an energy: the solver, run from one point."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..arrays import Array, BoolArray, holds_anywhere
from ..solver.drivers import History, active_bounds, minimise
from ..solver.problem import Problem, State, Tolerances, products
from ..solver.status import ITERATION_LIMIT, TIME_LIMIT, Outcome
from ..text.place import AXES
from ..threads import one_thread
from .energy import Energy
from .term import TermResult

SMALL = 2**15
"""Multiplications of a step, below which BLAS does not divide a product among threads."""


class Descent(NamedTuple):
    """Where one descent ended.

    Attributes
    ----------
    problem : Problem
    state : State
    history : list of (x, cost)
    results : list of TermResult
    earlier : int
        Steps of the descents that led to its start.
    """

    problem: Problem
    state: State
    history: History
    results: list[TermResult]
    earlier: int = 0

    @property
    def at_bounds(self) -> BoolArray | None:
        """Which unknowns (N,) are at a bound, or None if none of them is."""
        x = self.state.x
        found: BoolArray = (x <= self.problem.lower) | (x >= self.problem.upper)
        return found if holds_anywhere(found) else None

    @property
    def iterations(self) -> int:
        """Accepted steps in all."""
        return self.earlier + self.state.iterations

    @property
    def cut(self) -> Outcome | None:
        """Why it ended although it could go on; None if it did not."""
        outcome = self.state.outcome
        limited = outcome is not None and outcome.status in (ITERATION_LIMIT, TIME_LIMIT)
        return outcome if limited else None

    def after(self, former: Descent) -> Descent:
        """The descent as the continuation of another one."""
        before = former.history
        if np.array_equal(before[-1][0], self.history[0][0]):
            # It began where the other one ended.
            before = before[:-1]
        history = [*before, *self.history]
        return self._replace(history=history, earlier=former.iterations + self.earlier)

    @property
    def missed(self) -> list[TermResult]:
        """The terms whose goals are missed."""
        return [result for result in self.results if not result.met]

    @property
    def shortfall(self) -> float:
        """By how many times its tolerance the goal that is missed most is missed; 0 for none."""
        return max((result.shortfall for result in self.missed), default=0.0)

    def meets_more_than(self, other: Descent) -> bool:
        """Whether a goal is met that ``other`` misses, and none missed that it meets."""
        mine = {i for i, result in enumerate(self.results) if result.met}
        return mine > {i for i, result in enumerate(other.results) if result.met}


class Path(History):
    """The history of a descent, which calls a function at every entry."""

    def __init__(self, watch: Callable[[Array, float], None]) -> None:
        super().__init__()
        self.watch = watch

    def append(self, entry: tuple[Array, float]) -> None:
        """Add (x, cost)."""
        super().append(entry)
        self.watch(*entry)


def descend(
    energy: Energy,
    start: Array,
    tolerances: Tolerances,
    max_iterations: int,
    scale_by_columns: bool = False,
    watch: Callable[[Array, float], None] | None = None,
    deadline: float = math.inf,
) -> Descent:
    """Minimise an energy from one point of its free unknowns, (N,).

    Parameters
    ----------
    energy : Energy
    start : (N,) array
    tolerances : Tolerances
    max_iterations : int
    scale_by_columns : bool
        As for the solver's problem. Default False, which prefers short steps.
    watch : callable of (x, cost), optional
        Called at the start and at every accepted step.
    deadline : float
        The value of ``time.perf_counter()`` after which no step is tried. Default: no limit.
    """
    problem = Problem(
        energy.lower,
        energy.upper,
        energy.kinks,
        scale_by_columns=scale_by_columns,
        tolerances=tolerances,
        proximity=energy.proximity,
        constant=energy.constant,
        renews=energy.moves,
    )
    history: History = [] if watch is None else Path(watch)
    solve = minimise if _is_small(energy) else _minimise_alone
    state = solve(
        problem,
        start,
        energy.residual,
        energy.jacobian,
        energy.renew,
        max_iterations=max_iterations,
        history=history,
        deadline=deadline,
        # Only what users write may overflow.
        quiet=energy.row_count is None,
    )
    return Descent(problem, state, history, energy.results(state.x, state.residual))


_minimise_alone = one_thread(minimise)


def _is_small(energy: Energy) -> bool:
    """Whether BLAS would do every product of a step in one thread anyway, as in most drags."""
    rows = energy.row_count
    return rows is not None and products(rows, len(energy.lower)) < SMALL


def held_axes(energy: Energy, found: Descent) -> Array:
    """-1 or 1 where an axis is held at its lower or upper bound, else 0, in the shape of Θ."""
    problem, state = found.problem, found.state
    moves_axes = energy.text.font.moves_axes
    if moves_axes:
        # The model was made near a kink, where final coordinates may be beyond a limit.
        problem, state = problem._replace(kinks=None), replace(state, model=None)
    if energy.moves and state.model is None:
        # A restart may have located the moving terms elsewhere in the meantime.
        state = replace(state, residual=energy.renew(state.x))
    held = active_bounds(problem, state, energy.jacobian, inward=True)
    if moves_axes:
        # At x they may be beyond it by a rounding error, and then nothing moves.
        inside = active_bounds(problem, state, energy.jacobian)
        held = np.where(held == 0, inside, held)
    # A locked axis is not held by a bound of the font.
    held = np.where(energy.locked, 0, held)
    active = np.zeros(energy.text.coordinates.shape, dtype=int)
    if AXES in energy.unknowns.slices:
        active = energy.by_letter(held)
    return active
