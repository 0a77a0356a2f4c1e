"""Advances and how they vary: HVAR or VVAR when present, phantom points when not.

OpenType, "HVAR" and "VVAR" tables.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import NamedTuple

import numpy as np
from fontTools.ttLib import TTFont

from ..arrays import Array
from ..outline.variation import Regions
from .varstore import NO_VARIATION, VariationStore


class Advance(NamedTuple):
    """One glyph's advance in font units, as :class:`vfwidget.Glyph` takes it.

    Attributes
    ----------
    default : float
    deltas : (m,) array
    support : (m, n, 3) array
    """

    default: float
    deltas: Array
    support: Array


class Advances:
    """The advances of a font along one direction.

    Parameters
    ----------
    font : TTFont
    axis_count : int
    vertical : bool
        Advance heights (vmtx, VVAR) in place of advance widths (hmtx, HVAR). Default false.
    """

    def __init__(self, font: TTFont, axis_count: int, vertical: bool = False) -> None:
        metrics, variations, mapping = (
            ("vmtx", "VVAR", "AdvHeightMap") if vertical else ("hmtx", "HVAR", "AdvWidthMap")
        )
        # Fonts of more than 65,535 glyphs have a table of a longer format.
        metrics = metrics.upper() if metrics.upper() in font else metrics
        self._defaults = font[metrics].metrics if metrics in font else {}
        self._axis_count = axis_count
        self._store = None
        if variations in font:
            table = font[variations].table
            self._store = VariationStore(table.VarStore, axis_count, variations)
            index = getattr(table, mapping)
            self._index: dict[str, int] | None = index.mapping if index else None

    def read(self, name: str, glyph_id: int, layers: Array | None, support: Array) -> Advance:
        """One glyph's advance.

        Parameters
        ----------
        name : str
        glyph_id : int
        layers : (1 + m,) array or None
            Advance by the phantom points of the outline, if its format has such points.
        support : (m, n, 3) array
            The support of these layers.
        """
        default = float(self._defaults.get(name, (0, 0))[0])
        if self._store is not None:
            return Advance(default, *self._store.row(self._row_of(name, glyph_id)))
        if layers is not None:
            return Advance(float(layers[0]), layers[1:], support)
        return Advance(default, np.zeros(0), np.zeros((0, self._axis_count, 3)))

    def at(self, w: Array, names: Sequence[str]) -> dict[str, float]:
        """The advance of each glyph at w (n,), by name; empty unless the font has a table of them.

        Parameters
        ----------
        w : (n,) array
            The coordinates at which the regions of the table apply.
        names : sequence of str
            In order of glyph id.
        """
        store = self._store
        if store is None:
            return {}
        scalars = cache(lambda outer: Regions(store.support(outer)).scalars(w))
        found = {}
        for glyph_id, name in enumerate(names):
            index = self._row_of(name, glyph_id)
            deltas, _ = store.row(index)
            change = float(deltas @ scalars(index >> 16)) if len(deltas) else 0.0
            found[name] = max(float(self._defaults.get(name, (0, 0))[0]) + change, 0.0)
        return found

    def _row_of(self, name: str, glyph_id: int) -> int:
        """The index of the deltas of a glyph in the table."""
        return glyph_id if self._index is None else self._index.get(name, NO_VARIATION)


def read_positioning_regions(font: TTFont, axis_count: int) -> Array:
    """Supports (m, n, 3) of the regions over which anchors and kerning may vary (GDEF)."""
    store = getattr(font["GDEF"].table, "VarStore", None) if "GDEF" in font else None
    return VariationStore(store, axis_count, "GDEF").regions
