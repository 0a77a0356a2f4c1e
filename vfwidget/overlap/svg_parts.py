"""A shape that an SVG document draws, and the numbers in its attributes."""

from __future__ import annotations

import math
from typing import NamedTuple

from ..arrays import Array


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
