"""Colour glyphs: layers, each an outline and the paint inside it.

A paint is a solid colour or a gradient. All its numbers may vary with the axes, and so may the map
under which it is placed. The same data serve an SVG document, a raster and the view.

OpenType, "COLR" table; a solid colour is a gradient with one colour stop here.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..arrays import Array
from .composed import Composed, Coordinates
from .varying import Varying

SOLID, LINEAR, RADIAL, SWEEP = "solid", "linear", "radial", "sweep"
SIZES = {SOLID: 0, LINEAR: 6, RADIAL: 6, SWEEP: 4}
"""How many numbers state where each kind of gradient lies."""
Colour = tuple[float, float, float, float]
"""Red, green, blue and alpha from 0 to 1 (sRGB, not premultiplied)."""
Palette = Sequence[Colour]
BLACK: Colour = (0.0, 0.0, 0.0, 1.0)


@dataclass(frozen=True)
class Fill:
    """A paint at one location.

    Attributes
    ----------
    kind : {"solid", "linear", "radial", "sweep"}
    geometry : (q,) array
        Where the first and the last stop lie, in the coordinates of the paint. Linear: their two
        points. Radial: two circles, each a centre and a radius. Sweep: the centre and two angles
        in degrees, counterclockwise from the x axis.
    offsets, alphas : (s,) arrays
        Of the stops, from 0 to 1 and ascending.
    entries : tuple of int or None
        The entry of the palette that each stop takes; None for the colour of the text.
    extend : {"pad", "repeat", "reflect"}
        How the gradient goes on beyond its ends.
    matrix : (2, 3) array
        [A | b]: a point p of the paint lies at A p + b of the glyph.
    """

    kind: str
    geometry: Array
    offsets: Array
    alphas: Array
    entries: tuple[int | None, ...]
    extend: str
    matrix: Array

    def colours(self, palette: Palette, foreground: Colour = BLACK) -> Array:
        """Red, green, blue and alpha of every stop, (s, 4); a missing entry is the foreground."""
        known = [
            foreground if entry is None or entry >= len(palette) else palette[entry]
            for entry in self.entries
        ]
        found = np.array(known, dtype=np.float64)
        found[:, 3] *= self.alphas
        return found

    def sweep(self, angles: Array) -> Array:
        """Where angles in 0 … 360 degrees lie along a sweep gradient; 0 is its first stop."""
        start, end = self.geometry[2:]
        if start == end:
            return np.where(angles < start, -1.0, 2.0)
        return (angles - start) / (end - start)

    def between_stops(self, t: Array, colours: Array) -> Array:
        """The colours (..., 4) along the gradient, from those of its stops (s, 4).

        They are interpolated before they are multiplied by alpha, as SVG does.
        """
        if self.extend == "repeat":
            t = t - np.floor(t)
        elif self.extend == "reflect":
            t = 1 - np.abs(t % 2 - 1)
        # Of stops at one place the first serves what lies before, and the last what lies beyond.
        offsets = self.offsets + 1e-9 * np.arange(len(self.offsets))
        return np.stack([np.interp(t, offsets, part) for part in colours.T], -1)

    def placed(self, origin: Array, rotation: Array) -> Fill:
        """The same paint, rotated about 0 by a matrix (2, 2) and then moved to an origin (2,)."""
        matrix = rotation @ self.matrix
        matrix[:, 2] += origin
        return replace(self, matrix=matrix)


def solid(entry: int | None, alpha: float) -> Fill:
    """One colour: an entry of the palette, or None for the colour of the text."""
    none = np.zeros(0)
    return Fill(SOLID, none, np.zeros(1), np.array([alpha]), (entry,), "pad", np.eye(2, 3))


class Shape(NamedTuple):
    """Contours that are filled together.

    Attributes
    ----------
    contours : list of (s, 4, 2) arrays
    fill : Fill or None
        None for the colour of the text.
    """

    contours: list[Array]
    fill: Fill | None = None


def joined(shapes: Iterable[Shape]) -> list[Shape]:
    """Shapes from back to front, successive ones in the colour of the text as one; at least one."""
    found = [Shape([])]
    for shape in shapes:
        if shape.fill is None and found[-1].fill is None:
            found[-1].contours.extend(shape.contours)
        else:
            found.append(Shape(list(shape.contours), shape.fill))
    return [shape for shape in found if shape.contours] or found[:1]


@dataclass(frozen=True)
class Paint:
    """A solid colour or a gradient whose numbers vary with the axes.

    Attributes
    ----------
    kind, entries, extend
        As in :class:`Fill`.
    numbers : Varying
        Of shape (q + 2 s,): the geometry as the font states it, then the offsets of the s stops,
        then their alphas.
    frame : Varying
        Of shape (3, 2): where the paint's points (0, 0), (1, 0) and (0, 1) lie in the glyph.
    """

    kind: str
    numbers: Varying
    entries: tuple[int | None, ...]
    extend: str
    frame: Varying

    def over(self, coordinates: Coordinates) -> Paint:
        """The paint as a function of coordinates from which its own follow."""
        numbers, frame = (Composed(part, coordinates) for part in (self.numbers, self.frame))
        return replace(self, numbers=numbers, frame=frame)

    def at(self, w: Array) -> Fill:
        """The paint at normalized coordinates w (n,)."""
        numbers, count = self.numbers.value(w), len(self.entries)
        geometry, offsets, alphas = np.split(numbers, [SIZES[self.kind], -count])
        order = np.argsort(offsets, kind="stable")
        offsets, alphas = offsets[order], alphas[order].clip(0, 1)
        # The geometry is moved to the first and the last stop, because SVG knows no stops beyond.
        first, last = float(offsets[0]), float(offsets[-1])
        geometry = _between(self.kind, geometry, first, last if last > first else first + 1)
        offsets = (offsets - first) / (last - first) if last > first else offsets * 0
        origin, x, y = self.frame.value(w)
        return Fill(
            self.kind,
            geometry,
            offsets,
            alphas,
            tuple(self.entries[i] for i in order),
            self.extend if last > first else "pad",
            np.stack([x - origin, y - origin, origin], axis=-1),
        )


def _between(kind: str, geometry: Array, first: float, last: float) -> Array:
    """The geometry of a gradient between two of its offsets."""
    if kind == SOLID:
        return geometry
    if kind == SWEEP:
        start, end = geometry[2:]
        return np.array([*geometry[:2], *(start + (end - start) * t for t in (first, last))])
    if kind == LINEAR:
        geometry = straightened(geometry)
    one, other = np.split(geometry, 2)
    return np.concatenate([one + (other - one) * t for t in (first, last)])


def straightened(geometry: Array) -> Array:
    """Start and end of a linear gradient whose lines of equal colour are at right angles to it.

    The font gives a third point: lines of equal colour are parallel to the one through the first
    and the third.
    """
    start, end, turn = geometry.reshape(3, 2)
    along = turn - start
    across = np.array([-along[1], along[0]])
    length = float(across @ across)
    share = float((end - start) @ across) / length if length else 0.0
    return np.concatenate([start, start + share * across])
