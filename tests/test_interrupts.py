"""An interrupt, such as Ctrl+C or a kernel's stop button, leaves every state whole."""

from __future__ import annotations

import itertools
import linecache
import signal
import sys
import warnings
from collections.abc import Callable, Iterator
from functools import partial
from time import process_time
from types import FrameType
from typing import Any

import numpy as np
import pytest

import vfwidget as vf
from vfwidget.view.constraints import place

FEW, MANY = 12, 75
"""Interrupts of each kind in the plain run, and in the slow one."""

pytestmark = [
    pytest.mark.skipif(sys.platform == "win32", reason="needs an interval timer"),
    # Python prints an interrupt that arrives in a finalizer or in a callback of the garbage
    # collector, such as those of hypothesis, and goes on.
    pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning"),
]


def interrupt_after(seconds: float, action: Callable[[], object]) -> None:
    """Raise KeyboardInterrupt in an action after some processor time, unless it ended before."""
    armed = True

    def interrupt(*_: object) -> None:
        # A signal that another thread received may be handled long after the timer is off.
        if armed:
            raise KeyboardInterrupt

    # Timeouts of tests use the timer of elapsed time.
    before = signal.signal(signal.SIGVTALRM, interrupt)
    try:
        signal.setitimer(signal.ITIMER_VIRTUAL, seconds)
        action()
        armed = False
    except KeyboardInterrupt:
        armed = False
    signal.setitimer(signal.ITIMER_VIRTUAL, 0)
    signal.signal(signal.SIGVTALRM, before)


def interrupted(action: Callable[[int], object], count: int) -> Iterator[None]:
    """Interrupt an action at random times within its usual duration, and yield after each."""
    begin = process_time()
    for i in range(3):
        action(i)
    duration = (process_time() - begin) / 3
    for i, part in enumerate(np.random.default_rng(0).uniform(0.01, 1.05, count)):
        interrupt_after(part * duration, partial(action, i))
        yield


def assert_whole(editor: vf.Editor) -> None:
    assert editor.axes == editor.value == editor.text.axes == editor.history[-1].axes
    assert [place(pin) for pin in editor.pins] == editor._pins
    assert editor._steps == [len(editor._history.past), len(editor._history.future)]


counts = pytest.mark.parametrize("count", [FEW, pytest.param(MANY, marks=pytest.mark.slow)])


@counts
def test_an_editor_stays_whole(count: int) -> None:
    editor = vf.Editor("recursive", "hand", axes={"wght": 600})
    top = editor.text.nearest(100, 700)
    x, y = editor.text.position(top).tolist()
    sent: list[dict[str, object]] = []
    editor.send = sent.append
    rng = np.random.default_rng(1)

    def drag(i: int) -> None:
        target = {"x": x + rng.uniform(-40, 60), "y": y}
        content = {"type": "drag", "view": "a", "seq": i, "phase": "move", "gesture": str(i)}
        editor._receive(editor, {**content, "handle": place(top), **target}, [])
        editor.pins = [top] if i % 2 else []
        editor.undo()

    for _ in interrupted(drag, count):
        assert_whole(editor)
        editor.axes = {"wght": 600}
        assert editor.text.axes["wght"] == 600
    assert all(answer["ok"] for answer in sent)
    assert len(sent) >= 3  # those of the calls that are not interrupted


@pytest.mark.parametrize("count", [4, pytest.param(MANY, marks=pytest.mark.slow)])
def test_a_solve_and_a_match_can_be_repeated(count: int) -> None:
    text = vf.Text("dynapuff", "Sa")
    top = text.nearest(100, 600)
    x, y = text.position(top).tolist()
    image = 1 - vf.rasterize(vf.Text("dynapuff", "a", axes={"wght": 600}), (48, 48))

    def solve(_: int = 0) -> vf.Solution:
        return vf.solve(text, [vf.Target(top, (x + 30, y + 10)), vf.StayClose()])

    def match(_: int = 0) -> vf.Match:
        return vf.match(image, "a", "dynapuff", progress=False)

    for action in (solve, match):
        expected = action().axes
        for _ in interrupted(action, count):
            pass
        assert action().axes == expected


@pytest.mark.parametrize("count", [3, pytest.param(MANY, marks=pytest.mark.slow)])
def test_a_simulation_ends_with_whole_frames_and_can_be_repeated(count: int) -> None:
    text = vf.Text("dynapuff", "Sa")
    floor = [(-500, -300), (1500, -300), (1500, -200), (-500, -200)]
    ended: list[vf.Animation] = []

    def simulate(_: int = 0) -> None:
        animation = vf.simulate(
            text, 4, positions=True, forces=(0, -4000), obstacles=[floor], progress=False
        )
        ended.append(animation)

    simulate()
    (expected,) = ended
    with warnings.catch_warnings():
        # The frames so far come with a warning.
        warnings.simplefilter("ignore", vf.MotionWarning)
        for _ in interrupted(simulate, count):
            last = ended[-1]
            frames = len(last)
            assert len(last.theta) == len(last.offsets) == frames <= len(expected)
            np.testing.assert_array_equal(last.theta, expected.theta[:frames])
            np.testing.assert_array_equal(last.positions, expected.positions[:frames])
    simulate()
    np.testing.assert_array_equal(ended[-1].theta, expected.theta)
    assert text.axes == vf.Text("dynapuff", "Sa").axes


def interrupt_at(step: int, action: Callable[[], object]) -> bool:
    """Raise KeyboardInterrupt before the given line that the editor's module runs in an action."""
    left = step

    def trace(frame: FrameType, event: str, _: object) -> Any:
        nonlocal left
        if not frame.f_code.co_filename.endswith("view/editor.py"):
            return trace if event == "call" else None
        # Python cannot guard the moments between a guard and what it guards.
        line = linecache.getline(frame.f_code.co_filename, frame.f_lineno).strip()
        left -= event == "line" and line not in ("try:", "self._show()")
        if left == 0:
            raise KeyboardInterrupt
        return trace

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        action()
    except KeyboardInterrupt:
        return True
    finally:
        sys.settrace(before)
    return False


def test_an_editor_stays_whole_wherever_it_is_interrupted() -> None:
    editor = vf.Editor("recursive", "hand", axes={"wght": 600})
    pin = editor.text.nearest(100, 700)

    def change() -> None:
        editor.axes = {"wght": 310 + step}
        editor.pins = [pin]
        editor.undo()

    for step in itertools.count(1):
        stopped = interrupt_at(step, change)
        assert_whole(editor)
        editor.axes = {"wght": 600}
        editor.pins = []
        assert_whole(editor)
        if not stopped:
            break
    assert step > 20
