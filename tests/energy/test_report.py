"""The report of a solve names letters, blocks and goals as they are."""

from __future__ import annotations

import pytest

import vfwidget as vf


@pytest.fixture(scope="module")
def text() -> vf.Text:
    return vf.Text("dynapuff", "hello", shared=False)


def test_letters_with_one_name_are_counted(text: vf.Text) -> None:
    second = text.handle(glyph=3)
    x, y = text.position(second).tolist()
    found = vf.solve(text, [vf.Target(second, (x + 3000, y)), vf.StayClose()])
    assert "Target 2nd l is missed by" in found.message
    starts = [f"\n{name} wght " for name in ("h", "1st l", "2nd l", "l")]
    assert [found.report().count(start) for start in starts] == [1, 1, 1, 0]
    many = vf.Text("dynapuff", "l" * 23 + "e").word.distinct_names
    assert [many[i] for i in (0, 1, 2, 3, 10, 11, 12, 20, 21, 22, 23)] == [
        *("1st l", "2nd l", "3rd l", "4th l", "11th l", "12th l", "13th l"),
        *("21st l", "22nd l", "23rd l", "e"),
    ]


def test_a_value_next_to_zero_is_shown_as_zero() -> None:
    text = vf.Text("shantell-sans", "w", axes={"BNCE": 1e-8, "INFM": 0.5})
    report = vf.solve(text, vf.StayClose()).report()
    rows = {line.split()[0]: line.split()[1:3] for line in report.splitlines() if line}
    assert rows["BNCE"] == ["0", "0"] and rows["INFM"] == ["0.5", "0.5"]


def test_a_solve_of_positions_lists_no_axes(text: vf.Text) -> None:
    handle = text.handle(glyph=2)
    x, y = text.position(handle).tolist()
    terms = [vf.Target(handle, (x + 30, y))]
    moved = vf.solve(text, terms, free=["offsets"]).report()
    assert "moved by x" in moved and "wght" not in moved
    spaced = vf.solve(text, vf.Width(text.advance() + 100), free=["tracking"]).report()
    assert "tracking" in spaced and "wght" not in spaced
    assert "wght" in vf.solve(text, terms).report()


def test_preferences_are_no_goals_that_are_met(text: vf.Text) -> None:
    found = vf.solve(text, vf.AxisTarget({"wght": 600}))
    assert found.converged and "no term has a goal" in found.message
    met = vf.solve(text, [vf.Width(text.advance()), vf.StayClose()])
    assert met.message == "every goal is met"


def test_axes_of_several_letters_that_end_together_are_named_once() -> None:
    text = vf.Text("dynapuff", "hello", shared=False)
    for glyph, letters in ((4, "all letters"), (2, "letters 1, 2 and 3"), (0, "letter 1")):
        handle = text.handle(glyph=glyph)
        x, y = text.position(handle).tolist()
        found = vf.solve(text, [vf.Target(handle, (x + 5000, y)), vf.StayClose()])
        assert found.message.count(f"wdth of {letters} is at its maximum") == 1
        assert found.message.count("wdth") == 1
