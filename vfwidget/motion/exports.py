"""What an animation can be written as: CSS, a page, SVG, Lottie, JSON."""

from __future__ import annotations

import json
import re
from typing import Any

import numpy as np

from ..arrays import Array
from ..errors import MotionError
from ..export.animated_svg import animated_picture
from ..export.css_animation import markup, style_sheet
from ..export.images import read_colour
from ..export.lottie import lottie
from ..export.page import font_face, page
from ..files import written
from ..text import Text
from ..text.inputs import read_flag
from .image_exports import ImageExports, PathLike
from .numbers import LARGEST, read_number
from .spans import JOINER, Alternates, text_spans
from .tracks import drawn_box, letter_tracks, outlines, user_coordinates

CLASS = re.compile(r"[A-Za-z][\w-]*", re.ASCII)
"""Names of classes that need no escapes."""
NAME = "vf-text"
"""The class of the animated element in CSS."""
TOLERANCE = 0.001
"""Greatest error of an outline between keyframes in ems, unless stated otherwise."""


class Exports(ImageExports):
    """Methods of :class:`Animation` that write it in other formats.

    Each writes a file, which is replaced if it exists, and returns None; without a path it
    returns the content. CSS, SVG and Lottie hold keyframes. Between them outlines are
    interpolated, and ``tolerance`` is the greatest distance of a control point from its position
    in a frame, in font units (default: 1/1000 em).
    """

    text: Text
    times: Array
    theta: Array
    rotations: Array
    duration: Any
    fps: Any

    def to_css(
        self,
        path: PathLike | None = None,
        *,
        name: str = NAME,
        loop: bool = True,
        tolerance: float | None = None,
    ) -> str | None:
        """Write a style sheet that animates the axes; the text stays text.

        The sheet has a custom property for each axis that varies, and keyframes for each letter.
        A comment at its beginning holds the HTML element that it animates. The page has to
        provide the font, and the browser has to support its tables (few browsers read VARC).
        Letters stand where the animation has them, kerning included.

        Parameters
        ----------
        path : str or path, optional
            The file to write.
        name : str
            Class of the animated element. Default ``"vf-text"``; two animations on one page need
            two names.
        loop : bool
            Whether the animation repeats without end. Default True.
        tolerance : float, optional
            Largest error of a control point between keyframes, in font units. Default: 1/1000
            of an em.

        Returns
        -------
        str or None
            A reader who prefers reduced motion sees the last frame. Obstacles are left out.

        Raises
        ------
        MotionError
            A glyph depends on its neighbours, so that elements for single letters cannot show it;
            several glyphs of one character, such as a letter and its mark, have different axes or
            do not move as one piece; or an option has no meaning.
        OSError
            The file cannot be written.
        """
        if not (isinstance(name, str) and CLASS.fullmatch(name)):
            raise MotionError(
                f"name must be a letter, followed by letters, digits, - and _; received {name!r}."
            )
        family = self.text.font.family_name
        element, sheet = self._styled(name, family, loop, tolerance)
        # An asterisk in the text must not end the comment.
        return written(f"/* {element.replace('*', '&#42;')} */\n{sheet}", path)

    def to_html(
        self,
        path: PathLike | None = None,
        *,
        loop: bool = True,
        tolerance: float | None = None,
    ) -> str | None:
        """Write a page that contains the font, cut to the text, and runs without script or network.

        Glyphs that depend on their neighbours are shown, unlike in :meth:`to_css`, because the font
        of the page has a feature that chooses them.

        Parameters
        ----------
        path : str or path, optional
            The file to write.
        loop, tolerance
            As for :meth:`to_css`.

        Raises
        ------
        MotionError
            Several glyphs of one character, such as a letter and its mark, have different axes or
            do not move as one piece; or an option has no meaning.
        FontError
            fontTools cannot cut the font to the text.
        OSError
            The file cannot be written.
        """
        family, alternates, font = "vf-font", Alternates(), self.text.font
        element, sheet = self._styled(NAME, family, loop, tolerance, alternates)
        file = font.web_font(self.text.string + JOINER, alternates.by_name(font.glyph_names))
        made = page(self.text.title, element, [], font_face(family, file) + sheet + PAGE_STYLE)
        return written(made, path)

    def to_svg(
        self,
        path: PathLike | None = None,
        *,
        loop: bool = True,
        tolerance: float | None = None,
        height: float | None = None,
        background: str | None = None,
    ) -> str | None:
        """Write an animated SVG (SMIL), which shows the outlines without font or script.

        Parameters
        ----------
        path : str or path, optional
            The file to write.
        loop, tolerance
            As for :meth:`to_css`.
        height : float, optional
            Height of the picture in pixels. By default the picture takes the size of its container.
        background : str, optional
            A CSS colour. By default the picture is transparent.

        Returns
        -------
        str or None
            A reader who prefers reduced motion sees the last frame. Obstacles are lighter. Colour
            glyphs take the first palette of the font. SVG cannot animate all numbers of a
            gradient, so a layer whose paint varies has one picture for each frame.

        Raises
        ------
        MotionError
            An option has no meaning.
        OSError
            The file cannot be written.
        """
        if height is not None:
            height = read_number("height", height, 0.0, LARGEST, True)
        if not isinstance(background, str | None):
            raise MotionError(f"background must be a CSS colour; received {background!r:.200}.")
        letters, obstacles, box, palette = outlines(self)
        made = animated_picture(
            letters,
            obstacles,
            title=self.text.title,
            box=box,
            times=self.times - self.times[0],
            tolerance=self._tolerance(tolerance),
            palette=palette,
            loop=read_flag("loop", loop, MotionError),
            height=height,
            background=background,
        )
        return written(made, path)

    def to_lottie(
        self,
        path: PathLike | None = None,
        *,
        tolerance: float | None = None,
        ink: str = "black",
    ) -> str | None:
        """Write a Lottie document of shapes, because its players have no variable fonts.

        Parameters
        ----------
        path : str or path, optional
            The file to write.
        tolerance : float, optional
            Largest error of a control point between keyframes, in font units. Default: 1/1000
            of an em.
        ink : str
            Colour of the letters as in CSS. Default black.

        Returns
        -------
        str or None
            JSON. Whether it repeats is up to the player. Obstacles are lighter. Colour glyphs take
            the first palette of the font.

        Raises
        ------
        MotionError
            An option has no meaning, or a colour glyph has a gradient that Lottie does not have:
            a sweep gradient, one that repeats, or a radial one that is stretched or whose two
            circles have different centres and radii above 0.
        OSError
            The file cannot be written.
        """
        letters, obstacles, box, palette = outlines(self)
        made = lottie(
            letters,
            obstacles,
            title=self.text.title,
            box=box,
            times=self.times - self.times[0],
            fps=self.fps,
            tolerance=self._tolerance(tolerance),
            colour=read_colour("ink", ink),
            palette=palette,
        )
        return written(made, path)

    def to_json(self, path: PathLike | None = None) -> str | None:
        """Write the axis values, positions and rotations of every frame as JSON.

        Parameters
        ----------
        path : str or path, optional
            The file to write.

        Returns
        -------
        str or None
            An object with ``text``, ``family``, ``units_per_em``, ``times`` (seconds), and
            ``letters``: for each letter its characters (``text``), ``axes`` (a list of user
            coordinates for each tag), ``x``, ``y`` (its origin in font units, y up) and
            ``rotation`` (radians, counterclockwise). Numbers are rounded to 1e-5.

        Raises
        ------
        OSError
            The file cannot be written.
        """
        users, text = user_coordinates(self), self.text
        tracks, letters = letter_tracks(self), []
        for index, (name, row) in enumerate(zip(text.word.letter_names, tracks, strict=False)):
            origins = np.concatenate([track.origins for track in row])
            own = users[:, 0 if text.shared else index]
            letters.append(
                {
                    "text": name,
                    "axes": {
                        axis.tag: _rounded(column)
                        for axis, column in zip(text.font.axes, own.T, strict=True)
                    },
                    "x": _rounded(origins[:, 0]),
                    "y": _rounded(origins[:, 1]),
                    "rotation": _rounded(self.rotations[:, index]),
                }
            )
        document = {
            "text": text.string,
            "family": text.font.family_name,
            "units_per_em": text.font.units_per_em,
            "times": _rounded(self.times, 12),
            "letters": letters,
        }
        return written(json.dumps(document, separators=(",", ":")), path)

    def _tolerance(self, tolerance: float | None) -> float:
        em = self.text.font.units_per_em
        if tolerance is None:
            return TOLERANCE * em
        return read_number("tolerance", tolerance, 0.0, em, open_below=False)

    def _styled(
        self,
        name: str,
        family: str,
        loop: bool,
        tolerance: float | None,
        alternates: Alternates | None = None,
    ) -> tuple[str, str]:
        """The element that holds the text, and its style sheet."""
        text, font, em = self.text, self.text.font, self.text.font.units_per_em
        tracks = letter_tracks(self)
        left, bottom, right, top = drawn_box(self, tracks)
        spans = text_spans(self, tracks, self._tolerance(tolerance), alternates)
        options = text.composition.options
        element = markup(spans, name=name, string=text.string, language=options.language)
        sheet = style_sheet(
            spans,
            name=name,
            family=family,
            tags=[axis.tag for axis in font.axes],
            features=options.whole_features,
            duration=self.duration or 1.0,
            # Browsers round the distance of the baseline to whole pixels; this one is exact where
            # the size of the font is a multiple of 10 px.
            box=(left / em, bottom / em, right / em, np.ceil(10 * top / em) / 10),
            loop=read_flag("loop", loop, MotionError),
        )
        return element, sheet


PAGE_STYLE = """:root { color-scheme: light dark; }
body { display: grid; place-items: center; min-height: 90vh; margin: 0; overflow: hidden; }
.vf-text { font-size: min(20vmin, 160px); }
"""


def _rounded(values: Array, decimals: int = 5) -> list[float]:
    rounded: list[float] = np.round(values, decimals).tolist()
    return rounded
