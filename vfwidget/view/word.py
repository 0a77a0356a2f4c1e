"""The data that the view needs to draw a text at any axis values by itself."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..arrays import Array, IntArray
from ..font import Font
from ..outline.composed import Composed
from ..outline.glyph import Glyph, Layer
from ..outline.varying import Affine, Varying
from ..text import Text
from ..text.composition import Composition
from ..text.origins import Halves
from ..text.place import OFFSETS
from ..text.word import Word
from .varying import Node, Regions


def describe_word(text: Text) -> dict[str, Any]:
    """Describe a text so that the view can evaluate it, with tensors as float32 buffers.

    The result does not depend on where the text is in the design space. Regions and glyphs occur
    once, for all rows of glyphs that the text can have. The ``points`` of an affine glyph are its
    default outline (k, 2), followed by its delta sets, (k, 2) each; other glyphs have an
    ``outline``, see :class:`Regions`.

    Parameters
    ----------
    text : Text

    Returns
    -------
    dict
        The value of the ``_word`` trait; ``js/README.md`` describes its entries.
    """
    composition, font = text.composition, text.font
    words = uniform_words(composition)
    regions = Regions()
    glyphs = {glyph.glyph_id: glyph for word in words for glyph in word.glyphs}
    described = [_glyph(glyph, font, regions) for glyph in glyphs.values()]
    rows = [_row(word, np.array(regions.indices(word.regions.support))) for word in words]
    index = {glyph_id: i for i, glyph_id in enumerate(glyphs)}
    settings = composition.settings
    return {
        "family": font.family_name,
        "string": text.string,
        "units_per_em": font.units_per_em,
        "ascender": font.ascender,
        "descender": font.descender,
        "axes": _axes(font),
        "instances": [
            {"name": instance.name, "axes": dict(instance.axes)} for instance in font.instances
        ],
        "final": regions.node(font.displacement) if font.displacement else None,
        "glyphs": described,
        "rows": [
            {"order": [index[g] for g in word.glyph_ids], **row}
            for word, row in zip(words, rows, strict=True)
        ],
        "regions": regions.data(),
        "kinks": None if words[0].is_affine else [b.tolist() for b in words[0].breakpoints],
        "settings": {
            "edges": [edges.tolist() for edges in settings.edges],
            "cells": settings.cells.ravel().tolist(),
        },
        "tracking": text.tracking,
        "offsets": text.place[OFFSETS].tolist(),
    }


def uniform_words(composition: Composition) -> list[Word]:
    """The words of a composition whose letters are all taken from one row of glyphs."""
    count = 1 if composition.shared else composition.letter_count
    rows = composition.settings.rows
    usual = rows[0].clusters
    return [
        composition.word((i if composition.shared or row.clusters == usual else 0,) * count)
        for i, row in enumerate(rows)
    ]


def _glyph(glyph: Glyph, font: Font, regions: Regions) -> dict[str, Any]:
    outline, advance = (_over_final(v, font) for v in (glyph.outline, glyph.advance_width))
    assert isinstance(advance, Affine)
    kind, *parts = node = regions.node(outline)
    drawn = {"points": parts[0], "regions": parts[1]} if kind == "affine" else {"outline": node}
    return {
        "name": glyph.name,
        "contours": list(glyph.contours),
        **drawn,
        "advance": {
            "default": float(advance.base),
            "regions": regions.indices(advance.support),
            "deltas": advance.deltas.tolist(),
        },
        "layers": [_layer(layer, font, regions) for layer in glyph.layers],
    }


def _over_final(quantity: Varying, font: Font) -> Varying:
    """A quantity as a function of the coordinates after those that axes displace."""
    return quantity.outer if font.moves_axes and isinstance(quantity, Composed) else quantity


def _layer(layer: Layer, font: Font, regions: Regions) -> dict[str, Any]:
    def node(quantity: Varying) -> Node:
        return regions.node(_over_final(quantity, font))

    paint, palette = layer.paint, font.palettes[0] if font.palettes else ()
    colours = [
        palette[entry] if entry is not None and entry < len(palette) else None
        for entry in paint.entries
    ]
    return {
        "contours": list(layer.glyph.contours),
        "outline": node(layer.glyph.outline),
        "kind": paint.kind,
        "numbers": node(paint.numbers),
        "frame": node(paint.frame),
        "extend": paint.extend,
        "colours": [colour and [round(255 * c) for c in colour[:3]] for colour in colours],
        "alphas": [colour[3] if colour else 1 for colour in colours],
    }


def _row(word: Word, regions: IntArray) -> dict[str, Any]:
    origins = word.origins
    return {
        "clusters": list(word.clusters),
        "names": list(word.letter_names),
        "lines": list(word.layouts[0].row.lines),
        "bases": origins.is_base.astype(int).tolist(),
        "anchors": origins.anchor.tolist(),
        "gaps": origins.gaps.astype(int).tolist(),
        "pushed": [
            [[int(letter), float(row[letter])] for letter in np.flatnonzero(row)]
            for row in origins.pushed
        ],
        "own": _steps(origins.own, regions),
        "anchored": _steps(origins.anchored, regions),
    }


def _steps(halves: Halves, regions: IntArray) -> list[dict[str, Any]]:
    return [
        {"x": _form(base[0], deltas[0], regions), "y": _form(base[1], deltas[1], regions)}
        for base, deltas in zip(*halves, strict=True)
    ]


def _form(base: float, deltas: Array, regions: IntArray) -> dict[str, Any]:
    used = np.flatnonzero(deltas)
    return {
        "default": float(base),
        "regions": regions[used].tolist(),
        "deltas": deltas[used].tolist(),
    }


def _axes(font: Font) -> list[dict[str, Any]]:
    return [
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
    ]
