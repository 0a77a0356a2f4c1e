"""The shape of an outline: closed contours of cubic segments that share their end points."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property
from operator import index
from typing import Any

import numpy as np

from ..arrays import IntArray
from ..errors import GlyphError


class Contours(tuple[int, ...]):
    """How many cubic segments each closed contour of an outline has.

    A contour of s segments has 3 s control points: the start and the two inner points of each
    segment. The last segment ends at the start of the first one. The control points of the
    contours follow one another in one array (..., k, 2).

    Parameters
    ----------
    segments : iterable of int
        Each at least 1.

    Raises
    ------
    GlyphError
        A number of segments is not a whole number, or is below 1.

    Examples
    --------
    >>> shape = Contours([2, 1])
    >>> shape.point_count
    9
    >>> shape.segments.tolist()
    [[0, 1, 2, 3], [3, 4, 5, 0], [6, 7, 8, 6]]
    """

    def __new__(cls, segments: Iterable[int] = ()) -> Contours:
        """Check the numbers of segments and keep them."""
        if isinstance(segments, Contours):
            return segments
        try:
            counts = tuple(index(count) for count in segments)
        except TypeError:
            raise GlyphError(
                f"contours must list the number of segments of each contour; received {segments!r}."
            ) from None
        if min(counts, default=1) < 1:
            raise GlyphError(f"Each contour needs at least one segment; received {list(counts)}.")
        return super().__new__(cls, counts)

    @property
    def point_count(self) -> int:
        """The number of control points, k."""
        return 3 * sum(self)

    @cached_property
    def segments(self) -> IntArray:
        """Indices of the four control points of every segment, contour after contour, (S, 4)."""
        first = np.repeat(self._starts, self)
        within = np.arange(sum(self)) - first
        length = np.repeat(np.array(self, dtype=np.intp), self)
        offsets = (3 * within[:, None] + np.arange(4)) % (3 * length[:, None])
        return 3 * first[:, None] + offsets

    @cached_property
    def owners(self) -> IntArray:
        """The contour that each segment belongs to, (S,)."""
        return np.repeat(np.arange(len(self)), self)

    @property
    def indices(self) -> list[IntArray]:
        """:attr:`segments` cut into one (s, 4) array for each contour."""
        return [self.segments[at : at + s] for at, s in zip(self._starts, self, strict=True)]

    def split(self, points: Any) -> list[Any]:
        """Control points (..., k, 2), an array or a tensor, as one (..., s, 4, 2) per contour."""
        return [points[..., indices, :] for indices in self.indices]

    @property
    def _starts(self) -> IntArray:
        """The number of segments before each contour."""
        return np.cumsum((0, *self))[:-1]
