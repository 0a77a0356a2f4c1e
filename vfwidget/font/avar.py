"""The avar table: segment maps, and the displacement of coordinates that version 2 adds.

Invalid segment maps are repaired as HarfBuzz does.

OpenType, "avar" table.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from fontTools.ttLib import TTFont

from ..errors import FontWarning, warn_caller
from ..outline.composed import Displaced
from ..outline.variation import merge_regions
from ..outline.varying import Affine
from .source import damage
from .varstore import VariationStore

F2DOT14 = 16384
"""The store holds displacements in units of 1/16384."""
SegmentMap = tuple[tuple[float, float], ...]
IDENTITY_MAP: SegmentMap = ((-1.0, -1.0), (0.0, 0.0), (1.0, 1.0))


def read_segment_maps(font: TTFont, tags: Sequence[str]) -> list[SegmentMap]:
    """The segment map of each axis, in the order of fvar.

    Warns
    -----
    FontWarning
        A map is invalid.
    """
    if "avar" not in font:
        return [IDENTITY_MAP for _ in tags]
    tables = font["avar"].table.AxisSegmentMap
    maps = [[(v.FromCoordinate, v.ToCoordinate) for v in t.AxisValueMap] for t in tables]
    maps += [[]] * (len(tags) - len(maps))
    return [_valid(tag, pairs) for tag, pairs in zip(tags, maps, strict=False)]


@damage("The avar table is damaged")
def read_displacement(font: TTFont, axis_count: int) -> Displaced | None:
    """The map of normalized coordinates to final ones that avar 2 adds to the segment maps.

    None where the coordinates are final already.
    """
    table = font["avar"].table if "avar" in font else None
    if table is None or getattr(table, "VarStore", None) is None:
        return None
    store = VariationStore(table.VarStore, axis_count, "avar")
    index = table.VarIdxMap.mapping if table.VarIdxMap else range(axis_count)
    # As in all such maps, the last entry serves the axes beyond the end.
    rows = [store.row(index[min(axis, len(index) - 1)]) for axis in range(axis_count)]
    support, places = merge_regions([part for _, part in rows])
    deltas = np.zeros((axis_count, len(support)))
    for axis, (row, _) in enumerate(rows):
        np.add.at(deltas[axis], places[axis], row / F2DOT14)
    return Displaced(Affine(np.zeros(axis_count), deltas, support))


def _valid(tag: str, pairs: list[tuple[float, float]]) -> SegmentMap:
    if not pairs:
        return IDENTITY_MAP
    source, target = np.transpose(pairs)
    rises = (np.diff(source) > 0).all() and (np.diff(target) >= 0).all()
    if rises and set(IDENTITY_MAP) <= set(pairs):
        return tuple(pairs)
    warn_caller(
        f"The avar map of axis {tag!r} is invalid: it must rise and take -1, 0 and 1 to "
        "themselves. It is read as HarfBuzz reads it.",
        FontWarning,
    )
    # Outside its ends the map goes on with slope 1, until it comes to -1 or 1.
    limits = [x + side - y for x, y in (pairs[0], pairs[-1]) for side in (-1, 1)]
    corners = sorted({-1.0, 0.0, 1.0, *(x for x in [*source.tolist(), *limits] if abs(x) <= 1)})
    return tuple((x, float(np.clip(_map_as_harfbuzz(x, pairs), -1, 1))) for x in corners)


def _map_as_harfbuzz(x: float, pairs: list[tuple[float, float]]) -> float:
    """A normalized coordinate through a map that may be invalid (HarfBuzz, hb-ot-var-avar-table).

    Outside its ends a map goes on with slope 1.
    """
    # Some fonts state an end twice.
    if len(pairs) > 1 and pairs[0] == (-1, -1) and pairs[1][0] == -1:
        pairs = pairs[1:]
    if len(pairs) > 1 and pairs[-1] == (1, 1) and pairs[-2][0] == 1:
        pairs = pairs[:-1]
    exact = [target for source, target in pairs if source == x]
    if len(exact) == 3:
        return exact[1]
    if exact:
        if x == 0:
            return min(exact[0], exact[-1], key=abs)
        return exact[-1] if x < 0 else exact[0]
    after = next((i for i, pair in enumerate(pairs) if x < pair[0]), len(pairs))
    if after in (0, len(pairs)):
        source, target = pairs[0 if after == 0 else -1]
        return x - source + target
    (x0, y0), (x1, y1) = pairs[after - 1], pairs[after]
    return y0 + (x - x0) * (y1 - y0) / (x1 - x0)
