"""Artwork from SVG: filled and stroked shapes as closed outlines in font units."""

from __future__ import annotations

import io
import math
import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np

from ..arrays import Array
from ..errors import OverlapError
from ..limits import limits
from ..outline.arrangement import nonzero
from ..outline.union import odd, without_overlaps
from .shape import LARGEST, polygon

STEPS = 8
"""Straight steps that replace a curve in the outline of a stroke."""
STROKED = 8
"""Curves around a straight side of a stroke: those of a strip, and of a disc at the corner."""
ROUND = 4 / 3 * math.tan(math.pi / 8)
"""Length of the handles of a quarter circle of radius 1."""


class Painted(NamedTuple):
    """An area that is filled by one rule: even-odd or nonzero."""

    contours: list[Array]
    even_odd: bool


class Artwork:
    """Shapes around which letters make room.

    Fills, strokes (as areas of their width, with round corners), transforms, groups and ``use``
    are read. Text, images, scripts and styles from outside are ignored, and nothing is fetched.

    Parameters
    ----------
    svg : str, bytes, path or file
        SVG source text, the path of a file, or an open file.
    scale : float
        Font units per SVG unit. Default 1.
    position : (x, y)
        Where the origin of the SVG lies, in font units. Default (0, 0). The y axis of the SVG
        points down, that of a text points up.

    Attributes
    ----------
    contours : list of (s, 4, 2) arrays
        Closed contours in font units, without overlaps, to be filled nonzero.

    Raises
    ------
    OverlapError
        The SVG cannot be parsed or draws nothing, is too large or too dense, or declares entities.

    Examples
    --------
    >>> import vfwidget as vf
    >>> svg = '<svg xmlns="http://www.w3.org/2000/svg"><rect width="9" height="2"/></svg>'
    >>> vf.Artwork(svg).box.tolist()
    [[0.0, -2.0], [9.0, 0.0]]
    """

    def __init__(self, svg: Any, scale: float = 1.0, position: Any = (0.0, 0.0)) -> None:
        placement = _placement(scale, position)
        source = _source(svg)
        _check(source)
        with np.errstate(all="ignore"):
            elements = [(element, _subpaths(element)) for element in _elements(source)]
            _check_size([s for _, subpaths in elements for s, _ in subpaths], placement)
        _check_curves(sum(_least_curves(*element) for element in elements))
        areas = [area for element in elements for area in _areas(*element)]
        _check_curves(sum(len(contour) for area in areas for contour in area.contours))
        if not areas:
            raise OverlapError("The SVG draws nothing; it needs shapes with a fill or a stroke.")
        contours = _filled(areas, placement)
        if len(areas) > 1:
            contours = _filled([Painted(contours, False)])
        self.contours = contours

    @property
    def box(self) -> Array:
        """Lower left and upper right corner of the box around all control points, (2, 2)."""
        points = np.concatenate(self.contours).reshape(-1, 2)
        return np.stack([points.min(0), points.max(0)])

    def moved(self, x: float, y: float) -> Artwork:
        """The same artwork elsewhere, by a displacement in font units."""
        return self._like(_placement(1.0, (x, y))[1], 1.0)

    def scaled(self, factor: float) -> Artwork:
        """The same artwork, larger or smaller by a factor > 0 around the origin of the text."""
        return self._like(np.zeros(2), _placement(factor, (0, 0))[0][0])

    def _like(self, shift: Array, factor: float) -> Artwork:
        other = object.__new__(Artwork)
        with np.errstate(over="ignore"):
            other.contours = [factor * contour + shift for contour in self.contours]
            _check_size(other.contours, (np.ones(2), np.zeros(2)))
        return other

    def __repr__(self) -> str:
        (left, bottom), (right, top) = self.box
        return f"<Artwork of {len(self.contours)} contours, {right - left:g} × {top - bottom:g}>"


def _placement(scale: Any, position: Any) -> tuple[Array, Array]:
    """The factor of x and y, and the shift."""
    try:
        factor, shift = float(scale), np.array([float(value) for value in position])
    except (TypeError, ValueError, RuntimeError, OverflowError):
        factor, shift = math.nan, np.zeros(2)
    if not (math.isfinite(factor) and factor > 0 and shift.shape == (2,)) or not (
        np.isfinite(shift).all()
    ):
        raise OverlapError(
            f"scale must be a number > 0 and position a pair of numbers; got {scale!r} and "
            f"{position!r}."
        )
    return np.array([factor, -factor]), shift


def _source(svg: Any) -> str:
    """The SVG's source text."""
    if isinstance(svg, str) and "<" not in svg:
        svg = Path(svg)
    if isinstance(svg, os.PathLike):
        try:
            if not os.path.isfile(svg):
                raise OSError("it is not a file")
            if os.path.getsize(svg) > limits.svg_bytes:
                raise OverlapError(_too_large(f"The file {svg}"))
            svg = Path(svg).read_bytes()
        except OSError as error:
            raise OverlapError(f"{os.fspath(svg)!r} cannot be read ({error}).") from None
    if hasattr(svg, "read"):
        svg = svg.read(limits.svg_bytes + 1)
    if isinstance(svg, bytes):
        svg = svg.decode("utf-8", "replace")
    if not isinstance(svg, str):
        raise OverlapError(f"svg must be SVG text, a path or a file; got {type(svg).__name__}.")
    if len(svg) > limits.svg_bytes:
        raise OverlapError(_too_large("The SVG"))
    return svg


def _too_large(what: str) -> str:
    return (
        f"{what} is larger than {limits.svg_bytes:,} bytes; simplify the artwork or raise "
        "vf.limits.svg_bytes."
    )


def _check(source: str) -> None:
    """Refuse what could grow without limit when it is expanded."""
    if "<!ENTITY" in source:
        raise OverlapError("The SVG declares entities, which are not read; remove <!ENTITY …>.")
    try:
        root = ElementTree.fromstring(source.encode())
    except ElementTree.ParseError as error:
        raise OverlapError(f"The SVG cannot be parsed: {error}.") from None
    named = {element.get("id"): element for element in root.iter() if element.get("id")}
    counts: dict[int, int] = {}
    open_elements: set[int] = set()

    def count(element: ElementTree.Element, depth: int) -> int:
        key = id(element)
        if key in open_elements:
            raise OverlapError("The SVG uses itself: a <use> refers to an element around it.")
        if depth > 100:
            raise OverlapError("The SVG is nested more than 100 levels deep; simplify it.")
        if key not in counts:
            open_elements.add(key)
            total = 1 + sum(count(child, depth + 1) for child in element)
            if element.tag.rpartition("}")[2] == "use":
                names = [v for k, v in element.items() if k.rpartition("}")[2] == "href"]
                used = [named[n[1:]] for n in names if n.startswith("#") and n[1:] in named]
                total += sum(count(other, depth + 1) for other in used)
            counts[key] = total
            open_elements.discard(key)
        return counts[key]

    expanded = count(root, 0)
    if expanded > limits.svg_elements:
        raise OverlapError(
            f"The SVG has {expanded:,} elements after every <use> is expanded, and at most "
            f"{limits.svg_elements:,} are read; simplify it or raise vf.limits.svg_elements."
        )


def _check_curves(curves: int) -> None:
    if curves > limits.svg_curves:
        raise OverlapError(
            f"The SVG has at least {curves:,} curves, with those around its strokes, and at most "
            f"{limits.svg_curves:,} are read; simplify it or raise vf.limits.svg_curves."
        )


def _check_size(curves: list[Array], placement: tuple[Array, Array]) -> None:
    """Refuse coordinates that are not finite, or with which areas lose all their digits."""
    placed = [abs(segments * placement[0] + placement[1]).max() for segments in curves]
    largest = max([0.0, *placed, *(abs(segments).max() for segments in curves)])
    if not (np.isfinite(placed).all() and largest <= LARGEST):
        raise OverlapError(
            f"The SVG has a coordinate of {largest:g}; coordinates must be finite and at most "
            f"{LARGEST:g}, in SVG units and in font units. Check its transforms and the scale."
        )


def _elements(source: str) -> list[Any]:
    """The visible shapes of an SVG; their transforms are not yet applied."""
    from svgelements import SVG, Shape

    try:
        document = SVG.parse(io.StringIO(source), reify=False)
        shapes = [element for element in document.elements() if isinstance(element, Shape)]
    except OverlapError:
        raise
    except Exception as error:
        raise OverlapError(f"The SVG cannot be read: {error}.") from None
    hidden = {"none", "hidden", "collapse"}
    return [
        shape
        for shape in shapes
        if shape.values.get("display") not in hidden
        and shape.values.get("visibility") not in hidden
    ]


def _areas(element: Any, subpaths: list[tuple[Array, bool]]) -> Iterator[Painted]:
    """The area that an element fills, and the one that it strokes."""
    if subpaths and element.fill is not None and element.fill.value is not None:
        even_odd = element.values.get("fill-rule") == "evenodd"
        yield Painted([_closed(segments) for segments, _ in subpaths], even_odd)
    width = _stroke_width(element)
    if width:
        bars = [bar for segments, closed in subpaths for bar in _stroked(segments, closed, width)]
        if bars:
            yield Painted(bars, False)


def _stroke_width(element: Any) -> float:
    """In units of the SVG; 0 where nothing is stroked."""
    if element.stroke is None or element.stroke.value is None:
        return 0.0
    return max(0.0, float(element.implicit_stroke_width or 0.0))


def _least_curves(element: Any, subpaths: list[tuple[Array, bool]]) -> int:
    """At least how many curves an element has, with those around its stroke."""
    curves = sum(len(segments) for segments, _ in subpaths)
    return curves * STROKED if _stroke_width(element) else curves


def _filled(areas: Sequence[Painted], placement: Any = (1.0, 0.0)) -> list[Array]:
    """The boundary of each area, placed, as contours without overlaps."""
    factor, shift = placement
    contours = [contour * factor + shift for area in areas for contour in area.contours]
    curves = [sum(map(len, area.contours)) for area in areas]
    image = np.repeat(np.arange(len(areas)), curves)
    layer = np.repeat([int(area.even_odd) for area in areas], curves)
    sizes = [len(contour) for contour in contours]
    return without_overlaps(np.concatenate(contours), sizes, _by_rules, image, layer)


def _by_rules(winding: Any) -> Any:
    """Where winding numbers (1 or 2, N) are inside: the second ones by the even-odd rule."""
    return nonzero(winding) | odd(winding[-1:])


def _subpaths(element: Any) -> list[tuple[Array, bool]]:
    """The cubic segments (s, 4, 2) of each subpath, and whether it is closed."""
    from svgelements import Arc, Close, CubicBezier, Line, Move, QuadraticBezier

    found: list[tuple[list[Any], bool]] = []
    for part in element.segments(transformed=False):
        if isinstance(part, Move):
            found.append(([], False))
            continue
        pieces = part.as_cubic_curves() if isinstance(part, Arc) else [part]
        for piece in pieces:
            start, end = complex(piece.start), complex(piece.end)
            if isinstance(piece, CubicBezier):
                inner = [complex(piece.control1), complex(piece.control2)]
            elif isinstance(piece, QuadraticBezier):
                control = complex(piece.control)
                inner = [(start + 2 * control) / 3, (end + 2 * control) / 3]
            elif isinstance(piece, Line | Close):
                inner = [(2 * start + end) / 3, (start + 2 * end) / 3]
            found[-1][0].append([start, *inner, end])
        if isinstance(part, Close):
            found[-1] = (found[-1][0], True)
    m = element.transform
    linear, shift = np.array([[m.a, m.b], [m.c, m.d]], dtype=float), (float(m.e), float(m.f))
    return [
        (np.stack([np.real(segments), np.imag(segments)], -1) @ linear + shift, closed)
        for segments, closed in found
        if segments
    ]


def _closed(segments: Array) -> Array:
    """A contour that ends where it starts, by a straight side if necessary."""
    start, end = segments[-1, 3], segments[0, 0]
    if np.array_equal(start, end):
        return segments
    side = np.stack([start, (2 * start + end) / 3, (start + 2 * end) / 3, end])
    return np.concatenate([segments, side[None]])


def _stroked(segments: Array, closed: bool, width: float) -> list[Array]:
    """A stroke as contours of one direction: a strip along each segment, discs at the corners."""
    corners = segments[:, 0] if closed else segments[1:, 0]
    strips = [_strip(cubic, width / 2) for cubic in segments if np.ptp(cubic, 0).any()]
    return strips + [_disc(corner, width / 2) for corner in corners]


def _strip(cubic: Array, half: float) -> Array:
    """The strip along a cubic (4, 2), half a stroke's width to either side."""
    thirds = (2 * cubic[[0, 3]] + cubic[[3, 0]]) / 3
    t = np.linspace(0, 1, 2 if np.allclose(cubic[1:3], thirds) else STEPS + 1)[:, None]
    u = 1 - t
    middle = u**3 * cubic[0] + 3 * u * t * (u * cubic[1] + t * cubic[2]) + t**3 * cubic[3]
    sides = np.diff(cubic, axis=0)
    along = u * u * sides[0] + 2 * u * t * sides[1] + t * t * sides[2]
    # Where a handle has no length, the direction is that of the whole.
    along = np.where(along.any(1, keepdims=True), along, sides.sum(0))
    across = half * np.stack([along[:, 1], -along[:, 0]], 1)
    across /= np.maximum(np.hypot(*along.T), 1e-300)[:, None]
    return polygon(np.concatenate([middle + across, (middle - across)[::-1]]))


def _disc(centre: Array, radius: float) -> Array:
    out = radius * np.array([[1.0, 0], [0, 1], [-1, 0], [0, -1]])
    along = ROUND * np.roll(out, -1, 0)
    following = np.roll(out, -1, 0)
    return centre + np.stack([out, out + along, following + ROUND * out, following], 1)
