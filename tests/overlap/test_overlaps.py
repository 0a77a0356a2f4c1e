"""Which letters overlap: pairs, contacts, obstacles of every kind, and obstacles that are none."""

from __future__ import annotations

import tracemalloc
from pathlib import Path

import numpy as np
import pytest
import shapely

import vfwidget as vf
from tests.overlap.polygons import filled, simple
from vfwidget.overlap.contacts import nearest_chord
from vfwidget.overlap.shape import letters, polygon, read_obstacles
from vfwidget.raster import frame

SQUARE = [(0, 0), (100, 0), (100, 100), (0, 100)]


def test_letters_do_not_overlap_themselves_or_each_other():
    # The contours of each of these letters overlap.
    for name in vf.bundled_fonts():
        assert vf.overlaps(vf.Text(name, "NARt")) == []


def test_a_bar_through_a_stem():
    text = vf.Text("roboto-flex", "l")
    left, right = text.segments()[0][..., 0].min(), text.segments()[0][..., 0].max()
    [found] = vf.overlaps(text, [[(-500, 300), (500, 300), (500, 340), (-500, 340)]])
    assert found.pair == (0, 0) and found.obstacle
    assert found.area == pytest.approx(40 * float(right - left))
    # The shortest way out of the bar is up or down.
    inside = abs(found.points[:, 1] - 320) < 19.9
    assert found.depth <= max(20.0, float(right - left) / 2) + 1e-9
    np.testing.assert_allclose(np.hypot(*found.normals.T), 1, rtol=0, atol=1e-9)
    assert inside.any()
    assert "obstacle 0" in repr(found)


def test_normals_lead_out():
    text = vf.Text("recursive", "o")
    corner = [(0, 0), (120, 0), (120, 260), (0, 260)]
    [found] = vf.overlaps(text, [corner])
    # Moving the letter along its contacts' normals makes the common area smaller.
    way = found.normals.mean(0)
    shifted = [np.array(corner) - 2 * way]
    assert vf.overlaps(text, shifted)[0].area < found.area


def test_a_letter_inside_an_obstacle_counts():
    text = vf.Text("dynapuff", "o")
    huge = [(-5000, -5000), (5000, -5000), (5000, 5000), (-5000, 5000)]
    [found] = vf.overlaps(text, [huge])
    ink = vf.rasterize(text, (300, 300)).sum() / frame(text, (300, 300))[0, 0] ** 2
    assert found.area == pytest.approx(float(ink), rel=1e-6)
    assert found.depth > 1000


def test_lines_and_texts_as_obstacles():
    text = vf.Text("recursive", "pq")
    below = [s.numpy() - (0, 500) for s in vf.Text("recursive", "ll").segments()]
    found = vf.overlaps(text, [below])
    assert {overlap.pair for overlap in found} <= {(0, 0), (1, 0)} and found
    assert {o.pair for o in vf.overlaps(text, vf.Text("recursive", "pq"))} == {(0, 0), (1, 0)}


def test_one_obstacle_needs_no_list():
    text = vf.Text("recursive", "N")
    areas = [vf.overlaps(text, o)[0].area for o in ([SQUARE], SQUARE, np.array(SQUARE))]
    assert areas == [areas[0]] * 3


def test_self_intersecting_obstacles_are_filled_nonzero():
    text = vf.Text("recursive", "H")
    x, y = np.cos(np.arange(5) * 4 * np.pi / 5), np.sin(np.arange(5) * 4 * np.pi / 5)
    star = 200 * np.stack([x, y], 1) + (300, 350)
    [found] = vf.overlaps(text, [star])
    assert found.area > 0
    [turned] = vf.overlaps(text, [star[::-1]])
    assert turned.area == pytest.approx(found.area)


@pytest.mark.parametrize(
    "obstacles, message",
    [
        (5, "obstacles must be a list of polygons"),
        ([5], r"obstacles\[0\] must be a polygon"),
        ([[(0, 0), (1, 1)]], "a polygon is \\(m, 2\\) with m ≥ 3"),
        ([[(0, 0), (1, 1), (2, 2)]], "has no area"),
        ([[(0, 0), (1, np.nan), (2, 0)]], "must be finite"),
        ([[(0, 0), (1, 1e300), (2, 0)]], "must be finite and at most"),
        ([[np.zeros((3, 4, 3))]], r"give \(s, 4, 2\)"),
        ([[np.random.default_rng(0).normal(size=(3, 4, 2))]], "must start where the one before"),
        ([[]], "a polygon is"),
        ([SQUARE, []], r"obstacles\[1\] is empty"),
        ([SQUARE, [("a", "b"), (1, 2), (3, 4)]], r"obstacles\[1\]"),
    ],
)
def test_obstacles_that_are_none(obstacles, message):
    with pytest.raises(vf.OverlapError, match=message):
        vf.overlaps(vf.Text("recursive", "a"), obstacles)


def test_the_first_argument_is_a_text():
    with pytest.raises(vf.OverlapError, match="needs a Text first; received str"):
        vf.overlaps("a")


def test_spaces_have_no_outline():
    assert vf.overlaps(vf.Text("recursive", "a b"), [[(900, 0), (950, 0), (950, 9)]]) == []
    assert vf.overlaps(vf.Text("recursive", " "), [SQUARE]) == []


def test_there_may_be_more_obstacles_than_letters():
    text = vf.Text("recursive", "N")
    bars = [np.array([(0, y), (600, y), (600, y + 20), (0, y + 20)]) for y in (100, 300, 500)]
    found = vf.solve(text, vf.NoOverlap(bars), max_iterations=2)
    separate = [vf.overlaps(found.text, [bar])[0].area for bar in bars]
    assert np.isclose(found.cost, sum(separate))
    vf.check_derivative(vf.NoOverlap(bars), text)


@pytest.mark.parametrize("text", [None, 7, "abc", np.zeros((3, 2))])
def test_overlaps_need_a_text(text):
    with pytest.raises(vf.OverlapError, match="needs a Text"):
        vf.overlaps(text)


def test_obstacles_of_many_corners_take_little_memory():
    """A comb of 400 teeth; all pairs of its points and chords would take half a gigabyte."""
    teeth = [(4 * i, 700 if i % 2 else 0) for i in range(800)]
    text = vf.Text("recursive", "Hm")
    tracemalloc.start()
    found = vf.overlaps(text, [[*teeth, (3200, -9), (0, -9)]])
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert len(found) == 2
    assert peak < 100e6


def test_the_nearest_chords_of_many_points_are_those_of_each_point():
    chance = np.random.default_rng(7)
    points, start = chance.normal(size=(4000, 2)), 9 * chance.normal(size=(3000, 2))
    along = chance.normal(size=(3000, 2))
    chord, part, distance = nearest_chord(points, start, along)
    for i in range(0, 4000, 100):
        one = nearest_chord(points[i : i + 1], start, along)
        assert (chord[i], part[i], distance[i]) == (one[0][0], one[1][0], one[2][0])


@pytest.mark.parametrize("shift", [0.0, 2.5e-12, 1e-9])
@pytest.mark.parametrize("letter", ["W", "A", "T", "k"])
def test_contacts_of_a_letter_with_itself_lie_on_its_outline(letter: str, shift: float) -> None:
    # Where contours cross, the outlines of both cross in the same point inside.
    for name in vf.bundled_fonts():
        text = vf.Text(name, letter).at(rotations=[0.3])
        own = filled(simple(letters(text)[0]))
        copy = [np.asarray(segments) + shift for segments in text.segments()]
        [found] = vf.overlaps(text, [copy])
        away = shapely.distance(shapely.points(found.points), own.boundary)
        assert away.max() < 0.1
        assert found.depth < 0.1


@pytest.mark.parametrize("depth", [0.005, 1.0])
def test_the_depth_of_a_thin_overlap(depth: float) -> None:
    text = vf.Text("shantell-sans", "f")
    t = np.linspace(0, 1, 2001)
    weights = np.stack([(1 - t) ** 3, 3 * (1 - t) ** 2 * t, 3 * (1 - t) * t * t, t**3])
    low = min(float((weights.T @ s.numpy()[..., 1].T).min()) for s in text.segments())
    top = low + depth
    floor = [(-300, top - 100), (1500, top - 100), (1500, top), (-300, top)]
    (found,) = vf.overlaps(text, [floor])
    assert found.depth == pytest.approx(depth, rel=0.02)


def test_the_depth_of_a_needle_is_that_of_its_tip():
    text = vf.Text("roboto-flex", "l")
    x = text.segments()[0][..., 0]
    left, right = float(x.min()), float(x.max())
    depth = 0.4 * (right - left)
    tip = (left + depth, 300)
    [found] = vf.overlaps(text, [[tip, (left - 1000, 320), (left - 1000, 280)]])
    assert found.depth == pytest.approx(depth, rel=0.01)
    # The tip itself is one of the contacts, with the way out to the left.
    last = np.hypot(*(found.points - tip).T).argmin()
    assert np.hypot(*(found.points[last] - tip)) < 0.01 * depth
    assert found.normals[last] @ (1, 0) == pytest.approx(1)


@pytest.mark.parametrize("seed", range(6))
def test_the_depth_of_random_overlaps(seed):
    chance = np.random.default_rng(seed)
    text = vf.Text("recursive", "&g", tracking=-300, offsets=chance.normal(0, 60, (2, 2)))
    text = text.at(rotations=chance.normal(0, 0.5, 2))
    corners = chance.uniform(0, 600, (1, 2)) + chance.normal(0, 150, (5, 2))
    shapes = [*letters(text), *read_obstacles([corners])]
    polygons = [filled(simple(shape)) for shape in shapes]
    found = vf.overlaps(text, [corners])
    assert found
    for overlap in found:
        i, j = overlap.pair
        pair = polygons[i], polygons[2 if overlap.obstacle else j]
        depths = []
        for one, other in (pair, pair[::-1]):
            inside = one.boundary.segmentize(0.25).intersection(other)
            points = shapely.points(shapely.get_coordinates(inside))
            depths.append(shapely.distance(points, other.boundary).max(initial=0))
        assert overlap.depth == pytest.approx(max(depths), rel=0.02, abs=0.5)


def test_the_contours_of_a_text_are_one_obstacle():
    text, other = vf.Text("recursive", "no"), vf.Text("recursive", "o").at(offsets=[(300, 40)])
    expected = vf.overlaps(text, other)
    assert [found.pair for found in expected] == [(0, 0), (1, 0)]
    # The second contour of the o is a hole.
    for obstacles in (other.segments(), [other.segments()]):
        found = vf.overlaps(text, obstacles)
        assert [one.pair for one in found] == [(0, 0), (1, 0)]
        areas = [one.area for one in expected]
        assert [one.area for one in found] == pytest.approx(areas, rel=1e-9)


@pytest.mark.parametrize("source", ["<svg/>", b"<svg/>", Path("a.svg")])
def test_an_svg_becomes_artwork_first(source):
    for obstacles in (source, [source]):
        with pytest.raises(vf.OverlapError, match=r"vf\.Artwork"):
            vf.overlaps(vf.Text("recursive", "n"), obstacles)


@pytest.mark.parametrize(
    "use",
    [
        vf.overlaps,
        lambda text, obstacles: vf.solve(text, [vf.NoOverlap(obstacles)]),
        vf.resolve_overlaps,
        lambda text, obstacles: vf.simulate(text, 2, obstacles=obstacles, progress=False),
        lambda text, obstacles: vf.Editor(text, obstacles=obstacles),
    ],
    ids=["overlaps", "NoOverlap", "resolve_overlaps", "simulate", "Editor"],
)
def test_obstacles_that_can_be_read_once_only_are_refused(use):
    # NoOverlap, Editor and simulate read them several times, and found none from the second on.
    text = vf.Text("roboto-flex", "N")
    with pytest.raises(vf.VFWidgetError, match=r"must be a list, .* received a generator. Pass"):
        use(text, (one for one in [SQUARE]))
    with pytest.raises(vf.VFWidgetError, match=r"obstacles\[0\] must be a list, .* received a map"):
        use(text, [map(np.asarray, [polygon(np.array(SQUARE))])])
