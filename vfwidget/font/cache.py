"""Unpacked glyphs that a font keeps, up to a limit of memory."""

from __future__ import annotations

from collections import OrderedDict

from ..limits import limits
from ..outline.glyph import Glyph


class GlyphCache:
    """Glyphs by name; those used least recently are forgotten first.

    It grows up to ``limits.glyph_cache_bytes``, and always holds the latest glyph.
    """

    def __init__(self) -> None:
        self._glyphs: OrderedDict[str, Glyph] = OrderedDict()
        self._bytes = 0

    def get(self, name: str) -> Glyph | None:
        """A glyph that is kept."""
        if name in self._glyphs:
            self._glyphs.move_to_end(name)
        return self._glyphs.get(name)

    def add(self, name: str, glyph: Glyph) -> None:
        """Keep a glyph."""
        self._glyphs[name] = glyph
        self._bytes += glyph.nbytes
        while self._bytes > limits.glyph_cache_bytes and len(self._glyphs) > 1:
            _, forgotten = self._glyphs.popitem(last=False)
            self._bytes -= forgotten.nbytes
