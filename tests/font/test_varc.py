"""Components with axes of their own (VARC), against HarfBuzz and fontTools; derivatives."""

from __future__ import annotations

import fonts
import numpy as np
import pytest
import torch
import varc_fonts
from fontTools.pens.recordingPen import DecomposingRecordingPen
from fontTools.ttLib.tables.DefaultTable import DefaultTable
from referee import HarfBuzz, locations

import vfwidget as vf

STEP = 1e-6


def drawn_by_fonttools(data: bytes, name: str, w: np.ndarray) -> np.ndarray:
    """The points that fontTools passes to a pen, without the closing ones."""
    font = fonts.open_font(data)
    location = {axis.axisTag: float(x) for axis, x in zip(font["fvar"].axes, w, strict=True)}
    glyphs = font.getGlyphSet(location=location, normalized=True)
    pen = DecomposingRecordingPen(glyphs)
    glyphs[name].draw(pen)
    return np.array([point for kind, points in pen.value for point in points if point])


def on_curve(glyph: vf.Glyph, w: np.ndarray) -> np.ndarray:
    return glyph.points(w)[::3].numpy()


@pytest.mark.parametrize("name", "acd")
def test_outlines_are_those_of_fonttools_and_harfbuzz(name):
    data = varc_fonts.varc()
    font, referee = vf.load_font(data), HarfBuzz(fonts.open_font(data))
    glyph = font.glyph(name)
    assert not glyph.is_affine
    for w in locations(font, 12, np.random.default_rng(5)):
        ours = on_curve(glyph, w)
        theirs = drawn_by_fonttools(data, name, w)
        # Each of our corners is drawn by fontTools, whatever the order of points.
        apart = np.linalg.norm(ours[:, None] - theirs[None], axis=-1).min(1)
        # fontTools rounds coordinates of components that vary to whole units.
        assert np.sort(apart)[len(apart) // 2] < 1.5
        referee.locate(w)
        contours = [c for c in referee.contours(glyph.glyph_id) if len(c)]
        assert len(contours) == len(glyph.contours)
        for mine, other in zip(glyph.segments(w), contours, strict=True):
            # HarfBuzz rounds the axis values of a component to 1/16384.
            assert np.abs(mine.numpy()[: len(other)] - other).max() < 0.02


def test_a_component_appears_where_its_condition_holds():
    data = varc_fonts.varc()
    font, referee = vf.load_font(data), HarfBuzz(fonts.open_font(data))
    glyph = font.glyph("e")
    for w in [0.25, 0.1], [1, -0.5], [0.2, 0.1], [-1, 0]:
        referee.locate(np.array(w))
        visible = [c for c in glyph.segments(w) if np.ptp(c.numpy(), axis=(0, 1)).max() > 0]
        assert len(visible) == len([c for c in referee.contours(glyph.glyph_id) if len(c)])


@pytest.mark.parametrize("name", "acde")
def test_jacobian_is_the_slope_of_the_points_and_what_autograd_finds(name):
    font = vf.load_font(varc_fonts.varc())
    glyph = font.glyph(name)
    places = torch.tensor([[0.3, -0.4], [-0.6, 0.2], [0.7, 0.8], [0, 0], [0.5, 0]]).double()
    jacobians = glyph.jacobian(places)
    for w, jacobian in zip(places, jacobians, strict=True):
        array = glyph.outline.value_and_jacobian(w.numpy())[1]
        torch.testing.assert_close(jacobian, torch.as_tensor(array))
        for axis in range(2):
            moved = w.clone()
            moved[axis] += STEP
            slope = (glyph.points(moved) - glyph.points(w)) / STEP
            torch.testing.assert_close(jacobian[..., axis], slope, rtol=1e-5, atol=5e-3)
    for w in places[:3]:
        autograd = torch.autograd.functional.jacobian(glyph.points, w, vectorize=True)
        torch.testing.assert_close(glyph.jacobian(w), autograd)


def test_a_text_of_such_glyphs_is_dragged():
    font = vf.load_font(varc_fonts.varc())
    text = vf.Text(font, "cd")
    handle = text.handle(glyph=1, contour=0, segment=2)
    target = text.at(axes={"wght": 650, "wdth": 130}).position(handle)
    solution = vf.solve(text, [vf.Target(handle, target)])
    torch.testing.assert_close(solution.text.position(handle), target, rtol=0, atol=1e-2)


@pytest.mark.parametrize(
    "composites, message",
    [
        ({"c": ["d"], "d": ["c"]}, "nest too deeply"),
        ({"c": ["d"] * 40, "d": ["e"] * 40, "e": ["a"]}, "are too many"),
    ],
)
def test_components_without_end_are_refused(composites, message):
    parts = {
        name: [varc_fonts.var_component(part) for part in components]
        for name, components in composites.items()
    }
    font = vf.load_font(varc_fonts.varc_font(parts))
    with pytest.raises(vf.FontError, match=message):
        font.glyph("c")


def test_an_index_that_leads_nowhere_is_refused():
    part = varc_fonts.var_component("a", transformVarIndex=7, translateX=1)
    font = vf.load_font(varc_fonts.varc_font({"c": [part]}))
    with pytest.raises(vf.FontError, match="VARC table is damaged: an index leads to no deltas"):
        font.glyph("c")


def test_a_table_of_an_older_draft_is_named():
    def cut(builder):
        # The public test fonts of the format's drafts end before what fontTools expects.
        data = builder.font["VARC"].compile(builder.font)
        builder.font["VARC"] = table = DefaultTable("VARC")
        table.data = data[:40]

    with pytest.raises(vf.FontError, match=r"The VARC table is damaged, or follows an older draft"):
        vf.load_font(varc_fonts.varc(cut))
