"""Outlines as an SVG picture: one path for each fill, filled by the nonzero rule."""

from __future__ import annotations

import re
from collections.abc import Sequence
from html import escape

from ..arrays import Array
from ..outline.paint import Palette, Shape
from .paint import filled

MARGIN = 0.1
"""Room around the outlines, as a share of the height of the line."""


def plain(text: str) -> str:
    """Text for XML: markup is escaped, and characters that XML does not allow are replaced."""
    return escape(re.sub("[^\t\n\r -\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]", "\ufffd", text))


def picture(
    shapes: Sequence[Shape],
    *,
    title: str,
    line: tuple[float, float],
    palette: Palette = (),
    height: float | None = None,
    background: str | None = None,
) -> str:
    """Draw shapes as an SVG document.

    Parameters
    ----------
    shapes : sequence of Shape
        From back to front, in font units, y up.
    title : str
        Plain text; markup in it is escaped.
    line : (float, float)
        Least and greatest y that the picture shows even if no contour reaches them.
    palette : palette, optional
        The colours that paints refer to.
    height : float, optional
        Height of the picture in pixels. By default the picture takes the size of its container.
    background : str, optional
        A CSS colour. By default the picture is transparent.
    """
    contours = [contour for shape in shapes for contour in shape.contours]
    low = [contour.min((0, 1)) for contour in contours]
    high = [contour.max((0, 1)) for contour in contours]
    descender, ascender = line
    margin = MARGIN * (ascender - descender)
    left = min([0.0, *(x for x, _ in low)]) - margin
    right = max([0.0, *(x for x, _ in high)]) + margin
    top = -max([ascender, *(y for _, y in high)]) - margin
    bottom = -min([descender, *(y for _, y in low)]) + margin
    wide, tall = right - left, bottom - top
    box = f"{left:.1f} {top:.1f} {wide:.1f} {tall:.1f}"
    size = f' width="{height * wide / tall:.0f}" height="{height:.0f}"' if height else ""
    back = (
        f'<rect x="{left:.1f}" y="{top:.1f}" width="100%" height="100%" '
        f'fill="{plain(background)}"/>'
        if background is not None
        else ""
    )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{box}"{size} role="img">'
        f"<title>{plain(title)}</title>{back}"
        f"{drawn(shapes, palette, 'paint')}</svg>"
    )


def drawn(shapes: Sequence[Shape], palette: Palette, name: str) -> str:
    """Shapes from back to front as SVG elements; the name begins those of their gradients."""
    found = []
    for i, (contours, fill) in enumerate(shapes):
        data = path_data(contours)
        if fill is None:
            found.append(f'<path fill-rule="nonzero" d="{data}"/>')
        else:
            found.append(filled(data, contours, fill, palette, f"{name}-{i}"))
    return "".join(found)


def path_data(contours: Sequence[Array]) -> str:
    """Path data of contours (s, 4, 2), with y downwards."""
    return "".join(_contour(contour * [1, -1]) for contour in contours)


def _contour(segments: Array) -> str:
    x, y = segments[0, 0]
    curves = " ".join(
        f"C{a:.1f} {b:.1f} {c:.1f} {d:.1f} {e:.1f} {f:.1f}"
        for (a, b), (c, d), (e, f) in segments[:, 1:]
    )
    return f"M{x:.1f} {y:.1f}{curves}Z"
