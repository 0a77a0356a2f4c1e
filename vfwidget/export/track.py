"""One outline in motion: plain arrays that every export of an animation writes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ..arrays import Array, rotation_matrices
from ..outline.paint import Fill, Shape, joined


@dataclass(frozen=True)
class Track:
    """A letter, or an obstacle, over F successive frames in which its contours correspond.

    Attributes
    ----------
    start : int
        Number of the first frame.
    times : (F,) array
        Seconds since the start of the animation.
    sizes : tuple of int
        The number of cubic segments of each closed contour.
    points : (F, k, 2) array
        Control points, three for each segment, relative to the origin and before rotation; font
        units, y up.
    origins : (F, 2) array
    rotations : (F,) array
        Radians, counterclockwise, about the origin.
    axes : (F, n) array
        User coordinates of the font's axes; n is 0 for an obstacle.
    evaluate : function, optional
        Gives ``points`` (F, k, 2) at user coordinates (F, n), for exports that leave the outlines
        to a program with variable fonts.
    fills : sequence of F Fill, optional
        Paint of a layer of a colour glyph, relative to the origin and before rotation. Default:
        the colour of the text.
    layers : tuple of Track, optional
        Those of a colour glyph, from back to front, which are drawn instead of its own outline.
    """

    start: int
    times: Array
    sizes: tuple[int, ...]
    points: Array = field(repr=False)
    origins: Array = field(repr=False)
    rotations: Array = field(repr=False)
    axes: Array = field(repr=False)
    evaluate: Callable[[Array], Array] | None = field(default=None, repr=False)
    fills: Sequence[Fill] | None = field(default=None, repr=False)
    layers: tuple[Track, ...] = ()

    @property
    def painted(self) -> tuple[Track, ...]:
        """The tracks that are drawn: the layers, or the track itself if there are none."""
        return self.layers or (self,)

    @cached_property
    def constant_fill(self) -> bool:
        """Whether the paint is the same in all frames."""
        return self.fills is None or all(_same(self.fills[0], fill) for fill in self.fills)

    @property
    def drawn(self) -> Array:
        """The control points as drawn, (F, k, 2)."""
        return turned(self.points, self.rotations) + self.origins[:, None]

    def shows(self, frame: int) -> bool:
        """Whether the track includes the frame of this number."""
        return self.start <= frame < self.start + len(self.times)

    def shape(self, frame: int) -> Shape:
        """The closed contours and their paint, as drawn in the frame of this number."""
        index = frame - self.start
        contours = split(self.drawn[index], self.sizes)
        if self.fills is None:
            return Shape(contours)
        rotation = rotation_matrices(self.rotations[index])
        return Shape(contours, self.fills[index].placed(self.origins[index], rotation))

    def local(self, index: int) -> list[Array]:
        """The closed contours relative to the origin in one of the F frames."""
        return split(self.points[index], self.sizes)


def turned(points: Array, angles: Array) -> Array:
    """Points (F, k, 2), each frame rotated about 0 by its angle."""
    if not angles.any():
        return points
    return points @ rotation_matrices(angles).swapaxes(-1, -2)


def split(points: Array, sizes: tuple[int, ...]) -> list[Array]:
    """Control points (k, 2) as closed contours, each (s, 4, 2)."""
    found, start = [], 0
    for size in sizes:
        index = np.arange(3 * size).reshape(size, 3)
        index = np.concatenate([index, (index[:, :1] + 3) % max(3 * size, 1)], 1)
        found.append(points[start + index])
        start += 3 * size
    return [contour for contour in found if len(contour)]


def shapes_at(tracks: Sequence[Track], frame: int) -> list[Shape]:
    """What some tracks draw in the frame of this number, from back to front."""
    return joined(track.shape(frame) for track in tracks if track.shows(frame))


def _same(one: Fill, other: Fill) -> bool:
    names = ("geometry", "offsets", "alphas", "matrix")
    return one.entries == other.entries and all(
        np.array_equal(getattr(one, name), getattr(other, name)) for name in names
    )


def keyframes(track: Track, tolerance: float, by_axes: bool = False) -> list[int]:
    """The fewest frames found between which linear interpolation gives all others.

    If the paint varies, these are all frames. Otherwise they are those of the
    Ramer–Douglas–Peucker algorithm: starting from the first and the last one, the frame with the
    greatest error is added until no error exceeds the tolerance.

    Parameters
    ----------
    track : Track
    tolerance : float
        Greatest distance of a control point from its position in a frame, in font units.
    by_axes : bool
        Whether the axes are interpolated, or the control points.

    Returns
    -------
    list of int
        Indices among the F frames, ascending.
    """
    if not track.constant_fill:
        return list(range(len(track.times)))
    drawn, last = track.drawn, len(track.times) - 1
    kept, open_spans = {0, last}, [(0, last)]
    while open_spans:
        first, end = open_spans.pop()
        if end - first < 2:
            continue
        inner = np.arange(first + 1, end)
        off = blended(track, [first, end], track.times[inner], by_axes) - drawn[inner]
        error = np.hypot(*np.moveaxis(off, -1, 0)).max(1, initial=0.0)
        worst = int(error.argmax())
        if error[worst] > tolerance:
            kept.add(int(inner[worst]))
            open_spans += [(first, int(inner[worst])), (int(inner[worst]), end)]
    return sorted(kept)


def blended(track: Track, keys: list[int], times: Array, by_axes: bool = False) -> Array:
    """What a player draws that interpolates linearly between keyframes, (times, k, 2)."""

    def between(values: Array) -> Array:
        flat = values[keys].reshape(len(keys), -1)
        columns = [np.interp(times, track.times[keys], column) for column in flat.T]
        # A space has no points, hence no columns.
        table = np.reshape(columns, (flat.shape[1], len(times)))
        return table.T.reshape(len(times), *values.shape[1:])

    if by_axes and track.evaluate is not None:
        points = track.evaluate(between(track.axes))
    else:
        points = between(track.points)
    return turned(points, between(track.rotations)) + between(track.origins)[:, None]
