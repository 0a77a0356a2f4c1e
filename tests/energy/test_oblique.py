"""Kinks that are not parallel to the axes (avar 2)."""

from __future__ import annotations

import warnings

import fonts
import formats
import numpy as np
import pytest
import variation_tables
from fontTools.ttLib import newTable
from fontTools.ttLib.tables import otTables
from fontTools.varLib import builder as varLib_builder

import vfwidget as vf
from vfwidget.energy.checked import bound
from vfwidget.energy.descent import descend
from vfwidget.energy.oblique import along_planes
from vfwidget.energy.tied import energy_of
from vfwidget.solver.problem import Tolerances


def folded() -> vf.Font:
    """Weight moves the glyph by (100, 0); wdth - 0.8 wght lifts it on both sides of 0."""

    def add(builder):
        avar = builder.font["avar"] = newTable("avar")
        avar.majorVersion, avar.segments = 2, {"wght": {}, "wdth": {}}
        avar.table = otTables.avar()
        regions = varLib_builder.buildVarRegionList([fonts.BOLD], ["wght", "wdth"])
        rows = varLib_builder.buildVarData([0], [[0], [-13107]], optimize=False)
        avar.table.VarIdxMap = None
        avar.table.VarStore = varLib_builder.buildVarStore(regions, [rows])

    square = fonts.outline([(0, 0), (0, 300), (300, 300), (300, 0)])
    sets = [(fonts.BOLD, (100, 0)), (fonts.WIDE, (0, 400)), ({"wdth": (-1, -1, 0)}, (0, 400))]
    deltas = {"a": [(region, [move] * 4 + fonts.STILL) for region, move in sets]}
    return vf.load_font(fonts.build({"a": square}, deltas, edit=add))


@pytest.mark.parametrize("shared", [True, False])
def test_a_drag_follows_the_fold_along_which_the_cost_falls(shared):
    text = vf.Text(folded(), "a", shared=shared)
    handle = text.handle(0, 0, 1)
    x, y = text.position(handle).tolist()
    # Either axis by itself leaves the fold and lifts the point; only both together follow it.
    solution = vf.solve(text, vf.Target(handle, (x + 60, y - 50)), restarts=0)
    assert solution.theta.numpy()[0] == pytest.approx([0.6, 0.48], abs=1e-3)
    assert max(solution.misses) == pytest.approx(50, abs=1e-3)
    assert solution.status == "unreachable"


def test_a_locked_axis_stays():
    text = vf.Text(folded(), "a")
    handle = text.handle(0, 0, 1)
    x, y = text.position(handle).tolist()
    solution = vf.solve(text, vf.Target(handle, (x + 60, y - 50)), locks=["wdth"], restarts=0)
    assert np.allclose(solution.theta, 0, atol=1e-6)


@pytest.mark.parametrize("locked", ["wght", "wdth"])
def test_an_axis_that_is_locked_beside_a_kink_stays_there(locked):
    text = vf.Text(folded(), "a").at(theta=[[0.002, 0.001]])
    handle = text.handle(0, 0, 1)
    x, y = text.position(handle).tolist()
    solution = vf.solve(text, vf.Target(handle, (x + 60, y - 50)), locks=[locked])
    kept = ["wght", "wdth"].index(locked)
    assert solution.theta[0, kept] == text.theta[0, kept]
    assert solution.status == "unreachable"


def test_a_solve_stays_in_a_box_in_which_its_glyphs_stay():
    text = vf.Text(vf.load_font(variation_tables.avar_2_with_conditions()), "a")
    rng = np.random.default_rng(2)
    sizes = []
    for w in rng.uniform(-1, 1, (12, 2)):
        moved = text.at(theta=[w])
        lower, upper = moved.composition.bounds_at(moved.coordinates)
        assert ((lower <= w) & (w <= upper)).all()
        sizes.append(float((upper - lower).prod()))
        for other in rng.uniform(lower, upper, (8, 1, 2)):
            assert moved.at(theta=other).word is moved.word
    assert np.median(sizes) > 0.5


def test_a_drag_goes_on_beyond_an_oblique_boundary_and_says_so():
    text = vf.Text(vf.load_font(variation_tables.avar_2_with_conditions()), "ab")
    end = text.at({"wght": 850, "wdth": 80})
    assert [glyph.name for glyph in end.glyphs] == ["b", "b"]
    handle = text.handle(1, 0, 1)
    target = end.position(end.carry(handle))
    solution = vf.solve(text, vf.Target(handle, target))
    reached = solution.text.position(solution.text.carry(handle))
    assert np.linalg.norm(reached - target) == pytest.approx(max(solution.misses), abs=1e-6)


def test_a_solve_leaves_a_box_that_is_as_narrow_as_one_value():
    move = {"a": [(fonts.BOLD, [(200, 0)] * 4 + fonts.STILL)]}
    boxes = [{"wght": (0.2, 0.6), "wdth": (-0.5, 0.5)}]
    font = vf.load_font(fonts.swapping(boxes, variation_tables.add_avar_2, move))
    text = vf.Text(font, "a").at(theta=[[0.12, 0.56]])
    lower, upper = text.composition.bounds_at(text.coordinates)
    assert lower[0, 0] == upper[0, 0]
    handle, goal = text.handle(), text.at(theta=[[0.19, 0.13]])
    terms = [vf.Target(handle, goal.position(handle)), vf.AxisTarget(goal.axes)]
    assert vf.solve(text, terms, restarts=0).status == "converged"
    held = vf.solve(text, terms, restarts=0, locks=["wght"])
    assert held.status == "unreachable" and held.theta[0, 0] == 0.12
    assert not held.active.any()


def test_a_descent_that_could_follow_a_fold_further_says_so(monkeypatch):
    text = vf.Text(folded(), "a")
    handle = text.handle(0, 0, 1)
    x, y = text.position(handle).tolist()
    monkeypatch.setattr("vfwidget.energy.oblique.MOST_STEPS", 1)
    found = vf.solve(text, vf.Target(handle, (x + 60, y - 50)), restarts=0)
    assert found.status == "iteration_limit" and not found.converged


def random_solve(name: str, seed: int) -> tuple[vf.Text, list[vf.Term]]:
    """Targets and pins for letters whose axes start at random, at bounds and at kinks."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", vf.FontWarning)
        font = vf.load_font(formats.CONFORMANCE / "formats" / name)
    rng = np.random.default_rng(seed)
    lower, upper = font.bounds
    letters = "tesT" if "Amstelvar" in name else "abc"
    string = "".join(rng.choice(list(letters), rng.integers(1, 4)))
    text = vf.Text(font, string, shared=bool(rng.integers(2)))

    def place():
        w = rng.uniform(lower, upper, text.theta.shape)
        w = np.where(rng.random(w.shape) < rng.choice([0, 0.6, 0.9]), 0, w)
        at_ends = rng.random(w.shape) < rng.choice([0, 0.3])
        return np.where(at_ends, np.where(rng.random(w.shape) < 0.5, lower, upper), w)

    text, goal = text.at(theta=place()), text.at(theta=place())
    terms: list[vf.Term] = []
    for _ in range(rng.integers(1, 4)):
        letter, segment = int(rng.integers(len(text.glyphs))), int(rng.integers(4))
        handle = text.handle(letter, 0, segment, float(rng.random()))
        near = text.position(handle).numpy() + rng.normal(size=2) * rng.choice([20, 100, 400])
        position = goal.position(handle).numpy() if rng.random() < 0.3 else near
        terms.append((vf.Pin if rng.random() < 0.2 else vf.Target)(handle, position))
    return text, [*terms, vf.StayClose()] if rng.random() < 0.5 else terms


def lower_costs(text: vf.Text, terms: list[vf.Term], solution: vf.Solution) -> tuple[float, float]:
    """The cost of a solution, and the lowest one that small random steps within bounds reach."""
    energy = energy_of(solution.text, [bound(term, text) for term in terms])

    def cost(x):
        residual, away = energy.residual(x), x - energy.proximity.reference
        return residual @ residual + energy.proximity.weights * away @ away + energy.constant

    rng = np.random.default_rng(0)
    x = energy.unknowns.start
    first = best = cost(x)
    for _ in range(400):
        step = rng.normal(size=len(x)) * (rng.random(len(x)) < rng.uniform(0.05, 1))
        moved = np.clip(x + 10 ** rng.uniform(-6, -3) * step, energy.lower, energy.upper)
        if cost(moved) < best:
            x, best = moved, cost(moved)
    return first, best


@formats.needs_conformance
@pytest.mark.parametrize("seed", range(16))
@pytest.mark.parametrize("name", ["Amstelvar-avar2.subset.ttf", "RobotoDelta-Roman-VF-subset.ttf"])
def test_a_solve_over_many_axes_ends_where_no_small_step_lowers_the_cost(name, seed):
    text, terms = random_solve(name, seed)
    solution = vf.solve(text, terms, restarts=0)
    assert solution.status in ("converged", "unreachable"), solution.message
    first, best = lower_costs(text, terms, solution)
    assert first == pytest.approx(solution.cost, rel=1e-6, abs=1e-9)
    assert best > first * (1 - 1e-3) - 1e-3


@formats.needs_conformance
def test_points_that_rest_on_one_side_of_a_plane_are_solved_for():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", vf.FontWarning)
        font = vf.load_font(formats.CONFORMANCE / "formats" / "Amstelvar-avar2.subset.ttf")
    start = [-0.05888626, 0.14238611, -0.79872885, -1, -0.94267406, 0]
    start += [-1, -1, -1, -0.14183592, -0.93802401, 0.83480498]
    text = vf.Text(font, "es", shared=False).at(theta=[start] * 2)
    target = vf.Target(text.handle(1, 0, 33, 0.6666673066382406), (449.2226538, 18.5907211))
    ends = text.handle(1, 0, 4, 0.35613481195982866), text.handle(0, 0, 0, 0.3)
    found = vf.solve(text, [target, vf.SharedX(ends, weight=10)], restarts=3)
    assert found.status == "unreachable"


def test_no_step_along_planes_is_tried_after_the_time_limit():
    text = vf.Text(folded(), "a")
    handle = text.handle(0, 0, 1)
    x, y = text.position(handle).tolist()
    energy = energy_of(text, [vf.Target(handle, (x + 60, y - 50))])

    def down(energy, x):
        return descend(energy, x, Tolerances(absolute_cost=1e-4), 100)

    first = down(energy, energy.unknowns.start)
    late = along_planes(energy, first, down, deadline=0.0)
    assert late.state.outcome.status == "time_limit" and late.state.cost == first.state.cost
    assert along_planes(energy, first, down).state.cost < first.state.cost
