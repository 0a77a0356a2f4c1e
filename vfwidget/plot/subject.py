"""The subject of a figure: look up axes and glyphs, and rank delta sets by their effect."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from ..arrays import Array, BoolArray, to_array
from ..errors import AxisError, VFWidgetError
from ..font import Axis, Font, Glyph
from ..outline.variation import Regions
from ..solver.problem import is_count
from ..text import AxisValues, Text
from ..text.inputs import user_values
from .canvas import plain, showable

OFFSET = 1e-6
"""Distance, in normalized units, at which a function is evaluated on either side of a kink."""


def given(font: Font, axes: AxisValues | None) -> Mapping[str, Any]:
    """User values by tag; none if ``axes`` is omitted."""
    return {} if axes is None else user_values(font, axes)


def location(font: Font, axes: AxisValues | None) -> Array:
    """Convert user values to normalized coordinates (n,)."""
    return to_array(font.normalize(given(font, axes)))


def check_count(name: str, value: Any, least: int, most: int) -> None:
    """Check a number of things to draw.

    Raises
    ------
    VFWidgetError
        It is not a whole number of the range.
    """
    if not is_count(value) or not least <= value <= most:
        raise VFWidgetError(
            f"{name} must be a whole number from {least} to {most:,}; received {value!r:.200}."
        )


def axis_index(font: Font, tag: str) -> int:
    """Index of the first axis with this tag.

    Raises
    ------
    AxisError
        No axis has this tag.
    """
    tags = [axis.tag for axis in font.axes]
    if tag not in tags:
        raise AxisError(f"Unknown axis {tag!r}. This font has: {', '.join(tags)}.")
    return tags.index(tag)


def two_axes(font: Font, tag: str, tag2: str) -> tuple[int, int]:
    """Indices of the axes with these tags.

    Raises
    ------
    AxisError
        No axis has one of the tags, or the tags are equal.
    """
    if tag == tag2:
        raise AxisError(f"The two axes must differ; received {tag!r} twice.")
    return axis_index(font, tag), axis_index(font, tag2)


def axis_label(axis: Axis) -> str:
    """The tag of an axis, and its name if that is different and can be shown."""
    named = axis.name != axis.tag and showable(axis.name)
    return plain(f"{axis.tag} ({axis.name})" if named else axis.tag)


def title(font: Font, key: Any, glyph: Glyph, axes: AxisValues | None = None) -> str:
    """Title of a figure: the character or name of a glyph, its font and its axes."""
    character = isinstance(key, str) and len(key) == 1 and not key.isspace() and showable(key)
    name = f"“{plain(key)}”" if character else plain(glyph.name)
    return f"{name} in {plain(font.family_name)}{_where(font, given(font, axes))}"


def text_title(text: Text) -> str:
    """Title of a figure: a text, its font, and the axes that differ from the default."""
    name = f"“{plain(text.string)}” in {plain(text.font.family_name)}"
    theta = to_array(text.theta)
    if (theta != theta[:1]).any():
        return f"{name}, letters with separate axes"
    users = text.axes if text.shared else text.axes[0]
    moved = {
        axis.tag: users[axis.tag] for axis, w in zip(text.font.axes, theta[0], strict=True) if w
    }
    return name + _where(text.font, moved)


def _where(font: Font, axes: Mapping[str, Any]) -> str:
    """Format the user values of the given axes, clamped to their ranges."""
    values = [
        f"{axis.tag} {min(max(float(axes[axis.tag]), axis.minimum), axis.maximum):g}"
        for axis in font.axes
        if axis.tag in axes
    ]
    return f" at {plain(', '.join(values))}" if values else ""


def numbered(sets: Iterable[int], most: int = 4) -> str:
    """Format the numbers of delta sets; of many, only the first few."""
    numbers = [str(j) for j in sets]
    head = "set " if len(numbers) == 1 else "sets "
    if len(numbers) <= most:
        return head + ", ".join(numbers)
    return f"{head}{', '.join(numbers[: most - 1])} … ({len(numbers)} in all)"


def left_out(items: Sequence[str], why: str) -> str:
    """A line that lists the items that a figure omits; empty if there are none."""
    return f"Not shown, {why}: {', '.join(items)}." if items else ""


def supports(glyph: Glyph, axis: int) -> Regions:
    """The regions of the delta sets on one axis only; their scalars are φ along it."""
    return Regions(glyph.affine.support[:, [axis]])


def factors(glyph: Glyph, axis: int, values: Any) -> Array:
    """φ of every delta set at values (v,) of one axis, (v, m)."""
    return supports(glyph, axis).scalars(np.reshape(values, (-1, 1)))


def takes_part(glyph: Glyph) -> BoolArray:
    """Whether each delta set depends on each axis, (m, n): φ is 0 at the default of the axis."""
    n = glyph.affine.support.shape[1]
    return np.stack([factors(glyph, i, 0.0)[0] == 0 for i in range(n)], axis=1)


def strength(glyph: Glyph) -> Array:
    """Largest displacement of a control point by each delta set, (m,), in font units."""
    return lengths(glyph.affine.deltas, axis=1).max(0, initial=0)


def lengths(vectors: Array, axis: int = -1) -> Array:
    """Euclidean lengths along one dimension."""
    return np.linalg.norm(vectors, axis=axis)


def along(w: Array, axis: int, values: Array) -> Array:
    """Coordinates (v, n): copies of w in which one axis takes each of the values (v,)."""
    moved = np.repeat(w[None], len(values), 0)
    moved[:, axis] = values
    return moved


def reach(font: Font, axis: int) -> tuple[float, float]:
    """Range of an axis in normalized coordinates; −1 to 1 if the range is empty."""
    low, high = (float(bound[axis]) for bound in font.bounds)
    return (low, high) if low < high else (-1.0, 1.0)


def kinks(font: Font, glyph: Glyph, axis: int) -> Array:
    """Kinks of an axis, points at a small offset on both sides of each, and its ends."""
    low, high = reach(font, axis)
    points = supports(glyph, axis).breakpoints[0]
    around = np.concatenate([points - OFFSET, points, points + OFFSET, [low, high]])
    return np.unique(around[(around >= low) & (around <= high)])


def spaced(values: Iterable[float], least: float) -> list[float]:
    """Drop values that are closer than ``least`` to an earlier value, so that ticks have room."""
    kept: list[float] = []
    for value in values:
        if all(abs(value - other) >= least for other in kept):
            kept.append(value)
    return kept
