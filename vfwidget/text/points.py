r"""Points of a word as functions of the place: Eq. 3.

A letter's points are affine in the scalars γ(θ) of its own axes, and its origin is the sum of the
advances before it, each affine in its glyph's γ. So every point of the word, a control point or a
:class:`Handle` on a curve, is

    p̃ = base + D · γ(θ_letter) + Σ_{z < letter} advance_z(θ_z) x̂ + offset_letter,

and a few points cost a few rows, however large the glyphs are. A word with a glyph of another
form (one whose components have axes of their own) is evaluated glyph by glyph instead.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array, IntArray, like, namespace
from .place import AXES, OFFSETS

Values = Mapping[str, Any]
"""Arrays or tensors by block of unknowns: Θ (..., 1 or l, n), offsets (l, 2)."""


class PointSet(ABC):
    """Some points of a word as a function of the place.

    Attributes
    ----------
    letter : (p,) int array
        The letter that each point belongs to.
    word : Word
    """

    letter: IntArray
    word: Any

    def positions(self, place: Values) -> Any:
        """The points at a place, (..., p, 2); arrays stay arrays, tensors tensors."""
        theta = place[AXES]
        return self._set(theta) + like(place[OFFSETS], theta)[self.letter]

    def positions_and_jacobian(self, place: Values) -> tuple[Any, Any]:
        """The points at a place, (..., p, 2), and their derivative by Θ, (..., p, 2, 1 or l, n)."""
        theta = place[AXES]
        positions, jacobian = self._set_and_jacobian(theta)
        return positions + like(place[OFFSETS], theta)[self.letter], jacobian

    def by_offsets(self) -> Array:
        """The derivative of the points by the offsets of the letters, (p, 2, l, 2)."""
        own = np.eye(len(self.word.glyphs))[self.letter]
        return np.eye(2)[None, :, None, :] * own[:, None, :, None]

    @property
    def rows(self) -> AffineForm | None:
        """The points as rows over the word's scalars; None where they are not affine in them."""
        return None

    @abstractmethod
    def _set(self, theta: Any) -> Any:
        """The points where the layout sets them, (..., p, 2)."""

    @abstractmethod
    def _set_and_jacobian(self, theta: Any) -> tuple[Any, Any]: ...


class AffineForm(NamedTuple):
    """2 p coordinates, x and y in turn: ``base + gain @ γ``, as long as no advance is held at 0.

    Attributes
    ----------
    base : (2 p,) array
    gain : (2 p, parameters · M) array
    pushed : (2 p, l) array
        How much of each letter's advance is contained in ``base`` and ``gain``.
    """

    base: Array
    gain: Array
    pushed: Array


@dataclass(frozen=True)
class AffinePoints(PointSet):
    """Points of a word whose glyphs are all affine in their scalars.

    Attributes
    ----------
    base : (p, 2) array
    deltas : (p, 2, M) array
        Over the word's merged regions.
    before : (p, l) array
        1 where a letter stands before the point's own and so pushes it along, else 0.
    """

    letter: IntArray
    base: Array
    deltas: Array
    before: Array
    word: Any = field(repr=False)

    @cached_property
    def rows(self) -> AffineForm:
        """See :attr:`PointSet.rows`."""
        word, flat = self.word, self.deltas.reshape(self.base.size, self.deltas.shape[-1])
        pushed = np.zeros((self.base.size, len(word.glyphs)))
        pushed[0::2] = self.before
        gain = word.advance_rows(pushed)
        if word.shared:
            gain += flat
        else:
            m = flat.shape[1]
            for row, letter in enumerate(np.repeat(self.letter, 2)):
                gain[row, letter * m : (letter + 1) * m] += flat[row]
        return AffineForm(self.base.ravel() + pushed @ word.advance_base, gain, pushed)

    def _set(self, theta: Any) -> Any:
        gamma = self.word.regions.scalars(theta)
        return self._lay_out(gamma, self.word.unclipped_advances(gamma))

    def _set_and_jacobian(self, theta: Any) -> tuple[Any, Any]:
        xp, word = namespace(theta), self.word
        gamma, slopes = word.regions.scalars_and_jacobian(theta)
        advances = word.unclipped_advances(gamma)
        position = self._lay_out(gamma, advances)
        deltas, before = like(self.deltas, theta), like(self.before, theta)
        # An advance that is held at zero has no slope; one that is zero of itself has.
        rows = like(word.advance_deltas, theta) * (advances >= 0)[..., None]
        if word.shared:
            jacobian = deltas @ slopes
            jacobian[..., 0, :] += before @ (rows @ slopes[..., 0, :, :])
            return position, jacobian[..., None, :]
        own = deltas @ slopes[..., self.letter, :, :]
        widths = (rows[..., None, :] @ slopes)[..., 0, :]
        p, l, n = len(self.letter), len(word.glyphs), theta.shape[-1]
        jacobian = like(np.zeros((*position.shape[:-1], 2, l, n)), theta)
        jacobian[..., 0, :, :] = before[..., None] * widths[..., None, :, :]
        jacobian[..., xp.arange(p), :, self.letter, :] += xp.moveaxis(own, -3, 0)
        return position, jacobian

    def _lay_out(self, gamma: Any, advances: Any) -> Any:
        """A point within its letter, pushed along by the advances before it."""
        xp = namespace(gamma)
        own = gamma if self.word.shared else gamma[..., self.letter, :]
        moved = (like(self.deltas, gamma) @ own[..., None])[..., 0]
        push = (like(self.before, gamma) @ advances.clip(0)[..., None])[..., 0]
        return like(self.base, gamma) + moved + xp.stack([push, xp.zeros_like(push)], -1)


@dataclass(frozen=True)
class BlendedPoints(PointSet):
    """Points of a word with glyphs of any form, each a blend of control points of its letter.

    Attributes
    ----------
    index : (p, c) int array
        Control points of the whole word.
    weights : (p, c) array
    base : (p, 2) array
        A constant displacement.
    before : (p, l) array
        As in :class:`AffinePoints`.
    """

    letter: IntArray
    index: IntArray
    weights: Array
    base: Array
    before: Array
    word: Any = field(repr=False)

    def _set(self, theta: Any) -> Any:
        parts = [glyph.outline.value(w) for glyph, w in self.word.letters(theta)]
        return self._blend(namespace(theta).concatenate(parts, -2), self.word.advances(theta))

    def _set_and_jacobian(self, theta: Any) -> tuple[Any, Any]:
        xp, word = namespace(theta), self.word
        outlines, widths = zip(
            *(
                (glyph.outline.value_and_jacobian(w), glyph.advance_width.value_and_jacobian(w))
                for glyph, w in word.letters(theta)
            ),
            strict=True,
        )
        values = xp.concatenate([value for value, _ in outlines], -2)
        slopes = xp.concatenate([slope for _, slope in outlines], -3)
        advances = xp.stack([value for value, _ in widths], -1)
        turns = xp.stack([slope for _, slope in widths], -2)
        turns = turns * (advances >= 0)[..., None]
        position = self._blend(values, advances.clip(0))
        weights, before = like(self.weights, theta), like(self.before, theta)
        own = (weights[..., None, None] * slopes[..., self.index, :, :]).sum(-3)
        if word.shared:
            own[..., 0, :] += before @ turns
            return position, own[..., None, :]
        p, l, n = len(self.letter), len(word.glyphs), theta.shape[-1]
        jacobian = like(np.zeros((*position.shape[:-1], 2, l, n)), theta)
        jacobian[..., 0, :, :] = before[..., None] * turns[..., None, :, :]
        jacobian[..., xp.arange(p), :, self.letter, :] += xp.moveaxis(own, -3, 0)
        return position, jacobian

    def _blend(self, control_points: Any, advances: Any) -> Any:
        xp = namespace(control_points)
        weights = like(self.weights, control_points)
        own = (weights[..., None] * control_points[..., self.index, :]).sum(-2)
        push = (like(self.before, advances) @ advances[..., None])[..., 0]
        return like(self.base, own) + own + xp.stack([push, xp.zeros_like(push)], -1)
