"""User coordinates to normalized coordinates and back, by hand, fontTools and HarfBuzz."""

from __future__ import annotations

import fonts
import numpy as np
import pytest
import torch
from fontTools.varLib.models import normalizeLocation, piecewiseLinearMap
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from referee import HarfBuzz
from shared_cases import CASES

import vfwidget as vf
from vfwidget.font.source import open_font

FONTS = vf.bundled_fonts()
F2DOT14 = 16384

checked = settings(deadline=None, derandomize=True, max_examples=100)
sixteenths = st.integers(1, 15)


@st.composite
def axes(draw):
    """Axes with a default anywhere and a segment map that rises or is flat."""
    minimum, default, maximum = sorted(
        draw(st.lists(st.integers(-50, 900), min_size=3, max_size=3))
    )
    corners = {-1.0: -1.0, 0.0: 0.0, 1.0: 1.0}
    for sign in -1, 1:
        count = draw(st.integers(0, 3))
        pairs = [sorted(draw(st.lists(sixteenths, min_size=count, max_size=count))) for _ in "xy"]
        corners |= {sign * x / 16: sign * y / 16 for x, y in zip(*pairs, strict=True)}
    segment_map = tuple(sorted(corners.items()))
    assume(all(np.diff([to for _, to in segment_map]) >= 0))
    return vf.Axis("test", "Test", minimum, default, maximum, segment_map=segment_map)


def reachable(axis: vf.Axis, part: float) -> float:
    lower, upper = axis.normalize(axis.minimum), axis.normalize(axis.maximum)
    return lower + part * (upper - lower)


# Between user and normalized coordinates


@pytest.mark.parametrize("case", CASES["normalization"], ids=lambda case: case["name"])
def test_normalize_by_hand(case):
    axis = vf.Axis("test", "Test", **case["axis"], segment_map=tuple(map(tuple, case["map"])))
    assert axis.normalize(case["user"]) == pytest.approx(case["normalized"], abs=1e-12)
    tensor = axis.normalize(torch.tensor(case["user"]))
    assert tensor.dtype == torch.float64
    assert tensor.item() == pytest.approx(case["normalized"], abs=1e-12)


@pytest.mark.parametrize("name", FONTS)
def test_normalize_as_fonttools_does(name):
    font, ttfont = vf.load_font(name), open_font(name)
    rng = np.random.default_rng(4)
    triples = {axis.tag: (axis.minimum, axis.default, axis.maximum) for axis in font.axes}
    for _ in range(50):
        values = {axis.tag: rng.uniform(axis.minimum, axis.maximum) for axis in font.axes}
        plain = normalizeLocation(values, triples)
        maps = ttfont["avar"].segments
        want = [piecewiseLinearMap(plain[tag], maps[tag] or {0: 0}) for tag in triples]
        np.testing.assert_allclose(font.normalize(values), want, rtol=0, atol=1e-12)
        back = font.denormalize(font.normalize(values))
        np.testing.assert_allclose(font.normalize(back), want, rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", FONTS)
def test_named_instances_lie_where_harfbuzz_sees_them(name):
    font, referee = vf.load_font(name), HarfBuzz(open_font(name)).font
    assert font.instances
    for number, instance in enumerate(font.instances):
        referee.var_named_instance = number
        want = referee.get_var_coords_normalized()
        # HarfBuzz rounds before its segment maps and after.
        np.testing.assert_allclose(font.normalize(instance.axes), want, rtol=0, atol=4 / F2DOT14)
        assert set(instance.axes) == {axis.tag for axis in font.axes}
        assert instance.name


@checked
@given(axes(), st.floats(0, 1))
def test_denormalize_undoes_normalize_however_flat_the_map(axis, part):
    w = reachable(axis, part)
    assert axis.normalize(axis.denormalize(w)) == pytest.approx(w, abs=1e-9)


@checked
@given(axes(), st.integers(-16, 16))
def test_denormalize_gives_the_nearest_to_the_default(axis, sixteenth):
    w = sixteenth / 16
    assume(axis.normalize(axis.minimum) <= w <= axis.normalize(axis.maximum))
    user = axis.denormalize(w)
    assert axis.minimum <= user <= axis.maximum
    if abs(user - axis.default) > 1e-6:
        nearer = user + 1e-6 * np.sign(axis.default - user)
        assert abs(axis.normalize(nearer)) < abs(w)


@pytest.mark.parametrize("w, user", [(0.25, 12.5), (0.5, 25), (0.625, 81.25), (1, 100), (7, 100)])
def test_denormalize_over_a_flat_stretch_by_hand(w, user):
    flat = ((-1, -1), (0, 0), (0.25, 0.5), (0.75, 0.5), (1, 1))
    assert vf.Axis("test", "Test", 0, 0, 100, segment_map=flat).denormalize(w) == user


def test_denormalize_at_a_default_that_is_flat_gives_the_default():
    flat = ((-1, -1), (-0.5, 0), (0, 0), (0.5, 0), (1, 1))
    axis = vf.Axis("test", "Test", 100, 400, 900, segment_map=flat)
    assert [axis.denormalize(w) for w in (0, 0.5, -0.5)] == [400, 775, 175]


@pytest.mark.parametrize("name", FONTS)
def test_bounds_are_what_the_axes_reach(name):
    font = vf.load_font(name)
    lower, upper = font.bounds
    for axis, low, high in zip(font.axes, lower, upper, strict=True):
        # A default at an end leaves one side of the axis empty.
        assert low == (-1 if axis.minimum < axis.default else 0)
        assert high == (1 if axis.maximum > axis.default else 0)


# Derivatives


@checked
@given(axes(), st.floats(0.001, 0.999))
def test_gradient_of_normalize_is_its_slope(axis, part):
    assume(axis.minimum < axis.maximum)
    user = axis.minimum + part * (axis.maximum - axis.minimum)
    value = torch.tensor(user, requires_grad=True, dtype=torch.float64)
    axis.normalize(value).backward()
    step = 1e-7
    # On a corner this is the slope to the right, as everywhere.
    want = (axis.normalize(user + step) - axis.normalize(user)) / step
    before = (axis.normalize(user) - axis.normalize(user - step)) / step
    assume(abs(want - before) < 1e-6 or user == axis.default)
    assert value.grad.item() == pytest.approx(want, abs=1e-6)


@pytest.mark.parametrize(
    "user, slope",
    [(50, 0), (100, 1 / 300), (250, 1 / 300), (400, 1 / 500), (900, 1 / 500), (901, 0)],
)
def test_gradient_of_normalize_at_corners_and_outside(user, slope):
    value = torch.tensor(float(user), requires_grad=True)
    vf.Axis("wght", "Weight", 100, 400, 900).normalize(value).backward()
    assert value.grad.item() == pytest.approx(slope)


def test_gradient_reaches_the_outline_through_user_coordinates():
    font = vf.load_font("recursive")
    value = torch.tensor(650.0, requires_grad=True, dtype=torch.float64)

    def corner(user):
        return font.glyph("o").points(font.normalize({"wght": user, "slnt": -7.0}))[0, 0]

    assert torch.autograd.gradcheck(corner, value)


# What a font says of its axes


def test_axes_as_the_font_has_them():
    font = vf.load_font("recursive")
    weight = font.axes[2]
    assert (weight.tag, weight.name, weight.hidden) == ("wght", "Weight", False)
    assert (weight.minimum, weight.default, weight.maximum) == (300, 300, 1000)
    np.testing.assert_array_equal(font.normalize({}), np.zeros(5))
    assert font.denormalize(np.zeros(5)) == {axis.tag: axis.default for axis in font.axes}


def test_hidden_axes_are_marked_and_work():
    font = vf.load_font("roboto-flex")
    hidden = [axis.tag for axis in font.axes if axis.hidden]
    assert hidden == ["XOPQ", "YOPQ", "XTRA", "YTUC", "YTLC", "YTAS", "YTDE", "YTFI"]
    text = vf.Text(font, "a")
    assert not torch.equal(text.points(), text.at(axes={"XOPQ": 27}).points())


def test_an_instance_can_be_set():
    font = vf.load_font("dynapuff")
    bold = next(instance for instance in font.instances if instance.name == "Bold")
    assert vf.Text(font, "a", axes=bold.axes).axes == bold.axes == {"wght": 700, "wdth": 100}


def test_one_tag_on_two_axes_moves_both_each_by_its_own_map():
    font = vf.load_font(fonts.one_tag_on_two_axes())
    assert [axis.tag for axis in font.axes] == ["wght", "wght"]
    np.testing.assert_allclose(font.normalize({"wght": 650}), [0.25, 0.5], atol=1e-4)
    assert font.denormalize([1, 1]) == {"wght": 900}
    # The product of the two axes is what lifts the point, the first alone what pushes it.
    corner = font.glyph("a").points([0.5, 0.25])[0]
    np.testing.assert_allclose(corner, [100 + 50 * 0.5, 100 * 0.5 * 0.25])


def test_a_value_outside_its_axis_warns_and_is_clamped():
    font = vf.load_font("roboto-flex")
    with pytest.warns(vf.AxisWarning, match="wght=5000 lies outside 100 … 1000 and was clamped"):
        assert font.normalize({"wght": 5000})[1] == 1
    with pytest.warns(vf.AxisWarning, match="outside -1 … 1 were clamped"):
        assert font.denormalize([0, -3] + [0] * 11)["wght"] == 100


# Segment maps that are invalid


INVALID_MAPS = {
    "no ends": [(0, 0), (0.5, 0.25)],
    "one pair": [(0.25, 0.5)],
    "no middle": [(-1, -1), (1, 0.5)],
    "the middle elsewhere": [(-1, -1), (0, 0.25), (1, 1)],
    "an end twice": [(-1, -1), (-1, -0.75), (0, 0), (0.5, 0.75), (1, 0.75), (1, 1)],
    "falling": [(-1, -1), (0, 0), (0.25, 0.75), (0.75, 0.25), (1, 1)],
}


@pytest.mark.parametrize("pairs", INVALID_MAPS.values(), ids=INVALID_MAPS)
def test_an_invalid_segment_map_is_read_as_harfbuzz_reads_it(pairs):
    data = fonts.with_segment_map(pairs)
    with pytest.warns(vf.FontWarning, match="avar map of axis 'wght' is invalid"):
        font = vf.load_font(data)
    referee = HarfBuzz(fonts.open_font(data)).font
    for value in np.linspace(100, 900, 33):
        referee.set_variations({"wght": value})
        want = np.clip(referee.get_var_coords_normalized(), -1, 1)
        # HarfBuzz rounds before its segment maps and after.
        np.testing.assert_allclose(font.normalize({"wght": value}), want, atol=4 / F2DOT14)
    lower, upper = font.bounds
    for part in np.linspace(0, 1, 9):
        w = lower + part * (upper - lower)
        np.testing.assert_allclose(font.normalize(font.denormalize(w)), w, atol=1e-9)


def test_a_valid_segment_map_gives_no_warning():
    vf.load_font(fonts.with_segment_map([(-1, -1), (0, 0), (0.5, 0.5), (0.75, 0.5), (1, 1)]))
    vf.load_font(fonts.with_segment_map([]))
