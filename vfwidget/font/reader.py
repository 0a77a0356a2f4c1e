"""From the tables of a font file to one glyph."""

from __future__ import annotations

import numpy as np
from fontTools.ttLib import TTFont

from ..outline.glyph import Glyph
from .glyf import PHANTOMS, read_outline, to_cubics
from .metrics import read_advance


def read_glyph(font: TTFont, name: str) -> Glyph:
    """Unpack one glyph.

    Raises
    ------
    FontError
        The glyph's data are damaged.
    """
    raw = read_outline(font, name)
    layers, contours = to_cubics(raw)
    # Rasterisers put the left side bearing point at the origin, and so the outline's delta
    # sets carry that point's deltas too.
    layers = layers - raw.points[:, -PHANTOMS, None] * [1.0, 0.0]
    return Glyph(
        layers[0],
        np.moveaxis(layers[1:], 0, -1),
        raw.support,
        contours,
        read_advance(font, name, raw),
        name,
        font.getGlyphID(name),
    )
