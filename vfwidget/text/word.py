"""The part of a text that no axis changes: its glyphs, and how they vary together."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from ..arrays import Array, IntArray, like, namespace, padded_table, to_array
from ..font import Font, Glyph
from ..font.shaping import LINE_BREAK
from ..outline.composed import Composed
from ..outline.contours import Contours
from ..outline.cubics import bernstein
from ..outline.drawn import as_drawn
from ..outline.variation import Regions, merge_regions, selection
from ..outline.varying import Affine
from .handle import Handle
from .layout import Layout
from .memo import Memo
from .origins import Origins
from .points import AffinePoints, BlendedPoints, PointSet


class Word:
    """A row of glyphs that all texts moved within its settings share; it is immutable.

    Parameters
    ----------
    composition : Composition
    rows : tuple of int
        The row of glyphs of the composition that the letters are taken from: one, or one per
        letter.
    layouts : sequence of Layout
        The layout of each letter.

    Attributes
    ----------
    glyphs : tuple of Glyph
    letter_names : tuple of str
        The character of each letter, or its glyph name where it has no single character.
    distinct_names : tuple of str
        The same, and which one it is where several letters have one name: ``"2nd l"``.
    is_affine : bool
        Whether all glyphs are affine in the scalars of their regions.
    origins : Origins
        The origins of the letters, and the ends of the lines.
    scalars : Varying
        The scalars of these regions as functions of a letter's axes, (M,).
    regions : Regions
        The M regions over which the layout varies, and those of every affine word's glyphs. The
        attributes below exist for affine words only.
    outline_regions, advance_regions : list of int arrays
        The indices, among the M regions, of each letter's delta sets and advance deltas.
    advance_base : (l,) array
    advance_deltas : (l, M) array
    """

    def __init__(self, composition: Any, rows: tuple[int, ...], layouts: Sequence[Layout]) -> None:
        self.composition, self.rows = composition, rows
        self.font: Font = composition.font
        self.string: str = composition.string
        self.shared: bool = composition.shared
        self.layouts = tuple(layouts)
        self.glyph_ids = tuple(layout.row.glyph_ids[i] for i, layout in enumerate(layouts))
        self.clusters = layouts[0].row.clusters
        glyphs = map(self.font.glyph, self.glyph_ids)
        self.glyphs: tuple[Glyph, ...] = tuple(
            map(as_drawn, glyphs) if composition.drawn else glyphs
        )
        self.letter_names = _letter_names(self.string, self.clusters, self.glyphs)
        self.is_affine = all(glyph.is_affine for glyph in self.glyphs)
        supports = [layout.support for layout in layouts]
        if self.is_affine:
            affine = [glyph.affine for glyph in self.glyphs]
            supports += [g.support for g in affine] + [g.advance_support for g in affine]
        support, indices = merge_regions(supports)
        self.regions = Regions(support, self.font.bounds[1])
        m = len(support)
        self.scalars = self.font.over_axes(Affine(np.zeros(m), np.eye(m), support))
        count = len(layouts)
        self.origins = Origins(layouts, indices[:count], m, self.shared, composition.line_height)
        if self.is_affine:
            self._place_glyphs(indices[count:])
        self._point_sets: Memo[PointSet] = Memo()
        self.carried: Memo[Handle] = Memo()
        """Handles of the same text in another setting, as handles of this word."""
        self.compiled_rows: Memo[Any] = Memo(16)
        """What energies compile from affine terms, for the next solve with the same ones."""
        self.latest_energy: Any = None
        """The energy of the latest solve: the next one often has the same terms."""

    @cached_property
    def distinct_names(self) -> tuple[str, ...]:
        """See the class."""
        counts, seen, names = Counter(self.letter_names), Counter[str](), []
        for name in self.letter_names:
            seen[name] += 1
            names.append(f"{_ordinal(seen[name])} {name}" if counts[name] > 1 else name)
        return tuple(names)

    def _place_glyphs(self, indices: list[IntArray]) -> None:
        """Lay the deltas of the glyphs out over the word's regions."""
        affine, count = [glyph.affine for glyph in self.glyphs], len(self.glyphs)
        support = self.regions.support
        self.outline_regions, self.advance_regions = indices[:count], indices[count:]
        self.advance_base = np.array([g.advance_base for g in affine])
        self.advance_deltas = np.zeros((count, len(support)))
        for letter, own in enumerate(affine):
            spread = selection(self.advance_regions[letter], len(support))
            self.advance_deltas[letter] = own.advance_deltas @ spread

    def __reduce__(self) -> Any:
        return _word, (self.composition, self.rows)

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
    def breakpoints(self) -> list[Array]:
        """For each axis the sorted normalized coordinates at which some point has a kink."""
        varying = [v for glyph in self.glyphs for v in (glyph.outline, glyph.advance_width)]
        by_axis = zip(self.scalars.breakpoints, *(v.breakpoints for v in varying), strict=True)
        return [np.unique(np.concatenate(values)) for values in by_axis]

    @cached_property
    def final_breakpoints(self) -> list[Array]:
        """The same in final coordinates, for a font whose axes move others."""
        varying = [v for glyph in self.glyphs for v in (glyph.outline, glyph.advance_width)]
        inner = [v.outer.breakpoints for v in (self.scalars, *varying) if isinstance(v, Composed)]
        return [np.unique(np.concatenate(values)) for values in zip(*inner, strict=True)]

    @cached_property
    def kinks(self) -> Array:
        """The same for each entry of flat Θ, (parameters · n, q), padded with infinity."""
        return np.tile(padded_table(self.breakpoints), (self.parameters, 1))

    @cached_property
    def can_vanish(self) -> Array:
        """Letters whose advance might be clamped at 0 somewhere, (l,): its least sum is < 0."""
        return self.advance_base + np.minimum(self.advance_deltas, 0).sum(1) < 0

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

    def origins_at(self, theta: Any) -> Any:
        """Origins of the letters and ends of the lines at Θ, (..., l + lines, 2).

        Tracking and offsets are not counted.
        """
        return self.origins.value(self.scalars.value(theta), self.advances(theta))

    def set_advances(self, theta: Array) -> Array:
        """Advance of each letter at Θ with its kerning, (l,).

        As for the origins, kerning is the mean of its values at the letter and at the next one.
        """
        widths, count = self.advances(theta), len(self.glyphs)
        following = np.arange(count)
        for k in np.flatnonzero(self.origins.is_base):
            if self.origins.anchor[k] >= 0:
                following[self.origins.anchor[k]] = k
        gammas = [
            Regions(layout.support).scalars(to_array(self.font.final_coordinates(w)))
            for layout, (_, w) in zip(self.layouts, self.letters(theta), strict=True)
        ]

        def kern(letter: int, at: int) -> Any:
            layout = self.layouts[at]
            return layout.advance_base[letter] + layout.advance_deltas[letter] @ gammas[at]

        means = [(kern(i, i) + kern(i, int(following[i]))) / 2 for i in range(count)]
        return np.array([layout.own[i] for i, layout in enumerate(self.layouts)]) * widths + means

    def letters(self, theta: Any) -> Iterator[tuple[Glyph, Any]]:
        """Each glyph with its own coordinates (..., n)."""
        for i, glyph in enumerate(self.glyphs):
            yield glyph, theta[..., 0 if self.shared else i, :]

    @cached_property
    def outline(self) -> PointSet:
        """All control points, letter after letter."""
        count = len(self.glyphs)
        letter = np.repeat(np.arange(count), np.diff(self.first_point))
        if self.is_affine:
            base = np.concatenate([glyph.affine.base for glyph in self.glyphs])
            deltas = np.concatenate([self._spread(i) for i in range(count)])
            return AffinePoints(letter, letter, base, deltas, self)
        index = np.arange(len(letter))[:, None]
        return BlendedPoints(letter, letter, index, np.ones(index.shape), self)

    def at_handles(self, handles: Iterable[Handle]) -> PointSet:
        """The handles' points, each a blend of the four control points of its segment."""
        key = tuple(handles)
        return self._point_sets.get(key, lambda: self._blend(key))

    @cached_property
    def ends(self) -> PointSet:
        """The end of each line with a letter, where the next letter's origin would be."""
        origin = len(self.glyphs) + np.unique(self.layouts[0].row.lines)
        letter = np.maximum([self.layouts[0].anchor[k] for k in origin], 0)
        return self._bare(letter, origin)

    def starts(self, letter: IntArray) -> PointSet:
        """The origins of letters, (p,)."""
        return self._bare(letter, letter)

    def _bare(self, letter: IntArray, origin: IntArray) -> PointSet:
        """Points that lie at an origin."""
        if self.is_affine:
            deltas = np.zeros((len(origin), 2, len(self.regions.support)))
            return AffinePoints(letter, origin, np.zeros((len(origin), 2)), deltas, self)
        none = np.zeros((len(origin), 0))
        return BlendedPoints(letter, origin, none.astype(np.intp), none, self)

    def _blend(self, handles: tuple[Handle, ...]) -> PointSet:
        letter = np.array([h.glyph for h in handles], dtype=np.intp)
        own = [self.glyphs[h.glyph].contours.indices[h.contour][h.segment] for h in handles]
        weights = [bernstein(h.t) for h in handles]
        if not self.is_affine:
            index = np.reshape(own, (-1, 4)).astype(np.intp) + self.first_point[letter][:, None]
            return BlendedPoints(letter, letter, index, np.reshape(weights, (-1, 4)), self)
        base, deltas = [], []
        for h, points, blend in zip(handles, own, weights, strict=True):
            base.append(blend @ self.glyphs[h.glyph].affine.base[points])
            deltas.append(np.tensordot(blend, self._spread(h.glyph, points), 1))
        count = len(self.regions.support)
        p = len(handles)
        flat, spread = np.reshape(base, (p, 2)), np.reshape(deltas, (p, 2, count))
        return AffinePoints(letter, letter, flat, spread, self)

    def _spread(self, letter: int, points: Any = slice(None)) -> Array:
        """A letter's deltas (p, 2, M), laid out over the word's merged regions."""
        spread = selection(self.outline_regions[letter], len(self.regions.support))
        return self.glyphs[letter].affine.deltas[points] @ spread


def _word(composition: Any, rows: tuple[int, ...]) -> Word:
    word: Word = composition.word(rows)
    return word


def _ordinal(number: int) -> str:
    teens = 10 < number % 100 < 14
    return f"{number}{'th' if teens else {1: 'st', 2: 'nd', 3: 'rd'}.get(number % 10, 'th')}"


def _letter_names(string: str, clusters: Sequence[int], glyphs: Sequence[Glyph]) -> tuple[str, ...]:
    """The characters that each glyph stands for, or its name where it shares them with another."""
    sizes = Counter(clusters)
    starts = sorted(sizes)
    ends = [*starts[1:], len(string)]
    characters = {a: LINE_BREAK.sub("", string[a:b]) for a, b in zip(starts, ends, strict=True)}
    return tuple(
        letters if sizes[own] == 1 and letters.isprintable() and letters.strip() else glyph.name
        for own, glyph in zip(clusters, glyphs, strict=True)
        for letters in [characters[own]]
    )
