"""Messages and state from a simulated front end: each is answered once, and none does harm."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from front_end import FrontEnd, drag
from hypothesis import given, settings
from hypothesis import strategies as st

import vfwidget as vf


def test_every_drag_is_answered_once_in_order_with_its_number(editor: Any) -> None:
    handle = editor.text.nearest(1500, 1080)
    x, y = editor.text.position(handle).tolist()
    for seq in range(1, 8):
        drag(editor, handle, x, y + 3 * seq, seq=seq, phase="move" if seq < 7 else "up")
    assert [reply["seq"] for reply in editor.comm.replies] == list(range(1, 8))
    assert all(reply["ok"] and reply["view"] == "v" for reply in editor.comm.replies)


def test_an_answer_holds_the_axes_that_the_traits_then_have(editor: Any) -> None:
    handle = editor.text.nearest(1500, 1080)
    goal = editor.text.at(axes={"YTLC": 560, "wght": 500}).position(handle).tolist()
    reply = drag(editor, handle, *goal)
    assert reply["status"] == "converged"
    assert reply["axes"] == editor.axes == editor.text.axes == editor.comm.state["axes"]
    assert reply["point"] == pytest.approx(goal, abs=0.1)


MALFORMED = [
    None,
    "drag",
    {},
    {"type": "resize"},
    {"type": "drag"},
    {"type": "drag", "seq": 3, "handle": [0, 0, 0, 0.5], "x": 1},
    {"type": "drag", "seq": 3, "handle": [9, 0, 0, 0.5], "x": 1, "y": 1},
    {"type": "drag", "seq": 3, "handle": [0, 0, 0, 7], "x": 1, "y": 1},
    {"type": "drag", "seq": 3, "handle": [0, 0, 0, None], "x": 1, "y": 1},
    {"type": "drag", "seq": 3, "handle": [0, 0], "x": "far", "y": 1},
    {"type": "drag", "seq": 3, "handle": [0, 0, 0, 0.5], "x": float("nan"), "y": 1},
    {"type": "drag", "seq": 3, "handle": 5, "x": 1, "y": 1},
    {"type": "drag", "seq": 3, "handle": [0.5, 0, 0, 0.5], "x": 1, "y": 1},
    {"type": "drag", "seq": 3, "handle": [0, 0, 0, 0.5], "x": [1, 2], "y": {}},
]


@pytest.mark.parametrize("content", MALFORMED)
def test_a_malformed_message_is_answered_and_changes_nothing(editor: Any, content: Any) -> None:
    before = editor.axes
    editor.comm.custom(content)
    (reply,) = editor.comm.replies
    assert reply["ok"] is False and reply["error"]
    assert reply["seq"] == (content.get("seq") if isinstance(content, dict) else None)
    assert editor.axes == before
    assert drag(editor, editor.text.nearest(1500, 1080), 1500, 1090)["ok"]


leaves = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5)
# A list or dictionary of leaves, or of such lists: st.recursive sometimes warns of its own use.
branches = st.lists(leaves, max_size=5) | st.dictionaries(st.text(max_size=5), leaves, max_size=5)
json_values = leaves | branches | st.lists(branches, max_size=2)


@given(
    st.fixed_dictionaries(
        {"type": st.just("drag"), "seq": json_values, "handle": json_values},
        optional={"x": json_values, "y": json_values, "phase": json_values},
    )
)
@settings(max_examples=150, deadline=None, derandomize=True)
def test_no_message_kills_the_widget(content: Any) -> None:
    editor = _SHARED()
    count = len(editor.comm.replies)
    editor.comm.custom(content)
    assert len(editor.comm.replies) == count + 1
    assert np.isfinite(editor.text.theta.numpy()).all()


_MADE: list[Any] = []


def _SHARED() -> Any:
    """One editor for all examples, as they are one long session."""
    if not _MADE:
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr("comm.create_comm", FrontEnd)
            _MADE.append(vf.Editor("dynapuff", "o"))
    return _MADE[0]


def test_sliders_of_the_view_move_the_text_without_echo(editor: Any) -> None:
    # Values that normalizing and back would round.
    axes = editor.axes | {"wght": 613, "XTRA": 337.7, "opsz": 91.3}
    editor.comm.update(axes=axes)
    assert editor.text.axes == axes
    assert "axes" not in editor.comm.state


@pytest.mark.parametrize(
    "state",
    [
        {"axes": {"nope": 3}},
        {"axes": {"wght": None}},
        {"axes": {"wght": float("nan")}},
        {"axes": 7},
        {"axes": [{}, {}]},
        {"axes": []},
        {"_pins": [[0, 0, 0]]},
        {"_pins": [[7, 0, 0, 0.5]]},
        {"_pins": [5]},
        {"_pins": "x"},
        {"shared": "maybe"},
        {"shared": False, "axes": [{}]},
    ],
)
def test_bad_state_from_the_view_is_shown_and_undone(editor: Any, state: Any) -> None:
    editor.axes = {"wght": 620}
    before, pins = editor.axes, editor.pins
    editor.comm.sent.clear()
    editor.comm.update(**state)
    assert editor.error
    assert editor.comm.state["error"] == editor.error
    assert editor.axes == before == editor.text.axes
    assert editor.comm.state["axes"] == before
    assert (editor.pins, editor.shared) == (pins, True)
    editor.comm.update(axes=before | {"wght": 500})
    assert editor.text.axes["wght"] == pytest.approx(500)
    assert editor.error == ""


@pytest.mark.parametrize("state", [{"_word": {}}, {"_esm": "alert(1)"}, {"height": "tall"}, [1]])
def test_the_view_changes_nothing_but_the_state(editor: Any, state: Any) -> None:
    before = editor.get_state()
    editor.set_state(state)
    assert editor.error
    assert editor.get_state() == before | {"error": editor.error}


@pytest.mark.parametrize("bad", [None, [1], [0, "x"], [0, 1, 2], 3, {}])
def test_a_malformed_range_is_refused(editor: Any, bad: Any) -> None:
    editor.shared = False
    before = editor.axes
    reply = drag(editor, editor.text.nearest(1500, 1080), 0, 0, range=bad)
    assert not reply["ok"] and "malformed" in reply["error"]
    assert editor.axes == before


def test_tools_and_teaching_mode_are_brought_on_request(editor: Any) -> None:
    editor.comm.custom({"type": "tools"})
    assert "export" in editor.comm.replies[-1]["script"]
    editor.comm.update(teaching=True)
    assert editor.teaching is True
    editor.comm.update(teaching="very")
    assert editor.teaching is True
    assert "teaching" in editor.error
    assert vf.Editor("roboto-flex", "no", teaching=True).teaching


def test_a_constraint_that_takes_the_place_of_pins_comes_in_one_message(editor: Any) -> None:
    feet = [editor.text.nearest(x, 0) for x in (200, 800)]
    places = [[h.glyph, h.contour, h.segment, h.t] for h in feet]
    editor.comm.update(_pins=places, _gesture="pins")
    constraint = {"kind": "SharedY", "handles": places}
    axes = {**editor.axes, "wght": 500.0}
    editor.comm.update(_pins=[], _gesture="one", constraints=[constraint], axes=axes)
    assert editor.error == ""
    assert editor.pins == []
    assert editor.constraints == [constraint]
    assert editor.axes["wght"] == pytest.approx(500, abs=1)
    assert len(editor.history) == 3
    editor.undo()
    assert len(editor.pins) == 2 and editor.constraints == []


def test_what_the_view_sets_is_not_sent_back_to_it(editor: Any) -> None:
    before = len(editor.comm.sent)
    editor.comm.update(axes={**editor.axes, "wght": 512.0}, _gesture="slider")
    sent = [key for data in editor.comm.sent[before:] for key in data.get("state", {})]
    assert "axes" not in sent
    assert editor.axes["wght"] == 512
