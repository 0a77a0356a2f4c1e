"""The part of an editor that keeps letters apart from each other and from obstacles (Sec. 5.2)."""

from __future__ import annotations

from typing import Any

import traitlets

from ..energy.handle_terms import Pin
from ..energy.tied import Ties
from ..export.svg import path_data
from ..overlap.no_overlap import NoOverlap
from ..overlap.overlaps import overlaps
from ..overlap.resolve import resolve_overlaps
from ..overlap.shape import Shape, read_obstacles
from ..text import Text
from .constraints import terms
from .drag import ties_of
from .state import State, set_as

ROOM_SECONDS = 0.5
"""The search for the nearest free state ends after this time, so that the kernel stays ready."""
CROWDED = (
    "Letters overlap, and no axis values were found at which they do not. Unlock axes, remove pins "
    "or move the obstacles."
)


class KeepsApart(traitlets.HasTraits):
    """Traits of :class:`Editor`: obstacles, and whether drags avoid overlaps."""

    obstacles = traitlets.Any(())
    avoid_overlaps = traitlets.Bool(False).tag(sync=True, echo_update=False)
    _obstacles = traitlets.Unicode().tag(sync=True)

    _shapes: tuple[Shape, ...] = ()
    _crowded: State | None = None
    """The state from which no free one was found, until that is out of date."""
    _adopting: bool
    _history: Any
    _adopt: Any
    _moved: Any
    error: Any

    @property
    def _keep(self) -> NoOverlap | None:
        """What drags must not let overlap; None while they may."""
        return NoOverlap(self._shapes) if self.avoid_overlaps else None

    def _origin(self, content: dict[str, Any]) -> State:
        """The state from which a drag message is solved, which is where the view has predicted it.

        What the view predicts may overlap. With that to avoid, the kernel goes on from the state
        that it accepted last, and a drag begins at a state at which nothing overlaps.
        """
        state, keep, presses = self._history.present, self._keep, content.get("phase") == "down"
        if "axes" in content and (keep is None or presses):
            state = state.at(self._moved(content["axes"]))
        free = None
        if keep is not None and presses:
            free = room(state, keep, ties_of(content, state.text))
            self._crowded = state if free is None else None
        return state if free is None else state.at(free)

    def _complaint(self, state: State) -> str:
        """What the editor says of a new state: that its letters overlap, if they have to.

        A drag of crowded letters makes a new state at every event, in which they overlap still.
        """
        same = self.avoid_overlaps and self._was_crowded(state)
        if same and overlaps(state.text, self._shapes):
            return CROWDED
        self._crowded = None
        return ""

    def _relieved(self, state: State) -> State:
        """A new state in which letters that were crowded before give way, if there is room now."""
        keep = self._keep
        if keep is None or self._crowded is None or self._was_crowded(state):
            return state
        text = room(state, keep)
        self._crowded = state if text is None else None
        return state if text is None else state.at(text)

    def _was_crowded(self, state: State) -> bool:
        """Whether no free state was found with this word, its pins, locks and constraints."""
        crowded, text = self._crowded, state.text
        if crowded is None or text.composition is not crowded.text.composition:
            return False
        return set_as(text) == set_as(crowded.text) and crowded.at(text) == state

    @traitlets.validate("obstacles")
    def _check_obstacles(self, proposal: Any) -> Any:
        self._shapes = tuple(read_obstacles(proposal["value"]))
        return proposal["value"]

    @traitlets.observe("obstacles", "avoid_overlaps")
    def _on_obstacles(self, _: Any) -> None:
        contours = [contour for shape in self._shapes for contour in shape.contours]
        self._obstacles = path_data(contours)
        if self._adopting:
            return
        state, keep = self._history.present, self._keep
        text = None if keep is None else room(state, keep)
        self._crowded = state if keep is not None and text is None else None
        if text is not None:
            self._adopt(state.at(text))
        self.error = self._complaint(self._history.present)


def room(state: State, keep: NoOverlap, ties: Ties = ()) -> Text | None:
    """The nearest text at which nothing overlaps; None if none is found.

    Letters that are tied together stay equal. Otherwise a drag of them would set out from the axes
    of the first one, at which the others may overlap again.
    """
    pins = [Pin(pin, state.text.position(pin)) for pin in state.pins]
    solution = resolve_overlaps(
        state.text,
        keep.obstacles,
        terms=[*pins, *terms(state.constraints, state.text)],
        locks=state.locks,
        ties=ties,
        seconds=ROOM_SECONDS,
    )
    return solution.text if solution.free else None
