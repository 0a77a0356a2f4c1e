"""Cubics: nearest points and extents against dense sampling."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

import vfwidget as vf
from vfwidget.outline.contours import Contours
from vfwidget.outline.cubics import bernstein, nearest, x_extent

checked = settings(deadline=None, derandomize=True, max_examples=100)
coordinate = st.integers(-1000, 1000).map(float)
point = st.tuples(coordinate, coordinate)
contours = st.integers(1, 3).flatmap(
    lambda s: st.lists(point, min_size=3 * s, max_size=3 * s).map(
        lambda points: np.array(points)[Contours([s]).segments]
    )
)
cubics = st.lists(st.tuples(*[point] * 4), min_size=1, max_size=4).map(np.array)


def along(segments: np.ndarray, count: int = 4001) -> np.ndarray:
    """Points at even parameters, (s, count, 2)."""
    return bernstein(np.linspace(0, 1, count)).T @ segments


def test_weights_of_the_control_points():
    np.testing.assert_allclose(bernstein(0.25) * 64, [27, 27, 9, 1])
    np.testing.assert_array_equal([bernstein(0), bernstein(1)], [[1, 0, 0, 0], [0, 0, 0, 1]])


@checked
@given(cubics, point)
def test_nearest_is_no_farther_than_any_sample(segments, target):
    index, t = nearest(segments, np.array(target))
    assert 0 <= t <= 1
    found = np.linalg.norm(bernstein(t) @ segments[index] - target)
    best = np.linalg.norm(along(segments) - target, axis=-1).min()
    # Two arms of one curve may be so nearly as near that its coarse samples take the wrong one.
    assert found <= best + 0.02 * np.ptp(segments, axis=(0, 1)).max()


@pytest.mark.parametrize("name", vf.bundled_fonts())
def test_nearest_on_a_letter_is_the_nearest(name):
    rng = np.random.default_rng(8)
    font = vf.load_font(name)
    for letter in "aRg8":
        segments = np.concatenate([s.numpy() for s in font.glyph(letter).segments(font.bounds[1])])
        size = np.ptp(segments, axis=(0, 1)).max()
        samples = along(segments, 1001)
        for target in rng.uniform(-0.2 * size, 1.2 * size, (5, 2)):
            index, t = nearest(segments, target)
            found = np.linalg.norm(bernstein(t) @ segments[index] - target)
            assert found <= np.linalg.norm(samples - target, axis=-1).min() + 1e-9


@pytest.mark.parametrize(
    "segment, target, t",
    [
        ([(0, 0), (100, 0), (200, 0), (300, 0)], (75, 50), 0.25),
        ([(0, 0), (100, 0), (200, 0), (300, 0)], (-9, 5), 0),
        ([(0, 0), (100, 0), (200, 0), (300, 0)], (999, 5), 1),
        # A cusp, where the derivative vanishes.
        ([(0, 0), (100, 100), (0, 100), (100, 0)], (50, 200), 0.5),
    ],
)
def test_nearest_by_hand(segment, target, t):
    assert nearest(np.array([segment], dtype=float), np.array(target))[1] == pytest.approx(
        t, abs=1e-4
    )


def test_nearest_on_a_point_is_that_point():
    assert nearest(np.full((1, 4, 2), 7.0), np.array([0.0, 0.0]))[0] == 0


@checked
@given(contours)
def test_extent_is_that_of_the_curve(contour):
    left, right = (x.item() for x in x_extent([torch.tensor(contour)]))
    x = along(contour)[..., 0]
    # Samples miss a sharp turn by little.
    assert left - 1e-9 <= x.min() <= left + 0.01
    assert right - 0.01 <= x.max() <= right + 1e-9


def test_extent_is_differentiable_where_the_edge_is_inside_a_segment():
    bulge = [(0.0, 0.0), (400.0, 100.0), (300.0, 200.0), (0.0, 300.0)]
    back = [(0.0, 300.0), (-10.0, 200.0), (-90.0, 100.0), (0.0, 0.0)]
    contour = torch.tensor([bulge, back], dtype=torch.float64, requires_grad=True)
    assert torch.autograd.gradcheck(lambda c: x_extent([c]), contour)
