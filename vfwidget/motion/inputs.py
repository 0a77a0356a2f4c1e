"""What callers pass to a simulation, checked."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..arrays import Array, to_array
from ..errors import AxisError, MotionError
from ..font import NamedInstance
from ..text import Text
from .animation import Animation
from .numbers import read_number

LEAST_MASS = 1e-12
"""The roots of smaller masses are lost to rounding."""
ONE_VECTOR = (Mapping, NamedInstance, str)
"""The types of axis values for one axis vector."""


def read_masses(value: Any, letters: int) -> Array:
    """A mass for each letter, (l,).

    Raises
    ------
    MotionError
        The shape is wrong, or a mass is not a finite number ≥ 1e-12.
    """
    masses = _numbers("mass", value, [(), (letters,)])
    if not (masses >= LEAST_MASS).all():
        raise MotionError(f"Every mass must be at least {LEAST_MASS:g}; received {value!r:.200}.")
    return np.broadcast_to(masses, (letters,)).copy()


def read_rates(name: str, value: Any, text: Text) -> Array:
    """A number for each axis of each axis vector, (p, n).

    Raises
    ------
    MotionError
        The shape is wrong, a tag is unknown, or a number is negative or not finite.
    """
    p, n = text.coordinates.shape
    if isinstance(value, Mapping):
        tags = [axis.tag for axis in text.font.axes]
        unknown = [tag for tag in value if tag not in tags]
        if unknown:
            raise MotionError(f"{name} has no axis {unknown[0]!r}; the font has {', '.join(tags)}.")
        missing = [tag for tag in tags if tag not in value]
        if missing:
            raise MotionError(f"{name} needs a number for every axis; {missing[0]!r} is missing.")
        value = [value[tag] for tag in tags]
    rates = _numbers(name, value, [(), (n,), (p, 1), (p, n)])
    if not (rates >= 0).all():
        raise MotionError(f"{name} must be at least 0; received {value!r}.")
    return np.broadcast_to(rates, (p, n)).copy()


def read_vectors(name: str, value: Any, letters: int, size: int = 2) -> Array:
    """A vector for each letter, (l, size), from one for all or one for each.

    Raises
    ------
    MotionError
        The shape is wrong, or a number is not finite.
    """
    vectors = _numbers(name, value, [(size,), (letters, size)])
    return np.broadcast_to(vectors, (letters, size)).copy()


def read_rest(value: Any, text: Text) -> Array:
    """The rest state of the axes, (p, n), in normalized coordinates.

    Raises
    ------
    MotionError
        It is neither a text with the same font and letters, nor axis values, nor coordinates.
    """
    if isinstance(value, Text):
        if value.coordinates.shape != text.coordinates.shape or value.font is not text.font:
            raise MotionError(
                "rest must be a text with the same font and the same number of axis vectors; "
                f"received {value!r}."
            )
        return value.coordinates
    try:
        if isinstance(value, ONE_VECTOR) or _is_list(value):
            return text.at(axes=value).coordinates
        return text.at(theta=value).coordinates
    except (AxisError, TypeError) as error:
        raise MotionError(f"rest is no state of the axes. {error}") from error


def read_impulses(value: Any, letters: int, rotations: bool) -> list[tuple[float, Array]]:
    """Changes of velocity (l, 3), each with its time, in the order of time.

    The third number of each letter is the change of its angular velocity. Callers may leave it out.

    Raises
    ------
    MotionError
        It is no sequence of pairs of a time ≥ 0 and a vector.
    """
    try:
        pairs = [(time, vector) for time, vector in value]
    except (TypeError, ValueError):
        raise MotionError(
            f"impulses must be a sequence of (seconds, change of velocity); received {value!r}."
        ) from None
    read = []
    for time, vector in pairs:
        start = read_number("The time of an impulse", time, 0.0, math.inf, False)
        size = 3 if rotations and np.shape(vector)[-1:] == (3,) else 2
        change = read_vectors("The change of velocity of an impulse", vector, letters, size)
        read.append((start, np.pad(change, ((0, 0), (0, 3 - size)))))
    return sorted(read, key=lambda pair: pair[0])


def over_time(value: Any) -> Any:
    """An animation as a function of the time; anything else as it is."""
    return value.at if isinstance(value, Animation) else value


def _is_list(value: Any) -> bool:
    """Whether a value holds axis values for each letter, and not coordinates."""
    return isinstance(value, list | tuple) and bool(value) and isinstance(value[0], ONE_VECTOR)


def _numbers(name: str, value: Any, shapes: list[tuple[int, ...]]) -> Array:
    try:
        numbers = to_array(value)
    except (TypeError, ValueError, RuntimeError):
        numbers = np.full((0,), np.nan)
    if numbers.shape not in shapes:
        allowed = " or ".join("a number" if not shape else f"{shape}" for shape in shapes)
        raise MotionError(f"{name} must be {allowed}; received {value!r:.200}.")
    if not np.isfinite(numbers).all():
        raise MotionError(f"{name} must be finite; received {value!r:.200}.")
    return numbers
