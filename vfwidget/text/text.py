"""A line of text in a variable font, at one location of the font's design space."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from operator import index
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arrays import Array, ArrayLike, to_array, to_tensor
from ..errors import AxisError, GlyphError
from ..font import Font, Glyph, load_font
from ..font.shaping_options import FeatureValues
from .composition import Composition
from .exports import Exports
from .handle import Handle
from .inputs import AxisValues, read_axes, read_length, read_letters, read_point, read_theta
from .layout import PlacedGlyph
from .locate import carry, nearest_handle
from .place import AXES, OFFSETS, ROTATIONS, TRACKING, Block, Place
from .points import PointSet, RotatedPoints

if TYPE_CHECKING:
    import torch

    from ..font.source import FontSource


class Text(Exports):
    r"""A line of text at one location of its font's design space; it is immutable.

    Parameters
    ----------
    font : Font, or a source that :func:`load_font` takes
    string : str
        HarfBuzz sets it, with the font's default features. Lines are separated by ``"\n"``,
        ``"\r\n"`` or ``"\r"``.
    axes : axis values, or a sequence of them with one entry for each letter, optional
        Axis values are a mapping of tag to user value, an entry of ``font.instances``, or the
        name of one. An axis that is not in a mapping takes its default value.
    shared : bool
        True (the default) for one axis vector for the whole word, False for one for each letter.
    offsets : (l, 2) array, optional
        Displacement of each letter from the position that the layout gives it, in font units.
        Default 0.
    rotations : (l,) array, optional
        Angle of each letter about its origin, in radians, counterclockwise. Default 0. Solves
        keep the angles.
    tracking : float
        Space that is added after each grapheme, in font units. Default 0.
    features : mapping of str to bool, int or ranges, optional
        OpenType features to switch on or off, or alternates to choose: ``{"smcp": True}``. With
        ``{"kern": False}`` letters are spaced by their side bearings alone, as in Eq. 3. For some
        characters of the string only, add a range to the tag, as for hb-shape
        (``{"liga[1:3]": False}``), or give (start, end, value) for each range, as for uharfbuzz
        (``{"liga": [(1, 3, False)]}``). Where ranges overlap, the later one counts; give the value
        for the whole text first.
    language : str, optional
        BCP 47 tag such as ``"sr"``, of registered codes or for private use (``"x-mine"``).
    script : str, optional
        ISO 15924 tag such as ``"Arab"``. Default: that of the characters.
    direction : {"ltr", "rtl"}, optional
        Direction of each line as a paragraph (Unicode Standard Annex 9). Default: that of its
        first letter.
    line_height : float, optional
        Distance between the baselines of two lines, in font units. Default: ascender minus
        descender.

    Attributes
    ----------
    rotations : (l,) array
    word : Word
        The glyphs, and how they vary; shared by texts that :meth:`at` makes, if these are equal.
    composition : Composition
        The string, the font and the options.

    Raises
    ------
    TextError
        The string is empty or holds invisible characters only, an option does not exist,
        ``offsets`` has the wrong shape, or HarfBuzz sets the text in a way that vfwidget cannot
        follow.
    GlyphError
        The font lacks a character.
    AxisError
        The axis is unknown, a value is NaN, the number of entries differs from the number of
        letters, or the instance belongs to another font.

    Notes
    -----
    Θ, here ``theta``, holds normalized coordinates: (1, n) when shared, (l, n) otherwise. Points
    are in font units, y up; each line starts at x = 0, the first one at y = 0. Which glyphs the
    text has depends on the location (:class:`Settings`), and so does ``word``.
    """

    def __init__(
        self,
        font: Font | FontSource,
        string: str,
        axes: AxisValues | Sequence[AxisValues] | None = None,
        shared: bool = True,
        *,
        offsets: ArrayLike | None = None,
        rotations: ArrayLike | None = None,
        tracking: float = 0.0,
        features: FeatureValues | None = None,
        language: str | None = None,
        script: str | None = None,
        direction: str | None = None,
        line_height: float | None = None,
    ) -> None:
        font = load_font(font)
        options = font.shaping_options(features, language, script, direction)
        self.composition = Composition(font, string, shared, line_height, options)
        self._axes: list[dict[str, float]] | None
        self._theta, self._axes = read_axes(
            self.font, self.composition.parameters, axes if axes is not None else {}
        )
        self.word = self.composition.word_at(self._theta)
        letters = len(self.glyphs)
        self._offsets = read_letters("offsets", offsets, (letters, 2))
        self.rotations = read_letters("rotations", rotations, (letters,))
        self._tracking = np.array([read_length("tracking", tracking)])

    @property
    def font(self) -> Font:
        """The variable font."""
        return self.composition.font

    @property
    def string(self) -> str:
        """The characters."""
        return self.composition.string

    @property
    def shared(self) -> bool:
        """Whether all letters share one axis vector."""
        return self.composition.shared

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
        """Where the text stands, by block of unknowns.

        The blocks are ``"axes"`` (Θ), ``"offsets"`` (l, 2) and ``"tracking"`` (1,).
        """
        return Place({AXES: self._theta, OFFSETS: self._offsets, TRACKING: self._tracking})

    @property
    def tracking(self) -> float:
        """Space that is added after each grapheme, in font units."""
        return float(self._tracking[0])

    @property
    def layout(self) -> list[PlacedGlyph]:
        """Where each glyph stands, in drawing order."""
        word, letters = self.word, range(len(self.glyphs))
        origins = word.origins_at(self._theta)[letters]
        origins[:, 0] += self._tracking * word.origins.gaps[letters]
        origins += self._offsets
        advances = word.set_advances(self._theta) + self._tracking * word.origins.ends_grapheme
        rows = zip(word.glyph_ids, word.glyphs, word.clusters, *origins.T, advances, strict=True)
        return [PlacedGlyph(*row[:3], *map(float, row[3:])) for row in rows]

    @property
    def blocks(self) -> dict[str, Block]:
        """The text's unknowns with their bounds, for a solve: the box in which its glyphs stay."""
        axes = Block(self._theta, *self.composition.bounds_at(self._theta), self.word.kinks)
        return {AXES: axes, OFFSETS: Block(self._offsets), TRACKING: Block(self._tracking)}

    def at(
        self,
        axes: AxisValues | Sequence[AxisValues] | None = None,
        theta: ArrayLike | None = None,
        offsets: ArrayLike | None = None,
        rotations: ArrayLike | None = None,
        tracking: float | None = None,
        shared: bool | None = None,
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
        rotations : (l,) array, optional
            New angles of the letters, in radians. By default they stay.
        tracking : float, optional
            New space after each grapheme, in font units. By default it stays.
        shared : bool, optional
            Whether the new text's letters share their axes; after a change, handles are not valid.

        Raises
        ------
        AxisError
            The axis or instance is unknown, a shape is wrong, a value is NaN, both ``axes`` and
            ``theta`` are given, or no argument at all.
        TextError
            Another argument has the wrong shape or type, or is not finite.
        """
        if axes is not None and theta is not None:
            raise AxisError("Give either axes= or theta=, not both.")
        if all(one is None for one in (axes, theta, offsets, rotations, tracking, shared)):
            raise AxisError(
                "Give at least one of axes=, theta=, offsets=, rotations=, tracking= and shared=."
            )
        text = self
        if shared is not None and shared != self.shared:
            text = self._regrouped(shared)
        coordinates, values = text._theta, text._axes
        if axes is not None:
            coordinates, values = read_axes(self.font, text.composition.parameters, axes)
        elif theta is not None:
            coordinates, values = to_array(read_theta(theta, text._theta.shape)).copy(), None
        moved = text.moved(coordinates, values)
        letters = len(moved.glyphs)
        if offsets is not None:
            moved._offsets = read_letters("offsets", offsets, (letters, 2))
        if rotations is not None:
            moved.rotations = read_letters("rotations", rotations, (letters,))
        if tracking is not None:
            moved._tracking = np.array([read_length("tracking", tracking)])
        return moved

    def _regrouped(self, shared: bool) -> Text:
        """The text with axes for each letter, or with those of its first letter for all."""
        text = object.__new__(Text)
        text.__dict__.update(self.__dict__)
        text.composition = self.composition.regrouped(shared)
        text._axes = None
        return text.moved(np.repeat(self._theta[:1], text.composition.parameters, axis=0))

    def moved(self, coordinates: Array, axes: list[dict[str, float]] | None = None) -> Text:
        """:meth:`at`, for normalized coordinates that need no check."""
        moved = object.__new__(Text)
        moved.composition, moved._tracking = self.composition, self._tracking
        moved._theta, moved._axes = coordinates, axes
        moved.word = self.composition.word_at(coordinates)
        moved._offsets, moved.rotations = self._offsets, self.rotations
        if moved.word is not self.word and len(moved.glyphs) != len(self.glyphs):
            moved._offsets = np.zeros((len(moved.glyphs), 2))
            moved.rotations = np.zeros(len(moved.glyphs))
        return moved

    def moved_to(self, place: Mapping[str, Array]) -> Text:
        """The same text with other values of its unknowns, which need no check."""
        moved = self.moved(place[AXES])
        moved._tracking = place[TRACKING]
        if len(place[OFFSETS]) == len(moved.glyphs):
            moved._offsets = place[OFFSETS]
            moved.rotations = place.get(ROTATIONS, moved.rotations)
        return moved

    def __deepcopy__(self, memo: Any) -> Text:
        return self

    @property
    def coordinates(self) -> Array:
        """:attr:`theta` as the array itself; do not write to it."""
        return self._theta

    def points(self, theta: ArrayLike | None = None) -> torch.Tensor:
        """All control points laid out in the word, (K, 2) (Eq. 3); autograd passes.

        Parameters
        ----------
        theta : (1, n) or (l, n) array, optional
            Normalized coordinates. Default: those of the text.
        """
        return self.positions(self.point_set(), self._tensor(theta))

    def jacobian(self, theta: ArrayLike | None = None) -> torch.Tensor:
        """Derivative of :meth:`points` by Θ, (K, 2, 1, n) or (K, 2, l, n), in closed form.

        On a kink it is the one to the right, at the upper end of an axis the one to the left
        (autograd of fonts with avar 2 or VARC may find the other one).
        """
        return self.positions_and_jacobian(self.point_set(), self._tensor(theta))[1]

    def segments(self, theta: ArrayLike | None = None) -> list[torch.Tensor]:
        """Every closed contour of the word, in order, as cubic segments (s, 4, 2)."""
        return self.word.contours.split(self.points(theta))

    def advance(self) -> float:
        """Width of the text, in font units: that of its longest line."""
        return float(self.positions(self.word.ends, self._theta)[:, 0].max())

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
        point = read_point(x, y)
        return nearest_handle(self.word, self.positions(self.point_set(), self._theta), point)

    def position(self, handle: Handle) -> torch.Tensor:
        """Where a handle's point lies, (2,), in font units.

        Raises
        ------
        GlyphError
            The handle belongs to another text.
        """
        return to_tensor(self.positions(self.point_set([handle]), self._theta)[0])

    def owns(self, handle: Handle) -> bool:
        """Whether the handle was made by this text, here or elsewhere in its design space."""
        return isinstance(handle, Handle) and handle.word.composition is self.composition

    def carry(self, handle: Handle) -> Handle:
        """The point of this text's outline that corresponds to a handle made elsewhere.

        Where a glyph is another one here, the handle keeps its contour, segment and parameter if
        both glyphs have the same contours. Otherwise it becomes the nearest point of the outline,
        measured between the default outlines of both glyphs.

        Raises
        ------
        GlyphError
            The handle belongs to another text, or its letter has no outline here.
        """
        if not self.owns(handle):
            raise GlyphError(f"{handle!r} is not a handle of this text, {self.string!r}.")
        return carry(handle, self.word)

    @property
    def breakpoints(self) -> list[Array]:
        """For each axis the normalized coordinates at which some point of the text has a kink."""
        return self.word.breakpoints

    def point_set(self, handles: Sequence[Handle] | None = None) -> PointSet:
        """Some of the text's points, or all its control points, ready for :meth:`positions`."""
        word = self.word
        points = word.outline if handles is None else word.at_handles(map(self.carry, handles))
        return (
            RotatedPoints.of(points, self.rotations) if np.count_nonzero(self.rotations) else points
        )

    def positions(self, points: PointSet, theta: Any) -> Any:
        """A point set's positions at Θ, (p, 2); arrays stay arrays, tensors tensors."""
        return points.positions({**self._linear, AXES: theta})

    def positions_and_jacobian(self, points: PointSet, theta: Any) -> tuple[Any, Any]:
        """A point set's positions, (p, 2), and their derivative by Θ, (p, 2, 1 or l, n)."""
        return points.positions_and_jacobian({**self._linear, AXES: theta})

    @property
    def _linear(self) -> dict[str, Array]:
        """The blocks of the place in which points are linear."""
        return {OFFSETS: self._offsets, TRACKING: self._tracking}

    def _tensor(self, theta: ArrayLike | None) -> torch.Tensor:
        return self.theta if theta is None else read_theta(theta, self._theta.shape)
