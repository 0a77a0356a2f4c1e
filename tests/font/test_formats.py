"""Fonts of every format, against HarfBuzz; and the public text-rendering tests."""

from __future__ import annotations

import warnings

import fonts
import formats
import numpy as np
import pytest
import torch
from referee import HarfBuzz, check, locations
from rendering_cases import CASES, TOLERANCE, differences

import vfwidget as vf

AVAR_2 = ("Amstelvar-avar2.subset.ttf", "RobotoDelta-Roman-VF-subset.ttf", "avar2checker.ttf")
"""Held against HarfBuzz in test_avar.py, at final coordinates."""
FORMATS = [
    path
    for path in sorted((formats.CONFORMANCE / "formats").glob("*.?tf"))
    if path.name not in AVAR_2
]


def check_all(data: bytes, count: int = 8) -> None:
    """Hold every glyph against HarfBuzz, at random places and at every region's peak."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", vf.FontWarning)
        font = vf.load_font(data)
    referee = HarfBuzz(fonts.open_font(data))
    rng = np.random.default_rng(2026)
    for name in font.glyph_names:
        peaks = np.unique(font.glyph(name).support[..., 1].numpy(), axis=0)
        check(font, referee, name, np.concatenate([locations(font, count, rng), peaks]))


@pytest.mark.parametrize("build", formats.VARIABLE)
def test_formats_made_up(build):
    check_all(formats.VARIABLE[build](), count=30)


@formats.needs_conformance
@pytest.mark.parametrize("path", FORMATS, ids=lambda path: path.name)
def test_formats_of_public_test_suites(path):
    check_all(path.read_bytes())


@formats.needs_conformance
@pytest.mark.parametrize("case", CASES, ids=[case["id"] for case in CASES])
def test_text_rendering_tests(case):
    assert max(differences(case)) <= TOLERANCE


# Static fonts


@pytest.mark.parametrize("build", [formats.static_truetype, formats.accented_cff])
def test_a_static_font_serves_as_a_target(build):
    with pytest.raises(vf.FontError, match=r"static: .*or pass static=True"):
        vf.load_font(build())
    font, referee = vf.load_font(build(), static=True), HarfBuzz(fonts.open_font(build()))
    assert font.axes == () and font.normalize({}).shape == (0,)
    for name in font.glyph_names:
        check(font, referee, name, np.zeros((1, 0)))
    assert font.glyph("a").jacobian([]).shape[-1] == 0


# Collections


def test_a_font_of_a_collection():
    data = formats.collection(fonts.phantom_points(), formats.random_cff2())
    for index, want in enumerate([fonts.phantom_points(), formats.random_cff2()]):
        font = vf.load_font(data, index=index)
        assert torch.equal(font.glyph("a").default, vf.load_font(want).glyph("a").default)
    assert vf.load_font(data).glyph("a").advance([0, 0]).item() == 600


@pytest.mark.parametrize("index", [2, -1, 0.5, None, "0"])
def test_a_font_that_a_collection_does_not_hold(index):
    data = formats.collection(fonts.phantom_points(), formats.random_cff2())
    with pytest.raises(vf.FontError, match=r"no font of index .*; it holds 2 font"):
        vf.load_font(data, index=index)
    with pytest.raises(vf.FontError, match="it holds 1 font"):
        vf.load_font("dynapuff", index=1)


# Tables that are not there


@pytest.mark.parametrize("tag", ["name", "post", "OS/2", "cmap", "gvar", "GDEF"])
def test_a_font_without_a_table_it_can_do_without(tag):
    def drop(builder):
        if tag in builder.font:
            del builder.font[tag]

    font = vf.load_font(fonts.build(*fonts.base_glyphs(), edit=drop))
    assert font.glyph(1).contours == (4,)
    assert font.family_name == ("Untitled" if tag == "name" else "Tiny")
    assert font.axes[0].name == ("wght" if tag == "name" else "Weight")
    if tag == "gvar":
        assert font.glyph("a").deltas.shape == (12, 2, 0)
    if tag != "cmap":
        text = vf.Text(font, "ab")
        assert text.nearest(0, 0).glyph == 0


def test_a_font_without_outlines():
    def drop(builder):
        del builder.font["glyf"], builder.font["loca"], builder.font["gvar"]

    with pytest.raises(vf.FontError, match="none of the tables GLYF, glyf, CFF2, CFF"):
        vf.load_font(fonts.build(*fonts.base_glyphs(), edit=drop))


@pytest.mark.parametrize("size", [16, 16384])
def test_any_size_of_the_em(size):
    def set_size(builder):
        builder.font["head"].unitsPerEm = size

    assert vf.load_font(fonts.build(*fonts.base_glyphs(), edit=set_size)).units_per_em == size


@pytest.mark.parametrize("size", [0, 15, 16385])
def test_a_size_of_the_em_that_openType_does_not_allow(size):
    def set_size(builder):
        builder.font["head"].unitsPerEm = size

    with pytest.raises(vf.FontError, match=f"head table states {size} units per em"):
        vf.load_font(fonts.build(*fonts.base_glyphs(), edit=set_size))


# Damaged PostScript outlines


BIAS = -107


@pytest.mark.parametrize(
    "programs, message",
    [
        ({"a": [BIAS, "callgsubr"]}, "subroutines nest too deeply"),
        ({"a": [BIAS + 20, "callgsubr"]}, "more than 400000 operators"),
        ({"a": [0, 0, "rmoveto", 1, 2, 3, "rrcurveto"]}, "'a' are damaged"),
        ({"a": [1, 2, 9, "blend", "rmoveto"]}, "blend lacks operands"),
        ({"a": [3, "vsindex", 1, 2, 3, 4, 1, "blend", "hmoveto"]}, "no variation data 3"),
        ({"a": [*[1] * 600, "rlineto"]}, "more than 513 operands"),
        ({"a": [BIAS + 99, "callgsubr"]}, "'a' are damaged"),
    ],
)
def test_damaged_charstrings(programs, message):
    # Subroutine 0 calls itself; 3 to 19 each call the one before four times.
    subroutines = [[BIAS, "callgsubr"], [], [1, 1, "rlineto"]]
    subroutines += [[BIAS + i - 1, "callgsubr"] * 16 for i in range(3, 12)]
    subroutines += [[BIAS + 11, "callgsubr"]] * 9
    font = vf.load_font(formats.cff2(programs, global_subroutines=subroutines))
    with pytest.raises(vf.FontError, match=message):
        font.glyph("a")


@pytest.mark.parametrize("at", ["global subroutines", "charstrings"])
def test_a_list_longer_than_its_table_is_refused_before_it_is_unpacked(at):
    data = bytearray(formats.cff2_with_subroutines())
    table = fonts.open_font(bytes(data)).reader.tables["CFF2"].offset
    start = table + data[table + 2] + int.from_bytes(data[table + 3 : table + 5], "big")
    if at == "charstrings":
        start = table + fonts.open_font(bytes(data))["CFF2"].cff[0].rawDict["CharStrings"]
    data[start : start + 5] = b"\x7f\xff\xff\xff\0"
    with pytest.raises(vf.FontError, match="CFF2 table is damaged: it states a list of 2147483647"):
        vf.load_font(bytes(data))


# Glyphs that would take too much memory


def test_more_glyphs_than_the_file_has_room_for_are_refused_before_they_are_named():
    data = bytearray(formats.beyond_64k())
    start = fonts.open_font(bytes(data)).reader.tables["MAXP"].offset
    data[start + 4] = 0xFF
    with pytest.raises(vf.FontError, match=r"MAXP table is damaged: it states \d+ glyphs"):
        vf.load_font(bytes(data))


def test_too_many_points_and_delta_sets_are_refused():
    ring = [(i, i * i % 7) for i in range(20_000)]
    names = "bcdef"
    glyphs = {"a": fonts.outline(ring)}
    glyphs |= {name: fonts.composite(fonts.component("a")) for name in names}
    parts = [fonts.component("a"), *[fonts.component(name) for name in names]]
    glyphs["g"] = fonts.composite(*parts, *parts)
    glyphs["h"] = fonts.composite(*[fonts.component("g")] * 20)

    def without_totals(builder):
        builder.font.recalcBBoxes = False
        builder.font["glyf"].recalcBounds = lambda *_: None

    font = vf.load_font(fonts.build(glyphs, {}, edit=without_totals))
    with pytest.raises(vf.FontError, match=r"'h' has \d+ points and 0 delta sets; the limit"):
        font.glyph("h")

    moved = [(({"wght": (0, (i + 1) / 400, 1)}), [(1, 0)] * 20_004) for i in range(300)]
    font = vf.load_font(fonts.build({"a": fonts.outline(ring)}, {"a": moved}))
    with pytest.raises(vf.FontError, match="'a' has 20004 points and 300 delta sets; the limit"):
        font.glyph("a")
