"""Tiny variable fonts, each of which uses a feature of the format that few real fonts use.

``CASES`` names functions that build one as the bytes of a font file.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping, Sequence
from io import BytesIO
from itertools import accumulate
from pathlib import Path
from typing import Any

from fontTools.fontBuilder import FontBuilder
from fontTools.ttLib import TTFont, newTable
from fontTools.ttLib.tables import _g_l_y_f as glyf
from fontTools.ttLib.tables import otTables
from fontTools.ttLib.tables.DefaultTable import DefaultTable
from fontTools.ttLib.tables.ttProgram import Program
from fontTools.ttLib.tables.TupleVariation import TupleVariation
from fontTools.varLib import builder
from fontTools.varLib.featureVars import addFeatureVariations

import vfwidget as vf

Region = dict[str, tuple[float, float, float]]
DeltaSet = tuple[Region, list[Any]]

WEIGHT = ("wght", 100, 400, 900, "Weight")
WIDTH = ("wdth", 50, 100, 200, "Width")
BOLD: Region = {"wght": (0, 1, 1)}
LIGHT: Region = {"wght": (-1, -1, 0)}
WIDE: Region = {"wdth": (0, 1, 1)}
ADVANCE = 600
STILL = [(0, 0)] * 4
"""Phantom points that stay where they are."""

CASES: dict[str, Callable[[], bytes]] = {}


def case(build: Callable[[], bytes]) -> Callable[[], bytes]:
    CASES[build.__name__] = build
    return build


def outline(*contours: Sequence[tuple[int, ...]]) -> glyf.Glyph:
    """A simple glyph; a third number, 0, marks a point as off the curve."""
    points = [point for contour in contours for point in contour]
    glyph = glyf.Glyph()
    glyph.numberOfContours = len(contours)
    glyph.coordinates = glyf.GlyphCoordinates([point[:2] for point in points])
    glyph.flags = bytearray(int(len(point) == 2) for point in points)
    glyph.endPtsOfContours = [end - 1 for end in accumulate(map(len, contours))]
    glyph.program = Program()
    glyph.program.fromBytecode(b"")
    return glyph


def composite(*components: glyf.GlyphComponent) -> glyf.Glyph:
    glyph = glyf.Glyph()
    glyph.numberOfContours = -1
    glyph.components = list(components)
    return glyph


def component(
    name: str,
    x: int = 0,
    y: int = 0,
    matrix: Any = None,
    flags: int = 0,
    anchor: tuple[int, int] | None = None,
) -> glyf.GlyphComponent:
    """A component at an offset, or with ``anchor``: its second point put on an earlier one."""
    part = glyf.GlyphComponent()
    part.glyphName, part.flags = name, flags
    if anchor:
        part.firstPt, part.secondPt = anchor
    else:
        part.x, part.y = x, y
    if matrix:
        part.transform = matrix
    return part


def build(
    glyphs: Mapping[str, glyf.Glyph],
    deltas: Mapping[str, Sequence[DeltaSet]],
    axes: Sequence[tuple[Any, ...]] = (WEIGHT, WIDTH),
    metrics: Mapping[str, tuple[int, int]] | None = None,
    edit: Callable[[FontBuilder], None] | None = None,
) -> bytes:
    """A font of these glyphs; a glyph of a one-letter name stands for that letter.

    ``metrics`` are (advance, left side bearing), by default ``ADVANCE`` and the true one.
    """
    glyphs = {".notdef": outline(), **glyphs}
    font = FontBuilder(1000, isTTF=True)
    font.setupGlyphOrder(list(glyphs))
    font.setupCharacterMap({ord(name): name for name in glyphs if len(name) == 1})
    font.setupGlyf(dict(glyphs))
    plain = {name: (ADVANCE, getattr(glyph, "xMin", 0)) for name, glyph in glyphs.items()}
    font.setupHorizontalMetrics(plain | dict(metrics or {}))
    font.setupHorizontalHeader(ascent=800, descent=-200)
    font.setupNameTable({"familyName": "Tiny", "styleName": "Regular"})
    font.setupFvar(list(axes), [])
    font.setupGvar(
        {
            name: [TupleVariation(dict(region), list(points)) for region, points in sets]
            for name, sets in deltas.items()
        }
    )
    font.setupOS2()
    font.setupPost()
    if edit:
        edit(font)
    data = BytesIO()
    font.font.save(data)
    return data.getvalue()


def open_font(data: bytes) -> TTFont:
    return TTFont(BytesIO(data))


def bundled_file(name: str = "dynapuff") -> bytes:
    """The bytes of a font that comes with the package."""
    return (Path(vf.__file__).parent / "fonts" / f"{name}.woff2").read_bytes()


SQUARE = [(100, 0), (500, 0), (500, 700), (100, 700)]
BOWL = [(100, 0), (300, -50, 0), (500, 0), (550, 350, 0), (480, 700, 0), (100, 650)]


def base_glyphs() -> tuple[dict[str, glyf.Glyph], dict[str, list[DeltaSet]]]:
    """A square ``a`` and a bowl ``b``, over different regions, to make composites of."""
    square = [(-40, 0), (60, 0), (60, 30), (-40, 30)]
    bowl = [(-10, 5), (7, -20), (30, 5), (90, 0), (44, 21), (-10, 40)]
    return (
        {"a": outline(SQUARE), "b": outline(BOWL)},
        {
            "a": [(BOLD, [*square, (0, 0), (80, 0), (0, 0), (0, 0)])],
            "b": [
                ({"wght": (0, 0.5, 1)}, [*bowl, (-15, 0), (35, 0), (0, 0), (0, 0)]),
                (WIDE, [*bowl[::-1], *STILL]),
            ],
        },
    )


# Composite glyphs


@case
def transformed_components() -> bytes:
    glyphs, deltas = base_glyphs()
    glyphs["c"] = composite(
        component("a", 20, -30, ((0.5, 0), (0, 1.5))),
        component("b", 700, 10, ((-1, 0), (0, 1))),
        component("a", 10, 700, ((0.6, 0.8), (-0.8, 0.6))),
    )
    # A composite's deltas move its components, one "point" each.
    deltas["c"] = [
        (BOLD, [(10, 20), (-30, 7), (0, 0), *STILL]),
        ({"wdth": (-1, -1, 0)}, [(0, 0), None, (55, -21), (0, 0), (120, 0), (0, 0), (0, 0)]),
    ]
    return build(glyphs, deltas)


@case
def scaled_component_offsets() -> bytes:
    glyphs, deltas = base_glyphs()
    for name, flag in ("c", glyf.SCALED_COMPONENT_OFFSET), ("d", glyf.UNSCALED_COMPONENT_OFFSET):
        glyphs[name] = composite(
            component("a"), component("b", 300, 200, ((0.5, 0.25), (-0.25, 0.75)), flag)
        )
        deltas[name] = [(BOLD, [(0, 0), (40, 60), *STILL])]
    return build(glyphs, deltas)


@case
def anchored_components() -> bytes:
    glyphs, deltas = base_glyphs()
    glyphs["c"] = composite(
        component("a", 50, 0),
        component("b", matrix=((0.5, 0), (0, 0.5)), anchor=(2, 3)),
        # Anchored to a point that came with the component before.
        component("a", matrix=((0, 1), (-1, 0)), anchor=(7, 1)),
    )
    # What is given for an anchored component has no effect.
    deltas["c"] = [(WIDE, [(33, 11), (500, 500), (-500, 100), *STILL])]
    return build(glyphs, deltas)


@case
def use_my_metrics() -> bytes:
    glyphs, deltas = base_glyphs()
    mine = glyf.USE_MY_METRICS
    glyphs["c"] = composite(component("b", 0, 0, flags=mine), component("a", 0, 300))
    glyphs["d"] = composite(component("a", 0, 0, flags=mine), component("b", 40, 0, flags=mine))
    glyphs["e"] = composite(component("c", 30, 0, ((1.5, 0), (0, 1)), mine))
    moved = [(-70, 0), (300, 0), (0, 0), (0, 0)]
    deltas |= {name: [(BOLD, [(5, 5), (0, 9), *moved])] for name in "cd"}
    deltas["e"] = [(WIDE, [(5, 5), *moved])]
    return build(glyphs, deltas, metrics={name: (640, 100) for name in "bcde"})


@case
def nested_components() -> bytes:
    glyphs, deltas = base_glyphs()
    glyphs["c"] = composite(component("a"), component("b", 200, 100, ((0.5, 0), (0, -0.5))))
    glyphs["d"] = composite(component("c", 10, 20, ((-0.75, 0), (0.5, 0.75))), component("b"))
    glyphs["e"] = composite(component("d", 0, -100), component("c", anchor=(3, 2)))
    deltas |= {
        "c": [(BOLD, [(10, 0), (20, 5), *STILL])],
        "d": [(LIGHT, [(0, 17), (-9, 9), *STILL])],
        "e": [({"wght": (0, 1, 1), "wdth": (0, 1, 1)}, [(31, 13), (0, 0), *STILL])],
    }
    return build(glyphs, deltas)


# Contours


@case
def contours_of_every_shape() -> bytes:
    ring = [(300, 0, 0), (600, 0, 0), (600, 500, 0), (300, 600, 0)]
    glyphs = {
        "a": outline(ring),
        "b": outline([(0, 300, 0), (0, 0), (400, 0), (400, 300, 0), (200, 500)]),
        "c": outline([(0, 300, 0), (0, 0), (400, 0, 0), (400, 300), (200, 500, 0)]),
        # Anchors for marks: a contour of one point is no outline.
        "d": outline([(250, 700)], SQUARE, [(250, 0, 0)], ring),
        "e": outline([(0, 0), (500, 500)], [(0, 0), (400, 500, 0)], [(9, 0, 0), (500, 99, 0)]),
        # The last point lies on the first, at the default only.
        "f": outline([*SQUARE, SQUARE[0]], [*BOWL, BOWL[0]]),
        "g": outline(),
        " ": outline(),
    }
    deltas = {
        name: [
            (region, [(7 * i % 31, sign * 5 * i % 23) for i in range(points)] + STILL)
            for region, sign in ((BOLD, 1), (WIDE, -1))
        ]
        for name, points in zip("abcdefg ", [4, 5, 5, 10, 6, 12, 0, 0], strict=True)
    }
    deltas[" "] = [(WIDE, [(0, 0), (150, 0), (0, 0), (0, 0)])]
    return build(glyphs, deltas)


@case
def left_out_deltas() -> bytes:
    """Deltas to infer: between, beside and beyond the points that have one."""
    glyphs = {
        "a": outline(SQUARE, BOWL, [(900, 100), (950, 100), (950, 400, 0)]),
        # Points with deltas that share an x: what lies between has theirs only if they agree.
        "b": outline([(0, 0), (0, 100), (0, 200), (50, 200), (-50, 100), (0, 300)]),
    }
    moved = [(30, 0), None, (-20, 44), None, None]
    deltas: dict[str, list[DeltaSet]] = {
        "a": [
            # The first contour is touched once, so all of it moves; the last not at all.
            (BOLD, [None, None, (12, 34), None, (10, 0), *moved, *[None] * 3, *STILL]),
            (LIGHT, [(5, 6), None, None, (7, 8), None, (1, 2), *moved[:4], *[(3, 4)] * 3, *STILL]),
            (WIDE, [*[None] * 13, None, (77, 0), None, None]),
        ],
        "b": [
            (BOLD, [(10, 0), None, (20, 60), None, None, None, *STILL]),
            (WIDE, [(10, 0), None, (10, 60), None, None, (0, -5), *STILL]),
        ],
    }
    return build(glyphs, deltas)


# Regions


@case
def regions_of_every_shape() -> bytes:
    """Of every valid shape: of others HarfBuzz makes what is fastest."""
    # No two share a peak: where one of those is out of reach, HarfBuzz 15 skips the other too.
    supports = [
        *[(0, 0.25, 0.5), (0.25, 0.5, 1), (0.5, 1, 1), (0, 0.625, 0.625), (0.375, 0.375, 1)],
        *[(0.75, 0.75, 0.75), (-1, -0.5, 0), (-0.625, -0.625, 0), (-1, -1, -0.25)],
    ]
    regions: list[Region] = [{"wght": support} for support in supports]
    regions += [{"wdth": (0, 0.5, 1), "wght": support} for support in supports]
    deltas = [
        (region, [(3 * i + j, 5 * i - j) for j in range(4)] + [(-i, 0), (2 * i, 0), (0, 0), (0, 0)])
        for i, region in enumerate(regions, start=1)
    ]
    return build({"a": outline(SQUARE)}, {"a": deltas})


@case
def one_tag_on_two_axes() -> bytes:
    """Two axes moved by one slider bend the path of a point: only their product moves it."""
    both = {"wght": (0, 1, 1), "WGHT": (0, 1, 1)}
    first = {"wght": (0, 1, 1)}

    def segment_maps(font: FontBuilder) -> None:
        font.font["avar"] = newTable("avar")
        font.font["avar"].segments = {
            "wght": {-1.0: -1.0, 0.0: 0.0, 0.5: 0.25, 1.0: 1.0},
            "WGHT": {-1.0: -1.0, 0.0: 0.0, 1.0: 1.0},
        }

    data = build(
        {"a": outline(SQUARE)},
        {
            "a": [
                (both, [(0, 100), (0, 90), (0, 80), (0, 70), *STILL]),
                (first, [(50, 0), (60, 0), (70, 0), (80, 0), (0, 0), (9, 0), (0, 0), (0, 0)]),
            ]
        },
        axes=(WEIGHT, ("WGHT", *WEIGHT[1:])),
        edit=segment_maps,
    )
    # No library writes such a font, so it is written with two tags and the second renamed.
    font = open_font(data)
    fvar = font.reader.tables["fvar"]
    renamed = font.reader["fvar"].replace(b"WGHT", b"wght")
    return data[: fvar.offset] + renamed + data[fvar.offset + fvar.length :]


# Metrics


@case
def phantom_points() -> bytes:
    """No HVAR: advances and the origin follow the phantom points, wherever the outline goes."""
    glyphs, deltas = base_glyphs()
    left, right = (-35, 0), (120, 0)
    deltas["a"] += [(LIGHT, [*[(0, 0)] * 4, left, right, (0, 0), (0, 0)])]
    deltas["b"] += [(LIGHT, [*[(9, 9)] * 6, (20, 0), (-400, 0), (0, 0), (0, 0)])]
    glyphs["c"], deltas["c"] = (
        outline(SQUARE),
        [(WIDE, [*[(0, 0)] * 5, (-5000, 0), (0, 0), (0, 0)])],
    )
    # The side bearings stated are not those of the outlines.
    return build(glyphs, deltas, metrics={"a": (600, 40), "b": (500, 160), "c": (300, -20)})


def hvar(glyph_indices: Mapping[str, int] | None, rows: int = 4) -> Callable[[FontBuilder], None]:
    """Adds an HVAR table; with indices, through a map from glyphs to its rows."""

    def edit(font: FontBuilder) -> None:
        regions = [BOLD, WIDE, {"wght": (0, 0.5, 1), "wdth": (-1, -1, 0)}]
        data = builder.buildVarData(
            [0, 1, 2], [[13 * i, -7 * i, 300 - i] for i in range(rows)], optimize=False
        )
        table = otTables.HVAR()
        table.Version = 0x00010000
        table.VarStore = builder.buildVarStore(
            builder.buildVarRegionList(regions, ["wght", "wdth"]), [data]
        )
        table.AdvWidthMap = table.LsbMap = table.RsbMap = None
        if glyph_indices is not None:
            order = font.font.getGlyphOrder()
            table.AdvWidthMap = builder.buildVarIdxMap([glyph_indices[n] for n in order], order)
        font.font["HVAR"] = newTable("HVAR")
        font.font["HVAR"].table = table

    return edit


@case
def hvar_by_glyph_id() -> bytes:
    glyphs, deltas = base_glyphs()
    return build(glyphs | {"c": outline(SQUARE)}, deltas, edit=hvar(None))


@case
def hvar_with_fewer_rows_than_glyphs() -> bytes:
    glyphs, deltas = base_glyphs()
    return build(glyphs | {"c": outline(SQUARE)}, deltas, edit=hvar(None, rows=2))


@case
def hvar_with_a_map() -> bytes:
    glyphs, deltas = base_glyphs()
    nowhere = 0xFFFFFFFF
    indices = {".notdef": 0, "a": 3, "b": nowhere, "c": 3, "d": 1, "e": 1 << 16}
    others = {name: outline(SQUARE) for name in "cde"}
    return build(glyphs | others, deltas, edit=hvar(indices))


# Segment maps


def with_segment_map(pairs: Sequence[tuple[float, float]]) -> bytes:
    """A font of one axis with any avar map, valid or not."""

    def add(font: FontBuilder) -> None:
        # fontTools keeps one pair for each coordinate, so the table is written byte by byte.
        rounded = [round(x * 16384) for pair in pairs for x in pair]
        numbers = [1, 0, 0, 1, len(pairs), *rounded]
        font.font["avar"] = raw = DefaultTable("avar")
        raw.data = struct.pack(f">{len(numbers)}h", *numbers)

    return build({"a": outline(SQUARE)}, {"a": []}, axes=(WEIGHT,), edit=add)


def swapping(
    conditions: list[dict[str, tuple[float, float]]],
    edit: Callable[[FontBuilder], None] | None = None,
    deltas: Mapping[str, Sequence[DeltaSet]] | None = None,
) -> bytes:
    """A square ``a`` that becomes a bowl inside some boxes of weight and width."""

    def add(font: FontBuilder) -> None:
        addFeatureVariations(font.font, [(conditions, {"a": "bowl"})])
        if edit:
            edit(font)

    return build({"a": outline(SQUARE), "bowl": outline(BOWL)}, deltas or {}, edit=add)
