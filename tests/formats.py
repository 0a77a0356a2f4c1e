"""Tiny fonts of formats other than glyf + gvar, and the folder of fonts from public test suites."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from io import BytesIO
from pathlib import Path
from typing import Any

import fonts
import numpy as np
import pytest
from fontTools.colorLib import builder as colorLib
from fontTools.fontBuilder import FontBuilder
from fontTools.misc.psCharStrings import T2CharString
from fontTools.misc.vector import Vector
from fontTools.pens.t2CharStringPen import T2CharStringPen
from fontTools.ttLib import TTFont, newTable
from fontTools.ttLib.tables import otTables
from fontTools.ttLib.ttCollection import TTCollection
from fontTools.varLib import builder as varLib_builder
from fontTools.varLib.featureVars import addFeatureVariations

CONFORMANCE = Path(__file__).parents[1] / ".." / "shared" / "conformance"
needs_conformance = pytest.mark.skipif(
    not CONFORMANCE.is_dir(), reason=f"the fonts of {CONFORMANCE} are missing"
)

Program = Sequence[Any]
REGIONS = [{"wght": (0, 1, 1)}, {"wdth": (0, 1, 1)}, {"wght": (0, 0.5, 1), "wdth": (0, 1, 1)}]


def saved(font: TTFont) -> bytes:
    data = BytesIO()
    font.save(data)
    return data.getvalue()


def postscript_builder(programs: Mapping[str, Program]) -> tuple[FontBuilder, dict[str, Any]]:
    """A font to be given a CFF or CFF2 table, and its charstrings."""
    strings = {name: T2CharString(program=list(program)) for name, program in programs.items()}
    builder = FontBuilder(1000, isTTF=False)
    builder.setupGlyphOrder(list(strings))
    builder.setupCharacterMap({ord(name): name for name in strings if len(name) == 1})
    builder.setupHorizontalMetrics({name: (600, 0) for name in strings})
    builder.setupHorizontalHeader(ascent=800, descent=-200)
    builder.setupNameTable({"familyName": "Tiny", "styleName": "Regular"})
    builder.setupOS2()
    builder.setupPost()
    return builder, strings


def cff2(
    programs: Mapping[str, Program],
    regions: Sequence[dict[str, Any]] = REGIONS,
    subroutines: Sequence[Program] = (),
    global_subroutines: Sequence[Program] = (),
    edit: Callable[[TTFont], None] | None = None,
) -> bytes:
    """A CFF2 font of two axes whose blends vary over ``regions``."""
    builder, strings = postscript_builder({".notdef": (), **programs})
    builder.setupFvar([fonts.WEIGHT, fonts.WIDTH], [])
    builder.setupCFF2(strings, [{}], regions=list(regions))
    cff = builder.font["CFF2"].cff
    top = cff[0]
    for program in global_subroutines:
        cff.GlobalSubrs.append(T2CharString(program=list(program)))
    if subroutines:
        from fontTools.cffLib import SubrsIndex

        private = top.FDArray[0].Private
        private.Subrs = SubrsIndex()
        for program in subroutines:
            private.Subrs.append(T2CharString(program=list(program), private=private))
    if edit:
        edit(builder.font)
    # fontTools would run the charstrings, which may be damaged.
    builder.font.recalcBBoxes = False
    return saved(builder.font)


def cff(programs: Mapping[str, Program]) -> bytes:
    """A static font of PostScript outlines."""
    names = {".notdef": ["endchar"], **programs}
    builder, strings = postscript_builder(names)
    builder.setupCFF("Tiny-Regular", {"FullName": "Tiny"}, strings, {"nominalWidthX": 500})
    return saved(builder.font)


ARITIES = {
    "rlineto": [2, 4, 6],
    "hlineto": [1, 2, 5],
    "vlineto": [1, 2, 4],
    "rrcurveto": [6, 12],
    "hhcurveto": [4, 5, 9],
    "vvcurveto": [4, 5, 9],
    "hvcurveto": [4, 5, 8, 9, 13],
    "vhcurveto": [4, 5, 8, 9, 13],
    "rcurveline": [8, 14],
    "rlinecurve": [8, 10],
    "flex": [13],
    "hflex": [7],
    "hflex1": [9],
    "flex1": [11],
}
"""How many operands each path operator may have."""


def random_program(rng: np.random.Generator, regions: int) -> list[Any]:
    """Contours of every operator, about half of their operands blended."""

    def operands(count: int) -> list[Any]:
        tokens: list[Any] = []
        while count:
            n = int(rng.integers(1, count + 1))
            tokens += rng.integers(-200, 200, n).tolist()
            if regions and rng.random() < 0.5:
                tokens += [*rng.integers(-60, 60, n * regions).tolist(), n, "blend"]
            count -= n
        return tokens

    program = [*operands(4), "hstemhm", *operands(2), "hintmask", bytes([0b11100000])]
    for begin, count in ("rmoveto", 2), ("hmoveto", 1), ("vmoveto", 1):
        program += [*operands(count), begin]
        for name in rng.permutation(list(ARITIES)):
            count = int(rng.choice(ARITIES[name]))
            # flex1 asks whether it goes farther in x or in y, so one of them is made far longer.
            first = [5000] if name == "flex1" else []
            program += [*first, *operands(count - len(first)), str(name)]
    return program


def random_cff2() -> bytes:
    rng = np.random.default_rng(12)
    return cff2({name: random_program(rng, len(REGIONS)) for name in "abcdef"})


def cff2_with_subroutines() -> bytes:
    line = [10, 20, 30, 5, 6, 7, 1, "blend", "hlineto"]
    bias = -107
    return cff2(
        {
            "a": [0, 0, "rmoveto", bias, "callsubr", bias + 1, "callgsubr", 7, 300, "rlineto"],
            # A contour that begins without a move.
            "b": [bias, "callsubr", 50, "vlineto"],
        },
        subroutines=[line, [100, 100, "rlineto"]],
        global_subroutines=[[5, 5, "rlineto"], [bias + 1, "callsubr", bias, "callgsubr"]],
    )


def cff2_with_two_sets_of_regions() -> bytes:
    def add(font: TTFont) -> None:
        data = font["CFF2"].cff[0].VarStore.otVarStore.VarData
        from copy import deepcopy

        data.append(deepcopy(data[0]))
        data[1].VarRegionIndex, data[1].VarRegionCount = [2, 0], 2

    return cff2(
        {
            "a": [1, "vsindex", 100, 50, 10, 20, 30, 40, 2, "blend", "rmoveto", 300, 300, "rlineto",
                  -200, 90, 80, 1, "blend", "hlineto"],
            "b": [100, 50, 10, 20, 30, 1, 2, 3, 2, "blend", "rmoveto", 300, 30, 3, 2, 1, 1, "blend",
                  "rlineto", 77, "hlineto"],
        },
        edit=add,
    )  # fmt: skip


def cff2_closing_only_at_the_default() -> bytes:
    """The last line ends at the start at the default, and apart from it elsewhere."""
    return cff2(
        {
            "a": [0, 0, "rmoveto", 300, "hlineto", 300, "vlineto",
                  -300, -300, 40, 50, 60, 7, 8, 9, 2, "blend", "rlineto"],
            "b": [0, 0, "rmoveto", 300, "hlineto", 300, "vlineto", -300, -300, "rlineto"],
        }
    )  # fmt: skip


def with_hvar(data: bytes) -> bytes:
    font = TTFont(BytesIO(data))
    builder = FontBuilder(font=font)
    fonts.hvar(None)(builder)
    return saved(font)


def cff2_with_hvar() -> bytes:
    return with_hvar(random_cff2())


def collection(*members: bytes) -> bytes:
    holder = TTCollection()
    holder.fonts = [TTFont(BytesIO(data)) for data in members]
    data = BytesIO()
    holder.save(data)
    return data.getvalue()


def cubic_glyf() -> bytes:
    """Cubic curves with and without implied points, and contours that begin anywhere."""
    C = 0x80
    contours = {
        "a": [(0, 0, 1), (100, 0, C), (200, 100, C), (200, 200, 1), (0, 300, 1)],
        # Pairs of control points whose on-curve points are implied.
        "b": [(0, 0, 1), (100, 0, C), (200, 0, C), (300, 200, C), (200, 300, C), (0, 300, 1)],
        "c": [(100, 0, C), (200, 0, C), (300, 200, C), (200, 300, C), (0, 300, 1), (0, 0, 1)],
        # A quadratic and a cubic curve in one contour.
        "d": [(0, 0, 1), (100, -50, 0), (200, 0, 1), (250, 100, C), (200, 200, C), (0, 200, 1)],
    }
    glyphs = {}
    for name, points in contours.items():
        glyphs[name] = fonts.outline([point[:2] for point in points])
    deltas = {
        name: [
            (region, [(sign * 7 * i % 50, 5 * i) for i in range(len(points))] + fonts.STILL)
            for region, sign in ((fonts.BOLD, 1), (fonts.WIDE, -1))
        ]
        for name, points in contours.items()
    }

    def mark(font: TTFont) -> None:
        for name, points in contours.items():
            font["GLYF"][name].flags = bytearray(flag for *_, flag in points)

    return extended(fonts.build(glyphs, deltas), mark)


def extended(data: bytes, edit: Callable[[TTFont], None] = lambda _: None) -> bytes:
    """A font with the tables of the longer format (GLYF, GVAR …) in place of the usual ones."""
    font = TTFont(BytesIO(data))
    tags = [tag for tag in ("maxp", "hhea", "hmtx", "loca", "glyf", "gvar") if tag in font]
    font.ensureDecompiled()
    for tag in tags:
        table = newTable(tag.upper())
        table.__dict__.update(font[tag].__dict__ | {"tableTag": tag.upper()})
        font[tag.upper()] = table
    for tag in tags:
        del font[tag]
    edit(font)
    return saved(font)


def beyond_64k() -> bytes:
    return extended(fonts.nested_components())


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


PALETTES = [[(1, 0, 0, 1), (0, 0, 1, 0.5)], [(0, 1, 0, 1), (1, 1, 1, 1)]]


CLIP_BOXES = {"a": (-2000, -2000, 3000, 3000, 0), "e": (150, -500, 1000, 1500, 8)}
"""xMin, yMin, xMax and yMax, and the first row of their deltas."""


def coloured(edit: Callable[[FontBuilder], None] = lambda _: None) -> bytes:
    """Glyph "a" has one layer for each kind of paint, and numbers that vary.

    "c" is a composition that is not drawn as the font asks, "d" paints itself without end, and a
    clip box cuts "e".
    """
    first = iter(range(0, 1000, 8))

    def varying(form: int, **fields: Any) -> dict[str, Any]:
        return {"Format": form, "VarIndexBase": next(first), **fields}

    def line(extend: str) -> dict[str, Any]:
        stops = [(0.25, 0, 1.0), (0.75, 1, 0.5)]
        return {
            "Extend": extend,
            "ColorStop": [
                {"StopOffset": o, "PaletteIndex": i, "Alpha": a, "VarIndexBase": next(first)}
                for o, i, a in stops
            ],
        }

    def inside(paint: dict[str, Any]) -> dict[str, Any]:
        return {"Format": F.PaintGlyph, "Glyph": "a", "Paint": paint}

    F = otTables.PaintFormat
    solid = {"Format": F.PaintSolid, "PaletteIndex": 0xFFFF, "Alpha": 1.0}
    linear = dict(x0=0, y0=0, x1=300, y1=0, x2=30, y2=300)
    radial = dict(x0=0, y0=0, r0=20, x1=100, y1=50, r1=300)
    sweep = dict(centerX=100, centerY=100, startAngle=30, endAngle=200)
    matrix = dict(xx=1.0, yx=0.25, xy=-0.5, yy=1.0, dx=10.0, dy=0.0)
    layers = [
        inside(solid),
        varying(F.PaintVarTranslate, dx=50, dy=0, Paint=inside(solid)),
        inside(varying(F.PaintVarLinearGradient, ColorLine=line("pad"), **linear)),
        {
            "Format": F.PaintVarTransform,
            "Transform": {"VarIndexBase": next(first), **matrix},
            "Paint": inside(varying(F.PaintVarRadialGradient, ColorLine=line("reflect"), **radial)),
        },
        varying(
            F.PaintVarRotateAroundCenter,
            angle=30.0,
            centerX=100,
            centerY=100,
            Paint=inside(varying(F.PaintVarSweepGradient, ColorLine=line("repeat"), **sweep)),
        ),
    ]
    composite = {
        "Format": F.PaintComposite,
        "CompositeMode": "xor",
        "SourcePaint": inside(solid),
        "BackdropPaint": inside(solid),
    }
    glyphs: dict[str, Any] = {
        "a": {"Format": F.PaintColrLayers, "Layers": layers},
        "c": composite,
        "d": {"Format": F.PaintColrGlyph, "Glyph": "d"},
        "e": inside(solid),
    }

    def add(builder: FontBuilder) -> None:
        rows = [
            [(7 * i + 3 * j) % 41 - 20 for j in range(len(REGIONS))] for i in range(next(first))
        ]
        store = row_store([[40 * delta for delta in row] for row in rows])
        order = builder.font.getReverseGlyphMap()
        builder.font["COLR"] = colorLib.buildCOLR(
            glyphs, version=1, glyphMap=order, varStore=store, clipBoxes=CLIP_BOXES
        )
        builder.font["CPAL"] = colorLib.buildCPAL(PALETTES)
        edit(builder)

    shapes, deltas = fonts.base_glyphs()
    shapes |= {name: fonts.outline([(0, 0), (0, 90), (90, 90)]) for name in "cde"}
    return fonts.build(shapes, deltas, edit=add)


def flat_colours() -> bytes:
    """COLR version 0: glyph "b" has two layers of one colour each."""

    def add(builder: FontBuilder) -> None:
        builder.setupCOLR({"b": [("a", 1), ("b", 0xFFFF)]}, version=0)
        builder.setupCPAL(PALETTES)

    return fonts.build(*fonts.base_glyphs(), edit=add)


def static_colours() -> bytes:
    """COLR version 1 in a font without axes: a colour, a gradient and a turn."""
    F = otTables.PaintFormat
    line = {"Extend": "pad", "ColorStop": [(0.0, 0), (1.0, 1)]}
    linear = dict(ColorLine=line, x0=0, y0=0, x1=300, y1=0, x2=30, y2=300)
    fills = [
        {"Format": F.PaintSolid, "PaletteIndex": 1, "Alpha": 0.5},
        {"Format": F.PaintLinearGradient, **linear},
    ]
    layers = [{"Format": F.PaintGlyph, "Glyph": "a", "Paint": fill} for fill in fills]
    layers.append({"Format": F.PaintRotate, "angle": 30.0, "Paint": layers[1]})

    def add(builder: FontBuilder) -> None:
        del builder.font["fvar"], builder.font["gvar"]
        order = builder.font.getReverseGlyphMap()
        glyphs = {"a": {"Format": F.PaintColrLayers, "Layers": layers}}
        builder.font["COLR"] = colorLib.buildCOLR(glyphs, version=1, glyphMap=order)
        builder.font["CPAL"] = colorLib.buildCPAL(PALETTES)

    return fonts.build(*fonts.base_glyphs(), edit=add)


def static_truetype() -> bytes:
    def drop(builder: FontBuilder) -> None:
        del builder.font["fvar"], builder.font["gvar"]

    return fonts.build(*fonts.base_glyphs(), edit=drop)


def accented_cff() -> bytes:
    """An accented letter composed by the old four operands of ``endchar``."""
    pen = T2CharStringPen(600, None)
    pen.moveTo((0, 0))
    pen.lineTo((300, 0))
    pen.lineTo((100, 500))
    pen.closePath()
    letter = pen.getCharString().program
    accent = [20, 30, "rmoveto", 50, "hlineto", 40, "vlineto", "endchar"]
    return cff({"a": letter, "acute": accent, "aacute": [120, 480, 97, 194, "endchar"]})


VARIABLE: dict[str, Callable[[], bytes]] = {
    build.__name__: build
    for build in (
        random_cff2,
        cff2_with_subroutines,
        cff2_with_two_sets_of_regions,
        cff2_closing_only_at_the_default,
        cff2_with_hvar,
        cubic_glyf,
        beyond_64k,
    )
}


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
