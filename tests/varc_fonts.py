"""Tiny fonts whose glyphs are made of components with axes of their own: VARC."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import fonts
from fontTools.fontBuilder import FontBuilder
from fontTools.misc.vector import Vector
from fontTools.ttLib import newTable
from fontTools.ttLib.tables import otTables
from fontTools.varLib import builder as varLib_builder
from variation_tables import REGIONS


def var_component(name: str, **parts: Any) -> Any:
    """A component of VARC: attributes by name, and parts of its transformation."""
    made = otTables.VarComponent()
    made.glyphName = name
    for part, value in parts.items():
        if part in otTables.VAR_TRANSFORM_MAPPING:
            setattr(made.transform, part, value)
            made.flags |= otTables.VAR_TRANSFORM_MAPPING[part].flag
        elif part == "reset":
            made.flags |= otTables.VarComponentFlags.RESET_UNSPECIFIED_AXES
        else:
            setattr(made, part, value)
    if "scaleY" not in parts:
        made.transform.scaleY = made.transform.scaleX
    return made


def condition(axis: int, low: float, high: float) -> Any:
    made = otTables.ConditionTable()
    made.Format, made.AxisIndex = 1, axis
    made.FilterRangeMinValue, made.FilterRangeMaxValue = low, high
    return made


def varc_font(
    composites: Mapping[str, Sequence[Any]],
    rows: Sequence[Sequence[Sequence[int]]] = (),
    edit: Callable[[FontBuilder], None] = lambda _: None,
) -> bytes:
    """A font whose glyphs of these names are made of components with axes of their own.

    Each of ``rows`` has a list of deltas for each of ``REGIONS``.
    """

    def add(builder: FontBuilder) -> None:
        varc = otTables.VARC()
        varc.Version = 0x00010000
        varc.Coverage = otTables.Coverage()
        varc.Coverage.glyphs = sorted(composites, key=builder.font.getGlyphID)
        varc.VarCompositeGlyphs = otTables.VarCompositeGlyphs()
        varc.VarCompositeGlyphs.VarCompositeGlyph = [
            otTables.VarCompositeGlyph(list(composites[name])) for name in varc.Coverage.glyphs
        ]
        varc.AxisIndicesList = otTables.AxisIndicesList()
        varc.AxisIndicesList.Item = [(0,), (1,), (0, 1)]
        varc.ConditionList = otTables.ConditionList()
        varc.ConditionList.ConditionTable = [condition(0, 0.25, 1)]
        varc.ConditionList.ConditionCount = 1
        regions = varLib_builder.buildSparseVarRegionList(REGIONS, ["wght", "wdth"])
        data = varLib_builder.buildMultiVarData(list(range(len(REGIONS))), [])
        for row in rows:
            data.addItem([Vector(part) for part in row])
        varc.MultiVarStore = varLib_builder.buildMultiVarStore(regions, [data])
        # fontTools would draw the glyphs, which may be damaged.
        builder.font.recalcBBoxes = False
        builder.font["VARC"] = newTable("VARC")
        builder.font["VARC"].table = varc
        edit(builder)

    glyphs, deltas = fonts.base_glyphs()
    glyphs |= {name: fonts.outline() for name in composites if name not in glyphs}
    return fonts.build(glyphs, deltas, edit=add)


def varc(edit: Callable[[FontBuilder], None] = lambda _: None) -> bytes:
    """Axis values and transformations that vary, nested, reset, and by condition."""
    rows = [
        [[6000], [-3000], [2000]],
        [[50, -20, 300], [10, 400, -200], [0, 0, 100]],
        [[-400, 300, 100, -150, 60], [200, 100, -50, 80, -30], [100, 0, 0, 0, 0]],
        [[6000, -3000], [1000, 5000], [0, 0]],
    ]
    moved = {"translateX": 40, "translateY": -30, "rotation": 18}
    shaped = {"scaleX": 0.75, "scaleY": 1.25, "skewX": 9, "skewY": -6, "tCenterX": 250}
    composites = {
        "c": [
            var_component(
                "a", axisIndicesIndex=0, axisValues=(0.25,), axisValuesVarIndex=0,
                transformVarIndex=1, **moved,
            ),
            var_component("b", transformVarIndex=2, **shaped),
        ],
        "d": [
            var_component(
                "c", axisIndicesIndex=2, axisValues=(0.5, -0.25), axisValuesVarIndex=3,
                scaleX=0.5, rotation=-45,
            ),
            var_component("a", axisIndicesIndex=1, axisValues=(0.5,), reset=True, tCenterY=99),
        ],
        "e": [
            var_component("b", conditionIndex=0, translateX=300),
            var_component("c", axisIndicesIndex=1, axisValues=(0.75,), reset=True),
        ],
        # Its own outline, at other axis values.
        "a": [var_component("a", axisIndicesIndex=1, axisValues=(0.5,), translateY=25)],
    }  # fmt: skip
    return varc_font(composites, rows, edit)
