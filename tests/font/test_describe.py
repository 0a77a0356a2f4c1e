"""What a font says of itself, and how far each axis moves a glyph."""

from __future__ import annotations

import fonts
import numpy as np
import pytest

import vfwidget as vf


def test_a_description_names_axes_instances_and_tables():
    description = vf.load_font("roboto-flex").describe()
    text = repr(description)
    rows = dict(description.rows)
    assert text.startswith("Roboto Flex\n")
    assert rows["axis wght"].startswith("Weight, 100 … 400 … 1000")
    assert "hidden" in rows["axis XOPQ"]
    assert "gvar" in rows["tables read"]
    assert rows["STAT left aside"] == "not needed to draw"


def test_a_description_says_where_a_segment_map_bends():
    font = vf.load_font(fonts.with_segment_map([(-1, -1), (0, 0), (0.5, 0.25), (1, 1)]))
    assert dict(font.describe().rows)["axis wght"].endswith("900, avar map of 4 points")


def test_a_description_is_html_without_markup_of_the_font():
    def rename(builder):
        builder.font["name"].setName("<b>Tiny", 1, 3, 1, 0x409)

    html = vf.load_font(fonts.build(*fonts.base_glyphs(), edit=rename)).describe()._repr_html_()
    assert "&lt;b&gt;Tiny" in html and "<b>" not in html
    assert html.count("<tr>") == html.count("</tr>") > 5


def test_tables_left_aside_are_named_with_the_reason():
    def add(builder):
        builder.font["SVG "] = picture = fonts.DefaultTable("SVG ")
        picture.data = b"\0\0"
        builder.font["odd "] = odd = fonts.DefaultTable("odd ")
        odd.data = b"?"

    rows = dict(vf.load_font(fonts.build(*fonts.base_glyphs(), edit=add)).describe().rows)
    assert rows["SVG left aside"] == "pictures cannot vary"
    assert rows["odd left aside"] == "unknown table"


def test_the_effect_of_each_axis_by_hand():
    font = vf.load_font(fonts.build(*fonts.base_glyphs()))
    effect = font.axis_effect("a")
    assert set(effect) == {"wght", "wdth"}
    # The right upper corner of the square moves by (60, 30), the farthest of all.
    assert effect["wght"] == pytest.approx(np.hypot(60, 30))
    assert effect["wdth"] == 0
    assert font.axis_effect("b")["wdth"] > 0
    assert vf.load_font("recursive").axis_effect(" ") == dict.fromkeys(
        ["MONO", "CASL", "wght", "slnt", "CRSV"], 0
    )
