"""The shapes that an SVG document draws, with their styles, transforms, clips and markers.

References are followed within the document only. What is never drawn by itself (definitions,
symbols, masks, metadata, elements of other languages) is left out.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np

from ..arrays import Array
from ..errors import OverlapError, OverlapWarning, warn_caller
from ..limits import limits
from .svg_markers import Vertex, vertices
from .svg_parts import HIGH, WIDE, Drawn, length, number
from .svg_shapes import GEOMETRY, box_of, path_of
from .svg_style import LONG, Styles, tag_of

SHAPES = frozenset({"path", "rect", "circle", "ellipse", "line", "polyline", "polygon"})
GROUPS = frozenset({"g", "a", "svg", "switch", "use"})
INHERITED = frozenset(
    "fill fill-opacity fill-rule clip-rule stroke stroke-opacity stroke-width stroke-linecap "
    "stroke-linejoin stroke-miterlimit stroke-dasharray stroke-dashoffset visibility color "
    "marker-start marker-mid marker-end".split()
)
"""Properties that an element has from the one around it unless it states its own."""
MARKED = frozenset({"path", "line", "polyline", "polygon"})
"""Shapes that may have markers at their vertices."""
IGNORED = ("mask", "filter")
"""Properties that change what is painted, but have no outline."""
DEPTH = 100
"""Most elements around an element, with those through which it is used."""
LENGTHS = WIDE | HIGH | {"r", "stroke-width"}
SIZED = SHAPES | GROUPS | {"symbol", "marker", "clipPath"}
"""Elements whose lengths are read."""
DEFAULT_SIZE = (1000.0, 1000.0)
"""The viewport of an SVG that states none; only percentages depend on it."""
VIEW = re.compile(r"(?<=\d)v(w|h|min|max)$", re.IGNORECASE)
REFERENCE = re.compile(r"""url\(\s*['"]?#([^'")]+)""")


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
    document = _Document(root)
    shapes = list(document.walk(root, _Around({}, np.eye(3, 2), size, (), ())))
    if document.ignored:
        warn_caller(
            f"Masks and filters have no outline and are ignored: {', '.join(document.ignored)}. "
            "The shapes count as a whole.",
            OverlapWarning,
        )
    return shapes


class _Document:
    def __init__(self, root: ElementTree.Element) -> None:
        self.root, self.visited = root, 0
        # Of several elements with one id, the first counts.
        self.named = {element.get("id"): element for element in reversed(list(root.iter()))}
        self.styles = Styles(root)
        self.ignored: dict[str, None] = {}
        """What is said about masks and filters of elements, in their order."""

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
        shapes = self._content(element, tag, own, around)
        yield from self._clipped(own, around, shapes)
        self.ignored |= dict.fromkeys(
            f"the {name} of {_named(element)}"
            for name in IGNORED
            if REFERENCE.match(own.get(name, "")) or (name == "filter" and "(" in own.get(name, ""))
        )

    def _content(
        self, element: ElementTree.Element, tag: str, own: dict[str, str], around: _Around
    ) -> Iterator[Drawn]:
        """The shapes of an element, without its clip path."""
        if tag == "ellipse":
            # One radius stands for both.
            own = {"rx": own.get("ry", "0"), "ry": own.get("rx", "0"), **own}
        if tag in SHAPES:
            if around.style.get("visibility", "visible") == "visible" and _has_size(tag, own):
                style = around.style | {"vector-effect": own.get("vector-effect", "none")}
                yield Drawn(tag, own, style, around.matrix, around.clips)
                if tag in MARKED:
                    yield from self._markers(tag, own, around)
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

    def _markers(self, tag: str, own: dict[str, str], around: _Around) -> Iterator[Drawn]:
        """The shapes of the markers at the vertices of a shape."""
        markers = {
            kind: marker
            for kind in ("start", "mid", "end")
            if (marker := self._referred(around.style.get(f"marker-{kind}"), "marker")) is not None
        }
        if not markers:
            return
        form = {name: own[name] for name in GEOMETRY & own.keys()}
        for vertex in vertices(path_of(tag, form)):
            if vertex.kind in markers:
                yield from self._marker(markers[vertex.kind], vertex, around)

    def _marker(
        self, marker: ElementTree.Element, vertex: Vertex, around: _Around
    ) -> Iterator[Drawn]:
        """The shapes of a marker at a vertex."""
        self._count(marker, around)
        stated = self._stated(marker, around.size)
        width, height = (number(stated.get(f"marker{side}"), 3.0) for side in ("Width", "Height"))
        by_stroke = stated.get("markerUnits", "strokeWidth") != "userSpaceOnUse"
        scale = number(around.style.get("stroke-width"), 1.0) if by_stroke else 1.0
        if min(width, height, scale) <= 0:
            return
        orient = stated.get("orient", "0").strip()
        turn = (
            vertex.angle if orient.startswith("auto") else number(orient.removesuffix("deg"), 0.0)
        )
        if orient == "auto-start-reverse" and vertex.kind == "start":
            turn += 180.0
        x, y = vertex.place.tolist()
        placed = f"translate({x!r}, {y!r}) rotate({turn!r}) scale({scale!r})"
        matrix = _placed(around.matrix, placed)
        size = {"width": repr(width), "height": repr(height)}
        own = {name: value for name, value in stated.items() if name not in ("x", "y")} | size
        own.setdefault("overflow", "hidden")
        # The reference point is in coordinates of the view box, and lies at the vertex.
        plain = _viewport(own, around._replace(matrix=np.eye(3, 2), clips=()))
        if plain is None:
            return
        reference = [number(stated.get(name), 0.0) for name in ("refX", "refY")]
        left, top = np.array([*reference, 1.0]) @ plain.matrix
        inside = around._replace(
            style=self._inherited(marker),
            matrix=_placed(matrix, f"translate({-float(left)!r}, {-float(top)!r})"),
            elements=(*around.elements, id(marker)),
        )
        inner = _viewport(own, inside)
        if inner is not None:
            for child in marker:
                for shape in self.walk(child, inner):
                    yield shape._replace(of_marker=True)

    def _inherited(self, element: ElementTree.Element) -> dict[str, str]:
        """The inherited properties in an element that is drawn where others refer to it."""
        style = dict[str, str]()
        for one in self.styles.path(element):
            own = self.styles.stated(one)
            style |= {name: own[name] for name in INHERITED & own.keys()}
        return style

    def _referred(self, value: str | None, tag: str) -> ElementTree.Element | None:
        """The element of the document with this tag to which a property refers."""
        found = REFERENCE.match(value or "")
        element = self.named.get(found[1]) if found else None
        return element if element is not None and tag_of(element) == tag else None

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

    def _clipped(
        self, own: dict[str, str], around: _Around, shapes: Iterable[Drawn]
    ) -> Iterable[Drawn]:
        """The shapes of an element within its clip path, if it has one."""
        clip = self._referred(own.get("clip-path"), "clipPath")
        if clip is None:
            return shapes
        shapes = list(shapes)
        self._count(clip, around)
        stated = self._stated(clip, around.size)
        matrix = _placed(around.matrix, stated.get("transform"))
        if stated.get("clipPathUnits") == "objectBoundingBox":
            box = box_of(shapes, around.matrix)
            if box is None:
                return []
            inner = np.column_stack([np.stack([*np.diag(box[1] - box[0]), box[0]]), [0, 0, 1]])
            matrix = inner @ matrix
        inside = around._replace(
            style={name: stated[name] for name in INHERITED & stated.keys()},
            matrix=matrix,
            clips=(),
            elements=(*around.elements, id(clip)),
        )
        area = [shape for child in clip for shape in self.walk(child, inside)]
        area = list(self._clipped(stated, inside, [s for s in area if not s.of_marker]))
        return [shape._replace(clips=(*shape.clips, area)) for shape in shapes]

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
        if tag_of(element) not in SIZED:
            return own
        lengths = {
            name: length(name, _by_view(own[name], element is self.root), size)
            for name in LENGTHS & own.keys()
        }
        own = {name: value for name, value in own.items() if name not in lengths}
        return own | {name: repr(value) for name, value in lengths.items() if value is not None}


def _by_view(value: str, outermost: bool) -> str:
    """A length, in which the units of the window are percentages for the outermost element."""
    return VIEW.sub("%", value.strip()) if outermost else value


def _named(element: ElementTree.Element) -> str:
    """An element in words."""
    name = element.get("id")
    return f"<{tag_of(element)} id={name!r:.80}>" if name else f"a <{tag_of(element)}>"


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
    except Exception:
        raise OverlapError(
            f"The transform {transform!r:.100} cannot be read; state it as in translate(3, 4)."
        ) from None
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
