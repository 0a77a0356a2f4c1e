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
from . import names
from .avar import IDENTITY_MAP, SegmentMap, read_segment_maps
from .source import damage


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
    segment_map: SegmentMap = IDENTITY_MAP

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
        (users, normals), at = self._knots, self._at_default
        if w == normals[at]:
            return self.default
        # Walking outwards from the default finds the nearest preimage on a flat stretch.
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

    @cached_property
    def _at_default(self) -> int:
        """Which corner is the default."""
        return self._knots[0].tolist().index(self.default)


def _first_crossing(x: float, xs: Array, ys: Array) -> float:
    """The y at which the polyline through (xs, ys) first reaches x, or comes nearest to it."""
    for x0, x1, y0, y1 in zip(xs[:-1], xs[1:], ys[:-1], ys[1:], strict=True):
        if x0 < x <= x1:
            return float(y0 + (x - x0) / (x1 - x0) * (y1 - y0))
    return float(ys[xs.argmax()])


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


@damage("The fvar, avar or name table is damaged")
def read_axes(font: TTFont) -> tuple[Axis, ...]:
    """The axes of ``fvar`` with the segment maps of ``avar``; none for a static font.

    Raises
    ------
    FontError
        An axis has a tag that is not ASCII text, or its default lies outside its range.
    """
    records = font["fvar"].axes if "fvar" in font else []
    maps = read_segment_maps(font, [str(record.axisTag) for record in records])
    axes = []
    for record, segment_map in zip(records, maps, strict=True):
        if not isinstance(record.axisTag, str):
            raise FontError(f"An axis has the tag {record.axisTag!r}, which is not ASCII text.")
        if not record.minValue <= record.defaultValue <= record.maxValue:
            raise FontError(f"Axis {record.axisTag!r} has its default outside its range.")
        axes.append(
            Axis(
                tag=record.axisTag,
                name=names.string(font, record.axisNameID) or record.axisTag,
                minimum=record.minValue,
                default=record.defaultValue,
                maximum=record.maxValue,
                hidden=bool(record.flags & 0x0001),
                segment_map=segment_map,
            )
        )
    return tuple(axes)


@damage("The fvar or name table is damaged")
def read_instances(font: TTFont) -> tuple[NamedInstance, ...]:
    """The named instances of ``fvar``, in the font's order."""
    records = font["fvar"].instances if "fvar" in font else []
    return tuple(
        NamedInstance(
            name=names.string(font, record.subfamilyNameID) or f"Instance {number}",
            axes=dict(record.coordinates),
        )
        for number, record in enumerate(records, start=1)
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
        raise AxisError(f"Axis values must be a mapping of tag to number; received {values!r}.")
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
        raise AxisError(f"Axis {axis.tag!r} needs a finite number; received {value!r}.")
    if not axis.minimum <= number <= axis.maximum:
        warn_clamped(
            f"{axis.tag}={number:g} lies outside {axis.minimum:g} … {axis.maximum:g} "
            "and was clamped."
        )
    return value if is_tensor(value) else number


def denormalize(axes: Sequence[Axis], w: Array) -> dict[str, float]:
    """Normalized coordinates (n,) to user coordinates by tag."""
    return {axis.tag: axis.denormalize(float(x)) for axis, x in zip(axes, w, strict=True)}


def shown(values: Any) -> str:
    """Axis values in four digits on one line, as a ``repr`` shows them.

    ``values`` are a mapping, or a list of one mapping for each letter, of which two are shown.
    """
    if isinstance(values, Mapping):
        return "{" + ", ".join(f"{tag}: {value:.4g}" for tag, value in values.items()) + "}"
    return f"[{', '.join(map(shown, values[:2]))}{', …' if len(values) > 2 else ''}]"


def bounds(axes: Sequence[Axis]) -> tuple[Array, Array]:
    """The least and greatest normalized coordinates that user coordinates can reach, each (n,)."""
    reached = [axis._knots[1] for axis in axes]
    lower = np.array([normals.min() for normals in reached])
    upper = np.array([normals.max() for normals in reached])
    return lower, upper
