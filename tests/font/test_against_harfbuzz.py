"""Every glyph of every bundled font and of fonts made up for it, against HarfBuzz."""

from __future__ import annotations

import functools

import fonts
import numpy as np
import pytest
import torch
from referee import HarfBuzz

import vfwidget as vf
from vfwidget.font.source import open_font

OUTLINE_TOLERANCE = 0.002
FLOAT32 = 2**-22
"""HarfBuzz holds outlines in float32: far from the origin its own grid is coarser than that."""
F2DOT14 = 16384


def locations(font: vf.Font, count: int, rng: np.random.Generator) -> np.ndarray:
    """Random places on the F2Dot14 grid, which is all HarfBuzz can be told."""
    lower, upper = font.bounds
    n = len(font.axes)
    uniform = rng.uniform(lower, upper, (count, n))
    # A third of the coordinates go to where mistakes live: the ends and the default.
    special = rng.choice([-1.0, 0.0, 1.0], (count, n)).clip(lower, upper)
    mixed = np.where(rng.random((count, n)) < 1 / 3, special, uniform)
    fixed = np.stack([lower, upper, np.zeros(n)])
    return np.round(np.concatenate([fixed, mixed]) * F2DOT14) / F2DOT14


def outline_error(ours: list[np.ndarray], theirs: list[np.ndarray]) -> float:
    worst = 0.0
    # HarfBuzz may draw a contour of a single point, as a curve of no length.
    theirs = [contour for contour in theirs if len(contour) and np.ptp(contour, axis=(0, 1)).any()]
    assert len(ours) == len(theirs)
    for mine, other in zip(ours, theirs, strict=True):
        if len(other) == len(mine) - 1:
            # Our closing line has no length here, and HarfBuzz draws none.
            assert np.ptp(mine[-1], axis=0).max() < OUTLINE_TOLERANCE
            mine = mine[:-1]
        assert mine.shape == other.shape
        excess = np.abs(mine - other) - FLOAT32 * np.abs(other)
        worst = max(worst, float(excess.max()))
    return worst


def check(font: vf.Font, referee: HarfBuzz, name: str, places: np.ndarray) -> None:
    glyph = font.glyph(name)
    w = torch.tensor(places)
    contours = [contour.numpy() for contour in glyph.segments(w)]
    advances = glyph.advance(w).numpy()
    for index, place in enumerate(places):
        referee.locate(place)
        error = outline_error([c[index] for c in contours], referee.contours(glyph.glyph_id))
        assert error < OUTLINE_TOLERANCE, f"{name} at {place}: outline off by {error}"
        off = abs(advances[index] - referee.advance(glyph.glyph_id))
        assert off <= 0.5 + 1e-3, f"{name} at {place}: advance off by {off}"


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


@pytest.mark.parametrize(
    "string", ["AVAToy", "ello, fluffy wizards", "e\u0301x\u0301y\u0308z", "f\u200ci"]
)
@pytest.mark.parametrize("name", vf.bundled_fonts())
def test_letters_of_a_word_stand_where_harfbuzz_puts_them(name: str, string: str) -> None:
    font, referee = bundled(name)
    text = vf.Text(font, string)
    word = text.word
    for place in locations(font, 5, np.random.default_rng(7)):
        referee.locate(place)
        glyphs, pens, advance = referee.line(string)
        # HarfBuzz may swap a glyph at other places of the design space; a text keeps its own.
        if glyphs != [glyph.glyph_id for glyph in text.glyphs]:
            continue
        moved = text.at(theta=place)
        assert abs(moved.advance() - advance) <= 0.5 * len(glyphs) + 1e-3
        off = np.abs(word.origins(place[None]) - pens)
        assert (off <= 0.5 * np.arange(len(glyphs)) + 1e-3).all()
