"""An animation as images at even steps of time."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ..arrays import Array, to_array
from ..errors import MotionError
from ..export.animated_svg import OBSTACLE_OPACITY
from ..export.track import shapes_at
from ..outline.paint import Shape, solid
from ..solver.problem import is_count
from .numbers import MOST_FRAMES, read_number
from .tracks import Box, outlines

FPS = (0.01, 1000.0)
"""Least and most frames per second; no screen shows more."""
HEIGHTS = (2, 2**20)
"""Least and greatest height of an image in pixels."""
LIGHTER = solid(None, OBSTACLE_OPACITY)
"""The paint of obstacles."""


def frame_numbers(animation: Any, fps: float) -> list[int]:
    """The frame nearest in time to each multiple of 1 / fps.

    Raises
    ------
    MotionError
        ``fps`` is not a number between 0.01 and 1000, or asks for more than 100,000 images.
    """
    fps = read_number("fps", fps, *FPS, open_below=False)
    times = animation.times - animation.times[0]
    count = round(animation.duration * fps) + 1
    if count > MOST_FRAMES:
        raise MotionError(
            f"fps={fps:g} asks for {count:,} images; there may be {MOST_FRAMES:,}. Pass a smaller "
            "fps, or a slice of the animation."
        )
    wanted = np.arange(count) / fps
    middles = (times[1:] + times[:-1]) / 2
    return [int(i) for i in np.searchsorted(middles, wanted)]


def drawn_frames(
    animation: Any, height: int, fps: float, ink: tuple[int, int, int], progress: bool
) -> Iterator[Array]:
    """The images of an animation, (H, W, 4) each; H and W are even.

    Parameters
    ----------
    animation : Animation
    height : int
        Pixels.
    fps : float
        Images per second.
    ink : (red, green, blue)
        0 to 255 each; colour glyphs have their own colours.
    progress : bool
        Whether to show a progress bar.

    Yields
    ------
    (H, W, 4) array
        Red, green, blue and alpha, 0 to 1 each, not premultiplied.

    Raises
    ------
    MotionError
        ``fps`` or ``height`` is not a positive number.
    ImageError
        The images have more pixels than ``vfwidget.limits.raster_pixels``.
    """
    low, high = HEIGHTS
    if not (is_count(height) and low <= height <= high):
        raise MotionError(
            f"height must be a number of pixels, {low} to {high:,}; received {height!r:.200}."
        )
    numbers = frame_numbers(animation, fps)
    letters, obstacles, box, palette = outlines(animation)
    size, placement = _camera(box, int(height))
    from tqdm.auto import tqdm

    from ..raster.colours import paint
    from ..raster.rasterize import check_size

    check_size(size)
    red, green, blue = (part / 255 for part in ink)
    drawn: dict[int, Array] = {}
    for number in tqdm(numbers, desc="frames", leave=False, disable=not progress):
        if number not in drawn:
            # Only a frame that is shown several times in a row is needed again.
            drawn.clear()
            below = [Shape(s.contours, LIGHTER) for s in shapes_at(obstacles, number)]
            shapes = [*below, *shapes_at(letters, number)]
            image = paint(shapes, palette, size, placement, (red, green, blue, 1.0))
            drawn[number] = to_array(image)
        yield drawn[number]


def _camera(box: Box, height: int) -> tuple[tuple[int, int], Array]:
    """The size (H, W) of the images, and the placement (2, 3) of font units in pixels, y down."""
    left, bottom, right, top = box
    height += height % 2
    scale = height / (top - bottom)
    width = int(np.ceil(scale * (right - left)))
    width += width % 2
    x = (width - scale * (right - left)) / 2 - scale * left
    return (height, width), np.array([[scale, 0, x], [0, -scale, scale * top]])
