"""A shape that an SVG document draws, and the numbers in its attributes."""

from __future__ import annotations

import math
import re
from typing import NamedTuple

from ...arrays import Array
from ...errors import OverlapError

WIDE, HIGH = (
    frozenset({"x", "x1", "x2", "cx", "rx", "width"}),
    frozenset({"y", "y1", "y2", "cy", "ry", "height"}),
)
"""Attributes whose percentages are of the viewport's width, or of its height."""
FONT_SIZE = 16.0
"""The unit em, where no size of a font is stated."""
INCH = 96.0
UNITS = {
    **{"": 1.0, "px": 1.0, "in": INCH, "pt": INCH / 72, "pc": INCH / 6},
    **{"cm": INCH / 2.54, "mm": INCH / 25.4, "Q": INCH / 101.6},
}
"""Units of length, in pixels."""
BY_FONT = {"em": 1.0, "rem": 1.0, "ex": 0.5, "ch": 0.5}
"""Units of length, in sizes of a font."""
NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
LENGTH = re.compile(rf"({NUMBER})(%|[a-z]*)", re.IGNORECASE | re.ASCII)
WORD = re.compile(r"[a-z-]*", re.IGNORECASE)


class Drawn(NamedTuple):
    """A shape of the document.

    Attributes
    ----------
    tag : str
    attributes : dict
        The shape's own attributes; lengths are numbers in units of its coordinate system.
    style : dict
        Properties by name, with the inherited ones.
    matrix : (3, 2) array
        From (x, y, 1) in its coordinates to those of the document.
    clips : tuple of lists of Drawn
        Only what lies in each of these areas is visible.
    of_marker : bool
        Whether the shape belongs to a marker, which does not count for a bounding box.
    """

    tag: str
    attributes: dict[str, str]
    style: dict[str, str]
    matrix: Array
    clips: tuple[list[Drawn], ...]
    of_marker: bool = False


def number(value: str | None, default: float) -> float:
    """A finite number, or a percentage as a part of 1; otherwise the default."""
    try:
        text = (value or "").strip()
        number = float(text.removesuffix("%")) / (100 if text.endswith("%") else 1)
    except ValueError:
        return default
    return number if math.isfinite(number) else default


def length(
    name: str,
    value: str,
    whole: tuple[float, float],
    font: tuple[float, float] = (FONT_SIZE, FONT_SIZE),
) -> float | None:
    """A length in units of the coordinate system; None for a word such as ``auto``.

    Percentages are of a viewport with the size ``whole``. The sizes of the fonts of the element
    and of the document are the units em and rem.
    """
    value = value.strip()
    found = LENGTH.fullmatch(value)
    if not found:
        if WORD.fullmatch(value):
            return None
        raise OverlapError(_unread(name, value))
    size, unit = float(found[1]), "Q" if found[2] in "qQ" and found[2] else found[2].lower()
    if unit in BY_FONT:
        return size * BY_FONT[unit] * font[unit == "rem"]
    if unit in UNITS:
        return size * UNITS[unit]
    if unit != "%":
        raise OverlapError(_unread(name, value))
    width, height = whole
    if name in WIDE:
        return size / 100 * width
    return size / 100 * (height if name in HIGH else math.hypot(width, height) / 2**0.5)


def _unread(name: str, value: str) -> str:
    return (
        f"The length {name}={value!r:.80} of the SVG cannot be read; give a number with one of the "
        f"units {', '.join([*filter(None, UNITS), *BY_FONT])} and %."
    )
