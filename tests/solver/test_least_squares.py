"""The solver by itself: scipy as referee, bounds, kinks, torch and arrays, bad input."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.optimize
import torch
from hypothesis import example, given, settings
from hypothesis import strategies as st

import vfwidget as vf
from vfwidget.solver.derivatives import CentralDifferences

seeds = st.integers(0, 2**32 - 1)


def rosenbrock(x):
    xp = torch if isinstance(x, torch.Tensor) else np
    return xp.stack([10 * (x[1] - x[0] ** 2), 1 - x[0]])


@pytest.mark.parametrize("kinks", [None, [[7.0], [9.0]]])
@pytest.mark.parametrize("start", [[3.0, 1.0], [[3.0, 1.0], [2.0, 0.5]]])
def test_a_bound_at_an_unlisted_kink_is_active_by_the_slope_within_the_bounds(start, kinks):
    """There autograd says that the slope of an absolute value is 0."""

    def residual(x):
        return torch.stack([x[..., 0].abs() + 1, x[..., 1] - 2], -1)

    found = vf.least_squares(
        residual, torch.tensor(start), bounds=(0, 10), kinks=kinks, cost_floor=1.0001
    )
    assert (found.x[..., 0] == 0).all()
    assert (found.active == [-1, 0]).all()


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
@settings(max_examples=60, deadline=None, derandomize=True)
def test_linear_problems_with_bounds_as_scipy_has_them(seed: int) -> None:
    rng = np.random.default_rng(seed)
    m, n = int(rng.integers(1, 12)), int(rng.integers(1, 8))
    matrix, goal = rng.normal(size=(m, n)), rng.normal(size=m) * 3
    ours = vf.least_squares(lambda x: matrix @ x - goal, np.zeros(n), bounds=(-1, 1))
    theirs = scipy.optimize.lsq_linear(matrix, goal, bounds=(-1, 1), tol=1e-12)
    assert ours.cost == pytest.approx(2 * theirs.cost, rel=1e-6, abs=1e-9)


def test_a_bound_is_met_exactly_although_the_distance_to_it_is_rounded() -> None:
    rng = np.random.default_rng(0)
    for start, bound in zip(rng.uniform(-1, 0.2, 200), rng.uniform(0.2, 1, 200), strict=True):
        for side in (1, -1):
            bounds = sorted([-side, side * bound])
            found = vf.least_squares(lambda x, far=2 * side: x - far, [side * start], bounds=bounds)
            assert found.x == [side * bound] and found.active == [side]


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
@settings(max_examples=80, deadline=None, derandomize=True)
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


def growing():
    """A residual with one value more at each call."""
    values = [1.0]

    def residual(x):
        values.append(1.0)
        return np.array(values) * x[0]

    return residual


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda: vf.least_squares(lambda x: x * np.nan, [1.0]), "finite"),
        (lambda: vf.least_squares(lambda x: x / 0, [np.nan]), "x0 lies outside"),
        (lambda: vf.least_squares(lambda x: x, [2.0], bounds=(0, 1)), "outside the bounds"),
        (lambda: vf.least_squares(lambda x: x, [0.0], bounds=(1, -1)), "above its upper"),
        (lambda: vf.least_squares(lambda x: x, [0.0], bounds=([0, 1], [2, 2])), "do not fit"),
        (lambda: vf.least_squares(lambda x: x, [[[0.0]]]), "shape"),
        (lambda: vf.least_squares(lambda x: x, [1.0], loss="median"), "soft_l1"),
        (lambda: vf.least_squares(lambda x: x, [1.0], jacobian=lambda x: np.eye(2)), r"\(1, 1\)"),
        (lambda: vf.least_squares(lambda x: x, [1.0], jacobian=lambda x: x * np.nan), "Jacobian"),
        (lambda: vf.least_squares(lambda x: x, [1.0], scale="rows"), "columns"),
        (lambda: vf.least_squares(lambda x: x, [1.0], kinks=[[], []]), "kinks"),
        (lambda: vf.least_squares(lambda x: x, [1.0], max_iterations=-5), "max_iterations.*-5"),
        (lambda: vf.least_squares(lambda x: x, [1.0], max_iterations=2.5), "max_iterations.*2.5"),
        (lambda: vf.least_squares(lambda x: x, [1.0], max_iterations=np.nan), "max_iterations"),
        (lambda: vf.least_squares(lambda x: x, [1.0], max_iterations=None), "max_iterations.*None"),
        (lambda: vf.least_squares(lambda x: x, [1.0], step_tolerance=np.nan), "step_tol.*nan"),
        (lambda: vf.least_squares(lambda x: x, [1.0], gradient_tolerance=-1), "gradient_tolerance"),
        (lambda: vf.least_squares(lambda x: x, [1.0], relative_cost_tolerance="1"), "relative"),
        (lambda: vf.least_squares(lambda x: x, [1.0], cost_floor=np.inf), "cost_floor.*inf"),
        (lambda: vf.least_squares(lambda x: x, [1.0], loss_scale=0), "loss_scale"),
        (lambda: vf.least_squares(lambda x: x, [1j]), "x0 must be real"),
        (lambda: vf.least_squares(lambda x: x, torch.tensor([1j])), "x0 must be real"),
        (lambda: vf.least_squares(lambda x: x * 1j, [1.0]), r"residual\(x\) must be real"),
        (lambda: vf.least_squares(lambda x: "no", [1.0]), r"residual\(x\) must be an array"),
        (lambda: vf.least_squares(lambda x: None, [1.0]), "finite"),
        (lambda: vf.least_squares([1.0], lambda x: x), "residual must be a function"),
        (lambda: vf.least_squares(lambda x: x, [1.0], jacobian=3), "jacobian must be a function"),
        (lambda: vf.least_squares(lambda x: x, "start"), "x0 must be an array of numbers"),
        (lambda: vf.least_squares(lambda x: x, []), r"\(0,\)"),
        (lambda: vf.least_squares(lambda x: x, [1.0], bounds=1), "pair"),
        (lambda: vf.least_squares(growing(), [1.0, 2.0]), "changed its shape"),
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
@settings(max_examples=10, deadline=None, derandomize=True)
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


@pytest.mark.parametrize("away", [0.0, 1e-16, 1e-14, 1e-12, 1e-10, 1e-8, 1e-6, 1e-3])
@pytest.mark.parametrize("tensors", [False, True])
def test_a_start_near_a_corner_of_the_bounds_reaches_the_optimum(away, tensors) -> None:
    time = np.linspace(0, 4, 30)
    data = 2.5 * np.exp(-1.3 * time) + 0.5
    bounds = ([0, 0, 0], [10, 5, 2])

    def residual(x):
        xp = torch if isinstance(x, torch.Tensor) else np
        t, y = (torch.tensor(v) if tensors else v for v in (time, data))
        return x[0] * xp.exp(-x[1] * t) + x[2] - y

    upper = np.array(bounds[1], dtype=float)
    for corner in np.ndindex(2, 2, 2):
        if corner == (0, 0, 1) and away < 1e-10:
            # The first step leads to a saddle at (0, 0, mean of the data), where scipy stays too.
            continue
        start = np.where(corner, upper - away, away)
        given_start = torch.tensor(start) if tensors else start
        found = vf.least_squares(residual, given_start, bounds=bounds, max_iterations=300)
        assert found.cost < 1e-12
        assert found.converged


@given(seeds, st.sampled_from([0.0, 1e-14, 1e-12, 1e-10, 1e-9, 1e-8, 1e-7, 1e-5]))
@settings(max_examples=60, deadline=None, derandomize=True)
def test_a_start_near_a_kink_or_bound_is_not_where_a_convex_problem_ends(seed, away) -> None:
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 4))
    kinks = rng.uniform(-0.5, 0.5, n)
    goal, slopes = rng.uniform(-1, 1, n), rng.uniform(0.5, 3, (2, n))

    def position(x):
        # Rises at another rate on either side of the kink: each variable has one optimum.
        return np.where(x < kinks, slopes[0], slopes[1]) * (x - kinks)

    side = rng.choice([-1, 0, 1], n)
    start = np.select([side < 0, side > 0], [-1 + away, 1 - away], kinks + away)
    found = vf.least_squares(
        lambda x: position(x) - position(goal), start, bounds=(-1, 1), kinks=kinks[:, None]
    )
    assert found.converged
    assert found.x == pytest.approx(goal, abs=1e-7)


def test_a_wrong_derivative_is_no_convergence() -> None:
    found = vf.least_squares(lambda x: x - 3, [1.0], jacobian=lambda x: -np.eye(1))
    assert found.status == "stalled" and not found.converged
    assert "Jacobian" in found.message


def test_a_kink_that_is_not_listed_is_no_convergence() -> None:
    # Both slopes point at the kink at 0.3, where the model never fits.
    found = vf.least_squares(lambda x: np.array([1 + abs(x[0] - 0.3), x[0] - 0.3]), [1.0])
    assert found.x[0] == pytest.approx(0.3, abs=1e-6)
    assert found.status == "stalled"


@pytest.mark.parametrize("seed", [96, 221, 251, 269])
def test_a_zigzag_along_a_kink_that_is_not_listed_is_no_convergence(seed: int) -> None:
    rng = np.random.default_rng(seed)
    slopes, bend, normal = rng.normal(size=(3, 2)), rng.normal(size=3), rng.normal(size=2)
    goal = 30 * rng.normal(size=3)

    def residual(x: np.ndarray) -> np.ndarray:
        return 20 * slopes @ x + 80 * bend * max(normal @ x - 0.1, 0) - goal

    start = rng.uniform(-1, 1, 2)
    found = vf.least_squares(
        residual, start, bounds=(-1, 1), absolute_cost_tolerance=1e-4, scale="none"
    )
    angles = np.linspace(0, 2 * np.pi, 361)
    beside = found.x + 1e-3 * np.stack([np.cos(angles), np.sin(angles)], 1)
    least = min((residual(x) ** 2).sum() for x in beside.clip(-1, 1))
    assert not found.converged or least > found.cost - 0.02


def test_the_status_at_the_iteration_limit_says_so() -> None:
    found = vf.least_squares(rosenbrock, [-1.2, 1.0], max_iterations=3)
    assert found.status == "iteration_limit" and found.iterations == 3
    assert "iteration limit, 3," in found.message


def test_former_names_of_tolerances_still_work_and_warn() -> None:
    options = {"cost_tolerance": 1e-3, "gain_tolerance": 1e-2, "zero": 1e-1}
    names = ["relative_cost_tolerance", "absolute_cost_tolerance", "cost_floor"]
    for (old, value), new in zip(options.items(), names, strict=True):
        with pytest.warns(DeprecationWarning, match=f"{old}= is now called {new}="):
            former = vf.least_squares(rosenbrock, [-1.2, 1.0], **{old: value})
        present = vf.least_squares(rosenbrock, [-1.2, 1.0], **{new: value})
        assert former.x.tolist() == present.x.tolist()


def test_a_result_shows_itself_in_a_few_lines() -> None:
    one = vf.least_squares(rosenbrock, [-1.2, 1.0])
    assert 2 <= len(repr(one).splitlines()) <= 3
    assert "converged after" in repr(one) and "x [1, 1]" in repr(one)
    long = vf.least_squares(lambda x: x - 1, np.zeros(300))
    assert "300 variables" in repr(long) and len(repr(long)) < 300
    many = vf.least_squares(trigonometric, np.full((5, 3), 0.5))
    assert "5 problems of 3 variables" in repr(many)
    assert one._repr_html_().startswith("<pre>converged")


@given(seeds, st.sampled_from(["columns", "none"]))
@settings(max_examples=60, deadline=None, derandomize=True)
def test_where_it_converges_no_step_of_a_linear_solver_lowers_the_cost(seed, scale) -> None:
    rng = np.random.default_rng(seed)
    m, n = int(rng.integers(1, 9)), int(rng.integers(1, 7))
    matrix = rng.normal(size=(m, n)) * 10.0 ** rng.uniform(-3, 3, (m, 1))
    matrix *= 10.0 ** rng.uniform(-2, 2, n)
    wave = rng.normal(size=(m, n)) * rng.choice([0, 0.1, 1])
    goal = rng.normal(size=m) * 10.0 ** rng.uniform(-2, 2)
    lower, upper = -rng.exponential(2, size=n), rng.exponential(2, size=n)

    def residual(x):
        return matrix @ x + wave @ np.sin(x) - goal

    def jacobian(x):
        return matrix + wave * np.cos(x)

    start = np.clip(rng.normal(size=n), lower, upper)
    found = vf.least_squares(residual, start, jacobian, (lower, upper), scale=scale)
    if not found.converged:
        assert found.status == "iteration_limit"
        return
    room = lower - found.x - 1e-12, upper - found.x + 1e-12
    slope, values = jacobian(found.x), residual(found.x)
    step = scipy.optimize.lsq_linear(slope, -values, room, method="bvls", tol=1e-15).x
    for part in (1, 0.3, 0.1, 0.03, 0.01, 1e-3):
        there = np.clip(found.x + part * step, lower, upper)
        assert (residual(there) ** 2).sum() >= found.cost * (1 - 1e-7) - 1e-10


@pytest.mark.parametrize("unit", [1e-130, 1e-100, 1e100, 1e150])
def test_the_unit_of_the_residual_does_not_matter(unit: float) -> None:
    found = vf.least_squares(
        lambda x: unit * (x - [1, 2]), [0.0, 0.0], lambda x: unit * np.eye(2), scale="none"
    )
    assert found.converged
    assert found.x == pytest.approx([1, 2])


def test_a_column_too_small_to_square_is_left_alone() -> None:
    found = vf.least_squares(
        lambda x: x * [1e-160, 1] - [1e-160, 2], [0.0, 0.0], lambda x: np.diag([1e-160, 1])
    )
    assert found.converged
    assert found.x[1] == pytest.approx(2)


def test_differences_are_exact_at_bounds_and_kinks_too() -> None:
    def residual(x):
        return np.stack([np.exp(x[..., 0]), np.sin(3 * x[..., 1]) + abs(x[..., 1] - 0.5)], -1)

    start = np.array([1.0, 0.5])
    lower, upper = np.array([1.0, -1.0]), np.array([2.0, 0.5])
    found = CentralDifferences(residual, start, lower, upper, np.array([[np.inf], [0.5]]))
    for x in ([1.0, 0.5], [2.0, -1.0], [1 + 2e-6, 0.5 - 1e-8]):
        exact = np.diag([np.exp(x[0]), 3 * np.cos(3 * x[1]) - 1])
        assert found(np.array(x)) == pytest.approx(exact, abs=1e-8)


def test_a_start_on_a_corner_that_is_also_a_kink_rests_there() -> None:
    # At (0, 1) the slope by the second variable is 0, but not beside the kink of the first one.
    def residual(x: np.ndarray) -> np.ndarray:
        return np.array([8.0 + 2 * x[0] - x[0] * x[1]])

    def slopes(x: np.ndarray) -> np.ndarray:
        return np.array([[2 - x[1], -x[0]]])

    bounds, kinks = (0, [0.5, 2]), [[0, 1], [0, 1]]
    found = vf.least_squares(residual, [0, 1], slopes, bounds, kinks=kinks)
    assert found.status == "converged"
    assert found.x == pytest.approx([0, 1], abs=1e-6)


@pytest.mark.parametrize("seed", range(6))
def test_products_of_kinks_converge_from_corners(seed: int) -> None:
    rng = np.random.default_rng(seed)
    for _ in range(20):
        deltas = torch.tensor(rng.normal(size=(5, 4)))
        used = torch.tensor(rng.random((5, 3)) < 0.6)
        peak = torch.tensor(rng.choice([-1, 1], (5, 3)))

        def residual(x: torch.Tensor) -> torch.Tensor:
            scalars = torch.where(used, (x * peak).clip(0), 1.0).prod(1)  # noqa: B023
            return scalars @ deltas - 3 * deltas[0]  # noqa: B023

        lower, upper = rng.choice([-1, 0], 3), rng.choice([0.5, 1], 3)
        start = torch.tensor(np.where(rng.random(3) < 0.5, lower, rng.choice([0, 1], 3) * upper))
        found = vf.least_squares(residual, start, bounds=(lower, upper), kinks=[[-1, 0, 1]] * 3)
        assert found.status == "converged"
        for step in rng.normal(size=(60, 3)) * 1e-4:
            beside = torch.tensor(np.clip(found.x.numpy() + step, lower, upper))
            assert float((residual(beside) ** 2).sum()) > found.cost - 1e-6 * (1 + found.cost)
