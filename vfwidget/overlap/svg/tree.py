"""The shapes that an SVG document draws, with their styles, transforms, clips and markers.

References are followed within the document only. What is never drawn by itself (definitions,
symbols, masks, metadata, elements of other languages) is left out.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from urllib.parse import unquote
from xml.etree import ElementTree

import numpy as np

from ...arrays import Array
from ...errors import OverlapError
from ...limits import limits
from .basic_shapes import FILLS, clip_of, shape_and_box
from .markers import Vertex, vertices
from .paint import without_server
from .parts import LENGTHS, Drawn, length, number
from .paths import path_of
from .shapes import Boxes
from .style import Styles, tag_of
from .told import REFERENCE, Told
from .transforms import STYLED, inside, scaled, shifted, turned, view_box
from .variables import Followed, Variables, replaced
from .viewport import PEN, Around, dashes, fonts_of, pen_of, placed_in, viewport

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
DEPTH = 100
"""Most elements around an element, with those through which it is used."""
SIZED = SHAPES | GROUPS | {"symbol", "marker", "clipPath"}
"""Elements whose lengths are read."""
DEFAULT_SIZE = (1000.0, 1000.0)
"""The viewport of an SVG that states none; only percentages depend on it."""
VIEW = re.compile(r"(?<=\d)v(w|h|min|max)$", re.IGNORECASE)
BOXES = frozenset({"fill-box", "content-box"})
"""Values of transform-box by which a transform is measured in the box of its element."""
SERVERS = frozenset({"linearGradient", "radialGradient", "pattern"})
"""Elements that a fill or a stroke may refer to."""


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
    box = view_box(root.attrib)
    size = (box[2], box[3]) if box and min(box[2:]) > 0 else DEFAULT_SIZE
    document = _Document(root)
    shapes = list(
        document.walk(root, Around({}, np.eye(3, 2), size, (), (), variables=document.variables))
    )
    document.told.tell(document.styles.unread)
    return shapes


class _Document:
    def __init__(self, root: ElementTree.Element) -> None:
        self.root, self.visited = root, 0
        # Of several elements with one id, the first counts.
        self.named = {element.get("id"): element for element in reversed(list(root.iter()))}
        self.styles, self.variables = Styles(root), Variables({}, None, Followed())
        self.told, self.boxes = Told(), Boxes()

    def walk(self, element: ElementTree.Element, around: Around) -> Iterator[Drawn]:
        """The shapes of an element, and of the elements in it."""
        self._count(element, around)
        around = self._with_variables(element, around)
        tag, own = tag_of(element), self._stated(element, around)
        if not _is_chosen(element) or own.get("display") == "none":
            return
        if number(own.get("opacity"), 1.0) <= 0:
            return
        outside = around.matrix
        around = around._replace(
            style=around.style | _passed_on(own),
            fonts=fonts_of(own, around, element is self.root),
            elements=(*around.elements, id(element)),
        )
        # The outermost element is transformed with its viewport.
        if element is not self.root:
            box = None
            if own.get("transform-box") in BOXES and any(name in own for name in STYLED.values()):
                box = self.boxes.of(list(self._content(element, tag, own, around)), outside)
            around = around._replace(matrix=placed_in(around, own, box))
        shapes = self._content(element, tag, own, around)
        # The clip path of an inner viewport is within it.
        outer = tag != "svg" or element is self.root
        yield from self._clipped(own, around, shapes) if outer else shapes
        self.told.look(_named(element), own)

    def _content(
        self, element: ElementTree.Element, tag: str, own: dict[str, str], around: Around
    ) -> Iterator[Drawn]:
        """The shapes of an element, without its clip path."""
        if tag == "ellipse":
            # One radius stands for both, also for one that is below 0.
            given = {n: own[n] for n in ("rx", "ry") if number(own.get(n), -1.0) >= 0}
            both = {"rx": given.get("ry", "0"), "ry": given.get("rx", "0")}
            own = {name: value for name, value in own.items() if name not in both} | both | given
        if tag in SHAPES:
            if around.style.get("visibility", "visible") == "visible" and _has_size(tag, own):
                effect = {"vector-effect": own.get("vector-effect", "none")}
                style = around.style | pen_of(around) | effect
                yield Drawn(tag, own, style, around.matrix, around.clips)
                if tag in MARKED:
                    yield from self._markers(tag, own, around)
            return
        if tag == "use":
            yield from self._used(own, around)
            return
        if tag == "svg":
            root = element is self.root
            fixed = root and self._has_fixed_size()
            inner = viewport(own, around, outermost=root, clipped=fixed or not root)
            if inner is None:
                return
            around = inner
        children = list(element)
        if tag == "switch":
            children = list(filter(_is_chosen, children))[:1]
        shapes = (shape for child in children for shape in self.walk(child, around))
        inside = tag == "svg" and element is not self.root
        yield from self._clipped(own, around, shapes) if inside else shapes

    def _has_fixed_size(self) -> bool:
        """Whether the document states a size that does not depend on its window."""
        own = self.styles.stated(self.root)
        sides = [own.get(name, "auto").strip() for name in ("width", "height")]
        return not any(side == "auto" or "%" in side or VIEW.search(side) for side in sides)

    def _markers(self, tag: str, own: dict[str, str], around: Around) -> Iterator[Drawn]:
        """The shapes of the markers at the vertices of a shape."""
        markers = {
            kind: marker
            for kind in ("start", "mid", "end")
            if (marker := self._referred(around.style.get(f"marker-{kind}"), "marker")) is not None
        }
        if not markers:
            return
        for vertex in vertices(path_of(tag, own)):
            if vertex.kind in markers:
                yield from self._marker(markers[vertex.kind], vertex, around)

    def _marker(
        self, marker: ElementTree.Element, vertex: Vertex, around: Around
    ) -> Iterator[Drawn]:
        """The shapes of a marker at a vertex."""
        self._count(marker, around)
        style, variables = self._inherited(marker)
        around = around._replace(variables=variables)
        stated = self._stated(marker, around)
        width, height = (number(stated.get(f"marker{side}"), 3.0) for side in ("Width", "Height"))
        by_stroke = stated.get("markerUnits", "strokeWidth") != "userSpaceOnUse"
        scale = number(pen_of(around).get("stroke-width"), 1.0) if by_stroke else 1.0
        if min(width, height, scale) <= 0:
            return
        orient = stated.get("orient", "0").strip()
        turn = (
            vertex.angle if orient.startswith("auto") else number(orient.removesuffix("deg"), 0.0)
        )
        if orient == "auto-start-reverse" and vertex.kind == "start":
            turn += 180.0
        x, y = vertex.place.tolist()
        placed = inside(inside(shifted(x, y), turned(turn)), scaled(scale, scale))
        matrix = inside(around.matrix, placed)
        size = {"width": repr(width), "height": repr(height)}
        own = {name: value for name, value in stated.items() if name not in ("x", "y")} | size
        own.setdefault("overflow", "hidden")
        # The reference point is in coordinates of the view box, and lies at the vertex.
        plain = viewport(own, around._replace(matrix=np.eye(3, 2), clips=()))
        if plain is None:
            return
        reference = [number(stated.get(name), 0.0) for name in ("refX", "refY")]
        left, top = np.array([*reference, 1.0]) @ plain.matrix
        within = around._replace(
            style=style,
            matrix=inside(matrix, shifted(-float(left), -float(top))),
            elements=(*around.elements, id(marker)),
        )
        inner = viewport(own, within)
        if inner is not None:
            for child in marker:
                for shape in self.walk(child, inner):
                    yield shape._replace(of_marker=True)

    def _inherited(self, element: ElementTree.Element) -> tuple[dict[str, str], Variables]:
        """The inherited properties in an element that is drawn where others refer to it."""
        style, variables = dict[str, str](), self.variables
        for one in self.styles.path(element):
            stated = self.styles.stated(one)
            variables = variables.within(stated)
            style |= _passed_on(replaced(stated, variables))
        return style, variables

    def _with_variables(self, element: ElementTree.Element, around: Around) -> Around:
        """What is around an element, with the custom properties that it states."""
        stated = self.styles.stated(element, around.top)
        return around._replace(variables=around.variables.within(stated))

    def _referred(self, value: str | None, tag: str) -> ElementTree.Element | None:
        """The element of the document with this tag to which a property refers."""
        found = REFERENCE.match(value or "")
        element = self.named.get(found[1]) if found else None
        return element if element is not None and tag_of(element) == tag else None

    def _used(self, own: dict[str, str], around: Around) -> Iterator[Drawn]:
        """The shapes of the element that a ``use`` refers to."""
        used = self._by_reference(own)
        if used is None:
            return
        x, y = (number(own.get(name), 0.0) for name in ("x", "y"))
        around = around._replace(matrix=inside(around.matrix, shifted(x, y)), top=used)
        tag = tag_of(used)
        if tag not in ("symbol", "svg"):
            yield from self.walk(used, around)
            return
        self._count(used, around)
        around = self._with_variables(used, around)
        # A symbol is a group with a viewport, whose size the use may state.
        stated = self._stated(used, around)
        stated |= {name: value for name, value in own.items() if name in ("width", "height")}
        style = around.style | _passed_on(stated)
        elements = (*around.elements, id(used))
        around = around._replace(style=style, elements=elements, matrix=placed_in(around, stated))
        inner = viewport(stated, around)
        if inner is not None:
            shapes = (shape for child in used for shape in self.walk(child, inner))
            yield from self._clipped(stated, inner, shapes)

    def _by_reference(self, own: Mapping[str, str]) -> ElementTree.Element | None:
        """The element that a ``use`` refers to."""
        names = {key.rpartition("}")[0]: key for key in own if key.rpartition("}")[2] == "href"}
        # The plain attribute counts more than that of XLink.
        name = own[names[min(names)]].strip() if names else ""
        if not name.startswith("#"):
            return None
        return self.named.get(name[1:], self.named.get(unquote(name[1:])))

    def _clipped(
        self, own: dict[str, str], around: Around, shapes: Iterable[Drawn]
    ) -> Iterable[Drawn]:
        """The shapes of an element within its clip path, if it has one."""
        clip = self._referred(own.get("clip-path"), "clipPath")
        if clip is None:
            found = shape_and_box(own.get("clip-path", ""))
            if found is not None and len(around.elements) == 1:
                # The outermost element is a box of CSS.
                self.told.drop("the outermost <svg>", [f"clip-path: {own['clip-path']:.80}"])
                found = None
            return shapes if found is None else self._within(*found, around, list(shapes))
        shapes = list(shapes)
        self._count(clip, around)
        around = around._replace(variables=self._inherited(clip)[1])
        stated = self._stated(clip, around)
        matrix = placed_in(around, stated)
        if stated.get("clipPathUnits") == "objectBoundingBox":
            box = self.boxes.of(shapes, around.matrix)
            if box is None:
                return []
            matrix = inside(matrix, np.stack([*np.diag(box[1] - box[0]), box[0]]))
        within = around._replace(
            style=_passed_on(stated),
            matrix=matrix,
            clips=(),
            elements=(*around.elements, id(clip)),
        )
        children = filter(self._is_of_clip, clip)
        area = [shape for child in children for shape in self.walk(child, within)]
        area = [shape for shape in area if not shape.of_marker]
        if self._referred(stated.get("clip-path"), "clipPath") is None:
            # A shape of CSS is measured in the box of what is clipped.
            shapes = list(self._clipped(stated, around, shapes))
        else:
            area = list(self._clipped(stated, within, area))
        return [shape._replace(clips=(*shape.clips, area)) for shape in shapes]

    def _within(
        self, name: str, arguments: str, form: str, around: Around, shapes: list[Drawn]
    ) -> list[Drawn]:
        """The shapes of an element within a shape of CSS."""
        box: Array | None = np.array([(0.0, 0.0), around.size])
        if form != "view-box":
            box = self.boxes.of(shapes, around.matrix, strokes=form not in FILLS)
        if box is None:
            return []
        clip = clip_of(name, arguments, box, around.matrix, around.fonts)
        area = [clip] if clip is not None else []
        return [shape._replace(clips=(*shape.clips, area)) for shape in shapes]

    def _count(self, element: ElementTree.Element, around: Around) -> None:
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

    def _is_of_clip(self, element: ElementTree.Element) -> bool:
        """Whether an element may be in a clip path: a shape, by itself or by reference."""
        used: ElementTree.Element | None = element
        if tag_of(element) == "use":
            used = self._by_reference(self.styles.stated(element))
        return used is not None and tag_of(used) in SHAPES

    def _stated(self, element: ElementTree.Element, around: Around) -> dict[str, str]:
        """The attributes and properties of an element, with lengths as numbers."""
        own = replaced(self.styles.stated(element, around.top), around.variables)
        if tag_of(element) not in SIZED:
            return own
        self.told.drop(_named(element), self.styles.dropped.get(element, ()))
        size, fonts = around.size, fonts_of(own, around, element is self.root)
        found = dict[str, str]()
        for name, value in own.items():
            if name in PEN and "%" in value:
                found[name] = value  # Of the viewport of the shape that inherits it.
            elif name in LENGTHS:
                number = length(name, _by_view(value, element is self.root), size, fonts)
                found |= {} if number is None else {name: repr(number)}
            elif name == "stroke-dasharray":
                found[name] = dashes(value, size, fonts)
            elif name in ("fill", "stroke"):
                found[name] = without_server(value, self._is_server(value))
            else:
                found[name] = value
        return found

    def _is_server(self, paint: str) -> bool:
        """Whether a paint refers to a gradient with a stop, or to a pattern."""
        found = REFERENCE.match(paint)
        element = self.named.get(found[1].strip()) if found else None
        if element is None or tag_of(element) not in SERVERS:
            return False
        return len(element) > 0 or any(name.rpartition("}")[2] == "href" for name in element.attrib)


def _passed_on(own: Mapping[str, str]) -> dict[str, str]:
    """The properties of an element that those in it inherit."""
    return {name: own[name] for name in INHERITED & own.keys()}


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


def _has_size(tag: str, own: dict[str, str]) -> bool:
    """Whether a shape has no side or radius that must be above 0 and is not."""
    needed = {"rect": ("width", "height"), "circle": ("r",), "ellipse": ("rx", "ry")}.get(tag, ())
    return all(number(own.get(name), 0.0) > 0 for name in needed)
