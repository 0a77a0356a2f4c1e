"""Axis values as CSS."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

MOST_DECIMALS = 15
"""Of a duration in seconds."""


def declarations(
    family: str,
    axes: Mapping[str, float] | Sequence[Mapping[str, float]],
    features: Mapping[str, int] | None = None,
    tracking: float = 0.0,
) -> str:
    """Write the declarations that set a text in a font at axis values.

    Parameters
    ----------
    family : str
        Name of the font family.
    axes : mapping of tag to user value, or one for each letter
    features : mapping of tag to int, optional
        OpenType features that differ from the defaults of the font.
    tracking : float
        Space after each grapheme, in em.
    """
    lines = [f"font-family: {quoted(family)};"]
    if features:
        lines.append(f"font-feature-settings: {settings(features)};")
    if tracking:
        lines.append(f"letter-spacing: {number(tracking)}em;")
    if isinstance(axes, Mapping):
        return "\n".join([*lines, f"font-variation-settings: {settings(axes)};"])
    rules = [
        f".letter-{index} {{ font-variation-settings: {settings(values)}; }}"
        for index, values in enumerate(axes, start=1)
    ]
    return "\n".join([*lines, *rules])


def settings(axes: Mapping[str, float]) -> str:
    """The value of ``font-variation-settings`` or ``font-feature-settings``."""
    return ", ".join(f"{quoted(tag)} {number(value)}" for tag, value in axes.items())


def number(value: float, decimals: int = 5) -> str:
    """A number with so many decimals at most, never in exponential notation."""
    text = f"{value:.{decimals}f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def seconds(duration: float) -> str:
    """A duration in CSS and SVG, with six digits also if it is very short."""
    digits = 5 - math.floor(math.log10(duration)) if duration > 0 else 5
    return f"{number(duration, min(max(digits, 5), MOST_DECIMALS))}s"


def identifier(text: str) -> str:
    """A name in CSS in which every character but letters, digits, - and _ is escaped."""
    return "".join(
        c if c.isascii() and (c.isalnum() or c in "-_") and (i or not c.isdigit()) else _escaped(c)
        for i, c in enumerate(text)
    )


def quoted(text: str) -> str:
    """A string in CSS that nothing in the text can end, not even in a style element of HTML."""
    return f'"{"".join(map(_character, text))}"'


def _character(character: str) -> str:
    plain = character.isprintable() and character not in '"\\<>&'
    return character if plain else _escaped(character)


def _escaped(character: str) -> str:
    return f"\\{ord(character):x} "
