"""Glyphs, axes and coordinates that a font does not have raise one clear error."""

from __future__ import annotations

import numpy as np
import pytest
import torch

import vfwidget as vf

NAN, INF = float("nan"), float("inf")


@pytest.mark.parametrize(
    "key", ["あ", "no-such-glyph", "", -1, 10**6, True, 1.0, None, ["a"], b"a"], ids=repr
)
def test_a_missing_glyph(font, key):
    with pytest.raises(
        vf.GlyphError, match=r"no glyph .*give a character, a glyph name or a glyph id"
    ):
        font.glyph(key)


def test_an_unknown_axis(font):
    message = "Unknown axis 'WGHT'. This font has: MONO, CASL, wght, slnt, CRSV"
    for call in font.normalize, lambda axes: vf.Text(font, "a", axes=axes):
        with pytest.raises(vf.AxisError, match=message):
            call({"WGHT": 400})


@pytest.mark.parametrize(
    "value", [NAN, INF, -INF, None, "bold", 10**400, [1, 2], torch.ones(2)], ids=str
)
def test_an_axis_value_that_is_no_finite_number(font, value):
    with pytest.raises(vf.AxisError, match="Axis 'wght' needs a finite number; received"):
        font.normalize({"wght": value})


@pytest.mark.parametrize("axes", [[650], "wght", 650, None, [("wght", 650)]], ids=repr)
def test_axes_that_are_no_mapping(font, axes):
    with pytest.raises(
        vf.AxisError, match="Axis values must be a mapping of tag to number; received"
    ):
        font.normalize(axes)


COORDINATES = {
    "not a number": ([0, NAN, 0, 0, 0], "must be finite"),
    "infinite": (torch.tensor([0, INF, 0, 0, 0]), "must be finite"),
    "too few": ([0] * 4, r"This font has 5 axes; received coordinates of shape \(4,\)"),
    "one number": (0.5, r"received coordinates of shape \(\)"),
    "transposed": (np.zeros((5, 2)), r"received coordinates of shape \(5, 2\)"),
    "text": ("bold", "must be 5 numbers; received 'bold'"),
    "a mapping": ({"wght": 1}, "must be 5 numbers; received"),
    "ragged": ([[0] * 5, [0]], "must be 5 numbers; received"),
}


@pytest.mark.parametrize("w, message", COORDINATES.values(), ids=COORDINATES)
def test_coordinates_that_are_none(font, text, w, message):
    glyph = font.glyph("a")
    calls = [glyph.scalars, glyph.points, glyph.jacobian, glyph.segments, glyph.advance]
    calls += [glyph.side_bearings, font.denormalize, text.points, text.jacobian]
    for call in [*calls, lambda w: text.at(theta=w)]:
        with pytest.raises(vf.AxisError, match=message):
            call(w)


def test_coordinates_outside_are_clamped_with_a_warning(font, text):
    w = font.bounds[1]
    for method in font.glyph("a").points, font.glyph("a").jacobian, text.points:
        with pytest.warns(vf.AxisWarning, match="outside -1 … 1 were clamped"):
            clamped = method(w * 3)
        assert torch.equal(clamped, method(w))
    with pytest.warns(vf.AxisWarning, match="wght=9999 lies outside 300 … 1000"):
        assert vf.Text(font, "a", axes={"wght": 9999}).axes["wght"] == 1000


def test_warnings_point_at_the_line_that_called(font, text):
    calls = [lambda: font.normalize({"wght": 0}), lambda: vf.Text(font, "a", axes={"wght": 0})]
    calls += [lambda: font.glyph("a").segments([2] * 5), lambda: text.at(theta=[2] * 5)]
    for call in calls:
        with pytest.warns(vf.AxisWarning) as caught:
            call()
        assert caught[0].filename == __file__


def test_only_one_set_of_coordinates_is_denormalized_at_a_time(font):
    with pytest.raises(vf.AxisError, match=r"One set of coordinates at a time, not \(2, 5\)"):
        font.denormalize(np.zeros((2, 5)))
