"""The paint of a colour glyph as Lottie has it: a colour, a linear or a radial gradient."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..errors import MotionError
from ..outline.paint import LINEAR, SWEEP, Fill, straightened

SIMILAR = 1e-6
"""Relative deviation from a similarity, and from equal centres, that is rounding."""
LEAST_RADIUS = 1e-3
"""Font units."""
MOST_HIGHLIGHT = 0.99
"""Players keep the centre of the colours inside the circle."""


class Gradient(NamedTuple):
    """A gradient, in font units, y down.

    Attributes
    ----------
    radial : bool
    start, end : (2,) arrays
        Radial: the centre of the circle and a point on it.
    highlight, angle : float
        Radial: distance of the centre of the colours from that of the circle, in per cent of the
        radius, and its direction from the end, in degrees.
    stops : list of float
        Offset, red, green and blue of each stop, then offset and alpha of each.
    """

    radial: bool
    start: Array
    end: Array
    highlight: float
    angle: float
    stops: list[float]


def gradient(fill: Fill, colours: Array) -> Gradient:
    """A gradient at one location, with the colours (s, 4) of its stops.

    Raises
    ------
    MotionError
        Lottie has no such gradient.
    """
    if fill.kind == SWEEP:
        raise _missing("sweep gradients")
    if fill.extend != "pad":
        raise _missing("gradients that repeat or reflect their colours")
    linear, shift = fill.matrix[:, :2], fill.matrix[:, 2]
    if fill.kind == LINEAR:
        start, end = fill.geometry.reshape(2, 2)
        across = np.array([start[1] - end[1], end[0] - start[0]])
        points = np.stack([start, end, start + across]) @ linear.T + shift
        first, last = straightened(points.ravel()).reshape(2, 2) * [1, -1]
        return Gradient(False, first, last, 0.0, 0.0, _stops(fill.offsets, colours))
    scale = float(np.sqrt(abs(np.linalg.det(linear))))
    if abs(linear.T @ linear - scale**2 * np.eye(2)).max() > SIMILAR * scale**2:
        raise _missing("radial gradients that are stretched or slanted")
    x0, y0, r0, x1, y1, r1 = fill.geometry
    focus, centre = (np.array([[x0, y0], [x1, y1]]) @ linear.T + shift) * [1, -1]
    inner, outer, offsets = scale * max(r0, 0.0), scale * max(r1, 0.0), fill.offsets
    if inner > outer:
        focus, centre, inner, outer = centre, focus, outer, inner
        offsets, colours = 1 - offsets[::-1], colours[::-1]
    outer = max(outer, LEAST_RADIUS)
    away = focus - centre
    far = float(np.hypot(*away)) / outer
    if inner > SIMILAR * outer and far > SIMILAR:
        raise _missing("radial gradients between two circles with different centres")
    offsets = (inner + offsets * (outer - inner)) / outer
    angle = float(np.degrees(np.arctan2(away[1], away[0])))
    highlight = 100 * min(far, MOST_HIGHLIGHT)
    end = centre + np.array([outer, 0.0])
    return Gradient(True, centre, end, highlight, angle, _stops(offsets, colours))


def _stops(offsets: Array, colours: Array) -> list[float]:
    solid = np.column_stack([offsets, colours[:, :3]])
    alpha = np.column_stack([offsets, colours[:, 3]])
    stops: list[float] = np.round(np.concatenate([solid.ravel(), alpha.ravel()]), 4).tolist()
    return stops


def _missing(what: str) -> MotionError:
    return MotionError(
        f"Lottie has no {what}, and a colour glyph of this text has one. Use to_svg or to_html."
    )
