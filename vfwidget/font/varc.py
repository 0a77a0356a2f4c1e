"""Glyphs of components that have axis values and transformations of their own (VARC).

A component's axis values and its transformation are affine in the scalars at the glyph's own
coordinates. The outline is then drawn at those axis values and transformed, so a glyph of this
kind is a composition and not affine.

The VARC table: github.com/harfbuzz/boring-expansion-spec, "VARC".
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from fontTools.ttLib import TTFont
from fontTools.ttLib.tables.otTables import VAR_TRANSFORM_MAPPING, VarComponentFlags

from ..arrays import Array
from ..errors import FontError
from ..outline.composed import Composed, Coordinates, Displaced
from ..outline.conditions import AllOf, At, Condition, InRange, Not, Positive
from ..outline.placed import Joined, Placed, Replaced, Shown, Transformation
from ..outline.varying import Affine, Varying, constant
from .cache import GlyphCache
from .glyf import COMPONENTS_KEPT, MAX_COMPONENT_DEPTH, MAX_COMPONENTS
from .unpacked import Unpacked
from .varstore import NO_VARIATION

F2DOT14 = 16384
ANGLES = ("rotation", "skewX", "skewY")
RADIANS = np.array([np.pi / 180 if name in ANGLES else 1.0 for name in VAR_TRANSFORM_MAPPING])
"""What 1 is, as the file states each number of a transformation; angles are in degrees there."""
UNITS = np.array([[p.scale / (1 << p.fractionalBits)] for p in VAR_TRANSFORM_MAPPING.values()])
UNITS *= RADIANS[:, None]
"""What a delta of 1 adds to each number of a transformation, (9, 1)."""
STATED = np.array([int(part.flag) for part in VAR_TRANSFORM_MAPPING.values()])
RESET = int(VarComponentFlags.RESET_UNSPECIFIED_AXES)
"""Flags as plain integers: operations on enumerations are slow."""


@dataclass(frozen=True)
class Leaf:
    """The outline of a component that is not composed itself, and the segments of its contours."""

    outline: Affine
    contours: tuple[int, ...]

    @property
    def nbytes(self) -> int:
        """Memory of the arrays, in bytes."""
        return self.outline.nbytes


class VarcReader:
    """The VARC table of a font.

    Parameters
    ----------
    font : TTFont
    axis_count : int
    read : function
        Unpacks a glyph of glyf or CFF2 by name.
    """

    def __init__(self, font: TTFont, axis_count: int, read: Callable[[str], Unpacked]) -> None:
        self._table, self._axis_count, self._read = font["VARC"].table, axis_count, read
        self._still = Displaced(constant(np.zeros(axis_count), axis_count))
        self._leaves: GlyphCache[Leaf] = GlyphCache(COMPONENTS_KEPT)
        self._index = {name: i for i, name in enumerate(self._table.Coverage.glyphs)}
        store = self._table.MultiVarStore
        self._data = store.MultiVarData if store else []
        regions = store.SparseVarRegionList.Region if store else []
        self._support = np.zeros((len(regions), axis_count, 3))
        for j, region in enumerate(regions):
            for part in region.SparseVarRegionAxis:
                sides = part.StartCoord, part.PeakCoord, part.EndCoord
                self._support[j, part.AxisIndex] = sides

    def __contains__(self, name: str) -> bool:
        return name in self._index

    def read(self, name: str) -> tuple[Varying, list[int]]:
        """The outline of one glyph as a function of the font's coordinates, and its contours.

        Raises
        ------
        FontError
            Components nest without end or are too many, or an index leads nowhere.
        """
        drawing = _Drawing(self, name, self._still)
        drawing.add(name, self._still, [], 0)
        if not drawing.parts:
            return constant(np.zeros((0, 2)), self._axis_count), []
        return Joined(drawing.parts), drawing.contours

    def components(self, name: str) -> list[Any]:
        """The components of one glyph."""
        records: list[Any] = self._table.VarCompositeGlyphs.VarCompositeGlyph
        return list(records[self._index[name]].components)

    def leaf(self, name: str) -> Leaf:
        """The outline that a glyph has in glyf or CFF2; many glyphs may have it as a component."""
        leaf = self._leaves.get(name)
        if leaf is None:
            drawn = self._read(name)
            leaf = Leaf(drawn.outline, tuple(drawn.contours))
            self._leaves.add(name, leaf)
        return leaf

    def coordinates(self, component: Any, here: Coordinates, font: Coordinates) -> Coordinates:
        """Where a component's glyph is drawn: the axis values it states replace those around it."""
        base = font if int(component.flags) & RESET else here
        if component.axisIndicesIndex is None:
            return base
        named = self._table.AxisIndicesList.Item[component.axisIndicesIndex]
        if max(named, default=0) >= self._axis_count:
            raise FontError("The VARC table is damaged: a component names an axis that is missing.")
        axes, values = np.array(named, dtype=np.intp), np.array(component.axisValues, dtype=float)
        deltas, support = self._row(component.axisValuesVarIndex, len(axes))
        return Replaced(base, axes, Composed(Affine(values, deltas / F2DOT14, support), here))

    def transformation(self, component: Any, here: Coordinates) -> Varying:
        """How a component is placed, as a matrix (2, 3)."""
        flags = int(component.flags)
        stated = (STATED & flags) != 0
        transform = component.transform
        base = RADIANS * [getattr(transform, name) for name in VAR_TRANSFORM_MAPPING]
        rows, support = self._row(component.transformVarIndex, int(np.count_nonzero(stated)))
        deltas = np.zeros((9, len(support)))
        if len(support):
            deltas[stated] = rows
            deltas *= UNITS
            if not stated[4]:
                # Without a scale in y the one in x serves both.
                deltas[4] = deltas[3]
        return Transformation(Composed(Affine(base, deltas, support), here))

    def condition(self, component: Any, here: Coordinates) -> Condition | None:
        """When a component is drawn; None for always."""
        if component.conditionIndex is None:
            return None
        table = self._table.ConditionList.ConditionTable[component.conditionIndex]
        return At(self._condition(table), here)

    def _condition(self, table: Any) -> Condition:
        if table.Format == 1:
            if not 0 <= table.AxisIndex < self._axis_count:
                raise FontError("The VARC table is damaged: a condition names a missing axis.")
            return InRange(table.AxisIndex, table.FilterRangeMinValue, table.FilterRangeMaxValue)
        if table.Format == 2:
            deltas, support = self._row(table.VarIdx, 1)
            return Positive(Affine(np.array(float(table.DefaultValue)), deltas[0], support))
        if table.Format in (3, 4) and not table.ConditionTable:
            raise FontError("The VARC table is damaged: a condition has no parts.")
        if table.Format == 3:
            return AllOf([self._condition(part) for part in table.ConditionTable])
        if table.Format == 4:
            return Not(AllOf([Not(self._condition(part)) for part in table.ConditionTable]))
        if table.Format == 5:
            return Not(self._condition(table.ConditionTable))
        raise FontError(
            f"The VARC table has a condition of format {table.Format}, which is unknown."
        )

    def _row(self, index: int, count: int) -> tuple[Array, Array]:
        """Deltas (count, m) of as many values, and their support (m, n, 3)."""
        if index == NO_VARIATION:
            return np.zeros((count, 0)), self._support[:0]
        outer, inner = index >> 16, index & 0xFFFF
        if outer >= len(self._data) or inner >= len(self._data[outer].Item):
            raise FontError("The VARC table is damaged: an index leads to no deltas.")
        support = self._support[np.array(self._data[outer].VarRegionIndex, dtype=np.intp)]
        deltas = np.array(self._data[outer].Item[inner], dtype=np.float64)
        # An empty row means that nothing varies.
        deltas = deltas if deltas.size else np.zeros(count * len(support))
        return deltas.reshape(len(support), count).T, support


class _Drawing:
    """One glyph while its components are followed."""

    def __init__(self, reader: VarcReader, name: str, font: Coordinates) -> None:
        self.reader, self.name, self.font = reader, name, font
        self.parts: list[Varying] = []
        self.contours: list[int] = []
        self._components = 0

    def add(
        self,
        name: str,
        here: Coordinates,
        around: list[tuple[Varying, Condition | None]],
        depth: int,
    ) -> None:
        """Add a glyph at some coordinates, inside transformations and conditions around it."""
        if depth > MAX_COMPONENT_DEPTH:
            raise FontError(f"The components of glyph {self.name!r} nest too deeply.")
        for component in self.reader.components(name):
            self._components += 1
            if self._components > MAX_COMPONENTS:
                raise FontError(f"The components of glyph {self.name!r} are too many.")
            coordinates = self.reader.coordinates(component, here, self.font)
            placing = (
                self.reader.transformation(component, here),
                self.reader.condition(component, here),
            )
            inside = [placing, *around]
            # A glyph that names itself means its own outline in glyf or CFF2.
            if component.glyphName != name and component.glyphName in self.reader:
                self.add(component.glyphName, coordinates, inside, depth + 1)
            else:
                self._draw(component.glyphName, coordinates, inside)

    def _draw(
        self,
        name: str,
        coordinates: Coordinates,
        around: list[tuple[Varying, Condition | None]],
    ) -> None:
        leaf = self.reader.leaf(name)
        outline: Varying = Composed(leaf.outline, coordinates)
        for transformation, condition in around:
            outline = Placed(outline, transformation)
            if condition is not None:
                outline = Shown(outline, condition)
        if leaf.contours:
            self.parts.append(outline)
            self.contours += leaf.contours
