"""Shapes as polygons of shapely."""

from __future__ import annotations

from functools import reduce

import numpy as np
from shapely.geometry import Polygon

from vfwidget.outline.union import without_overlaps
from vfwidget.overlap.shape import Shape

T = np.linspace(0, 1, 60)[:-1]
WEIGHTS = np.stack([(1 - T) ** 3, 3 * (1 - T) ** 2 * T, 3 * (1 - T) * T**2, T**3], 1)


def simple(shape: Shape) -> Shape:
    """The shape without overlaps between its contours."""
    contours = without_overlaps(shape.segments, shape.sizes)
    return Shape(np.concatenate(contours), [len(contour) for contour in contours])


def filled(shape: Shape) -> Polygon:
    """A shape without overlaps as a fine polygon, holes included."""
    fine = [np.einsum("tk,skc->stc", WEIGHTS, contour) for contour in shape.contours]
    rings = [Polygon(points.reshape(-1, 2)) for points in fine]
    return reduce(Polygon.symmetric_difference, rings)
