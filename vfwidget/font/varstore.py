"""Item variation stores: the rows of deltas that HVAR, VVAR, MVAR, avar 2, CFF2 and COLR share.

OpenType, "Font variations common table formats", item variation store.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..arrays import Array
from ..errors import FontError

NO_VARIATION = 0xFFFFFFFF
"""The index of a value that does not vary."""


class VariationStore:
    """Rows of deltas, each over some of the store's regions.

    Parameters
    ----------
    store : fontTools.ttLib.tables.otTables.VarStore or None
        None stands for a store without rows.
    axis_count : int
    tag : str
        The table that holds the store, for messages.

    Attributes
    ----------
    regions : (R, n, 3) array
        Start, peak and end of every region on each axis.

    Raises
    ------
    FontError
        The regions have more axes than the font.
    """

    def __init__(self, store: Any, axis_count: int, tag: str) -> None:
        self._data = store.VarData if store else []
        self._tag = tag
        regions = store.VarRegionList.Region if store and store.VarRegionList else []
        self.regions = np.zeros((len(regions), axis_count, 3))
        for j, region in enumerate(regions):
            sides = [(a.StartCoord, a.PeakCoord, a.EndCoord) for a in region.VarRegionAxis]
            if len(sides) > axis_count:
                raise FontError(
                    f"The {tag} table is damaged: its regions have {len(sides)} axes, "
                    f"and the font has {axis_count}."
                )
            self.regions[j, : len(sides)] = np.reshape(sides, (-1, 3))

    def support(self, outer: int) -> Array:
        """The regions of one part of the store, (m, n, 3).

        Raises
        ------
        FontError
            There is no such part, or it names a region that does not exist.
        """
        if not 0 <= outer < len(self._data):
            raise FontError(f"The {self._tag} table is damaged: it has no variation data {outer}.")
        indices = np.array(self._data[outer].VarRegionIndex, dtype=np.intp)
        if indices.max(initial=-1) >= len(self.regions):
            raise FontError(f"The {self._tag} table is damaged: it names a missing region.")
        return self.regions[indices]

    def row(self, index: int) -> tuple[Array, Array]:
        """The deltas (m,) of one row and their support (m, n, 3).

        An index that leads nowhere means that the value does not vary, as in HarfBuzz.
        """
        outer, inner = index >> 16, index & 0xFFFF
        if outer >= len(self._data) or inner >= len(self._data[outer].Item):
            return np.zeros(0), np.zeros((0, self.regions.shape[1], 3))
        deltas, support = (
            np.array(self._data[outer].Item[inner], dtype=np.float64),
            self.support(outer),
        )
        if len(deltas) != len(support):
            raise FontError(f"The {self._tag} table is damaged: a row has too few deltas.")
        return deltas, support
