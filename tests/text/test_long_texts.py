"""Long texts: what they take grows with their length, and a limit bounds them."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest

import vfwidget as vf
from vfwidget.energy.energy import Energy

WORD = "abcdefghij"


def test_a_text_beyond_the_limit_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(vf.limits, "text_characters", 20)
    assert len(vf.Text("recursive", WORD * 2).glyphs) == 20
    with pytest.raises(vf.TextError, match=r"21 characters; the limit is 20.*text_characters"):
        vf.Text("recursive", WORD * 2 + "a")


def test_letters_of_a_long_text_stand_where_those_of_a_short_one_do() -> None:
    short, long = (vf.Text("recursive", WORD * count).layout for count in (2, 100))
    # From the second word on, each word stands one word farther than the one before.
    width = short[10].x - short[0].x
    found = np.array([glyph.x for glyph in long])
    wanted = [short[i % 10].x + width * (i // 10) for i in range(1000)]
    np.testing.assert_allclose(found, wanted, atol=1e-6)


@pytest.mark.parametrize("shared", [True, False])
def test_points_are_the_same_in_many_small_products(
    monkeypatch: pytest.MonkeyPatch, shared: bool
) -> None:
    text = vf.Text("recursive", WORD, axes={"wght": 700}, shared=shared)
    points = text.point_set()
    whole = points.positions_and_jacobian(text.place)
    monkeypatch.setattr("vfwidget.text.points.PRODUCTS", 500)
    for found, wanted in zip(points.positions_and_jacobian(text.place), whole, strict=True):
        np.testing.assert_allclose(found, wanted, atol=1e-9)


def test_the_derivative_of_many_letters_takes_little_memory() -> None:
    text = vf.Text("recursive", "hamburge" * 15, shared=False)
    handles = [text.handle(letter) for letter in range(len(text.glyphs))]
    tracemalloc.start()
    try:
        energy = Energy(text, [vf.Target(handle, (0.0, 0.0)) for handle in handles])
        jacobian = energy.jacobian(energy.unknowns.start + 0.01)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    # Entries for each row, letter, region and axis took 43 times as much as the derivative.
    assert peak < 22 * jacobian.nbytes


@pytest.mark.slow
def test_the_longest_text_can_be_drawn_and_searched() -> None:
    line = WORD * 40
    text = vf.Text("recursive", "\n".join([line] * 9))
    assert len(text.string) < vf.limits.text_characters
    last = text.layout[-1]
    assert text.nearest(last.x, last.y).glyph in (len(text.glyphs) - 1, len(text.glyphs) - 2)
    flip = text.font.units_per_em * 0.01
    contours = [(segments / flip).numpy() * [1, -1] + [0, 20] for segments in text.segments()]
    drawn = vf.rasterize(contours, size=(160, 2400))
    assert drawn.shape[:2] == (160, 2400)
    assert float(drawn.sum()) > 1000
