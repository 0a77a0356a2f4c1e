"""Delta sets of TrueType glyphs (gvar, and GVAR for fonts of more than 65,535 glyphs).

fontTools decodes the tuples of one glyph. The table is read here, so that a glyph can be refused
before its deltas are unpacked, two axes may share a tag, and nothing stays in memory.

OpenType, "gvar" table.
"""

from __future__ import annotations

import struct

import numpy as np
from fontTools.ttLib import TTFont
from fontTools.ttLib.tables import TupleVariation as tuples
from fontTools.varLib.iup import iup_delta

from ..arrays import Array
from ..errors import FontError
from ..limits import limits


def check_size(name: str, points: int, sets: int) -> None:
    """Refuse a glyph that would take too much memory.

    Raises
    ------
    FontError
        Points × (1 + delta sets) exceed ``limits.glyph_points``.
    """
    if points * (1 + sets) > limits.glyph_points:
        raise FontError(
            f"Glyph {name!r} has {points} points and {sets} delta sets; the limit for "
            f"points × (1 + delta sets) is {limits.glyph_points}. "
            "If you trust the file, raise vfwidget.limits.glyph_points."
        )


class GlyphVariations:
    """The gvar or GVAR table of a font; a font without one has glyphs that do not vary.

    Parameters
    ----------
    font : TTFont
    tag : {"gvar", "GVAR"}
    axis_count : int

    Raises
    ------
    FontError
        The table states another number of axes than fvar.
    """

    def __init__(self, font: TTFont, tag: str, axis_count: int) -> None:
        self._axis_count = axis_count
        self._data = font.reader[tag] if tag in font else b""
        self._support: dict[tuple[tuple[int, tuple[float, float, float]], ...], Array] = {}
        self._glyph_count = 0
        if not self._data:
            return
        # GVAR counts glyphs in three bytes, gvar in two.
        id_size = 3 if tag == "GVAR" else 2
        axes, shared_count, shared_at = struct.unpack(">HHL", self._data[4:12])
        at = 12 + id_size
        self._glyph_count = int.from_bytes(self._data[12:at], "big")
        flags, self._start = struct.unpack(">HL", self._data[at : at + 6])
        self._id_size = id_size
        self._offsets = at + 6
        self._offset_size = 4 if flags & 1 else 2
        if axes != axis_count:
            raise FontError(
                f"The {tag} table is damaged: it has {axes} axes, and fvar has {axis_count}."
            )
        self._shared = tuples.decompileSharedTuples(
            list(range(axis_count)), shared_count, self._data, shared_at
        )

    def read(
        self, name: str, glyph_id: int, default: Array, ends: list[int]
    ) -> tuple[Array, Array]:
        """The delta sets of one glyph.

        Parameters
        ----------
        name : str
            For messages.
        glyph_id : int
        default : (k, 2) array
            Its points, phantom points last.
        ends : list of int
            Index of the last point of each contour.

        Returns
        -------
        deltas : (m, k, 2) array
            Deltas that the file leaves out are inferred.
        support : (m, n, 3) array
        """
        found = self._decode(name, glyph_id, len(default))
        deltas = np.zeros((len(found), *default.shape))
        support = np.zeros((len(found), self._axis_count, 3))
        points: list[list[float]] = []
        for j, variation in enumerate(found):
            support[j] = self._region(variation.axes)
            if None in variation.coordinates:
                points = points or default.tolist()
                # Each phantom point counts as a contour of its own: nothing is inferred for it.
                deltas[j] = iup_delta(variation.coordinates, points, ends)
            else:
                deltas[j] = variation.coordinates
        return deltas, support

    def _decode(self, name: str, glyph_id: int, points: int) -> list[tuples.TupleVariation]:
        if glyph_id >= self._glyph_count:
            return []
        at, size = self._offsets + glyph_id * self._offset_size, self._offset_size
        begin, end = (int.from_bytes(self._data[i : i + size], "big") for i in (at, at + size))
        scale = 1 if size == 4 else 2
        data = self._data[self._start + begin * scale : self._start + end * scale]
        if not data:
            return []
        count = int.from_bytes(data[:2], "big")
        check_size(name, points, count & tuples.TUPLE_COUNT_MASK)
        first = int.from_bytes(data[2 : 2 + self._id_size], "big")
        return tuples.decompileTupleVariationStore(
            "gvar",
            list(range(self._axis_count)),
            count,
            points,
            self._shared,
            data,
            2 + self._id_size,
            first,
        )

    def _region(self, axes: dict[int, tuple[float, float, float]]) -> Array:
        """One region over all axes, (n, 3); glyphs share most of them."""
        key = tuple(axes.items())
        if key not in self._support:
            region = np.zeros((self._axis_count, 3))
            for axis, sides in key:
                region[axis] = sides
            self._support[key] = region
        return self._support[key]
