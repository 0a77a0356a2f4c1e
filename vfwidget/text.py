r"""A line of text in a variable font: shaping, Eq. 3, and points upon its outline.

A letter's points are affine in its own scaling factors γ(θ), and its origin is the sum of the
advances before it, each affine in its glyph's γ. So every point of the word, an outline's
control point or any :class:`Handle` on a curve, is

    p̃(Θ) = base + D · γ(θ_letter) + Σ_{z < letter} advance_z(θ_z) x̂,

and a handful of points costs a handful of rows, however large the glyphs are.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from .arrays import Array, ArrayLike, IntArray, like, namespace, to_array, to_tensor
from .bezier import bernstein, nearest, segment_indices
from .coordinates import check_coordinates
from .errors import AxisError, GlyphError
from .font import Font, Glyph, load_font
from .variation import Regions, merge_regions, selection

if TYPE_CHECKING:
    import torch

    from .font.source import FontSource

AxisValues = Mapping[str, Any]


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
    """

    letter: IntArray
    base: Array
    deltas: Array
    before: Array

    @staticmethod
    def join(sets: Sequence[PointSet]) -> PointSet:
        """Several sets of one word as one, in order."""
        return PointSet(
            np.concatenate([s.letter for s in sets]),
            np.concatenate([s.base for s in sets]),
            np.concatenate([s.deltas for s in sets]),
            np.concatenate([s.before for s in sets]),
        )


class Word:
    """The part of a text that no axis changes: its glyphs and their merged regions.

    Functions take Θ as (l, n) or, when shared, (1, n), numpy or torch.

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
        self.glyphs: tuple[Glyph, ...] = tuple(font.glyph(s.glyph_id) for s in shaped)
        self.offsets = np.array([s.offset for s in shaped], dtype=np.float64)
        self.first_point = np.cumsum([0, *(len(g.affine.base) for g in self.glyphs)])
        supports = [g.affine.support for g in self.glyphs]
        supports += [g.affine.advance_support for g in self.glyphs]
        support, indices = merge_regions(supports)
        count = len(self.glyphs)
        self.regions = Regions(support)
        self.outline_regions, self.advance_regions = indices[:count], indices[count:]
        self.advance_base = np.array([g.affine.advance_base for g in self.glyphs])
        self.advance_deltas = np.zeros((count, len(support)))
        for letter, glyph in enumerate(self.glyphs):
            spread = selection(self.advance_regions[letter], len(support))
            self.advance_deltas[letter] = glyph.affine.advance_deltas @ spread

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
        letter = np.array([h.glyph for h in handles], dtype=np.intp)
        base, deltas = [], []
        for h in handles:
            indices = segment_indices(self.glyphs[h.glyph].contours)[h.contour][h.segment]
            weights = bernstein(h.t)
            base.append(weights @ self.glyphs[h.glyph].affine.base[indices])
            deltas.append(np.tensordot(weights, self._spread(h.glyph, indices), 1))
        regions = len(self.regions.support)
        return self._point_set(
            letter, np.reshape(base, (-1, 2)), np.reshape(deltas, (-1, 2, regions))
        )

    def _spread(self, letter: int, points: Any = slice(None)) -> Array:
        """A letter's deltas (p, 2, M), laid out over the word's merged regions."""
        spread = selection(self.outline_regions[letter], len(self.regions.support))
        return self.glyphs[letter].affine.deltas[points] @ spread

    def _point_set(self, letter: IntArray, base: Array, deltas: Array) -> PointSet:
        before = np.arange(len(self.glyphs)) < letter[:, None]
        return PointSet(letter, base + self.offsets[letter], deltas, before.astype(np.float64))

    def advances(self, gamma: Any) -> Any:
        """Advance width of each letter, (l,), from the scaling factors γ (1 or l, M)."""
        varied = (like(self.advance_deltas, gamma) * gamma).sum(-1)
        return (like(self.advance_base, gamma) + varied).clip(0)

    def origins(self, theta: Any) -> Any:
        """The x of each letter's origin, (l,), its constant offset not counted."""
        advances = self.advances(self.regions.scalars(theta))
        return advances.cumsum(0) - advances

    def positions(self, points: PointSet, theta: Any) -> Any:
        """The points at Θ, (p, 2) (Eq. 3)."""
        xp = namespace(theta)
        gamma = self.regions.scalars(theta)
        own = gamma if self.shared else gamma[points.letter]
        moved = (like(points.deltas, theta) @ own[..., None])[..., 0]
        push = like(points.before, theta) @ self.advances(gamma)
        return like(points.base, theta) + moved + xp.stack([push, xp.zeros_like(push)], -1)

    def positions_and_jacobian(self, points: PointSet, theta: Any) -> tuple[Any, Any]:
        """The points at Θ, (p, 2), and their derivative, (p, 2, 1 or l, n), in closed form."""
        xp = namespace(theta)
        gamma, slopes = self.regions.scalars_and_jacobian(theta)
        deltas, before = like(points.deltas, theta), like(points.before, theta)
        advances = self.advances(gamma)
        own_gamma = gamma if self.shared else gamma[points.letter]
        push = before @ advances
        position = like(points.base, theta) + (deltas @ own_gamma[..., None])[..., 0]
        position = position + xp.stack([push, xp.zeros_like(push)], -1)

        # An advance held at zero has no slope.
        rows = like(self.advance_deltas, theta) * (advances > 0)[:, None]
        if self.shared:
            jacobian = deltas @ slopes[0]
            jacobian[:, 0] += before @ (rows @ slopes[0])
            return position, jacobian[:, :, None]
        own = deltas @ slopes[points.letter]
        p, l, n = len(points.letter), len(self.glyphs), theta.shape[-1]
        jacobian = like(np.zeros((p, 2, l, n)), theta)
        jacobian[:, 0] = before[..., None] * (rows[:, None] @ slopes)[:, 0]
        jacobian[xp.arange(p), :, points.letter] += own
        return position, jacobian


class Text:
    """A line of text at one place of its font's design space; it is immutable.

    Parameters
    ----------
    font : Font or what :func:`load_font` takes
    string : str
        Set by HarfBuzz with the font's default features, kerning off: Eq. 3 spaces letters by
        their side bearings alone.
    axes : mapping of tag to user value, or one such mapping per letter, optional
        Missing tags mean default.
    shared : bool
        One axis vector for the whole word, or one for each letter.

    Attributes
    ----------
    word : Word
        What all texts moved from this one share.

    Raises
    ------
    TextError
        The string is empty.
    GlyphError
        The font lacks a character.
    AxisError
        Unknown axis, NaN, or as many axis mappings as there are not letters.

    Notes
    -----
    Θ, here ``theta``, holds normalized coordinates: (1, n) when shared, (l, n) otherwise. Points
    are in font units, y up, the origin at the first letter's left side bearing point.
    """

    def __init__(
        self,
        font: Font | FontSource,
        string: str,
        axes: AxisValues | Sequence[AxisValues] | None = None,
        shared: bool = True,
    ) -> None:
        self.word = Word(load_font(font), string, bool(shared))
        self._theta = self._read_axes(axes if axes is not None else {})
        self._outline: PointSet | None = None

    @property
    def font(self) -> Font:
        """The variable font."""
        return self.word.font

    @property
    def string(self) -> str:
        """The characters."""
        return self.word.string

    @property
    def shared(self) -> bool:
        """Whether all letters share one axis vector."""
        return self.word.shared

    @property
    def glyphs(self) -> tuple[Glyph, ...]:
        """One glyph for each of the l letters; a ligature is one letter."""
        return self.word.glyphs

    def __repr__(self) -> str:
        return f"<Text {self.string!r} in {self.font.family_name!r} at {self.axes}>"

    @property
    def theta(self) -> torch.Tensor:
        """Normalized coordinates, (1, n) when shared, (l, n) otherwise."""
        return to_tensor(self._theta)

    @property
    def axes(self) -> Any:
        """User coordinates by tag: a dict when shared, a list of one dict per letter otherwise."""
        values = [self.font.denormalize(row) for row in self._theta]
        return values[0] if self.shared else values

    def at(
        self,
        axes: AxisValues | Sequence[AxisValues] | None = None,
        theta: ArrayLike | None = None,
    ) -> Text:
        """The same text elsewhere in the design space, by user or by normalized coordinates.

        Parameters
        ----------
        axes : mapping, or one per letter, optional
            User coordinates. Missing tags mean default.
        theta : (1, n) or (l, n) array, optional
            Normalized coordinates. Give this or ``axes``.

        Raises
        ------
        AxisError
            Unknown axis, wrong shape, NaN, or both or neither argument.
        """
        if (axes is None) == (theta is None):
            raise AxisError("Give either axes= or theta=.")
        moved = object.__new__(Text)
        moved.word, moved._outline = self.word, self._outline
        moved._theta = self._read_axes(axes) if axes is not None else to_array(self._check(theta))
        return moved

    def points(self, theta: ArrayLike | None = None) -> torch.Tensor:
        """All control points laid out in the word, (K, 2) (Eq. 3); autograd passes.

        Parameters
        ----------
        theta : (1, n) or (l, n) array, optional
            Where; by default at the text's own place.
        """
        return self.positions(self.point_set(), self._tensor(theta))

    def jacobian(self, theta: ArrayLike | None = None) -> torch.Tensor:
        """Derivative of :meth:`points` by Θ, (K, 2, 1, n) or (K, 2, l, n), in closed form."""
        return self.positions_and_jacobian(self.point_set(), self._tensor(theta))[1]

    def segments(self, theta: ArrayLike | None = None) -> list[torch.Tensor]:
        """Every closed contour of the word, in order, as cubic segments (s, 4, 2)."""
        points = self.points(theta)
        contours = [s for glyph in self.glyphs for s in glyph.contours]
        return [points[indices] for indices in segment_indices(contours)]

    def advance(self) -> float:
        """Width of the whole line, in font units."""
        gamma = self.word.regions.scalars(self._theta)
        return float(self.word.advances(gamma).sum())

    def handle(self, glyph: int = 0, contour: int = 0, segment: int = 0, t: float = 0.0) -> Handle:
        """A point of the outline, by where it lies on it.

        Raises
        ------
        GlyphError
            There is no such letter, contour or segment, or t is not in 0 … 1.
        """
        where = f"glyph={glyph}, contour={contour}, segment={segment}, t={t}"
        try:
            if min(glyph, contour, segment) < 0 or not 0 <= t <= 1:
                raise IndexError
            if segment >= self.glyphs[glyph].contours[contour]:
                raise IndexError
        except (IndexError, TypeError):
            raise GlyphError(f"{self.string!r} has no outline point at {where}.") from None
        return Handle(int(glyph), int(contour), int(segment), float(t), word=self.word)

    def nearest(self, x: float, y: float) -> Handle:
        """The handle of the outline point nearest to (x, y) in the word's font units.

        Raises
        ------
        GlyphError
            The text has no outline (spaces only), or x or y is not finite.
        """
        point = to_array([x, y])
        if not np.isfinite(point).all():
            raise GlyphError(f"The nearest point to ({x}, {y}) cannot be asked for.")
        owners = [
            (letter, contour, segment)
            for letter, glyph in enumerate(self.glyphs)
            for contour, s in enumerate(glyph.contours)
            for segment in range(s)
        ]
        if not owners:
            raise GlyphError(f"{self.string!r} has no outline to take a point of.")
        points = self.positions(self.point_set(), self._theta)
        contours = [s for glyph in self.glyphs for s in glyph.contours]
        index, t = nearest(points[np.concatenate(segment_indices(contours))], point)
        return Handle(*owners[index], t, word=self.word)

    def position(self, handle: Handle) -> torch.Tensor:
        """Where a handle's point lies, (2,), in font units.

        Raises
        ------
        GlyphError
            The handle belongs to another text.
        """
        if not self.owns(handle):
            raise GlyphError(f"{handle!r} is not a handle of this text, {self.string!r}.")
        return to_tensor(self.positions(self.point_set([handle]), self._theta)[0])

    def owns(self, handle: Handle) -> bool:
        """Whether the handle was made by this text, here or elsewhere in its design space."""
        return handle.word is self.word

    @property
    def breakpoints(self) -> list[Array]:
        """For each axis the normalized coordinates at which some point of the text has a kink."""
        return self.word.regions.breakpoints

    def point_set(self, handles: Sequence[Handle] | None = None) -> PointSet:
        """Some of the text's points, or all its control points, ready for :meth:`positions`."""
        if handles is not None:
            return self.word.at_handles(handles)
        if self._outline is None:
            self._outline = self.word.outline()
        return self._outline

    def positions(self, points: PointSet, theta: Any) -> Any:
        """A point set's positions at Θ, (p, 2); arrays stay arrays, tensors tensors."""
        return self.word.positions(points, theta)

    def positions_and_jacobian(self, points: PointSet, theta: Any) -> tuple[Any, Any]:
        """A point set's positions, (p, 2), and their derivative by Θ, (p, 2, 1 or l, n)."""
        return self.word.positions_and_jacobian(points, theta)

    def _tensor(self, theta: ArrayLike | None) -> torch.Tensor:
        return self.theta if theta is None else self._check(theta)

    def _check(self, theta: Any) -> torch.Tensor:
        theta = check_coordinates(theta, len(self.font.axes))
        if theta.ndim == 1 and self.shared:
            theta = theta[None]
        if tuple(theta.shape[:-1]) != (self.word.parameters,):
            raise AxisError(
                f"theta has shape {tuple(theta.shape)}; this text needs "
                f"({self.word.parameters}, {len(self.font.axes)})."
            )
        return theta

    def _read_axes(self, axes: AxisValues | Sequence[AxisValues]) -> Array:
        count = self.word.parameters
        rows = [axes] * count if isinstance(axes, Mapping) else axes
        if isinstance(rows, str) or not isinstance(rows, Sequence) or len(rows) != count:
            raise AxisError(f"Axis values are one mapping, or {count} for this text; not {axes!r}.")
        return np.stack([to_array(self.font.normalize(row)) for row in rows])
