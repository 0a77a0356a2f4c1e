"""Drags that a simulated front end sends: pins, locks, constraints, ranges of letters, threads."""

from __future__ import annotations

import threading
import time
from typing import Any

import numpy as np
import pytest
from front_end import FrontEnd, drag

import vfwidget as vf
from vfwidget.view import drag as widget_module


def test_out_of_reach_says_so(editor: Any) -> None:
    reply = drag(editor, editor.text.nearest(1500, 1080), -9000, 9000, phase="up")
    assert reply["ok"] and reply["status"] == "unreachable"
    assert "font units" in reply["message"]


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


def test_drags_on_many_threads_leave_one_whole_state(editor: Any) -> None:
    import torch

    handle = editor.text.nearest(1500, 1080)
    x, y = editor.text.position(handle).tolist()
    grad_modes: list[bool] = []

    def work(k: int) -> None:
        # The thread of a comm handler may start in any grad mode of torch.
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


def test_a_drag_of_a_range_of_letters_keeps_them_equal(editor: Any) -> None:
    editor.text = vf.Text("roboto-flex", "noon", shared=False)
    handle = editor.text.nearest(1500, 1080)
    x, y = editor.text.position(handle).tolist()
    reply = drag(editor, handle, x, y + 40, range=[1, 2])
    assert reply["ok"]
    first, second, third, fourth = editor.axes
    assert second == third != first
    assert fourth == vf.Text("roboto-flex", "n").axes


def test_a_range_beyond_the_word_takes_its_letters(editor: Any) -> None:
    editor.shared = False
    handle = editor.text.nearest(1500, 1080)
    x, y = editor.text.position(handle).tolist()
    assert drag(editor, handle, x, y + 40, range=[0, 10**12])["ok"]
    assert editor.axes[0] == editor.axes[1]
