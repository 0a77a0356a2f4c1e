"""The part of a text that no axis changes: its glyphs, and how they vary together."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from ..arrays import Array, IntArray, like, namespace, padded_table
from ..font import Font, Glyph
from ..outline.contours import Contours
from ..outline.cubics import bernstein
from ..outline.variation import Regions, merge_regions, selection
from .handle import Handle
from .memo import Memo
from .points import AffinePoints, BlendedPoints, PointSet


class Word:
    """A row of glyphs that all texts moved from one another share; it is immutable.

    Attributes
    ----------
    glyphs : tuple of Glyph
    letter_names : tuple of str
        The character of each letter, or its glyph name where it has no single character.
    fixed_offsets : (l, 2) array
        Constant displacements that shaping gave, such as that of a mark over its base.
    is_affine : bool
        Whether all glyphs are affine in the scalars of their regions. The attributes below exist
        only then.
    regions : Regions
        Every region of every glyph, once: M of them.
    outline_regions, advance_regions : list of int arrays
        The indices, among the M regions, of each letter's delta sets and advance deltas.
    advance_base : (l,) array
    advance_deltas : (l, M) array
    """

    def __init__(self, font: Font, string: str, shared: bool) -> None:
        self.font, self.string, self.shared = font, string, shared
        shaped = font.shape(string)
        glyphs = [font.glyph(s.glyph_id) for s in shaped]
        self.glyphs: tuple[Glyph, ...] = tuple(
            glyph if s.spacing else glyph.without_advance()
            for glyph, s in zip(glyphs, shaped, strict=True)
        )
        self.letter_names = tuple(
            _letter_name(string, [s.cluster for s in shaped], i, glyph)
            for i, glyph in enumerate(glyphs)
        )
        self.fixed_offsets = np.array([s.offset for s in shaped], dtype=np.float64)
        self.is_affine = all(glyph.is_affine for glyph in self.glyphs)
        if self.is_affine:
            self._merge()
        self._point_sets: Memo[PointSet] = Memo()
        self.compiled_rows: Memo[Any] = Memo()
        """What energies compile from affine terms, for the next solve with the same ones."""

    def _merge(self) -> None:
        affine, count = [glyph.affine for glyph in self.glyphs], len(self.glyphs)
        supports = [g.support for g in affine] + [g.advance_support for g in affine]
        support, indices = merge_regions(supports)
        self.regions = Regions(support)
        self.outline_regions, self.advance_regions = indices[:count], indices[count:]
        self.advance_base = np.array([g.advance_base for g in affine])
        self.advance_deltas = np.zeros((count, len(support)))
        for letter, own in enumerate(affine):
            spread = selection(self.advance_regions[letter], len(support))
            self.advance_deltas[letter] = own.advance_deltas @ spread

    def __reduce__(self) -> Any:
        return Word, (self.font, self.string, self.shared)

    def __deepcopy__(self, memo: Any) -> Word:
        return self

    @property
    def parameters(self) -> int:
        """How many axis vectors Θ holds: 1 when shared, else one for each letter."""
        return 1 if self.shared else len(self.glyphs)

    @cached_property
    def contours(self) -> Contours:
        """The contours of the word, letter after letter."""
        return Contours(segments for glyph in self.glyphs for segments in glyph.contours)

    @cached_property
    def first_point(self) -> IntArray:
        """The number of control points before each letter, and in all, (l + 1,)."""
        return np.cumsum([0, *(glyph.contours.point_count for glyph in self.glyphs)])

    @cached_property
    def bounds(self) -> tuple[Array, Array]:
        """Least and greatest Θ, two (parameters, n) arrays."""
        lower, upper = (np.tile(bound, (self.parameters, 1)) for bound in self.font.bounds)
        return lower, upper

    @cached_property
    def breakpoints(self) -> list[Array]:
        """For each axis the sorted normalized coordinates at which some point has a kink."""
        varying = [v for glyph in self.glyphs for v in (glyph.outline, glyph.advance_width)]
        by_axis = zip(*(one.breakpoints for one in varying), strict=True)
        return [np.unique(np.concatenate(values)) for values in by_axis]

    @cached_property
    def kinks(self) -> Array:
        """The same for each entry of flat Θ, (parameters · n, q), padded with infinity."""
        return np.tile(padded_table(self.breakpoints), (self.parameters, 1))

    @cached_property
    def can_vanish(self) -> Array:
        """Letters whose advance might be clamped at 0 somewhere, (l,): its least sum is < 0."""
        return self.advance_base + np.minimum(self.advance_deltas, 0).sum(1) < 0

    def advance_rows(self, pushed: Array) -> Array:
        """Advances as rows over the scalars: weights (r, l) to (r, parameters · M)."""
        if self.shared:
            return pushed @ self.advance_deltas
        return (pushed[..., None] * self.advance_deltas).reshape(len(pushed), -1)

    def unclipped_advances(self, gamma: Any) -> Any:
        """The sum of the deltas of each advance, (..., l), which may be negative.

        Parameters
        ----------
        gamma : (..., 1 or l, M) array or tensor
            Scalars of the regions.
        """
        varied = (like(self.advance_deltas, gamma) * gamma).sum(-1)
        return like(self.advance_base, gamma) + varied

    def advances(self, theta: Any) -> Any:
        """Advance width of each letter at Θ, (..., l); never negative."""
        if self.is_affine:
            return self.unclipped_advances(self.regions.scalars(theta)).clip(0)
        xp = namespace(theta)
        widths = [glyph.advance_width.value(w) for glyph, w in self.letters(theta)]
        return xp.stack(widths, -1).clip(0)

    def origins(self, theta: Any) -> Any:
        """The x of each letter's origin at Θ, (..., l), offsets not counted."""
        advances = self.advances(theta)
        return advances.cumsum(-1) - advances

    def letters(self, theta: Any) -> Iterator[tuple[Glyph, Any]]:
        """Each glyph with its own coordinates (..., n)."""
        for i, glyph in enumerate(self.glyphs):
            yield glyph, theta[..., 0 if self.shared else i, :]

    def outline(self) -> PointSet:
        """All control points, letter after letter."""
        count = len(self.glyphs)
        letter = np.repeat(np.arange(count), np.diff(self.first_point))
        if self.is_affine:
            base = np.concatenate([glyph.affine.base for glyph in self.glyphs])
            deltas = np.concatenate([self._spread(i) for i in range(count)])
            return self._affine(letter, base, deltas)
        index = np.arange(len(letter))[:, None]
        return self._blended(letter, index, np.ones(index.shape))

    def at_handles(self, handles: Sequence[Handle]) -> PointSet:
        """The handles' points, each a blend of the four control points of its segment."""
        key = tuple(handles)
        return self._point_sets.get(key, lambda: self._blend(key))

    @cached_property
    def end(self) -> PointSet:
        """The one point at the end of the line, where the next letter's origin would be."""
        last = np.array([len(self.glyphs) - 1], dtype=np.intp)
        pushed = np.ones((1, len(self.glyphs)))
        if self.is_affine:
            deltas = np.zeros((1, 2, len(self.regions.support)))
            return AffinePoints(last, np.zeros((1, 2)), deltas, pushed, self)
        none = np.zeros((1, 0))
        return BlendedPoints(last, none.astype(np.intp), none, np.zeros((1, 2)), pushed, self)

    def _blend(self, handles: tuple[Handle, ...]) -> PointSet:
        letter = np.array([h.glyph for h in handles], dtype=np.intp)
        own = [self.glyphs[h.glyph].contours.indices[h.contour][h.segment] for h in handles]
        weights = [bernstein(h.t) for h in handles]
        if not self.is_affine:
            index = np.reshape(own, (-1, 4)).astype(np.intp) + self.first_point[letter][:, None]
            return self._blended(letter, index, np.reshape(weights, (-1, 4)))
        base, deltas = [], []
        for h, points, blend in zip(handles, own, weights, strict=True):
            base.append(blend @ self.glyphs[h.glyph].affine.base[points])
            deltas.append(np.tensordot(blend, self._spread(h.glyph, points), 1))
        count = len(self.regions.support)
        p = len(handles)
        return self._affine(letter, np.reshape(base, (p, 2)), np.reshape(deltas, (p, 2, count)))

    def _spread(self, letter: int, points: Any = slice(None)) -> Array:
        """A letter's deltas (p, 2, M), laid out over the word's merged regions."""
        spread = selection(self.outline_regions[letter], len(self.regions.support))
        return self.glyphs[letter].affine.deltas[points] @ spread

    def _affine(self, letter: IntArray, base: Array, deltas: Array) -> PointSet:
        base = base + self.fixed_offsets[letter]
        return AffinePoints(letter, base, deltas, self._before(letter), self)

    def _blended(self, letter: IntArray, index: IntArray, weights: Array) -> PointSet:
        base = self.fixed_offsets[letter]
        return BlendedPoints(letter, index, weights, base, self._before(letter), self)

    def _before(self, letter: IntArray) -> Array:
        return (np.arange(len(self.glyphs)) < letter[:, None]).astype(np.float64)


def _letter_name(string: str, clusters: list[int], index: int, glyph: Glyph) -> str:
    """The characters that a glyph stands for, or its name where it shares them with another."""
    own = clusters[index]
    if clusters.count(own) > 1:
        return glyph.name
    end = min((cluster for cluster in clusters if cluster > own), default=len(string))
    letters = string[own:end]
    return letters if letters.isprintable() and letters.strip() else glyph.name
