r"""Points of a word as functions of the place: Eq. 3.

A letter's points are affine in the scalars γ(θ) of its own axes, and the word's layout gives its
origin (:class:`Origins`; with kerning off, the sum of the advances before it). So every point of
the word, a control point or a :class:`Handle` on a curve, is

    p̃ = base + D · γ(θ_letter) + origin(Θ) + gaps · tracking x̂ + offset_letter,

and a few points cost a few rows, however large the glyphs are. A word with a glyph of another
form (one whose components have axes of their own) is evaluated glyph by glyph instead. If letters
are rotated, so are the first two summands (:class:`RotatedPoints`).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from ..arrays import Array, BoolArray, IntArray, like, namespace, rotation_matrices, rows_of
from ..outline.variation import inward
from .memo import Memo
from .origins import RIGHT
from .place import AXES, OFFSETS, TRACKING

PRODUCTS = 2**17
"""Most multiplications in one product of matrices. BLAS divides a larger product among threads. If
other programs use the processor, waiting for these threads takes much longer than the product."""
Values = Mapping[str, Any]
"""Arrays or tensors by block of unknowns: Θ (..., 1 or l, n), offsets (l, 2)."""


class PointSet(ABC):
    """Some points of a word as a function of the place.

    Attributes
    ----------
    letter : (p,) int array
        The letter that each point belongs to.
    origin : (p,) int array
        The origin that each point is measured from: that of its letter, or the end of a line.
    word : Word
    """

    letter: IntArray
    origin: IntArray
    word: Any

    def positions(self, place: Values) -> Any:
        """The points at a place, (..., p, 2); arrays stay arrays, tensors tensors."""
        theta = place[AXES]
        return self._set(theta) + like(self._displacement(place), theta)

    def positions_and_jacobian(self, place: Values) -> tuple[Any, Any]:
        """The points at a place, (..., p, 2), and their derivative by Θ, (..., p, 2, 1 or l, n)."""
        theta = place[AXES]
        positions, jacobian = self._set_and_jacobian(theta)
        return positions + like(self._displacement(place), theta), jacobian

    def jacobian(self, place: Values) -> Any:
        """The second one of :meth:`positions_and_jacobian`."""
        return self._set_and_jacobian(place[AXES])[1]

    @cached_property
    def by_block(self) -> dict[str, Array]:
        """The derivative (p, 2, size) by the blocks in which the points are linear."""
        own = np.eye(len(self.word.glyphs))[self.letter]
        if self._fixed is not None:
            own[self._fixed] = 0
        offsets = np.eye(2)[None, :, None, :] * own[:, None, :, None]
        return {
            OFFSETS: offsets.reshape(len(own), 2, 2 * own.shape[1]),
            TRACKING: self._by_tracking[..., None],
        }

    @cached_property
    def _by_tracking(self) -> Array:
        """The derivative of the points by the tracking, (p, 2)."""
        return self.word.origins.gaps[self.origin, None] * RIGHT

    @cached_property
    def _fixed(self) -> BoolArray | None:
        """Which points are ends of lines, (p,), which no offset moves; None if none is."""
        ends: BoolArray = self.origin >= len(self.word.glyphs)
        return ends if ends.any() else None

    def _displacement(self, place: Values) -> Any:
        """What the offsets and the tracking add, (p, 2)."""
        offsets = rows_of(place[OFFSETS], self.letter)
        if self._fixed is not None:
            offsets = offsets * like(~self._fixed[:, None], offsets)
        return offsets + place[TRACKING][0] * self._by_tracking

    @abstractmethod
    def some(self, which: IntArray) -> PointSet:
        """Some of the points, by their indices."""

    @abstractmethod
    def _set(self, theta: Any) -> Any:
        """The points where the layout sets them, (..., p, 2)."""

    @abstractmethod
    def _set_and_jacobian(self, theta: Any) -> tuple[Any, Any]: ...


class RememberedPoints(PointSet):
    """Points whose latest positions are kept, because several callers ask for the same places.

    Parameters
    ----------
    points : PointSet
    most : int
        How many places are kept.
    """

    def __init__(self, points: PointSet, most: int) -> None:
        self.letter, self.origin, self.word = points.letter, points.origin, points.word
        self._points = points
        self._latest: Memo[Any] = Memo(most)

    def positions(self, place: Values) -> Any:
        """See :meth:`PointSet.positions`; ``place`` holds arrays."""
        at = b"".join([place[name].tobytes() for name in (AXES, OFFSETS, TRACKING)])
        # A caller may write to them.
        return self._latest.get(at, lambda: self._points.positions(place)).copy()

    def jacobian(self, place: Values) -> Any:
        """See :meth:`PointSet.jacobian`."""
        return self._points.jacobian(place)

    def some(self, which: IntArray) -> PointSet:
        """See :meth:`PointSet.some`."""
        return self._points.some(which)

    def _set(self, theta: Any) -> Any:
        return self._points._set(theta)

    def _set_and_jacobian(self, theta: Any) -> tuple[Any, Any]:
        return self._points._set_and_jacobian(theta)


@dataclass(frozen=True)
class AffinePoints(PointSet):
    """Points of a word whose glyphs are all affine in their scalars.

    Attributes
    ----------
    base : (p, 2) array
    deltas : (p, 2, M) array
        Over the word's merged regions.
    """

    letter: IntArray
    origin: IntArray
    base: Array
    deltas: Array
    word: Any = field(repr=False)

    def some(self, which: IntArray) -> AffinePoints:
        """See :meth:`PointSet.some`."""
        letter, origin = self.letter[which], self.origin[which]
        return AffinePoints(letter, origin, self.base[which], self.deltas[which], self.word)

    def _set(self, theta: Any) -> Any:
        gamma = self.word.regions.scalars(theta)
        return self._lay_out(gamma, self.word.unclipped_advances(gamma))

    def _set_and_jacobian(self, theta: Any) -> tuple[Any, Any]:
        word = self.word
        gamma, slopes = word.regions.scalars_and_jacobian(theta)
        advances = word.unclipped_advances(gamma)
        return self._lay_out(gamma, advances), self._turn(slopes, advances)

    def jacobian(self, place: Values) -> Any:
        """See :meth:`PointSet.jacobian`."""
        gamma, slopes = self.word.regions.scalars_and_jacobian(place[AXES])
        return self._turn(slopes, self.word.unclipped_advances(gamma))

    def _turn(self, slopes: Any, advances: Any) -> Any:
        """The derivative of the points (..., p, 2, 1 or l, n), from that of the scalars."""
        word = self.word
        # An advance that is held at zero has no slope; one that is zero of itself has.
        rows = like(word.advance_deltas, slopes) * (advances >= 0)[..., None]
        widths = rows[..., None, :] @ slopes
        turns = by_letter(widths[..., 0, :], word.shared)
        jacobian = word.origins.jacobian(slopes, turns)[..., self.origin, :, :, :]
        own = self._moved(slopes)
        for begin, end, k in self._runs:
            jacobian[..., begin:end, :, k, :] += own[..., begin:end, :, :]
        return jacobian

    @property
    def vector(self) -> IntArray:
        """The axis vector in Θ that each point depends on, apart from its origin, (p,)."""
        return np.zeros_like(self.letter) if self.word.shared else self.letter

    def _lay_out(self, gamma: Any, advances: Any) -> Any:
        """A point within its letter, at the letter's origin."""
        moved = self._moved(gamma[..., None])[..., 0]
        origins = self.word.origins.value(gamma, advances.clip(0))
        return like(self.base, gamma) + moved + rows_of(origins, self.origin)

    def _moved(self, columns: Any) -> Any:
        """The deltas times columns (..., 1 or l, M, q) of each axis vector: (..., p, 2, q)."""
        deltas = like(self.deltas, columns)
        *batch, _, m, q = columns.shape
        block = max(1, PRODUCTS // max(1, 2 * m * q))
        # One product of matrices for many points is many times as quick as one for each.
        cuts = self._runs
        if block < len(deltas):
            cuts = [
                (at, min(at + block, end), k)
                for begin, end, k in self._runs
                for at in range(begin, end, block)
            ]
        parts = [deltas[a:b].reshape(2 * (b - a), m) @ columns[..., k, :, :] for a, b, k in cuts]
        moved = parts[0] if len(parts) == 1 else namespace(columns).concatenate(parts, -2)
        return moved.reshape(*batch, len(deltas), 2, q)

    @cached_property
    def _runs(self) -> list[tuple[int, int, int]]:
        """Where points that follow each other have the same axis vector: begin, end, vector."""
        vector = self.vector
        bounds = [0, *(np.flatnonzero(np.diff(vector)) + 1).tolist(), len(vector)]
        return [(a, b, int(vector[a]) if a < b else 0) for a, b in pairwise(bounds)]


def by_letter(slopes: Any, shared: bool) -> Any:
    """Derivatives (..., l, n) of each letter by its own axes, by Θ: (..., l, 1 or l, n)."""
    if shared:
        return slopes[..., None, :]
    xp = namespace(slopes)
    *batch, l, n = slopes.shape
    by_theta = like(np.zeros((*batch, l, l, n)), slopes)
    by_theta[..., xp.arange(l), xp.arange(l), :] = slopes
    return by_theta


@dataclass(frozen=True)
class BlendedPoints(PointSet):
    """Points of a word with glyphs of any form, each a blend of control points of its letter.

    Attributes
    ----------
    index : (p, c) int array
        Control points of the whole word.
    weights : (p, c) array
    """

    letter: IntArray
    origin: IntArray
    index: IntArray
    weights: Array
    word: Any = field(repr=False)

    def some(self, which: IntArray) -> BlendedPoints:
        """See :meth:`PointSet.some`."""
        letter, origin = self.letter[which], self.origin[which]
        return BlendedPoints(letter, origin, self.index[which], self.weights[which], self.word)

    def _set(self, theta: Any) -> Any:
        parts = [glyph.outline.value(w) for glyph, w in self.word.letters(theta)]
        gamma = self.word.scalars.value(theta)
        origins = self.word.origins.value(gamma, self.word.advances(theta))
        return self._blend(namespace(theta).concatenate(parts, -2), origins)

    def _set_and_jacobian(self, theta: Any) -> tuple[Any, Any]:
        xp, word = namespace(theta), self.word
        sides = inward(theta, like(word.font.bounds[1], theta))
        outlines, widths = zip(
            *(
                [one.value_and_jacobian(w, side) for one in (glyph.outline, glyph.advance_width)]
                for (glyph, w), (_, side) in zip(
                    word.letters(theta), word.letters(sides), strict=True
                )
            ),
            strict=True,
        )
        values = xp.concatenate([value for value, _ in outlines], -2)
        outline_slopes = xp.concatenate([slope for _, slope in outlines], -3)
        advances = xp.stack([value for value, _ in widths], -1)
        turns = xp.stack([slope for _, slope in widths], -2) * (advances >= 0)[..., None]
        gamma, slopes = word.scalars.value_and_jacobian(theta, sides)
        position = self._blend(values, word.origins.value(gamma, advances.clip(0)))
        own = like(self.weights, theta)[..., None, None] * outline_slopes[..., self.index, :, :]
        turns = by_letter(turns, word.shared)
        jacobian = word.origins.jacobian(slopes, turns)[..., self.origin, :, :, :]
        letter = np.zeros_like(self.letter) if word.shared else self.letter
        points = xp.arange(len(letter))
        jacobian[..., points, :, letter, :] += xp.moveaxis(own.sum(-3), -3, 0)
        return position, jacobian

    def _blend(self, control_points: Any, origins: Any) -> Any:
        weights = like(self.weights, control_points)
        own = (weights[..., None] * control_points[..., self.index, :]).sum(-2)
        return own + rows_of(origins, self.origin)


@dataclass(frozen=True)
class RotatedPoints(PointSet):
    """Points of letters that are rotated about their origins.

    Attributes
    ----------
    points : PointSet
        The points of the upright letters.
    start : PointSet
        The origin of the letter of each point, (p, 2).
    angles : (l,) array
        Of the letters, in radians, counterclockwise.
    """

    letter: IntArray
    origin: IntArray
    points: PointSet
    start: PointSet
    angles: Array
    word: Any = field(repr=False)

    @staticmethod
    def of(points: PointSet, angles: Array) -> RotatedPoints:
        """Points of a word, rotated with their letters."""
        start = points.word.starts(points.letter)
        return RotatedPoints(points.letter, points.letter, points, start, angles, points.word)

    def some(self, which: IntArray) -> RotatedPoints:
        """See :meth:`PointSet.some`."""
        points, start = self.points.some(which), self.start.some(which)
        return RotatedPoints(points.letter, points.letter, points, start, self.angles, self.word)

    def _set(self, theta: Any) -> Any:
        start = self.start._set(theta)
        return start + self._rotated((self.points._set(theta) - start)[..., None])[..., 0]

    def _set_and_jacobian(self, theta: Any) -> tuple[Any, Any]:
        start, start_slopes = self.start._set_and_jacobian(theta)
        position, slopes = self.points._set_and_jacobian(theta)
        l, n = slopes.shape[-2:]
        own = (slopes - start_slopes).reshape(*slopes.shape[:-2], l * n)
        turned = self._rotated(own).reshape(slopes.shape)
        return start + self._rotated((position - start)[..., None])[..., 0], start_slopes + turned

    def _rotated(self, vectors: Any) -> Any:
        """Vectors (..., p, 2, q), rotated with the letters of the points."""
        return like(rotation_matrices(self.angles)[self.letter], vectors) @ vectors
