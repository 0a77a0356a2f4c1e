"""The editor from Python: its attributes, options, history and callbacks."""

from __future__ import annotations

import copy
import re
from pathlib import Path
from typing import Any

import fonts
import pytest
from front_end import drag

import vfwidget as vf
from vfwidget.view.word import describe_word


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


def test_a_text_keeps_its_own_sharing_and_refuses_another() -> None:
    for shared in (True, False):
        text = vf.Text("dynapuff", "no", shared=shared)
        assert vf.Editor(text).shared is vf.Editor(text, shared=shared).shared is shared
        with pytest.raises(vf.TextError, match="shared"):
            vf.Editor(text, shared=not shared)
        assert vf.Editor(text.at(shared=not shared)).shared is not shared
    assert vf.Editor("dynapuff", "no").shared
    assert not vf.Editor("dynapuff", "no", shared=False).shared


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
        ([{"kind": "Width", "value": 1e300}], "at most 1e\\+12 font units"),
        ([{"kind": "Width", "value": 10**400}], "at most 1e\\+12 font units"),
        ([{"kind": "Width", "value": True}], "length ≥ 0"),
        ([{"kind": ["Width"]}], "A constraint is one of"),
        ([{"kind": {}}], "A constraint is one of"),
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


@pytest.mark.parametrize(
    ("bad", "words"),
    [
        (vf.Residual(lambda points: points), "one of SharedX"),
        (vf.SharedX(None), "2 to 1000 points; received None"),  # type: ignore[arg-type]
        (vf.SharedX(3), "2 to 1000 points; received 3"),  # type: ignore[arg-type]
        (vf.SharedX([1, 2]), r"\[letter, contour, segment, t\]; received 1"),  # type: ignore[list-item]
        (vf.Distance("a", "b"), r"\[letter, contour, segment, t\]; received 'a'"),  # type: ignore[arg-type]
        (vf.Distance("a", None, 60.0), r"received 'a'"),  # type: ignore[arg-type]
    ],
)
def test_bad_terms_as_constraints_are_one_clear_error(
    editor: Any, bad: vf.Term, words: str
) -> None:
    with pytest.raises(vf.VFWidgetError, match=words):
        editor.constraints = [bad]
    assert editor.constraints == []


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


@pytest.mark.parametrize(
    "change",
    [
        {"tracking": 120.0},
        {"offsets": [[0, 0], [0, 90]]},
        {"features": {"kern": False}},
        {"direction": "rtl"},
        {"line_height": 900.0},
    ],
    ids=str,
)
def test_a_text_that_is_set_in_another_way_is_shown(editor: Any, change: dict[str, Any]) -> None:
    editor.text = vf.Text(editor.text.font, "A\nV", shared=False)
    former, letters = editor.text, len(editor.text.glyphs)
    if "offsets" in change:
        change = {"offsets": [[10 * i, 90] for i in range(letters)]}
    wanted = vf.Text(former.font, "A\nV", shared=False, **change)
    before = describe_word(former)
    editor.text = wanted
    assert editor.text is wanted
    assert editor.get_state(["_word"])["_word"] == describe_word(wanted)
    assert editor.undo()
    assert editor.text is former
    assert editor.get_state(["_word"])["_word"] == before
    assert editor.redo()
    assert editor.text is wanted
    assert editor.get_state(["_word"])["_word"] == describe_word(wanted)


def test_marks_without_a_point_under_other_features_are_left_out(editor: Any) -> None:
    joined = vf.Text(editor.text.font, "fi")
    assert len(joined.glyphs) == 1
    editor.text = joined
    handles = [joined.handle(0, len(joined.glyphs[0].contours) - 1, 0), joined.handle(0, 0, 0)]
    editor.pins = handles
    editor.constraints = [vf.SharedX(handles)]
    editor.text = vf.Text(joined.font, "fi", features={"liga": False})
    assert len(editor.text.glyphs) == 2
    assert [(pin.glyph, pin.contour) for pin in editor.pins] == [(0, 0)]
    assert editor.constraints == []
    editor.undo()
    assert len(editor.pins) == 2 and len(editor.constraints) == 1


def test_rotated_letters_are_refused_later_too(editor: Any) -> None:
    former = editor.text
    with pytest.raises(vf.TextError, match="rotations"):
        editor.text = former.at(rotations=[0.1, 0])
    assert editor.text is former


def test_a_slider_in_a_flat_part_of_a_segment_map_is_heard(editor: Any) -> None:
    flat = [(-1.0, -1.0), (0.0, 0.0), (0.4, 0.5), (0.8, 0.5), (1.0, 1.0)]
    editor.text = vf.Text(vf.load_font(fonts.with_segment_map(flat)), "a", axes={"wght": 650})
    editor.comm.update(axes={"wght": 750.0}, _gesture="slider")
    assert editor.axes == {"wght": 750} == editor.text.axes


@pytest.mark.parametrize("bad", [[["wght"]], [{}], [5], "wght", None])
def test_locks_that_are_no_tags_are_one_clear_error(editor: Any, bad: Any) -> None:
    with pytest.raises(vf.AxisError, match="lock"):
        editor.locks = bad
    assert editor.locks == []
