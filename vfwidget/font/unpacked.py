"""One glyph's outline as layers: the default outline, then its delta sets."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..outline.varying import Affine


@dataclass(frozen=True)
class Unpacked:
    """What a reader of outlines finds in the file for one glyph.

    Attributes
    ----------
    points : (1 + m, k, 2) array
        Cubic control points; layer 0 is the default outline, layers 1… its delta sets.
    support : (m, n, 3) array
    contours : list of int
        Segments of each contour; see :class:`vfwidget.outline.contours.Contours`.
    width, height : (1 + m,) array or None
        Advances by the phantom points; None where the format has no such points.
    """

    points: Array
    support: Array
    contours: Sequence[int]
    width: Array | None = None
    height: Array | None = None

    @property
    def outline(self) -> Affine:
        """The control points as a function of the coordinates."""
        return Affine(self.points[0], self.points[1:].transpose(1, 2, 0), self.support)


def chain(points: Array, segments: Sequence[tuple[int, int, int, int, int]]) -> Array:
    """Segments of any order as cubics.

    Parameters
    ----------
    points : (1 + m, k, 2) array
    segments : sequence of (start, first control, second control, end, order)
        Indices of points. Order 3 is a cubic. A quadratic, order 2, has its one control point
        twice. A line, order 1, has its end and its start for controls, so that t is even along it.

    Returns
    -------
    (1 + m, 3 s, 2) array
        Start and inner points of each segment.
    """
    if not segments:
        return np.zeros((len(points), 0, 2))
    start, one, two, end, order = np.array(segments).T
    # The inner points lie a third, two thirds or all of the way from an end to its control.
    pull = (order / 3)[:, None]
    starts, ends = points[:, start], points[:, end]
    first = starts + pull * (points[:, one] - starts)
    second = ends + pull * (points[:, two] - ends)
    return np.stack([starts, first, second], axis=2).reshape(len(points), -1, 2)
