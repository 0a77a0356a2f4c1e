"""What a font file holds, as a table for people."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

from fontTools.ttLib import TTFont

from .design_space import DesignSpace
from .names import family_name

READ = {
    **dict.fromkeys(("glyf", "loca", "GLYF", "LOCA"), "TrueType outlines"),
    **dict.fromkeys(("gvar", "GVAR"), "variations of TrueType outlines"),
    **dict.fromkeys(("CFF ", "CFF2"), "PostScript outlines"),
    **dict.fromkeys(("fvar", "avar"), "axes and their maps"),
    **dict.fromkeys(("hmtx", "hhea", "HMTX", "HHEA", "HVAR"), "advance widths"),
    **dict.fromkeys(("vmtx", "vhea", "VMTX", "VHEA", "VVAR"), "advances of vertical text"),
    **dict.fromkeys(("MVAR", "OS/2", "post"), "metrics of the font"),
    **dict.fromkeys(("GDEF", "GSUB", "GPOS", "kern", "morx", "kerx"), "shaping"),
    **dict.fromkeys(("head", "maxp", "MAXP", "cmap", "name"), "general data"),
    **dict.fromkeys(("COLR", "CPAL"), "colour glyphs"),
    "VARC": "components with axes of their own",
}
"""What is read of each table."""
LEFT_ASIDE = {
    **dict.fromkeys(("cvt ", "fpgm", "prep", "gasp", "cvar", "VDMX", "hdmx", "LTSH"), "hinting"),
    **dict.fromkeys(("SVG ", "sbix", "CBDT", "CBLC"), "pictures cannot vary"),
    **dict.fromkeys(("EBDT", "EBLC", "EBSC", "bdat", "bloc"), "bitmaps cannot vary"),
    **dict.fromkeys(("STAT", "meta", "DSIG", "PCLT"), "not needed to draw"),
    **dict.fromkeys(("VORG", "BASE", "JSTF", "MATH"), "layout that texts here do not have"),
}
"""Why a table is not read."""
MOST_NAMES = 12
"""Instances that are named before the rest is only counted."""


@dataclass(frozen=True)
class Description:
    """A table with a heading; each row has a label and a value.

    Attributes
    ----------
    title : str
    rows : tuple of (str, str)
    """

    title: str
    rows: tuple[tuple[str, str], ...]

    def __repr__(self) -> str:
        width = max(len(label) for label, _ in self.rows)
        return "\n".join(
            [self.title, *(f"  {label:<{width}}  {text}" for label, text in self.rows)]
        )

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><th style='text-align:left'>{escape(label)}</th>"
            f"<td style='text-align:left'>{escape(text)}</td></tr>"
            for label, text in self.rows
        )
        return f"<table><caption>{escape(self.title)}</caption>{rows}</table>"


def describe(space: DesignSpace, font: TTFont) -> Description:
    """Sum up a font and its file."""
    rows = [("glyphs", str(len(font.getGlyphOrder())))]
    rows.append(("units per em", str(font["head"].unitsPerEm)))
    for axis in space.axes:
        notes = ["hidden"] if axis.hidden else []
        if any(source != target for source, target in axis.segment_map):
            notes.append(f"avar map of {len(axis.segment_map)} points")
        numbers = f"{axis.minimum:g} … {axis.default:g} … {axis.maximum:g}"
        rows.append((f"axis {axis.tag}", ", ".join([axis.name, numbers, *notes])))
    if "avar" in font and font["avar"].majorVersion == 2:
        rows.append(("avar", "version 2: axes move other axes"))
    rows.append(("instances", _listed([instance.name for instance in space.instances])))
    tags = [tag for tag in font.keys() if tag != "GlyphOrder"]
    rows.append(("tables read", _listed([t.strip() for t in tags if t in READ], len(tags))))
    for tag in tags:
        if tag not in READ:
            rows.append((f"{tag.strip()} left aside", LEFT_ASIDE.get(tag, "unknown table")))
    return Description(family_name(font), tuple(rows))


def _listed(names: Sequence[str], most: int = MOST_NAMES) -> str:
    rest = f" and {len(names) - most} more" if len(names) > most else ""
    return (", ".join(names[:most]) or "none") + rest
