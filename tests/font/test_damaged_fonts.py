"""Damaged fonts raise one clear error of this package, and no other exception."""

from __future__ import annotations

import logging
import random
from io import BytesIO

import fonts
import formats
import numpy as np
import pytest
import varc_fonts
import variation_tables
from fontTools.ttLib import TTFont

import vfwidget as vf
from vfwidget.font.source import open_font

FONTS = vf.bundled_fonts()


def unpacked(font: TTFont) -> bytes:
    font.flavor = None
    data = BytesIO()
    font.save(data)
    return data.getvalue()


@pytest.mark.parametrize("name", FONTS)
@pytest.mark.parametrize(
    "pack", [fonts.bundled_file, lambda name: unpacked(open_font(name))], ids=["woff2", "ttf"]
)
def test_a_font_cut_anywhere_is_refused(name, pack):
    data = pack(name)
    cuts = [*range(1, 400, 57), *np.linspace(400, len(data) - 5, 20).astype(int), len(data) - 5]
    for cut in cuts:
        with pytest.raises(vf.FontError, match=r"truncated|Not a font file"):
            vf.load_font(data[:cut])


def use_everything(data: bytes, rng: random.Random) -> None:
    font = vf.load_font(data)
    w = np.full(len(font.axes), 0.5)
    font.metrics(w), font.describe()
    for name in rng.sample(font.glyph_names, min(len(font.glyph_names), 8)):
        glyph = font.glyph(name)
        glyph.points(w), glyph.jacobian(w), glyph.side_bearings(w)
    text = vf.Text(font, "aa")
    text.points(), text.jacobian(), repr((font, text, font.instances, font.bounds))


BUILDERS = fonts.CASES | formats.VARIABLE
BUILDERS |= {
    b.__name__: b for b in (varc_fonts.varc, variation_tables.avar_2, variation_tables.with_mvar)
}


MUTANTS = 10
"""Of each font; the attacks try thousands."""


@pytest.mark.parametrize("case", BUILDERS)
@pytest.mark.filterwarnings("ignore::vfwidget.FontWarning")
def test_damaged_bytes_raise_no_other_error(case, caplog):
    caplog.set_level(logging.CRITICAL, "fontTools")
    good = BUILDERS[case]()
    rng = random.Random(case)
    refused = 0
    for _ in range(MUTANTS):
        data = bytearray(good)
        for _ in range(rng.choice([1, 1, 4, 16])):
            at = rng.randrange(len(data))
            data[at] = rng.choice([0, 255, data[at] ^ 1 << rng.randrange(8)])
        try:
            use_everything(bytes(data), rng)
        except vf.VFWidgetError:
            refused += 1
    assert 0 < refused < MUTANTS


def with_part(data: bytes, glyph: int, part: int, at: int, value: int) -> bytes:
    """A font with one byte of one component of a glyph changed, as no library would write it.

    A component is two bytes each of flags and of glyph id, then its two arguments.
    """
    font = fonts.open_font(data)
    start = font.reader.tables["glyf"].offset + font["loca"][glyph] + 10 + 6 * part + at
    return data[:start] + bytes([value]) + data[start + 1 :]


def test_a_glyph_made_of_itself_is_refused():
    data = fonts.build({"a": fonts.outline(), "b": fonts.composite(fonts.component("a"))}, {})
    with pytest.raises(vf.FontError, match="components of glyph 'b' nest too deeply"):
        vf.load_font(with_part(data, 2, 0, 3, 2)).glyph("b")


def test_components_that_multiply_are_refused():
    # Each glyph is four of the one before: sixteen million squares in a small file.
    names = "bcdefghijklm"
    glyphs = {name: fonts.composite(*[fonts.component("a", x) for x in range(4)]) for name in names}
    data = fonts.build({"a": fonts.outline(fonts.SQUARE), **glyphs}, {})
    for glyph in range(3, 2 + len(names)):
        for part in range(4):
            data = with_part(data, glyph, part, 3, glyph - 1)
    font = vf.load_font(data)
    assert len(font.glyph("e").contours) == 4**4
    with pytest.raises(vf.FontError, match="are too many"):
        font.glyph("m")


def test_a_glyph_whose_advance_cannot_be_read_has_no_text():
    data = bytearray(fonts.build(*fonts.base_glyphs()))
    table = fonts.open_font(bytes(data)).reader.tables["gvar"]
    # The headers of all delta sets, after the header and the offsets of the table.
    start, end = table.offset + 40, table.offset + table.length
    data[start:end] = b"\xff" * (end - start)
    font = vf.load_font(bytes(data))
    for _ in range(2):
        with pytest.raises(vf.FontError, match="The data of glyph 'a' are damaged"):
            vf.Text(font, "aa")


def test_a_component_anchored_to_a_missing_point_is_refused():
    glyphs, deltas = fonts.base_glyphs()
    glyphs["c"] = fonts.composite(fonts.component("a"), fonts.component("b", anchor=(3, 0)))
    data = fonts.build(glyphs, deltas)
    vf.load_font(data).glyph("c")
    with pytest.raises(vf.FontError, match="'c' is anchored to a missing point"):
        vf.load_font(with_part(data, 3, 1, 4, 4)).glyph("c")
