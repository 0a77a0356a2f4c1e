"""Animated axis values as CSS: one element for each letter, and the text stays text.

A browser with the variable font draws every frame. Letters do not take part in the browser's own
layout, because it does not kern across elements: each has no width, and a transform puts its
origin where the animation has it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from html import escape

import numpy as np

from ..arrays import Array
from .css import identifier, number, quoted, seconds


@dataclass(frozen=True)
class Span:
    """The characters of one element, and its K keyframes.

    Attributes
    ----------
    text : str
    rtl : bool
        Whether the characters belong to a run from right to left.
    features : mapping of tag to int
        OpenType features of this element only.
    times : (K,) array
        Seconds since the start of the animation.
    axes : (K, n) array
        User coordinates.
    origins : (K, 2) array
        In ems, y up.
    rotations : (K,) array
        Radians, counterclockwise.
    """

    text: str
    rtl: bool
    features: Mapping[str, int]
    times: Array = field(repr=False)
    axes: Array = field(repr=False)
    origins: Array = field(repr=False)
    rotations: Array = field(repr=False)


def style_sheet(
    spans: Sequence[Span],
    *,
    name: str,
    family: str,
    tags: Sequence[str],
    features: Mapping[str, int],
    duration: float,
    box: tuple[float, float, float, float],
    loop: bool,
) -> str:
    """Write the rules that animate the elements of :func:`markup`.

    Parameters
    ----------
    spans : sequence of Span
    name : str
        Class of the element that holds the text, and prefix of the names of keyframes.
    family : str
        Name of the font family.
    tags : sequence of str
        The n axes.
    features : mapping of tag to int
        OpenType features that differ from a browser's defaults.
    duration : float
        Seconds.
    box : (left, bottom, right, top)
        The part of the plane that the element shows, in ems, y up; it contains the whole line.
    loop : bool
        Whether the animation repeats without end.

    Returns
    -------
    str
        Custom properties, one for each axis that varies; one ``@keyframes`` rule for each letter.
        A reader who prefers reduced motion sees the last frame.
    """
    values = np.concatenate([span.axes for span in spans])
    varying = [i for i in range(len(tags)) if np.ptp(values[:, i]) > 0]
    properties = {i: f"--{identifier(tags[i])}" for i in varying}
    settings = ", ".join(
        f"{quoted(tag)} {f'var({properties[i]})' if i in varying else number(values[0, i])}"
        for i, tag in enumerate(tags)
    )
    left, bottom, right, top = box
    scope = f".{identifier(name)}"
    rules = [
        f'@property {properties[i]} {{ syntax: "<number>"; inherits: true; '
        f"initial-value: {number(values[0, i])}; }}"
        for i in varying
    ]
    rules += [
        # An empty box stands on the baseline: so the first one puts the baseline at its lower
        # end, and the one in each letter puts the lower end of the letter on its baseline.
        f"{scope} {{ position: relative; width: {number(right - left)}em; "
        f"height: {number(top - bottom)}em; font-family: {quoted(family)}; "
        f"font-feature-settings: {_switched(features)}; font-synthesis: none; "
        "white-space: pre; line-height: 0; direction: ltr; text-align: left; }",
        f'{scope}::before {{ content: ""; display: inline-block; height: {number(top)}em; }}',
        f"{scope} > span {{ display: inline-block; width: 0; transform-origin: 0 100%; "
        f"font-variation-settings: {settings}; animation: {seconds(duration)} linear "
        f"{'infinite' if loop else '1 both'}; }}",
        f'{scope} > span::before {{ content: ""; display: inline-block; }}',
    ]
    for index, span in enumerate(spans, start=1):
        frames = [_declarations(span, k, properties, (left, 0.0)) for k in range(len(span.times))]
        keyframes = f"{identifier(name)}-{index}"
        own = ""
        if span.features:
            own = f" font-feature-settings: {_switched({**features, **span.features})};"
        rules.append(
            f"{scope} > :nth-child({index}) {{ {frames[-1]}{own} animation-name: {keyframes}; }}"
        )
        steps = [
            f"{number(100 * time / duration)}% {{ {frame} }}"
            for time, frame in zip(span.times, frames, strict=True)
        ]
        rules.append("\n  ".join([f"@keyframes {keyframes} {{", *steps]) + "\n}")
    rules.append(
        f"@media (prefers-reduced-motion: reduce) {{ {scope} > span {{ animation: none; }} }}"
    )
    return "\n".join(rules) + "\n"


def _switched(features: Mapping[str, int]) -> str:
    """The value of ``font-feature-settings``."""
    return ", ".join(f"{quoted(tag)} {value:d}" for tag, value in features.items()) or "normal"


def _declarations(
    span: Span, key: int, properties: Mapping[int, str], corner: tuple[float, float]
) -> str:
    """The state of a letter at one keyframe."""
    axes = [f"{name}: {number(span.axes[key, i])};" for i, name in properties.items()]
    x, y = span.origins[key] - corner
    moved = f"translate({number(x)}em, {number(-y)}em)"
    if span.rotations.any():
        moved += f" rotate({number(-span.rotations[key])}rad)"
    return " ".join([*axes, f"transform: {moved};"])


def markup(spans: Sequence[Span], *, name: str, string: str, language: str | None) -> str:
    """The HTML element that :func:`style_sheet` animates; characters in it are escaped."""
    letters = "".join(
        f'<span><bdo dir="rtl">{escape(span.text)}</bdo></span>'
        if span.rtl
        else f"<span>{escape(span.text)}</span>"
        for span in spans
    )
    lang = f' lang="{escape(language)}"' if language else ""
    label = escape(" ".join(string.split()))
    return f'<div class="{escape(name)}" role="img" aria-label="{label}"{lang}>{letters}</div>'
