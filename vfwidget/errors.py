"""What a caller may catch: every error of the package is a :class:`VFWidgetError`."""

from __future__ import annotations

import sys
import warnings
from typing import Any

LONGEST_MESSAGE = 4000
"""Characters of a message; a hostile input that it quotes may have millions."""


class VFWidgetError(ValueError):
    """Base of every error this package raises on bad input.

    Parameters
    ----------
    message : str
        The middle of a message that is too long is left out.
    """

    def __init__(self, message: str = "") -> None:
        if len(message) > LONGEST_MESSAGE:
            half = LONGEST_MESSAGE // 2
            message = f"{message[:half]} … {message[-half:]}"
        super().__init__(message)


class FontError(VFWidgetError):
    """The source is not a variable font this package can read."""


class GlyphError(VFWidgetError):
    """The font has no such glyph, or the glyph no such contour, segment or parameter."""


class AxisError(VFWidgetError):
    """An unknown axis, or an axis value that is not a finite number."""


class TextError(VFWidgetError):
    """A text that cannot be laid out, such as an empty one."""


class SolveError(VFWidgetError):
    """A solve that cannot start or go on: NaN, wrong shapes, a foreign handle, bad bounds."""


class ImageError(VFWidgetError):
    """An image that cannot be read or drawn: no pixels, too many, NaN, no ink."""


class OverlapError(VFWidgetError):
    """Outlines that cannot be read or joined: no area, open, not finite, unsafe SVG, too dense."""


class MotionError(VFWidgetError):
    """An animation that cannot be made or go on: wrong shapes, bad time steps, an explosion.

    Attributes
    ----------
    animation : Animation or None
        The frames up to the error, if there are any.
    """

    animation: Any = None


class AxisWarning(UserWarning):
    """An axis value outside its range was clamped to it."""


class FontWarning(UserWarning):
    """A part of the font file is invalid or is left aside; the message says which."""


class OverlapWarning(UserWarning):
    """A part of an SVG that has no outline, such as a mask, was ignored."""


class MotionWarning(UserWarning):
    """A simulation that was interrupted, or whose letters overlapped at the start."""


def warn_clamped(message: str) -> None:
    """Issue an :class:`AxisWarning` at the line of code that called into this package."""
    warn_caller(message, AxisWarning)


def warn_caller(message: str, category: type[Warning]) -> None:
    """Issue a warning at the line of code that called into this package."""
    package = __name__.partition(".")[0]
    frame, level = sys._getframe(1), 2
    while frame.f_back and frame.f_globals.get("__name__", "").partition(".")[0] == package:
        frame, level = frame.f_back, level + 1
    warnings.warn(message, category, stacklevel=level)
