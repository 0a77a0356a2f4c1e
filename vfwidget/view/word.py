"""The data that the view needs to evaluate the outlines of a word by itself."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..text.word import Word


def describe_word(word: Word) -> dict[str, Any]:
    """Describe a word so that the view can evaluate Eq. 1–3, with tensors as float32 buffers.

    The regions are those of the word. A glyph that occurs twice is sent once. The ``points`` of a
    glyph are its default outline (k, 2), followed by its delta sets, (k, 2) each.

    Parameters
    ----------
    word : Word

    Returns
    -------
    dict
        The value of the ``_word`` trait; ``js/README.md`` describes its entries.
    """
    glyphs: list[dict[str, Any]] = []
    index: dict[int, int] = {}
    for letter, glyph in enumerate(word.glyphs):
        if glyph.glyph_id in index:
            continue
        index[glyph.glyph_id] = len(glyphs)
        affine = glyph.affine
        layers = np.concatenate([affine.base[None], np.moveaxis(affine.deltas, -1, 0)])
        glyphs.append(
            {
                "name": glyph.name,
                "contours": list(glyph.contours),
                "points": layers.astype("<f4").tobytes(),
                "regions": word.outline_regions[letter].tolist(),
                "advance": {
                    "default": affine.advance_base,
                    "regions": word.advance_regions[letter].tolist(),
                    "deltas": affine.advance_deltas.tolist(),
                },
            }
        )
    font = word.font
    support = word.regions.support
    return {
        "family": font.family_name,
        "string": word.string,
        "units_per_em": font.units_per_em,
        "ascender": font.ascender,
        "descender": font.descender,
        "axes": [
            {
                "tag": axis.tag,
                "name": axis.name,
                "minimum": axis.minimum,
                "default": axis.default,
                "maximum": axis.maximum,
                "hidden": axis.hidden,
                "map": [list(pair) for pair in axis.segment_map],
            }
            for axis in font.axes
        ],
        "instances": [
            {"name": instance.name, "axes": dict(instance.axes)} for instance in font.instances
        ],
        "regions": {"count": len(support), "data": support.astype("<f4").tobytes()},
        "glyphs": glyphs,
        "order": [index[glyph.glyph_id] for glyph in word.glyphs],
        "offsets": word.fixed_offsets.tolist(),
    }
