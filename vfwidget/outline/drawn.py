"""The visible shape of a colour glyph: its layers in place of its outline."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arrays import Array, IntArray
from .contours import Contours
from .glyph import Glyph
from .placed import Joined, Reordered
from .varying import Affine, Varying, constant, one_after_another


def as_drawn(glyph: Glyph) -> Glyph:
    """A glyph whose outline holds the contours of all layers; the same one if it has no layers.

    Filled nonzero, it covers what any layer covers. For this, layers that wind the other way round
    than the first one at the default are reversed: a mirrored layer would cancel the others.
    """
    if not glyph.layers:
        return glyph
    parts = [layer.glyph for layer in glyph.layers if layer.glyph.contours]
    areas = [_signed_area(part) for part in parts]
    outlines = [
        _reversed(part) if area * areas[0] < 0 else part.outline
        for part, area in zip(parts, areas, strict=True)
    ]
    contours = [segments for part in parts for segments in part.contours]
    axes = glyph.outline.axis_count
    drawn = Glyph.of(_joined(outlines, axes), glyph.advance_width, contours, glyph.name)
    drawn.glyph_id, drawn.advance_height = glyph.glyph_id, glyph.advance_height
    return drawn


def _joined(outlines: Sequence[Varying], axis_count: int) -> Varying:
    """Outlines one after another; affine ones as one affine outline."""
    if not outlines:
        return constant(np.zeros((0, 2)), axis_count)
    affine = [outline for outline in outlines if isinstance(outline, Affine)]
    if len(affine) < len(outlines):
        return Joined(outlines)
    return one_after_another(affine)


def _reversed(glyph: Glyph) -> Varying:
    """The outline of a glyph with every contour the other way round."""
    order = _backwards(glyph.contours)
    outline = glyph.outline
    return outline.some(order) if isinstance(outline, Affine) else Reordered(outline, order)


def _backwards(contours: Contours) -> IntArray:
    """The control points of contours in reverse, each from its own start."""
    order, first = list[int](), 0
    for segments in contours:
        end = first + 3 * segments
        order += [first, *range(end - 1, first, -1)]
        first = end
    return np.array(order, dtype=np.intp)


def _signed_area(glyph: Glyph) -> float:
    """Twice the area that the control points enclose at the default, positive anticlockwise."""
    points: Array = glyph.outline.value(np.zeros(glyph.outline.axis_count))
    ends = 3 * np.cumsum(glyph.contours)
    following = np.arange(1, len(points) + 1)
    following[ends - 1] = [0, *ends[:-1]]
    x, y = points.T
    return float(x @ y[following] - y @ x[following])
