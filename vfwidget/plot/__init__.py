"""Figures for teaching: the formulation of a variable font, drawn from the font's own numbers.

Every function takes ``ax``, a matplotlib Axes to draw in, makes a figure of its own without one,
and returns the Axes it drew in. Functions of several panels return an array of Axes; given one,
they put the panels in its place, which has to be of a grid, as ``plt.subplots`` makes it. Nothing
else of matplotlib's state is touched.

Delta sets are numbered from 0, as in ``font.glyph("a").deltas[..., 0]``. What a figure leaves out
to stay readable, it says beneath.
"""

from .axes import axis_effect, normalization
from .instances import gallery
from .scaling import delta_sets, scalars, support
from .shapes import jacobian, layout, outline

__all__ = [
    "axis_effect",
    "delta_sets",
    "gallery",
    "jacobian",
    "layout",
    "normalization",
    "outline",
    "scalars",
    "support",
]
