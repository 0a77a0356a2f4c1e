"""Settings: the boxes of the design space in each of which a text has one row of glyphs.

A font may exchange glyphs at some locations, such as a dollar sign without its bar where the
letters are heavy. GSUB and GPOS hold *condition sets* for this: each is a box in normalized
coordinates, and the first set whose box holds the location decides which lookups apply
(OpenType, "FeatureVariations table"). So the design space is cut into boxes, and glyphs change
only at their boundaries.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from itertools import product
from math import prod
from typing import Any

import numpy as np
from fontTools.ttLib import TTFont

from ..arrays import Array, IntArray
from ..errors import TextError
from .shaping import ShapedRow

F2DOT14 = 16384
"""Condition sets are decided on coordinates in whole numbers of 1/16384."""
MOST_CELLS = 100_000
"""More pieces of the design space than this would take seconds to go through."""


def read_conditions(font: TTFont) -> tuple[IntArray, IntArray]:
    """The boxes of the condition sets of GSUB and of GPOS, each (r, n, 2), in units of 1/16384.

    Raises
    ------
    TextError
        A condition is not a range of an axis.
    """
    n = len(font["fvar"].axes) if "fvar" in font else 0
    gsub, gpos = (_boxes(font[tag].table if tag in font else None, n) for tag in ("GSUB", "GPOS"))
    return gsub, gpos


def _boxes(table: Any, n: int) -> IntArray:
    variations = getattr(table, "FeatureVariations", None)
    records = variations.FeatureVariationRecord if variations else []
    boxes = np.empty((len(records), n, 2), dtype=np.intp)
    boxes[:] = -2 * F2DOT14, 2 * F2DOT14
    for box, record in zip(boxes, records, strict=True):
        for condition in record.ConditionSet.ConditionTable if record.ConditionSet else ():
            if condition.Format != 1:
                raise TextError(
                    f"The font chooses glyphs by a condition of format {condition.Format}; "
                    "vfwidget reads format 1 only, which is a range of an axis."
                )
            side = box[condition.AxisIndex]
            side[0] = max(side[0], round(condition.FilterRangeMinValue * F2DOT14))
            side[1] = min(side[1], round(condition.FilterRangeMaxValue * F2DOT14))
    return boxes


Box = tuple[Array, Array]
"""Lower and upper corner of a box of the design space, (n,) each."""
Cell = tuple[int, ...]


class Settings:
    """Which row of glyphs a text has at each location.

    Parameters
    ----------
    conditions : two (r, n, 2) arrays
        From :func:`read_conditions`.
    bounds : two (n,) arrays
        Least and greatest normalized coordinates.
    shape : function
        Shapes the text at normalized coordinates (n,).

    Attributes
    ----------
    rows : tuple of ShapedRow
        The rows that occur; the first is that of the default.
    edges : list of n arrays
        On each axis, the normalized coordinates at which the row may change, ascending. They lie
        halfway between multiples of 1/16384.
    cells : int array with n dimensions
        The index of the row in each box between edges.

    Raises
    ------
    TextError
        The condition sets cut the design space into more than ``MOST_CELLS`` pieces.
    """

    def __init__(
        self,
        conditions: Sequence[IntArray],
        bounds: tuple[Array, Array],
        shape: Callable[[Array], ShapedRow],
    ) -> None:
        self._bounds = bounds
        lower, upper = (np.round(side * F2DOT14) for side in bounds)
        edges = [_edges(conditions, *axis) for axis in enumerate(zip(lower, upper, strict=True))]
        if prod(len(inner) + 1 for inner in edges) > MOST_CELLS:
            raise TextError(
                "The font has too many conditions for choosing glyphs: they cut its design space "
                f"into more than {MOST_CELLS} pieces."
            )
        rows: dict[tuple[ShapedRow, int], int] = {}
        known: dict[tuple[int, ...], int] = {}

        def row_at(place: Array) -> int:
            choice = tuple(_first_match(boxes, place) for boxes in conditions)
            if choice not in known:
                # The same glyphs may stand elsewhere where GPOS has chosen another condition set.
                known[choice] = rows.setdefault((shape(place / F2DOT14), choice[1]), len(rows))
            return known[choice]

        row_at(np.zeros(len(lower)))
        middles = [
            _middles(np.array([low, *inner, high]))
            for low, inner, high in zip(lower, edges, upper, strict=True)
        ]
        cells = np.array([row_at(np.array(place)) for place in product(*middles)])
        self.cells = cells.reshape([len(inner) + 1 for inner in edges])
        self.rows: tuple[ShapedRow, ...] = tuple(row for row, _ in rows)
        self.edges = [inner / F2DOT14 for inner in self._drop_needless(edges)]

    def _drop_needless(self, edges: list[Array]) -> list[Array]:
        """Keep the edges at which some row changes, and join the cells on both sides of others."""
        kept = []
        for axis, inner in enumerate(edges):
            others = tuple(i for i in range(len(edges)) if i != axis)
            changes = (np.diff(self.cells, axis=axis) != 0).any(others)
            self.cells = self.cells.compress(np.append(True, changes), axis)
            kept.append(inner[changes])
        return kept

    def row_at(self, w: Array) -> Any:
        """The indices (...) in ``rows`` of the rows at normalized coordinates w (..., n)."""
        return self.cells[self._cell_at(w)]

    def box_at(self, w: Array) -> Box:
        """The boxes around normalized coordinates w (..., n), up to the last coordinates inside.

        Returns
        -------
        lower, upper : (..., n) arrays
        """
        index, lower, upper = self._box_of_cell
        box = index[self._cell_at(w)]
        return lower[box], upper[box]

    @cached_property
    def all_boxes(self) -> list[Box]:
        """The boxes of all rows, from the first to the last coordinates inside each."""
        _, lower, upper = self._box_of_cell
        return list(zip(lower, upper, strict=True))

    def boxes(self, row: int) -> list[Box]:
        """The boxes in which the text has this row: lower and upper corners, (n,) each.

        Cells that lie side by side are joined where that gives a box.
        """
        return [self._box(first, last) for first, last in self._ranges(row)]

    def _cell_at(self, w: Array) -> tuple[Any, ...]:
        """The cell that holds each location, as an index of ``cells``."""
        rounded = np.round(w * F2DOT14) / F2DOT14
        uncut = np.zeros(w.shape[:-1], dtype=np.intp)
        return tuple(
            inner.searchsorted(rounded[..., axis]) if len(inner) else uncut
            for axis, inner in enumerate(self.edges)
        )

    @cached_property
    def _box_of_cell(self) -> tuple[IntArray, Array, Array]:
        """The index of the box of each cell, and the corners (b, n) of all boxes."""
        index = np.empty(self.cells.shape, dtype=np.intp)
        boxes: list[Box] = []
        for row in range(len(self.rows)):
            for first, last in self._ranges(row):
                index[tuple(slice(i, j + 1) for i, j in zip(first, last, strict=True))] = len(boxes)
                boxes.append(self._box(first, last))
        lower, upper = np.moveaxis(np.array(boxes), 1, 0)
        # The last coordinates inside a box are multiples of 1/16384, unless it ends with the axis.
        first_inside, last_inside = (
            np.ceil(lower * F2DOT14) / F2DOT14,
            np.floor(upper * F2DOT14) / F2DOT14,
        )
        ends = self._bounds
        return (
            index,
            np.where(lower > ends[0], first_inside, lower),
            np.where(upper < ends[1], last_inside, upper),
        )

    def _box(self, first: Cell, last: Cell) -> Box:
        """The corners of a box of cells."""
        sides = [
            np.array([low, *inner, high])
            for low, inner, high in zip(self._bounds[0], self.edges, self._bounds[1], strict=True)
        ]
        return (
            np.array([side[i] for side, i in zip(sides, first, strict=True)]),
            np.array([side[i + 1] for side, i in zip(sides, last, strict=True)]),
        )

    def _ranges(self, row: int) -> list[tuple[Cell, Cell]]:
        """The first and last cells of the boxes in which the text has this row."""
        ranges = [(cell, cell) for cell in map(tuple, np.argwhere(self.cells == row).tolist())]
        for axis in range(len(self.edges)):
            ranges = _join(ranges, axis)
        return ranges


def _edges(conditions: Sequence[IntArray], axis: int, bounds: tuple[float, float]) -> Array:
    """Halfway between the coordinates inside a condition and those outside."""
    ends = [boxes[:, axis] + [-0.5, 0.5] for boxes in conditions]
    found = np.unique(np.concatenate(ends))
    return found[(found > bounds[0]) & (found < bounds[1])]


def _middles(ends: Array) -> Array:
    """A whole number between each two neighbours."""
    return np.maximum(np.floor((ends[:-1] + ends[1:]) / 2), np.ceil(ends[:-1]))


def _first_match(boxes: IntArray, place: Array) -> int:
    """The first box that holds the place, or -1."""
    inside = ((boxes[..., 0] <= place) & (place <= boxes[..., 1])).all(-1)
    return int(inside.argmax()) if inside.any() else -1


def _join(ranges: list[tuple[Cell, Cell]], axis: int) -> list[tuple[Cell, Cell]]:
    """Join boxes of cells that follow one another along an axis and agree along all others."""

    def others(cell: Cell) -> Cell:
        return cell[:axis] + cell[axis + 1 :]

    joined: list[tuple[Cell, Cell]] = []
    order = sorted(ranges, key=lambda r: (others(r[0]), others(r[1]), r[0][axis]))
    for first, last in order:
        if joined:
            before, end = joined[-1]
            same = others(before) == others(first) and others(end) == others(last)
            if same and end[axis] + 1 == first[axis]:
                joined[-1] = before, last
                continue
        joined.append((first, last))
    return joined
