"""The shapes of a text with the paint of each, for every drawing of it."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from typing import Any

import numpy as np

from ..arrays import rotation_matrices, to_array
from ..errors import TextError
from ..font import Font
from ..outline.paint import Palette, Shape, joined
from ..outline.union import without_overlaps


def shapes(text: Any) -> list[Shape]:
    """What a text paints at its location, from back to front; letters of one colour are joined.

    Parameters
    ----------
    text : Text

    Returns
    -------
    list of Shape
        In font units, y up. A text without colour glyphs is one shape.
    """
    found = []
    letters = text.word.letters(text.coordinates)
    rotations = rotation_matrices(text.rotations)
    for (glyph, w), placed, rotation in zip(letters, text.layout, rotations, strict=True):
        origin = np.array([placed.x, placed.y])
        if not glyph.layers:
            outline = glyph.outline.value(w) @ rotation.T + origin
            found.append(Shape(glyph.contours.split(outline)))
        for layer in glyph.layers:
            outline = layer.glyph.outline.value(w) @ rotation.T + origin
            fill = layer.paint.at(w).placed(origin, rotation)
            found.append(Shape(layer.glyph.contours.split(outline), fill))
    return joined(found)


def as_drawn(text: Any) -> Any:
    """A text whose outlines are those that are visible: colour glyphs have those of their layers.

    It has the unknowns of the text, and stands at the same place. Without colour glyphs it is the
    text itself.
    """
    composition = text.composition.as_drawn
    if composition is text.composition:
        return text
    drawn = copy(text)
    drawn.composition, drawn.word = composition, composition.word_at(text.coordinates)
    return drawn


def without_crossings(shape: Shape) -> Shape:
    """The shape with contours that neither cross nor overlap."""
    contours = [to_array(contour) for contour in shape.contours]
    if not contours:
        return shape
    sizes = [len(contour) for contour in contours]
    return shape._replace(contours=without_overlaps(np.concatenate(contours), sizes))


def palette_of(font: Font, palette: int | Sequence[Any]) -> Palette:
    """A palette of the font by its index, or colours that are given.

    Raises
    ------
    TextError
        The font has no such palette, or a colour is not four numbers from 0 to 1.
    """
    if isinstance(palette, int):
        if not font.palettes and palette == 0:
            return ()
        if not 0 <= palette < len(font.palettes):
            raise TextError(
                f"palette={palette}: {font.family_name} has {len(font.palettes)} palettes, "
                "counted from 0."
            )
        return font.palettes[palette]
    try:
        colours = to_array(palette)
    except (TypeError, ValueError):
        colours = to_array([])
    if colours.ndim != 2 or colours.shape[1] != 4 or not ((colours >= 0) & (colours <= 1)).all():
        raise TextError(
            "palette must be the index of a palette or a list of colours, each red, green, blue "
            f"and alpha from 0 to 1; received {palette!r:.80}."
        )
    return [(r, g, b, a) for r, g, b, a in colours.tolist()]
