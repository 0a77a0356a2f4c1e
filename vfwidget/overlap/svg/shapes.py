"""The areas that the shapes of an SVG fill and stroke."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...errors import OverlapError
from ...limits import limits
from ...outline.cubics import chord, x_extent
from .paint import is_visible
from .parts import Drawn, number
from .paths import path_of, subpaths
from .strokes import LEAST_CURVES, Pen, count_dashes, length_of, stroked

GEOMETRY = frozenset("d points x y x1 y1 x2 y2 cx cy r rx ry width height".split())
"""The attributes that give a shape its form."""
ROOM = 4
"""Curves of which boxes are measured, by those that may be drawn."""
NUMBER = re.compile(r"[0-9]*\.?[0-9]+")


class Painted(NamedTuple):
    """An area that is filled by one rule: even-odd or nonzero."""

    contours: list[Array]
    even_odd: bool


class Outline(NamedTuple):
    """The path of a shape.

    Attributes
    ----------
    subpaths : list of ((s, 4, 2) array, bool)
        Cubic segments in the shape's own coordinates, and whether they are closed.
    linear, shift : (2, 2) and (2,) arrays
        From these coordinates to those of the document.
    pen : Pen, optional
        How the path is stroked; None if it is not.
    """

    subpaths: list[tuple[Array, bool]]
    linear: Array
    shift: Array
    pen: Pen | None

    def placed(self, segments: Array) -> Array:
        """Segments in the coordinates of the document."""
        return segments @ self.linear + self.shift


def outlines(shapes: Sequence[Drawn]) -> list[Outline]:
    """The path of each shape; those that are drawn several times are read once.

    Raises
    ------
    OverlapError
        A shape cannot be read, or there are too many curves.
    """
    known: dict[tuple[str, ...], list[tuple[Array, bool]]] = {}
    count, found = 0, []
    for shape in shapes:
        form = {name: shape.attributes[name] for name in GEOMETRY & shape.attributes.keys()}
        key = (shape.tag, *(part for pair in sorted(form.items()) for part in pair))
        if key not in known:
            check_curves(_stated_curves(form))
            try:
                known[key] = subpaths(path_of(shape.tag, form))
            except Exception as error:
                raise OverlapError(f"A {shape.tag} of the SVG cannot be read: {error}.") from None
        pen = _pen(shape, known[key])
        found.append(Outline(known[key], shape.matrix[:2], shape.matrix[2], pen))
        count += _least_curves(found[-1])
        check_curves(count)
    return found


def check_curves(curves: int) -> None:
    """Refuse artwork of too many curves."""
    if curves > limits.svg_curves:
        raise OverlapError(
            f"The SVG has at least {curves:,} curves, with those around its strokes, and at most "
            f"{limits.svg_curves:,} are read; simplify it or raise vf.limits.svg_curves."
        )


def areas(shape: Drawn, path: Outline) -> Iterator[Painted]:
    """The area that a shape fills, and the one that it strokes."""
    if path.subpaths and _is_painted(shape.style, "fill", "black"):
        yield filled(path, shape.style.get("fill-rule"))
    pen = path.pen
    if pen is None:
        return
    # The width of this stroke is that of the document, whatever the transforms.
    still = "non-scaling-stroke" in shape.style.get("vector-effect", "")
    bars, count = list[Array](), 0
    for segments, closed in path.subpaths:
        for piece in stroked(path.placed(segments) if still else segments, closed, pen):
            bars.append(piece if still else path.placed(piece))
            # A cusp takes long and has many curves, so they are counted one by one.
            count += len(piece)
            check_curves(count)
    if bars:
        yield Painted(bars, False)


def filled(path: Outline, rule: str | None) -> Painted:
    """The area inside a path by a rule, "evenodd" or "nonzero"."""
    contours = [_closed(path.placed(segments)) for segments, _ in path.subpaths]
    return Painted(contours, rule == "evenodd")


def _stated_curves(form: dict[str, str]) -> int:
    """At least how many curves a shape has, by its text, which is quick to count."""
    path, points = form.get("d", ""), form.get("points", "")
    letters = sum(map(path.count, "hHvVlLcCsSqQtTaA"))
    return max(letters, len(NUMBER.findall(path)) // 7, len(NUMBER.findall(points)) // 2)


def _least_curves(path: Outline) -> int:
    """At least how many curves a shape has, with those around its stroke."""
    pen = path.pen
    if pen is None:
        return sum(len(segments) for segments, _ in path.subpaths)
    sides = (len(segments) + count_dashes(segments, pen) for segments, _ in path.subpaths)
    return LEAST_CURVES * sum(sides)


class Boxes:
    """The bounding boxes of shapes of a document, of which some may be measured again."""

    measured = 0

    def of(self, shapes: Sequence[Drawn], matrix: Array, strokes: bool = False) -> Array | None:
        """The bounding box (2, 2) of shapes as seen in a coordinate system.

        As in browsers, it is the box around the boxes of the shapes in their own coordinates.

        Parameters
        ----------
        shapes : sequence of Drawn
        matrix : (3, 2) array
            From the coordinates of the box to those of the document.
        strokes : bool
            Whether strokes count.

        Raises
        ------
        OverlapError
            There are too many curves in all boxes of the document.
        """
        corners = []
        for path in outlines([shape for shape in shapes if not shape.of_marker]):
            parts = [_closed(part) for part, _ in path.subpaths]
            if strokes and path.pen is not None:
                parts += [piece for one in path.subpaths for piece in stroked(*one, path.pen)]
            self.measured += sum(map(len, parts))
            if self.measured > ROOM * limits.svg_curves:
                raise OverlapError(
                    f"The SVG needs the boxes of more than {ROOM * limits.svg_curves:,} curves "
                    "for clip paths and transforms; simplify it or raise vf.limits.svg_curves."
                )
            if parts:
                corners.append(path.placed(_corners(np.concatenate(parts))))
        if not corners or abs(np.linalg.det(matrix[:2])) == 0:
            return None
        own = (np.concatenate(corners) - matrix[2]) @ np.linalg.inv(matrix[:2])
        return np.stack([own.min(0), own.max(0)])


def _corners(segments: Array) -> Array:
    """The corners (4, 2) of the box around closed segments.

    The extent of open segments leaves out where the last one ends.
    """
    import torch

    cubics = torch.from_numpy(segments)
    x, y = (torch.stack(x_extent([cubics[..., axes]])) for axes in ([0, 1], [1, 0]))
    return np.array([(a, b) for b in y for a in x]).reshape(-1, 2)


def _closed(segments: Array) -> Array:
    """A contour that ends where it starts, by a straight side if necessary."""
    start, end = segments[-1, 3], segments[0, 0]
    if np.array_equal(start, end):
        return segments
    return np.concatenate([segments, chord(start, end)[None]])


def _is_painted(style: dict[str, str], name: str, default: str) -> bool:
    """Whether a fill or a stroke is visible."""
    paint = style.get(name, default)
    if paint == "currentcolor":
        paint = style.get("color", "black")
    return is_visible(paint) and number(style.get(f"{name}-opacity"), 1.0) > 0


def _pen(shape: Drawn, subpaths: Sequence[tuple[Array, bool]]) -> Pen | None:
    """How the path of a shape is stroked; None if it is not."""
    style = shape.style
    width = number(style.get("stroke-width"), 1.0)
    if width <= 0 or not _is_painted(style, "stroke", "none"):
        return None
    # Lengths have been read as numbers; "none" is none.
    dashes = tuple(number(part, 0.0) for part in style.get("stroke-dasharray", "").split())
    if sum(dashes) == 0:
        dashes = ()
    pen = Pen(
        width,
        style.get("stroke-linecap", "butt"),
        style.get("stroke-linejoin", "miter"),
        number(style.get("stroke-miterlimit"), 4.0),
        dashes,
        number(style.get("stroke-dashoffset"), 0.0),
    )
    return _stretched(pen, shape.attributes.get("pathLength"), subpaths)


def _stretched(pen: Pen, stated: str | None, subpaths: Sequence[tuple[Array, bool]]) -> Pen:
    """A pen whose dashes are measured in units of which the path has a stated number."""
    whole = number(stated, -1.0)
    if not pen.dashes or whole < 0:
        return pen
    if whole == 0:
        return pen._replace(dashes=())
    scale = sum(length_of(segments) for segments, _ in subpaths) / whole
    dashes = tuple(scale * dash for dash in pen.dashes)
    return pen._replace(dashes=dashes if sum(dashes) > 0 else (), offset=scale * pen.offset)
