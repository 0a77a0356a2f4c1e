"""Outlines in motion as Lottie, a JSON format of vector animation (lottie.github.io, "Spec")."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..outline.paint import SOLID, Colour, Fill, Palette, solid
from .lottie_paint import gradient
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
    times: Array,
    fps: float,
    tolerance: float,
    colour: tuple[int, int, int],
    palette: Palette = (),
) -> str:
    """Write a Lottie document; players have no variable fonts, so it holds the outlines.

    Parameters
    ----------
    letters, obstacles : sequences of Track
    title : str
    box : (left, bottom, right, top)
        The part of the plane that the picture shows, in font units, y up.
    times : (T,) array
        Seconds from the start to each frame.
    fps : float
        Frames per second, on average.
    tolerance : float
        As in :func:`~vfwidget.export.track.keyframes`.
    colour : (red, green, blue)
        0 to 255 each.
    palette : palette, optional
        The colours that paints refer to.

    Raises
    ------
    MotionError
        Lottie has no such gradient; see :func:`~vfwidget.export.lottie_paint.gradient`.
    """
    left, bottom, right, top = box
    corner = np.array([left, top])
    # The first layer is the topmost.
    shapes = [(t, 100) for t in reversed(letters)] + [(t, OBSTACLE_OPACITY) for t in obstacles]
    inks = _Inks((*(part / 255 for part in colour), 1.0), palette)  # type: ignore[arg-type]
    # A frame lasts until the next one; the last one as long as the others on average.
    ends = [*(times[1:] * fps), times[-1] * fps + 1]
    layers = [
        _layer(index, track, opacity, corner, fps, ends, tolerance, inks)
        for index, (track, opacity) in enumerate(shapes, start=1)
    ]
    document = {
        "v": "5.7.0",
        "fr": fps,
        "ip": 0,
        "op": round(ends[-1], 3),
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
    ends: Sequence[float],
    tolerance: float,
    inks: _Inks,
) -> dict[str, Any]:
    keys = keyframes(track, tolerance)
    times = track.times[keys] * fps
    origins = (track.origins[keys] - corner) * [1, -1]
    forms = [track.local(key) for key in keys]
    paths = [
        {"ty": "sh", "ks": _animated([_bezier(form[c]) for form in forms], times, shape=True)}
        for c in range(len(forms[0]))
    ]
    fills = track.fills or [solid(None, 1.0)]
    # Paint that varies has a keyframe at every frame.
    fill = inks.fill(fills[:1] if track.constant_fill else fills, times)
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
        "op": round(float(ends[track.start + len(track.times) - 1]), 3),
        "st": 0,
        "shapes": [{"ty": "gr", "it": [*paths, fill, _IDENTITY]}],
    }


class _Inks(NamedTuple):
    """The colours of a document."""

    foreground: Colour
    palette: Palette

    def fill(self, fills: Sequence[Fill], times: Array) -> dict[str, Any]:
        """The paint of a layer: one for all times, or one for each."""
        colours = [fill.colours(self.palette, self.foreground) for fill in fills]
        common = {"r": 1}  # the nonzero rule
        if fills[0].kind == SOLID:
            opacity = _animated([[_rounded(100 * c[0, 3], 2)] for c in colours], times)
            colour = _animated([[*np.round(c[0, :3], 4).tolist(), 1] for c in colours], times)
            return {"ty": "fl", "c": colour, "o": opacity, **common}
        found = [gradient(*one) for one in zip(fills, colours, strict=True)]
        made = {
            "ty": "gf",
            "o": {"a": 0, "k": 100},
            "t": 2 if found[0].radial else 1,
            "s": _animated([_rounded(one.start) for one in found], times),
            "e": _animated([_rounded(one.end) for one in found], times),
            "g": {"p": len(colours[0]), "k": _animated([one.stops for one in found], times)},
            **common,
        }
        if found[0].radial:
            made["h"] = _animated([[_rounded(one.highlight, 2)] for one in found], times)
            made["a"] = _animated([[_rounded(one.angle, 2)] for one in found], times)
        return made


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
