"""Every glyph of every bundled font and of fonts made up for it, against HarfBuzz."""

from __future__ import annotations

import functools

import fonts
import numpy as np
import pytest
from referee import HarfBuzz, check, locations

import vfwidget as vf
from vfwidget.font.source import open_font


@functools.cache
def bundled(name: str) -> tuple[vf.Font, HarfBuzz]:
    return vf.load_font(name), HarfBuzz(open_font(name))


one_in = pytest.mark.parametrize("step", [8, pytest.param(1, marks=pytest.mark.slow)])
"""The plain run checks one glyph in eight, and the slow one every glyph."""


@one_in
@pytest.mark.parametrize("name", vf.bundled_fonts())
def test_glyphs_at_random_places(name: str, step: int) -> None:
    font, referee = bundled(name)
    rng = np.random.default_rng(2026)
    for glyph_name in font.glyph_names[::step]:
        check(font, referee, glyph_name, locations(font, 6, rng))


@one_in
@pytest.mark.parametrize("name", vf.bundled_fonts())
def test_glyphs_at_the_peak_of_each_of_their_regions(name: str, step: int) -> None:
    font, referee = bundled(name)
    for glyph_name in font.glyph_names[::step]:
        peaks = font.glyph(glyph_name).support[..., 1].numpy()
        if len(peaks):
            check(font, referee, glyph_name, np.unique(peaks, axis=0))


@pytest.mark.parametrize("case", fonts.CASES)
def test_what_real_fonts_seldom_do(case: str) -> None:
    data = fonts.CASES[case]()
    font, referee = vf.load_font(data), HarfBuzz(fonts.open_font(data))
    rng = np.random.default_rng(2026)
    for glyph_name in font.glyph_names:
        kinks = font.glyph(glyph_name).support.numpy()
        places = [locations(font, 30, rng), *np.moveaxis(kinks, -1, 0)]
        check(font, referee, glyph_name, np.concatenate(places))
