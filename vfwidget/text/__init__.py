"""A line of text over a font's design space, and points of its outline (Sec. 3, Eq. 3)."""

from .handle import Handle
from .inputs import AxisValues
from .layout import PlacedGlyph
from .text import Text

__all__ = ["AxisValues", "Handle", "PlacedGlyph", "Text"]
