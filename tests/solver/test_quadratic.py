"""Quadratics over boxes: both kinds against each other, scipy, and the optimality conditions."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.optimize
from hypothesis import example, given, settings
from hypothesis import strategies as st

from vfwidget.solver.model import Model
from vfwidget.solver.quadratic import (
    DenseQuadratic,
    LowRankQuadratic,
    Quadratic,
    minimise_over_box,
)

seeds = st.integers(0, 2**32 - 1)


def random_box(rng, n):
    low, high = -rng.exponential(size=n), rng.exponential(size=n)
    fixed = rng.random(n) < 0.2
    return np.where(fixed, 0, low), np.where(fixed, 0, high)


def check_optimality(d, slope, low, high):
    assert (d >= low).all() and (d <= high).all()
    assert slope[(d > low) & (d < high)] == pytest.approx(0, abs=1e-8)
    assert (slope[(d == low) & (low < high)] >= -1e-8).all()
    assert (slope[(d == high) & (low < high)] <= 1e-8).all()


@given(seeds)
@settings(max_examples=60, deadline=None, derandomize=True)
def test_the_minimiser_meets_the_optimality_conditions(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 12))
    root = rng.normal(size=(n, n))
    matrix = root @ root.T + 1e-3 * np.eye(n)
    gradient = rng.normal(size=n)
    low, high = random_box(rng, n)
    d, bounded = minimise_over_box(DenseQuadratic(matrix, gradient), low, high)
    check_optimality(d, gradient + matrix @ d, low, high)
    assert bounded == bool(((d == low) | (d == high)).any())


@given(seeds, st.booleans())
@settings(max_examples=100, deadline=None, derandomize=True)
def test_few_rows_and_a_diagonal_give_the_same_as_their_matrix(seed: int, graded: bool) -> None:
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 12))
    rows = int(rng.integers(0, n + 1))
    jacobian, residual = rng.normal(size=(rows, n)), rng.normal(size=rows)
    diagonal = 10.0 ** rng.uniform(-4, 1, n)
    linear = rng.normal(size=n) * diagonal
    low, high = random_box(rng, n)
    matrix = jacobian.T @ jacobian + np.diag(diagonal)
    gradient = residual @ jacobian + linear
    low_rank = LowRankQuadratic(jacobian, residual, diagonal, linear, graded)
    dense = DenseQuadratic(matrix, gradient)

    def value(d):
        return d @ matrix @ d / 2 + gradient @ d

    for one, other in (
        (low_rank.minimiser(), dense.minimiser()),
        (minimise_over_box(low_rank, low, high)[0], minimise_over_box(dense, low, high)[0]),
        (low_rank.with_linear(linear).minimiser(), dense.with_linear(linear).minimiser()),
    ):
        assert value(one) == pytest.approx(value(other), rel=1e-7, abs=1e-9)


@given(seeds)
@example(1202)
@settings(max_examples=60, deadline=None, derandomize=True)
def test_a_heavy_row_leaves_the_light_ones_their_accuracy(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 8))
    jacobian, residual = rng.normal(size=(n, n)), rng.normal(size=n)
    weight = np.where(np.arange(n) == rng.integers(n), 1e8, 1.0)
    quadratic = LowRankQuadratic(
        weight[:, None] * jacobian, weight * residual, np.full(n, 1e-12), np.zeros(n), True
    )
    low, high = np.full(n, -1.0), np.full(n, 1.0)
    d, _ = minimise_over_box(quadratic, low, high)
    expected = scipy.optimize.lsq_linear(
        weight[:, None] * jacobian, -weight * residual, (low, high), method="bvls", tol=1e-15
    )
    cost = ((weight * (jacobian @ d + residual)) ** 2).sum()
    assert cost <= 2 * expected.cost * (1 + 1e-2) + 1e-9


def test_five_hundred_variables_need_no_large_matrix(monkeypatch) -> None:
    rng = np.random.default_rng(0)
    n = 520
    quadratic = LowRankQuadratic(
        rng.normal(size=(4, n)), rng.normal(size=4), np.full(n, 1e-3), np.zeros(n)
    )
    solve, sizes = np.linalg.solve, []
    monkeypatch.setattr(np.linalg, "solve", lambda a, b: sizes.append(len(a)) or solve(a, b))
    d, bounded = minimise_over_box(quadratic, np.full(n, -0.001), np.full(n, 0.002))
    assert bounded and max(sizes) == 4
    slope = quadratic.slope(d)
    inside = (d > -0.001) & (d < 0.002)
    assert inside.any() and abs(slope[inside]).max() <= 1e-9
    assert (slope[d == -0.001] >= 0).all() and (slope[d == 0.002] <= 0).all()


def test_many_bounds_take_few_systems(monkeypatch) -> None:
    rng = np.random.default_rng(1)
    n = 400
    # Sums of all variables so far couple them: the first step leaves the box at most of its bounds.
    sums = np.tril(rng.uniform(0.5, 1.5, size=(n, n)))
    jacobian = np.concatenate([sums, np.diag(rng.normal(size=n))])[:, rng.permutation(n)]
    matrix = jacobian.T @ jacobian + 1e-6 * np.eye(n)
    quadratic = DenseQuadratic(matrix, 50 * rng.normal(size=2 * n) @ jacobian)
    low, high = -rng.exponential(size=n), rng.exponential(size=n)
    solve, sizes = np.linalg.solve, []
    monkeypatch.setattr(np.linalg, "solve", lambda a, b: sizes.append(len(a)) or solve(a, b))
    d, bounded = minimise_over_box(quadratic, low, high)
    at_bounds = np.count_nonzero((d == low) | (d == high))
    assert bounded and at_bounds > n / 2 and len(sizes) < 60
    slope = quadratic.slope(d)
    assert abs(slope[(d > low) & (d < high)]).max() <= 1e-7 * abs(quadratic.gradient).max()


@given(seeds, st.booleans(), st.booleans())
@settings(max_examples=100, deadline=None, derandomize=True)
def test_the_start_does_not_change_the_minimiser(seed: int, dense: bool, graded: bool) -> None:
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 40))
    jacobian, residual = rng.normal(size=(int(rng.integers(1, n + 1)), n)), rng.normal(size=n)
    residual = 5 * residual[: len(jacobian)]
    diagonal, linear = 10.0 ** rng.uniform(-3, 1, n), rng.normal(size=n)
    low, high = random_box(rng, n)
    matrix = jacobian.T @ jacobian + np.diag(diagonal)
    gradient = residual @ jacobian + linear
    quadratic: Quadratic = LowRankQuadratic(jacobian, residual, diagonal, linear, graded)
    if dense:
        quadratic = DenseQuadratic(matrix, gradient)
    ends = np.where(rng.random(n) < 0.5, low, high)
    for start in (None, np.zeros(n), ends, np.where(rng.random(n) < 0.5, ends, 0.0)):
        d, bounded = minimise_over_box(quadratic, low, high, start)
        check_optimality(d, gradient + matrix @ d, low, high)
        assert bounded or not ((d == low) | (d == high)).any()


@pytest.mark.parametrize("rows", [40, 400])
def test_a_search_from_the_minimiser_takes_one_system_of_the_smaller_kind(
    rows: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    rng = np.random.default_rng(2)
    n = 500
    jacobian, residual = rng.normal(size=(rows, n)), 50 * rng.normal(size=rows)
    quadratic = LowRankQuadratic(jacobian, residual, np.full(n, 0.1), np.zeros(n))
    box = np.full(n, -1.0), np.full(n, 1.0)
    d, _ = minimise_over_box(quadratic, *box)
    solve, sizes = np.linalg.solve, []
    monkeypatch.setattr(np.linalg, "solve", lambda a, b: sizes.append(len(a)) or solve(a, b))
    again, bounded = minimise_over_box(quadratic, *box, d)
    assert again == pytest.approx(d, abs=1e-9)
    free = np.count_nonzero(abs(d) < 1)
    assert bounded and free < n and sizes == [min(rows, free)]


def test_unknowns_that_change_no_row_take_no_equations(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(3)
    rows, n = 60, 150
    jacobian, residual = 3 * rng.normal(size=(rows, n)), 3 * rng.normal(size=rows)
    jacobian[:, rng.permutation(n)[:110]] = 0.0
    weights, pull = np.full(n, 0.1), 0.1 * rng.normal(size=n)
    # A bound that holds an unknown from the start saves the system without bounds.
    high = np.where(np.arange(n) < 10, 0.0, 0.5)
    model = Model(jacobian, residual, weights, pull, -high, high)
    solve, sizes = np.linalg.solve, []
    monkeypatch.setattr(np.linalg, "solve", lambda a, b: sizes.append(len(a)) or solve(a, b))
    d, _ = minimise_over_box(model.damped(0.01), model.low, model.high)
    matrix = jacobian.T @ jacobian + np.diag(weights + 0.01)
    check_optimality(d, model.gradient + matrix @ d, model.low, model.high)
    assert sizes and max(sizes) <= 40


@given(seeds, st.integers(1, 4))
@example(168344102, 2)
@settings(max_examples=60, deadline=None, derandomize=True)
def test_few_equations_are_solved_as_by_lapack(seed: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    scale = 10.0 ** rng.uniform(-6, 6, n)
    root = rng.normal(size=(n, n)) * scale
    matrix = root.T @ root + np.diag(1e-8 * scale**2)
    d = rng.normal(size=n)
    found = DenseQuadratic(matrix, -matrix @ d).minimiser()
    expected = np.linalg.solve(matrix, matrix @ d)
    # Both are as near to d as the condition of the matrix allows, each unknown in its own unit.
    for near in (found, expected):
        assert np.abs(scale * (near - d)).max() <= 1e-6 * np.abs(scale * d).max()


def test_a_pivot_lost_in_rounding_errors_is_left_to_lapack() -> None:
    matrix = np.array([[1.0, 1.0], [1.0, 1.0 - 2.0**-53]])
    gradient = np.array([1.0, 0.0])
    found = DenseQuadratic(matrix, gradient).minimiser()
    assert np.array_equal(found, np.linalg.solve(matrix, -gradient))


def model_with_a_light_row(norm: float, weight: float, far: float = 1.0) -> Model:
    """The model of 14 heavy rows and one of this norm; no step is longer than ``far``."""
    rng = np.random.default_rng(3)
    jacobian = 1e3 * rng.normal(size=(15, 30))
    jacobian[7] *= norm / np.linalg.norm(jacobian[7])
    residual, w = 5 * rng.normal(size=15), np.full(30, weight)
    return Model(
        jacobian, residual, w, w * rng.normal(size=30), np.full(30, -far), np.full(30, far)
    )


@pytest.mark.parametrize(
    ("norm", "weight", "far", "graded"),
    [
        (1.0, 0.0, 1.0, False),
        (1e-5, 0.0, 1.0, True),
        # The proximity decides in place of the light row.
        (1e-5, 0.1, 1.0, False),
        (1e-5, 1e-12, 1.0, True),
        # No step changes the row, except by rounding errors.
        (1e-15, 0.0, 1.0, False),
        (1e-15, 0.0, np.inf, True),
    ],
)
def test_only_light_rows_that_matter_make_a_model_graded(norm, weight, far, graded) -> None:
    assert model_with_a_light_row(norm, weight, far).graded is graded


@pytest.mark.parametrize(("norm", "weight"), [(1.0, 0.1), (1e-5, 0.1), (1e-15, 0.0)])
def test_a_light_row_that_does_not_matter_leaves_the_minimiser(norm, weight) -> None:
    model = model_with_a_light_row(norm, weight)
    rows = [model.jacobian, np.diag(np.sqrt(model.weights + 1e-2))]
    aim = [-model.residual, -model.pull / np.sqrt(model.weights + 1e-2)]
    low, high = np.full(30, -2e-4), np.full(30, 1e-4)
    d, bounded = minimise_over_box(model.damped(1e-2), low, high)
    expected = scipy.optimize.lsq_linear(np.vstack(rows), np.concatenate(aim), (low, high), "bvls")
    cost = ((np.vstack(rows) @ d - np.concatenate(aim)) ** 2).sum() / 2
    assert bounded
    assert cost == pytest.approx(expected.cost, rel=1e-9)
