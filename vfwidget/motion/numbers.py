"""Numbers that callers pass, checked."""

from __future__ import annotations

import math
import sys
from typing import Any

import numpy as np

from ..arrays import Array, to_array
from ..errors import MotionError
from ..solver.problem import is_count, is_number

MOST_FRAMES = 100_000
"""Frames of an animation: almost half an hour at 60 frames per second."""
LARGEST = 1e12
"""Seconds, font units and radians beyond this have no meaning."""


def read_number(name: str, value: Any, least: float, most: float, open_below: bool) -> float:
    """A number of a range.

    Raises
    ------
    MotionError
        It is no finite number, or out of the range.
    """
    # Comparisons hold for integers of any size, while math.isfinite raises an error.
    fits = is_number(value) and least <= value <= min(most, sys.float_info.max)
    if not fits or (open_below and value == least):
        lower = "" if math.isinf(least) else f" {'>' if open_below else '≥'} {least:g}"
        upper = "" if math.isinf(most) else f" and ≤ {most:g}"
        raise MotionError(f"{name} must be a finite number{lower}{upper}; received {value!r:.200}.")
    return float(value)


def read_count(name: str, value: Any) -> int:
    """A whole number from 1 to the most frames of an animation.

    Raises
    ------
    MotionError
        It is none.
    """
    if not is_count(value) or not 1 <= value <= MOST_FRAMES:
        raise MotionError(
            f"{name} must be a whole number from 1 to {MOST_FRAMES:,}; received {value!r:.200}."
        )
    return int(value)


def check_frames(count: float) -> None:
    """Check that an animation may have so many frames.

    Raises
    ------
    MotionError
        They are more than 100,000.
    """
    if not count <= MOST_FRAMES:
        raise MotionError(
            f"The animation would have {count:,.6g} frames; there may be {MOST_FRAMES:,}. Choose a "
            "smaller fps or a shorter duration."
        )


def read_array(
    name: str, values: Any, shape: tuple[int, ...] | None = None, most: float = LARGEST
) -> Array:
    """A read-only copy as a float64 array.

    Raises
    ------
    MotionError
        The shape is another one, or a number is not finite or enormous.
    """
    try:
        array = np.array(to_array(values))
    except (TypeError, ValueError, RuntimeError):
        array = np.full((), np.nan)
    if shape is not None and array.shape != shape:
        raise MotionError(f"{name} must be numbers of shape {shape}; received {array.shape}.")
    if not (np.isfinite(array).all() and (abs(array) <= most).all()):
        upper = "" if math.isinf(most) else f" of at most {most:g}"
        raise MotionError(f"{name} must be finite numbers{upper}; received {values!r:.200}.")
    array.flags.writeable = False
    return array


def read_scenery(scenery: Any, count: int) -> tuple[tuple[Array, ...], ...]:
    """The contours (s, 4, 2) of the obstacles of each frame.

    Raises
    ------
    MotionError
        There are not as many rows as frames, or a contour has another shape or is not finite.
    """
    try:
        rows = [tuple(row) for row in scenery]
    except TypeError:
        raise MotionError(
            f"scenery must hold a sequence of contours for each frame; received {scenery!r:.200}."
        ) from None
    if len(rows) != count:
        raise MotionError(
            f"scenery must hold the contours of each of the {count} frames; it has "
            f"{len(rows)} entries."
        )
    # Obstacles that stand still are the same arrays in every frame.
    contours = {id(contour): _contour(contour) for row in rows for contour in row}
    return tuple(tuple(contours[id(contour)] for contour in row) for row in rows)


def _contour(values: Any) -> Array:
    contour = read_array("Each contour of scenery", values)
    if contour.ndim != 3 or contour.shape[1:] != (4, 2) or not len(contour):
        raise MotionError(
            "Each contour of scenery must have shape (s, 4, 2) with s ≥ 1; received "
            f"{contour.shape}."
        )
    return contour
