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


@pytest.mark.parametrize("name", vf.bundled_fonts())
def test_every_glyph_at_random_places(name: str) -> None:
    font, referee = bundled(name)
    rng = np.random.default_rng(2026)
    for glyph_name in font.glyph_names:
        check(font, referee, glyph_name, locations(font, 6, rng))


@pytest.mark.parametrize("name", vf.bundled_fonts())
def test_every_glyph_at_the_peak_of_each_of_its_regions(name: str) -> None:
    font, referee = bundled(name)
    for glyph_name in font.glyph_names:
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
