"""A line of text over a font's design space, and points of its outline (Sec. 3, Eq. 3)."""

from .handle import Handle
from .text import AxisValues, Text

__all__ = ["AxisValues", "Handle", "Text"]
