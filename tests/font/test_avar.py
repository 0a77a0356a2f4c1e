"""Axes that move other axes (avar 2), against HarfBuzz and by differences."""

from __future__ import annotations

import warnings

import fonts
import formats
import numpy as np
import pytest
import torch
import variation_tables
from referee import OUTLINE_TOLERANCE, HarfBuzz, outline_error
from test_formats import AVAR_2

import vfwidget as vf

F2DOT14 = 16384
REAL = [formats.CONFORMANCE / "formats" / name for name in AVAR_2]
STEP = 1e-6


def sources() -> list:
    real = [pytest.param(path.read_bytes, id=path.name) for path in REAL if path.is_file()]
    return [*real, pytest.param(variation_tables.avar_2, id="made up")]


def random_values(font: vf.Font, count: int) -> list[dict[str, float]]:
    rng = np.random.default_rng(7)
    return [
        {axis.tag: float(rng.uniform(axis.minimum, axis.maximum)) for axis in font.axes}
        for _ in range(count)
    ]


@pytest.mark.parametrize("source", sources())
def test_final_coordinates_and_outlines_are_those_of_harfbuzz(source):
    font, referee = vf.load_font(source()), HarfBuzz(fonts.open_font(source()))
    assert not font.glyph(1).is_affine
    for values in random_values(font, 8):
        referee.font.set_variations(values)
        want = np.array(referee.font.get_var_coords_normalized())
        got = font.final_coordinates(font.normalize(values))
        # HarfBuzz rounds before and after its maps, and each displacement.
        np.testing.assert_allclose(got, want, rtol=0, atol=4 / F2DOT14)
        for glyph in font:
            # Held at the coordinates of HarfBuzz, so that its rounding does not count.
            points = glyph.outline.outer.value(want)
            drawn = referee.contours(glyph.glyph_id)
            assert outline_error(glyph.contours.split(points), drawn) < OUTLINE_TOLERANCE
            assert abs(glyph.advance_width.outer.value(want) - referee.advance(glyph.glyph_id)) <= 1


@pytest.mark.parametrize("source", sources())
def test_jacobian_is_the_slope_of_the_points_also_at_the_default(source):
    font = vf.load_font(source())
    lower, upper = map(torch.tensor, font.bounds)
    part = torch.rand(len(lower), generator=torch.Generator().manual_seed(1)).double()
    glyphs = [glyph for glyph in font if glyph.contours][:3]
    for w in torch.zeros_like(lower), lower + part * (upper - lower):
        for glyph in glyphs:
            jacobian = glyph.jacobian(w)
            array = glyph.outline.value_and_jacobian(w.numpy())[1]
            torch.testing.assert_close(jacobian, torch.as_tensor(array))
            for axis in range(len(w)):
                moved = w.clone()
                moved[axis] += STEP if w[axis] + STEP <= 1 else -STEP
                slope = (glyph.points(moved) - glyph.points(w)) / (moved[axis] - w[axis])
                torch.testing.assert_close(jacobian[..., axis], slope, rtol=1e-6, atol=1e-3)


def test_an_axis_moves_another_by_hand():
    font = vf.load_font(variation_tables.avar_2())
    # Weight displaces width by -0.5 at most, width displaces nothing.
    assert font.final_coordinates([1, 0.75]).tolist() == [1, 0.25]
    assert font.final_coordinates([1, -0.75]).tolist() == [1, -1]
    assert font.normalize({"wght": 900, "wdth": 175}).tolist() == [1, 0.75]
    assert font.denormalize([1, 0.75]) == {"wght": 900, "wdth": 175}


def test_a_text_of_such_a_font_is_dragged():
    font = vf.load_font(variation_tables.avar_2())
    text = vf.Text(font, "ab")
    handle = text.handle(glyph=0, segment=0)
    target = text.at(axes={"wght": 700, "wdth": 150}).position(handle)
    solution = vf.solve(text, [vf.Target(handle, target)])
    torch.testing.assert_close(solution.text.position(handle), target, rtol=0, atol=1e-2)


def test_a_batch_is_its_rows():
    font = vf.load_font(variation_tables.avar_2())
    glyph = font.glyph("b")
    w = torch.tensor([[0, 0], [0.5, -0.5], [1, 1], [-1, 0.25]], dtype=torch.float64)
    for method in glyph.points, glyph.jacobian, glyph.advance, font.final_coordinates:
        torch.testing.assert_close(method(w), torch.stack([method(row) for row in w]))
    want = glyph.jacobian(w[1])
    torch.testing.assert_close(torch.func.jacrev(glyph.points)(w[1]), want)
    torch.testing.assert_close(torch.func.vmap(torch.func.jacfwd(glyph.points))(w[1:2])[0], want)


def test_a_displacement_that_leads_nowhere_is_none():
    font = vf.load_font(variation_tables.avar_2(store=False))
    assert font.final_coordinates([1, 0.75]).tolist() == [1, 0.75]
    assert font.glyph("a").is_affine


# The inverse


@pytest.mark.parametrize("source", sources())
def test_final_coordinates_lead_back_to_axis_values_that_have_them(source):
    font = vf.load_font(source())
    lower, upper = font.bounds
    for w in np.random.default_rng(3).uniform(lower, upper, (6, len(lower))):
        final = font.final_coordinates(w)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", vf.AxisWarning)
            values = font.denormalize(final, final=True)
        back = font.final_coordinates(font.normalize(values))
        np.testing.assert_allclose(back, final, rtol=0, atol=0.6 / F2DOT14)


def test_the_inverse_by_hand():
    font = vf.load_font(variation_tables.avar_2())
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert font.denormalize([1, 0.25], final=True) == pytest.approx({"wght": 900, "wdth": 175})
        plain = vf.load_font("dynapuff")
        assert plain.denormalize([1, 0], final=True) == plain.denormalize([1, 0])


def test_final_coordinates_that_several_axis_values_have():
    # A width of -0.5 … -1 is displaced to -1 by the full weight.
    with pytest.warns(vf.AxisWarning, match="Several axis values lead to these final"):
        values = vf.load_font(variation_tables.avar_2()).denormalize([1, -1], final=True)
    assert values == pytest.approx({"wght": 900, "wdth": 75}, abs=0.1)


def test_final_coordinates_that_no_axis_values_have():
    with pytest.raises(vf.AxisError, match=r"No axis values lead to .*\[1.0, 0.75\].* by 0.2"):
        vf.load_font(variation_tables.avar_2()).denormalize([1, 0.75], final=True)
