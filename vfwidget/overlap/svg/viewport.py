"""The coordinates and sizes that the elements around an element of an SVG give to it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple
from xml.etree import ElementTree

from ...arrays import Array
from ...errors import OverlapError
from .maths import listed
from .parts import FONT_SIZE, Drawn, length, number
from .transforms import Frame, fitted, inside, shifted, transform_of, view_box
from .variables import Variables

PEN = frozenset({"stroke-width", "stroke-dasharray", "stroke-dashoffset"})
"""Lengths of strokes, which are inherited; percentages are inherited as such."""


NONE = Variables({})


class Around(NamedTuple):
    """What the elements around an element say about it."""

    style: dict[str, str]
    matrix: Array
    size: tuple[float, float]
    clips: tuple[list[Drawn], ...]
    elements: tuple[int, ...]
    fonts: tuple[float, float] = (FONT_SIZE, FONT_SIZE)
    """The sizes of the fonts of the element and of the document."""
    top: ElementTree.Element | None = None
    """The element that a ``use`` draws, within which rules of style look."""
    variables: Variables = NONE


def viewport(
    own: dict[str, str], around: Around, outermost: bool = False, clipped: bool = True
) -> Around | None:
    """What is around the content of an element that has a size and may have a view box.

    None if it has no area, so that nothing is drawn.
    """
    box = view_box(own)
    x, y = (0.0, 0.0) if outermost else (number(own.get(name), 0.0) for name in ("x", "y"))
    sides = [number(own[name], -1.0) if name in own else None for name in ("width", "height")]
    whole = around.size
    if box and min(box[2:]) == 0:
        return None
    if outermost and box:
        # The missing side follows from the proportions of the view box.
        ratio = box[2] / box[3]
        whole = (ratio * (sides[1] or whole[1]), (sides[0] or whole[0]) / ratio)
    width, height = (
        default if side is None else side for side, default in zip(sides, whole, strict=True)
    )
    if width <= 0 or height <= 0:
        return None
    matrix = around.matrix
    if outermost:
        frame = Frame((width, height), (width / 2, height / 2), fonts=around.fonts)
        own_matrix = transform_of(own, frame)
        matrix = matrix if own_matrix is None else inside(matrix, own_matrix)
    clips = around.clips
    if clipped and own.get("overflow", "hidden") not in ("visible", "auto"):
        form = {"x": x, "y": y, "width": width, "height": height}
        edge = Drawn("rect", {k: repr(v) for k, v in form.items()}, {}, matrix, ())
        clips = (*clips, [edge])
    aspect = own.get("preserveAspectRatio")
    fit = fitted(box, (x, y, width, height), aspect) if box else shifted(x, y)
    size = (box[2], box[3]) if box else (width, height)
    return around._replace(matrix=inside(matrix, fit), size=size, clips=clips)


def dashes(value: str, size: tuple[float, float], fonts: tuple[float, float]) -> str:
    """The lengths of dashes and gaps as numbers; empty if they are none."""
    lengths = [length("stroke-dasharray", part, size, fonts) for part in listed(value)]
    numbers = [-1.0 if number is None else number for number in lengths]
    return " ".join(map(repr, numbers)) if min(numbers) >= 0 else ""


def pen_of(around: Around) -> dict[str, str]:
    """The lengths of the stroke of a shape as numbers, by the viewport that it is in."""
    found = {name: around.style[name] for name in PEN & around.style.keys()}
    for name, value in found.items():
        if name == "stroke-dasharray" and "%" in value:
            found[name] = dashes(value, around.size, around.fonts)
        elif "%" in value:
            found[name] = repr(length(name, value, around.size, around.fonts))
    return found


def placed_in(around: Around, own: Mapping[str, str], box: Array | None = None) -> Array:
    """The matrix inside an element with these properties.

    Its origin is in a box (2, 2), or otherwise in the viewport, and percentages are of that.
    """
    if box is None:
        frame = Frame(around.size, fonts=around.fonts)
    else:
        (left, top), (width, height) = box[0].tolist(), (box[1] - box[0]).tolist()
        frame = Frame((width, height), (left, top), (left, top), around.fonts)
    own_matrix = transform_of(own, frame)
    return around.matrix if own_matrix is None else inside(around.matrix, own_matrix)


def fonts_of(own: Mapping[str, str], around: Around, is_root: bool) -> tuple[float, float]:
    """The sizes of the fonts of an element and of the document."""
    stated, (above, root) = own.get("font-size", ""), around.fonts
    if stated.endswith("%"):
        size: float | None = number(stated, 1.0) * above
    else:
        try:
            size = length("font-size", stated, around.size, around.fonts)
        except OverlapError:
            size = None
    size = size if size is not None and size >= 0 else above
    return size, size if is_root else root
