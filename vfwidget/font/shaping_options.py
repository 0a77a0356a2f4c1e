"""What a text asks of HarfBuzz besides its characters: features, language, script, direction."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass

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
LANGUAGE = re.compile(r"([A-Za-z]{2,3}|[xX](?=-)|[iI](?=-))(-[A-Za-z0-9]{1,8})*")
"""The form of a BCP 47 language tag."""
LANGUAGES = frozenset(
    "aa ab ae af ak am an ar as av ay az ba be bg bh bi bm bn bo br bs ca ce ch co cr cs cu cv "
    "cy da de dv dz ee el en eo es et eu fa ff fi fj fo fr fy ga gd gl gn gu gv ha he hi ho hr "
    "ht hu hy hz ia id ie ig ii ik io is it iu ja jv ka kg ki kj kk kl km kn ko kr ks ku kv kw "
    "ky la lb lg li ln lo lt lu lv mg mh mi mk ml mn mo mr ms mt my na nb nd ne ng nl nn no nr "
    "nv ny oc oj om or os pa pi pl ps pt qu rm rn ro ru rw sa sc sd se sg sh si sk sl sm sn so "
    "sq sr ss st su sv sw ta te tg th ti tk tl tn to tr ts tt tw ty ug uk ur uz ve vi vo wa wo "
    "xh yi yo za zh zu".split()
)
"""Language codes of two letters (ISO 639-1). Those of three letters are not checked."""


@dataclass(frozen=True)
class ShapingOptions:
    """What a text asks of HarfBuzz besides its characters; :func:`check_options` makes it.

    Attributes
    ----------
    features : tuple of (str, int)
        OpenType features that differ from HarfBuzz's defaults: 0 is off, 1 on, and more chooses
        among alternates. Sorted by tag.
    language : str or None
        BCP 47 tag, such as ``"sr"``.
    script : str or None
        ISO 15924 tag, such as ``"Arab"``; by default that of the characters.
    direction : "ltr", "rtl" or None
        Direction of each line as a paragraph; by default that of its first strong character.
    """

    features: tuple[tuple[str, int], ...] = ()
    language: str | None = None
    script: str | None = None
    direction: str | None = None


def check_options(
    font_features: Collection[str],
    features: Mapping[str, bool | int] | None = None,
    language: str | None = None,
    script: str | None = None,
    direction: str | None = None,
) -> ShapingOptions:
    """Check what a text asks of HarfBuzz.

    Parameters
    ----------
    font_features : collection of str
        The features that the font has.
    features : mapping of tag to bool or int, optional
    language, script, direction : str, optional
        As in :class:`ShapingOptions`.

    Raises
    ------
    TextError
        Neither the font nor HarfBuzz has the feature, its value is not a whole number, the script
        or the language does not exist, or the direction is not ``"ltr"`` or ``"rtl"``.
    """
    if not isinstance(features, Mapping | None):
        raise TextError(
            f"features has to be a mapping such as {{'kern': False}}; received {features!r}."
        )
    for tag, value in (features or {}).items():
        if tag not in COMMON_FEATURES and tag not in font_features:
            names = ", ".join(sorted(font_features)) or "none"
            raise TextError(f"The font has no feature {tag!r}. It has: {names}.")
        whole = isinstance(value, bool | int | np.integer | np.bool_)
        if not whole or not 0 <= int(value) < MOST_ALTERNATES:
            raise TextError(f"Feature {tag!r} has to be on, off or a number; received {value!r}.")
    if language is not None and not _is_language(language):
        raise TextError(f"language has to be a BCP 47 tag such as 'en'; received {language!r}.")
    if script is not None and str(script) not in unicodedata.Scripts.NAMES:
        raise TextError(
            f"script has to be an ISO 15924 tag such as 'Latn' or 'Arab'; received {script!r}."
        )
    if direction not in (None, "ltr", "rtl"):
        raise TextError(f"direction has to be 'ltr' or 'rtl'; received {direction!r}.")
    chosen = tuple(sorted((tag, int(value)) for tag, value in (features or {}).items()))
    return ShapingOptions(chosen, language, script, direction)


def _is_language(tag: object) -> bool:
    """Whether a value has the form of a BCP 47 tag, and its code of two letters exists."""
    if not isinstance(tag, str) or not LANGUAGE.fullmatch(tag):
        return False
    primary = tag.lower().split("-")[0]
    return len(primary) != 2 or primary in LANGUAGES
