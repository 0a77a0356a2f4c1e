"""Differentiable variable fonts, and a notebook widget to drag letters by their outline."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from .energy.handle_terms import Collinear, Distance, Pin, SharedX, SharedY, Target
from .energy.solution import Solution, solve
from .energy.term import Term
from .energy.word_terms import Area, AxisTarget, Residual, StayClose, Width
from .errors import (
    AxisError,
    AxisWarning,
    FontError,
    FontWarning,
    GlyphError,
    ImageError,
    OverlapError,
    SolveError,
    TextError,
    VFWidgetError,
)
from .font import Axis, Font, Glyph, NamedInstance, bundled_fonts, load_font
from .limits import limits
from .overlap.artwork import Artwork
from .overlap.overlaps import Overlap, overlaps
from .solver import least_squares
from .text import Text
from .text.word import Handle

if TYPE_CHECKING:
    from . import plot
    from .matching import Match, match
    from .raster import rasterize
    from .view.editor import Editor

__version__ = "0.1.0"

LAZY = {
    "Editor": ".view.editor",
    "Match": ".matching",
    "match": ".matching",
    "rasterize": ".raster",
}
"""Where to find what is loaded only when it is asked for."""

__all__ = [
    "Area",
    "Artwork",
    "Axis",
    "AxisError",
    "AxisTarget",
    "AxisWarning",
    "Collinear",
    "Distance",
    "Editor",
    "Font",
    "FontError",
    "FontWarning",
    "Glyph",
    "GlyphError",
    "Handle",
    "ImageError",
    "Match",
    "NamedInstance",
    "Overlap",
    "OverlapError",
    "Pin",
    "Residual",
    "SharedX",
    "SharedY",
    "Solution",
    "SolveError",
    "StayClose",
    "Target",
    "Term",
    "Text",
    "TextError",
    "VFWidgetError",
    "Width",
    "bundled_fonts",
    "least_squares",
    "limits",
    "load_font",
    "match",
    "overlaps",
    "plot",
    "rasterize",
    "solve",
]


def __getattr__(name: str) -> Any:
    """Load what needs Jupyter, matplotlib or torch when it is asked for."""
    if name == "plot":
        return importlib.import_module(".plot", __name__)
    if name in LAZY:
        return getattr(importlib.import_module(LAZY[name], __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
