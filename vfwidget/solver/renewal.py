"""Solves whose residual changes between steps, for instance because contacts are found anew."""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

from ..arrays import Array
from .levenberg_marquardt import finite_cost
from .problem import Kind, Problem, Requests, State
from .status import CONVERGED, NOT_FALLING, Outcome

PATIENCE = 8
"""A solve ends after this many steps without a new lowest cost."""


@dataclass
class Renewal:
    """Renews the residual after every accepted step, and decides whether the solve goes on.

    The cost of a renewed residual may be higher than before the step, and may even return to
    earlier values for ever. The solve is allowed some such steps, because a new contact often
    raises the cost first. The damping grows with each of them, so that the steps become shorter.

    Attributes
    ----------
    problem : Problem
    x, cost : (n,) array, float
        The point with the lowest renewed cost so far.
    waited : int
        The number of steps since then.
    """

    problem: Problem
    x: Array
    cost: float
    waited: int = 0

    def after_step(self, state: State, damping: float) -> Requests:
        """Renew the residual at the new iterate; ``damping`` is that of the last step."""
        predicted = state.cost
        yield from self._renew(state)
        least = self.problem.tolerances.least_decrease(self.cost)
        if abs(state.cost - predicted) > least:
            # The step was judged by a residual that no longer applies.
            state.outcome = None
        if state.cost < self.cost - least:
            self.x, self.cost, self.waited = state.x, state.cost, 0
            return
        self.waited += 1
        state.damping = max(state.damping, damping * 2.0**self.waited)
        if self.waited >= PATIENCE and state.outcome is None:
            state.outcome = NOT_FALLING

    def finish(self, state: State) -> Requests:
        """Return to the point with the lowest cost, if the last one is worse."""
        if state.cost <= self.cost + self.problem.tolerances.least_decrease(self.cost):
            return
        state.x = self.x
        yield from self._renew(state)
        if cast(Outcome, state.outcome).status == CONVERGED:
            state.outcome = NOT_FALLING

    def _renew(self, state: State) -> Requests:
        state.residual = yield Kind.RENEW, state.x
        when = f"renewed after step {state.iterations}"
        state.cost = finite_cost(self.problem, state.residual, state.x, when)
        state.model = None
