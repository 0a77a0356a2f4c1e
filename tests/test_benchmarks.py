"""The simulations of the benchmarks, in small: they run, and they measure what they should."""

from __future__ import annotations

import importlib
import pkgutil

import numpy as np
import pytest

import benchmarks
import vfwidget as vf
from benchmarks import overlap, reach, study
from benchmarks.overlap_cases import KINDS, cases


def test_outlines_are_as_far_apart_as_their_points() -> None:
    text = vf.Text("roboto-flex", "R")
    outline = study.Outline(text)
    goals = np.random.default_rng(0).uniform(*text.font.bounds, (2, 1, len(text.font.axes)))
    apart = outline.places(goals[0]) - outline.places(goals[1])
    expected = np.sqrt((apart**2).sum(1).mean()) / text.font.units_per_em
    assert np.linalg.norm(outline.difference(*goals)) == pytest.approx(expected)


def test_people_need_nothing_for_the_default_and_one_move_for_one_axis() -> None:
    text = vf.Text("recursive", "a")
    outline, rng = study.Outline(text), np.random.default_rng(0)
    bold = text.at(axes={"wght": 800}).theta.numpy()
    for goal, moves in ((text.theta.numpy(), 0), (bold, 1)):
        assert study.slider_moves(outline, goal) == moves
        assert study.drags(outline, goal, study.POLICIES[0], rng) == moves


def test_study_at_its_smallest() -> None:
    counts = study.study("dynapuff", "a", 2)
    assert counts.shape == (len(study.POLICIES) + 1, 2)
    assert np.isfinite(counts[0]).all()


def test_brute_force_tells_what_is_in_reach() -> None:
    text, rng = vf.Text("shantell-sans", "g"), np.random.default_rng(0)
    handle = reach.random_handle(text, rng)
    places = rng.uniform(*text.font.bounds, (4, 1, len(text.font.axes)))
    targets = np.concatenate([[text.at(theta=place).position(handle).numpy()] for place in places])
    near = reach.brute_force(text, handle, targets, rng)
    far = reach.brute_force(text, handle, targets + 5000, rng)
    assert (near <= reach.WITHIN).all()
    assert (far > 1000).all()


def test_a_solve_reaches_positions_that_are_in_reach() -> None:
    for place in reach.places("dynapuff", "a", 4):
        assert reach.attempt(place, restarts=8).miss <= reach.WITHIN


def test_a_drag_follows_and_its_leaps_are_counted() -> None:
    text = vf.Text("recursive", "n")
    offsets = 1000 * reach.line()[:5]
    axes = reach.follow(text, text.nearest(250, 500), offsets, stay_close=1.0)
    assert axes.shape == (5, len(text.font.axes))
    assert axes[0] == pytest.approx(0, abs=1e-6)


def test_leaps_go_there_and_back_within_three_events() -> None:
    still = np.full((9, 2), 0.5)
    assert reach.leaps(still) == 0
    for events, count in (((4,), 1), ((4, 5), 2), ((4, 5, 6), 0)):
        axes = still.copy()
        axes[events, 1] = 0.8
        assert reach.leaps(axes) == count


@pytest.mark.slow
def test_overlap_cases_have_a_free_witness_and_both_methods_run() -> None:
    found = list(cases(3, seed=5))
    assert [case.kind for case in found] == list(KINDS)
    for case in found:
        assert vf.overlaps(case.text, case.obstacles)
        assert not vf.overlaps(case.text.at(theta=case.witness), case.obstacles)
        for text in (overlap.resolved(case, restarts=0), overlap.planes_in_a_loop(case)):
            assert text.word is case.text.word


def test_every_benchmark_can_be_imported() -> None:
    """Their functions take too long to be run here, but what they import must exist."""
    modules = [module.name for module in pkgutil.iter_modules(benchmarks.__path__)]
    for name in (name for name in modules if name != "__main__"):
        importlib.import_module(f"benchmarks.{name}")
