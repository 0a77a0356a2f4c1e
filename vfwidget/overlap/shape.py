"""Closed outlines as arrays: letters of a text, and obstacles of every kind."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import Any

import numpy as np

from ..arrays import Array, IntArray, to_array
from ..errors import OverlapError
from ..outline.area import areas, slopes
from ..outline.arrangement import Spans, boundary
from ..outline.contours import Contours
from ..outline.cubics import chord
from ..outline.monotone import coefficients
from ..text import Text
from ..text.colours import as_drawn

CLOSED = 1e-6
"""Largest distance between the end of a contour and its start, relative to its size."""
LARGEST = 1e9
"""Coordinates beyond this, in font units, are refused: areas would lose all their digits."""
KEPT = 256
"""Texts whose indices of segments are kept, because they do not change while letters move."""
SHORTEST, SHORTEST_PART = 1e-6, 1e-9
"""Font units, and part of a segment: what is shorter than both is a crossing, not a part."""
LEAST_AREA = 1e-12
"""Areas below this, relative to the square of the largest coordinate, are rounding."""


class Shape:
    """Closed contours of cubic segments, filled nonzero.

    Parameters
    ----------
    segments : (S, 4, 2) array
        Contour after contour, in font units, y up.
    sizes : sequence of int
        Segments of each contour.
    """

    def __init__(self, segments: Array, sizes: Sequence[int]) -> None:
        self.segments, self.sizes = segments, Contours(sizes)

    @property
    def contours(self) -> list[Array]:
        """The segments of each contour, (s, 4, 2)."""
        return np.split(self.segments, np.cumsum(self.sizes)[:-1]) if self.sizes else []

    @cached_property
    def box(self) -> Array:
        """The box around all control points, (2, 2); an empty shape has an empty one."""
        if not self.sizes:
            return np.array([[np.inf, np.inf], [-np.inf, -np.inf]])
        points = self.segments.reshape(-1, 2)
        return np.array([points.min(0), points.max(0)])

    def union(self) -> Spans:
        """The parts of the segments that bound the shape."""
        curves = coefficients(self.segments)
        return with_length(boundary(curves, self.sizes), curves)

    def area(self) -> float:
        """The area inside, each point counted once."""
        if not self.sizes:
            return 0.0
        spans = self.union()
        middle = self.segments.mean((0, 1))
        return float(areas(coefficients(self.segments - middle), spans).sum())


def with_length(spans: Spans, curves: Array) -> Spans:
    """Spans of curves (4, 2, C); those without a length bound nothing.

    Where curves cross, rounding may leave such a span inside the shape.
    """
    length = spans.end - spans.start
    speed = abs(slopes(curves[..., spans.cubic])).sum((0, 1))
    short = (length <= SHORTEST_PART) & (speed * length <= SHORTEST)
    return spans._replace(weight=np.where(short, 0.0, spans.weight))


def letters(text: Text, points: Array | None = None) -> list[Shape]:
    """The letters of a text, one shape for each.

    Parameters
    ----------
    text : Text
    points : (K, 2) array, optional
        All control points of the text. Default: where the text stands.
    """
    if points is None:
        points = text.point_set().positions(text.place)
    segments = points.take(text.word.contours.segments, 0)
    sizes = tuple(glyph.contours for glyph in text.glyphs)
    bounds, starts = _bounds(sizes)
    shapes = [Shape(segments[a:b], own) for (a, b), own in zip(bounds, sizes, strict=True)]
    # The boxes of all letters are found together.
    filled = [shape for shape in shapes if shape.sizes]
    if filled:
        low, high = np.minimum.reduceat(points, starts), np.maximum.reduceat(points, starts)
        for shape, box in zip(filled, np.array([low, high]).swapaxes(0, 1), strict=True):
            shape.box = box
    return shapes


@lru_cache(KEPT)
def _bounds(sizes: tuple[Contours, ...]) -> tuple[list[tuple[int, int]], IntArray]:
    """The first segment of each letter and of the next one, and the first points of letters."""
    ends = np.cumsum([sum(contours) for contours in sizes]).tolist()
    bounds = list(pairwise([0, *ends]))
    return bounds, np.array([3 * a for a, b in bounds if a < b], dtype=np.intp)


def read_obstacles(obstacles: Any) -> list[Shape]:
    """Obstacles as shapes.

    Parameters
    ----------
    obstacles : obstacle, or sequence of obstacles
        A polygon (m, 2), a list of closed contours (s, 4, 2), a :class:`Text` or an
        :class:`~.artwork.Artwork`.

    Raises
    ------
    OverlapError
        An obstacle is none of these, or has no area, an open contour, or coordinates that are not
        finite or are enormous.
    """
    if isinstance(obstacles, Text) or hasattr(obstacles, "contours") or _dimensions(obstacles) == 2:
        obstacles = [obstacles]
    _refuse_names(obstacles, "obstacles")
    _refuse_iterator(obstacles, "obstacles")
    try:
        listed = list(obstacles)
    except TypeError:
        raise OverlapError(
            "obstacles must be a list of polygons, contours, texts or artwork; "
            f"received {obstacles!r}."
        ) from None
    if listed and all(not isinstance(one, Shape) and _dimensions(one) == 3 for one in listed):
        # One list of contours, such as those of a text.
        listed = [listed]
    return [
        # A shape has been checked when it was read.
        one if isinstance(one, Shape) else _checked(_read(one, f"obstacles[{i}]"), i)
        for i, one in enumerate(listed)
    ]


def _refuse_names(value: Any, name: str) -> None:
    """Refuse the source text or the path of an SVG, which :class:`Artwork` reads."""
    if isinstance(value, str | bytes | os.PathLike):
        raise OverlapError(
            f"{name} must consist of numbers, texts or artwork; received {value!r:.80}. Pass "
            "vf.Artwork(…) of an SVG."
        )


def _refuse_iterator(value: Any, name: str) -> None:
    """Refuse what can be read once only: the next computation would find no obstacles in it."""
    if isinstance(value, Iterator):
        raise OverlapError(
            f"{name} must be a list, which can be read several times; received a "
            f"{type(value).__name__}. Pass list(…) of it."
        )


def _read(obstacle: Any, name: str) -> Shape:
    if isinstance(obstacle, Text):
        contours = [to_array(segments) for segments in as_drawn(obstacle).segments()]
    elif hasattr(obstacle, "contours"):
        contours = list(obstacle.contours)
    elif _dimensions(obstacle) == 2:
        corners = _numbers(obstacle, name)
        if corners.shape[1:] != (2,) or len(corners) < 3:
            raise OverlapError(
                f"{name} has shape {corners.shape}; a polygon is (m, 2) with m ≥ 3 corners."
            )
        contours = [polygon(corners)]
    else:
        _refuse_names(obstacle, name)
        _refuse_iterator(obstacle, name)
        try:
            contours = [_numbers(contour, name) for contour in obstacle]
        except TypeError:
            raise OverlapError(
                f"{name} must be a polygon (m, 2), a list of contours (s, 4, 2), a Text or an "
                f"Artwork; received {obstacle!r}."
            ) from None
    for contour in contours:
        if contour.ndim != 3 or contour.shape[1:] != (4, 2) or not len(contour):
            raise OverlapError(
                f"A contour of {name} has shape {contour.shape}; give (s, 4, 2) with s ≥ 1, the "
                "control points of cubic segments."
            )
    if not contours:
        raise OverlapError(f"{name} is empty; leave it out.")
    return Shape(np.concatenate(contours), [len(contour) for contour in contours])


def _checked(shape: Shape, i: int) -> Shape:
    largest = float(np.abs(shape.segments).max())
    if not largest <= LARGEST:
        raise OverlapError(
            f"obstacles[{i}] has a coordinate of {largest:g}; coordinates must be finite and at "
            f"most {LARGEST:g} font units."
        )
    ends = np.cumsum(shape.sizes)
    follower = np.arange(1, ends[-1] + 1)
    follower[ends - 1] = ends - shape.sizes
    gap = float(np.abs(shape.segments[:, 3] - shape.segments[follower, 0]).max())
    if gap > CLOSED * max(1.0, largest):
        raise OverlapError(
            f"Each segment of obstacles[{i}] must start where the one before it ends, and the "
            f"first where the last one ends; one is {gap:.3g} units away."
        )
    # A contour is closed exactly, so that areas are exact.
    shape.segments[:, 3] = shape.segments[follower, 0]
    if not shape.area() > LEAST_AREA * largest**2:
        raise OverlapError(f"obstacles[{i}] has no area; give an outline that encloses some.")
    return shape


def _dimensions(value: Any) -> int:
    """The number of dimensions of an array-like of numbers; 0 for anything else."""
    try:
        return int(np.ndim(to_array(value)))
    except (TypeError, ValueError, RuntimeError, AttributeError):
        return 0


def _numbers(value: Any, name: str) -> Array:
    try:
        numbers = np.array(to_array(value))
    except (TypeError, ValueError, RuntimeError) as error:
        raise OverlapError(f"{name} must consist of numbers ({error}).") from None
    if not np.isfinite(numbers).all():
        raise OverlapError(f"The coordinates of {name} must be finite; one is NaN or infinite.")
    return numbers


def polygon(corners: Array) -> Array:
    """The sides of a polygon with corners (m, 2) as cubic segments (m, 4, 2)."""
    return chord(corners, np.roll(corners, -1, 0))
