"""Advance widths and how they vary: HVAR when present, phantom points when not.

OpenType, "HVAR" table and "Item variation stores".
"""

from __future__ import annotations

from typing import Any

import numpy as np
from fontTools.ttLib import TTFont

from ..arrays import Array
from ..errors import FontError
from .glyf import PHANTOMS, RawOutline


def read_advance(font: TTFont, name: str, raw: RawOutline) -> tuple[float, Array, Array]:
    """One glyph's advance width, in font units.

    Returns
    -------
    default : float
    deltas : (m,) array
    support : (m, n, 3) array
    """
    if "HVAR" not in font:
        left, right = raw.points[:, -PHANTOMS, 0], raw.points[:, 1 - PHANTOMS, 0]
        return float(right[0] - left[0]), (right - left)[1:], raw.support
    default = float(font["hmtx"][name][0])
    tags = [axis.axisTag for axis in font["fvar"].axes]
    table = font["HVAR"].table
    mapping = table.AdvWidthMap.mapping if table.AdvWidthMap else None
    index = font.getGlyphID(name) if mapping is None else mapping.get(name, 0xFFFFFFFF)
    outer, inner = index >> 16, index & 0xFFFF
    subtables = table.VarStore.VarData
    # An index that leads nowhere means that the advance does not vary.
    if outer >= len(subtables) or inner >= len(subtables[outer].Item):
        return default, np.zeros(0), np.zeros((0, len(tags), 3))
    data = subtables[outer]
    support = _region_supports(table.VarStore, len(tags))[data.VarRegionIndex]
    deltas = np.array(data.Item[inner], dtype=np.float64)
    if len(deltas) != len(support):
        raise FontError(f"The HVAR table is damaged: too few deltas for glyph {name!r}.")
    return default, deltas, support


def read_positioning_regions(font: TTFont) -> Array:
    """Supports (m, n, 3) of the regions over which anchors and kerning may vary (GDEF)."""
    store = getattr(font["GDEF"].table, "VarStore", None) if "GDEF" in font else None
    axes = len(font["fvar"].axes)
    return _region_supports(store, axes) if store else np.zeros((0, axes, 3))


def _region_supports(store: Any, axes: int) -> Array:
    """Start, peak and end of each region of an item variation store on each axis, (m, n, 3)."""
    return np.array(
        [
            [(axis.StartCoord, axis.PeakCoord, axis.EndCoord) for axis in region.VarRegionAxis]
            for region in store.VarRegionList.Region
        ],
        dtype=np.float64,
    ).reshape(-1, axes, 3)
