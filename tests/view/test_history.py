"""Undo and redo: one step for each gesture, checked against a plain list of states."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from vfwidget.view.history import LONGEST, History

actions = st.lists(
    st.sampled_from(["undo", "redo", "restart"]) | st.tuples(st.integers(0, 3), st.none()),
    max_size=40,
)


@given(actions)
def test_undo_and_redo_walk_a_list_of_states(actions: list[object]) -> None:
    history, states, at = History(0), [0], 0
    for action in actions:
        if action == "undo":
            assert history.undo() == (at > 0)
            at = max(0, at - 1)
        elif action == "redo":
            assert history.redo() == (at < len(states) - 1)
            at = min(len(states) - 1, at + 1)
        else:
            value = 0 if action == "restart" else action[0]  # type: ignore[index]
            history.restart() if action == "restart" else history.record(value)
            if value != states[at]:
                states, at = [*states[: at + 1], value], at + 1
        assert history.present == states[at]
        assert history.states == states[: at + 1]
        assert len(history.future) == len(states) - at - 1


def test_one_gesture_is_one_step_and_none_if_it_changes_nothing() -> None:
    history = History(0)
    for value in (1, 2, 3):
        history.record(value, "drag")
    history.record(4, "slide")
    assert history.past == [0, 3]
    history.record(5, "slide")
    history.record(3, "slide")
    assert (history.past, history.present) == ([0], 3)
    history.undo()
    history.record(7, "slide")
    assert (history.past, history.future) == ([0], [])


def test_old_steps_are_forgotten_but_not_the_start() -> None:
    history = History(-1)
    for value in range(2 * LONGEST):
        history.record(value)
    assert len(history.past) == LONGEST
    history.restart()
    assert history.present == -1
