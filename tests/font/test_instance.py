"""Instances as font files, drawn by HarfBuzz; their names; subsets."""

from __future__ import annotations

import fonts
import formats
import numpy as np
import pytest
import torch
import variation_tables
from fontTools.ttLib import TTFont
from fontTools.ttLib.tables.DefaultTable import DefaultTable
from referee import HarfBuzz

import vfwidget as vf

SOURCES = {
    "recursive": lambda: "recursive",
    "dynapuff": lambda: "dynapuff",
    "cff2_with_two_sets_of_regions": formats.cff2_with_two_sets_of_regions,
    "avar_2": variation_tables.avar_2,
}


@pytest.mark.parametrize("source", SOURCES)
def test_harfbuzz_draws_an_instance_as_its_parent_is_at_those_axes(source, tmp_path):
    parent = vf.load_font(SOURCES[source]())
    values = {axis.tag: 0.7 * axis.minimum + 0.3 * axis.maximum for axis in parent.axes}
    instance = parent.instance(values)
    assert instance.axes == ()
    instance.save(tmp_path / "instance.ttf")
    referee = HarfBuzz(TTFont(tmp_path / "instance.ttf"))
    w = parent.normalize(values)
    for name in parent.glyph_names[:60]:
        glyph = parent.glyph(name)
        drawn = [contour for contour in referee.contours(glyph.glyph_id) if len(contour)]
        ours = [c.numpy() for c in glyph.segments(w)]
        assert len(drawn) == len(ours)
        for mine, other in zip(ours, drawn, strict=True):
            # The instancer rounds the location, each point and the offsets of components.
            assert np.abs(mine[: len(other)] - other).max() <= 2.5, name
        assert abs(glyph.advance(w).item() - referee.advance(glyph.glyph_id)) <= 1


@pytest.mark.parametrize(
    "build, limits",
    [
        (fonts.hvar_by_glyph_id, {"wght": 700, "wdth": 160}),
        (fonts.hvar_by_glyph_id, {"wght": 700}),
        (fonts.hvar_by_glyph_id, {"wght": (500, 900), "wdth": (50, 80, 200)}),
        (fonts.hvar_with_a_map, {"wght": 700, "wdth": 160}),
        (fonts.phantom_points, {"wght": (500, 900)}),
        (fonts.use_my_metrics, {"wght": 700, "wdth": 160}),
        (fonts.use_my_metrics, {"wdth": (60, 90)}),
    ],
)
def test_an_instance_has_the_advances_of_its_parent(build, limits):
    """fontTools takes those of the phantom points, and the HVAR table of a font may have others."""
    parent = vf.load_font(build())
    part = parent.instance(limits)
    for k in range(5):
        axes = {axis.tag: np.interp(k, [0, 4], [axis.minimum, axis.maximum]) for axis in part.axes}
        pinned = {tag: value for tag, value in limits.items() if tag not in axes}
        ours, theirs = part.normalize(axes), parent.normalize(axes | pinned)
        for name in parent.glyph_names:
            # The instancer rounds each delta.
            found = part.glyph(name).advance(ours).clip(0)
            assert abs(found - parent.glyph(name).advance(theirs).clip(0)) <= 2


def test_a_static_font_has_the_advances_that_it_states():
    """Without axes HarfBuzz reads hmtx alone, also where a component lends its metrics."""

    def edit(builder):
        del builder.font["fvar"], builder.font["gvar"]

    glyphs, _ = fonts.base_glyphs()
    glyphs["c"] = fonts.composite(fonts.component("a", flags=fonts.glyf.USE_MY_METRICS))
    data = fonts.build(glyphs, {}, metrics={"c": (431, 100)}, edit=edit)
    font, referee = vf.load_font(data, static=True), HarfBuzz(fonts.open_font(data))
    for glyph in map(font.glyph, "abc"):
        assert glyph.advance([]) == referee.advance(glyph.glyph_id)


def test_axes_are_pinned_or_narrowed():
    parent = vf.load_font("recursive")
    part = parent.instance({"MONO": 0, "CASL": (0, 0.5), "wght": (400, 500, 700)})
    axes = {axis.tag: (axis.minimum, axis.default, axis.maximum) for axis in part.axes}
    assert axes["wght"] == (400, 500, 700)
    assert axes["CASL"] == (0, 0, 0.5)
    assert set(axes) == {"CASL", "wght", "slnt", "CRSV"}


def test_a_named_instance_as_a_font():
    parent = vf.load_font("dynapuff")
    bold = next(instance for instance in parent.instances if instance.name == "Bold")
    font = parent.instance(bold)
    assert font.family_name == "DynaPuff wght 700 wdth 100"


def test_an_instance_is_named_apart_from_its_parent(tmp_path):
    font = vf.load_font("recursive").instance({"wght": 650}, name="My Own")
    font.save(tmp_path / "own.ttf")
    names = TTFont(tmp_path / "own.ttf")["name"]
    found = {i: names.getDebugName(i) for i in (1, 2, 4, 6, 16, 17)}
    assert found == {1: "My Own", 2: "Regular", 4: "My Own", 6: "My-Own", 16: None, 17: None}


def test_a_subset_holds_what_its_text_needs():
    parent = vf.load_font("recursive")
    part = parent.instance({"MONO": 0}, string="fin é")
    assert len(part) < 40
    assert all(character in part for character in "fin é")
    assert "x" not in part
    assert vf.Text(part, "fin é").advance() == pytest.approx(vf.Text(parent, "fin é").advance())


@pytest.mark.parametrize("string", ["u\u0308A\u030ao", "\u00fcu", "\u212b"], ids=ascii)
def test_a_subset_holds_characters_that_stand_for_several(string):
    """HarfBuzz sets a letter with its mark as one glyph, and as two without it."""
    text = vf.Text("afacad-flux", string, axes={"wght": 700})
    again = vf.Text(text.to_font(), string)
    for ours, theirs in zip(text.layout, again.layout, strict=True):
        assert ours.cluster == theirs.cluster
        assert (ours.x, ours.y) == pytest.approx((theirs.x, theirs.y), abs=len(string))
        drawn, wanted = theirs.glyph.points([]), ours.glyph.points(text.theta[0])
        assert drawn.shape == wanted.shape and (drawn - wanted).abs().max() <= 2.5
    web = vf.Text(text.font.web_font(string), string)
    assert len(web.layout) == len(text.layout)


@pytest.mark.parametrize(
    "value", [200, 1200, "bold", None, (400, 300), (300, 2000), (1, 2, 3, 4), [], float("nan")]
)
def test_what_is_no_limit_of_an_axis(value):
    with pytest.raises(
        vf.AxisError, match=r"'wght' needs a number, or a range .* 300 … 1000; received"
    ):
        vf.load_font("recursive").instance({"wght": value})


def test_an_unknown_axis():
    with pytest.raises(vf.AxisError, match=r"Unknown axis 'WGHT'\. This font has: MONO, CASL"):
        vf.load_font("recursive").instance({"WGHT": 400})


def test_a_static_font_has_no_instances():
    with pytest.raises(vf.AxisError, match="no axes that could be pinned or narrowed"):
        vf.Text("recursive", "a").to_font().instance({})


@pytest.mark.parametrize("name", ["", " ", 5, "a\0b", "a\ud800", "a" * 256])
def test_what_is_no_name_of_a_family(name):
    text = vf.Text("recursive", "a")
    for make in (lambda: text.to_font(name=name), lambda: text.font.instance({"wght": 400}, name)):
        with pytest.raises(vf.FontError, match="name must be a string of 1 to 255 printable"):
            make()


@pytest.mark.parametrize("string", ["", 5, b"a"])
def test_what_is_no_text_to_keep_glyphs_for(string):
    with pytest.raises(vf.FontError, match="text of at least one character; received"):
        vf.load_font("recursive").instance({"wght": 400}, string=string)


@pytest.mark.parametrize("path", ["", 5, "a\0b", b"a.ttf"])
def test_what_is_no_path_of_a_font(path):
    text = vf.Text("dynapuff", "a")
    for save in (text.font.save, text.to_font):
        with pytest.raises(vf.VFWidgetError, match="A file to write is named by"):
            save(path)


def test_a_file_that_cannot_be_written(tmp_path):
    text = vf.Text("dynapuff", "a")
    for path, error in ((tmp_path, IsADirectoryError), (tmp_path / "a/b", FileNotFoundError)):
        with pytest.raises(error):
            text.to_font(path)


def test_a_font_that_cannot_be_instantiated():
    def add(builder):
        builder.font["STAT"] = broken = DefaultTable("STAT")
        broken.data = b"\0\1\0\1\0"

    font = vf.load_font(fonts.build(*fonts.base_glyphs(), edit=add))
    with pytest.raises(vf.FontError, match="No instance can be made of this font"):
        font.instance({"wght": 400})


def test_a_text_as_a_font(tmp_path):
    text = vf.Text("recursive", "fin", axes={"wght": 650, "CASL": 0.4, "slnt": -7})
    font = text.to_font(tmp_path / "text.ttf", name="Fin")
    assert vf.load_font(tmp_path / "text.ttf", static=True).family_name == "Fin"
    assert "x" not in font
    for letter, glyph in zip("fin", text.glyphs, strict=True):
        drawn, want = font.glyph(letter).points([]), glyph.points(text.theta[0])
        assert (drawn - want).abs().max() <= 2.5


def test_a_text_whose_letters_have_axes_of_their_own_is_no_font():
    with pytest.raises(vf.TextError, match="one location for all letters"):
        vf.Text("recursive", "fin", shared=False).to_font()


def test_an_instance_of_postscript_outlines_may_join_lines_but_fills_the_same_area():
    # fontTools joins lines that follow one another in one direction, also where the second goes
    # back. The instance then has fewer points, and the same area.
    parent = vf.load_font(formats.random_cff2())
    instance = parent.instance({"wght": 400, "wdth": 100})
    joined = 0
    for name in "abcdef":
        glyph, twin = parent.glyph(name), instance.glyph(name)
        joined += glyph.contours != twin.contours
        outlines = [glyph.segments([0, 0]), twin.segments([])]
        points = torch.cat([contour.reshape(-1, 2) for contour in outlines[0]])
        low, size = points.amin(0), float((points.amax(0) - points.amin(0)).max())
        images = [
            vf.rasterize([(contour - low) * (48 / size) for contour in outline], (48, 48))
            for outline in outlines
        ]
        torch.testing.assert_close(images[1], images[0], rtol=0, atol=1e-6)
    assert joined
