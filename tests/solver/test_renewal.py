"""Residuals that change between steps: contacts found anew, cycles, and time limits."""

from __future__ import annotations

import math
import time

import numpy as np
import pytest

import vfwidget as vf
from vfwidget.solver.drivers import minimise
from vfwidget.solver.problem import Problem, Proximity, Tolerances

EVERYWHERE = np.full(2, np.inf)


class Disc:
    """A point is drawn to a target; planes tangent to the unit disc keep it outside.

    The planes are those of the disc's boundary nearest to the point when the contact was found.
    A point outside has no contact, and one row less.
    """

    def __init__(self, target, stiffness=1e3):
        self.target, self.stiffness = np.array(target), stiffness
        self.normal, self.renewals = None, []

    def residual(self, x):
        rows = x - self.target
        if self.normal is None:
            return rows
        depth = max(1 - self.normal @ x, 0.0)
        return np.append(rows, self.stiffness * depth)

    def jacobian(self, x):
        if self.normal is None:
            return np.eye(2)
        inside = 1 - self.normal @ x > 0
        return np.vstack([np.eye(2), -self.stiffness * self.normal * inside])

    def renew(self, x):
        distance = np.linalg.norm(x)
        self.normal = x / distance if 0 < distance < 1 else None
        self.renewals.append(x)
        return self.residual(x)


def solve(terms, start, **options):
    problem = Problem(-EVERYWHERE, EVERYWHERE, renews=True)
    history = []
    start = np.array(start, dtype=float)
    state = minimise(
        problem, start, terms.residual, terms.jacobian, terms.renew, history=history, **options
    )
    return state, history


def test_a_point_is_pushed_out_of_a_disc_to_the_nearest_place_to_its_target() -> None:
    disc = Disc([0.3, 0.4])
    state, history = solve(disc, [-0.2, 0.6])
    assert state.outcome.status == "converged"
    # The spring to the target presses the point slightly into the disc.
    assert state.x == pytest.approx([0.6, 0.8], abs=1e-5)
    assert history[-1][0] is state.x and history[-1][1] == state.cost
    # The contact is found at the start and after every step.
    assert len(disc.renewals) == state.iterations + 1


def test_a_contact_found_after_the_last_step_goes_on_with_the_solve() -> None:
    # Without contacts the first step reaches the target exactly, and the cost is zero there.
    disc = Disc([0.0, 0.8])
    state, history = solve(disc, [2.0, 0.0])
    assert history[1][1] > 1e3
    assert state.x == pytest.approx([0, 1], abs=1e-4)
    assert state.outcome.status == "converged"


def test_the_history_records_the_costs_of_the_renewed_residual() -> None:
    disc = Disc([0.0, 0.8])
    _, history = solve(disc, [2.0, 0.0])
    fresh = Disc([0.0, 0.8])
    assert [cost for _, cost in history] == [(fresh.renew(x) ** 2).sum() for x, _ in history]


class Flip:
    """A residual that always wants the point on the other side: no solve can lower its cost."""

    def residual(self, x):
        return x - self.side

    def jacobian(self, x):
        return np.eye(len(x))

    def renew(self, x):
        self.side = -np.sign(x + 1e-30)
        return self.residual(x)


def test_a_cost_that_never_falls_ends_the_solve_honestly_at_the_lowest() -> None:
    state, history = solve(Flip(), [0.4, 0.4])
    assert state.outcome.status == "stalled"
    assert "renewed" in state.outcome.message
    assert state.iterations < 30
    assert state.cost == min(cost for _, cost in history) == history[-1][1]


def test_a_renewed_residual_that_is_not_finite_is_an_error() -> None:
    class Broken(Flip):
        def renew(self, x):
            return super().renew(x) if x[0] == 0.4 else np.full(3, np.nan)

    with pytest.raises(vf.SolveError, match="renewed after step 1 must be a vector of finite"):
        solve(Broken(), [0.4, 0.4])


def test_a_problem_that_renews_requires_the_function() -> None:
    problem = Problem(-EVERYWHERE, EVERYWHERE, renews=True)
    with pytest.raises(vf.SolveError, match="renew"):
        minimise(problem, np.zeros(2), lambda x: x, lambda x: np.eye(2))


def test_a_solve_ends_at_its_deadline() -> None:
    calls = []

    def residual(x):
        calls.append(time.perf_counter())
        return np.array([10 * (x[1] - x[0] ** 2), 1 - x[0]])

    def jacobian(x):
        return np.array([[-20 * x[0], 10], [-1, 0]])

    problem = Problem(-EVERYWHERE, EVERYWHERE)
    start = np.array([-1.2, 1.0])
    late = minimise(problem, start, residual, jacobian, deadline=time.perf_counter() - 1)
    assert late.outcome.status == "time_limit"
    assert late.x.tolist() == start.tolist() and len(calls) == 1
    free = minimise(problem, start, residual, jacobian, deadline=math.inf)
    assert free.outcome.status == "converged"


@pytest.mark.parametrize("n", [2, 40])
def test_proximity_is_as_rows_of_the_residual(n: int) -> None:
    rng = np.random.default_rng(n)
    slope, bend = rng.normal(size=(2, n)), 0.1 * rng.normal(size=(2, n))
    target = rng.normal(size=2)
    weights = np.where(rng.random(n) < 0.5, 0.0, 10.0 ** rng.uniform(-4, 0, n))
    weights[0] = 1.0
    reference, start = rng.uniform(-1, 1, (2, n))
    tolerances = Tolerances(relative_cost=1e-15)

    def residual(x):
        return slope @ x + bend @ x**2 - target

    def jacobian(x):
        return slope + 2 * bend * x

    root = np.sqrt(weights)
    lower, upper = np.full(n, -1.0), np.full(n, 1.0)
    near = Problem(lower, upper, proximity=Proximity(weights, reference), tolerances=tolerances)
    ours = minimise(near, start, residual, jacobian)
    rows = minimise(
        Problem(lower, upper, tolerances=tolerances),
        start,
        lambda x: np.concatenate([residual(x), root * (x - reference)]),
        lambda x: np.vstack([jacobian(x), np.diag(root)]),
    )
    assert ours.outcome.status == rows.outcome.status == "converged"
    assert ours.cost == pytest.approx(rows.cost, rel=1e-6, abs=1e-12)
    assert len(ours.residual) == 2


def test_a_variable_at_rest_does_not_move() -> None:
    n = 40
    slope = np.zeros((2, n))
    slope[:, :3] = [[3, 1, 2], [1, -2, 1]]
    start = np.random.default_rng(0).uniform(-1, 1, n)
    problem = Problem(
        np.full(n, -1.0), np.full(n, 1.0), proximity=Proximity(np.full(n, 1e-3), start)
    )
    state = minimise(problem, start, lambda x: slope @ x - [1, 2], lambda x: slope)
    assert state.x[3:].tolist() == start[3:].tolist()
    assert state.residual == pytest.approx([0, 0], abs=1e-2)


def test_a_cost_of_nothing_but_proximity_is_minimised_at_once() -> None:
    reference = np.array([0.5, 3.0])
    problem = Problem(-np.ones(2), np.ones(2), proximity=Proximity(np.ones(2), reference))
    state = minimise(problem, np.zeros(2), lambda x: np.zeros(0), lambda x: np.zeros((0, 2)))
    assert state.x == pytest.approx([0.5, 1.0])
    assert state.cost == pytest.approx(4)
