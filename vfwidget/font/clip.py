"""Clip boxes of colour glyphs: whether one cuts a part of its glyph off.

A clip box says how much of the page a glyph may paint. Fonts state boxes that hold the whole glyph,
so that a renderer can reserve an image of that size, and such a box changes nothing. Layers are
drawn whole here; a box that cuts them is named in a warning.

OpenType, "COLR" table, ClipList.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arrays import Array, to_tensor
from ..outline.cubics import x_extent
from ..outline.glyph import Layer
from ..outline.varying import Varying

SLACK = 1.0
"""How far, in font units, an outline may reach beyond a box: boxes have whole numbers."""


def cuts(corners: Varying, layers: Sequence[Layer]) -> bool:
    """Whether some layer reaches out of a clip box.

    The layers are compared at the default and at both ends of each axis.

    Parameters
    ----------
    corners : Varying
        Of shape (3, 2): where the lower left, the lower right and the upper left corner lie.
    layers : sequence of Layer
    """
    eye = np.eye(corners.axis_count)
    for w in [np.zeros(len(eye)), *eye, *-eye]:
        origin, right, top = corners.value(w)
        sides = np.stack([right - origin, top - origin])
        if any(_reaches_out(layer, w, origin, sides) for layer in layers):
            return True
    return False


def _reaches_out(layer: Layer, w: Array, origin: Array, sides: Array) -> bool:
    """Whether a layer leaves the parallelogram that two sides from ``origin`` span."""
    glyph = layer.glyph
    if not glyph.contours:
        return False
    if abs(np.linalg.det(sides)) < SLACK:
        return True
    # In units of the sides, between which the box reaches from 0 to 1.
    inverse = np.linalg.inv(sides)
    points = (glyph.outline.value(w) - origin) @ inverse
    slack = SLACK * np.linalg.norm(inverse, axis=0)
    if (points >= -slack).all() and (points <= 1 + slack).all():
        return False
    # Control points may lie outside although the curves do not.
    for i in range(2):
        contours = glyph.contours.split(to_tensor(points[:, [i, 1 - i]]))
        least, greatest = map(float, x_extent(contours))
        if least < -slack[i] or greatest > 1 + slack[i]:
            return True
    return False
