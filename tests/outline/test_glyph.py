"""Glyphs as tensors: shapes, Eq. 1 by hand, derivatives, side bearings."""

from __future__ import annotations

import fonts
import numpy as np
import pytest
import torch
from shared_cases import CASES

import vfwidget as vf

FONTS = vf.bundled_fonts()
STEP = 1e-6


def some_glyphs(font: vf.Font, count: int) -> list[vf.Glyph]:
    """Glyphs with an outline, the same ones at every run."""
    rng = np.random.default_rng(11)
    names = [str(name) for name in rng.permutation(font.glyph_names)]
    glyphs = (font.glyph(name) for name in names)
    return [
        glyph for glyph, _ in zip((g for g in glyphs if g.contours), range(count), strict=False)
    ]


def random_places(font: vf.Font, count: int) -> torch.Tensor:
    lower, upper = font.bounds
    return torch.tensor(np.random.default_rng(5).uniform(lower, upper, (count, len(font.axes))))


def dense(segments: torch.Tensor, count: int = 1001) -> torch.Tensor:
    """Points along cubics (s, 4, 2), (s, count, 2)."""
    t = torch.linspace(0, 1, count, dtype=torch.float64)[:, None]
    u = 1 - t
    weights = torch.cat([u**3, 3 * u * u * t, 3 * u * t * t, t**3], 1)
    return weights @ segments


# Shapes and values


@pytest.mark.parametrize("name", FONTS)
def test_shapes_and_types(name):
    font = vf.load_font(name)
    n = len(font.axes)
    for glyph in [font.glyph(" "), *some_glyphs(font, 5)]:
        k, m = 3 * sum(glyph.contours), len(glyph.support)
        w = random_places(font, 6).reshape(2, 3, n)
        left, right = glyph.side_bearings(w)
        tensors = {
            glyph.default: (k, 2),
            glyph.deltas: (k, 2, m),
            glyph.support: (m, n, 3),
            glyph.scalars(w): (2, 3, m),
            glyph.points(w): (2, 3, k, 2),
            glyph.jacobian(w): (2, 3, k, 2, n),
            glyph.advance(w): (2, 3),
            left: (2, 3),
            right: (2, 3),
        }
        tensors |= dict(
            zip(glyph.segments(w), [(2, 3, s, 4, 2) for s in glyph.contours], strict=True)
        )
        for tensor, shape in tensors.items():
            assert tensor.shape == shape
            assert tensor.dtype == torch.float64


@pytest.mark.parametrize("case", CASES["points"], ids=lambda case: case["name"])
def test_points_by_hand(case):
    tags = ["AAAA", "BBBB"][: len(case["w"])]
    deltas = [
        (dict(zip(tags, map(tuple, region), strict=True)), [*map(tuple, moved), *fonts.STILL])
        for region, moved in zip(case["support"], case["deltas"], strict=True)
    ]
    font = vf.load_font(
        fonts.build(
            {"a": fonts.outline([tuple(point) for point in case["default"]])},
            {"a": deltas},
            axes=[(tag, -1, 0, 1, tag) for tag in tags],
            metrics={"a": (fonts.ADVANCE, min(x for x, _ in case["default"]))},
        )
    )
    corners = font.glyph("a").points(case["w"])[::3]
    np.testing.assert_allclose(corners, case["points"])


@pytest.mark.parametrize("name", FONTS)
def test_a_batch_is_its_rows(name):
    font = vf.load_font(name)
    w = random_places(font, 3)
    for glyph in some_glyphs(font, 5):
        for method in glyph.scalars, glyph.points, glyph.jacobian, glyph.advance:
            rows = torch.stack([method(row) for row in w])
            torch.testing.assert_close(method(w), rows, rtol=0, atol=1e-9)
        for index in range(2):
            rows = torch.stack([glyph.side_bearings(row)[index] for row in w])
            torch.testing.assert_close(glyph.side_bearings(w)[index], rows, rtol=0, atol=1e-9)


def test_segments_are_closed_and_share_their_ends():
    for name in FONTS:
        font = vf.load_font(name)
        for glyph in some_glyphs(font, 10):
            for contour in glyph.segments(random_places(font, 1)[0]):
                assert torch.equal(contour[:, 3], contour[:, 0].roll(-1, 0))


@pytest.mark.parametrize("kind", [np.array, torch.tensor, list, tuple])
@pytest.mark.parametrize("place", [[1, 0, 0.5, -1, -0.25], [0, 1, 0, 0, 1]])
def test_any_kind_of_numbers_will_do(kind, place):
    glyph = vf.load_font("recursive").glyph("a")
    want = glyph.points(torch.tensor(place, dtype=torch.float64))
    assert torch.equal(glyph.points(kind(place)), want)


def test_float32_loses_no_breakpoint():
    # In float32 a peak and a hair beside it are one number.
    font = vf.load_font("roboto-flex")
    for name in "aRg":
        glyph = font.glyph(name)
        for peak in glyph.support[..., 1]:
            torch.testing.assert_close(glyph.scalars(peak.float()), glyph.scalars(peak))


def test_lookups_of_one_glyph_agree():
    font = vf.load_font("recursive")
    glyph = font.glyph("é")
    assert glyph.name == "eacute"
    assert font.glyph("eacute") is glyph
    assert font.glyph(glyph.glyph_id) is glyph
    assert font.glyph(np.int64(glyph.glyph_id)) is glyph
    assert font.glyph_names[glyph.glyph_id] == "eacute"


def test_a_contour_may_have_very_many_points():
    # A font of a few kilobytes may hold it, so memory must not grow with its square.
    k = 20_000
    around = np.exp(2j * np.pi * np.arange(k) / k) * 10_000
    ring = [(round(z.real), round(z.imag)) for z in around]
    font = vf.load_font(fonts.build({"o": fonts.outline(ring)}, {}))
    assert font.glyph("o").contours == (k,)
    np.testing.assert_array_equal(
        font.glyph("o").default[::3] - font.glyph("o").default[0], np.array(ring) - ring[0]
    )


# Derivatives


@pytest.mark.parametrize("name", FONTS)
def test_jacobian_is_the_slope_of_the_points(name):
    font = vf.load_font(name)
    n = len(font.axes)
    step = STEP * torch.eye(n, dtype=torch.float64)
    for glyph, w in zip(some_glyphs(font, 20), random_places(font, 20), strict=True):
        want = (glyph.points(w + step) - glyph.points(w - step)) / (2 * STEP)
        torch.testing.assert_close(glyph.jacobian(w), want.movedim(0, -1), rtol=1e-5, atol=1e-4)


def kinks(font: vf.Font) -> torch.Tensor:
    """The default, the corners and places half way between, where every axis has a kink."""
    lower, upper = map(torch.tensor, font.bounds)
    return torch.stack([torch.zeros_like(lower), lower, upper, lower / 2, upper / 2])


@pytest.mark.parametrize("name", FONTS)
def test_jacobian_on_a_kink_is_the_slope_to_the_right_or_at_the_end_to_the_left(name):
    font = vf.load_font(name)
    n = len(font.axes)
    for glyph in some_glyphs(font, 5):
        for w in kinks(font):
            step = STEP * torch.where(w < 1, 1.0, -1.0)
            want = (glyph.points(w + torch.diag(step)) - glyph.points(w)) / step.reshape(n, 1, 1)
            torch.testing.assert_close(glyph.jacobian(w), want.movedim(0, -1), rtol=1e-5, atol=1e-4)


@pytest.mark.parametrize("name", FONTS)
def test_jacobian_is_what_autograd_finds(name):
    font = vf.load_font(name)
    places = torch.cat([kinks(font), random_places(font, 2)])
    for glyph in some_glyphs(font, 5):
        for w in places:
            autograd = torch.autograd.functional.jacobian(glyph.points, w, vectorize=True)
            torch.testing.assert_close(glyph.jacobian(w), autograd, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("name", ["recursive", "roboto-flex"])
def test_torch_func_transforms(name):
    font = vf.load_font(name)
    glyph, places = font.glyph("g"), random_places(font, 3)
    want = glyph.jacobian(places)
    for transform in torch.func.jacfwd, torch.func.jacrev:
        torch.testing.assert_close(transform(glyph.points)(places[0]), want[0])
        torch.testing.assert_close(torch.func.vmap(transform(glyph.points))(places), want)
    # Under vmap values cannot be looked at, and are clamped all the same.
    outside = torch.func.vmap(glyph.points)(2 * torch.sign(places))
    torch.testing.assert_close(outside, glyph.points(torch.sign(places)))


@pytest.mark.parametrize("name", FONTS)
def test_advances_and_side_bearings_are_differentiable(name):
    font = vf.load_font(name)
    for glyph, w in zip(some_glyphs(font, 5), random_places(font, 5), strict=True):
        assert torch.autograd.gradcheck(glyph.advance, w.requires_grad_())
        assert torch.autograd.gradcheck(glyph.side_bearings, w)


# Side bearings


@pytest.mark.parametrize("name", FONTS)
def test_side_bearings_reach_from_the_outline_to_the_origin_and_the_advance(name):
    font = vf.load_font(name)
    for glyph, w in zip(some_glyphs(font, 10), random_places(font, 10), strict=True):
        x = torch.cat([dense(contour)[..., 0].ravel() for contour in glyph.segments(w)])
        left, right = glyph.side_bearings(w)
        # No point sampled lies beyond the edges, and the outermost lie close to them.
        edges = left, glyph.advance(w) - right
        assert edges[0] - 1e-9 <= x.min() <= edges[0] + 5e-3
        assert edges[1] - 5e-3 <= x.max() <= edges[1] + 1e-9


def test_a_glyph_without_an_outline_has_an_advance_and_no_side_bearings():
    font = vf.load_font("recursive")
    space = font.glyph(" ")
    narrow, wide = font.normalize({}), font.normalize({"MONO": 1})
    assert space.segments(narrow) == []
    assert 0 < space.advance(narrow) < space.advance(wide)
    assert [bearing.item() for bearing in space.side_bearings(wide)] == [0, 0]
    assert space.jacobian(wide).shape == (0, 2, 5)


def test_an_advance_is_never_negative():
    font = vf.load_font(fonts.phantom_points())
    glyph = font.glyph("c")
    assert [glyph.advance(w).item() for w in ([0, 0], [0, 1])] == [300, 0]
