"""The shapes that an SVG document draws, with their styles, transforms and clips.

References are followed within the document only. What is never drawn by itself (definitions,
symbols, masks, markers, metadata, elements of other languages) is left out.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np

from ..arrays import Array
from ..errors import OverlapError
from ..limits import limits
from .svg_style import LONG, Styles, tag_of

SHAPES = frozenset({"path", "rect", "circle", "ellipse", "line", "polyline", "polygon"})
GROUPS = frozenset({"g", "a", "svg", "switch", "use"})
INHERITED = frozenset(
    "fill fill-opacity fill-rule clip-rule stroke stroke-opacity stroke-width stroke-linecap "
    "stroke-linejoin stroke-miterlimit stroke-dasharray stroke-dashoffset visibility color".split()
)
"""Properties that an element has from the one around it unless it states its own."""
DEPTH = 100
"""Most elements around an element, with those through which it is used."""
WIDE, HIGH = (
    frozenset({"x", "x1", "x2", "cx", "rx", "width"}),
    frozenset({"y", "y1", "y2", "cy", "ry", "height"}),
)
"""Attributes whose percentages are of the viewport's width, or of its height."""
LENGTHS = WIDE | HIGH | {"r", "stroke-width"}
DEFAULT_SIZE = (1000.0, 1000.0)
"""The viewport of an SVG that states none; only percentages depend on it."""
FONT_SIZE = 16.0
"""The unit em."""
REFERENCE = re.compile(r"""url\(\s*['"]?#([^'")]+)""")


class Drawn(NamedTuple):
    """A shape of the document.

    Attributes
    ----------
    tag : str
    attributes : dict
        The shape's own attributes; lengths are numbers in units of its coordinate system.
    style : dict
        Properties by name, with the inherited ones.
    matrix : (3, 2) array
        From (x, y, 1) in its coordinates to those of the document.
    clips : tuple of lists of Drawn
        Only what lies in each of these areas is visible.
    """

    tag: str
    attributes: dict[str, str]
    style: dict[str, str]
    matrix: Array
    clips: tuple[list[Drawn], ...]


class _Around(NamedTuple):
    """What the elements around an element say about it."""

    style: dict[str, str]
    matrix: Array
    size: tuple[float, float]
    clips: tuple[list[Drawn], ...]
    elements: tuple[int, ...]


def drawn_shapes(source: str) -> list[Drawn]:
    """The visible shapes of an SVG.

    Raises
    ------
    OverlapError
        The source declares entities, cannot be parsed, or uses itself; or it is too large when
        everything that it uses is expanded.
    """
    if "<!ENTITY" in source:
        raise OverlapError("The SVG declares entities, which are not read; remove <!ENTITY …>.")
    try:
        # The declaration names the encoding of the file, which has been decoded.
        parser = ElementTree.XMLParser(encoding="utf-8")
        root = ElementTree.fromstring(source.encode(), parser)
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        raise OverlapError(f"The SVG cannot be parsed: {error}.") from None
    box = _view_box(root.attrib)
    size = (box[2], box[3]) if box else DEFAULT_SIZE
    return list(_Document(root).walk(root, _Around({}, np.eye(3, 2), size, (), ())))


class _Document:
    def __init__(self, root: ElementTree.Element) -> None:
        self.root, self.visited = root, 0
        # Of several elements with one id, the first counts.
        self.named = {element.get("id"): element for element in reversed(list(root.iter()))}
        self.styles = Styles(root)

    def walk(self, element: ElementTree.Element, around: _Around) -> Iterator[Drawn]:
        """The shapes of an element, and of the elements in it."""
        self._count(element, around)
        tag, own = tag_of(element), self._stated(element, around.size)
        if tag not in SHAPES | GROUPS or own.get("display") == "none":
            return
        if number(own.get("opacity"), 1.0) <= 0:
            return
        around = around._replace(
            style=around.style | {name: own[name] for name in INHERITED & own.keys()},
            matrix=_placed(around.matrix, own.get("transform")),
            elements=(*around.elements, id(element)),
        )
        around = self._clipped(own, around)
        if tag == "ellipse":
            # One radius stands for both.
            own = {"rx": own.get("ry", "0"), "ry": own.get("rx", "0"), **own}
        if tag in SHAPES:
            if around.style.get("visibility", "visible") == "visible" and _has_size(tag, own):
                style = around.style | {"vector-effect": own.get("vector-effect", "none")}
                yield Drawn(tag, own, style, around.matrix, around.clips)
            return
        if tag == "use":
            yield from self._used(own, around)
            return
        if tag == "svg":
            inner = _viewport(own, around, outermost=element is self.root)
            if inner is None:
                return
            around = inner
        children = list(element)
        if tag == "switch":
            children = list(filter(_is_chosen, children))[:1]
        for child in children:
            yield from self.walk(child, around)

    def _used(self, own: dict[str, str], around: _Around) -> Iterator[Drawn]:
        """The shapes of the element that a ``use`` refers to."""
        names = [value for key, value in own.items() if key.rpartition("}")[2] == "href"]
        used = self.named.get(names[0].strip()[1:]) if names and names[0][:1] == "#" else None
        if used is None:
            return
        x, y = own.get("x", "0"), own.get("y", "0")
        around = around._replace(matrix=_placed(around.matrix, f"translate({x}, {y})"))
        tag = tag_of(used)
        if tag not in ("symbol", "svg"):
            yield from self.walk(used, around)
            return
        self._count(used, around)
        # A symbol is a group with a viewport, whose size the use may state.
        stated = self._stated(used, around.size)
        stated |= {name: value for name, value in own.items() if name in ("width", "height")}
        style = around.style | {name: stated[name] for name in INHERITED & stated.keys()}
        around = around._replace(style=style, elements=(*around.elements, id(used)))
        inner = _viewport(stated, around)
        if inner is not None:
            for child in used:
                yield from self.walk(child, inner)

    def _clipped(self, own: dict[str, str], around: _Around) -> _Around:
        """What is around an element, with its clip path if it has one."""
        found = REFERENCE.match(own.get("clip-path", ""))
        clip = self.named.get(found[1]) if found else None
        if clip is None or tag_of(clip) != "clipPath":
            return around
        if clip.get("clipPathUnits") == "objectBoundingBox":
            return around
        self._count(clip, around)
        stated = self._stated(clip, around.size)
        inside = around._replace(
            style={name: stated[name] for name in INHERITED & stated.keys()},
            matrix=_placed(around.matrix, stated.get("transform")),
            clips=(),
            elements=(*around.elements, id(clip)),
        )
        inside = self._clipped(stated, inside)
        shapes = [shape for child in clip for shape in self.walk(child, inside)]
        return around._replace(clips=(*around.clips, shapes))

    def _count(self, element: ElementTree.Element, around: _Around) -> None:
        """Refuse what could grow without limit when it is expanded."""
        self.visited += 1
        if id(element) in around.elements:
            raise OverlapError("The SVG uses itself: a <use> refers to an element around it.")
        if len(around.elements) > DEPTH:
            raise OverlapError(f"The SVG is nested more than {DEPTH} levels deep; simplify it.")
        if self.visited > limits.svg_elements:
            raise OverlapError(
                f"Of an SVG, at most {limits.svg_elements:,} elements are read after every <use> "
                "is expanded, and this one has more; simplify it or raise vf.limits.svg_elements."
            )

    def _stated(self, element: ElementTree.Element, size: tuple[float, float]) -> dict[str, str]:
        """The attributes and properties of an element, with lengths as numbers."""
        own = self.styles.stated(element)
        lengths = {name: _length(name, own[name], size) for name in LENGTHS & own.keys()}
        own = {name: value for name, value in own.items() if name not in lengths}
        return own | {name: repr(value) for name, value in lengths.items() if value is not None}


def _is_chosen(element: ElementTree.Element) -> bool:
    """Whether a ``switch`` may draw an element."""
    language = element.get("systemLanguage")
    return (
        tag_of(element) in SHAPES | GROUPS
        and not element.get("requiredExtensions")
        and (language is None or "en" in re.split(r"[\s,-]+", language))
    )


def _viewport(own: dict[str, str], around: _Around, outermost: bool = False) -> _Around | None:
    """What is around the content of an element that has a size and may have a view box.

    None if it has no area, so that nothing is drawn.
    """
    from svgelements import Viewbox

    box = _view_box(own)
    x, y = (0.0, 0.0) if outermost else (number(own.get(name), 0.0) for name in ("x", "y"))
    sides = [number(own[name], -1.0) if name in own else None for name in ("width", "height")]
    whole = around.size
    if outermost and box:
        # The missing side follows from the proportions of the view box.
        ratio = box[2] / box[3]
        whole = (ratio * (sides[1] or whole[1]), (sides[0] or whole[0]) / ratio)
    width, height = (
        default if side is None else side for side, default in zip(sides, whole, strict=True)
    )
    if width <= 0 or height <= 0:
        return None
    clips = around.clips
    if not outermost and own.get("overflow", "hidden") not in ("visible", "auto"):
        form = {"x": x, "y": y, "width": width, "height": height}
        edge = Drawn("rect", {k: repr(v) for k, v in form.items()}, {}, around.matrix, ())
        clips = (*clips, [edge])
    if box:
        fit = Viewbox.viewbox_transform(x, y, width, height, *box, own.get("preserveAspectRatio"))
    else:
        fit = f"translate({x!r}, {y!r})"
    size = (box[2], box[3]) if box else (width, height)
    return around._replace(matrix=_placed(around.matrix, fit), size=size, clips=clips)


def _placed(matrix: Array, transform: str | None) -> Array:
    """A matrix (3, 2), with a further transform of the content."""
    from svgelements import Matrix

    if not transform or transform == "none":
        return matrix
    if len(transform) > LONG:
        raise OverlapError(f"A transform has {len(transform):,} characters; simplify the SVG.")
    try:
        own = Matrix(transform)
        own.render(ppi=96.0)
        numbers = [float(value) for value in (own.a, own.b, own.c, own.d, own.e, own.f)]
    except Exception as error:
        raise OverlapError(f"The transform {transform!r:.100} cannot be read: {error}.") from None
    inner = np.column_stack([np.reshape(numbers, (3, 2)), [0.0, 0.0, 1.0]])
    return np.asarray(inner @ matrix)


def _view_box(own: Mapping[str, str]) -> list[float] | None:
    """Left, top, width and height of a view box that has an area."""
    parts = re.split(r"[\s,]+", own.get("viewBox", "").strip())
    numbers = [number(part, math.nan) for part in parts]
    return numbers if len(numbers) == 4 and min(numbers[2:]) > 0 else None


def _has_size(tag: str, own: dict[str, str]) -> bool:
    """Whether a shape has no side or radius that must be above 0 and is not."""
    needed = {"rect": ("width", "height"), "circle": ("r",), "ellipse": ("rx", "ry")}.get(tag, ())
    return all(number(own.get(name), 0.0) > 0 for name in needed)


def number(value: str | None, default: float) -> float:
    """A finite number, or a percentage as a part of 1; otherwise the default."""
    try:
        text = (value or "").strip()
        number = float(text.removesuffix("%")) / (100 if text.endswith("%") else 1)
    except ValueError:
        return default
    return number if math.isfinite(number) else default


def _length(name: str, value: str, size: tuple[float, float]) -> float | None:
    """A length in units of the coordinate system; None for a word such as ``auto``."""
    from svgelements import Length

    if not re.match(r"[+-]?\.?\d", value.strip()):
        return None
    width, height = size
    whole = (
        width if name in WIDE else height if name in HIGH else math.hypot(width, height) / 2**0.5
    )
    length = Length(value.strip()).value(
        ppi=96.0, relative_length=whole, font_size=FONT_SIZE, font_height=FONT_SIZE / 2
    )
    return float(length)
