"""What a figure is about: axes and glyphs looked up, and the delta sets that matter most."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from ..arrays import Array, BoolArray, to_array
from ..errors import AxisError
from ..font import Axis, Font, Glyph
from ..outline.variation import Regions
from ..text import Text
from .canvas import plain, showable

HAIR = 1e-6
"""In normalized units: far enough from a kink to be beside it, too near to be seen."""


def place(font: Font, axes: Mapping[str, Any] | None) -> Array:
    """User values as normalized coordinates (n,)."""
    return to_array(font.normalize(axes if axes is not None else {}))


def axis_index(font: Font, tag: str) -> int:
    """Which axis has this tag; of two, the first.

    Raises
    ------
    AxisError
        None has.
    """
    tags = [axis.tag for axis in font.axes]
    if tag not in tags:
        raise AxisError(f"Unknown axis {tag!r}. This font has: {', '.join(tags)}.")
    return tags.index(tag)


def two_axes(font: Font, tag: str, tag2: str) -> tuple[int, int]:
    """Which two axes have these tags.

    Raises
    ------
    AxisError
        None has, or it is one tag twice.
    """
    if tag == tag2:
        raise AxisError(f"Two different axes are needed, not {tag!r} twice.")
    return axis_index(font, tag), axis_index(font, tag2)


def axis_label(axis: Axis) -> str:
    """The tag, and the axis's name where it says more."""
    named = axis.name != axis.tag and showable(axis.name)
    return plain(f"{axis.tag} ({axis.name})" if named else axis.tag)


def title(font: Font, key: Any, glyph: Glyph, axes: Mapping[str, Any] | None = None) -> str:
    """How a figure names a glyph, by its character where one was asked for, and its place."""
    character = isinstance(key, str) and len(key) == 1 and not key.isspace() and showable(key)
    name = f"“{plain(key)}”" if character else plain(glyph.name)
    return f"{name} in {plain(font.family_name)}{_where(font, axes or {})}"


def text_title(text: Text) -> str:
    """How a figure names a text, and its place, if its letters are at one, off the default."""
    name = f"“{plain(text.string)}” in {plain(text.font.family_name)}"
    theta = to_array(text.theta)
    if (theta != theta[:1]).any():
        return f"{name}, each letter by itself"
    users = text.axes if text.shared else text.axes[0]
    moved = {
        axis.tag: users[axis.tag] for axis, w in zip(text.font.axes, theta[0], strict=True) if w
    }
    return name + _where(text.font, moved)


def _where(font: Font, axes: Mapping[str, Any]) -> str:
    """User values of the axes that are given, as far as these reach."""
    values = [
        f"{axis.tag} {min(max(float(axes[axis.tag]), axis.minimum), axis.maximum):g}"
        for axis in font.axes
        if axis.tag in axes
    ]
    return f" at {plain(', '.join(values))}" if values else ""


def numbered(sets: Iterable[int], most: int = 4) -> str:
    """Delta sets by number, the first few of many."""
    numbers = [str(j) for j in sets]
    head = "set " if len(numbers) == 1 else "sets "
    if len(numbers) <= most:
        return head + ", ".join(numbers)
    return f"{head}{', '.join(numbers[: most - 1])} … ({len(numbers)} of them)"


def left_out(items: Sequence[str], why: str) -> str:
    """A line that says which items a figure leaves out; empty when none are."""
    return f"Not shown, {why}: {', '.join(items)}." if items else ""


def supports(glyph: Glyph, axis: int) -> Regions:
    """The delta sets' regions cut down to one axis: their scalars are φ along it."""
    return Regions(glyph.affine.support[:, [axis]])


def factors(glyph: Glyph, axis: int, values: Any) -> Array:
    """φ of every delta set at values (v,) of one axis, (v, m)."""
    return supports(glyph, axis).scalars(np.reshape(values, (-1, 1)))


def takes_part(glyph: Glyph) -> BoolArray:
    """Which axes each delta set depends on, (m, n): its φ is 0 at their default."""
    n = glyph.affine.support.shape[1]
    return np.stack([factors(glyph, i, 0.0)[0] == 0 for i in range(n)], axis=1)


def strength(glyph: Glyph) -> Array:
    """How far each delta set moves the control point it moves most, (m,), in font units."""
    return lengths(glyph.affine.deltas, axis=1).max(0, initial=0)


def lengths(vectors: Array, axis: int = -1) -> Array:
    """Euclidean lengths along one dimension."""
    return np.linalg.norm(vectors, axis=axis)


def along(w: Array, axis: int, values: Array) -> Array:
    """Coordinates (v, n): w with one axis at each of the values (v,)."""
    moved = np.repeat(w[None], len(values), 0)
    moved[:, axis] = values
    return moved


def reach(font: Font, axis: int) -> tuple[float, float]:
    """The normalized coordinates an axis reaches; all of them where it has no range to show."""
    low, high = (float(bound[axis]) for bound in font.bounds)
    return (low, high) if low < high else (-1.0, 1.0)


def kinks(font: Font, glyph: Glyph, axis: int) -> Array:
    """Where an axis has kinks, with a hair on both sides, and its ends: what polylines need."""
    low, high = reach(font, axis)
    points = supports(glyph, axis).breakpoints[0]
    around = np.concatenate([points - HAIR, points, points + HAIR, [low, high]])
    return np.unique(around[(around >= low) & (around <= high)])


def spaced(values: Iterable[float], least: float) -> list[float]:
    """Those values that lie at least so far from all kept before them: ticks with room."""
    kept: list[float] = []
    for value in values:
        if all(abs(value - other) >= least for other in kept):
            kept.append(value)
    return kept
