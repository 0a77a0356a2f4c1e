"""The warnings about what an SVG states and is not read."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping

from ...errors import OverlapWarning, warn_caller

REFERENCE = re.compile(r"""url\(\s*['"]?#([^'")]+)""")
IGNORED = {
    "mask": REFERENCE,
    "filter": re.compile(REFERENCE.pattern + r"|.*\("),
    "transform-box": re.compile(r"(?:stroke|border)-box"),
}
"""Properties that change what is seen, and are not read: which values of them do."""


class Told:
    """What is told about a document when all of it has been read, in the order of its elements."""

    def __init__(self) -> None:
        self._ignored: dict[str, None] = {}
        self._dropped: dict[str, None] = {}

    def look(self, element: str, own: Mapping[str, str]) -> None:
        """Note the properties of an element, given in words, that are not read."""
        self._ignored |= dict.fromkeys(
            f"the {name} of {element}"
            for name, form in IGNORED.items()
            if form.match(own.get(name, ""))
        )

    def drop(self, element: str, values: Iterable[str]) -> None:
        """Note values of an element that cannot be read."""
        self._dropped |= dict.fromkeys(f"{value} of {element}" for value in values)

    def tell(self, selectors: Iterable[str]) -> None:
        """Issue the warnings, with one about selectors that are not read."""
        if self._ignored:
            warn_caller(
                f"The SVG states what is not read and is ignored: {', '.join(self._ignored)}. "
                "Masks and filters have no outline. The shapes count as a whole, where they are "
                "without it.",
                OverlapWarning,
            )
        if dropped := list(self._dropped):
            warn_caller(
                "Lengths, transforms and clip paths of the SVG that cannot be read are ignored: "
                f"{', '.join(dropped[:3])}. State them as in width='3px' and "
                "transform='translate(3, 4)'.",
                OverlapWarning,
            )
        if unread := list(selectors):
            warn_caller(
                "Rules of style are ignored whose selectors are not read: "
                f"{', '.join(map(repr, unread[:3]))}; state them by types, classes, ids, "
                "attributes, and pseudo-classes such as :not() and :nth-child().",
                OverlapWarning,
            )
