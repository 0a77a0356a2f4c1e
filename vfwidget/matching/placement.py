"""Where a text stands in a picture: read from an affine map, or estimated from the ink."""

from __future__ import annotations

import math

import numpy as np

from ..arrays import Array, ArrayLike, to_array
from ..errors import ImageError
from ..text import Text
from .scene import Scene, by_glyphs, middle

CANVAS = 48
"""Pixels of the picture in which a candidate's ink is measured."""
MOST_ROTATION = math.radians(25)
LONG = 1.5
"""The direction of ink tells its rotation only if it is this many times as long as broad."""
NOT_SIMILAR = 1e-6
"""How far, relative to its scale, a placement may be from a similarity."""


def read_placement(placement: ArrayLike | None, text: Text) -> Array | None:
    """An affine map (2, 3) as t, log s and φ of a :class:`~.scene.State`, (4,).

    Raises
    ------
    ImageError
        It is not a similarity that turns y down.
    """
    if placement is None:
        return None
    try:
        matrix = to_array(placement)
    except (TypeError, ValueError, RuntimeError) as error:
        raise ImageError(f"placement must be a (2, 3) array of numbers ({error}).") from None
    if matrix.shape != (2, 3) or not np.isfinite(matrix).all():
        raise ImageError(
            f"placement must be a (2, 3) array of finite numbers; received {matrix!r:.200}."
        )
    linear = matrix[:, :2]
    a, b = linear[:, 0]
    expected = np.array([[a, b], [b, -a]])
    size = math.hypot(a, b)
    if size == 0 or abs(linear - expected).max() > NOT_SIMILAR * size:
        raise ImageError(
            "placement may scale, rotate and shift, and must turn y down: [[a, b, x], [b, -a, y]]; "
            f"received {matrix.tolist()}."
        )
    shift = linear @ middle(text) + matrix[:, 2]
    return np.array([*shift, math.log(size), math.atan2(b, a)])


def place_on_ink(text: Text, thetas: Array, ink: Array, factor: int, rotated: bool) -> Array:
    """The placement (B, 4) that puts the ink of each candidate on that of a picture.

    It matches the middle and the extent of the ink and, if ``rotated``, its direction.

    Raises
    ------
    ImageError
        The text has no ink.
    """
    size = (CANVAS, CANVAS)
    scene = Scene(text, size)
    points = [
        each.positions(each.point_set(), thetas[at]).reshape(-1, 2)
        for each, at in by_glyphs(text, thetas)
    ]
    low, high = (end(np.concatenate(points), 0) for end in (np.min, np.max))
    scale = 0.9 * CANVAS / max(float((high - low).max()), 1.0)
    here = np.array([CANVAS / 2, CANVAS / 2, math.log(scale), 0.0])
    offset = (low + high) / 2 - scene.centre
    here[:2] -= scale * offset * [1, -1]
    own = scene.coverage(thetas, np.broadcast_to(here, (len(thetas), 4)))
    goal = _Moments(ink)
    found = []
    for image in own:
        moments = _Moments(image)
        ratio = goal.extent / moments.extent
        angle = 0.0
        if rotated and min(goal.length, moments.length) > LONG:
            angle = (goal.direction - moments.direction + math.pi / 2) % math.pi - math.pi / 2
            angle = angle if abs(angle) < MOST_ROTATION else 0.0
        rotation = np.array(
            [[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]]
        )
        # From the text's middle to the middle of its ink, in the picture.
        arm = ratio * rotation @ (moments.centre - here[:2])
        place = (goal.centre - arm) * factor
        found.append([*place, math.log(scale * ratio * factor), angle])
    return np.array(found)


class _Moments:
    """Middle, extent and direction of an image's ink, in pixels."""

    def __init__(self, image: Array) -> None:
        total = float(image.sum())
        if total <= 0:
            raise ImageError("There is no ink to match: the text is blank, or far too small.")
        y, x = np.mgrid[: image.shape[0], : image.shape[1]] + 0.5
        self.centre = np.array([(image * x).sum(), (image * y).sum()]) / total
        dx, dy = x - self.centre[0], y - self.centre[1]
        xx, yy, xy = ((image * p).sum() / total for p in (dx * dx, dy * dy, dx * dy))
        self.extent = math.sqrt(xx + yy) or 1.0
        root = math.hypot((xx - yy) / 2, xy)
        large, small = (xx + yy) / 2 + root, (xx + yy) / 2 - root
        self.length = math.sqrt(large / max(small, 1e-9))
        self.direction = math.atan2(2 * xy, xx - yy) / 2
