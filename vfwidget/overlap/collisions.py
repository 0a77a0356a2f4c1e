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

    def gradient(self, contours: Contours, starts: IntArray) -> Array:
        """The derivative of :meth:`by_letter` by all control points, (l, K, 2).

        Parameters
        ----------
        contours : Contours
            Those of all letters.
        starts : (l,) int array
            The first segment of each letter.
        """
        common = self.common
        own, points = self._points(contours, starts, np.arange(len(common.segment)))
        gradient = np.zeros((len(starts), contours.point_count, 2))
        letter = self.pairs[common.pair[own], 0]
        np.add.at(gradient, (letter[:, None], points), common.gradient()[own])
        return gradient

    def by_piece(self, contours: Contours, starts: IntArray) -> tuple[IntArray, Array, Array]:
        """Pair (M,), area (M,) and its derivative (M, K, 2) of each piece of common area."""
        pieces = self.common.pieces()
        own, points = self._points(contours, starts, pieces.segment)
        gradient = np.zeros((len(pieces.pair), contours.point_count, 2))
        np.add.at(gradient, (pieces.piece[own][:, None], points), pieces.gradient[own])
        return pieces.pair, pieces.area, gradient

    def _points(
        self, contours: Contours, starts: IntArray, index: IntArray
    ) -> tuple[IntArray, IntArray]:
        """Which of the segments at an index belong to letters, and their control points (…, 4)."""
        common = self.common
        pair, layer = common.pair[index], common.layer[index]
        # The others belong to obstacles, of which there may be more than letters.
        own = np.flatnonzero(~self.obstacle[pair] | (layer == 0))
        owner = self.pairs[pair[own], layer[own]]
        return own, contours.segments[starts[owner] + common.segment[index[own]]]


def collisions(
    letters: Sequence[Shape],
    obstacles: Sequence[Shape],
    between_glyphs: bool = True,
    gap: float = 0.0,
) -> Collisions:
    """The pairs whose boxes overlap, or are nearer than a gap, with their common areas."""
    shapes, count = [*letters, *obstacles], len(letters)
    pairs = pairs_nearby(np.array([shape.box for shape in shapes]), count, between_glyphs, gap)
    common = common_area([(shapes[i], shapes[j]) for i, j in pairs.tolist()])
    obstacle = pairs[:, 1] >= count
    pairs[obstacle, 1] -= count
    return Collisions(pairs, obstacle, common)


def areas(
    states: Sequence[Sequence[Shape]], obstacles: Sequence[Shape], between_glyphs: bool = True
) -> Array:
    """The sum of all common areas, for letters in several states (s,); quicker than one by one."""
    shapes, counts = list[tuple[Shape, Shape]](), []
    for letters in states:
        both = [*letters, *obstacles]
        boxes = np.array([shape.box for shape in both])
        pairs = pairs_nearby(boxes, len(letters), between_glyphs).tolist()
        shapes += [(both[i], both[j]) for i, j in pairs]
        counts.append(len(pairs))
    state = np.repeat(np.arange(len(states)), counts)
    return np.bincount(state, common_area(shapes).area, len(states)).astype(np.float64)
