"""The steps of an editor: undo, redo and back to the start."""

from __future__ import annotations

from typing import Any

from ..text import Text
from .history import History
from .state import State


class Steps:
    """Methods of :class:`Editor` that move along its history."""

    _history: History[State]
    _lock: Any
    _show: Any

    @property
    def history(self) -> list[Text]:
        """The states up to the present one, oldest first; each is a Text."""
        return [state.text for state in self._history.states]

    def undo(self) -> bool:
        """Take back the last gesture or assignment.

        Returns
        -------
        bool
            False if there was nothing to undo.
        """
        return self._step(self._history.undo)

    def redo(self) -> bool:
        """Do again what was undone last.

        Returns
        -------
        bool
            False if there was nothing to redo.
        """
        return self._step(self._history.redo)

    def restart(self) -> None:
        """Go back to the state in which the editor began. This can be undone."""
        self._step(self._history.restart)

    def _step(self, move: Any) -> Any:
        with self._lock:
            try:
                return move()
            finally:
                self._show()
