"""All pairs of letters, and of letters and obstacles, that may overlap, with their common areas."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..arrays import Array, BoolArray, IntArray
from ..outline.contours import Contours
from .common_area import Common, common_area, pairs_nearby
from .shape import Shape


class Collisions(NamedTuple):
    """P pairs of shapes whose boxes overlap, or are nearer than a gap.

    Attributes
    ----------
    pairs : (P, 2) int array
        Two letters, or a letter and an obstacle.
    obstacle : (P,) bool array
        Whether the second of a pair is an obstacle.
    common : Common
    """

    pairs: IntArray
    obstacle: BoolArray
    common: Common

    def by_letter(self, count: int) -> Array:
        """The common area (count,) of each letter with the letters after it and the obstacles."""
        return np.bincount(self.pairs[:, 0], self.common.area, count).astype(np.float64)

    def by_pair(self, contours: Contours, starts: IntArray) -> Array:
        """The derivative of each pair's common area by all control points, (P, K, 2).

        Parameters
        ----------
        contours : Contours
            Those of all letters.
        starts : (l,) int array
            The first segment of each letter.
        """
        common = self.common
        owner = self.pairs[common.pair, common.layer]
        # The others belong to obstacles, of which there may be more than letters.
        own = ~self.obstacle[common.pair] | (common.layer == 0)
        points = contours.segments[starts[owner[own]] + common.segment[own]]
        gradient = np.zeros((len(self.pairs), contours.point_count, 2))
        np.add.at(gradient, (common.pair[own][:, None], points), common.gradient()[own])
        return gradient

    def gradient(self, contours: Contours, starts: IntArray) -> Array:
        """The derivative of :meth:`by_letter` by all control points, (l, K, 2)."""
        gradient = np.zeros((len(starts), contours.point_count, 2))
        np.add.at(gradient, self.pairs[:, 0], self.by_pair(contours, starts))
        return gradient


def collisions(
    letters: Sequence[Shape],
    obstacles: Sequence[Shape],
    between_glyphs: bool = True,
    gap: float = 0.0,
) -> Collisions:
    """The pairs whose boxes overlap, or are nearer than a gap, with their common areas."""
    own, others = list(letters), list(obstacles)
    inner = pairs_nearby(own, gap=gap) if between_glyphs else np.zeros((0, 2), dtype=np.intp)
    outer = pairs_nearby(own, others, gap)
    shapes = [(own[i], own[j]) for i, j in inner] + [(own[i], others[j]) for i, j in outer]
    obstacle = np.arange(len(shapes)) >= len(inner)
    return Collisions(np.concatenate([inner, outer]), obstacle, common_area(shapes))
