"""Metrics of a font and vertical advances, against HarfBuzz; their gradients."""

from __future__ import annotations

import fonts
import formats
import numpy as np
import pytest
import torch
import uharfbuzz as hb
import variation_tables
from referee import HarfBuzz, locations

import vfwidget as vf
from vfwidget.font.font_metrics import METRICS
from vfwidget.font.source import open_font

NAMES = vf.bundled_fonts()
FORMATS = [
    formats.CONFORMANCE / folder / name
    for folder, name in (
        ("formats", "32bit_var_store.otf"),
        ("formats", "NotoSans-VF-cubic.subset.ttf"),
        ("trt-fonts", "TestGPOSFour.ttf"),
    )
]
# HarfBuzz scales these by the slant of the caret, or gives the height of a vertical line.
LEFT_OUT = {"caret_rise", "caret_run", "vertical_ascender", "vertical_descender"}


def opentype_tag(name: str) -> hb.OTMetricsTag:
    return hb.OTMetricsTag(int.from_bytes(METRICS[name][0].encode(), "big"))


@pytest.mark.parametrize("source", [*NAMES, *(p for p in FORMATS if p.is_file())], ids=str)
def test_metrics_are_those_of_harfbuzz(source):
    font, referee = vf.load_font(source), HarfBuzz(open_font(source))
    for w in locations(font, 4, np.random.default_rng(3)):
        referee.locate(w)
        found = font.metrics(w)
        assert {"ascender", "descender", "underline_position"} <= set(found)
        for name in set(found) - LEFT_OUT:
            want = referee.font.get_metric_position(opentype_tag(name))
            if want is not None:
                # Some of these HarfBuzz gives with the opposite sign.
                assert abs(abs(found[name].item()) - abs(want)) <= 1, name


def test_metrics_vary_and_are_differentiable():
    font = vf.load_font(variation_tables.with_mvar())
    assert font.metrics([0, 0])["x_height"].item() == 500
    assert font.metrics([0.5, 0])["x_height"].item() == 520
    assert font.metrics(np.zeros((3, 2)))["ascender"].shape == (3,)
    w = torch.tensor([0.25, 0.5], dtype=torch.float64, requires_grad=True)
    font.metrics(w)["x_height"].backward()
    assert w.grad.tolist() == [40, 0]


def test_vertical_advances_are_those_of_harfbuzz():
    for data in map(variation_tables.with_vertical_metrics, (False, True)):
        font, referee = vf.load_font(data), HarfBuzz(fonts.open_font(data))
        for w in locations(font, 6, np.random.default_rng(3)):
            referee.locate(w)
            for glyph in font:
                want = -referee.font.get_glyph_v_advance(glyph.glyph_id)
                assert abs(glyph.vertical_advance(w).item() - want) <= 0.5 + 1e-3


def test_a_font_without_vertical_metrics_says_so():
    with pytest.raises(vf.GlyphError, match="'a' has no vertical metrics"):
        vf.load_font("recursive").glyph("a").vertical_advance([0] * 5)
