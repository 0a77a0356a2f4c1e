"""What a text can be written as: an SVG picture, CSS, a static font."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from numbers import Real
from typing import Any, overload

from ..errors import TextError
from ..export.css import declarations
from ..export.svg import picture
from ..files import written
from ..font import Font
from .colours import palette_of, shapes, without_crossings
from .composition import Composition


class Exports:
    """Methods of :class:`Text` that write it, as it stands, in other formats."""

    composition: Composition
    axes: Any
    tracking: Any

    @overload
    def to_svg(
        self,
        *,
        height: float | None = ...,
        background: str | None = ...,
        palette: int | Sequence[Any] = ...,
        union: bool = ...,
    ) -> str: ...
    @overload
    def to_svg(
        self,
        path: str | os.PathLike[str],
        *,
        height: float | None = ...,
        background: str | None = ...,
        palette: int | Sequence[Any] = ...,
        union: bool = ...,
    ) -> None: ...
    def to_svg(
        self,
        path: str | os.PathLike[str] | None = None,
        *,
        height: float | None = None,
        background: str | None = None,
        palette: int | Sequence[Any] = 0,
        union: bool = False,
    ) -> str | None:
        """Draw the text as an SVG document in font units.

        Parameters
        ----------
        path : str or path, optional
            The file to write. Without it, the document is returned.
        height : float, optional
            Height of the picture in pixels. By default the picture takes the size of its container.
        background : str, optional
            A CSS colour. By default the picture is transparent.
        palette : int or list of colours
            The colours of colour glyphs: the index of a palette of the font, or as many colours
            of red, green, blue and alpha from 0 to 1. Default 0, the font's first palette.
        union : bool
            Whether contours that overlap are joined, for plotters and cutters. Default False.

        Returns
        -------
        str or None
            One path for the whole text, filled by the nonzero rule; a colour glyph has one for
            each layer. The document has a title, runs no script and refers to nothing outside.

        Raises
        ------
        TextError
            The height is not a number > 0, or the font has no such palette.
        OSError
            The file cannot be written.
        """
        if height is not None and not (isinstance(height, Real) and 0 < height < math.inf):
            raise TextError(f"height must be a number of pixels > 0; received {height!r}.")
        font = self.composition.font
        drawn = picture(
            [without_crossings(shape) for shape in shapes(self)] if union else shapes(self),
            title=self.title,
            line=(font.descender, font.ascender),
            palette=palette_of(font, palette),
            height=height,
            background=background,
        )
        return written(drawn, path)

    @overload
    def to_css(self) -> str: ...
    @overload
    def to_css(self, path: str | os.PathLike[str]) -> None: ...
    def to_css(self, path: str | os.PathLike[str] | None = None) -> str | None:
        """Write the CSS declarations that set the text in its font at its axes.

        Parameters
        ----------
        path : str or path, optional
            The file to write. Without it, the declarations are returned.

        Returns
        -------
        str or None
            ``font-family`` and ``font-variation-settings``, and where the text has features or
            tracking, ``font-feature-settings`` and ``letter-spacing``. With an axis vector for
            each letter there is one rule for each letter, ``.letter-1`` and so on. Offsets,
            rotations, lines and the language are left out.

        Raises
        ------
        TextError
            A feature is set for some characters only.
        OSError
            The file cannot be written.
        """
        font, options = self.composition.font, self.composition.options
        parts = [str(feature) for feature in options.features if not feature.is_everywhere]
        if parts:
            raise TextError(
                "CSS sets features for a whole element, and this text sets some for a part of its "
                f"characters: {', '.join(parts)}. Make a text of each part, or use to_svg."
            )
        features, tracking = options.whole_features, self.tracking / font.units_per_em
        return written(declarations(font.family_name, self.axes, features, tracking), path)

    def to_font(self, path: str | os.PathLike[str] | None = None, name: str | None = None) -> Font:
        """The text's glyphs at its location as a static font; ``path`` writes it to a file, too.

        ``name`` is its family name; by default the parent's, followed by the axis values.

        Raises
        ------
        TextError
            The letters have axis values of their own.
        FontError
            The name is no name, or fontTools cannot make the instance.
        VFWidgetError, OSError
            The path is not valid, or the file cannot be written.
        """
        if not self.composition.shared:
            raise TextError("to_font needs one location for all letters; use shared=True.")
        font = self.composition.font.instance(self.axes, name, self.composition.string)
        if path is not None:
            font.save(path)
        return font

    @property
    def title(self) -> str:
        """The string and the name of the font, for a heading or an alternative text."""
        return f"{self.composition.string} in {self.composition.font.family_name}"
