"""Tiny fonts of formats other than glyf + gvar, and the folder of fonts from public test suites."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from io import BytesIO
from pathlib import Path
from typing import Any

import fonts
import numpy as np
import pytest
from fontTools.fontBuilder import FontBuilder
from fontTools.misc.psCharStrings import T2CharString
from fontTools.pens.t2CharStringPen import T2CharStringPen
from fontTools.ttLib import TTFont, newTable
from fontTools.ttLib.ttCollection import TTCollection
from variation_tables import REGIONS

CONFORMANCE = Path(__file__).parents[1] / ".." / "shared" / "conformance"
needs_conformance = pytest.mark.skipif(
    not CONFORMANCE.is_dir(), reason=f"the fonts of {CONFORMANCE} are missing"
)
Program = Sequence[Any]


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
