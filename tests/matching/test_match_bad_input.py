"""What cannot be matched is refused with a clear error."""

from __future__ import annotations

import numpy as np
import pytest
from pictures import match

import vfwidget as vf
from vfwidget.matching.match import Search
from vfwidget.matching.scene import Scene
from vfwidget.raster.coverage import fill

SHEAR = [[0.03, 0.01, 10], [0, -0.03, 50]]
OPTIONS = {
    "a fit of nothing known": ({"fit": ["x", "skew"]}, "'skew' cannot be fitted: choose from x, y"),
    "a fit as one word": ({"fit": "blur"}, "fit must be a sequence of some of x, y"),
    "a fit of lists": ({"fit": [["x"]]}, "fit must be a sequence of some of x, y"),
    "a viewer of no text": ({"watch": 3}, "watch must be an Editor, or a function"),
    "half an iteration": (
        {"max_iterations": 0.5},
        "max_iterations must be a whole number ≥ 0; received 0.5",
    ),
    "optimizer": ({"optimizer": "newton"}, "no optimizer 'newton': choose one of gauss-newton"),
    "loss": ({"loss": "l3"}, "There is no loss 'l3': choose one of linear"),
    "ink": ({"ink": "red"}, "ink must be one of auto, dark, light; received 'red'"),
    "background": ({"background": "odd"}, "background must be one of even, uneven; received 'odd'"),
    "a sheared placement": ({"placement": SHEAR}, "placement may scale, rotate and shift"),
    "a placement with y up": ({"placement": np.eye(2, 3)}, "must turn y down"),
    "a placement of no size": ({"placement": np.zeros((2, 3))}, "placement may scale"),
    "a square placement": (
        {"placement": np.eye(3)},
        r"\(2, 3\) array of finite numbers; received array",
    ),
    "a placement of NaN": (
        {"placement": np.full((2, 3), np.nan)},
        "array of finite numbers; received array",
    ),
    "a second font": ({"fonts": ["dynapuff"]}, r"Give a font, or several as fonts=\[…\]"),
}


@pytest.mark.parametrize("options, message", OPTIONS.values(), ids=OPTIONS)
def test_options_that_are_none(options, message, image):
    with pytest.raises(vf.ImageError, match=message):
        match(image, "S", "dynapuff", **options)


def test_whole_numbers_of_numpy_are_whole_numbers(image):
    options = {"max_iterations": np.int64(1), "resolution": np.int32(32)}
    assert match(image, "S", "dynapuff", **options).text.string == "S"


def test_a_font_has_to_be_given(image):
    with pytest.raises(vf.ImageError, match=r"Give a font, or several as fonts=\[…\]"):
        vf.match(image, "S", progress=False)


@pytest.mark.parametrize("string", [" ", "  ", "\u00a0"], ids=ascii)
def test_a_text_without_ink(string, image):
    with pytest.raises(vf.ImageError, match="no ink to match"):
        match(image, string, "recursive")


@pytest.mark.parametrize(
    "string, font, options, error, message",
    [
        ("あ", "dynapuff", {}, vf.GlyphError, "no glyph"),
        ("", "dynapuff", {}, vf.TextError, "is empty"),
        ("S", "no-such-font", {}, vf.FontError, "no-such-font"),
        ("S", b"no font", {}, vf.FontError, "Not a font file"),
        ("S", "dynapuff", {"axes": {"opsz": 9}}, vf.AxisError, "Unknown axis 'opsz'"),
    ],
)
def test_texts_and_fonts_fail_as_everywhere(string, font, options, error, message, image):
    with pytest.raises(error, match=message):
        match(image, string, font, **options)


def test_a_text_brings_its_font_and_how_axes_are_shared():
    text = vf.Text("dynapuff", "n", shared=False).at(axes=[{"wght": 600}])
    found = vf.match(1 - vf.rasterize(text, (48, 48)).numpy(), text, progress=False)
    assert not found.text.shared
    assert found.axes[0]["wght"] == pytest.approx(600, abs=1)


@pytest.mark.parametrize(
    ("options", "unknowns"),
    # Eight axes; then placement, blur, and seven numbers for the brightness of paper and ink.
    [({}, 8 + 4 + 1 + 7), ({"background": "even", "fit": ["x", "background"]}, 8 + 1 + 2)],
)
def test_a_match_that_is_too_large_is_refused_at_once(monkeypatch, options, unknowns):
    text = vf.Text("dynapuff", "ab\nba", shared=False)
    image = 1 - vf.rasterize(text, (40, 40)).numpy()
    monkeypatch.setattr(vf.limits, "step_products", 1600 * unknowns**2)
    vf.match(image, text, progress=False, max_iterations=0, **options)
    monkeypatch.setattr(Search, "_starts", lambda search: pytest.fail("A stage has begun."))
    monkeypatch.setattr(vf.limits, "step_products", 1600 * unknowns**2 - 1)
    with pytest.raises(vf.SolveError, match=rf"1,600 residuals and {unknowns} unknowns"):
        vf.match(image, text, progress=False, **options)


def test_candidates_of_a_long_text_are_drawn_a_few_at_a_time(monkeypatch):
    text = vf.Text("dynapuff", "long text", axes={"wght": 600})
    drawn = []

    def watched(points, *others):
        drawn.append(points.shape[:2])
        return fill(points, *others)

    monkeypatch.setattr("vfwidget.matching.scene.fill", watched)
    here = Scene(text, (12, 48))
    thetas = np.linspace(0, 1, 7)[:, None, None] * text.coordinates
    places = np.tile(np.array([24.0, 6.0, np.log(0.01), 0.0]), (7, 1))
    together = here.coverage(thetas, places)
    curves = drawn[0][1]
    monkeypatch.setattr("vfwidget.matching.scene.BATCH", 3 * curves)
    np.testing.assert_allclose(here.coverage(thetas, places), together, atol=1e-12)
    monkeypatch.setattr("vfwidget.matching.scene.BATCH", curves // 2)
    np.testing.assert_allclose(here.coverage(thetas, places), together, atol=1e-12)
    assert [count for count, _ in drawn] == [7, 3, 2, 2, 1, 1, 1, 1, 1, 1, 1]
