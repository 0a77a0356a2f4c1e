"""Artwork from SVG: filled and stroked shapes as closed outlines in font units."""

from __future__ import annotations

import codecs
import math
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import Array
from ..errors import OverlapError
from ..limits import limits
from ..outline.arrangement import in_both, nonzero
from ..outline.cubics import AREA
from ..outline.union import odd, without_overlaps
from .shape import LARGEST
from .svg.parts import Drawn
from .svg.shapes import Outline, Painted, areas, check_curves, filled, outlines
from .svg.tree import drawn_shapes

THINNEST = 1e-9
"""A contour is a line if its area is below this, by the square of its length."""


class Artwork:
    """The shapes of an SVG, as an obstacle that letters avoid.

    Fills, strokes (as areas of their width, with their joins, caps and dashes), transforms, groups,
    symbols, ``use``, clip paths (also shapes such as ``circle(40%)``), markers, and style sheets
    within the file are read. Transforms may be attributes, or the properties ``transform``,
    ``translate``, ``rotate`` and ``scale`` in the plane. Lengths may be computed by ``calc()``,
    ``min()``, ``max()`` and ``clamp()``, and values may refer to custom properties by ``var()``.
    Selectors may state where an element is among others, as in
    ``g > rect + rect:not(:last-child)``. What lies outside the document's width and height is cut
    off, if both are stated. Text, images and scripts are ignored, and nothing is fetched. Masks and
    filters have no outline, so they are ignored as well: a shape with a mask counts as a whole.

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
        The SVG cannot be parsed or draws nothing, is too large or too dense, declares entities, or
        states a length that depends on the window that shows it.

    Warns
    -----
    OverlapWarning
        An element has a mask, a filter, or another property that changes what is seen and is not
        read; a length, a transform or a clip path cannot be read, and is ignored as browsers do it;
        or a rule of a style sheet has a selector that is not read. The message names it.

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
        with np.errstate(all="ignore"):
            contours = _visible(drawn_shapes(source), placement)
        if not contours:
            raise OverlapError("The SVG draws nothing; it needs shapes with a fill or a stroke.")
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
        count = len(self.contours)
        contours = f"{count} contour{'' if count == 1 else 's'}"
        return f"<Artwork of {contours}, {right - left:g} × {top - bottom:g}>"


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
            f"scale must be a number > 0 and position a pair of numbers; received {scale!r} and "
            f"{position!r}."
        )
    return np.array([factor, -factor]), shift


def _source(svg: Any) -> str:
    """The SVG's source text."""
    if isinstance(svg, str) and not svg.strip():
        raise OverlapError("The text of the SVG is empty; pass SVG text, a path or a file.")
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
        try:
            svg = svg.read(limits.svg_bytes + 1)
        except (OSError, ValueError) as error:
            raise OverlapError(f"The file of the SVG cannot be read ({error}).") from None
    if isinstance(svg, bytes):
        wide = svg.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
        svg = svg.decode("utf-16" if wide else "utf-8", "replace")
    if not isinstance(svg, str):
        raise OverlapError(
            f"svg must be SVG text, a path or a file; received {type(svg).__name__}."
        )
    if len(svg) > limits.svg_bytes:
        raise OverlapError(_too_large("The SVG"))
    return svg


def _too_large(what: str) -> str:
    return (
        f"{what} is larger than {limits.svg_bytes:,} bytes; simplify the artwork or raise "
        "vf.limits.svg_bytes."
    )


def _check_size(curves: list[Array], placement: tuple[Array, Array]) -> None:
    """Refuse coordinates that are not finite, or with which areas lose all their digits."""
    placed = [abs(segments * placement[0] + placement[1]).max() for segments in curves]
    # The largest one is NaN if any of them is; the product of infinity and zero is.
    largest = float(np.max([0.0, *placed, *(abs(segments).max() for segments in curves)]))
    if not largest <= LARGEST:
        size = "inf" if math.isnan(largest) else f"{largest:g}"
        raise OverlapError(
            f"The SVG has a coordinate of {size}; coordinates must be finite and at most "
            f"{LARGEST:g}, in SVG units and in font units. Check its transforms and the scale."
        )


def _visible(shapes: Sequence[Drawn], placement: tuple[Array, Array]) -> list[Array]:
    """The boundary of all that the shapes paint, placed, as contours without overlaps."""
    clips = {id(clip): clip for shape in shapes for clip in shape.clips}
    read = _read(shapes, placement)
    groups: dict[tuple[int, ...], list[Painted]] = {}
    curves, count = list[Array](), 0
    for shape, path in read:
        painted = list(areas(shape, path))
        groups.setdefault(tuple(map(id, shape.clips)), []).extend(painted)
        added = [contour for area in painted for contour in area.contours]
        curves += added
        count += sum(map(len, added))
        check_curves(count)
    _check_size(curves, placement)
    windows: dict[int, list[Array]] = {}
    found = []
    for keys, painted in groups.items():
        contours = _joined(painted, placement)
        for key in keys:
            if key not in windows:
                windows[key] = _window(clips[key], placement)
            if not _covers(windows[key], contours):
                contours = _common(contours, windows[key])
        found.append(contours)
    parts = [Painted(contours, False) for contours in found if contours]
    contours = parts[0].contours if len(parts) == 1 else _joined(parts)
    return [contour for contour in contours if _encloses(contour)]


def _encloses(contour: Array) -> bool:
    """Whether a contour (s, 4, 2) encloses an area; the outline of a line does not."""
    x, y = np.moveaxis(contour - contour[0, 0], -1, 0)
    area = abs(np.einsum("si,ij,sj", x, AREA, y))
    return bool(area > THINNEST * np.ptp(contour, (0, 1)).max() ** 2)


def _read(shapes: Sequence[Drawn], placement: Any) -> list[tuple[Drawn, Outline]]:
    """Shapes with their paths, whose size has been checked."""
    paths = outlines(shapes)
    _check_size([path.placed(s) for path in paths for s, _ in path.subpaths], placement)
    return list(zip(shapes, paths, strict=True))


def _window(clip: Sequence[Drawn], placement: tuple[Array, Array]) -> list[Array]:
    """The area of a clip path, placed, as contours without overlaps."""
    found = []
    for shape, path in _read(clip, placement):
        contours = _joined([filled(path, shape.style.get("clip-rule"))], placement)
        for inner in shape.clips:
            contours = _common(contours, _window(inner, placement))
        found.append(Painted(contours, False))
    return _joined(found)


def _joined(areas: Sequence[Painted], placement: Any = (1.0, 0.0)) -> list[Array]:
    """The boundary of several areas, placed, as contours without overlaps."""
    areas = [area for area in areas if area.contours]
    if not areas:
        return []
    contours = _filled(areas, placement)
    return contours if len(areas) == 1 else _filled([Painted(contours, False)])


def _common(contours: list[Array], window: list[Array]) -> list[Array]:
    """The boundary of what lies in both of two areas."""
    if not contours or not window:
        return []
    curves = [*contours, *window]
    sizes = [len(contour) for contour in curves]
    layer = np.repeat([0] * len(contours) + [1] * len(window), sizes)
    return without_overlaps(np.concatenate(curves), sizes, in_both, layer=layer)


def _covers(window: list[Array], contours: list[Array]) -> bool:
    """Whether a window is an upright rectangle with all the contours in it."""
    if len(window) != 1 or not contours:
        return False
    corners, points = window[0].reshape(-1, 2), np.concatenate(contours).reshape(-1, 2)
    low, high = corners.min(0), corners.max(0)
    x, y = np.moveaxis(window[0] - low, -1, 0)
    area, box = abs(np.einsum("si,ij,sj", x, AREA, y)), (high - low).prod()
    return bool(abs(area - box) <= THINNEST * box and ((low <= points) & (points <= high)).all())


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
