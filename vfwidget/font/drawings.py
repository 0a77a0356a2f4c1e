"""Glyphs from elsewhere, such as from arrays, that take the place of a font's own."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from ..errors import FontError, GlyphError
from ..outline.glyph import Glyph


class Drawings(dict[str, Glyph]):
    """Glyphs by name that a font shows in place of those of its file."""

    def and_these(
        self, glyphs: Mapping[Any, Glyph], find: Callable[[Any], Glyph], axis_count: int
    ) -> Drawings:
        """These drawings and others.

        Parameters
        ----------
        glyphs : mapping of character, glyph name or glyph id to Glyph
        find : function
            From such a key to the glyph of the font, whose name and id the drawing takes.
        axis_count : int

        Raises
        ------
        GlyphError
            ``glyphs`` is no mapping, the font has no such glyph, a drawing is no Glyph, or it has
            another number of axes.
        """
        if not isinstance(glyphs, Mapping):
            raise GlyphError(
                "glyphs must be a mapping of characters, glyph names or glyph ids to drawings; "
                f"received {glyphs!r:.80}."
            )
        drawings = Drawings(self)
        for key, glyph in glyphs.items():
            own = find(key)
            if not isinstance(glyph, Glyph) or glyph.outline.axis_count != axis_count:
                raise GlyphError(
                    f"The drawing of {key!r} must be a Glyph over {axis_count} axes; "
                    f"received {glyph!r:.80}."
                )
            drawings[own.name] = glyph.named(own.name, own.glyph_id)
        return drawings

    def check_none(self) -> None:
        """Refuse to write a font file that would lack the drawings.

        Raises
        ------
        FontError
            There are drawings.
        """
        if self:
            raise FontError(
                f"The drawings of {', '.join(self)} that with_glyphs has set cannot be written to "
                "a font file; use the font as it was loaded."
            )
