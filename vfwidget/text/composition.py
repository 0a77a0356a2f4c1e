"""A string set in a font, over the whole design space: which word it is at each location."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from threading import Lock
from typing import Any, NamedTuple
from uuid import uuid4
from weakref import WeakValueDictionary

import numpy as np

from ..arrays import Array, IntArray, holds_anywhere, to_array
from ..font import Font
from ..font.settings import Settings
from ..font.shaping_options import ShapingOptions
from ..outline.composed import Displaced
from .inputs import read_flag, read_length
from .layout import Layout, layouts
from .memo import Memo
from .word import Word

MOST_SETTINGS = 4
"""So many settings are kept for the next calls."""
HALVINGS = 15
"""Bisections for a side of a box: to 1/16384 of the range of an axis."""


class Setting(NamedTuple):
    """A word, and the box of Θ in which the text is that word: two corners of its shape."""

    word: Word
    lower: Array
    upper: Array

    def misses(self, theta: Array) -> bool:
        """Whether Θ lies outside the box."""
        return holds_anywhere((theta < self.lower) | (theta > self.upper))


class Composition:
    """What does not change when a text moves: font, string, and how HarfBuzz sets it.

    Parameters
    ----------
    font : Font
    string : str
    shared : bool
        Whether all letters share one axis vector.
    line_height : float, optional
        Distance between the baselines of two lines, in font units. Default: ascender minus
        descender.
    options : ShapingOptions
    drawn : bool
        Whether the outlines of colour glyphs are those of their layers. Default False.

    Attributes
    ----------
    settings : Settings
        The boxes of the design space in each of which the string has one row of glyphs.

    Raises
    ------
    TextError
        The string is empty, or the text cannot be laid out.
    GlyphError
        The font lacks a character.
    """

    def __init__(
        self,
        font: Font,
        string: str,
        shared: bool,
        line_height: float | None,
        options: ShapingOptions,
        drawn: bool = False,
    ) -> None:
        self.font, self.string, self.shared = font, string, read_flag("shared", shared)
        if line_height is None:
            line_height = font.ascender - font.descender
        self.line_height = read_length("line_height", line_height)
        self.options, self.drawn = options, drawn
        self._layouts = layouts(font, string, self.options)
        self._words: Memo[Word] = Memo()
        self.corresponding: Memo[tuple[int, float]] = Memo(1024)
        """Points of one glyph that stand for those of another, for handles."""
        self._latest: tuple[Array | None, list[Setting]] = None, []
        self._name = uuid4().hex
        _known[self._name] = self

    def regrouped(self, shared: bool) -> Composition:
        """The same string with axes shared by all letters, or not."""
        return self._with(shared, self.drawn)

    @cached_property
    def as_drawn(self) -> Composition:
        """The same string with the outlines of the layers of colour glyphs."""
        glyph_ids = {glyph_id for row in self.settings.rows for glyph_id in row.glyph_ids}
        if self.drawn or not any(self.font.glyph(one).layers for one in glyph_ids):
            return self
        return self._with(self.shared, drawn=True)

    def _with(self, shared: bool, drawn: bool) -> Composition:
        return Composition(self.font, self.string, shared, self.line_height, self.options, drawn)

    def __reduce__(self) -> Any:
        arguments = self.font, self.string, self.shared, self.line_height, self.options, self.drawn
        return _read, (self._name, arguments)

    def __deepcopy__(self, memo: Any) -> Composition:
        return self

    @property
    def settings(self) -> Settings:
        """See the attributes of the class."""
        return self._layouts.settings

    @property
    def letter_count(self) -> int:
        """The number of letters at the default."""
        return len(self.settings.rows[0].glyph_ids)

    @property
    def parameters(self) -> int:
        """How many axis vectors Θ holds."""
        return 1 if self.shared else self.letter_count

    def word_at(self, theta: Array) -> Word:
        """The word at Θ, (1, n) or (l, n).

        A letter with axes of its own takes its glyph from the row at its own location. If that
        row joins the letters of the string in another way than the row of the default does, the
        letter takes its glyph from the latter.
        """
        if self._only_word is not None:
            return self._only_word
        if self.font.moves_axes:
            return self._word_at(to_array(self.font.final_coordinates(theta)))
        return self._setting_at(theta).word

    @cached_property
    def _only_word(self) -> Word | None:
        """The word, if the design space has one setting; else None."""
        return self.word((0,) * self.parameters) if len(self.settings.rows) == 1 else None

    def bounds_at(self, theta: Array) -> tuple[Array, Array]:
        """The least and the greatest Θ of a box around Θ in which the word is that at Θ.

        Both have the shape of Θ. Where axes move others, the word may be the same beyond the box.
        """
        if self._bounds is not None:
            return self._bounds
        displacement = self.font.displacement
        if displacement is None:
            _, lower, upper = self._setting_at(theta)
            return lower, upper
        boxes = np.array([self._box_within(w, displacement) for w in theta])
        return np.minimum(boxes[:, 0], theta), np.maximum(boxes[:, 1], theta)

    @cached_property
    def _bounds(self) -> tuple[Array, Array] | None:
        """The bounds of Θ if they are the same everywhere, else None."""
        if any(map(len, self.settings.edges)):
            return None
        lower, upper = (np.tile(bound, (self.parameters, 1)) for bound in self.font.bounds)
        return lower, upper

    def _setting_at(self, theta: Array) -> Setting:
        """The setting at Θ, which nobody writes to.

        The latest ones are kept, because a drag seldom leaves them: where it comes to a boundary,
        both sides of it are tried.
        """
        at, kept = self._latest
        if at is theta:
            return kept[0]
        for setting in kept:
            if not setting.misses(theta):
                break
        else:
            setting = Setting(self._word_at(theta), *self.settings.box_at(theta))
            if setting.misses(theta):
                # HarfBuzz rounds, so that Θ may lie just outside. Such a box is that of Θ alone.
                sides = np.minimum(setting.lower, theta), np.maximum(setting.upper, theta)
                return setting._replace(lower=sides[0], upper=sides[1])
        others = [one for one in kept if one is not setting]
        self._latest = theta, [setting, *others[: MOST_SETTINGS - 1]]
        return setting

    def _word_at(self, final: Array) -> Word:
        """The word at the coordinates at which the font's conditions apply."""
        rows = self.settings.row_at(final)
        if not self.shared:
            rows = self._usual_rows[rows]
        return self.word(tuple(rows.tolist()))

    @cached_property
    def _usual_rows(self) -> IntArray:
        """For each row, itself if a letter may be taken from it, else the row of the default."""
        clusters = [row.clusters for row in self.settings.rows]
        return np.array([i if own == clusters[0] else 0 for i, own in enumerate(clusters)])

    def _box_within(self, w: Array, displacement: Displaced) -> Array:
        """A box (2, n) around w (n,) whose final coordinates stay in one box of the settings."""
        final = displacement.value(w)
        least, greatest = self.settings.box_at(final)
        # HarfBuzz rounds, so that w may lie just outside.
        least, greatest = np.minimum(least, final), np.maximum(greatest, final)
        whole = np.stack(self.font.bounds)

        def fits(box: Array) -> bool:
            low, high = displacement.limits(*box)
            return bool((low >= least).all() and (high <= greatest).all())

        # All sides at once, so that each has room, and then each as far as it goes.
        box = _largest(fits, np.array([w, w]), whole)
        for side, axis in np.ndindex(*box.shape):
            larger = box.copy()
            larger[side, axis] = whole[side, axis]
            box = _largest(fits, box, larger)
        return box

    def word(self, rows: tuple[int, ...]) -> Word:
        """The word whose letters are taken from these rows of glyphs: one, or one per letter."""
        return self._words.get(rows, lambda: Word(self, rows, self._layouts_of(rows)))

    def _layouts_of(self, rows: tuple[int, ...]) -> list[Layout]:
        found = [self._layouts.of(self.font, row) for row in rows]
        return found * len(found[0].row.glyph_ids) if self.shared else found


_known: WeakValueDictionary[str, Composition] = WeakValueDictionary()
"""The compositions of this process, by names that differ between all processes."""
_reading = Lock()


def _read(name: str, arguments: tuple[Any, ...]) -> Composition:
    """A composition from a pickle.

    A text and its handles may be pickled apart, as when a pool of workers gets a function and its
    arguments. They belong together still, so each composition is read once in a process.
    """
    with _reading:
        found = _known.get(name)
        if found is None:
            found = Composition(*arguments)
            found._name = name
            _known[name] = found
        return found


def _largest(fits: Callable[[Array], bool], box: Array, larger: Array) -> Array:
    """The largest box that fits between a box that does and a larger one."""
    if fits(larger):
        return larger
    near, far = 0.0, 1.0
    for _ in range(HALVINGS):
        middle = (near + far) / 2
        near, far = (middle, far) if fits(box + middle * (larger - box)) else (near, middle)
    return box + near * (larger - box)
