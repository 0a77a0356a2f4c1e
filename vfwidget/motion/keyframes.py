"""Keyframes: states at given times, with eased transitions between them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

import numpy as np

from ..arrays import Array, to_array
from ..errors import MotionError
from ..solver.problem import is_number
from ..text import Text
from ..text.place import OFFSETS
from .numbers import LARGEST, check_frames, read_array

Easing: TypeAlias = "str | Sequence[float] | Callable[[Array], Any]"
"""The name of a CSS easing, the numbers of ``cubic-bezier``, or a function from part to part."""

EASINGS = {
    "linear": (0.0, 0.0, 1.0, 1.0),
    "ease": (0.25, 0.1, 0.25, 1.0),
    "ease-in": (0.42, 0.0, 1.0, 1.0),
    "ease-out": (0.0, 0.0, 0.58, 1.0),
    "ease-in-out": (0.42, 0.0, 0.58, 1.0),
}
"""The easings of CSS by name, as the inner control points of a cubic from (0, 0) to (1, 1)."""
HALVINGS = 40
"""Bisections that find the parameter of a point on such a cubic."""


def read_easing(easing: Easing) -> Callable[[Array], Array]:
    """A function from the part of the time that has passed to the part of the way, both 0 to 1.

    Raises
    ------
    MotionError
        The name is unknown, or the numbers are no ``cubic-bezier``.
    """
    if callable(easing):
        given = easing
        return lambda part: _called(given, part)
    numbers = EASINGS.get(easing, ()) if isinstance(easing, str) else easing
    try:
        x1, y1, x2, y2 = (float(number) for number in numbers)
    except (TypeError, ValueError, RuntimeError, OverflowError):
        x1 = math.nan
    if not (0 <= x1 <= 1 and 0 <= x2 <= 1 and math.isfinite(y1 + y2)):
        raise MotionError(
            f"easing must be one of {', '.join(EASINGS)}, four numbers (x1, y1, x2, y2) with x "
            f"between 0 and 1, or a function; received {easing!r}."
        )

    def eased(part: Array) -> Array:
        low, high = np.zeros_like(part), np.ones_like(part)
        for _ in range(HALVINGS):
            middle = (low + high) / 2
            early = _bezier(x1, x2, middle) < part
            low, high = np.where(early, middle, low), np.where(early, high, middle)
        return np.where(part <= 0, 0.0, np.where(part >= 1, 1.0, _bezier(y1, y2, high)))

    return eased


def _called(easing: Callable[[Array], Any], part: Array) -> Array:
    """The parts of the way that a caller's own easing gives.

    Raises
    ------
    MotionError
        They are not one finite number for each part of the time.
    """
    found = easing(part)
    try:
        way = to_array(found)
    except (TypeError, ValueError, RuntimeError):
        way = np.array(np.nan)
    if way.shape != part.shape or not np.isfinite(way).all():
        raise MotionError(
            f"The easing must take an array of parts of the time, from 0 to 1, and return an array "
            f"of the same shape, {part.shape}; it returned {found!r:.200}."
        )
    return way


def _bezier(first: float, second: float, t: Array) -> Array:
    return 3 * (1 - t) ** 2 * t * first + 3 * (1 - t) * t * t * second + t**3


def read_keyframes(keyframes: Any) -> tuple[Array, list[Text]]:
    """The times (q,) and the texts of keyframes.

    Raises
    ------
    MotionError
        They are no pairs of a time and a text, the times do not increase, or the texts are not
        states of one text.
    """
    try:
        pairs = [(time, text) for time, text in keyframes]
    except (TypeError, ValueError):
        pairs = []
    if not pairs or not all(is_number(t) and isinstance(text, Text) for t, text in pairs):
        raise MotionError(
            f"keyframes must be pairs of seconds and a Text; received {keyframes!r:.200}."
        )
    times = read_array("The times of keyframes", [time for time, _ in pairs])
    if not (times[1:] > times[:-1]).all():
        raise MotionError(f"The times of keyframes must increase; received {times.tolist()}.")
    texts = [text for _, text in pairs]
    for text in texts[1:]:
        check_same(texts[0], text)
    return times, texts


def check_same(first: Text, other: Text) -> None:
    """Check that two texts are states of the same text.

    Raises
    ------
    MotionError
        They differ in more than axes, offsets and rotations; the message says in what.
    """
    one, two = first.composition, other.composition
    equal = {
        "string": first.string == other.string,
        "font (load a font once and pass it to each Text)": first.font is other.font,
        "value of shared": first.shared == other.shared,
        "number of glyphs (switch ligatures off, as by features={'liga': False})": (
            len(first.glyphs) == len(other.glyphs)
        ),
        "tracking": first.tracking == other.tracking,
        "line height": one.line_height == two.line_height,
        "features, language, script or direction": one.options == two.options,
    }
    differences = [name for name, same in equal.items() if not same]
    if differences:
        raise MotionError(
            f"All frames must be states of one text, but the texts {first.string!r} and "
            f"{other.string!r} differ in: {'; '.join(differences)}. Make one from the other by "
            "text.at(…)."
        )


def read_delays(delay: Any, letters: int) -> Array:
    """The delay of each letter in seconds, (l,), from one step for all or one number for each.

    Raises
    ------
    MotionError
        It is neither, or a number is negative or not finite.
    """
    try:
        delays = to_array(delay)
    except (TypeError, ValueError, RuntimeError):
        delays = np.full(1, np.nan)
    if delays.shape == ():
        delays = np.clip(delays, -1, 2 * LARGEST) * np.arange(letters)
    if delays.shape != (letters,) or not ((delays >= 0) & (delays <= LARGEST)).all():
        raise MotionError(
            f"delay must be a number of seconds ≥ 0, or one for each of the {letters} letters; "
            f"received {delay!r}."
        )
    return delays


def transitions(
    times: Array, texts: Sequence[Text], delays: Array, easing: Easing, fps: float
) -> tuple[Array, Array, Array, Array]:
    """Frame times (T,), Θ (T, p, n), offsets (T, l, 2) and rotations (T, l) between keyframes."""
    ease = read_easing(easing)
    end = times[-1] + delays.max(initial=0.0)
    wanted = float(end - times[0]) * fps
    check_frames(wanted + 1)
    frames = max(math.ceil(wanted - 1e-9), 0)
    sampled = np.minimum(times[0] + np.arange(frames + 1) / fps, end)
    # Each letter is that much behind; the first keyframe lasts until it starts.
    local = np.clip(sampled[:, None] - delays, times[0], times[-1])
    theta = np.stack([text.coordinates for text in texts])
    offsets = np.stack([text.place[OFFSETS] for text in texts])
    rotations = np.stack([text.rotations for text in texts])
    at = np.clip(np.searchsorted(times, local, side="right") - 1, 0, max(len(times) - 2, 0))
    if len(times) == 1:
        part = np.zeros_like(local)
        following = at
    else:
        following = at + 1
        part = ease((local - times[at]) / (times[following] - times[at]))
    letters = np.arange(len(delays))

    def mixed(states: Array, rows: Any) -> Array:
        first, second = states[at[:, rows], rows], states[following[:, rows], rows]
        share = part[:, rows].reshape(first.shape[:2] + (1,) * (first.ndim - 2))
        return np.asarray(first + share * (second - first))

    vectors = np.zeros(1, dtype=np.intp) if theta.shape[1] == 1 else letters
    # An easing may go beyond both states, but no axis leaves its range.
    axes = np.clip(mixed(theta, vectors), *texts[0].font.bounds)
    return sampled, axes, mixed(offsets, letters), mixed(rotations, letters)
