"""From an image to the axes: which instance of which font a picture of letters shows."""

from .api import match
from .result import Match

__all__ = ["Match", "match"]
