"""The data that the view needs to draw a text at any axis values by itself."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..arrays import Array, IntArray
from ..font import Font
from ..outline.variation import merge_regions
from ..text import Text
from ..text.composition import Composition
from ..text.origins import Halves
from ..text.place import OFFSETS
from ..text.word import Word


def describe_word(text: Text) -> dict[str, Any]:
    """Describe a text so that the view can evaluate it, with tensors as float32 buffers.

    The result does not depend on where the text is in the design space. Regions and glyphs occur
    once, for all rows of glyphs that the text can have. The ``points`` of a glyph are its default
    outline (k, 2), followed by its delta sets, (k, 2) each.

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
    support, regions = merge_regions([word.regions.support for word in words])
    glyphs: dict[int, dict[str, Any]] = {}
    for word, at in zip(words, regions, strict=True):
        for letter, glyph_id in enumerate(word.glyph_ids):
            if glyph_id not in glyphs:
                glyphs[glyph_id] = _glyph(word, letter, at)
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
        "regions": {"count": len(support), "data": support.astype("<f4").tobytes()},
        "glyphs": list(glyphs.values()),
        "rows": [
            {"order": [index[g] for g in word.glyph_ids], **_row(word, at)}
            for word, at in zip(words, regions, strict=True)
        ],
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


def _glyph(word: Word, letter: int, regions: IntArray) -> dict[str, Any]:
    glyph, affine = word.glyphs[letter], word.glyphs[letter].affine
    layers = np.concatenate([affine.base[None], np.moveaxis(affine.deltas, -1, 0)])
    return {
        "name": glyph.name,
        "contours": list(glyph.contours),
        "points": layers.astype("<f4").tobytes(),
        "regions": regions[word.outline_regions[letter]].tolist(),
        "advance": {
            "default": affine.advance_base,
            "regions": regions[word.advance_regions[letter]].tolist(),
            "deltas": affine.advance_deltas.tolist(),
        },
    }


def _row(word: Word, regions: IntArray) -> dict[str, Any]:
    origins = word.origins
    return {
        "clusters": list(word.clusters),
        "bases": origins.is_base.astype(int).tolist(),
        "anchors": origins.anchor.tolist(),
        "gaps": origins.gaps.astype(int).tolist(),
        "pushed": [
            [[int(letter), float(row[letter])] for letter in np.flatnonzero(row)]
            for row in origins.pushed
        ],
        "own": _steps(origins.own, regions),
        "beside": _steps(origins.beside, regions),
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
