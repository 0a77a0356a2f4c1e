"""Strings, axes and points that make no text raise one clear error."""

from __future__ import annotations

import numpy as np
import pytest

import vfwidget as vf

NAN, INF = float("nan"), float("inf")


@pytest.mark.parametrize("string", ["", "\u200b", "\u200d\u2060"], ids=ascii)
def test_a_text_of_nothing(font, string):
    with pytest.raises(vf.TextError, match="is empty: it has no visible character"):
        vf.Text(font, string)


@pytest.mark.parametrize("string", [b"ab", None, 3, ["a", "b"]], ids=repr)
def test_a_text_that_is_no_string(font, string):
    with pytest.raises(
        vf.TextError, match=f"A text must be a string; received {type(string).__name__}"
    ):
        vf.Text(font, string)


@pytest.mark.parametrize(
    "axes, shared, message",
    [
        ([{}, {}], True, "must be one mapping or instance, or 1 of them for this text"),
        ([{}], False, "must be one mapping or instance, or 2 of them for this text"),
        ("ab", False, "has no instance 'ab'"),
        ([{}, None], False, "must be a mapping of tag to number; received None"),
        (700, True, "must be one mapping or instance, or 1 of them for this text"),
    ],
)
def test_axes_that_fit_no_text(font, axes, shared, message):
    with pytest.raises(vf.AxisError, match=message):
        vf.Text(font, "ab", axes=axes, shared=shared)


@pytest.mark.parametrize(
    "shared, shape", [(True, (2, 5)), (False, (1, 5)), (False, (5,)), (True, (1, 1, 5))]
)
def test_a_theta_that_fits_no_text(font, shared, shape):
    text = vf.Text(font, "ab", shared=shared)
    for call in text.points, text.jacobian, text.segments, lambda theta: text.at(theta=theta):
        with pytest.raises(vf.AxisError, match=rf"this text needs \({1 if shared else 2}, 5\)"):
            call(np.zeros(shape))


def test_a_text_is_moved_by_axes_or_by_theta(text):
    for both_or_neither in {}, {"axes": {}, "theta": text.theta}:
        with pytest.raises(vf.AxisError, match=r"^Give (either|at least one of) axes="):
            text.at(**both_or_neither)


@pytest.mark.parametrize(
    "where",
    [
        *[{"glyph": 2}, {"glyph": -1}, {"contour": 9}, {"contour": -1}, {"segment": 99}],
        *[{"segment": -1}, {"segment": 0.5}, {"glyph": None}, {"contour": "0"}],
        *[{"t": 1.001}, {"t": -0.001}, {"t": NAN}, {"t": "half"}, {"t": None}],
    ],
    ids=str,
)
def test_a_point_that_is_not_on_the_outline(text, where):
    with pytest.raises(vf.GlyphError, match="'ab' has no outline point at glyph="):
        text.handle(**where)


@pytest.mark.parametrize(
    "x, y", [(NAN, 0), (0, INF), ("a", 0), (None, 0), (0, [1, 2]), (10**400, 0)]
)
def test_nearest_to_what_is_no_point(text, x, y):
    with pytest.raises(vf.GlyphError, match=r"x and y must be finite numbers; received"):
        text.nearest(x, y)
