"""From a string to a row of glyphs, by HarfBuzz."""

from __future__ import annotations

from dataclasses import dataclass

import uharfbuzz as hb
from fontTools.ttLib import TTFont

from ..errors import GlyphError, TextError

FEATURES = {"kern": False}
"""Kerning is off: Eq. 3 spaces glyphs by their side bearings alone."""


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
    """

    glyph_id: int
    cluster: int
    offset: tuple[float, float]


class Shaper:
    """HarfBuzz over one font's tables, at the default instance."""

    def __init__(self, font: TTFont) -> None:
        face = hb.Face.create_for_tables(
            lambda _face, tag, _data: font.getTableData(tag) if tag in font else b"", None
        )
        self._font = hb.Font(face)
        self._font.scale = (face.upem, face.upem)

    def shape(self, string: str) -> list[ShapedGlyph]:
        """Shape a line of text; ligatures and alternates as the font's default features say.

        Raises
        ------
        TextError
            ``string`` is empty or no string.
        GlyphError
            The font has no glyph for a character.
        """
        if not isinstance(string, str):
            raise TextError(f"A text is a string, not {type(string).__name__}.")
        if not string:
            raise TextError("The text is empty: there is nothing to lay out.")
        buffer = hb.Buffer()
        buffer.add_str(string)
        buffer.guess_segment_properties()
        hb.shape(self._font, buffer, FEATURES)
        missing = sorted({string[g.cluster] for g in buffer.glyph_infos if g.codepoint == 0})
        if missing:
            raise GlyphError(
                "The font has no glyph for " + ", ".join(f"{c!r} (U+{ord(c):04X})" for c in missing)
            )
        return [
            ShapedGlyph(info.codepoint, info.cluster, (position.x_offset, position.y_offset))
            for info, position in zip(buffer.glyph_infos, buffer.glyph_positions, strict=True)
        ]
