"""A line of text in a variable font, and the points of its outline a person takes hold of."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from operator import index
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arrays import Array, ArrayLike, to_array, to_tensor
from ..errors import AxisError, GlyphError
from ..font import Font, Glyph, load_font
from ..outline.coordinates import check_coordinates
from ..outline.cubics import nearest
from .word import Handle, PointSet, Word

if TYPE_CHECKING:
    import torch

    from ..font.source import FontSource

AxisValues = Mapping[str, Any]


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
        The string is empty, or holds invisible characters only.
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
        self._axes: list[dict[str, float]] | None
        self._theta, self._axes = self._read_axes(axes if axes is not None else {})
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
        if self._axes is None:
            self._axes = [self.font.denormalize(row) for row in self._theta]
        values = [dict(row) for row in self._axes]
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
        if axes is not None:
            return self.moved(*self._read_axes(axes))
        return self.moved(to_array(self._check(theta)).copy())

    def moved(self, coordinates: Array, axes: list[dict[str, float]] | None = None) -> Text:
        """:meth:`at`, for coordinates that need no check."""
        moved = object.__new__(Text)
        moved.word, moved._outline = self.word, self._outline
        moved._theta, moved._axes = coordinates, axes
        return moved

    @property
    def coordinates(self) -> Array:
        """:attr:`theta` as the array it is, not to be written to."""
        return self._theta

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
        return self.word.contours.split(self.points(theta))

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
            glyph, contour, segment = index(glyph), index(contour), index(segment)
            if min(glyph, contour, segment) < 0 or not 0 <= t <= 1:
                raise IndexError
            if segment >= self.glyphs[glyph].contours[contour]:
                raise IndexError
        except (IndexError, TypeError):
            raise GlyphError(f"{self.string!r} has no outline point at {where}.") from None
        return Handle(glyph, contour, segment, float(t), word=self.word)

    def nearest(self, x: float, y: float) -> Handle:
        """The handle of the outline point nearest to (x, y) in the word's font units.

        Raises
        ------
        GlyphError
            The text has no outline (spaces only), or x or y is not finite.
        """
        try:
            point = np.array([float(x), float(y)])
        except (TypeError, ValueError, OverflowError, RuntimeError):
            point = np.array([np.nan, np.nan])
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
        found, t = nearest(points[self.word.contours.segments], point)
        return Handle(*owners[found], t, word=self.word)

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

    def _read_axes(
        self, axes: AxisValues | Sequence[AxisValues]
    ) -> tuple[Array, list[dict[str, float]]]:
        """Θ, and the user values it came from, which normalizing and back would only round."""
        count = self.word.parameters
        rows = [axes] * count if isinstance(axes, Mapping) else axes
        if isinstance(rows, str) or not isinstance(rows, Sequence) or len(rows) != count:
            raise AxisError(f"Axis values are one mapping, or {count} for this text; not {axes!r}.")
        theta = np.stack([to_array(self.font.normalize(row)) for row in rows])
        return theta, [self._complete(row) for row in rows]

    def _complete(self, row: AxisValues) -> dict[str, float]:
        values = {}
        for axis in self.font.axes:
            value = float(row.get(axis.tag, axis.default))
            values[axis.tag] = min(max(value, axis.minimum), axis.maximum)
        return values
