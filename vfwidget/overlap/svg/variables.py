"""Custom properties of style sheets, and values that refer to them by ``var()``."""

from __future__ import annotations

import re
from collections.abc import Mapping

from ...errors import OverlapError
from .maths import end_of_brackets, words
from .paint import accepted
from .parts import LONG, SHAPING

VAR = re.compile(r"(?<![\w-])var\(", re.IGNORECASE)
DEEPEST = 30
"""References within references that are followed."""
MOST = 100_000
"""References that are followed in one document; each is short."""


class Followed:
    """The references that have been followed in a document."""

    count = depth = 0

    def add(self) -> None:
        """Count one more.

        Raises
        ------
        OverlapError
            There are too many.
        """
        self.count += 1
        if self.count > MOST:
            raise OverlapError(
                f"The SVG refers to custom properties by more than {MOST:,} var(), counted for "
                "each element; simplify it."
            )


class Variables:
    """The custom properties of an element.

    Parameters
    ----------
    stated : mapping of str to str
        Those that the element states.
    around : Variables, optional
        Those of the element around it, which it inherits.
    followed : Followed, optional
        Counts the references; needed without ``around``.
    """

    def __init__(
        self,
        stated: Mapping[str, str],
        around: Variables | None = None,
        followed: Followed | None = None,
    ) -> None:
        self._stated, self._around = stated, around
        self._followed: Followed = followed or (around._followed if around else Followed())
        self._known: dict[str, str | None] = {}
        self._open: list[str] = []
        self._circular: set[str] = set()

    def within(self, own: Mapping[str, str]) -> Variables:
        """The custom properties of an element in this one, by all that it states."""
        stated = {name: value for name, value in own.items() if name.startswith("--")}
        return Variables(stated, self) if stated else self

    def replaced(self, value: str) -> str | None:
        """A value with its references replaced; None if it cannot be known."""
        if self._followed.depth > DEEPEST:
            return None
        self._followed.depth += 1
        try:
            return self._replaced(value)
        finally:
            self._followed.depth -= 1

    def _replaced(self, value: str) -> str | None:
        found, place = "", 0
        while reference := VAR.search(value, place):
            self._followed.add()
            end = end_of_brackets(value, reference.end())
            name, *other = words(value[reference.end() : end - 1], ",") if end else [""]
            if not name.startswith("--"):
                return None
            part = self._value(name)
            if part is None and other:
                part = self.replaced(",".join(other))
            if part is None:
                return None
            # What it stands for does not merge with the signs beside it.
            found += f"{value[place : reference.start()]} {part} "
            place = end
            if len(found) > LONG:
                return None
        found += value[place:]
        return found if len(found) <= LONG else None

    def _value(self, name: str) -> str | None:
        """The value of a custom property; None if it has none."""
        scope: Variables | None = self
        while scope is not None and name not in scope._stated:
            scope = scope._around
        return scope._stated_value(name) if scope is not None else None

    def _stated_value(self, name: str) -> str | None:
        if name in self._open:
            # Properties that refer to each other have no values, not even fallbacks.
            self._circular.update(self._open[self._open.index(name) :])
            return None
        if name not in self._known:
            self._open.append(name)
            stated = self._stated[name]
            value = None if stated.lower() == "initial" else self.replaced(stated)
            self._open.pop()
            self._known[name] = None if name in self._circular else value
        return self._known[name]


def replaced(stated: dict[str, str], variables: Variables) -> dict[str, str]:
    """Attributes and properties with the values of those that refer to custom properties.

    A property whose value turns out to be none is as if it were not stated.
    """
    referring = {
        name: value
        for name, value in stated.items()
        if name not in SHAPING and not name.startswith("--") and VAR.search(value)
    }
    if not referring:
        return stated
    found = {name: value for name, value in stated.items() if name not in referring}
    for name, value in referring.items():
        replaced = variables.replaced(value)
        taken = None if replaced is None else accepted(name, replaced.strip())
        if taken not in (None, "inherit"):
            found[name] = str(taken)
    return found
