"""A line of text in a variable font, at one place of the font's design space."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from operator import index
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from ..arrays import Array, ArrayLike, to_array, to_tensor
from ..errors import AxisError, GlyphError, TextError
from ..font import Font, Glyph, NamedInstance, load_font
from ..outline.coordinates import check_coordinates
from ..outline.cubics import nearest
from .handle import Handle
from .place import AXES, OFFSETS, Block, Place
from .points import PointSet
from .word import Word

if TYPE_CHECKING:
    import torch

    from ..font.source import FontSource

AxisValues: TypeAlias = "Mapping[str, Any] | NamedInstance | str"
"""Axis values as callers give them: user values by tag, a named instance, or its name."""


class Text:
    """A line of text at one place of its font's design space; it is immutable.

    Parameters
    ----------
    font : Font, or a source that :func:`load_font` takes
    string : str
        Set by HarfBuzz with the font's default features except kerning: Eq. 3 spaces letters by
        their side bearings alone.
    axes : axis values, or a sequence of them with one entry for each letter, optional
        Axis values are a mapping of tag to user value, an entry of ``font.instances``, or the
        name of one. An axis that is not in a mapping takes its default value.
    shared : bool
        True (the default) for one axis vector for the whole word, False for one for each letter.
    offsets : (l, 2) array, optional
        Displacement of each letter from the position that the layout gives it, in font units.
        Default 0.

    Attributes
    ----------
    word : Word
        The data that all texts moved from this one share.

    Raises
    ------
    TextError
        The string is empty or holds invisible characters only, or ``offsets`` has the wrong shape.
    GlyphError
        The font lacks a character.
    AxisError
        The axis is unknown, a value is NaN, the number of entries differs from the number of
        letters, or the instance belongs to another font.

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
        *,
        offsets: ArrayLike | None = None,
    ) -> None:
        self.word = Word(load_font(font), string, bool(shared))
        self._axes: list[dict[str, float]] | None
        self._theta, self._axes = self._read_axes(axes if axes is not None else {})
        self._offsets = np.zeros((len(self.glyphs), 2))
        if offsets is not None:
            self._offsets = self._read_offsets(offsets)
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

    @property
    def place(self) -> Place:
        """Where the text stands, by block of unknowns: ``"axes"`` (Θ) and ``"offsets"`` (l, 2)."""
        return Place({AXES: self._theta, OFFSETS: self._offsets})

    @property
    def blocks(self) -> dict[str, Block]:
        """The text's unknowns with their bounds, for a solve."""
        axes = Block(self._theta, *self.word.bounds, self.word.kinks)
        return {AXES: axes, OFFSETS: Block(self._offsets)}

    def at(
        self,
        axes: AxisValues | Sequence[AxisValues] | None = None,
        theta: ArrayLike | None = None,
        offsets: ArrayLike | None = None,
    ) -> Text:
        """The same text elsewhere in the design space, by user or by normalized coordinates.

        Parameters
        ----------
        axes : axis values, or one for each letter, optional
            As for :class:`Text`: ``text.at({"wght": 700})``, ``text.at("Bold")``.
        theta : (1, n) or (l, n) array, optional
            Normalized coordinates. Give either this or ``axes``.
        offsets : (l, 2) array, optional
            New displacements of the letters, in font units. By default they stay.

        Raises
        ------
        AxisError
            The axis or instance is unknown, a shape is wrong, a value is NaN, both ``axes`` and
            ``theta`` are given, or no argument at all.
        TextError
            ``offsets`` has the wrong shape or holds NaN.
        """
        if (axes is None) == (theta is None) and (offsets is None or axes is not None):
            raise AxisError("Give either axes= or theta=.")
        coordinates, values = self._theta, self._axes
        if axes is not None:
            coordinates, values = self._read_axes(axes)
        elif theta is not None:
            coordinates, values = to_array(self._check(theta)).copy(), None
        moved = self.moved(coordinates, values)
        if offsets is not None:
            moved._offsets = self._read_offsets(offsets)
        return moved

    def moved(self, coordinates: Array, axes: list[dict[str, float]] | None = None) -> Text:
        """:meth:`at`, for normalized coordinates that need no check."""
        moved = object.__new__(Text)
        moved.word, moved._outline = self.word, self._outline
        moved._theta, moved._axes, moved._offsets = coordinates, axes, self._offsets
        return moved

    def moved_to(self, place: Mapping[str, Array]) -> Text:
        """The same text at a place of its unknowns, which needs no check."""
        moved = self.moved(place[AXES])
        moved._offsets = place[OFFSETS]
        return moved

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_outline": None}

    def __deepcopy__(self, memo: Any) -> Text:
        return self

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
        return float(self.word.advances(self._theta).sum())

    def to_font(self, path: str | os.PathLike[str] | None = None, name: str | None = None) -> Font:
        """The text's glyphs at its location as a static font; ``path`` writes it to a file, too.

        ``name`` is its family name; by default the parent's, followed by the axis values.

        Raises
        ------
        TextError
            The letters have axis values of their own.
        FontError
            fontTools cannot make the instance.
        """
        if not self.shared:
            raise TextError("to_font needs one location for all letters; use shared=True.")
        font = self.font.instance(self.axes, name, self.string)
        if path is not None:
            font.save(path)
        return font

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
            raise GlyphError(f"x and y must be finite numbers; received ({x}, {y}).")
        owners = [
            (letter, contour, segment)
            for letter, glyph in enumerate(self.glyphs)
            for contour, s in enumerate(glyph.contours)
            for segment in range(s)
        ]
        if not owners:
            raise GlyphError(f"{self.string!r} has no outline, so it has no nearest point.")
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
        return isinstance(handle, Handle) and handle.word is self.word

    @property
    def breakpoints(self) -> list[Array]:
        """For each axis the normalized coordinates at which some point of the text has a kink."""
        return self.word.breakpoints

    def point_set(self, handles: Sequence[Handle] | None = None) -> PointSet:
        """Some of the text's points, or all its control points, ready for :meth:`positions`."""
        if handles is not None:
            return self.word.at_handles(handles)
        if self._outline is None:
            self._outline = self.word.outline()
        return self._outline

    def positions(self, points: PointSet, theta: Any) -> Any:
        """A point set's positions at Θ, (p, 2); arrays stay arrays, tensors tensors."""
        return points.positions({AXES: theta, OFFSETS: self._offsets})

    def positions_and_jacobian(self, points: PointSet, theta: Any) -> tuple[Any, Any]:
        """A point set's positions, (p, 2), and their derivative by Θ, (p, 2, 1 or l, n)."""
        return points.positions_and_jacobian({AXES: theta, OFFSETS: self._offsets})

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
        single = isinstance(axes, Mapping | NamedInstance | str)
        rows = [axes] * count if single else axes
        if not isinstance(rows, Sequence) or len(rows) != count:
            raise AxisError(
                f"Axis values are one mapping or instance, or {count} for this text; not {axes!r}."
            )
        mappings = [self._values(row) for row in rows]
        theta = np.stack([to_array(self.font.normalize(row)) for row in mappings])
        return theta, [self._complete(row) for row in mappings]

    def _values(self, row: Any) -> Mapping[str, Any]:
        """User values by tag, from a mapping, an instance or the name of an instance."""
        if isinstance(row, str):
            named = {instance.name: instance for instance in self.font.instances}
            if row not in named:
                raise AxisError(
                    f"{self.font.family_name} has no instance {row!r}; "
                    f"it has {', '.join(named) or 'none'}."
                )
            row = named[row]
        if isinstance(row, NamedInstance):
            if row not in self.font.instances:
                raise AxisError(f"{row.name!r} is not an instance of {self.font.family_name}.")
            row = row.axes
        if not isinstance(row, Mapping):
            raise AxisError(f"Axis values are a mapping of tag to number, not {row!r}.")
        return row

    def _complete(self, row: Mapping[str, Any]) -> dict[str, float]:
        values = {}
        for axis in self.font.axes:
            value = float(row.get(axis.tag, axis.default))
            values[axis.tag] = min(max(value, axis.minimum), axis.maximum)
        return values

    def _read_offsets(self, offsets: ArrayLike) -> Array:
        shape = (len(self.glyphs), 2)
        try:
            values = to_array(offsets).copy()
        except (TypeError, ValueError, RuntimeError):
            values = np.zeros(0)
        if values.shape != shape or not np.isfinite(values).all():
            raise TextError(
                f"offsets must be finite numbers of shape {shape}, one displacement (x, y) for "
                f"each letter; received {offsets!r:.200}."
            )
        return values
