"""A text as an SVG picture: one path, filled by the nonzero rule."""

from __future__ import annotations

from html import escape

from ..arrays import to_array
from ..text import Text

MARGIN = 0.1
"""Room around the text, in ems."""


def to_svg(text: Text, *, height: float | None = None, background: str | None = None) -> str:
    """Draw a text at its axes.

    Parameters
    ----------
    text : Text
    height : float, optional
        Height of the picture in pixels. By default the picture takes the size of its container.
    background : str, optional
        A CSS colour. By default the picture is transparent.

    Returns
    -------
    str
        An SVG document in font units. It has a title, runs no script and refers to nothing.
    """
    em, font = text.font.units_per_em, text.font
    outlines = [to_array(contour) * [1, -1] for contour in text.segments()]
    low = [contour.min((0, 1)) for contour in outlines]
    high = [contour.max((0, 1)) for contour in outlines]
    margin = MARGIN * em
    left = min([0.0, *(x for x, _ in low)]) - margin
    right = max([0.0, *(x for x, _ in high)]) + margin
    top = min([-font.ascender, *(y for _, y in low)]) - margin
    bottom = max([-font.descender, *(y for _, y in high)]) + margin
    wide, tall = right - left, bottom - top
    box = f"{left:.1f} {top:.1f} {wide:.1f} {tall:.1f}"
    size = f' width="{height * wide / tall:.0f}" height="{height:.0f}"' if height else ""
    title = escape(f"{text.string} in {font.family_name}")
    back = (
        f'<rect x="{left:.1f}" y="{top:.1f}" width="100%" height="100%" '
        f'fill="{escape(background)}"/>'
        if background is not None
        else ""
    )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{box}"{size} role="img">'
        f"<title>{title}</title>{back}"
        f'<path fill-rule="nonzero" d="{"".join(map(_path, outlines))}"/></svg>'
    )


def _path(contour: object) -> str:
    """Path data of one contour, (s, 4, 2)."""
    segments = to_array(contour)
    x, y = segments[0, 0]
    curves = " ".join(
        f"C{a:.1f} {b:.1f} {c:.1f} {d:.1f} {e:.1f} {f:.1f}"
        for (a, b), (c, d), (e, f) in segments[:, 1:]
    )
    return f"M{x:.1f} {y:.1f}{curves}Z"
