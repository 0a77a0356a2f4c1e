"""From the tables of a font file to one glyph, whatever the format of its outlines."""

from __future__ import annotations

from collections.abc import Callable
from threading import RLock

from fontTools.ttLib import TTFont

from ..errors import FontError
from ..outline.glyph import Glyph, Layer
from ..outline.varying import Affine, Varying
from .cff import CffReader
from .colour import ColourReader
from .glyf import GlyfReader
from .metrics import Advances
from .source import damage
from .varc import VarcReader

OUTLINE_TABLES: dict[str, type[GlyfReader] | type[CffReader]] = {
    **{"GLYF": GlyfReader, "glyf": GlyfReader, "CFF2": CffReader, "CFF ": CffReader}
}
"""Which reader knows each table; where a font has several, the first of them is read."""


class GlyphReader:
    """Unpacks the glyphs of one font.

    Parameters
    ----------
    font : TTFont
    axis_count : int

    Raises
    ------
    FontError
        The font has no outlines in a format that is known.
    """

    def __init__(self, font: TTFont, axis_count: int) -> None:
        tag = next((tag for tag in OUTLINE_TABLES if tag in font), None)
        if tag is None:
            raise FontError(
                "This font has no outlines that can be read: it has none of the tables "
                f"{', '.join(table.strip() for table in OUTLINE_TABLES)}. "
                "Load a font with outlines; bitmaps and SVG pictures cannot vary."
            )
        self._font, self._varies = font, axis_count > 0
        with damage(f"The {tag.strip()} table, or a table that it needs, is damaged"):
            self._outlines = OUTLINE_TABLES[tag](font, axis_count)
        with damage(
            "The VARC table is damaged, or follows an older draft of the format; use a newer build "
            "of the font"
        ):
            self._composites = (
                VarcReader(font, axis_count, self._outlines.read) if "VARC" in font else None
            )
        with damage("The hmtx or HVAR table is damaged"):
            self._widths = Advances(font, axis_count)
        vertical = "vmtx" in font or "VMTX" in font
        with damage("The vmtx or VVAR table is damaged"):
            self._heights = Advances(font, axis_count, vertical=True) if vertical else None
        with damage("The COLR table is damaged"):
            self._colours = ColourReader(font, axis_count, self.read) if "COLR" in font else None

    def layers(self, name: str) -> tuple[Layer, ...]:
        """What a colour glyph paints, as :meth:`ColourReader.read` gives it."""
        return self._colours.read(name) if self._colours else ()

    def has_layers(self, name: str) -> bool:
        """Whether this is a colour glyph."""
        return self._colours is not None and name in self._colours

    def read(self, name: str) -> Glyph:
        """Unpack one glyph, without its layers.

        Raises
        ------
        FontError
            The glyph's data are damaged.
        """
        glyph_id: int = self._font.getGlyphID(name)
        drawn = self._outlines.read(name)
        # Phantom points matter where they vary only: they may be those of a component.
        by_width, by_height = (drawn.width, drawn.height) if self._varies else (None, None)
        width = Affine(*self._widths.read(name, glyph_id, by_width, drawn.support))
        outline: Varying
        if self._composites and name in self._composites:
            outline, contours = self._composites.read(name)
        else:
            outline, contours = drawn.outline, list(drawn.contours)
        glyph = Glyph.of(outline, width, contours, name, glyph_id)
        if self._heights:
            height = self._heights.read(name, glyph_id, by_height, drawn.support)
            glyph.advance_height = Affine(*height)
        return glyph


def layers_later(reader: GlyphReader, reading: RLock, name: str) -> Callable[[], tuple[Layer, ...]]:
    """A function that reads the layers of a glyph; it does not keep the font alive."""

    def read() -> tuple[Layer, ...]:
        with reading, damage(f"The colours of glyph {name!r} are damaged"):
            return reader.layers(name)

    return read
