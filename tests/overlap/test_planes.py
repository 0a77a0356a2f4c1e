"""The planes that keep a gap: the nearest points of two outlines have one."""

from __future__ import annotations

import numpy as np
import pytest
from shapely.geometry import LinearRing, MultiLineString

import vfwidget as vf
from vfwidget.outline.cubics import bernstein

GRID = bernstein(np.linspace(0, 1, 200, endpoint=False)).T


def flat(contour):
    return LinearRing(np.concatenate([GRID @ segment for segment in np.asarray(contour)]))


def disc_at(centre, radius):
    """A disc as one contour in a list."""
    circle = vf.Artwork(f'<svg xmlns="http://www.w3.org/2000/svg"><circle r="{radius}"/></svg>')
    return circle.moved(*centre).contours


def distance(text, obstacle=None):
    """The smallest distance between two letters of the text, or from an obstacle."""
    contours = iter(text.segments())
    shapes = [MultiLineString([flat(next(contours)) for _ in g.contours]) for g in text.glyphs]
    if obstacle is not None:
        shapes.append(flat(obstacle[0]) if np.ndim(obstacle) == 4 else LinearRing(obstacle))
    return min(a.distance(b) for i, a in enumerate(shapes) for b in shapes[i + 1 :])


def miss(text, *obstacles, **options):
    """How far the text misses a gap where it stands."""
    term = vf.NoOverlap(obstacles, **options)
    return vf.solve(text, term, max_iterations=0, restarts=0).terms[0].miss


@pytest.mark.parametrize("method", ["area", "planes"])
@pytest.mark.parametrize("height", [60, 91, 130, 700])
def test_a_corner_near_a_straight_side(method, height):
    """The tip of a triangle, 3 units to the right of an I."""
    text = vf.Text("roboto-flex", "I")
    right = float(text.points()[:, 0].max()) + 3
    wedge = [(right, height), (right + 500, height - 99), (right + 500, height + 99)]
    assert miss(text, wedge, gap=10, method=method) == pytest.approx(7)
    assert miss(text, wedge, gap=3.01, method=method) == pytest.approx(0.01)
    assert miss(text, wedge, gap=2.99, method=method) == 0


def test_a_point_outside_beside_a_corner_is_not_inside():
    """The nearest point of a sharp corner has two normals, and one of them points away."""
    text = vf.Text("roboto-flex", "I")
    right = float(text.points()[:, 0].max()) + 3
    for height in range(50, 500, 10):
        wedge = [(right, height), (right + 500, height - 99), (right + 500, height + 99)]
        assert miss(text, wedge, method="planes") == 0


@pytest.mark.parametrize("font", vf.bundled_fonts())
def test_the_miss_is_that_of_the_smallest_distance(font):
    text = vf.Text(font, "Rg", shared=False, tracking=30.0).at(rotations=[0.1, -0.2])
    apart = distance(text)
    assert miss(text, gap=apart + 5) == pytest.approx(5, abs=0.01)
    assert miss(text, gap=apart - 0.01) == 0


@pytest.mark.parametrize("angle", np.arange(0.1, 1.5, 0.2))
def test_two_round_shapes(angle):
    """No sample of either outline is nearer than the gap, but their nearest points are."""
    text = vf.Text("recursive", "O")
    lower, upper = (text.points().numpy().min(0), text.points().numpy().max(0))
    way = 900 * np.array([np.cos(angle), np.sin(angle)])
    disc = disc_at((lower + upper) / 2 + way, 350.0)
    apart = distance(text, disc)
    assert miss(text, disc, gap=apart + 0.02) == pytest.approx(0.02, abs=0.01)


def test_only_the_pairs_that_are_asked_for_have_planes():
    text = vf.Text("roboto-flex", "II", tracking=-100.0)
    far = [(5000, 0), (5100, 0), (5100, 100)]
    assert miss(text, gap=400) > 0
    assert miss(text, far, gap=400, between_glyphs=False) == 0


@pytest.mark.parametrize("gap", [5.0, 20.0])
def test_a_free_state_keeps_the_gap(gap):
    text = vf.Text("afacad-flux", "ello", shared=False, tracking=-60.0)
    text = text.at(rotations=[0.1, -0.15, 0.2, -0.1])
    solution = vf.resolve_overlaps(text, gap=gap)
    assert solution.free
    assert distance(solution.text) > gap - 0.05


def test_a_gap_from_a_corner_is_made():
    text = vf.Text("roboto-flex", "I")
    right = float(text.points()[:, 0].max()) + 3
    wedge = [(right, 60), (right + 500, -40), (right + 500, 160)]
    solution = vf.resolve_overlaps(text, wedge, gap=10.0)
    assert solution.free
    assert distance(solution.text, wedge) > 10 - 0.05
