"""From a string to a row of glyphs, by HarfBuzz."""

from __future__ import annotations

from dataclasses import dataclass

import uharfbuzz as hb
from fontTools.ttLib import TTFont

from ..errors import GlyphError, TextError

FEATURES = {"kern": False}
"""Kerning is off: Eq. 3 spaces glyphs by their side bearings alone."""
TABLES = (
    *("head", "maxp", "hhea", "hmtx", "cmap", "fvar", "avar", "HVAR"),
    *("GDEF", "GSUB", "GPOS", "morx"),
)
"""What shaping reads; outlines are not among it."""


@dataclass(frozen=True)
class ShapedGlyph:
    """A glyph of a line: which one, for which character, and how far off its place.

    Attributes
    ----------
    glyph_id : int
    cluster : int
        Index in the string of the first character it stands for.
    offset : (float, float)
        Shift in font units, such as a mark's over its base.
    spacing : bool
        False for a mark that HarfBuzz gives no room, whatever the advance of its glyph.
    """

    glyph_id: int
    cluster: int
    offset: tuple[float, float]
    spacing: bool


class Shaper:
    """HarfBuzz over one font's tables, at the default instance."""

    def __init__(self, font: TTFont) -> None:
        # HarfBuzz asks for a table and then reads it where it lies, at any later time: so all are
        # held here, in full before it asks, because it could not be told of a damaged one.
        self._tables = {tag: font.getTableData(tag) for tag in TABLES if tag in font}
        face = hb.Face.create_for_tables(
            lambda _face, tag, tables: tables.get(tag, b""), self._tables
        )
        self._font = hb.Font(face)
        self._font.scale = (face.upem, face.upem)

    def shape(self, string: str) -> list[ShapedGlyph]:
        """Shape a line of text; ligatures and alternates as the font's default features say.

        Raises
        ------
        TextError
            ``string`` is no string, is empty, or holds invisible characters only.
        GlyphError
            The font has no glyph for a character.
        """
        if not isinstance(string, str):
            raise TextError(f"A text is a string, not {type(string).__name__}.")
        buffer = hb.Buffer()
        # A mark keeps its own cluster, so that a missing one is not taken for its base.
        buffer.cluster_level = hb.BufferClusterLevel.MONOTONE_CHARACTERS
        # uharfbuzz takes no subclass, such as numpy's strings.
        buffer.add_str(str(string))
        # A joiner and its like say how to shape, and are then no letters.
        buffer.flags = hb.BufferFlags.REMOVE_DEFAULT_IGNORABLES
        buffer.guess_segment_properties()
        hb.shape(self._font, buffer, FEATURES)
        if not buffer.glyph_infos:
            raise TextError(f"The text {string!r} is empty: there is nothing to lay out.")
        missing = sorted({string[g.cluster] for g in buffer.glyph_infos if g.codepoint == 0})
        if missing:
            raise GlyphError(
                "The font has no glyph for " + ", ".join(f"{c!r} (U+{ord(c):04X})" for c in missing)
            )
        return [
            ShapedGlyph(
                info.codepoint,
                info.cluster,
                (position.x_offset, position.y_offset),
                position.x_advance != 0 or self._font.get_glyph_h_advance(info.codepoint) == 0,
            )
            for info, position in zip(buffer.glyph_infos, buffer.glyph_positions, strict=True)
        ]
