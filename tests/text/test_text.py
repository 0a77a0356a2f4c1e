"""Words: Eq. 3 by hand, derivatives, handles, and what shaping makes of a string."""

from __future__ import annotations

import fonts
import numpy as np
import pytest
import torch
import varc_fonts

import vfwidget as vf
from vfwidget.outline.cubics import bernstein, x_extent

FONTS = vf.bundled_fonts()
WORD = "fjörd 8"


def tiny() -> vf.Font:
    """Advances: a 600 + 80 at wght 1; b 600 + 50 at wght 0.5, its origin 15 further left."""
    return vf.load_font(fonts.build(*fonts.base_glyphs()))


def random_theta(text: vf.Text, seed: int = 3) -> torch.Tensor:
    lower, upper = text.font.bounds
    return torch.tensor(np.random.default_rng(seed).uniform(lower, upper, tuple(text.theta.shape)))


def outline_samples(text: vf.Text, count: int = 501) -> np.ndarray:
    weights = bernstein(np.linspace(0, 1, count)).T
    return np.concatenate([(weights @ s.numpy()).reshape(-1, 2) for s in text.segments()])


# Eq. 3


@pytest.mark.parametrize(
    "shared, theta, origins",
    [
        (True, [[0, 0]], [0, 600, 1200]),
        (True, [[0.5, 0]], [0, 640, 1290]),
        (True, [[1, 0]], [0, 680, 1280]),
        (False, [[1, 0], [0.25, 0], [0, 0]], [0, 680, 1305]),
        (False, [[0, 1], [0.5, -1], [1, 0]], [0, 600, 1250]),
    ],
)
def test_letters_follow_one_another_by_their_advances(shared, theta, origins):
    text = vf.Text(tiny(), "aba", shared=shared).at(theta=theta)
    rows = theta * 3 if shared else theta
    want = [
        glyph.points(row) + torch.tensor([origin, 0.0])
        for glyph, row, origin in zip(text.glyphs, rows, origins, strict=True)
    ]
    torch.testing.assert_close(text.points(), torch.cat(want))
    last = text.glyphs[-1].advance(rows[-1]).item()
    assert text.advance() == pytest.approx(origins[-1] + last)


@pytest.mark.parametrize("name", FONTS)
def test_a_word_is_its_glyphs_side_by_side(name):
    text = vf.Text(name, WORD, shared=False, features={"kern": False})
    theta = random_theta(text)
    pen, want = 0.0, []
    for glyph, w in zip(text.glyphs, theta, strict=True):
        left, right = glyph.side_bearings(w)
        contours = glyph.segments(w)
        want.append(glyph.points(w) + torch.tensor([pen, 0.0]))
        if contours:
            # Eq. 3 as printed: side bearings and the outline's width between.
            edges = x_extent(contours)
            assert left + (edges[1] - edges[0]) + right == pytest.approx(glyph.advance(w).item())
        pen += glyph.advance(w).item()
    torch.testing.assert_close(text.points(theta), torch.cat(want))
    assert text.at(theta=theta).advance() == pytest.approx(pen)


@pytest.mark.parametrize("name", FONTS)
def test_sharing_is_every_letter_at_one_place(name):
    together, apart = vf.Text(name, WORD), vf.Text(name, WORD, shared=False)
    theta = random_theta(together)
    rows = theta.expand(len(apart.glyphs), -1)
    torch.testing.assert_close(together.points(theta), apart.points(rows))
    torch.testing.assert_close(together.jacobian(theta), apart.jacobian(rows).sum(2, keepdim=True))
    for one, other in zip(together.segments(theta), apart.segments(rows), strict=True):
        torch.testing.assert_close(one, other)


@pytest.mark.parametrize("shared", [True, False])
@pytest.mark.parametrize("name", FONTS)
def test_jacobian_is_what_autograd_finds(name, shared):
    text = vf.Text(name, "gä", shared=shared)
    lower, upper = (torch.tensor(bound).expand(text.theta.shape) for bound in text.font.bounds)
    for theta in random_theta(text), text.theta, lower, upper:
        jacobian = text.jacobian(theta)
        assert jacobian.shape == (*text.points().shape, *theta.shape)
        autograd = torch.autograd.functional.jacobian(text.points, theta, vectorize=True)
        torch.testing.assert_close(jacobian, autograd, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("name", FONTS)
def test_at_the_upper_end_of_an_axis_the_derivative_is_that_into_its_range(name):
    """The default of many axes, such as slant, is their maximum."""
    text, step = vf.Text(name, "gä"), 1e-6
    upper = text.font.bounds[1]
    for theta in text.theta.numpy(), upper[None], np.where(upper > 0, 0.5, 0.0)[None]:
        here, jacobian = text.points(theta), text.jacobian(theta)
        for axis in range(len(upper)):
            side = -step if theta[0, axis] >= upper[axis] else step
            there = theta + side * np.eye(len(upper))[axis]
            slope = (text.points(there) - here) / side
            torch.testing.assert_close(jacobian[:, :, 0, axis], slope, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("shared", [True, False])
def test_beyond_the_upper_end_of_an_axis_the_derivative_is_that_to_the_left(shared):
    """Normalized coordinates may be up to 1 although the default is the maximum."""
    font = fonts.build(*fonts.base_glyphs(), axes=[("wght", 100, 400, 400, "Weight"), fonts.WIDTH])
    text, step = vf.Text(font, "ab", shared=shared), 1e-6
    for wght in 0.25, 0.5, 0.75, 1:
        theta = np.zeros(text.theta.shape)
        theta[-1, 0] = wght
        there = theta.copy()
        there[-1, 0] -= step
        slope = (text.points(theta) - text.points(there)) / step
        found = text.jacobian(theta)[:, :, -1, 0]
        torch.testing.assert_close(found, slope, rtol=1e-6, atol=1e-6)


def test_an_advance_of_zero_may_grow_and_one_held_at_zero_may_not():
    deltas = [*[(0, 0)] * 5, (250, 0), (0, 0), (0, 0)]
    glyphs = {name: fonts.outline(fonts.SQUARE) for name in "ab"}
    growing = fonts.build(glyphs, {"a": [(fonts.BOLD, deltas)]}, metrics={"a": (0, 100)})
    assert vf.Text(growing, "ab").jacobian()[-1, 0, 0].tolist() == [250, 0]
    # The advance of c is 300 - 5000 at wdth 1, held at zero from 0.06 on.
    squeezed = vf.Text(fonts.phantom_points(), "ca")
    after = squeezed.jacobian([0, 0.5])[squeezed.word.first_point[1], 0, 0]
    assert after.tolist() == squeezed.glyphs[1].jacobian([0, 0.5])[0, 0].tolist()


@pytest.mark.parametrize("shared", [True, False])
def test_arrays_stay_arrays(shared):
    text = vf.Text("recursive", WORD, shared=shared)
    theta, points = random_theta(text), text.point_set()
    positions, jacobian = text.positions_and_jacobian(points, theta.numpy())
    for array in positions, jacobian, text.positions(points, theta.numpy()):
        assert type(array) is np.ndarray
    for got, want in (positions, text.points(theta)), (jacobian, text.jacobian(theta)):
        np.testing.assert_allclose(got, want, rtol=1e-12, atol=1e-9)


# Axes


def test_axes_and_theta_are_two_ways_to_say_one_place():
    text = vf.Text("recursive", "ab", axes={"wght": 700, "CASL": 0.5})
    assert text.theta.shape == (1, 5) and text.theta.dtype == torch.float64
    assert text.axes == pytest.approx({"MONO": 0, "CASL": 0.5, "wght": 700, "slnt": 0, "CRSV": 0.5})
    torch.testing.assert_close(text.at(theta=text.theta[0]).points(), text.points())
    torch.testing.assert_close(text.at(axes=text.axes).theta, text.theta)

    apart = vf.Text("recursive", "ab", axes=[{"wght": 700}, {}], shared=False)
    assert apart.theta.shape == (2, 5)
    assert [place["wght"] for place in apart.axes] == pytest.approx([700, 300])
    # One mapping goes to every letter.
    assert [place["wght"] for place in apart.at(axes={"wght": 400}).axes] == pytest.approx(
        [400] * 2
    )


def test_a_text_is_immutable():
    text = vf.Text("recursive", "ab", axes={"wght": 700})
    theta, points = text.theta, text.points()
    text.theta.zero_()
    text.points().zero_()
    text.axes.clear()
    place = np.zeros((1, 5))
    for given in place, torch.tensor(place):
        moved = text.at(theta=given)
        given += 0.5
        assert moved.theta.abs().max() == 0
    assert torch.equal(text.theta, theta) and torch.equal(text.points(), points)


# Handles


@pytest.mark.parametrize("shared", [True, False])
def test_a_handle_is_a_point_of_its_segment_wherever_the_text_moves(shared):
    text = vf.Text("dynapuff", "éa", shared=shared)
    handle = text.handle(glyph=1, contour=1, segment=2, t=0.25)
    assert (handle.glyph, handle.contour, handle.segment, handle.t) == (1, 1, 2, 0.25)
    before = len(text.glyphs[0].contours)
    for moved in text, text.at(theta=random_theta(text)):
        segment = moved.segments()[before + 1][2].numpy()
        np.testing.assert_allclose(moved.position(handle), bernstein(0.25) @ segment)
        assert moved.owns(handle)


def test_the_end_of_a_segment_is_the_start_of_the_next():
    text = vf.Text("recursive", "o")
    last = text.glyphs[0].contours[0] - 1
    end, start = text.handle(segment=last, t=1), text.handle()
    torch.testing.assert_close(text.position(end), text.position(start))


@pytest.mark.parametrize("name", FONTS)
def test_nearest_is_the_nearest_of_the_whole_word(name):
    text = vf.Text(name, "Rä g")
    text = text.at(theta=random_theta(text))
    samples = outline_samples(text)
    low, high = samples.min(0) - 100, samples.max(0) + 100
    for target in np.random.default_rng(1).uniform(low, high, (20, 2)):
        handle = text.nearest(*target)
        assert handle == text.handle(handle.glyph, handle.contour, handle.segment, handle.t)
        found = np.linalg.norm(text.position(handle).numpy() - target)
        assert found <= np.linalg.norm(samples - target, axis=1).min() + 1e-9


def test_nearest_to_a_point_of_the_outline_is_that_point():
    text = vf.Text("shantell-sans", "ok")
    handle = text.handle(1, 0, 3, 0.4)
    found = text.nearest(*text.position(handle))
    torch.testing.assert_close(text.position(found), text.position(handle), rtol=0, atol=1e-3)


def test_handles_of_another_text_are_refused():
    text, twin = vf.Text("recursive", "ab"), vf.Text("recursive", "ab")
    handle = twin.handle()
    assert not text.owns(handle) and handle != text.handle()
    with pytest.raises(vf.GlyphError, match="not a handle of this text, 'ab'"):
        text.position(handle)


# Shaping


def test_a_ligature_is_one_letter():
    font = vf.load_font("roboto-flex")
    text = vf.Text(font, "afi", shared=False)
    assert [glyph.name for glyph in text.glyphs] == ["uni0061", "uniFB01"]
    assert [placed.cluster for placed in vf.Text(font, "afi").layout] == [0, 1]
    assert text.theta.shape == (2, 13) and len(text.axes) == 2
    # A joiner that forbids it is no letter itself.
    parted = vf.Text(font, "af\u200ci")
    assert [glyph.name for glyph in parted.glyphs] == ["uni0061", "uni0066", "uni0069"]


def test_shaping_outlives_what_it_read():
    # HarfBuzz holds tables by address: were they freed, later words would come out wrong.
    font = vf.load_font("roboto-flex")
    for string in "\u200ba", "x", "afi":
        vf.Text(font, string)
        rubbish = [bytes([255]) * size for size in range(256, 512) for _ in range(4)]
    assert [glyph.name for glyph in vf.Text(font, "afi").glyphs] == ["uni0061", "uniFB01"]
    assert rubbish


@pytest.mark.parametrize("name", FONTS)
def test_letters_are_not_kerned_where_kerning_is_off(name):
    text = vf.Text(name, "AVAToy", features={"kern": False})
    place = np.zeros(len(text.font.axes))
    assert text.advance() == sum(glyph.advance(place).item() for glyph in text.glyphs)


@pytest.mark.parametrize(
    "string, missing",
    [
        ("aあb", "'あ' (U+3042)"),
        ("xあyいあ", "'あ' (U+3042), 'い' (U+3044)"),
        ("x\U0001f642", "(U+1F642)"),
        # The mark is missing, not the letter it stands on.
        ("x\u20dd", "(U+20DD)"),
        ("a\tb", "(U+0009)"),
    ],
)
def test_missing_characters_are_named(string, missing):
    with pytest.raises(vf.GlyphError) as caught:
        vf.Text("recursive", string)
    assert str(caught.value).endswith(missing)
    assert "'x'" not in str(caught.value) and "'a'" not in str(caught.value)


def test_spaces_only_have_an_advance_and_nothing_to_hold():
    text = vf.Text("recursive", "  ")
    assert text.advance() == 600
    assert text.points().shape == (0, 2) and text.jacobian().shape == (0, 2, 1, 5)
    assert vf.Text("recursive", "  ", shared=False).jacobian().shape == (0, 2, 2, 5)
    assert text.segments() == []
    with pytest.raises(vf.GlyphError, match="'  ' has no outline, so it has no nearest point"):
        text.nearest(0, 0)
    with pytest.raises(vf.GlyphError, match="has no outline point at"):
        text.handle()


@pytest.mark.parametrize("shared", [True, False])
@pytest.mark.parametrize("kind", ["upright", "rotated", "with variable components"])
def test_some_points_are_those_of_all(kind, shared):
    font = vf.load_font(varc_fonts.varc()) if kind.startswith("with") else "recursive"
    text = vf.Text(font, "cc", shared=shared)
    if kind == "rotated":
        text = text.at(rotations=[0.3, -0.2])
    points, which = text.point_set(), np.array([3, 0, 7])
    place = {**text.place, "axes": random_theta(text).numpy()}
    for found, every in zip(
        points.some(which).positions_and_jacobian(place),
        points.positions_and_jacobian(place),
        strict=True,
    ):
        np.testing.assert_allclose(found, every[which], rtol=1e-12, atol=1e-12)


def test_letters_from_right_to_left_stand_in_the_order_seen():
    def hebrew(font):
        font.setupCharacterMap({0x5D0: "a", 0x5D1: "b"})

    font = vf.load_font(fonts.build(*fonts.base_glyphs(), edit=hebrew))
    text = vf.Text(font, "אאב")
    assert [glyph.name for glyph in text.glyphs] == ["b", "a", "a"]
    assert [placed.cluster for placed in text.layout] == [2, 1, 0]
    assert text.advance() == 1800


def test_the_box_of_a_text_does_not_depend_on_the_texts_before():
    """A location beyond the range of an axis has a box of its own, which reaches to it."""
    text = vf.Text("recursive", "hk", {"wght": 500})
    expected = text.composition.bounds_at(text.coordinates)
    beyond = text.theta.numpy() + np.array([0, 0, -0.5, 0.5, 0])
    outside = text.at(theta=beyond)
    lower, upper = outside.composition.bounds_at(outside.coordinates)
    assert lower[0, 2] == beyond[0, 2] and upper[0, 3] == beyond[0, 3]
    again = text.at({"wght": 500})
    assert np.array_equal(again.composition.bounds_at(again.coordinates), expected)
