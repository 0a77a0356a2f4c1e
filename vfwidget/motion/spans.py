"""Which characters each element of a page holds, and their keyframes.

A browser shapes each element by itself. So an element holds a letter with its marks, with joiners
around it if it joins its neighbours, and HarfBuzz confirms that its glyphs are those of the text.
Where a glyph depends on its neighbours in another way, a page whose font is made for it can choose
the glyph by a feature (:mod:`vfwidget.font.alternates`).
"""

from __future__ import annotations

import unicodedata
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..arrays import Array
from ..errors import MotionError, VFWidgetError
from ..export.css_animation import Span
from ..export.track import Track, keyframes, turned
from ..font.alternates import ALTERNATES
from ..font.shaping import LINE_BREAK
from .tracks import user_coordinates

JOINER = "\u200d"
"""ZERO WIDTH JOINER: a letter next to it takes the form that joins."""

ROUNDING = 1e-6
"""Font units: errors of rounding are smaller."""


class Alternates:
    """The glyphs that elements show in place of those that their characters have by themselves.

    The value of the feature is the number of the element's entry.
    """

    def __init__(self) -> None:
        self._entries: list[dict[int, int]] = []

    def add(self, replaced: dict[int, int]) -> dict[str, int]:
        """The feature setting of an element in which glyphs are replaced by others."""
        self._entries.append(replaced)
        return {ALTERNATES: len(self._entries)}

    def by_name(self, names: Sequence[str]) -> dict[str, list[str]]:
        """For each glyph its alternates, by the names of the font's glyphs."""
        glyphs = {glyph for entry in self._entries for glyph in entry}
        return {
            names[glyph]: [names[entry.get(glyph, glyph)] for entry in self._entries]
            for glyph in sorted(glyphs)
        }


def text_spans(
    animation: Any,
    tracks: Sequence[Sequence[Track]],
    tolerance: float,
    alternates: Alternates | None = None,
) -> list[Span]:
    """The elements of a text in the order of its characters.

    Parameters
    ----------
    animation : Animation
    tracks : sequence of sequences of Track
        As :func:`~vfwidget.motion.tracks.letter_tracks` gives them.
    tolerance : float
        As :func:`~vfwidget.export.track.keyframes` takes it, in font units.
    alternates : Alternates, optional
        Takes the glyphs that depend on their neighbours. Without it there may be none.

    Raises
    ------
    MotionError
        A glyph depends on its neighbours, or the letters of one element have different axes or do
        not move as one piece.
    """
    word, users = animation.text.word, user_coordinates(animation)
    em, times = animation.text.font.units_per_em, animation.times - animation.times[0]
    if any(frame.word.clusters != word.clusters for frame in animation):
        raise MotionError(
            f"The letters of {word.string!r} stand for other characters in some frames, and one "
            "element for each letter cannot show that. Switch off ligatures (features={'liga': "
            "False}), or use to_svg, to_lottie or a video."
        )
    spans = []
    for group, string in _groups(word):
        own = [0] if word.shared else group
        if any(np.ptp(users[:, own], axis=1).ravel()):
            raise MotionError(
                f"{string!r} consists of several glyphs, which have different axis values, and "
                "one element of a page cannot show that. Use to_svg, to_lottie or a video."
            )
        base = group[0]
        if any(
            _off(animation, tracks, base, letter) > tolerance + ROUNDING for letter in group[1:]
        ):
            raise MotionError(
                f"{string!r} consists of several glyphs, which move or rotate by themselves, and "
                "one element of a page cannot show that. Use to_svg, to_lottie or a video."
            )
        rtl = word.layouts[base].row.rtl[base]
        keys = {
            track.start + key
            for letter in group
            for track in tracks[letter]
            for key in keyframes(track, tolerance, by_axes=True)
        }
        at = sorted(keys)
        origins = np.concatenate([track.origins for track in tracks[base]])
        characters, features = _shaped_alone(animation, group, string, rtl, alternates)
        spans.append(
            Span(
                characters,
                rtl,
                features,
                times[at],
                users[at, own[0]],
                origins[at] / em,
                animation.rotations[at, base],
            )
        )
    return spans


def _off(animation: Any, tracks: Sequence[Sequence[Track]], base: int, letter: int) -> float:
    """How far a letter is at most from where its base carries it in one piece, in font units."""
    own, carrying = (np.concatenate([track.origins for track in tracks[i]]) for i in (letter, base))
    angles, offsets = animation.rotations[:, [letter, base]].T, animation.offsets
    apart = (own - offsets[:, letter]) - (carrying - offsets[:, base])
    off = own - carrying - turned(apart[:, None], angles[1])[:, 0]
    size = max(float(np.hypot(*track.points.T).max(initial=0.0)) for track in tracks[letter])
    return float((np.hypot(*off.T) + size * abs(angles[0] - angles[1])).max())


def _groups(word: Any) -> list[tuple[list[int], str]]:
    """Letters that share an element, the base first, with their characters."""
    starts = sorted(set(word.clusters))
    ends = [*starts[1:], len(word.string)]
    groups: list[tuple[list[int], str]] = []
    for start, end in zip(starts, ends, strict=True):
        letters = [i for i, cluster in enumerate(word.clusters) if cluster == start]
        characters = LINE_BREAK.sub("", word.string[start:end])
        if groups and unicodedata.category(characters[:1] or " ").startswith("M"):
            groups[-1] = (groups[-1][0] + letters, groups[-1][1] + characters)
        else:
            groups.append((letters, characters))
    return groups


def _shaped_alone(
    animation: Any, group: list[int], string: str, rtl: bool, alternates: Alternates | None
) -> tuple[str, dict[str, int]]:
    """The characters and features that give the group's glyphs by themselves.

    The characters have joiners around them where that is enough.
    """
    text, own = animation.text, 0 if animation.text.shared else group[0]
    whole = text.composition.options
    first = min(text.word.clusters[letter] for letter in group)
    options = replace(whole.at_character(first), direction="rtl" if rtl else "ltr")
    features = dict(sorted(options.whole_features.items() - whole.whole_features.items()))
    wanted: dict[tuple[int, ...], Array] = {}
    for frame, w in zip(animation, animation.theta[:, own], strict=True):
        wanted.setdefault(tuple(frame.word.glyph_ids[i] for i in sorted(group)), w)

    def alone(candidate: str) -> list[tuple[int, ...]]:
        try:
            return [
                text.font.shape_at(candidate, w, options, lambda _: 0.0).glyph_ids
                for w in wanted.values()
            ]
        except VFWidgetError:
            return []

    for before, after in (("", ""), ("", JOINER), (JOINER, ""), (JOINER, JOINER)):
        if alone(before + string + after) == list(wanted):
            return before + string + after, features
    found = alone(string)
    if alternates is not None and [len(row) for row in found] == [len(row) for row in wanted]:
        pairs = {
            pair
            for row, target in zip(found, wanted, strict=True)
            for pair in zip(row, target, strict=True)
        }
        if len(pairs) == len({glyph for glyph, _ in pairs}):
            return string, features | alternates.add(dict(pairs))
    raise MotionError(
        f"The glyph of {string!r} depends on the letters around it, and a browser does not see "
        "them where each letter is an element. Switch off the feature that chooses the glyph (in "
        "most fonts features={'calt': False} or features={'rlig': False}), or use to_html, "
        "to_svg, to_lottie or a video."
    )
