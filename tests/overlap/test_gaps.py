"""Gaps between outlines agree with the distances of polygons."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
import shapely
from shapely.affinity import translate
from shapely.geometry import Polygon
from shapely.ops import unary_union

import vfwidget as vf
from tests.overlap.polygons import WEIGHTS, filled, simple
from vfwidget.overlap.gaps import Outlines
from vfwidget.overlap.shape import Shape, letters, polygon


def outer(shape: Shape):
    """The outer contours of a shape as fine polygons."""
    ends = np.cumsum(shape.sizes)
    parts = [
        Polygon(np.einsum("tk,skc->stc", WEIGHTS, shape.segments[a:b]).reshape(-1, 2)).buffer(0)
        for a, b in zip([0, *ends[:-1]], ends, strict=True)
    ]
    return unary_union(parts)


@pytest.mark.parametrize(("font", "pair"), list(product(vf.bundled_fonts(), ["Oa", "Ts", "NT"])))
def test_the_least_gap_is_the_distance(font, pair) -> None:
    rng = np.random.default_rng(len(font) + ord(pair[0]))
    first, second = letters(vf.Text(font, pair, shared=False))
    cos, sin = np.cos(ord(pair[1])), np.sin(ord(pair[1]))
    second = Shape(second.segments @ np.array([[cos, sin], [-sin, cos]]), second.sizes)
    one, other = outer(first), outer(second)
    # From where both lie over each other, the second one moves away until they are 0.5 apart.
    start = np.array(one.centroid.coords[0]) - np.array(other.centroid.coords[0])
    second = Shape(second.segments + start, second.sizes)
    other = translate(other, *start)
    angle = rng.uniform(0, 2 * np.pi)
    away = np.array([np.cos(angle), np.sin(angle)])
    near, far = 0.0, 5000.0
    for _ in range(40):
        middle = (near + far) / 2
        if one.distance(translate(other, *(middle * away))) > 0.5:
            far = middle
        else:
            near = middle
    segments = np.concatenate([first.segments, second.segments + far * away])
    gaps = Outlines([first, second], 2).gaps(segments, 20.0)
    distance = one.distance(translate(other, *(far * away)))
    assert gaps.gap.min() == pytest.approx(distance, abs=0.02)
    # The ends of each gap are that far apart, along the normal.
    start, end = gaps.ends(segments)
    np.testing.assert_allclose(start - end, gaps.gap[:, None] * gaps.normal, atol=1e-6)


def test_a_point_inside_has_a_negative_gap_and_obstacles_have_none() -> None:
    square = np.array([(0, 0), (100, 0), (100, 100), (0, 100)], dtype=float)
    shapes = [Shape(polygon(corners), [4]) for corners in (square, square + np.array([97, 40]))]
    gaps = Outlines(shapes, 1).gaps(np.concatenate([s.segments for s in shapes]), 10.0)
    assert gaps.gap.min() == pytest.approx(-3)
    deepest = gaps.some(gaps.gap < -2.9)
    assert (abs(deepest.normal[:, 0]) > 0.99).all()
    none = Outlines(shapes, 0).gaps(np.concatenate([s.segments for s in shapes]), 10.0)
    assert not len(none.gap)


@pytest.mark.parametrize("font", vf.bundled_fonts())
def test_every_gap_is_the_signed_distance_of_its_point(font) -> None:
    rng = np.random.default_rng(len(font))
    for pair in ("Hi", "EO", "in", "ab"):
        first, second = map(simple, letters(vf.Text(font, pair, shared=False)))
        one, other = filled(first), filled(second)
        # The second letter stands at the right of the first one, up to 40 units inside it.
        right, left = one.bounds[2], other.bounds[0]
        way = right - left - rng.uniform(0, 40), rng.uniform(-300, 300)
        second = Shape(second.segments + np.array(way), second.sizes)
        other = translate(other, *way)
        segments = np.concatenate([first.segments, second.segments])
        gaps = Outlines([first, second], 2).gaps(segments, 40.0)
        points, _ = gaps.ends(segments)
        for shape, solid in enumerate((one, other)):
            to_it = gaps.shape[:, 1] == shape
            distance = shapely.distance(shapely.points(points[to_it]), solid.boundary)
            inside = shapely.contains_xy(solid, points[to_it])
            signed = np.where(inside, -distance, distance)
            np.testing.assert_allclose(gaps.gap[to_it], signed, atol=0.1, err_msg=pair)
