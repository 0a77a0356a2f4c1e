"""Numbers that callers pass, checked."""

from __future__ import annotations

import math
from typing import Any

from ..errors import MotionError
from ..solver.problem import is_count, is_number


def read_number(name: str, value: Any, least: float, most: float, open_below: bool) -> float:
    """A number of a range.

    Raises
    ------
    MotionError
        It is no finite number, or out of the range.
    """
    fits = is_number(value) and math.isfinite(value) and least <= value <= most
    if not fits or (open_below and value == least):
        sign = ">" if open_below else "≥"
        upper = "" if math.isinf(most) else f" and ≤ {most:g}"
        raise MotionError(
            f"{name} must be a finite number {sign} {least:g}{upper}; received {value!r}."
        )
    return float(value)


def read_count(name: str, value: Any) -> int:
    """A whole number ≥ 1.

    Raises
    ------
    MotionError
        It is none.
    """
    if not is_count(value) or value < 1:
        raise MotionError(f"{name} must be a whole number ≥ 1; received {value!r}.")
    return int(value)
