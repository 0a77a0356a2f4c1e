"""Checks of the options of a widget."""

from __future__ import annotations

import difflib
import inspect
from collections.abc import Callable, Collection, Mapping
from typing import Any

from ..errors import TextError, VFWidgetError
from ..text import Text

HEIGHTS = (80, 4000)
"""Pixels between which the height of the picture is useful."""


def text_to_show(font: Any, string: Any, axes: Any, shared: Any) -> Text:
    """The text of an editor, from a Text or from a font and a string.

    Raises
    ------
    TextError
        There is no string, a Text comes together with a string, axes or another value of shared,
        or letters are rotated.
    """
    if not isinstance(font, Text):
        if string is None:
            raise TextError('An Editor needs a text to show: vf.Editor(font, "NT").')
        return Text(font, string, axes=axes, shared=True if shared is None else shared)
    if string is not None or axes is not None:
        raise TextError(
            "Do not pass string or axes together with a Text, because a Text already contains both."
        )
    if shared is not None and shared is not font.shared:
        raise TextError(
            f"This Text has shared={font.shared}; received shared={shared!r:.80}. Leave it out, or "
            "pass text.at(shared=…)."
        )
    return upright(font)


def upright(text: Text) -> Text:
    """A text whose letters are not rotated.

    Raises
    ------
    TextError
        Some letters are rotated.
    """
    if text.rotations.any():
        raise TextError(
            f"An Editor shows upright letters, and this text has rotations {text.rotations}. "
            f"Pass text.at(rotations=[0] * {len(text.glyphs)})."
        )
    return text


def checked_height(height: Any) -> int | None:
    """A height in pixels, or None.

    Raises
    ------
    TextError
        It is not a number, or outside :data:`HEIGHTS`.
    """
    low, high = HEIGHTS
    if height is None:
        return None
    if not isinstance(height, int | float) or not low <= height <= high:
        raise TextError(f"height must be {low} to {high} pixels; received {height!r}.")
    return int(height)


def refuse_foreign(
    sync_data: Mapping[str, Any], allowed: Collection[str], error: type[VFWidgetError]
) -> None:
    """Refuse traits that a view must not set.

    Raises
    ------
    error
        There are some.
    """
    foreign = sync_data.keys() - {*allowed}
    if foreign:
        raise error(f"The view must not set {', '.join(map(str, foreign))}.")


def refuse_unknown(unknown: Collection[str], function: Callable[..., Any]) -> None:
    """Name keywords that a function does not have, and those that they resemble.

    Raises
    ------
    TypeError
        There are some.
    """
    parameters = inspect.signature(function).parameters.values()
    known = [p.name for p in parameters if p.kind in (p.POSITIONAL_OR_KEYWORD, p.KEYWORD_ONLY)]
    for name in unknown:
        close = difflib.get_close_matches(name, known, n=1)
        hint = f"did you mean {close[0]!r}?" if close else f"there are {', '.join(known[1:])}."
        widget = function.__qualname__.partition(".")[0]
        raise TypeError(f"{widget} has no option {name!r}; {hint}")
