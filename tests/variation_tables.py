"""Tiny fonts with avar 2, MVAR and VVAR, and the variation stores of such tables."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import fonts
from fontTools.fontBuilder import FontBuilder
from fontTools.ttLib import newTable
from fontTools.ttLib.tables import otTables
from fontTools.varLib import builder as varLib_builder
from fontTools.varLib.featureVars import addFeatureVariations

REGIONS = [{"wght": (0, 1, 1)}, {"wdth": (0, 1, 1)}, {"wght": (0, 0.5, 1), "wdth": (0, 1, 1)}]


def add_avar_2(builder: FontBuilder, store: bool = True) -> None:
    """Let weight displace width by -0.5."""
    avar = builder.font["avar"] = newTable("avar")
    avar.majorVersion, avar.segments = 2, {"wght": {}, "wdth": {}}
    avar.table = otTables.avar()
    avar.table.VarIdxMap = avar.table.VarStore = None
    if store:
        rows = varLib_builder.buildVarData([0], [[0], [-8192]], optimize=False)
        regions = varLib_builder.buildVarRegionList([fonts.BOLD], ["wght", "wdth"])
        avar.table.VarStore = varLib_builder.buildVarStore(regions, [rows])


def avar_2(store: bool = True) -> bytes:
    """Weight displaces width by -0.5, and takes the glyphs to a kink of width at the default."""
    glyphs, deltas = fonts.base_glyphs()
    narrow = [(-30, 3), (-20, 0), (0, 9), (50, 0)]
    deltas["a"] += [(fonts.WIDE, [(x, x) for x, _ in narrow] + fonts.STILL)]
    deltas["a"] += [({"wdth": (-1, -1, 0)}, [*narrow, (0, 0), (-90, 0), (0, 0), (0, 0)])]
    return fonts.build(glyphs, deltas, edit=lambda builder: add_avar_2(builder, store))


def avar_2_with_conditions() -> bytes:
    """Weight displaces width, and where the final width is below -0.25 "a" becomes "b"."""

    def add(builder: FontBuilder) -> None:
        add_avar_2(builder)
        addFeatureVariations(builder.font, [([{"wdth": (-1.0, -0.25)}], {"a": "b"})])

    glyphs, deltas = fonts.base_glyphs()
    return fonts.build(glyphs, deltas, edit=add)


def row_store(rows: Sequence[Sequence[int]]) -> Any:
    """A variation store whose rows vary over ``REGIONS``."""
    data = varLib_builder.buildVarData(list(range(len(REGIONS))), list(rows), optimize=False)
    regions = varLib_builder.buildVarRegionList(REGIONS, ["wght", "wdth"])
    return varLib_builder.buildVarStore(regions, [data])


def with_mvar() -> bytes:
    def add(builder: FontBuilder) -> None:
        builder.font["OS/2"].sxHeight = 500
        mvar = builder.font["MVAR"] = newTable("MVAR")
        mvar.table = otTables.MVAR()
        mvar.table.Version, mvar.table.Reserved = 0x00010000, 0
        mvar.table.ValueRecordSize, mvar.table.ValueRecordCount = 8, 1
        record = otTables.MetricsValueRecord()
        record.ValueTag, record.VarIdx = "xhgt", 0
        mvar.table.ValueRecord, mvar.table.VarStore = [record], row_store([[40, 0, 0]])

    return fonts.build(*fonts.base_glyphs(), edit=add)


def with_vertical_metrics(vvar: bool) -> bytes:
    """Advances of vertical text that vary by VVAR, or by the phantom points."""

    def add(builder: FontBuilder) -> None:
        builder.setupVerticalHeader(ascent=500, descent=-500)
        glyf = builder.font["glyf"]
        tops = {name: getattr(glyf[name], "yMax", 0) for name in glyf.keys()}
        builder.setupVerticalMetrics({name: (1000, 880 - top) for name, top in tops.items()})
        if vvar:
            table = builder.font["VVAR"] = newTable("VVAR")
            table.table = otTables.VVAR()
            table.table.Version = 0x00010000
            table.table.VarStore = row_store([[9, 9, 9], [70, -30, 20], [-400, 10, 0]])
            for name in ("AdvHeightMap", "TsbMap", "BsbMap", "VOrgMap"):
                setattr(table.table, name, None)

    glyphs, deltas = fonts.base_glyphs()
    moved = [*[(0, 0)] * 4, (0, 0), (0, 0), (0, 40), (0, -60)]
    deltas["a"] += [(fonts.BOLD, moved)]
    return fonts.build(glyphs, deltas, edit=add)
