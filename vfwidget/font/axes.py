"""Axes: user coordinates, normalized coordinates and the segment maps between (fvar, avar).

User coordinates are the numbers on a slider (``wght`` 100–900). Normalized coordinates run from
-1 (minimum) over 0 (default) to 1 (maximum); a segment map (``avar``) may bend that line
(OpenType, "fvar" and "avar" tables, "Coordinate scales and normalization").
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from fontTools.ttLib import TTFont

from ..arrays import Array, is_tensor
from ..errors import AxisError, FontError, warn_clamped

IDENTITY_MAP = ((-1.0, -1.0), (0.0, 0.0), (1.0, 1.0))


@dataclass(frozen=True)
class Axis:
    """One axis of a variable font (an ``fvar`` axis record with its ``avar`` segment map).

    Attributes
    ----------
    tag : str
        Four characters, such as ``"wght"``.
    name : str
        What the font calls it, such as ``"Weight"``; the tag where it has no name.
    minimum, default, maximum : float
        In user coordinates.
    hidden : bool
        Whether the font asks that users are not shown this axis.
    segment_map : tuple of (float, float)
        Pairs (from, to) in normalized coordinates, ascending: the ``avar`` map.
    """

    tag: str
    name: str
    minimum: float
    default: float
    maximum: float
    hidden: bool = False
    segment_map: tuple[tuple[float, float], ...] = IDENTITY_MAP

    def normalize(self, value: Any) -> Any:
        """User coordinate to normalized coordinate; outside the range it is clamped.

        A tensor gives a float64 tensor, differentiable with slope 0 outside the range; at a
        corner of the segment map with the slope to the right, as everywhere in this package.
        """
        users, normals = self._knots
        if not is_tensor(value):
            return float(np.interp(value, users, normals))
        if len(users) == 1:
            return value.double() * 0 + normals[0]
        value = value.double().clip(users[0], users[-1])
        right = int(np.searchsorted(users[1:-1], float(value.detach()), side="right")) + 1
        slope = (normals[right] - normals[right - 1]) / (users[right] - users[right - 1])
        return normals[right - 1] + slope * (value - users[right - 1])

    def denormalize(self, w: float) -> float:
        """Normalized coordinate to user coordinate.

        Where the segment map is flat, several user values share one w; the one nearest the
        default is given.
        """
        users, normals = self._knots
        if w == self.normalize(self.default):
            return self.default
        # Walking outwards from the default finds the nearest preimage on a flat stretch.
        at = int(np.flatnonzero(users == self.default)[0])
        if w > normals[at]:
            return _first_crossing(w, normals[at:], users[at:])
        return _first_crossing(-w, -normals[at::-1], users[at::-1])

    @cached_property
    def _knots(self) -> tuple[Array, Array]:
        """The whole map, user → normalized, as the corners of one piecewise linear function."""
        corners: dict[float, float] = {}
        for source, target in self.segment_map:
            side = self.minimum if source < 0 else self.maximum
            user = self.default + abs(source) * (side - self.default)
            if source == 0 or user != self.default:
                corners[user] = target
        users = np.array(sorted(corners))
        return users, np.array([corners[user] for user in users])


def _first_crossing(x: float, xs: Array, ys: Array) -> float:
    """Where the polyline through (xs, ys), xs rising or flat, first comes to x; else its end."""
    if x >= xs[-1]:
        return float(ys[np.searchsorted(xs, xs[-1])])
    right = int(np.searchsorted(xs, x))
    part = (x - xs[right - 1]) / (xs[right] - xs[right - 1])
    return float(ys[right - 1] + part * (ys[right] - ys[right - 1]))


@dataclass(frozen=True)
class NamedInstance:
    """A named point of the design space, such as "Bold" (an ``fvar`` instance record).

    Attributes
    ----------
    name : str
    axes : dict of str to float
        User coordinates of every axis.
    """

    name: str
    axes: dict[str, float]


def read_axes(font: TTFont) -> tuple[Axis, ...]:
    """The axes of ``fvar`` with the segment maps of ``avar`` version 1.

    Raises
    ------
    FontError
        The font has no axes, or an ``avar`` table of version 2.
    """
    if "fvar" not in font or not font["fvar"].axes:
        raise FontError(
            "This font is static: it has no variation axes (no fvar table). "
            "Load a variable font instead."
        )
    keys = axis_keys(font)
    _read_by_axis(font, keys)
    maps = {}
    if "avar" in font:
        if font["avar"].majorVersion != 1:
            raise FontError("This font's avar table is of version 2, which is not supported.")
        maps = font["avar"].segments
    axes = []
    for key, record in zip(keys, font["fvar"].axes, strict=True):
        if not isinstance(record.axisTag, str):
            raise FontError(f"An axis has the tag {record.axisTag!r}, which is not ASCII text.")
        if not record.minValue <= record.defaultValue <= record.maxValue:
            raise FontError(f"Axis {record.axisTag!r} has its default outside its range.")
        # Corners of a segment map may be left out at the ends and the middle.
        segments = dict(IDENTITY_MAP) | maps.get(key, {})
        axes.append(
            Axis(
                tag=record.axisTag,
                name=font["name"].getDebugName(record.axisNameID) or record.axisTag,
                minimum=record.minValue,
                default=record.defaultValue,
                maximum=record.maxValue,
                hidden=bool(record.flags & 0x0001),
                segment_map=tuple(sorted(segments.items())),
            )
        )
    return tuple(axes)


def axis_keys(font: TTFont) -> list[str]:
    """The axes' tags, those that repeat an earlier one made distinct.

    By these keys fontTools gives the regions of ``gvar`` once :func:`read_axes` has run.
    """
    tags = [record.axisTag for record in font["fvar"].axes]
    return [f"{tag}#{i}" if tag in tags[:i] else tag for i, tag in enumerate(tags)]


def _read_by_axis(font: TTFont, keys: list[str]) -> None:
    """Have fontTools read the tables that it keeps by tag while each axis has a tag of its own.

    Of two axes with one tag it would keep but the last axis's numbers.
    """
    records = font["fvar"].axes
    tags = [record.axisTag for record in records]
    try:
        for record, key in zip(records, keys, strict=True):
            record.axisTag = key
        for table in {"avar", "gvar"} & set(font.keys()):
            font[table]
    finally:
        for record, tag in zip(records, tags, strict=True):
            record.axisTag = tag


def read_instances(font: TTFont) -> tuple[NamedInstance, ...]:
    """The named instances of ``fvar``, in the font's order."""
    return tuple(
        NamedInstance(
            name=font["name"].getDebugName(record.subfamilyNameID) or f"Instance {number}",
            axes=dict(record.coordinates),
        )
        for number, record in enumerate(font["fvar"].instances, start=1)
    )


def normalize(axes: Sequence[Axis], values: Mapping[str, Any]) -> list[Any]:
    """User coordinates by tag to n normalized coordinates; missing tags mean default.

    Where two axes share a tag, the value goes to both, as in HarfBuzz.

    Raises
    ------
    AxisError
        An unknown tag, or a value that is not a finite number.

    Warns
    -----
    AxisWarning
        A value outside its axis's range, which is clamped.
    """
    if not isinstance(values, Mapping):
        raise AxisError(f"Axis values are a mapping of tag to number, not {values!r}.")
    tags = [axis.tag for axis in axes]
    for tag in values:
        if tag not in tags:
            raise AxisError(f"Unknown axis {tag!r}. This font has: {', '.join(tags)}.")
    return [axis.normalize(_checked(axis, values.get(axis.tag, axis.default))) for axis in axes]


def _checked(axis: Axis, value: Any) -> Any:
    try:
        number = float(value.detach() if is_tensor(value) else value)
    except (TypeError, ValueError, OverflowError, RuntimeError):
        # torch raises the last for a tensor of several numbers.
        number = math.nan
    if not math.isfinite(number):
        raise AxisError(f"Axis {axis.tag!r} needs a finite number, not {value!r}.")
    if not axis.minimum <= number <= axis.maximum:
        warn_clamped(
            f"{axis.tag}={number:g} lies outside {axis.minimum:g} … {axis.maximum:g} "
            "and was clamped."
        )
    return value if is_tensor(value) else number


def denormalize(axes: Sequence[Axis], w: Array) -> dict[str, float]:
    """Normalized coordinates (n,) to user coordinates by tag."""
    return {axis.tag: axis.denormalize(float(x)) for axis, x in zip(axes, w, strict=True)}


def bounds(axes: Sequence[Axis]) -> tuple[Array, Array]:
    """The least and greatest normalized coordinates that user coordinates can reach, each (n,)."""
    lower = np.array([axis.normalize(axis.minimum) for axis in axes])
    upper = np.array([axis.normalize(axis.maximum) for axis in axes])
    return lower, upper
