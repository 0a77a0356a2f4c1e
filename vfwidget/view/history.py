"""Undo and redo: the states that gestures have replaced, one step for each gesture."""

from __future__ import annotations

from typing import Generic, TypeVar

State = TypeVar("State")

LONGEST = 200
"""Steps that are kept. A state is a few hundred numbers, so this bounds the memory only roughly."""


class History(Generic[State]):
    """The past and the future of a state, which is immutable and can be compared.

    Parameters
    ----------
    start : State
        The first state. It is kept for :meth:`restart` when older steps are forgotten.

    Attributes
    ----------
    start, present : State
    past, future : list of State
        The nearest state is last.
    """

    def __init__(self, start: State) -> None:
        self.start = self.present = start
        self.past: list[State] = []
        self.future: list[State] = []
        self._gesture: str | None = None

    @property
    def states(self) -> list[State]:
        """All states up to the present, oldest first."""
        return [*self.past, self.present]

    def record(self, state: State, gesture: str | None = None) -> None:
        """Replace the present.

        Parameters
        ----------
        state : State
        gesture : str, optional
            Changes with the same name, one after the other, are one step. A gesture that ends
            where it began is none. By default each change is a step.
        """
        if state == self.present:
            return
        if gesture is None or gesture != self._gesture:
            self.past = [*self.past, self.present][-LONGEST:]
            self.future = []
        elif self.past[-1:] == [state]:
            self.past.pop()
            gesture = None
        self.present, self._gesture = state, gesture

    def undo(self) -> bool:
        """Go one step back; False if there is none."""
        return self._move(self.past, self.future)

    def redo(self) -> bool:
        """Go one step forward again; False if there is none."""
        return self._move(self.future, self.past)

    def restart(self) -> None:
        """Go to the first state, as one more step."""
        self.record(self.start)

    def _move(self, source: list[State], target: list[State]) -> bool:
        if not source:
            return False
        target.append(self.present)
        self.present, self._gesture = source.pop(), None
        return True
