"""What a text asks of HarfBuzz besides its characters: features, language, script, direction."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from fontTools import unicodedata

from ..errors import TextError

COMMON_FEATURES = frozenset(
    "abvf abvm abvs akhn blwf blwm blws calt ccmp cfar chws cjct clig cswh curs dist dlig fin2 "
    "fin3 fina frac half haln halt init isol jalt kern liga ljmo locl ltra ltrm mark med2 medi "
    "mkmk nukt palt pref pres pstf psts rclt rkrf rlig rphf rtla rtlm rvrn salt stch tjmo vatu "
    "vjmo".split()
)
"""Features that may be switched whether the font has them or not: those that HarfBuzz applies."""
MOST_ALTERNATES = 2**32
"""HarfBuzz holds the value of a feature in 32 bits."""
END = 2**32 - 1
"""Where a range ends that has no end, in HarfBuzz."""
RANGE = re.compile(r"(.+)\[(?:([0-9]*):([0-9]*)|([0-9]+)|)\]", re.DOTALL)
"""A feature with a range of characters, as hb-shape takes it: ``kern[1:5]`` or ``kern[3]``."""

FeatureValues: TypeAlias = "Mapping[str, bool | int | Iterable[tuple[int, int, bool | int]]]"
"""Features as callers give them: the value by tag or by tag with a range, or ranges with values."""


class Feature(NamedTuple):
    """An OpenType feature that a text sets, with the characters ``string[start:end]``.

    Attributes
    ----------
    tag : str
    value : int
        0 is off, 1 on, and more chooses among alternates.
    start, end : int
        By default the whole text.
    """

    tag: str
    value: int
    start: int = 0
    end: int = END

    @property
    def is_everywhere(self) -> bool:
        """Whether the feature is set for the whole text."""
        return (self.start, self.end) == (0, END)

    def __str__(self) -> str:
        return self.tag if self.is_everywhere else f"{self.tag}[{self.start}:{self.end}]"


@dataclass(frozen=True)
class ShapingOptions:
    """What a text asks of HarfBuzz besides its characters; :func:`check_options` makes it.

    Attributes
    ----------
    features : tuple of Feature
        OpenType features that differ from HarfBuzz's defaults, sorted by tag. Among those of one
        tag a later one takes precedence.
    language : str or None
        BCP 47 tag, such as ``"sr"``.
    script : str or None
        ISO 15924 tag, such as ``"Arab"``; by default that of the characters.
    direction : "ltr", "rtl" or None
        Direction of each line as a paragraph; by default that of its first strong character.
    """

    features: tuple[Feature, ...] = ()
    language: str | None = None
    script: str | None = None
    direction: str | None = None

    @property
    def feature_values(self) -> dict[str, int | list[tuple[int, int, int]]]:
        """The features as HarfBuzz and a text take them: a value by tag, or ranges with values."""
        found: dict[str, Any] = {}
        for feature in self.features:
            found.setdefault(feature.tag, []).append((feature.start, feature.end, feature.value))
        whole = self.whole_features
        return {
            tag: whole[tag] if len(ranges) == 1 and tag in whole else ranges
            for tag, ranges in found.items()
        }

    @property
    def whole_features(self) -> dict[str, int]:
        """The values that are set for the whole text, by tag."""
        return {feature.tag: feature.value for feature in self.features if feature.is_everywhere}

    def at_character(self, index: int) -> ShapingOptions:
        """The same options where a text is the character at this index only."""
        # HarfBuzz sets ranges after all values for the whole text.
        order = sorted(self.features, key=lambda feature: not feature.is_everywhere)
        own = {f.tag: f.value for f in order if f.start <= index < f.end}
        return replace(self, features=tuple(Feature(*item) for item in own.items()))


def check_options(
    font_features: Collection[str],
    features: FeatureValues | None = None,
    language: str | None = None,
    script: str | None = None,
    direction: str | None = None,
) -> ShapingOptions:
    """Check what a text asks of HarfBuzz.

    Parameters
    ----------
    font_features : collection of str
        The features that the font has.
    features : mapping of str to value or ranges, optional
        As :class:`~vfwidget.Text` takes it.
    language, script, direction : str, optional
        As in :class:`ShapingOptions`.

    Raises
    ------
    TextError
        Neither the font nor HarfBuzz has the feature, its value is not a whole number, its range
        is none, the script or the language does not exist, or the direction is not ``"ltr"`` or
        ``"rtl"``.
    """
    if not isinstance(features, Mapping | None):
        raise TextError(
            f"features must be a mapping such as {{'kern': False}}; received {features!r}."
        )
    found = [f for key, given in (features or {}).items() for f in _read(key, given, font_features)]
    if language is not None and not _is_language(language):
        raise TextError(
            "language must be a BCP 47 tag of registered codes, such as 'en' or 'sr-Latn'; "
            f"received {language!r:.100}. For a language without a code write 'x-' and a name."
        )
    if script is not None and str(script) not in unicodedata.Scripts.NAMES:
        raise TextError(
            f"script must be an ISO 15924 tag such as 'Latn' or 'Arab'; received {script!r}."
        )
    if direction not in (None, "ltr", "rtl"):
        raise TextError(f"direction must be 'ltr' or 'rtl'; received {direction!r}.")
    # The order of those of one tag is kept.
    chosen = tuple(sorted(found, key=lambda feature: feature.tag))
    return ShapingOptions(chosen, language, script, direction)


def _read(key: Any, given: Any, font_features: Collection[str]) -> list[Feature]:
    """What one entry of a mapping of features sets."""
    ranged = None if _exists(key, font_features) else RANGE.fullmatch(str(key))
    tag = ranged[1] if ranged else key
    if not _exists(tag, font_features):
        names = ", ".join(sorted(font_features)) or "none"
        hint = " Write a range of characters as in 'kern[1:3]'." if "[" in str(tag) else ""
        raise TextError(f"The font has no feature {tag!r}.{hint} It has: {names}.")
    if isinstance(given, str) or not isinstance(given, Iterable):
        start, end = _bounds(*ranged.groups()[1:]) if ranged else (0, END)
        return [_checked(tag, start, end, given)]
    if ranged:
        raise TextError(
            f"Feature {tag!r} has a range in its key {key!r} and others in its value. "
            f"Write {{{tag!r}: {given!r:.100}}}."
        )
    found = []
    for entry in given:
        if not isinstance(entry, Sequence) or isinstance(entry, str) or len(entry) != 3:
            raise TextError(
                f"A range of feature {tag!r} must be (start, end, value), such as (1, 3, 0); "
                f"received {entry!r:.100}."
            )
        found.append(_checked(tag, *entry))
    return found


def _exists(tag: Any, font_features: Collection[str]) -> bool:
    """Whether the font or HarfBuzz has a feature."""
    return tag in COMMON_FEATURES or tag in font_features


def _bounds(start: str, end: str, only: str) -> tuple[int, int]:
    """The range that a key states by ``[start:end]``, ``[only]`` or ``[]``."""
    if only:
        return int(only), int(only) + 1
    return int(start or 0), int(end or END)


def _checked(tag: str, start: Any, end: Any, value: Any) -> Feature:
    """A feature whose range and value are whole numbers that HarfBuzz can hold."""
    if not _is_whole(value) or not 0 <= int(value) < MOST_ALTERNATES:
        raise TextError(f"Feature {tag!r} must be on, off or a number; received {value!r:.100}.")
    whole = all(_is_whole(bound) and not isinstance(bound, bool) for bound in (start, end))
    if not whole or not 0 <= start <= end:
        raise TextError(
            f"A range of feature {tag!r} goes from one character of the text to a later one, such "
            f"as '{tag}[1:3]' or (1, 3, value); received ({start!r:.100}, {end!r:.100})."
        )
    return Feature(tag, int(value), min(int(start), END), min(int(end), END))


def _is_whole(value: Any) -> bool:
    return isinstance(value, bool | int | np.integer | np.bool_)


def _is_language(tag: object) -> bool:
    """Whether a value is a BCP 47 tag of registered codes, or of codes for private use."""
    from langcodes import Language, tag_is_valid

    # The library takes an underscore for a hyphen.
    if not isinstance(tag, str) or "_" in tag or not tag_is_valid(tag):
        return False
    # The library does not look up a second language, such as yue in zh-yue.
    return all(map(tag_is_valid, Language.get(tag, normalize=False).extlangs or ()))
