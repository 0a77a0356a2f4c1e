"""Points of a text's outline that a person can take hold of."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Handle:
    """A point of a word's outline that keeps its curve parameter as the axes move.

    Attributes
    ----------
    glyph, contour, segment : int
        The letter of the word, the contour of that letter and the cubic segment of that contour,
        each counted from 0.
    t : float
        Parameter on the cubic, 0 … 1.
    word : Word
        The word that the point belongs to. A handle is valid in every :class:`Text` of that word.
    """

    glyph: int
    contour: int
    segment: int
    t: float
    word: Any = field(repr=False, compare=True, kw_only=True)

    @property
    def letter_name(self) -> str:
        """The handle's letter in words: its character or glyph name; of equal ones, which it is."""
        return str(self.word.distinct_names[self.glyph])
