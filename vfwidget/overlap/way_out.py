"""A short straight way on which a shape leaves all others, also from deep inside."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arrays import Array
from .collisions import areas
from .overlaps import TOUCH
from .shape import Shape

DIRECTIONS = 24
"""Ways that are compared, 15° apart."""
FIRST, LONGER = 1.0, 1.15
"""The first distance that is looked at, in font units, and how many times as far the next one is.
Room that is narrower than these steps may be passed."""
CLOSE = 0.05
"""Font units: a way ends at most so far behind the others."""


def way_out(shape: Shape, others: Sequence[Shape]) -> Array:
    """The displacement (2,) of a shape after which it overlaps none of the others.

    There is one: at the end of the longest ways, the boxes of all shapes are apart.
    """
    others = [other for other in others if other.sizes]
    boxes = np.array([one.box for one in (shape, *others)])
    longest = np.sqrt(2.0) * float((boxes[:, 1].max(0) - boxes[:, 0].min(0)).max()) + 1.0
    angles = 2 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
    ways = np.stack([np.cos(angles), np.sin(angles)], 1)

    def clear(ways: Array) -> Array:
        """After which of some displacements (w, 2) the shape overlaps nothing, (w,)."""
        moved = [[Shape(shape.segments + way, shape.sizes)] for way in ways]
        return np.asarray(areas(moved, others, between_glyphs=False) <= TOUCH)

    near, far = 0.0, min(FIRST, longest)
    while not (free := clear(far * ways)).any() and far < longest:
        near, far = far, min(LONGER * far, longest)
    ways = ways[free] if free.any() else ways
    low, high = np.full(len(ways), near), np.full(len(ways), far)
    while (high - low).max() > CLOSE:
        middle = (low + high) / 2
        free = clear(middle[:, None] * ways)
        low, high = np.where(free, low, middle), np.where(free, middle, high)
    best = int(high.argmin())
    return np.asarray(high[best] * ways[best])
