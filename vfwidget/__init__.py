"""Differentiable variable fonts, and a notebook widget to drag letters by their outline."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from .energy import (
    Area,
    AxisTarget,
    Collinear,
    Derivative,
    Distance,
    Pin,
    Residual,
    SharedX,
    SharedY,
    Solution,
    StayClose,
    Target,
    Term,
    Width,
    check_derivative,
    solve,
)
from .errors import (
    AxisError,
    AxisWarning,
    FontError,
    FontWarning,
    GlyphError,
    ImageError,
    MotionError,
    MotionWarning,
    OverlapError,
    OverlapWarning,
    SolveError,
    TextError,
    VFWidgetError,
)
from .font import Axis, Font, Glyph, NamedInstance, bundled_fonts, load_font
from .limits import limits
from .motion.animation import Animation
from .motion.simulate import simulate
from .overlap.artwork import Artwork
from .overlap.no_overlap import NoOverlap
from .overlap.overlaps import Overlap, overlaps
from .overlap.resolve import resolve_overlaps
from .solver import least_squares
from .text import Handle, Text

if TYPE_CHECKING:
    from . import plot
    from .matching import Looks, Match, match
    from .raster import rasterize
    from .view.editor import Editor
    from .view.player import Player

__version__ = "0.1.0"

LAZY = {
    "Editor": ".view.editor",
    "Looks": ".matching",
    "Match": ".matching",
    "Player": ".view.player",
    "match": ".matching",
    "rasterize": ".raster",
}
"""The modules of names that are loaded at their first use."""

__all__ = [
    "Animation",
    "Area",
    "Artwork",
    "Axis",
    "AxisError",
    "AxisTarget",
    "AxisWarning",
    "Collinear",
    "Derivative",
    "Distance",
    "Editor",
    "Font",
    "FontError",
    "FontWarning",
    "Glyph",
    "GlyphError",
    "Handle",
    "ImageError",
    "Looks",
    "Match",
    "MotionError",
    "MotionWarning",
    "NamedInstance",
    "NoOverlap",
    "Overlap",
    "OverlapError",
    "OverlapWarning",
    "Pin",
    "Player",
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
    "check_derivative",
    "least_squares",
    "limits",
    "load_font",
    "match",
    "overlaps",
    "plot",
    "rasterize",
    "resolve_overlaps",
    "simulate",
    "solve",
]


def __getattr__(name: str) -> Any:
    """Load what needs Jupyter, matplotlib or torch at its first use."""
    if name == "plot":
        return importlib.import_module(".plot", __name__)
    if name in LAZY:
        # Kept, so that this function is not called again.
        globals()[name] = getattr(importlib.import_module(LAZY[name], __name__), name)
        return globals()[name]
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    """The public names, whether they are loaded or not."""
    return sorted([*__all__, "__version__"])
