"""From an image to the axes: the instance of a font that a picture of letters shows."""

from .api import match
from .looks import Looks
from .result import Match

__all__ = ["Looks", "Match", "match"]
