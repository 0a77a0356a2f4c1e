"""Supports and scaling factors: by hand, against fontTools, and their derivatives."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from fontTools.varLib.models import supportScalar
from hypothesis import given, settings
from hypothesis import strategies as st
from shared_cases import CASES

from vfwidget.outline.variation import Regions, merge_regions, selection

GRID = 64
STEP = 1e-6
on_grid = st.integers(-GRID, GRID).map(lambda i: i / GRID)
off_grid = st.integers(-GRID, GRID - 1).map(lambda i: (i + 0.5) / GRID)
"""Coordinates at which no support has a kink, with room for a difference to either side."""
anything = st.tuples(on_grid, on_grid, on_grid)
valid = st.one_of(
    st.lists(st.integers(0, GRID), min_size=3, max_size=3).map(
        lambda s: tuple(i / GRID for i in sorted(s))
    ),
    st.lists(st.integers(-GRID, 0), min_size=3, max_size=3).map(
        lambda s: tuple(i / GRID for i in sorted(s))
    ),
    st.just((0.0, 0.0, 0.0)),
)
continuous = valid.filter(
    lambda s: (s[0] < s[1] < s[2]) or s[1] == 0 or s in [(0, 1, 1), (-1, -1, 0)]
)


@st.composite
def regions(draw, supports=valid, places=on_grid):
    """Supports (m, n, 3) and a place w (n,)."""
    m, n = draw(st.integers(1, 4)), draw(st.integers(1, 3))
    support = [[draw(supports) for _ in range(n)] for _ in range(m)]
    return np.array(support), np.array([draw(places) for _ in range(n)])


checked = settings(deadline=None, derandomize=True, max_examples=100)


@pytest.mark.parametrize("case", CASES["scalars"], ids=lambda case: case["name"])
def test_scalars_by_hand(case):
    got = Regions(case["support"]).scalars(np.array(case["w"], dtype=float))
    np.testing.assert_allclose(got, case["scalars"], rtol=0, atol=1e-12)


@checked
@given(regions(supports=st.one_of(valid, anything), places=st.one_of(on_grid, off_grid)))
def test_scalars_as_fonttools_has_them(case):
    support, w = case
    location = dict(enumerate(w))
    want = [supportScalar(location, dict(enumerate(map(tuple, region)))) for region in support]
    np.testing.assert_allclose(Regions(support).scalars(w), want, rtol=0, atol=1e-12)


@checked
@given(regions(places=off_grid))
def test_jacobian_is_the_slope_between_kinks(case):
    support, w = case
    made = Regions(support)
    step = STEP * np.eye(len(w))
    want = (made.scalars(w + step) - made.scalars(w - step)).T / (2 * STEP)
    np.testing.assert_allclose(made.scalars_and_jacobian(w)[1], want, rtol=1e-6, atol=1e-6)


@checked
@given(regions(supports=continuous, places=on_grid))
def test_jacobian_on_a_kink_is_the_slope_to_the_right_or_at_the_end_to_the_left(case):
    support, w = case
    made = Regions(support)
    for axis in range(len(w)):
        step = np.zeros(len(w))
        step[axis] = STEP if w[axis] < 1 else -STEP
        want = (made.scalars(w + step) - made.scalars(w)) / step[axis]
        got = made.scalars_and_jacobian(w)[1][:, axis]
        np.testing.assert_allclose(got, want, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize(
    "support, w, slope",
    [
        ((0, 0.5, 0.5), 0.5, 2),  # a cliff to the right: the slope of the line that leads to it
        ((0.5, 0.5, 1), 0.5, -2),
        ((0.5, 0.5, 0.5), 0.5, 0),
        ((0, 1, 1), 1, 1),
        ((0, 1, 1), 0, 1),
        ((-1, -1, 0), 0, 0),
        ((-1, -1, 0), -1, -1),
        ((0, 0.5, 1), 0.5, -2),
        ((0, 0, 1), 0.5, 0),
    ],
)
def test_slope_by_hand(support, w, slope):
    _, jacobian = Regions([[support]]).scalars_and_jacobian(np.array([w]))
    assert jacobian.item() == slope


@checked
@given(regions(places=st.one_of(on_grid, off_grid)))
def test_torch_numpy_and_autograd_agree(case):
    support, w = case
    made, tensor = Regions(support), torch.tensor(w)
    scalars, jacobian = made.scalars_and_jacobian(w)
    for got in made.scalars(w), made.scalars(tensor), made.scalars_and_jacobian(tensor)[0]:
        np.testing.assert_array_equal(got, scalars)
    np.testing.assert_array_equal(made.scalars_and_jacobian(tensor)[1], jacobian)
    autograd = torch.autograd.functional.jacobian(made.scalars, tensor)
    np.testing.assert_allclose(autograd, jacobian, rtol=1e-12, atol=1e-12)


@checked
@given(regions(), st.lists(on_grid, min_size=18, max_size=18))
def test_a_batch_is_its_rows(case, numbers):
    support, w = case
    made, batch = Regions(support), np.reshape(numbers[: 6 * len(w)], (2, 3, len(w)))
    scalars, jacobian = made.scalars_and_jacobian(batch)
    np.testing.assert_array_equal(made.scalars(batch), scalars)
    for index in np.ndindex(2, 3):
        one, slope = made.scalars_and_jacobian(batch[index])
        np.testing.assert_array_equal(scalars[index], one)
        np.testing.assert_array_equal(jacobian[index], slope)


@checked
@given(
    regions(supports=st.one_of(valid, anything)),
    st.lists(st.tuples(on_grid, st.sampled_from([-1e-8, 0.0, 1e-8])), min_size=3, max_size=24),
)
def test_the_cells_kept_along_a_path_change_no_value(case, steps):
    support, w = case
    kept = Regions(support)
    for i, (place, off) in enumerate(steps):
        # One axis moves at each step, to a kink or just beside it.
        w[i % len(w)] = place + off
        for got, want in zip(kept.along(w), Regions(support).scalars_and_slopes(w), strict=True):
            np.testing.assert_array_equal(got, want)


def test_breakpoints_are_those_of_the_axes_that_take_part():
    made = Regions([[(0, 0.5, 1), (0, 0, 0)], [(0.25, 0.5, 0.75), (-1, -1, 0)], [(-1, 0.5, 1)] * 2])
    assert [points.tolist() for points in made.breakpoints] == [[0, 0.25, 0.5, 0.75, 1], [-1, 0]]


@checked
@given(st.lists(regions().map(lambda case: case[0]), max_size=4))
def test_merging_keeps_every_region_once_and_in_its_place(supports):
    # One number of axes for all.
    supports = [support[:, :1] for support in supports]
    merged, indices = merge_regions(supports)
    assert len({region.tobytes() for region in merged}) == len(merged)
    for support, index in zip(supports, indices, strict=True):
        np.testing.assert_array_equal(merged[index], support)
        spread = selection(index, len(merged))
        deltas = np.arange(1.0, len(support) + 1)
        # Laid out over the merged regions, deltas move a point just as far; repeats add up.
        here = np.array([0.3])
        np.testing.assert_allclose(
            (deltas @ spread) @ Regions(merged).scalars(here),
            deltas @ Regions(support).scalars(here),
        )


@pytest.mark.parametrize(
    ("side", "upper", "slope"),
    [
        ((0, 0.5, 1), 0.0, 0.0),  # Values beyond the upper end are never reached.
        ((0, 0.5, 1), 0.5, 2.0),
        ((-1, -0.5, 0), 0.0, -2.0),
        ((-1, -1, 0), 0.0, -1.0),
        ((0, 1, 1), 1.0, 1.0),
        ((0, 0.5, 1), 1.0, -2.0),
    ],
)
def test_at_the_upper_end_of_a_coordinate_the_slope_is_that_from_the_left(side, upper, slope):
    one = np.array([0])
    slots = Regions([[side]]).of_letters(one, one, np.array([upper]))
    height, found = slots.along(np.array([upper]))
    assert found[0, 0] == slope
    before = slots.along(np.array([upper - 1e-6]))[0]
    assert height[0] - before[0] == pytest.approx(1e-6 * slope)
