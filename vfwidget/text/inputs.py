"""What callers pass to a text, checked: axis values, coordinates, offsets and lengths."""

from __future__ import annotations

import difflib
import sys
from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from ..arrays import Array, ArrayLike, to_array
from ..errors import AxisError, GlyphError, TextError, VFWidgetError
from ..font import Font, NamedInstance
from ..outline.coordinates import check_coordinates

if TYPE_CHECKING:
    import torch

AxisValues: TypeAlias = "Mapping[str, Any] | NamedInstance | str"
"""Axis values as callers give them: user values by tag, a named instance, or its name."""
MOST_NAMES = 8
"""Instances that an error message lists at most; some fonts have hundreds."""


def read_axes(
    font: Font, count: int, axes: AxisValues | Sequence[AxisValues] | None
) -> tuple[Array, list[dict[str, float]]]:
    """Θ, and the user values it came from, which normalizing and back would only round.

    Parameters
    ----------
    font : Font
    count : int
        The number of axis vectors.
    axes : axis values, or a sequence of them, optional
        Default: the defaults of the font.

    Raises
    ------
    AxisError
        The axis or instance is unknown, a value is NaN, or the number of entries is wrong.
    """
    axes = {} if axes is None else axes
    single = isinstance(axes, Mapping | NamedInstance | str)
    rows = [axes] * count if single else axes
    if not isinstance(rows, Sequence) or len(rows) != count:
        raise AxisError(
            f"Axis values must be one mapping or instance, or {count} of them for this text; "
            f"received {axes!r}."
        )
    mappings = [user_values(font, row) for row in rows]
    theta = np.stack([to_array(font.normalize(row)) for row in mappings])
    return theta, [_complete(font, row) for row in mappings]


def user_values(font: Font, row: Any) -> Mapping[str, Any]:
    """User values by tag, from a mapping, an instance or the name of an instance.

    Raises
    ------
    AxisError
        It is none of these, or the font has no such instance.
    """
    if isinstance(row, str):
        named = {instance.name: instance for instance in font.instances}
        if row not in named:
            raise AxisError(f"{font.family_name} has no instance {row!r}; {_offered(row, named)}.")
        row = named[row]
    if isinstance(row, NamedInstance):
        if row not in font.instances:
            raise AxisError(f"{row.name!r} is not an instance of {font.family_name}.")
        row = row.axes
    if not isinstance(row, Mapping):
        raise AxisError(f"Axis values must be a mapping of tag to number; received {row!r}.")
    return row


def _offered(name: str, names: Collection[str]) -> str:
    """The instances of a font in words; if there are many, only those with similar names."""
    if len(names) <= MOST_NAMES:
        return f"it has {', '.join(names) or 'none'}"
    alike = difflib.get_close_matches(name, names, MOST_NAMES, 0.0)
    return f"font.instances lists its {len(names)} instances, such as {', '.join(alike)}"


def _complete(font: Font, row: Mapping[str, Any]) -> dict[str, float]:
    values = {}
    for axis in font.axes:
        value = float(row.get(axis.tag, axis.default))
        values[axis.tag] = min(max(value, axis.minimum), axis.maximum)
    return values


def read_theta(theta: ArrayLike, shape: tuple[int, ...]) -> torch.Tensor:
    """Normalized coordinates as a float64 tensor of a shape, (1, n) or (l, n).

    Where the shape is (1, n), (n,) is accepted as well.

    Raises
    ------
    AxisError
        The shape is another one, or an entry is not finite.
    """
    count, n = shape
    checked = check_coordinates(theta, n)
    if checked.ndim == 1 and count == 1:
        checked = checked[None]
    if tuple(checked.shape[:-1]) != (count,):
        raise AxisError(f"theta has shape {tuple(checked.shape)}; this text needs ({count}, {n}).")
    return checked


def read_letters(name: str, values: ArrayLike | None, shape: tuple[int, ...]) -> Array:
    """Numbers for each letter, (l, 2) or (l,); None stands for zeros.

    Raises
    ------
    TextError
        The shape is another one, or a number is not finite.
    """
    if values is None:
        return np.zeros(shape)
    try:
        numbers = to_array(values).copy()
    except (TypeError, ValueError, RuntimeError):
        numbers = np.zeros(0)
    if numbers.shape != shape or not np.isfinite(numbers).all():
        raise TextError(
            f"{name} must be finite numbers of shape {shape}, one row for each letter; "
            f"received {values!r:.200}."
        )
    numbers.flags.writeable = False
    return numbers


def read_length(name: str, value: Any) -> float:
    """A length in font units.

    Raises
    ------
    TextError
        It is not a finite number.
    """
    # numpy would compare a short floating-point number with the greatest one of its own kind.
    value = value.item() if isinstance(value, np.generic) else value
    number = isinstance(value, int | float)
    # An integer of Python may be too large for a floating-point number.
    if not number or isinstance(value, bool) or not abs(value) <= sys.float_info.max:
        raise TextError(f"{name} must be a finite number of font units; received {value!r:.100}.")
    return float(value)


def read_flag(name: str, value: Any, error: type[VFWidgetError] = TextError) -> bool:
    """True or False.

    Raises
    ------
    TextError
        It is neither; or the error that is given.
    """
    if not isinstance(value, bool | np.bool_):
        raise error(f"{name} must be True or False; received {value!r:.200}.")
    return bool(value)


def read_point(x: float, y: float) -> Array:
    """A point, (2,).

    Raises
    ------
    GlyphError
        A coordinate is not a finite number.
    """
    try:
        point = np.array([float(x), float(y)])
    except (TypeError, ValueError, OverflowError, RuntimeError):
        point = np.array([np.nan, np.nan])
    if not np.isfinite(point).all():
        raise GlyphError(f"x and y must be finite numbers; received ({x}, {y}).")
    return point
