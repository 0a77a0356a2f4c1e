"""The solver by itself: scipy as referee, bounds, kinks, torch and arrays, bad input."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.optimize
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

import vfwidget as vf
from vfwidget.quadratic import minimise_quadratic

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
def test_the_quadratic_over_a_box_meets_its_optimality_conditions(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 12))
    root = rng.normal(size=(n, n))
    system = root @ root.T + 1e-3 * np.eye(n)
    gradient = rng.normal(size=n)
    low, high = -rng.exponential(size=n), rng.exponential(size=n)
    frozen = rng.random(n) < 0.2
    low, high = np.where(frozen, 0, low), np.where(frozen, 0, high)
    d = minimise_quadratic(system, gradient, low, high)
    slope = gradient + system @ d
    assert (d >= low).all() and (d <= high).all()
    assert slope[(d > low) & (d < high)] == pytest.approx(0, abs=1e-8)
    assert (slope[(d == low) & (low < high)] >= -1e-8).all()
    assert (slope[(d == high) & (low < high)] <= 1e-8).all()


@given(seeds)
@settings(max_examples=60, deadline=None)
def test_linear_problems_with_bounds_as_scipy_has_them(seed: int) -> None:
    rng = np.random.default_rng(seed)
    m, n = int(rng.integers(1, 12)), int(rng.integers(1, 8))
    matrix, goal = rng.normal(size=(m, n)), rng.normal(size=m) * 3
    ours = vf.least_squares(lambda x: matrix @ x - goal, np.zeros(n), bounds=(-1, 1))
    theirs = scipy.optimize.lsq_linear(matrix, goal, bounds=(-1, 1), tol=1e-12)
    assert ours.cost == pytest.approx(2 * theirs.cost, rel=1e-6, abs=1e-9)


def hinge(slopes_left, slopes_right, kinks):
    """A residual that bends at kinks of every variable, as delta sets at their regions do."""

    def residual(x):
        x = np.asarray(x)
        offset = x[:, None] - kinks
        bent = np.where(offset < 0, slopes_left * offset, slopes_right * offset)
        return bent.sum(axis=(1, 2))

    return residual


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
        (lambda: vf.least_squares(lambda x: x, [[0.0]]), "one vector"),
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
