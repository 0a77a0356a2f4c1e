"""Outlines in motion as Lottie, a JSON format of vector animation (lottie.github.io, "Spec")."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..arrays import Array
from .track import Track, keyframes

OBSTACLE_OPACITY = 35
"""Per cent. Obstacles are drawn lighter than letters."""
DECIMALS = 1
"""Decimals of coordinates in font units."""
LINEAR = {"o": {"x": [0], "y": [0]}, "i": {"x": [1], "y": [1]}}
"""The easing of every keyframe."""


def lottie(
    letters: Sequence[Track],
    obstacles: Sequence[Track],
    *,
    title: str,
    box: tuple[float, float, float, float],
    frames: int,
    fps: float,
    tolerance: float,
    colour: tuple[int, int, int],
) -> str:
    """Write a Lottie document; players have no variable fonts, so it holds the outlines.

    Parameters
    ----------
    letters, obstacles : sequences of Track
    title : str
    box : (left, bottom, right, top)
        The part of the plane that the picture shows, in font units, y up.
    frames : int
        The number of frames.
    fps : float
        Frames per second.
    tolerance : float
        As in :func:`~vfwidget.export.track.keyframes`.
    colour : (red, green, blue)
        0 to 255 each.
    """
    left, bottom, right, top = box
    corner = np.array([left, top])
    # The first layer is the topmost.
    shapes = [(track, 100) for track in letters] + [(t, OBSTACLE_OPACITY) for t in obstacles]
    layers = [
        _layer(index, track, opacity, corner, fps, tolerance, colour)
        for index, (track, opacity) in enumerate(shapes, start=1)
    ]
    document = {
        "v": "5.7.0",
        "fr": fps,
        "ip": 0,
        "op": frames,
        "w": round(right - left),
        "h": round(top - bottom),
        "nm": title,
        "ddd": 0,
        "assets": [],
        "layers": layers,
    }
    return json.dumps(document, separators=(",", ":"))


def _layer(
    index: int,
    track: Track,
    opacity: int,
    corner: Array,
    fps: float,
    tolerance: float,
    colour: tuple[int, int, int],
) -> dict[str, Any]:
    keys = keyframes(track, tolerance)
    times = track.times[keys] * fps
    origins = (track.origins[keys] - corner) * [1, -1]
    forms = [track.local(key) for key in keys]
    paths = [
        {"ty": "sh", "ks": _animated([_bezier(form[c]) for form in forms], times, shape=True)}
        for c in range(len(forms[0]))
    ]
    fill = {
        "ty": "fl",
        "c": {"a": 0, "k": [round(part / 255, 4) for part in colour] + [1]},
        "o": {"a": 0, "k": 100},
        "r": 1,  # the nonzero rule
    }
    return {
        "ty": 4,
        "ind": index,
        "ks": {
            "o": {"a": 0, "k": opacity},
            "p": _animated([[*_rounded(origin), 0] for origin in origins], times),
            "r": _animated([[_rounded(-np.degrees(a), 3)] for a in track.rotations[keys]], times),
            "a": {"a": 0, "k": [0, 0, 0]},
            "s": {"a": 0, "k": [100, 100, 100]},
        },
        "ip": round(float(track.times[0]) * fps, 3),
        "op": round(float(track.times[-1]) * fps, 3) + 1,
        "st": 0,
        "shapes": [{"ty": "gr", "it": [*paths, fill, _IDENTITY]}],
    }


_IDENTITY = {
    "ty": "tr",
    "p": {"a": 0, "k": [0, 0]},
    "a": {"a": 0, "k": [0, 0]},
    "s": {"a": 0, "k": [100, 100]},
    "r": {"a": 0, "k": 0},
    "o": {"a": 0, "k": 100},
}


def _animated(values: list[Any], times: Array, shape: bool = False) -> dict[str, Any]:
    """A property with keyframes, or a constant one if all values are equal."""
    if all(value == values[0] for value in values):
        only = values[0]
        return {"a": 0, "k": only[0] if len(only) == 1 and not shape else only}
    keys = [
        {"t": round(float(time), 3), "s": [value] if shape else value, **LINEAR}
        for time, value in zip(times, values, strict=True)
    ]
    return {"a": 1, "k": keys}


def _bezier(contour: Array) -> dict[str, Any]:
    """A closed contour (s, 4, 2): vertices, and tangents relative to them, y down."""
    down = contour * [1, -1]
    vertex = down[:, 0]
    arriving = np.roll(down[:, 2], 1, axis=0)
    return {
        "c": True,
        "v": _rounded(vertex),
        "o": _rounded(down[:, 1] - vertex),
        "i": _rounded(arriving - vertex),
    }


def _rounded(values: Any, decimals: int = DECIMALS) -> Any:
    """Numbers for JSON, whole ones as integers."""
    if np.ndim(values):
        return [_rounded(value, decimals) for value in values]
    number = round(float(values), decimals)
    return int(number) if number == int(number) else number
