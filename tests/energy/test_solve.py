"""Drags in code: reachable, unreachable, pinned, drifting, at kinks; scipy as referee."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import scipy.optimize
import torch

import vfwidget as vf
from vfwidget.energy.descent import descend
from vfwidget.energy.energy import Energy
from vfwidget.solver.problem import Tolerances

FONTS = vf.bundled_fonts()


def random_handle(text: vf.Text, rng: np.random.Generator) -> vf.Handle:
    letter = int(rng.integers(len(text.glyphs)))
    contour = int(rng.integers(len(text.glyphs[letter].contours)))
    segment = int(rng.integers(text.glyphs[letter].contours[contour]))
    return text.handle(letter, contour, segment, rng.random())


def random_place(text: vf.Text, rng: np.random.Generator) -> vf.Text:
    lower, upper = text.font.bounds
    return text.at(theta=rng.uniform(lower, upper, tuple(text.theta.shape)))


def scipy_solve(text: vf.Text, terms: list[vf.Term]) -> float:
    """The same energy, from the same start, by scipy; its cost as ours counts it."""
    energy = Energy(text, terms)
    shape = tuple(text.theta.shape)
    lower, upper = (np.tile(b, shape[0]) for b in text.font.bounds)
    start = np.clip(text.theta.numpy().ravel(), lower + 1e-6, upper - 1e-6)
    found = scipy.optimize.least_squares(
        lambda x: energy.residual(x),
        start,
        lambda x: energy.jacobian(x),
        bounds=(lower, upper),
        xtol=1e-12,
        ftol=1e-12,
    )
    return 2 * found.cost


@pytest.mark.parametrize("name", FONTS)
@pytest.mark.parametrize("shared", [True, False])
def test_reachable_drags_arrive(name: str, shared: bool) -> None:
    rng = np.random.default_rng(5)
    text = vf.Text(name, "age", shared=shared)
    for _ in range(12):
        handle = random_handle(text, rng)
        place = random_place(text, rng)
        if place.glyphs[handle.glyph] is not text.glyphs[handle.glyph]:
            # The point of another glyph may lie where no point of this one comes to.
            continue
        goal = place.position(handle)
        before = text.theta.clone()
        solution = vf.solve(text, [vf.Target(handle, goal), vf.StayClose()])
        assert solution.status == "converged"
        assert solution.text.position(handle).tolist() == pytest.approx(goal.tolist(), abs=0.1)
        assert torch.equal(text.theta, before)


@pytest.mark.parametrize("name", FONTS)
def test_unreachable_drags_end_no_farther_than_scipy_and_brute_force(name: str) -> None:
    rng = np.random.default_rng(6)
    text = vf.Text(name, "R")
    lower, upper = text.font.bounds
    places = rng.uniform(lower, upper, (500, 1, len(lower)))
    for _ in range(6):
        handle = random_handle(text, rng)
        goal = text.position(handle).numpy() + rng.uniform(-1, 1, 2) * text.font.units_per_em
        terms = [vf.Target(handle, goal)]
        solution = vf.solve(text, terms)
        assert solution.converged
        # A place that is better but far away is offered, not taken.
        best = solution.misses[0]
        if solution.elsewhere is not None:
            offered = np.hypot(*(solution.elsewhere.position(handle).numpy() - goal))
            assert offered < best
            best = offered
        assert best**2 <= scipy_solve(text, terms) * (1 + 1e-6) + 1e-3
        points = text.point_set([handle])
        sampled = min(np.hypot(*(text.positions(points, p)[0] - goal)) for p in places)
        assert best <= sampled + 1e-6
        if solution.misses[0] > 0.5:
            assert solution.status == "unreachable"
            assert f"missed by {solution.misses[0]:.1f} font units" in solution.message


def test_an_unreachable_solve_repeated_from_its_end_does_not_move() -> None:
    text = vf.Text("recursive", "n")
    handle = text.nearest(500, 500)
    far = [vf.Target(handle, (3000, 3000)), vf.StayClose()]
    first = vf.solve(text, far)
    again = vf.solve(first.text, far)
    assert first.status == again.status == "unreachable"
    assert again.theta.numpy() == pytest.approx(first.theta.numpy(), abs=1e-6)


def test_an_axis_that_cannot_help_does_not_drift() -> None:
    # A round lower-case letter is not moved by the axis of the figures' height, among others.
    text = vf.Text("roboto-flex", "o")
    tags = [axis.tag for axis in text.font.axes]
    handle = text.nearest(600, 1100)
    target = vf.solve(text, [vf.Target(handle, text.position(handle) + 40), vf.StayClose()])
    start, end = text.theta[0], target.theta[0]
    corners = np.where(np.random.default_rng(9).random((64, len(tags))) < 0.5, -0.3, 0.3)
    idle = text.glyphs[0].jacobian(corners).abs().amax((0, 1, 2)) == 0
    assert idle[tags.index("YTFI")]
    assert torch.equal(start[idle], end[idle])
    assert not torch.equal(start, end)


def test_an_axis_that_cannot_help_does_not_drift_when_a_restart_wins() -> None:
    text = vf.Text("recursive", "R")
    handle = text.handle(0, 2, 15, 0.9889)
    target = [vf.Target(handle, (211.2, 53.5)), vf.StayClose()]
    assert vf.solve(text, target, restarts=0).status == "unreachable"
    found = vf.solve(text, target)
    assert found.status == "converged"
    assert found.axes["CRSV"] == text.axes["CRSV"]


def test_a_restart_that_gains_nothing_worth_seeing_is_not_taken() -> None:
    text = vf.Text("recursive", "n")
    handle = text.nearest(250, 500)
    x, y = text.position(handle).tolist()
    found = vf.solve(text, vf.Target(handle, (x, y + 10)))
    assert found.status == "unreachable"
    assert found.axes["MONO"] == text.axes["MONO"]


def test_a_restart_never_leaps_for_a_small_gain() -> None:
    """A reported drag: weight 100 became 1000 on release, to miss 754.9 units for 770.4."""
    rng = np.random.default_rng(17)
    text = vf.Text("afacad-flux", "wavy")
    em = text.font.units_per_em
    outline = text.point_set()
    for _ in range(12):
        handle = random_handle(text, rng)
        goal = text.position(handle).numpy() + rng.uniform(-0.25, 0.25, 2) * em
        terms = [vf.Target(handle, goal), vf.StayClose((0.001 * em) ** 2)]
        held, released = vf.solve(text, terms, restarts=0), vf.solve(text, terms)
        places = [outline.positions(found.place) for found in (held, released)]
        leap = np.hypot(*np.moveaxis(places[1] - places[0], -1, 0)).max()
        assert leap <= 0.02 * em or released.misses[0] <= 0.5
        if released.elsewhere is not None:
            there = released.elsewhere.position(handle).numpy() - goal
            assert np.hypot(*there) < released.misses[0] - 0.5


@pytest.mark.parametrize("name", FONTS)
def test_pins_hold_where_they_can(name: str) -> None:
    rng = np.random.default_rng(7)
    text = vf.Text(name, "hand", shared=False)
    for _ in range(6):
        pinned, dragged = random_handle(text, rng), random_handle(text, rng)
        # A place where the pin does hold: another instance is asked for by both at once.
        elsewhere = random_place(text, rng)
        goal = elsewhere.position(dragged)
        pin = vf.Pin(pinned, elsewhere.position(pinned))
        solution = vf.solve(text, [vf.Target(dragged, goal), pin, vf.StayClose()])
        assert solution.misses[1] < 0.5


def test_a_pin_outweighs_a_target_out_of_reach() -> None:
    text = vf.Text("roboto-flex", "H")
    pinned, dragged = text.nearest(200, 0), text.nearest(1200, 1400)
    solution = vf.solve(text, [vf.Target(dragged, (9000, 9000)), vf.Pin(pinned), vf.StayClose()])
    assert solution.status == "unreachable"
    assert solution.misses[1] < 0.5
    assert solution.misses[0] < float((text.position(dragged) - 9000).norm())


def test_stay_close_prefers_the_nearer_of_equivalent_places() -> None:
    text = vf.Text("recursive", "n", axes={"wght": 600})
    handle = text.nearest(100, 0)
    goal = text.position(handle)
    solution = vf.solve(text, [vf.Target(handle, goal), vf.StayClose()])
    assert solution.theta.numpy() == pytest.approx(text.theta.numpy(), abs=1e-9)


def test_any_function_of_the_points_can_be_a_residual() -> None:
    text = vf.Text("roboto-flex", "nd", shared=False)
    left, right = text.nearest(300, 1082), text.nearest(1800, 1500)

    def level(points: torch.Tensor) -> torch.Tensor:
        return points[:1, 1] - points[1:, 1]

    solution = vf.solve(text, [vf.Residual(level, handles=[left, right]), vf.StayClose()])
    heights = [float(solution.text.position(h)[1]) for h in (left, right)]
    assert (
        abs(heights[0] - heights[1])
        < 0.5
        < abs(float(text.position(left)[1] - text.position(right)[1]))
    )


def test_a_residual_over_the_whole_outline() -> None:
    text = vf.Text("dynapuff", "o")
    width = float(text.points()[:, 0].max() - text.points()[:, 0].min())

    def narrower(points: torch.Tensor) -> torch.Tensor:
        return points[:, 0].max() - points[:, 0].min() - (width - 60)

    solution = vf.solve(text, [vf.Residual(narrower), vf.StayClose()])
    found = solution.text.points()[:, 0]
    assert float(found.max() - found.min()) == pytest.approx(width - 60, abs=0.1)


def test_jacobian_of_every_term_against_central_differences() -> None:
    rng = np.random.default_rng(8)
    text = random_place(vf.Text("recursive", "ad", shared=False), rng)
    a, b = random_handle(text, rng), random_handle(text, rng)
    terms = [
        vf.Target(a, (100, 200), weight=2.0),
        vf.Pin(b),
        vf.StayClose(0.5),
        vf.Residual(lambda p: (p[0] - p[1]) ** 2 / 100, handles=[a, b]),
        vf.Residual(lambda p: p.mean(0)),
    ]
    energy = Energy(text, terms)
    theta = text.theta.numpy().ravel()
    jacobian = energy.jacobian(theta)
    for i in range(theta.size):
        step = np.zeros(theta.size)
        step[i] = 1e-6
        central = (energy.residual(theta + step) - energy.residual(theta - step)) / 2e-6
        assert jacobian[:, i] == pytest.approx(central, rel=1e-5, abs=1e-3)


def test_bad_terms_are_refused_and_the_text_is_as_it_was() -> None:
    text, other = vf.Text("dynapuff", "n"), vf.Text("dynapuff", "n")
    handle = text.handle()
    before = text.theta.clone()
    bad = [
        [],
        [handle],
        [vf.Target(other.handle(), (0, 0))],
        [vf.Target(handle, (np.nan, 0))],
        [vf.Target(handle, (0, 0, 0))],
        [vf.Target(handle, (0, 0), weight=-1)],
        [vf.StayClose(weight=np.inf)],
        [vf.Residual(lambda p: 3.0, handles=[handle])],
        [vf.Residual(lambda p: p * np.nan, handles=[handle])],
    ]
    for terms in bad:
        with pytest.raises(vf.SolveError):
            vf.solve(text, terms)
        assert torch.equal(text.theta, before)


def test_the_iteration_limit_is_said() -> None:
    text = vf.Text("recursive", "g")
    handle = text.nearest(300, -200)
    goal = text.at(axes={"wght": 900, "CASL": 0.7, "slnt": -12}).position(handle)
    solution = vf.solve(text, [vf.Target(handle, goal)], max_iterations=0)
    assert solution.status == "iteration_limit"
    assert not solution.converged


# Glyphs that change


def test_a_descent_at_another_state_has_the_bounds_of_that_state() -> None:
    text = vf.Text("dynapuff", "a")
    lower, upper = text.font.bounds
    energy = Energy(text.at(theta=[(lower + upper) / 2]), [vf.StayClose()])
    found = descend(energy, energy.unknowns.start, Tolerances(), 10)
    assert found.at_bounds is None
    ended = found._replace(state=replace(found.state, x=energy.upper))
    assert ended.at_bounds is not None and ended.at_bounds.all()


def test_many_letters_with_targets_need_no_singular_values(monkeypatch: pytest.MonkeyPatch) -> None:
    text = vf.Text("recursive", "hamburgefonstivhamb", shared=False)
    terms: list[vf.Term] = [vf.StayClose()]
    for letter in range(len(text.glyphs)):
        handle = text.handle(letter, 0, 0, 0.0)
        away = np.array([5 * np.sin(letter), 8 * np.cos(letter)])
        terms.append(vf.Target(handle, text.position(handle).numpy() + away))
    taken = []
    svd = np.linalg.svd
    monkeypatch.setattr(np.linalg, "svd", lambda *a, **k: taken.append(1) or svd(*a, **k))
    # At the second start some points do not move, apart from rounding errors.
    found = vf.solve(text, terms, restarts=1)
    assert found.active.any() and not taken


@pytest.mark.parametrize("options", [{}, {"free": ("axes", "offsets")}, {"ties": [(0, 1)]}])
def test_the_history_has_the_cost_of_preferences_that_disagree(options: dict[str, Any]) -> None:
    text = vf.Text("recursive", "hk", {"wght": 500}, shared=False)
    handle = text.handle(1, 0, 1, 0.5)
    x, y = text.position(handle).tolist()
    goal, heavy = vf.Target(handle, (x + 30, y)), vf.AxisTarget({"wght": 900}, weight=20.0)
    for terms in ([goal, vf.StayClose(10.0), heavy], [vf.StayClose(10.0), heavy]):
        for _ in range(2):
            found = vf.solve(text, terms, **options)
            costs = [cost for _, cost in found.history]
            assert costs[-1] == pytest.approx(found.cost, rel=1e-9) and found.cost > 1
            assert costs == sorted(costs, reverse=True)


def test_a_result_of_a_restart_counts_and_lists_all_steps_of_the_restart() -> None:
    text = vf.Text("afacad-flux", "a", {"slnt": 12.7, "wght": 737})
    handle = text.handle(0, 0, 5, 0.5)
    rng = np.random.default_rng(1)
    lower, upper = text.font.bounds
    moved = 0
    for _ in range(60):
        start = text.at(theta=rng.uniform(lower, upper)[None])
        goal = text.at(theta=rng.uniform(lower, upper)[None]).position(handle)
        terms = [vf.Target(handle, goal), vf.StayClose(1e-3)]
        alone, found = (vf.solve(start, terms, restarts=count) for count in (0, 8))
        if found.theta.tolist() != alone.theta.tolist():
            moved += 1
            assert found.iterations > 0
            assert len(found.history) == found.iterations + 1
            assert found.history[-1].cost == pytest.approx(found.cost)
    assert moved


def test_a_history_that_is_written_to_moves_no_text() -> None:
    text = vf.Text("recursive", "n", axes={"wght": 600})
    found = vf.solve(text, [vf.Target(text.nearest(600, 0), (580, 0)), vf.StayClose()])
    start, end = text.theta, found.theta.clone()
    for theta, _ in found.history:
        theta += 1
    assert (text.theta == start).all() and (found.text.theta == end).all()
    assert (vf.Text("recursive", "n", axes={"wght": 600}).theta == start).all()
