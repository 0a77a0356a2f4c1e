"""The state of an editor, which undo brings back: a text and the marks on it."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from ..energy.handle_terms import Pin
from ..errors import AxisError, GlyphError, SolveError
from ..text import Handle, Text
from ..text.place import OFFSETS
from .constraints import place


@dataclass(frozen=True, eq=False)
class State:
    """The text of an editor, and what a person has pinned, locked and constrained.

    Attributes
    ----------
    text : Text
    pins : tuple of Handle
        Of this text.
    locks : tuple of str
        Tags of axes that drags leave as they are.
    constraints : tuple of dict
        As :mod:`.constraints` describes them.
    """

    text: Text
    pins: tuple[Handle, ...] = ()
    locks: tuple[str, ...] = ()
    constraints: tuple[dict[str, Any], ...] = ()

    def at(self, text: Text) -> State:
        """The same marks on another text; what has no meaning there is left out."""
        same_letters = text.font is self.text.font and text.string == self.text.string
        pins = [_taken_along(pin, text) for pin in self.pins] if same_letters else []
        tags = {axis.tag for axis in text.font.axes}
        locks = tuple(tag for tag in self.locks if tag in tags)
        carried = [self._carried(one, text) for one in self.constraints] if same_letters else []
        constraints = tuple(one for one in carried if one is not None)
        return State(text, tuple(pin for pin in pins if pin is not None), locks, constraints)

    def _carried(self, constraint: dict[str, Any], text: Text) -> dict[str, Any] | None:
        handles = [self.text.handle(*point) for point in constraint["handles"]]
        carried = [_taken_along(handle, text) for handle in handles]
        places = [place(handle) for handle in carried if handle is not None]
        return {**constraint, "handles": places} if len(places) == len(handles) else None

    def __eq__(self, other: object) -> bool:
        return isinstance(other, State) and self._key == other._key

    def __hash__(self) -> int:
        return hash(self._key)

    @property
    def _key(self) -> Any:
        text = self.text
        # In a flat part of a segment map, different user values have the same coordinates.
        sets = [text.axes] if text.shared else text.axes
        values = [[f"{value:.9g}" for value in axes.values()] for axes in sets]
        marks = json.dumps([self.pin_places, self.locks, self.constraints, values])
        theta = text.coordinates.tobytes()
        return text.font, text.string, text.shared, theta, marks, set_as(text)

    @property
    def pin_places(self) -> list[list[float]]:
        """The pins as the view writes them, ``[letter, contour, segment, t]`` each."""
        return [place(pin) for pin in self.pins]


def set_as(text: Text) -> Any:
    """How a text is set, apart from its font, its string and its axes; it can be compared."""
    composition = text.composition
    offsets = text.place[OFFSETS].tobytes()
    return composition.options, composition.line_height, text.tracking, offsets


def _taken_along(pin: Handle, text: Text) -> Handle | None:
    """The pin on a text with other glyphs, or on one whose letters got separate axes.

    None if the text, which may have other features, has no such point.
    """
    if text.owns(pin):
        return text.carry(pin)
    try:
        return text.handle(*place(pin))
    except GlyphError:
        return None


def checked_pins(pins: Any, text: Text) -> tuple[Handle, ...]:
    """Pins given as handles, as :class:`Pin` terms or as the view writes them.

    Raises
    ------
    SolveError
        They are not a list, or one of them is no point of the text.
    """
    if not isinstance(pins, list | tuple):
        raise SolveError(f"pins must be a list of handles; received {pins!r}.")
    handles = []
    for pin in pins:
        handle = pin.handle if isinstance(pin, Pin) else pin
        if isinstance(handle, list | tuple):
            if len(handle) != 4:
                raise SolveError(f"A pin is [letter, contour, segment, t]; received {handle!r}.")
            handle = text.handle(*handle)
        if not isinstance(handle, Handle) or not text.owns(handle):
            raise SolveError(f"{handle!r} is not a handle of this editor's text.")
        handles.append(text.carry(handle))
    return tuple(handles)


def checked_locks(locks: Any, text: Text) -> tuple[str, ...]:
    """Tags of axes to lock.

    Raises
    ------
    AxisError
        They are not a list of tags of the font's axes.
    """
    tags = [axis.tag for axis in text.font.axes]
    if isinstance(locks, str) or not isinstance(locks, Iterable):
        raise AxisError(f"locks must be a list of axis tags; received {locks!r}.")
    locks = tuple(locks)
    for tag in locks:
        if tag not in tags:
            raise AxisError(
                f"The font has no axis {tag!r:.100} to lock; its axes are {', '.join(tags)}."
            )
    return tuple(dict.fromkeys(locks))
