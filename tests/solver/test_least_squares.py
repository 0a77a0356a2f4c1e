"""The solver by itself: scipy as referee, bounds, kinks, torch and arrays, bad input."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.optimize
import torch
from hypothesis import example, given, settings
from hypothesis import strategies as st

import vfwidget as vf

seeds = st.integers(0, 2**32 - 1)


def rosenbrock(x):
    xp = torch if isinstance(x, torch.Tensor) else np
    return xp.stack([10 * (x[1] - x[0] ** 2), 1 - x[0]])


def test_rosenbrock_with_and_without_bounds_as_scipy_has_it() -> None:
    for bounds in [(-np.inf, np.inf), ([-2, -2], [0.8, 2]), ([-2, 0.5], [0.3, 0.6])]:
        start = np.clip([-1.2, 1.0], *bounds)
        ours = vf.least_squares(rosenbrock, start, bounds=bounds)
        theirs = scipy.optimize.least_squares(rosenbrock, start, bounds=bounds, xtol=1e-14)
        assert ours.converged
        assert ours.x == pytest.approx(theirs.x, abs=1e-6)
        assert ours.cost == pytest.approx(2 * theirs.cost, abs=1e-10)


def test_tensors_give_tensors_and_forward_mode_the_jacobian() -> None:
    found = vf.least_squares(rosenbrock, torch.tensor([-1.2, 1.0], dtype=torch.float64))
    assert isinstance(found.x, torch.Tensor)
    assert found.x.tolist() == pytest.approx([1, 1], abs=1e-8)


def test_history_starts_at_the_start_and_never_rises() -> None:
    found = vf.least_squares(rosenbrock, [-1.2, 1.0])
    costs = [cost for _, cost in found.history]
    assert found.history[0].x.tolist() == [-1.2, 1.0]
    assert costs == sorted(costs, reverse=True)
    assert len(costs) == found.iterations + 1


def test_an_optimum_on_a_bound_is_reached_although_it_was_left_before() -> None:
    # Projecting an unbounded step stops short here: the step of y, taken with x free, is wrong
    # once x is held at its bound.
    matrix = np.array([[1.0, 0.99], [0.0, 0.1]])
    goal = np.array([2.0, 0.3])

    def residual(x):
        return matrix @ x - goal

    ours = vf.least_squares(residual, [0.5, 0.5], bounds=(0, 1))
    theirs = scipy.optimize.lsq_linear(matrix, goal, bounds=(0, 1))
    assert ours.x == pytest.approx(theirs.x, abs=1e-7)
    assert ours.active.tolist() == [1, 1]


@given(seeds)
@settings(max_examples=60, deadline=None)
def test_linear_problems_with_bounds_as_scipy_has_them(seed: int) -> None:
    rng = np.random.default_rng(seed)
    m, n = int(rng.integers(1, 12)), int(rng.integers(1, 8))
    matrix, goal = rng.normal(size=(m, n)), rng.normal(size=m) * 3
    ours = vf.least_squares(lambda x: matrix @ x - goal, np.zeros(n), bounds=(-1, 1))
    theirs = scipy.optimize.lsq_linear(matrix, goal, bounds=(-1, 1), tol=1e-12)
    assert ours.cost == pytest.approx(2 * theirs.cost, rel=1e-6, abs=1e-9)


def test_a_start_on_a_kink_with_one_flat_side_goes_down_the_other() -> None:
    def residual(x):
        return np.array([np.minimum(x[0], 0) + 0.5])

    # From the right the residual is constant: that derivative says nothing can be done.
    found = vf.least_squares(residual, [0.0], bounds=(-1, 1), kinks=[[0.0]])
    assert found.x[0] == pytest.approx(-0.5)
    assert found.cost == pytest.approx(0, abs=1e-16)


def test_a_minimum_on_a_kink_is_landed_on_exactly() -> None:
    def residual(x):
        return np.array([1 + 3 * abs(x[0] - 0.25), x[1] - 0.5 - abs(x[0] - 0.25)])

    found = vf.least_squares(residual, [-0.9, 0.9], bounds=(-1, 1), kinks=[[0.25], []])
    assert found.x.tolist() == pytest.approx([0.25, 0.5], abs=1e-8)
    assert found.iterations < 12


@given(seeds)
@example(1236643)  # Its normal matrix has no full rank, and the damping falls to its least.
@settings(max_examples=80, deadline=None)
def test_where_it_stops_no_step_along_any_direction_goes_down(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n, m, q = int(rng.integers(1, 5)), int(rng.integers(1, 6)), 3
    kinks = np.sort(np.round(rng.uniform(-0.9, 0.9, (n, q)), 2), axis=1)
    kinks[:, 1] = 0.0
    left, right = rng.normal(size=(2, m, n, q))
    base = rng.normal(size=m)

    def residual(x):
        offset = np.asarray(x)[:, None] - kinks
        return base + np.where(offset < 0, left * offset, right * offset).sum((1, 2))

    found = vf.least_squares(
        residual, np.zeros(n), bounds=(-1, 1), kinks=list(kinks), max_iterations=300
    )
    assert found.converged
    directions = np.concatenate([np.eye(n), -np.eye(n), rng.normal(size=(200, n))])
    for direction in directions / np.linalg.norm(directions, axis=1, keepdims=True):
        beside = np.clip(found.x + 1e-5 * direction, -1, 1)
        assert (residual(beside) ** 2).sum() >= found.cost - 1e-8 * (1 + found.cost)


def test_a_variable_without_effect_stays_where_it_is() -> None:
    found = vf.least_squares(lambda x: np.array([x[0] - 0.3, 2 * x[0]]), [0.9, 0.123])
    assert found.x[1] == 0.123


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda: vf.least_squares(lambda x: x * np.nan, [1.0]), "finite"),
        (lambda: vf.least_squares(lambda x: x / 0, [np.nan]), "start"),
        (lambda: vf.least_squares(lambda x: x, [2.0], bounds=(0, 1)), "outside the bounds"),
        (lambda: vf.least_squares(lambda x: x, [0.0], bounds=(1, -1)), "above its upper"),
        (lambda: vf.least_squares(lambda x: x, [0.0], bounds=([0, 1], [2, 2])), "do not fit"),
        (lambda: vf.least_squares(lambda x: x, [[[0.0]]]), "shape"),
        (lambda: vf.least_squares(lambda x: x, [1.0], loss="median"), "soft_l1"),
        (lambda: vf.least_squares(lambda x: x, [1.0], jacobian=lambda x: np.eye(2)), r"\(1, 1\)"),
        (lambda: vf.least_squares(lambda x: x, [1.0], jacobian=lambda x: x * np.nan), "Jacobian"),
        (lambda: vf.least_squares(lambda x: x, [1.0], scale="rows"), "columns"),
        (lambda: vf.least_squares(lambda x: x, [1.0], kinks=[[], []]), "kinks"),
    ],
)  # fmt: skip
def test_bad_input_is_one_clear_error(call, says) -> None:
    with pytest.raises(vf.SolveError, match=says):
        call()


def test_a_residual_that_is_not_a_number_further_on_shortens_the_step() -> None:
    def residual(x):
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.log(x) - np.log(0.01)

    found = vf.least_squares(residual, [5.0])
    assert found.x[0] == pytest.approx(0.01)


def trigonometric(x):
    """Ten residuals of three variables, for one point (n,) or many (B, n)."""
    xp = torch if isinstance(x, torch.Tensor) else np
    time = xp.linspace(0, 3, 10)
    a, b, c = (x[..., i, None] for i in range(3))
    return a * xp.sin(b * time) + c - xp.sin(1.7 * time) * 0.8


@pytest.mark.parametrize("tensors", [False, True])
def test_a_batch_is_as_its_problems_one_by_one(tensors: bool) -> None:
    starts = np.random.default_rng(3).uniform([0, 0.5, -1], [1, 2, 1], (40, 3))
    given_starts = torch.tensor(starts) if tensors else starts
    options = {"bounds": ([0, 0.5, -1], [1, 2, 1]), "kinks": [[0.5], [], [0.0]]}
    together = vf.least_squares(trigonometric, given_starts, **options)
    for i, start in enumerate(starts):
        alone = vf.least_squares(trigonometric, start, **options)
        assert float(together.cost[i]) == pytest.approx(alone.cost, rel=1e-4, abs=1e-9)
        assert bool(together.converged[i]) == alone.converged
    assert together.x.shape == (40, 3)
    assert isinstance(together.x, torch.Tensor) == tensors


def test_a_batch_may_hold_different_problems_and_bounds() -> None:
    goals = np.array([[1.0, 2.0], [3.0, -4.0]])
    found = vf.least_squares(
        lambda x: x - goals, np.zeros((2, 2)), bounds=([[0, 0], [0, -9]], [[5, 1], [2, 9]])
    )
    assert found.x == pytest.approx(np.array([[1, 1], [2, -4]]), abs=1e-8)
    assert found.active.tolist() == [[0, 1], [1, 0]]


@pytest.mark.parametrize("loss", ["soft_l1", "huber", "cauchy", "arctan"])
def test_robust_losses_find_what_scipy_finds(loss: str) -> None:
    rng = np.random.default_rng(4)
    t = np.linspace(0, 2, 30)
    y = 2 * np.exp(-1.3 * t) + 0.02 * rng.normal(size=30)
    y[::7] += 3

    def residual(x):
        return x[0] * np.exp(x[1] * t) - y

    ours = vf.least_squares(residual, [1.5, -1.0], loss=loss, loss_scale=0.1)
    theirs = scipy.optimize.least_squares(
        residual, [1.5, -1.0], loss=loss, f_scale=0.1, xtol=1e-12, ftol=1e-12, gtol=1e-12
    )
    assert ours.x == pytest.approx(theirs.x, rel=1e-4)
    assert ours.cost == pytest.approx(2 * theirs.cost, rel=1e-8)
    plain = vf.least_squares(residual, [1.5, -1.0])
    assert abs(ours.x[1] + 1.3) < 0.1 < abs(plain.x[1] + 1.3)


def test_geodesic_acceleration_shortens_the_way_along_a_curved_valley() -> None:
    plain = vf.least_squares(rosenbrock, [-1.2, 1.0])
    bent = vf.least_squares(rosenbrock, [-1.2, 1.0], acceleration=True)
    assert bent.x == pytest.approx([1, 1], abs=1e-6)
    assert bent.iterations < plain.iterations


def test_the_pieces_can_be_stepped_one_by_one() -> None:
    from vfwidget.solver.drivers import answer
    from vfwidget.solver.levenberg_marquardt import init, step
    from vfwidget.solver.problem import Kind, Problem

    def jacobian(x):
        return np.array([[-20 * x[0], 10], [-1, 0]])

    everywhere = np.full(2, np.inf)
    problem = Problem(-everywhere, everywhere)
    functions = {Kind.RESIDUAL: rosenbrock, Kind.JACOBIAN: jacobian}
    state = answer(init(problem, np.array([-1.2, 1.0])), functions)
    costs = [state.cost]
    while state.outcome is None:
        answer(step(problem, state), functions)
        costs.append(state.cost)
    assert costs == sorted(costs, reverse=True)
    assert state.x == pytest.approx([1, 1], abs=1e-8)


@pytest.mark.parametrize("scale", ["columns", "none"])
@pytest.mark.parametrize("shape", [(3, 3), (2, 5), (8, 4), (30, 6)])
@given(seeds)
@settings(max_examples=10, deadline=None)
def test_one_heavy_weight_takes_a_handful_of_steps(scale, shape, seed: int) -> None:
    rng = np.random.default_rng(seed)
    m, n = shape
    weights = np.where(np.arange(m) == rng.integers(m), 1e8, 1.0)
    matrix, goal = weights[:, None] * rng.normal(size=shape), weights * rng.normal(size=m)
    found = vf.least_squares(
        lambda x: matrix @ x - goal, np.full(n, 0.3), lambda x: matrix, scale=scale
    )
    best = np.linalg.lstsq(matrix, goal, rcond=None)[0]
    assert found.converged and found.iterations <= 12
    assert found.cost <= ((matrix @ best - goal) ** 2).sum() * (1 + 1e-6) + 1e-12
