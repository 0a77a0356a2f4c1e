"""Figures for teaching that show the formulation of a variable font.

Every function takes ``ax``, the matplotlib Axes to draw in, and returns the Axes that it drew in.
Without ``ax`` it makes a new figure. Functions with several panels return an array of Axes. If
they receive an Axes, they draw the panels in its place, and it must be part of a grid made by
``plt.subplots``. The functions change nothing else in the state of matplotlib.

Delta sets are numbered from 0, as in ``font.glyph("a").deltas[..., 0]``. If a figure omits
something to stay readable, a line below it says so.
"""

from .axes import axis_effect, normalization
from .instances import gallery
from .motion import frames
from .scaling import delta_sets, scalars, support
from .settings import settings
from .shapes import jacobian, layout, outline

__all__ = [
    "axis_effect",
    "delta_sets",
    "frames",
    "gallery",
    "jacobian",
    "layout",
    "normalization",
    "outline",
    "scalars",
    "settings",
    "support",
]
