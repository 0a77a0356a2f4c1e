"""Metrics of a whole font, such as its x-height, and how they vary (MVAR).

OpenType, "MVAR" table.
"""

from __future__ import annotations

import numpy as np
from fontTools.ttLib import TTFont

from ..outline.varying import Affine
from .varstore import VariationStore

USE_TYPO_METRICS = 1 << 7
"""Flag of OS/2 by which ascender, descender and line gap are those of OS/2."""
METRICS = {
    "ascender": ("hasc", "hhea", "ascent"),
    "descender": ("hdsc", "hhea", "descent"),
    "line_gap": ("hlgp", "hhea", "lineGap"),
    "clipping_ascent": ("hcla", "OS/2", "usWinAscent"),
    "clipping_descent": ("hcld", "OS/2", "usWinDescent"),
    "x_height": ("xhgt", "OS/2", "sxHeight"),
    "cap_height": ("cpht", "OS/2", "sCapHeight"),
    "underline_position": ("undo", "post", "underlinePosition"),
    "underline_thickness": ("unds", "post", "underlineThickness"),
    "strikeout_position": ("stro", "OS/2", "yStrikeoutPosition"),
    "strikeout_thickness": ("strs", "OS/2", "yStrikeoutSize"),
    "caret_rise": ("hcrs", "hhea", "caretSlopeRise"),
    "caret_run": ("hcrn", "hhea", "caretSlopeRun"),
    "caret_offset": ("hcof", "hhea", "caretOffset"),
    "subscript_x_size": ("sbxs", "OS/2", "ySubscriptXSize"),
    "subscript_y_size": ("sbys", "OS/2", "ySubscriptYSize"),
    "subscript_x_offset": ("sbxo", "OS/2", "ySubscriptXOffset"),
    "subscript_y_offset": ("sbyo", "OS/2", "ySubscriptYOffset"),
    "superscript_x_size": ("spxs", "OS/2", "ySuperscriptXSize"),
    "superscript_y_size": ("spys", "OS/2", "ySuperscriptYSize"),
    "superscript_x_offset": ("spxo", "OS/2", "ySuperscriptXOffset"),
    "superscript_y_offset": ("spyo", "OS/2", "ySuperscriptYOffset"),
    "vertical_ascender": ("vasc", "vhea", "ascent"),
    "vertical_descender": ("vdsc", "vhea", "descent"),
    "vertical_line_gap": ("vlgp", "vhea", "lineGap"),
}
"""For each metric its tag in MVAR, and the table and the field that hold its default."""
TYPOGRAPHIC = {
    "ascender": "sTypoAscender",
    "descender": "sTypoDescender",
    "line_gap": "sTypoLineGap",
}


def read_metrics(font: TTFont, axis_count: int) -> dict[str, Affine]:
    """The metrics that the font states, by name."""
    table = font["MVAR"].table if "MVAR" in font else None
    records = {record.ValueTag: record.VarIdx for record in table.ValueRecord} if table else {}
    store = VariationStore(table.VarStore if table else None, axis_count, "MVAR")
    typographic = "OS/2" in font and font["OS/2"].fsSelection & USE_TYPO_METRICS
    found = {}
    for name, (tag, holder, field) in METRICS.items():
        if typographic and name in TYPOGRAPHIC:
            holder, field = "OS/2", TYPOGRAPHIC[name]
        holder = "HHEA" if holder == "hhea" and "HHEA" in font else holder
        default = getattr(font[holder], field, None) if holder in font else None
        if default is None:
            continue
        deltas, support = np.zeros(0), np.zeros((0, axis_count, 3))
        if tag in records:
            deltas, support = store.row(records[tag])
        found[name] = Affine(float(default), deltas, support)
    return found
