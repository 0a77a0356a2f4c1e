r"""Contact planes: points of one shape that must stay on the outer side of a line (Sec. 5.2).

Each sampled point p that lies in another shape, or nearer to it than the gap, has a nearest point b
on that shape, where N is the outward normal. The residual is the paper's
:math:`\max(0, N^T(b - p))`, with the gap added. Both p and b move with their letters. N and the
pairs (p, b) are kept until the planes are found again.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arrays import Array, IntArray
from ..outline.contours import Contours
from .collisions import Collisions
from .contacts import Points, nearest, sampled
from .shape import Shape


class Carried(NamedTuple):
    """Q points that move with control points, or are fixed.

    Attributes
    ----------
    points : (Q, 4) int array
        The control points of the segment on which each point lies.
    weights : (Q, 4) array
        Their weights; zero for a point that is fixed.
    fixed : (Q, 2) array
        The position of a point that is fixed, else zero.
    """

    points: IntArray
    weights: Array
    fixed: Array

    def positions(self, points: Array) -> Array:
        """The positions (Q, 2) for control points (K, 2)."""
        return (self.weights[..., None] * points[self.points]).sum(1) + self.fixed


class Planes(NamedTuple):
    """Q planes with normals (Q, 2) at ``bases``, of which ``points`` stay on the outer side."""

    points: Carried
    bases: Carried
    normals: Array
    gap: float

    def residual(self, points: Array) -> Array:
        """How far each point is beyond its plane, (Q,), in font units; 0 on the outer side."""
        away = self.points.positions(points) - self.bases.positions(points)
        return np.maximum(self.gap - (away * self.normals).sum(1), 0.0)

    def derivative(self, points: Array) -> Array:
        """The derivative of :meth:`residual` by the control points, (Q, K, 2)."""
        by = np.zeros((len(self.normals), *points.shape))
        beyond = self.residual(points) > 0
        row = np.arange(len(by))[:, None]
        for carried, sign in ((self.points, -1.0), (self.bases, 1.0)):
            weights = sign * beyond[:, None] * carried.weights
            np.add.at(by, (row, carried.points), weights[..., None] * self.normals[:, None])
        return by


def find_planes(
    letters: list[Shape], obstacles: list[Shape], nearby: Collisions, contours: Contours, gap: float
) -> Planes:
    """The planes of all contacts of letters with each other and with obstacles.

    Parameters
    ----------
    letters, obstacles : list of Shape
    nearby : Collisions
        The pairs to look at.
    contours : Contours
        Those of all letters.
    gap : float
        Points outside the other shape count if they are nearer than this, in font units.
    """
    counts = [sum(shape.sizes) for shape in letters]
    starts = np.cumsum(counts) - counts
    pairs = nearby.pairs + nearby.obstacle[:, None] * np.array([0, len(letters)])
    shapes = letters + obstacles
    unions = {i: shapes[i].union() for i in set(pairs.ravel().tolist())}

    def carried(shape: int, ends: Points) -> Carried:
        if shape >= len(letters):
            nothing = np.zeros((len(ends.t), 4))
            return Carried(nothing.astype(np.intp), nothing, ends.position)
        t = ends.t[:, None]
        weights = np.concatenate(
            [(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t * t * (1 - t), t**3], axis=1
        )
        index = contours.segments[starts[shape] + ends.segment]
        return Carried(index, weights, np.zeros((len(t), 2)))

    none = Points(np.zeros(0, dtype=np.intp), np.zeros(0), np.zeros((0, 2)), np.zeros((0, 2)))
    points, bases, normals = (
        [carried(len(letters), none)],
        [carried(len(letters), none)],
        [none.position],
    )
    for i, j in pairs.tolist():
        for a, b in ((i, j), (j, i)):
            ends = sampled(shapes[a], unions[a])
            base = nearest(ends.position, shapes[b], unions[b])
            away = ends.position - base.position
            distance = np.hypot(*away.T)
            side = np.where((away * base.outward).sum(1) < 0, -1.0, 1.0)
            close = np.flatnonzero(side * distance < gap)
            clear = distance[close, None] > 0
            unit = (side[:, None] * away)[close] / np.where(clear, distance[close, None], 1.0)
            points.append(carried(a, ends.some(close)))
            bases.append(carried(b, base.some(close)))
            normals.append(np.where(clear, unit, base.outward[close]))
    return Planes(_joined(points), _joined(bases), np.concatenate(normals), gap)


def _joined(parts: list[Carried]) -> Carried:
    return Carried(*(np.concatenate(values) for values in zip(*parts, strict=True)))
