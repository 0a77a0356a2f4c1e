"""The editor's kernel side against a simulated front end: messages, state, errors, threads."""

from __future__ import annotations

import copy
import re
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from comm.base_comm import BaseComm
from hypothesis import given, settings
from hypothesis import strategies as st

import vfwidget as vf
from vfwidget.view import drag as widget_module


class FrontEnd(BaseComm):
    """Records what the kernel publishes, and speaks as a view does."""

    def __init__(self, **keywords: Any) -> None:
        self.sent: list[dict[str, Any]] = []
        super().__init__(**keywords)

    def publish_msg(self, msg_type: str, data: Any = None, **_: Any) -> None:
        if msg_type == "comm_msg":
            self.sent.append(data)

    def receive(self, **data: Any) -> None:
        self.handle_msg({"content": {"data": data}, "buffers": []})

    def custom(self, content: Any) -> None:
        self.receive(method="custom", content=content)

    def update(self, **state: Any) -> None:
        self.receive(method="update", state=state, buffer_paths=[])

    @property
    def replies(self) -> list[dict[str, Any]]:
        return [data["content"] for data in self.sent if data["method"] == "custom"]

    @property
    def state(self) -> dict[str, Any]:
        """The latest value the kernel sent of each trait."""
        updates = [data["state"] for data in self.sent if data["method"] == "update"]
        return {name: value for state in updates for name, value in state.items()}


@pytest.fixture
def editor(monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.setattr("comm.create_comm", FrontEnd)
    made = vf.Editor("roboto-flex", "no")
    assert isinstance(made.comm, FrontEnd)
    return made


def drag(editor: Any, handle: vf.Handle, x: float, y: float, **more: Any) -> dict[str, Any]:
    place = [handle.glyph, handle.contour, handle.segment, handle.t]
    message = {"type": "drag", "view": "v", "seq": 1, "phase": "move", "handle": place}
    editor.comm.custom(message | {"x": x, "y": y} | more)
    return editor.comm.replies[-1]


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


def test_out_of_reach_says_so(editor: Any) -> None:
    reply = drag(editor, editor.text.nearest(1500, 1080), -9000, 9000, phase="up")
    assert reply["ok"] and reply["status"] == "unreachable"
    assert "font units" in reply["message"]


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
@settings(max_examples=150, deadline=None)
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


def test_an_error_in_the_solve_is_the_answer(editor: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(*_: Any, **__: Any) -> None:
        raise RuntimeError("no luck")

    before = editor.axes
    with monkeypatch.context() as patch:
        patch.setattr(widget_module, "solve", fails)
        reply = drag(editor, editor.text.nearest(1500, 1080), 1500, 1090)
    assert reply == {
        "type": "drag", "view": "v", "seq": 1, "ok": False, "error": "RuntimeError: no luck",
    }  # fmt: skip
    assert editor.axes == before
    assert drag(editor, editor.text.nearest(1500, 1080), 1500, 1090)["ok"]


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


def test_changes_within_an_attribute_are_refused(editor: Any) -> None:
    changes = [
        lambda: editor.axes.update(wght=900),
        lambda: editor.value.pop("wght"),
        lambda: editor.pins.append(vf.Text("recursive", "x").nearest(0, 0)),
        lambda: editor.locks.extend(["wght"]),
        lambda: editor.constraints.clear(),
    ]
    for change in changes:
        with pytest.raises(vf.SolveError, match="Assign a new value"):
            change()
    copied = copy.deepcopy(editor.axes)
    copied["wght"] = 700
    editor.axes = copied
    assert editor.text.axes["wght"] == 700


def test_axes_from_python_are_checked_and_observers_hear_once(editor: Any) -> None:
    heard: list[Any] = []
    editor.observe(lambda change: heard.append(change["new"]), "axes")
    editor.axes = {"wght": 650}
    assert heard == [editor.axes]
    assert set(editor.axes) == {axis.tag for axis in editor.text.font.axes}
    before = editor.axes
    with pytest.raises(vf.AxisError, match="nope"):
        editor.axes = {"nope": 1}
    with pytest.raises(vf.AxisError, match="finite"):
        editor.axes = {"wght": float("inf")}
    assert editor.axes == before == editor.text.axes
    with pytest.warns(vf.AxisWarning):
        editor.axes = {"wght": 99999}
    assert editor.axes["wght"] == 1000
    drag(editor, editor.text.nearest(1500, 1080), 1500, 1000)
    assert heard[-1] == editor.axes


def test_text_from_python_shows_another_word(editor: Any) -> None:
    editor.pins = [editor.text.handle()]
    editor.text = vf.Text("dynapuff", "hi", axes={"wdth": 80})
    assert editor.axes == {"wght": 400, "wdth": pytest.approx(80)}
    assert editor.comm.state["_word"]["string"] == "hi"
    assert editor.pins == [] and editor.comm.state["_pins"] == []
    assert drag(editor, editor.text.handle(1), 400, 300)["ok"]


def test_moving_the_text_from_python_keeps_the_pins(editor: Any) -> None:
    pin = editor.text.nearest(150, 0)
    editor.pins = [pin]
    editor.text = editor.text.at(axes={"wght": 300})
    assert editor.pins == [pin]
    assert editor.axes["wght"] == pytest.approx(300)


def test_pins_go_both_ways_and_refuse_strangers(editor: Any) -> None:
    editor.comm.update(_pins=[[1, 0, 2, 0.25]])
    (pin,) = editor.pins
    assert (pin.glyph, pin.segment, pin.t) == (1, 2, 0.25)
    other = editor.text.nearest(150, 0)
    editor.pins = [*editor.pins, vf.Pin(other)]
    assert editor.pins == [pin, other]
    assert editor.comm.state["_pins"][1] == [other.glyph, other.contour, other.segment, other.t]
    with pytest.raises(vf.SolveError, match="not a handle"):
        editor.pins = [vf.Text("roboto-flex", "no").handle()]
    with pytest.raises(vf.SolveError):
        editor.pins = 3
    assert editor.pins == [pin, other]


def test_pins_hold_through_a_long_drag_and_do_not_creep(editor: Any) -> None:
    pin = editor.text.nearest(150, 0)
    editor.pins = [pin]
    held = editor.text.position(pin)
    handle = editor.text.nearest(1500, 1080)
    x, y = editor.text.position(handle).tolist()
    for i in range(40):
        drag(editor, handle, x + 300 * np.sin(i / 4), y + 400 * np.cos(i / 5), seq=i)
    assert float((editor.text.position(pin) - held).norm()) < 0.5


def test_a_pin_that_is_dragged_stays_where_it_was_left(editor: Any) -> None:
    pin = editor.text.nearest(1500, 1080)
    editor.pins = [pin]
    start = editor.text.position(pin)
    goal = editor.text.at(axes={"YTLC": 560}).position(pin).tolist()
    drag(editor, pin, *goal)
    moved = editor.text.position(pin)
    assert float((moved - start).norm()) > 10
    other = editor.text.nearest(400, 1100)
    x, y = editor.text.position(other).tolist()
    drag(editor, other, x + 20, y)
    assert float((editor.text.position(pin) - moved).norm()) < 0.5


def test_letters_apart_and_together_keep_axes_and_pins(editor: Any) -> None:
    editor.axes = {"wght": 300}
    editor.pins = [editor.text.nearest(150, 0)]
    editor.shared = False
    assert [axes["wght"] for axes in editor.axes] == pytest.approx([300, 300])
    assert editor.text.theta.shape == (2, 13)
    assert len(editor.pins) == 1 and editor.text.owns(editor.pins[0])
    editor.axes = [{"wght": 200}, {"wght": 900}]
    assert editor.text.axes[1]["wght"] == pytest.approx(900)
    # The view joins letters and says with whose axes in one message.
    editor.comm.update(shared=True, axes=editor.axes[1])
    assert editor.axes["wght"] == pytest.approx(900)
    assert editor.text.theta.shape == (1, 13)
    editor.comm.update(shared=False, axes=[editor.axes, editor.axes])
    assert len(editor.axes) == 2


def test_drags_on_many_threads_leave_one_whole_state(editor: Any) -> None:
    import torch

    handle = editor.text.nearest(1500, 1080)
    x, y = editor.text.position(handle).tolist()
    grad_modes: list[bool] = []

    def work(k: int) -> None:
        # A comm handler's thread starts with whatever grad mode torch gives it.
        with torch.no_grad():
            drag(editor, handle, x, y + k, seq=k)
            grad_modes.append(torch.is_grad_enabled())

    threads = [threading.Thread(target=work, args=(k,)) for k in range(12)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(reply["seq"] for reply in editor.comm.replies) == list(range(12))
    assert all(reply["ok"] for reply in editor.comm.replies)
    assert editor.axes == editor.text.axes
    assert not any(grad_modes)


def test_a_front_end_with_one_message_in_flight_settles_soon(
    editor: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    # The arithmetic of the protocol, with the view's rule played here: 120 moves, 60 ms solves.
    solves = 0
    works = widget_module.solve

    def slow(*arguments: Any, **options: Any) -> Any:
        nonlocal solves
        solves += 1
        time.sleep(0.06)
        return works(*arguments, **options)

    monkeypatch.setattr(widget_module, "solve", slow)
    handle = editor.text.nearest(1500, 1080)
    x, y = editor.text.position(handle).tolist()
    latest: dict[str, tuple[int, str]] = {}
    done = threading.Event()

    def view() -> None:
        while not (done.is_set() and not latest):
            if latest:
                _, (seq, phase) = latest.popitem()
                drag(editor, handle, x, y + seq / 4, seq=seq, phase=phase)
            time.sleep(0.001)

    sender = threading.Thread(target=view)
    sender.start()
    for seq in range(120):
        latest["drag"] = (seq, "move")
        time.sleep(0.002)
    latest["drag"] = (120, "up")
    done.set()
    sender.join()
    assert solves < 30
    assert editor.comm.replies[-1]["seq"] == 120
    assert editor.comm.replies[-1]["point"][1] == pytest.approx(y + 30, abs=1)


@pytest.mark.parametrize(
    ("arguments", "error"),
    [
        (("recursive",), vf.TextError),
        (("recursive", ""), vf.TextError),
        (("no-such-font", "a"), vf.FontError),
        (("recursive", "\u4eba"), vf.GlyphError),
        (("recursive", "a", {"nope": 1}), vf.AxisError),
        ((vf.Text("dynapuff", "a"), "b"), vf.TextError),
    ],
)
def test_a_bad_start_is_one_clear_error(arguments: Any, error: type[Exception]) -> None:
    with pytest.raises(error):
        vf.Editor(*arguments)


def test_a_misspelled_keyword_is_named_with_the_one_it_resembles() -> None:
    with pytest.raises(TypeError, match="no option 'axis'; did you mean 'axes'"):
        vf.Editor("recursive", "a", axis={"wght": 3})
    with pytest.raises(TypeError, match="no option 'zzz'; there are font, string"):
        vf.Editor("recursive", "a", zzz=1)


def test_each_assignment_and_each_gesture_of_the_view_is_one_step(editor: Any) -> None:
    start = editor.axes
    editor.axes = {"wght": 600}
    bold = editor.axes
    for weight in (610, 620, 630):
        editor.comm.update(axes=bold | {"wght": weight}, _gesture="slide")
    handle = editor.text.nearest(1500, 1080)
    x, y = editor.text.position(handle).tolist()
    for seq, phase in enumerate(["down", "move", "move", "up"]):
        drag(editor, handle, x, y + 10 * seq, seq=seq, phase=phase, gesture="g", axes=editor.axes)
    assert editor.comm.state["_steps"] == [3, 0]
    assert [text.axes["wght"] for text in editor.history[:3]] == pytest.approx([400, 600, 630])
    dragged = editor.axes
    assert editor.undo()
    assert editor.axes["wght"] == pytest.approx(630)
    editor.comm.custom({"type": "undo"})
    assert editor.axes == bold == editor.comm.state["axes"]
    assert editor.undo() and not editor.undo()
    assert editor.axes == start
    while editor.redo():
        pass
    assert editor.axes == dragged
    editor.restart()
    assert editor.axes == start
    assert editor.undo() and editor.axes == dragged


def test_undo_brings_back_pins_locks_letters_and_texts(editor: Any) -> None:
    editor.pins = [editor.text.nearest(150, 0)]
    editor.locks = ["wght"]
    editor.shared = False
    editor.text = vf.Text("dynapuff", "hi")
    assert (editor.pins, editor.locks) == ([], ["wght"])
    for pins, locks, shared, string in [
        (1, ["wght"], False, "no"),
        (1, ["wght"], True, "no"),
        (1, [], True, "no"),
        (0, [], True, "no"),
    ]:
        editor.undo()
        assert (len(editor.pins), editor.locks, editor.shared) == (pins, locks, shared)
        assert editor.text.string == editor.comm.state["_word"]["string"] == string
        assert all(editor.text.owns(pin) for pin in editor.pins)


def test_value_is_another_name_of_axes(editor: Any) -> None:
    heard: list[Any] = []
    editor.observe(lambda change: heard.append(change["new"]), "value")
    editor.value = {"wght": 650}
    drag(editor, editor.text.nearest(1500, 1080), 1500, 1000)
    assert heard[0]["wght"] == 650
    assert heard[-1] == editor.axes == editor.value


def test_an_editor_feeds_interactive_output(editor: Any) -> None:
    import ipywidgets

    seen: list[Any] = []
    ipywidgets.interactive_output(lambda axes: seen.append(axes), {"axes": editor})
    editor.axes = {"wght": 650}
    assert seen[-1] == editor.axes


@pytest.mark.parametrize(
    ("trait", "bad", "error", "words"),
    [
        ("locks", ["nope"], vf.AxisError, "no axis 'nope' to lock"),
        ("locks", "wght", vf.AxisError, "list of axis tags"),
        ("locks", 3, vf.AxisError, "list of axis tags"),
        ("height", 5, vf.TextError, "80 to 4000"),
        ("height", "tall", vf.TextError, "80 to 4000"),
        ("theme", "pink", Exception, "pink"),
    ],
)
def test_bad_options_are_refused_and_change_nothing(
    editor: Any, trait: str, bad: Any, error: type[Exception], words: str
) -> None:
    before = getattr(editor, trait)
    with pytest.raises(error, match=words):
        setattr(editor, trait, bad)
    assert getattr(editor, trait) == before
    with pytest.raises(error, match=words):
        vf.Editor("roboto-flex", "no", **{trait: bad})


def test_locked_axes_stay_in_a_drag(editor: Any) -> None:
    editor.axes = {"wght": 512}
    editor.locks = ["wght", "wdth"]
    reply = drag(editor, editor.text.nearest(1500, 1080), 1450, 1150, phase="up")
    assert (reply["axes"]["wght"], reply["axes"]["wdth"]) == (512, 100)
    assert reply["axes"] != editor.text.at(axes={"wght": 512}).axes


def test_the_path_of_a_drag_does_not_matter(editor: Any) -> None:
    handle = editor.text.nearest(1500, 1080)
    x, y = editor.text.position(handle).tolist()
    start = editor.text
    for seq in range(1, 31):
        phase = "up" if seq == 30 else "move"
        drag(editor, handle, x + 2 * seq, y + 3 * seq, seq=seq, phase=phase)
    pull = (0.001 * start.font.units_per_em) ** 2
    once = vf.solve(start, [vf.Target(handle, (x + 60, y + 90)), vf.StayClose(pull)]).axes
    for axis in start.font.axes:
        assert abs(editor.axes[axis.tag] - once[axis.tag]) < 0.01 * (axis.maximum - axis.minimum)


def test_the_saved_picture_follows_the_editor(monkeypatch: pytest.MonkeyPatch) -> None:
    from IPython.core.interactiveshell import InteractiveShell
    from IPython.testing.globalipapp import start_ipython

    shell = start_ipython() or InteractiveShell.instance()
    published: list[Any] = []
    monkeypatch.setattr(
        shell.display_pub, "publish", lambda data, **more: published.append((data, more))
    )
    made = vf.Editor("dynapuff", "hi")
    made._ipython_display_()
    (shown, _), (picture, more) = published
    assert "application/vnd.jupyter.widget-view+json" in shown
    path = re.compile(' d="(.*?)"')
    assert path.findall(picture["image/svg+xml"]) == path.findall(made.to_svg())
    assert "hi in DynaPuff" in picture["text/plain"]
    assert not more.get("update")
    made.axes = {"wght": 700}
    made._picture.update()
    later, more = published[-1]
    assert more["update"]
    assert path.findall(later["image/svg+xml"]) == path.findall(made.to_svg())
    assert later["image/svg+xml"] != picture["image/svg+xml"]
    count = len(published)
    made._picture.update()
    assert len(published) == count


def test_a_better_place_far_away_is_offered_and_not_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("comm.create_comm", FrontEnd)
    monkeypatch.setattr(widget_module, "RESTART_SECONDS", None)
    editor = vf.Editor("afacad-flux", "wavy")
    handle = editor.text.handle(2, 0, 8, 0.0)
    goal = (2535.0, 836.0)
    assert drag(editor, handle, *goal, phase="move")["elsewhere"] is None
    reply = drag(editor, handle, *goal, phase="up")
    assert reply["axes"] == editor.axes != reply["elsewhere"]
    target = np.array(goal)
    here, there = (
        np.linalg.norm(editor.text.at(axes=axes).position(handle).numpy() - target)
        for axes in (reply["axes"], reply["elsewhere"])
    )
    assert there < here


def test_constraints_are_terms_that_drags_keep(editor: Any) -> None:
    left, right = editor.text.nearest(150, 500), editor.text.nearest(330, 500)
    distance = vf.Distance(left, right)
    editor.constraints = [distance]
    (kept,) = editor.constraints
    assert kept["kind"] == "Distance" and len(kept["handles"]) == 2
    assert editor.comm.state["constraints"] == [kept]
    handle = editor.text.nearest(1500, 1080)
    x, y = editor.text.position(handle).tolist()
    drag(editor, handle, x + 80, y + 60, phase="up")
    first, second = (editor.text.position(editor.text.handle(*h)) for h in kept["handles"])
    assert float((second - first).norm()) == pytest.approx(kept["value"], abs=0.5)
    # The view reads and writes the same JSON.
    editor.comm.update(constraints=[kept, {"kind": "Width", "value": 2500.0}])
    assert editor.text.advance() == pytest.approx(2500, abs=0.5)
    assert editor.undo() and editor.constraints == [kept]


@pytest.mark.parametrize(
    ("bad", "words"),
    [
        (3, "must be a list"),
        ([3], "one of SharedX"),
        ([{"kind": "Glue"}], "one of SharedX"),
        ([{"kind": "SharedX", "handles": [[0, 0, 0, 0]]}], "2 to 1000 points"),
        ([{"kind": "Collinear", "handles": 3}], "3 to 1000 points"),
        ([{"kind": "Width", "value": float("nan")}], "length ≥ 0"),
        ([{"kind": "Width"}], "length ≥ 0"),
        ([{"kind": "SharedY", "handles": [[0, 0, 0, 0], [0, 0]]}], r"\[letter, contour"),
        ([{"kind": "SharedY", "handles": [[0, 0, 0, 0], [9, 0, 0, 0]]}], "9"),
    ],
)
def test_bad_constraints_are_one_clear_error(editor: Any, bad: Any, words: str) -> None:
    with pytest.raises(vf.VFWidgetError, match=words):
        editor.constraints = bad
    assert editor.constraints == []
    editor.comm.update(constraints=bad)
    assert editor.error and editor.constraints == []
    assert drag(editor, editor.text.nearest(1500, 1080), 1500, 1090)["ok"]


def test_constraints_on_letters_that_are_gone_are_left_out(editor: Any) -> None:
    editor.constraints = [vf.SharedY([editor.text.handle(0), editor.text.handle(1)])]
    editor.text = vf.Text("roboto-flex", "n")
    assert editor.constraints == []


def test_callbacks_hear_of_changes_and_of_releases(editor: Any) -> None:
    changes: list[Any] = []
    releases: list[Any] = []
    editor.on_change(lambda e: changes.append(e.axes))
    editor.on_release(lambda e: releases.append(e.axes))
    handle = editor.text.nearest(1500, 1080)
    x, y = editor.text.position(handle).tolist()
    for seq, phase in enumerate(["down", "move", "move", "up"]):
        drag(editor, handle, x, y + 10 * seq, seq=seq, phase=phase)
    editor.axes = {"wght": 300}
    assert len(changes) >= 3
    assert len(releases) == 1 and releases[0] == changes[-2]

    def fails(_: Any) -> None:
        raise RuntimeError("no luck")

    editor.on_release(fails)
    reply = drag(editor, handle, x, y, phase="up")
    assert reply["ok"] is False and "no luck" in reply["error"]
    assert drag(editor, handle, x, y)["ok"]


def test_the_word_is_saved_as_a_static_font(editor: Any, tmp_path: Path) -> None:
    editor.axes = {"wght": 700}
    editor.to_font(tmp_path / "word.ttf")
    saved = vf.Text(vf.load_font(tmp_path / "word.ttf", static=True), editor.text.string)
    assert saved.font.axes == ()
    assert saved.advance() == pytest.approx(editor.text.advance(), abs=len(saved.glyphs))


def test_a_drag_of_a_range_of_letters_keeps_them_equal(editor: Any) -> None:
    editor.text = vf.Text("roboto-flex", "noon", shared=False)
    handle = editor.text.nearest(1500, 1080)
    x, y = editor.text.position(handle).tolist()
    reply = drag(editor, handle, x, y + 40, range=[1, 2])
    assert reply["ok"]
    first, second, third, fourth = editor.axes
    assert second == third != first
    assert fourth == vf.Text("roboto-flex", "n").axes


@pytest.mark.parametrize("bad", [None, [1], [0, "x"], [0, 1, 2], 3, {}])
def test_a_malformed_range_is_refused(editor: Any, bad: Any) -> None:
    editor.shared = False
    before = editor.axes
    reply = drag(editor, editor.text.nearest(1500, 1080), 0, 0, range=bad)
    assert not reply["ok"] and "malformed" in reply["error"]
    assert editor.axes == before


def test_a_range_beyond_the_word_takes_its_letters(editor: Any) -> None:
    editor.shared = False
    handle = editor.text.nearest(1500, 1080)
    x, y = editor.text.position(handle).tolist()
    assert drag(editor, handle, x, y + 40, range=[0, 10**12])["ok"]
    assert editor.axes[0] == editor.axes[1]


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
