r"""A row of glyphs, and points upon it, as functions of Θ: Eq. 3.

A letter's points are affine in its own scaling factors γ(θ), and its origin is the sum of the
advances before it, each affine in its glyph's γ. So every point of the word, an outline's
control point or any :class:`Handle` on a curve, is

    p̃(Θ) = base + D · γ(θ_letter) + Σ_{z < letter} advance_z(θ_z) x̂,

and a handful of points costs a handful of rows, however large the glyphs are.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple, TypeVar, cast

import numpy as np

from ..arrays import Array, BoolArray, IntArray, like, namespace, padded_table
from ..font import Font, Glyph
from ..outline.contours import Contours
from ..outline.cubics import bernstein
from ..outline.variation import Regions, merge_regions, selection

MOST_KNOWN = 256
"""How many things a word remembers before it forgets them all."""
Made = TypeVar("Made")


@dataclass(frozen=True)
class Handle:
    """A point of a word's outline that stays on its curve parameter as the axes move.

    Attributes
    ----------
    glyph, contour, segment : int
        Which letter of the word, which of its contours, which cubic of that contour.
    t : float
        Parameter on the cubic, 0 … 1.
    word : Word
        The word it belongs to; handles serve every :class:`Text` moved from that text.
    """

    glyph: int
    contour: int
    segment: int
    t: float
    word: Word = field(repr=False, compare=True, kw_only=True)


@dataclass(frozen=True)
class PointSet:
    """Points of a word as affine functions of their letters' scaling factors.

    Attributes
    ----------
    letter : (p,) int array
    base : (p, 2) array
    deltas : (p, 2, M) array
        Over the word's merged regions.
    before : (p, l) array
        1 where a letter stands before the point's own and so pushes it along, else 0.
    word : Word
    """

    letter: IntArray
    base: Array
    deltas: Array
    before: Array
    word: Word = field(repr=False)

    @cached_property
    def rows(self) -> Rows:
        """The coordinates of these points as rows over all scaling factors of the word."""
        word, flat = self.word, self.deltas.reshape(self.base.size, -1)
        pushed = np.zeros((self.base.size, len(word.glyphs)))
        pushed[0::2] = self.before
        gain = word.advance_rows(pushed)
        if word.shared:
            gain += flat
        else:
            m = flat.shape[1]
            for row, letter in enumerate(np.repeat(self.letter, 2)):
                gain[row, letter * m : (letter + 1) * m] += flat[row]
        return Rows(self.base.ravel() + pushed @ word.advance_base, gain, pushed)


class Rows(NamedTuple):
    """2 p coordinates, x and y in turn: ``base + gain @ γ``, as long as no advance is held at 0.

    Attributes
    ----------
    base : (2 p,) array
    gain : (2 p, parameters · M) array
    pushed : (2 p, l) array
        How much of each letter's advance is in ``base`` and ``gain``.
    """

    base: Array
    gain: Array
    pushed: Array


class Word:
    """The part of a text that no axis changes: its glyphs and their merged regions.

    Functions take Θ as (..., l, n) or, when shared, (..., 1, n), numpy or torch.

    Attributes
    ----------
    glyphs : tuple of Glyph
    offsets : (l, 2) array
        Constant shifts that shaping gave, such as a mark's over its base.
    regions : Regions
        Every region of every glyph, once: M of them.
    outline_regions, advance_regions : list of int arrays
        Which of the M regions each letter's delta sets and advance deltas belong to.
    """

    def __init__(self, font: Font, string: str, shared: bool) -> None:
        self.font, self.string, self.shared = font, string, shared
        shaped = font.shape(string)
        glyphs = [font.glyph(s.glyph_id) for s in shaped]
        self.glyphs: tuple[Glyph, ...] = tuple(
            glyph if s.spacing else glyph.without_advance()
            for glyph, s in zip(glyphs, shaped, strict=True)
        )
        self.offsets = np.array([s.offset for s in shaped], dtype=np.float64)
        self.first_point = np.cumsum([0, *(len(g.affine.base) for g in self.glyphs)])
        supports = [g.affine.support for g in self.glyphs]
        supports += [g.affine.advance_support for g in self.glyphs]
        support, indices = merge_regions(supports)
        count = len(self.glyphs)
        self.regions = Regions(support)
        self._known: dict[Hashable, Any] = {}
        self.outline_regions, self.advance_regions = indices[:count], indices[count:]
        self.advance_base = np.array([g.affine.advance_base for g in self.glyphs])
        self.advance_deltas = np.zeros((count, len(support)))
        for letter, glyph in enumerate(self.glyphs):
            spread = selection(self.advance_regions[letter], len(support))
            self.advance_deltas[letter] = glyph.affine.advance_deltas @ spread

    def kinks(self, felt: BoolArray) -> Array:
        """Where each coordinate of flat Θ has a kink in some of these of the M regions, padded."""

        def table() -> Array:
            breakpoints = Regions(self.regions.support[felt]).breakpoints
            return np.tile(padded_table(breakpoints), (self.parameters, 1))

        return self.remember(felt.tobytes(), table)

    def advance_rows(self, pushed: Array) -> Array:
        """Advances as rows over the scaling factors: weights (r, l) to (r, parameters · M)."""
        if self.shared:
            return pushed @ self.advance_deltas
        return (pushed[..., None] * self.advance_deltas).reshape(len(pushed), -1)

    @cached_property
    def bounds(self) -> tuple[Array, Array]:
        """Least and greatest flat Θ, two (parameters · n,) arrays."""
        lower, upper = self.font.bounds
        return np.tile(lower, self.parameters), np.tile(upper, self.parameters)

    @cached_property
    def can_vanish(self) -> Array:
        """Which letters' advances might come to nothing somewhere, (l,): their least sum is < 0."""
        return self.advance_base + np.minimum(self.advance_deltas, 0).sum(1) < 0

    @cached_property
    def contours(self) -> Contours:
        """The contours of the word, letter after letter."""
        return Contours(segments for glyph in self.glyphs for segments in glyph.contours)

    @property
    def parameters(self) -> int:
        """How many axis vectors Θ holds: 1 when shared, else one for each letter."""
        return 1 if self.shared else len(self.glyphs)

    def outline(self) -> PointSet:
        """All control points, letter after letter."""
        letter = np.repeat(np.arange(len(self.glyphs)), np.diff(self.first_point))
        return self._point_set(
            letter,
            np.concatenate([g.affine.base for g in self.glyphs]),
            np.concatenate([self._spread(i) for i in range(len(self.glyphs))]),
        )

    def at_handles(self, handles: Sequence[Handle]) -> PointSet:
        """The handles' points, each a blend of the four control points of its segment."""
        key = tuple(handles)
        return self.remember(key, lambda: self._blend(key))

    def remember(self, key: Hashable, make: Callable[[], Made]) -> Made:
        """What was made for this key before, else what is made now: a drag repeats itself."""
        if key not in self._known:
            if len(self._known) >= MOST_KNOWN:
                self._known.clear()
            self._known[key] = make()
        return cast(Made, self._known[key])

    def _blend(self, handles: tuple[Handle, ...]) -> PointSet:
        letter = np.array([h.glyph for h in handles], dtype=np.intp)
        base, deltas = [], []
        for h in handles:
            indices = self.glyphs[h.glyph].contours.indices[h.contour][h.segment]
            weights = bernstein(h.t)
            base.append(weights @ self.glyphs[h.glyph].affine.base[indices])
            deltas.append(np.tensordot(weights, self._spread(h.glyph, indices), 1))
        regions = len(self.regions.support)
        return self._point_set(
            letter, np.reshape(base, (-1, 2)), np.reshape(deltas, (-1, 2, regions))
        )

    def end(self) -> PointSet:
        """The one point at the end of the line, where the next letter's origin would be."""
        return PointSet(
            np.array([len(self.glyphs) - 1], dtype=np.intp),
            np.zeros((1, 2)),
            np.zeros((1, 2, len(self.regions.support))),
            np.ones((1, len(self.glyphs))),
            self,
        )

    def _spread(self, letter: int, points: Any = slice(None)) -> Array:
        """A letter's deltas (p, 2, M), laid out over the word's merged regions."""
        spread = selection(self.outline_regions[letter], len(self.regions.support))
        return self.glyphs[letter].affine.deltas[points] @ spread

    def _point_set(self, letter: IntArray, base: Array, deltas: Array) -> PointSet:
        before = np.arange(len(self.glyphs)) < letter[:, None]
        return PointSet(
            letter, base + self.offsets[letter], deltas, before.astype(np.float64), self
        )

    def advances(self, gamma: Any) -> Any:
        """Advance width of each letter, (..., l), from the scaling factors γ (..., 1 or l, M)."""
        return self.unclipped_advances(gamma).clip(0)

    def unclipped_advances(self, gamma: Any) -> Any:
        """What the deltas of each advance add up to, (..., l), be it less than nothing."""
        varied = (like(self.advance_deltas, gamma) * gamma).sum(-1)
        return like(self.advance_base, gamma) + varied

    def origins(self, theta: Any) -> Any:
        """The x of each letter's origin, (..., l), its constant offset not counted."""
        advances = self.advances(self.regions.scalars(theta))
        return advances.cumsum(-1) - advances

    def positions(self, points: PointSet, theta: Any) -> Any:
        """The points at Θ, (..., p, 2) (Eq. 3)."""
        gamma = self.regions.scalars(theta)
        return self._place(points, gamma, self.unclipped_advances(gamma))

    def positions_and_jacobian(self, points: PointSet, theta: Any) -> tuple[Any, Any]:
        """The points at Θ, (..., p, 2), and their derivative, (..., p, 2, 1 or l, n)."""
        xp = namespace(theta)
        gamma, slopes = self.regions.scalars_and_jacobian(theta)
        advances = self.unclipped_advances(gamma)
        position = self._place(points, gamma, advances)
        deltas, before = like(points.deltas, theta), like(points.before, theta)
        # An advance that is held at zero has no slope; one that is zero of itself has.
        rows = like(self.advance_deltas, theta) * (advances >= 0)[..., None]
        if self.shared:
            jacobian = deltas @ slopes
            jacobian[..., 0, :] += before @ (rows @ slopes[..., 0, :, :])
            return position, jacobian[..., None, :]
        own = deltas @ slopes[..., points.letter, :, :]
        widths = (rows[..., None, :] @ slopes)[..., 0, :]
        p, l, n = len(points.letter), len(self.glyphs), theta.shape[-1]
        jacobian = like(np.zeros((*position.shape[:-1], 2, l, n)), theta)
        jacobian[..., 0, :, :] = before[..., None] * widths[..., None, :, :]
        jacobian[..., xp.arange(p), :, points.letter, :] += xp.moveaxis(own, -3, 0)
        return position, jacobian

    def _place(self, points: PointSet, gamma: Any, advances: Any) -> Any:
        """Eq. 3: a point in its letter, pushed along by the advances before it."""
        xp = namespace(gamma)
        own = gamma if self.shared else gamma[..., points.letter, :]
        moved = (like(points.deltas, gamma) @ own[..., None])[..., 0]
        push = (like(points.before, gamma) @ advances.clip(0)[..., None])[..., 0]
        return like(points.base, gamma) + moved + xp.stack([push, xp.zeros_like(push)], -1)
