"""Handles of a word: the nearest to a point, and those that come from another setting."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..arrays import Array
from ..errors import GlyphError
from ..font import Glyph
from ..outline.cubics import bernstein, nearest
from .handle import Handle
from .word import Word

CLEARLY_NEARER = 0.5
"""Contours correspond from their starts, unless that takes points farther than this allows: the
share of the mean distance that is left if they correspond from another segment."""


def nearest_handle(word: Word, points: Array, point: Array) -> Handle:
    """The handle of the outline point nearest to a point (2,).

    Parameters
    ----------
    points : (K, 2) array
        The control points of the word.

    Raises
    ------
    GlyphError
        The word has no outline.
    """
    owners = [
        (letter, contour, segment)
        for letter, glyph in enumerate(word.glyphs)
        for contour, s in enumerate(glyph.contours)
        for segment in range(s)
    ]
    if not owners:
        raise GlyphError(f"{word.string!r} has no outline, so it has no nearest point.")
    found, t = nearest(points[word.contours.segments], point)
    return Handle(*owners[found], t, word=word)


def carry(handle: Handle, word: Word) -> Handle:
    """The handle of a word that corresponds to that of the same text in another setting.

    The point keeps its contour, segment and parameter if the glyphs of both words have the same
    contours; if a contour clearly starts elsewhere, its segments are counted from there. Otherwise
    it is the point of the new outline nearest to the old one, where both outlines are those of the
    default and are measured from the letter's origin. So the point is the same wherever the text
    stands, and a drag beyond a boundary does not slide along the glyph.

    Raises
    ------
    GlyphError
        The new word has no outline for the letter.
    """
    if handle.word is word:
        return handle
    return word.carried.get(handle, lambda: _carried(handle, word))


def _carried(handle: Handle, word: Word) -> Handle:
    """As :func:`carry`, from another word."""
    letter = _letter(handle, word)
    before, after = handle.word.glyphs[handle.glyph], word.glyphs[letter]
    if before is after:
        return replace(handle, glyph=letter, word=word)
    if not after.contours:
        raise GlyphError(f"{handle.letter_name} has no outline there, so no point to hold.")
    # Each word of a long text has most of its glyphs from others.
    key = before, after, handle.contour, handle.segment, handle.t
    found, t = word.composition.corresponding.get(
        key, lambda: _corresponding(before, after, handle)
    )
    contour = int(after.contours.owners[found])
    return Handle(letter, contour, found - sum(after.contours[:contour]), t, word=word)


def _corresponding(before: Glyph, after: Glyph, handle: Handle) -> tuple[int, float]:
    """The segment of a glyph, and t on it, that stand for a handle's point of another glyph."""
    w = np.zeros(len(handle.word.font.axes))
    old, new = before.outline.value(w), after.outline.value(w)
    own = before.contours.indices[handle.contour]
    if before.contours == after.contours:
        turn = _turn(old[own[:, 0]], new[own[:, 0]])
        segment = (handle.segment + turn) % before.contours[handle.contour]
        return sum(before.contours[: handle.contour]) + segment, handle.t
    point = bernstein(handle.t) @ old[own[handle.segment]]
    return nearest(new[after.contours.segments], point)


def _turn(old: Array, new: Array) -> int:
    """How many segments later a contour starts in another glyph, by the starts (s, 2) of both."""
    away = [np.hypot(*(np.roll(new, -k, 0) - old).T).mean() for k in range(len(old))]
    turn = int(np.argmin(away))
    return turn if away[turn] < CLEARLY_NEARER * away[0] else 0


def _letter(handle: Handle, word: Word) -> int:
    """The letter of a word that stands for the same characters as that of a handle."""
    cluster = handle.word.clusters[handle.glyph]
    if word.clusters == handle.word.clusters:
        return handle.glyph
    same = [i for i, other in enumerate(word.clusters) if other == cluster]
    if len(same) != 1:
        raise GlyphError(
            f"{handle.letter_name} is not a letter by itself there, because the text has other "
            "glyphs; take a new handle."
        )
    return same[0]
