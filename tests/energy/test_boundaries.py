"""Solves that meet locations at which glyphs change: what they cross, and what they say."""

from __future__ import annotations

from typing import Any

import fonts
import numpy as np
import pytest
import torch
import variation_tables
from fontTools.varLib.featureVars import addFeatureVariations

import vfwidget as vf
from vfwidget.energy.energy import Energy
from vfwidget.text.word import Word


def exchanged(
    string: str = "a", shared: bool = True, below: int = 200, above: int = 300
) -> vf.Text:
    """A square that moves by 200 with the weight; another one above 0.5, which moves by 300."""
    moved = [(below, 0)] * 4
    glyphs = {"a": fonts.outline(fonts.SQUARE), "bowl": fonts.outline(fonts.SQUARE)}
    deltas = {"a": [(fonts.BOLD, [*moved, *fonts.STILL])]}
    deltas["bowl"] = [(fonts.BOLD, [(above, 0)] * 4 + fonts.STILL)]

    def edit(builder) -> None:
        addFeatureVariations(builder.font, [([{"wght": (0.5, 1)}], {"a": "bowl"})])

    return vf.Text(fonts.build(glyphs, deltas, edit=edit), string, shared=shared)


def test_a_boundary_is_crossed_where_that_is_better() -> None:
    text = exchanged()
    handle = text.handle()
    x, y = text.position(handle).tolist()
    found = vf.solve(text, [vf.Target(handle, (x + 240, y)), vf.StayClose()])
    assert found.status == "converged"
    assert found.text.glyphs[0].name == "bowl"
    assert found.theta[0, 0] == pytest.approx(0.8, abs=1e-3)
    (met,) = found.boundaries
    assert (met.axis, met.before, met.after, met.crossed) == ("wght", ("a",), ("bowl",), True)
    assert met.value == pytest.approx(650, abs=0.1)
    assert "a becomes bowl at wght = 650: crossed" in found.report()


def test_a_boundary_is_not_crossed_where_that_costs_more() -> None:
    """Just below the boundary the square has moved by 100, just above it by 150."""
    text = exchanged()
    handle = text.handle()
    x, y = text.position(handle).tolist()
    found = vf.solve(text, [vf.Target(handle, (x + 110, y)), vf.StayClose()])
    assert found.status == "unreachable" and found.misses[0] == pytest.approx(10, abs=0.1)
    assert found.text.glyphs[0].name == "a" and not found.active.any()
    assert [met.crossed for met in found.boundaries] == [False]
    assert "a becomes bowl at wght = 650: not crossed" in found.message


def exchanged_twice() -> vf.Text:
    """As :func:`exchanged`, with a third square in a narrow box in between."""
    moves = {"a": 200, "thin": -900, "bowl": 300}
    glyphs = {name: fonts.outline(fonts.SQUARE) for name in moves}
    deltas = {n: [(fonts.BOLD, [(x, 0)] * 4 + fonts.STILL)] for n, x in moves.items()}

    def edit(builder) -> None:
        boxes = [("thin", 0.5, 8197 / 2**14), ("bowl", 8198 / 2**14, 1)]
        swaps = [([{"wght": (low, high)}], {"a": name}) for name, low, high in boxes]
        addFeatureVariations(builder.font, swaps)

    return vf.Text(fonts.build(glyphs, deltas, edit=edit), "a")


@pytest.mark.parametrize("back", [False, True])
def test_a_solve_looks_beyond_a_narrow_box_whose_glyph_costs_more(back: bool) -> None:
    """Recursive has such boxes, because the ends of its condition sets differ very slightly."""
    text = exchanged_twice()
    assert len(text.composition.settings.rows) == 3
    text = text.at(theta=[[0.9, 0]]) if back else text
    handle = text.handle()
    x, y = text.position(handle).tolist()
    found = vf.solve(text, vf.Target(handle, (x - 200 if back else x + 240, y)), restarts=0)
    assert found.status == "converged"
    assert found.text.glyphs[0].name == ("a" if back else "bowl")
    names = [("a", "bowl"), ("bowl", "a")][back]
    assert [(met.before[0], met.after[0], met.crossed) for met in found.boundaries] == [
        (*names, True)
    ]
    # A goal that no box reaches is compared with the nearest one.
    far = vf.solve(text, vf.Target(handle, (x + 9000, y)), restarts=0)
    assert far.status == "unreachable"


def test_no_result_lies_beyond_the_end_of_an_axis() -> None:
    """Where axes move others, a box may end much nearer to the end of an axis than a step."""
    text = vf.Text(vf.load_font(variation_tables.avar_2_with_conditions()), "a")
    for width in np.linspace(0.6, 1, 9):
        start = text.at(theta=[[0.5, width]])
        handle = start.handle()
        x, y = start.position(handle).tolist()
        for reach in (-3000, 3000):
            found = vf.solve(start, vf.Target(handle, (x + reach, y)), restarts=0)
            assert (abs(found.theta) <= 1).all()


def test_a_boundary_is_crossed_without_restarts_too() -> None:
    """So that a glyph changes while it is dragged."""
    text = exchanged()
    handle = text.handle()
    x, y = text.position(handle).tolist()
    found = vf.solve(text, vf.Target(handle, (x + 240, y)), restarts=0)
    assert found.text.glyphs[0].name == "bowl" and found.converged
    back = vf.solve(found.text, vf.Target(handle, (x + 60, y)), restarts=0)
    assert back.text.glyphs[0].name == "a" and back.converged


def test_the_result_of_a_restart_goes_on_beyond_a_boundary() -> None:
    """At light weights the square stays where it is, so the first descent ends at its start."""
    text = exchanged(below=30, above=40).at(theta=[[-0.3, 0]])
    handle = text.handle()
    x, y = text.position(handle).tolist()
    found = vf.solve(text, vf.Target(handle, (x + 36, y)))
    assert found.status == "converged" and found.text.glyphs[0].name == "bowl"
    assert [met.crossed for met in found.boundaries] == [True]
    beyond = vf.solve(text, vf.Target(handle, (x + 50, y)))
    assert beyond.status == "unreachable" and beyond.misses[0] == pytest.approx(10, abs=0.1)
    assert "not crossed" not in beyond.message and "wght is at its maximum" in beyond.message


def test_no_boundary_is_crossed_when_the_time_is_over() -> None:
    text = exchanged()
    handle = text.handle()
    x, y = text.position(handle).tolist()
    terms = [vf.Target(handle, (x + 240, y)), vf.StayClose()]
    found = vf.solve(text, terms, restart_seconds=0)
    assert found.text.glyphs[0].name == "a" and not found.boundaries
    assert found.status == "time_limit"


def test_a_solve_that_meets_too_many_boundaries_does_not_claim_that_a_goal_is_unreachable(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    text = exchanged()
    handle = text.handle()
    x, y = text.position(handle).tolist()
    target = vf.Target(handle, (x + 900, y))
    assert vf.solve(text, target, restarts=0).status == "unreachable"
    monkeypatch.setattr("vfwidget.energy.boundaries.MOST_CROSSINGS", 1)
    found = vf.solve(text, target, restarts=0)
    assert found.text.glyphs[0].name == "bowl"
    assert found.status == "iteration_limit" and "glyphs change" in found.message
    near = vf.solve(text, vf.Target(handle, (x + 240, y)), restarts=0)
    assert near.converged, "A goal that is met needs no further boundary."


def test_a_solve_without_time_for_a_boundary_does_not_claim_to_have_converged(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    text = vf.Text("recursive", "k" * 20, axes={"slnt": -14.5, "CRSV": 0.5}, shared=False)
    made = []

    def noted(energy: Energy, *given: Any) -> Energy:
        made.append(energy)
        return at(energy, *given)

    at = Energy.at
    monkeypatch.setattr(Energy, "at", noted)
    found = vf.solve(text, vf.AxisTarget({"slnt": -5}), restart_seconds=0)
    assert found.status == "time_limit" and not found.converged
    assert "every goal is met" not in found.message
    assert len(made) == 1, "After the end of the time no other boundary is looked at."
    assert vf.solve(text, vf.AxisTarget({"slnt": -5})).status == "converged"


def test_one_letter_of_several_crosses_a_boundary() -> None:
    text = exchanged("aa", shared=False)
    handle, other = text.handle(1), text.handle(0)
    x, y = text.position(handle).tolist()
    terms = [vf.Target(handle, (x + 240, y)), vf.Pin(other), vf.StayClose()]
    found = vf.solve(text, terms)
    assert [glyph.name for glyph in found.text.glyphs] == ["a", "bowl"]
    assert found.boundaries[0].letter == 1
    assert "at wght of letter 2 = 650: crossed" in found.report()


def test_a_side_that_cost_more_is_tried_again_after_another_letter_has_crossed() -> None:
    """The first letter follows the second one at a distance, and would be too far beyond alone."""
    text = exchanged("aa", shared=False)
    handles = [text.handle(i) for i in (0, 1)]
    (first, _), (second, y) = (text.position(handle).tolist() for handle in handles)
    follows = vf.Residual(lambda p: (p[1:, 0] - second) - (p[:1, 0] - first) + 10, handles)
    found = vf.solve(text, [vf.Target(handles[1], (second + 240, y)), follows], restarts=0)
    assert [glyph.name for glyph in found.text.glyphs] == ["bowl", "bowl"]
    assert found.status == "converged"
    assert [(met.letter, met.crossed) for met in found.boundaries] == [(1, True), (0, True)]


@pytest.mark.parametrize("text", [exchanged(), exchanged_twice()], ids=["next", "after next"])
def test_a_side_with_too_few_iterations_is_not_said_to_cost_more(text: vf.Text) -> None:
    handle = text.handle()
    start = float(text.position(handle)[0])

    def function(p: torch.Tensor) -> torch.Tensor:
        """20 units are missed below the boundary. Beyond, the way to zero takes many steps.

        In the narrow box no step changes the cost.
        """
        moved = (p[:, 0] - start).clamp(-300)
        return torch.where(moved < 120, 120 - moved, 40 * ((moved - 250) / 50) ** 3)

    term = vf.Residual(function, [handle])
    found = vf.solve(text, term, restarts=0, max_iterations=2)
    assert found.status == "iteration_limit" and not found.boundaries
    assert vf.solve(text, term, restarts=0).status == "converged"


@pytest.mark.parametrize("beyond", ["not a number", "an error"])
def test_a_term_without_a_value_beyond_a_boundary_stays_before_it(beyond: str) -> None:
    text = exchanged()
    handle = text.handle()
    start = float(text.position(handle)[0])

    class Bounded(vf.Term):
        handles = (handle,)

        def residual(self, points: torch.Tensor, theta: torch.Tensor) -> torch.Tensor:
            moved = points[:, 0] - start
            if moved > 120 and beyond == "an error":
                moved = moved[3:4] + points[5]
            return torch.sqrt(120 - moved)

    found = vf.solve(text, Bounded(), restarts=0)
    assert found.text.glyphs[0].name == "a" and found.status == "unreachable"
    assert found.misses[0] == pytest.approx(20**0.5, abs=0.01)


@pytest.mark.parametrize("ties", [[(0, 1)], [(1, 0)], [(2, 0), (1, 3)]])
def test_tied_letters_cross_a_boundary_together(ties: list[tuple[int, ...]]) -> None:
    text = exchanged("aaaa", shared=False)
    handle = text.handle(1)
    x, y = text.position(handle).tolist()
    found = vf.solve(text, [vf.Target(handle, (x + 240, y)), vf.StayClose()], ties=ties)
    (group,) = (set(group) for group in ties if 1 in group)
    names = [glyph.name for glyph in found.text.glyphs]
    assert names == ["bowl" if i in group else "a" for i in range(4)]
    assert found.status == "converged" and len(found.boundaries) == 1


@pytest.mark.parametrize("weights", [(0.2, 0.8), (0.8, 0.2)])
@pytest.mark.parametrize("locks", [(), ("wdth",)])
def test_tied_letters_may_start_on_two_sides_of_a_boundary(
    weights: tuple[float, float], locks: tuple[str, ...]
) -> None:
    text = exchanged("aa", shared=False).at(theta=[(w, w - 0.5) for w in weights])
    handle, other = text.handle(0), text.handle(1)
    x, y = text.position(handle).tolist()
    terms = [vf.Target(handle, (x + 5, y)), vf.StayClose()]
    found = vf.solve(text, terms, ties=[(0, 1)], locks=locks, restarts=0)
    assert found.status == "converged" and found.theta[0, 0] > weights[0]
    assert np.array_equal(found.theta[0], found.theta[1])
    if locks:
        assert found.theta[0, 1] == text.theta[0, 1]
    # A pin holds its point where it was in the text, and not where its group starts.
    pinned = vf.solve(text, vf.Pin(other), ties=[(0, 1)], restarts=0)
    goal = pinned.terms[0].term.position
    assert np.array_equal(goal, text.position(other))


def test_every_letter_of_many_crosses_its_boundary_after_few_descents(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Each third letter stays, because the other side costs more; it is not tried again.

    Only the words of sides that are tried are made.
    """
    count = 24
    text = exchanged(count * "a", shared=False)
    handles = [text.handle(i) for i in range(count)]
    places = np.array([text.position(handle).tolist() for handle in handles])
    moves = np.where(np.arange(count) % 3, 240, 110)
    terms = [
        vf.Target(h, (x + move, y)) for h, (x, y), move in zip(handles, places, moves, strict=True)
    ]
    tried, words = [], []
    beyond, make = Energy.at, Word.__init__
    monkeypatch.setattr(Energy, "at", lambda *all: tried.append(all) or beyond(*all))
    monkeypatch.setattr(Word, "__init__", lambda *all: words.append(all) or make(*all))
    found = vf.solve(text, [*terms, vf.StayClose()], restarts=0)
    names = [glyph.name for glyph in found.text.glyphs]
    assert names == ["bowl" if i % 3 else "a" for i in range(count)]
    assert [met.crossed for met in found.boundaries] == [True] * 16 + [False] * 8
    assert len(words) <= len(tried) <= 2 * count
