"""Where the markers of a path stand, and how they are turned."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from .paths import CLOSE, MOVE, Step


class Vertex(NamedTuple):
    """A vertex of a path.

    Attributes
    ----------
    kind : str
        "start", "mid" or "end".
    place : (2,) array
    angle : float
        The direction of the path, in degrees as in SVG.
    """

    kind: str
    place: Array
    angle: float


def vertices(path: Sequence[Step]) -> list[Vertex]:
    """The vertices of a path at which markers stand.

    A marker is turned to the bisector of the directions before and after its vertex. Where the
    path begins or ends, there is one direction; a closed subpath has both at its start.
    """
    places, ways, opens, closes = list[Array](), list[Array](), list[int](), dict[int, int]()
    for step in path:
        if step.kind == MOVE:
            opens.append(len(places))
            places.append(step.end)
            ways.append(np.zeros((2, 2)))
            continue
        points = [point for curve in step.curves for point in curve]
        places.append(step.end)
        ways.append(np.array([_way(points), -_way(points[::-1])]))
        if step.kind == CLOSE:
            closes[opens[-1]] = len(places) - 1
    # The direction after a vertex is that in which the next segment begins.
    arriving = [way[1] for way in ways]
    leaving = [way[0] for way in ways[1:]] + [np.zeros(2)]
    for first, last in closes.items():
        arriving[first], leaving[last] = arriving[last], leaving[first]
    count = len(places)
    found = []
    for i, place in enumerate(places):
        kinds = ["mid"] if 0 < i < count - 1 else []
        kinds += ["start"] if i == 0 else []
        kinds += ["end"] if i == count - 1 else []
        way = arriving[i] + leaving[i]
        if not way.any():
            way = arriving[i] if arriving[i].any() else leaving[i]
        angle = math.degrees(math.atan2(way[1], way[0]))
        found += [Vertex(kind, place, angle) for kind in kinds]
    return found


def _way(points: list[Array]) -> Array:
    """The unit vector in which a row of points begins; zero if they are all equal."""
    for point in points[1:]:
        way = point - points[0]
        if way.any():
            return np.asarray(way / np.hypot(*way))
    return np.zeros(2)
