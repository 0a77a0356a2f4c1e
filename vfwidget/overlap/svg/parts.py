"""A shape that an SVG document draws, and the numbers in its attributes."""

from __future__ import annotations

import math
import re
from typing import NamedTuple

from ...arrays import Array
from ...errors import OverlapError
from .maths import Measure, Unit, computed

WIDE, HIGH = (
    frozenset({"x", "x1", "x2", "cx", "rx", "width"}),
    frozenset({"y", "y1", "y2", "cy", "ry", "height"}),
)
"""Attributes whose percentages are of the viewport's width, or of its height."""
LENGTHS = WIDE | HIGH | {"r", "stroke-width", "stroke-dashoffset"}
"""Attributes that are lengths."""
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
OF_WINDOW = re.compile(r"[0-9.](?:[sld]?v|cq)(?:w|h|i|b|min|max)\b", re.IGNORECASE)
"""Units that depend on the window in which the document is shown."""
LONG = 1_000
"""Characters of a property that is read; it may be read again for each use of an element."""
SHAPING = frozenset({"d", "points", "transform"})
"""Attributes that may be longer."""


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


def lengths(side: float, font: tuple[float, float] = (FONT_SIZE, FONT_SIZE)) -> Unit:
    """What units of length are: percentages are of a side.

    The sizes of the fonts of the element and of the document are the units em and rem.
    """

    def unit(size: float, unit: str) -> Measure | None:
        small = unit.lower()
        if small in BY_FONT:
            return Measure(size * BY_FONT[small] * font[small == "rem"], "length")
        if small == "%":
            return Measure(size / 100 * side, "length")
        pixels = UNITS.get("Q" if small == "q" else small)
        return None if pixels is None else Measure(size * pixels, "length" if unit else "")

    return unit


def length(
    name: str,
    value: str,
    whole: tuple[float, float],
    font: tuple[float, float] = (FONT_SIZE, FONT_SIZE),
) -> float | None:
    """A length in units of the coordinate system; None if it is no length, such as ``auto``.

    Percentages are of a viewport with the size ``whole``. The sizes of the fonts of the element
    and of the document are the units em and rem.

    Raises
    ------
    OverlapError
        The length depends on the window in which the document is shown.
    """
    width, height = whole
    both = math.hypot(width, height) / 2**0.5
    found = computed(
        value, lengths(width if name in WIDE else height if name in HIGH else both, font)
    )
    if found is None and OF_WINDOW.search(value):
        raise OverlapError(
            f"The length {name}={value!r:.80} of the SVG depends on the window that shows it; give "
            f"a number with one of the units {', '.join([*filter(None, UNITS), *BY_FONT])} and %."
        )
    return found and found.size


def is_length(value: str) -> bool:
    """Whether a value is a length, or the word that leaves a length open."""
    known = value.lower() == "auto" or OF_WINDOW.search(value) is not None
    return known or length("", value, (1.0, 1.0)) is not None
