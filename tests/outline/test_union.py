"""Outlines without overlaps: the same area, whose contours no longer cross."""

from __future__ import annotations

import numpy as np
import pytest

import vfwidget as vf
from vfwidget.outline.cubics import AREA
from vfwidget.outline.union import odd, without_overlaps
from vfwidget.raster import frame


def contours_of(text):
    contours = [segments.numpy() for segments in text.segments()]
    return np.concatenate(contours), [len(contour) for contour in contours]


def signed_area(contours):
    """∫ y dx: positive where the shape is on the right."""
    return -sum(np.einsum("si,ij,sj->", c[..., 0], AREA, c[..., 1]) for c in contours)


@pytest.mark.parametrize("name", vf.bundled_fonts())
def test_letters_keep_their_ink(name):
    text = vf.Text(name, "NARt&8@")
    rng = np.random.default_rng(0)
    for theta in rng.uniform(*text.font.bounds, (2, 1, len(text.font.axes))):
        here = text.at(theta=theta)
        size, scale = (256, 1024), frame(here, (256, 1024))
        simple = without_overlaps(*contours_of(here))
        for contour in simple:
            np.testing.assert_array_equal(contour[:, 3], np.roll(contour[:, 0], -1, 0))
        want = vf.rasterize(here, size, scale)
        np.testing.assert_allclose(vf.rasterize(simple, size, scale), want, rtol=0, atol=1e-6)
        # Every point is counted once, so the signed area is that of the ink.
        ink = float(want.sum() / scale[0, 0] ** 2)
        assert signed_area(simple) == pytest.approx(ink, rel=1e-6)


def test_shapes_are_joined_by_the_fill_rule():
    square = np.array([(0, 0), (0, 1), (1, 1), (1, 0)], float)
    sides = np.stack([square, np.roll(square, -1, 0)], 1)
    segments = np.stack(
        [sides[:, 0] + t * (sides[:, 1] - sides[:, 0]) for t in (0, 1 / 3, 2 / 3, 1)], 1
    )
    both = np.concatenate([3 * segments, segments + 1])
    assert signed_area(without_overlaps(both, [4, 4])) == pytest.approx(9)
    assert signed_area(without_overlaps(both, [4, 4], odd)) == pytest.approx(8)
    assert without_overlaps(np.zeros((0, 4, 2)), []) == []


def test_shapes_of_their_own_are_not_joined():
    """Each image is simplified alone, though the squares of all lie at the same place."""
    square = np.array([(0, 0), (0, 1), (1, 1), (1, 0)], float)
    sides = np.stack([square, np.roll(square, -1, 0)], 1)
    t = np.linspace(0, 1, 4)[:, None]
    segments = sides[:, :1] * (1 - t) + sides[:, 1:] * t
    crossed = np.concatenate([segments, segments + 0.5])
    image = np.repeat(np.arange(50), 8)
    simple = without_overlaps(np.concatenate([crossed] * 50), [4] * 100, image=image)
    assert len(simple) == 50
    for contour in simple:
        assert signed_area([contour]) == pytest.approx(1.75)
