"""The area that two shapes have in common against pyclipper and shapely, and its derivative."""

from __future__ import annotations

import numpy as np
import pyclipper
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

import vfwidget as vf
from vfwidget.outline import crossings
from vfwidget.outline.monotone import coefficients, evaluate, evaluate_slope
from vfwidget.overlap.common_area import common_area, pairs_nearby
from vfwidget.overlap.shape import Shape, letters, polygon
from vfwidget.overlap.shortened import shortened

checked = settings(deadline=None, derandomize=True, max_examples=60)
CHORDS = 256
UNIT = 2**20
"""pyclipper computes with integers: parts of a font unit."""
LETTERS = "AaBegNTRoO&8sSx%"


def flattened(shape, chords):
    """The contours of a shape as polygons of many chords."""
    t = np.arange(chords) / chords
    u = 1 - t
    weights = np.stack([u**3, 3 * u * u * t, 3 * u * t * t, t**3], -1)
    points = np.einsum("tj,sjd->std", weights, shape.segments)
    return [c.reshape(-1, 2) for c in np.split(points, np.cumsum(shape.sizes)[:-1])]


def by_clipper(first, second, chords=CHORDS):
    """The common area of two shapes, filled nonzero, by pyclipper."""
    unions = []
    for shape in (first, second):
        clipper = pyclipper.Pyclipper()
        outline = flattened(shape, chords)
        paths = [(UNIT * contour).round().astype(np.int64).tolist() for contour in outline]
        # pyclipper refuses contours whose points lie on one line.
        paths = [path for path in paths if pyclipper.Area(path)]
        if not paths:
            return 0.0
        clipper.AddPaths(paths, pyclipper.PT_SUBJECT, True)
        fill = pyclipper.PFT_NONZERO
        unions.append(clipper.Execute(pyclipper.CT_UNION, fill, fill))
    if not all(unions):
        return 0.0
    clipper = pyclipper.Pyclipper()
    clipper.AddPaths(unions[0], pyclipper.PT_SUBJECT, True)
    clipper.AddPaths(unions[1], pyclipper.PT_CLIP, True)
    common = clipper.Execute(pyclipper.CT_INTERSECTION, fill, fill)
    return sum(pyclipper.Area(path) for path in common) / UNIT**2


def box(x, y, width, height):
    corners = np.array([(x, y), (x + width, y), (x + width, y + height), (x, y + height)], float)
    return Shape(polygon(corners), [4])


def moved(shape, shift):
    return Shape(shape.segments + shift, shape.sizes)


def area(first, second):
    return float(common_area([(first, second)]).area[0])


def two_letters(font, string, rng):
    """Two letters at a random place, the second pushed into the first."""
    text = vf.Text(font, string)
    text = text.at(theta=rng.uniform(*text.font.bounds)[None])
    first, second = letters(text)
    (left, _), (right, top) = first.box
    x = left + rng.uniform(0.2, 0.8) * (right - left) - second.box[0, 0]
    y = rng.choice([0.0, rng.uniform(-0.1, 0.1) * top])
    return first, moved(second, np.array([x, y]))


@pytest.mark.parametrize("name", vf.bundled_fonts())
@pytest.mark.parametrize("string", ["NT", "oe", "a&", "8%"])
def test_the_common_area_of_letters_is_that_of_clipper(name, string):
    first, second = two_letters(name, string, np.random.default_rng(len(name)))
    assert area(first, second) == pytest.approx(by_clipper(first, second), rel=1e-5, abs=1e-2)


@pytest.mark.slow
@pytest.mark.parametrize("name", vf.bundled_fonts())
def test_the_common_area_of_all_pairs_of_letters_is_that_of_clipper(name):
    rng, font = np.random.default_rng(7), vf.load_font(name)
    for one in LETTERS:
        for other in LETTERS:
            first, second = two_letters(font, one + other, rng)
            got = area(first, second)
            if got != pytest.approx(by_clipper(first, second), rel=1e-5, abs=1e-2):
                # The chords of the referee may be too coarse for a small common area.
                fine = by_clipper(first, second, 16 * CHORDS)
                assert got == pytest.approx(fine, rel=1e-5, abs=1e-2)


corner = st.tuples(*[st.integers(-20, 20)] * 2)


@checked
@given(*[st.lists(corner, min_size=3, max_size=7, unique=True)] * 2)
def test_the_common_area_of_polygons_is_that_of_shapely(one, other):
    # Corners on a small grid: many edges coincide, and many corners lie on edges.
    first, second = (Shape(polygon(np.array(p, float)), [len(p)]) for p in (one, other))
    polygons = [shapely.Polygon(p) for p in (one, other)]
    if all(p.is_valid for p in polygons):
        want = polygons[0].intersection(polygons[1]).area
        assert area(first, second) == pytest.approx(want, rel=1e-9, abs=1e-9)
    elif min(first.area(), second.area()) > 0:
        assert area(first, second) == pytest.approx(by_clipper(first, second), rel=1e-5, abs=1e-4)


@pytest.mark.parametrize("gap", [0, 1e-12, 1e-9, 1e-6, 1e-3])
def test_edges_that_nearly_coincide(gap):
    first = box(0, 0, 40, 700)
    for second, want in (
        (box(40 + gap, 0, 30, 700), 0.0),
        (box(40 - gap, 0, 30, 700), 700 * gap),
        (box(-gap, gap, 40, 700), (40 - gap) * (700 - gap)),
        (box(10, gap, 10, 700 - 2 * gap), 10 * (700 - 2 * gap)),
    ):
        assert area(first, second) == pytest.approx(want, rel=1e-9, abs=1e-9)


def test_lenses_however_thin():
    # Two circles of radius 100, whose arcs bulge into each other.
    way = 4 / 3 * np.tan(np.pi / 8)
    out = 100 * np.array([[1.0, 0], [0, 1], [-1, 0], [0, -1]])
    end = np.roll(out, -1, 0)
    circle = Shape(np.stack([out, out + way * end, end + way * out, end], 1), [4])
    for depth in (10.0, 1.0, 1e-2, 1e-4):
        got = area(circle, moved(circle, (200 - depth, 0)))
        # The lens of two parabolas with the curvature of this circle's cubic at its end.
        handle = 100 * way
        curvature = 2 / 3 * (100 - handle) / handle**2
        want = 4 / 3 * depth * np.sqrt(depth / curvature)
        assert got == pytest.approx(want, rel=0.02 + depth / 100)


def ellipse_through_origin(rng):
    """An ellipse that passes through the origin, the normal outwards there, and the curvature."""
    ends = np.array([[1.0, 0], [0, 1], [-1, 0], [0, -1]])
    after, way = np.roll(ends, -1, 0), 4 / 3 * np.tan(np.pi / 8)
    circle = np.stack([ends, ends + way * after, after + way * ends, after], 1)
    segments = circle * rng.uniform(30, 300, 2) @ turn(rng.uniform(0, 2 * np.pi))
    curve, t = coefficients(segments[:1]), rng.uniform(0.05, 0.95, 1)
    (x, y), bend = evaluate_slope(curve, t)[:, 0], (2 * curve[2] + 6 * curve[3] * t)[:, 0]
    speed = np.hypot(x, y)
    curvature = abs(x * bend[1] - y * bend[0]) / speed**3
    return segments - evaluate(curve, t)[:, 0], np.array([y, -x]) / speed, curvature


def turn(angle):
    """The matrix that turns row vectors counterclockwise."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, s], [-s, c]])


@pytest.mark.parametrize("seed", range(6))
def test_lenses_of_ellipses_are_found_anywhere_on_their_outlines(seed):
    rng = np.random.default_rng(seed)
    for depth in 10 ** rng.uniform(-4, 0, 40):
        first, out, curvature = ellipse_through_origin(rng)
        second, normal, other = ellipse_through_origin(rng)
        second = second @ turn(np.arctan2(*-out[::-1]) - np.arctan2(*normal[::-1]))
        got = area(Shape(first, [4]), Shape(second - depth * out, [4]))
        # The lens of two parabolas.
        want = 4 / 3 * depth * np.sqrt(2 * depth / (curvature + other))
        assert got == pytest.approx(want, rel=0.1)


def test_a_shape_inside_another_and_holes():
    outer, inner = box(0, 0, 100, 100), box(20, 30, 10, 10)
    assert area(outer, inner) == area(inner, outer) == pytest.approx(100)
    # A ring: the inner contour has the opposite direction.
    hole = box(10, 10, 80, 80).segments[::-1, ::-1]
    ring = Shape(np.concatenate([outer.segments, hole]), [4, 4])
    assert area(ring, inner) == 0
    # Contours of one direction that overlap count once.
    twice = Shape(np.concatenate([inner.segments, inner.segments]), [4, 4])
    assert area(outer, twice) == pytest.approx(100)


@pytest.mark.parametrize("name", vf.bundled_fonts())
def test_never_negative_beside_kinks(name):
    text = vf.Text(name, "NH")
    size = text.font.units_per_em
    for axis, breakpoints in enumerate(text.breakpoints):
        for kink in breakpoints:
            areas = []
            for step in (-1e-8, 0.0, 1e-8):
                theta = np.zeros((1, len(text.font.axes)))
                theta[0, axis] = np.clip(kink + step, -1, 1)
                first, second = letters(text.at(theta=theta))
                areas.append(area(first, moved(second, (-0.3 * size, 0))))
            assert min(areas) >= 0
            assert np.ptp(areas) <= 1e-5 * max(areas) + 1e-3


@pytest.mark.parametrize("name", vf.bundled_fonts())
@pytest.mark.parametrize("string", ["NT", "ae", "g&"])
def test_gradient_is_the_difference_of_areas(name, string):
    rng = np.random.default_rng(3)
    first, second = two_letters(name, string, rng)
    # Vertical edges of both letters may coincide by chance only.
    second = moved(second, (0.137, 0.241))
    common = common_area([(first, second)])
    assert common.area[0] > 0
    gradient = common.gradient()
    for _ in range(3):
        # A smooth motion keeps contours closed.
        moves = [rng.normal(size=(2, 6)) for _ in range(2)]

        def deform(shape, move, step):
            x, y = shape.segments[..., 0] / 500, shape.segments[..., 1] / 500
            basis = np.stack([np.ones_like(x), x, y, x * y, np.sin(x), np.cos(y)], -1)
            return step * basis @ move.T

        got = 0.0
        for layer, (shape, move) in enumerate(zip((first, second), moves, strict=True)):
            of = common.layer == layer
            got += (gradient[of] * deform(shape, move, 1.0)[common.segment[of]]).sum()
        h = 1e-3
        both = []
        for step in (h, -h):
            shapes = [
                Shape(shape.segments + deform(shape, move, step), shape.sizes)
                for shape, move in zip((first, second), moves, strict=True)
            ]
            both.append(area(*shapes))
        scale = abs(gradient).sum()
        assert got == pytest.approx((both[0] - both[1]) / (2 * h), rel=1e-6, abs=1e-7 * scale)


def test_a_long_line_has_few_pairs():
    shapes = letters(vf.Text("recursive", "variable" * 10))
    boxes = np.array([shape.box for shape in shapes])
    pairs = pairs_nearby(boxes, len(boxes), gap=20)
    assert len(pairs) <= 2 * len(shapes)
    assert (np.diff(pairs, axis=1) >= 1).all()
    want = {
        (i, j)
        for i in range(len(shapes))
        for j in range(i + 1, len(shapes))
        if (boxes[i, 0] - 20 < boxes[j, 1]).all() and (boxes[j, 0] - 20 < boxes[i, 1]).all()
    }
    assert {tuple(pair) for pair in pairs.tolist()} == want


def test_many_pairs_at_once_are_the_pairs_by_themselves():
    line = letters(vf.Text("dynapuff", "variable"))
    shapes = [moved(shape, (-220.0 * i, 0)) for i, shape in enumerate(line)]
    pairs = pairs_nearby(np.array([shape.box for shape in shapes]), len(shapes))
    together = common_area([(shapes[i], shapes[j]) for i, j in pairs]).area
    alone = [area(shapes[i], shapes[j]) for i, j in pairs]
    np.testing.assert_allclose(together, alone, rtol=1e-9, atol=1e-9)
    assert len(pairs) > 5 and together.max() > 100


def test_a_lens_between_two_heights_at_which_curves_are_compared():
    # Parts of an "e" and a "g": the curves cross twice within a tenth of their height.
    one = np.array([(423.5, 434.1), (423.5, 391.8), (415.2, 355.2), (398.7, 324.4)])
    other = np.array([(433.4, 448.1), (422.2, 420.3), (416.6, 378.2), (416.6, 321.9)])

    def closed(curve, x):
        corners = np.array([curve[3], (x, curve[3, 1]), (x, curve[0, 1]), curve[0]])
        return Shape(np.concatenate([curve[None], polygon(corners)[:3]]), [4])

    lens = area(closed(one, 300), closed(other, 600))
    assert lens == pytest.approx(by_clipper(closed(one, 300), closed(other, 600)), abs=3e-3)
    assert lens > 2


def tangled(seed):
    """One contour of two to seven wild curves, which cross one another and themselves."""
    rng = np.random.default_rng(seed)
    count = rng.integers(2, 8)
    angles = np.sort(rng.uniform(0, 2 * np.pi, count))
    corners = np.stack([np.cos(angles), np.sin(angles)], 1) * rng.uniform(0.5, 1, (count, 1))
    curves = []
    for start, end in zip(corners, np.roll(corners, -1, 0), strict=True):
        bend = rng.normal(0, 0.35, (2, 2))
        inner = [start + (end - start) / 3 + bend[0], start + 2 * (end - start) / 3 + bend[1]]
        curves.append([start, *inner, end])
    return 1000 * np.array(curves)


@pytest.mark.parametrize(
    ("seed", "angle"), [(50240, 0.9), (50299, 0.35), (50354, 0.35), (50574, 2.6), (50580, 1.7)]
)
def test_lenses_of_outlines_that_cross_themselves(seed, angle):
    """Each has a small lens near another crossing, or near the point at which curves join."""
    turned = Shape(tangled(seed) @ turn(angle), [len(tangled(seed))])
    assert area(turned, turned) == pytest.approx(by_clipper(turned, turned), rel=1e-4)


@pytest.mark.parametrize("turn", range(4))
def test_what_lies_beyond_a_side_of_the_other_box_is_one_chord(turn):
    quarter = np.linalg.matrix_power(np.array([[0.0, 1], [-1, 0]]), turn)
    angles = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    ring = np.stack([np.cos(angles), np.sin(angles)], 1) * 100
    disc = Shape(np.concatenate([polygon(ring), polygon(0.9 * ring[::-1])]) @ quarter, [40, 40])
    beam = Shape(box(80, -5, 200, 10).segments @ quarter, [4])
    outlines, _ = shortened([(disc, beam)])
    assert len(outlines.segment) < 20
    assert area(disc, beam) == pytest.approx(by_clipper(disc, beam, 1), abs=1e-3)
    # A contour around a shape keeps its winding number there.
    spot = Shape(box(-5, -5, 10, 10).segments @ quarter, [4])
    assert area(Shape(disc.segments[:40], [40]), spot) == pytest.approx(100, abs=1e-6)
    assert area(disc, spot) == pytest.approx(0, abs=1e-6)


@pytest.mark.parametrize("depth", [1e-9, 1e-6, 1e-3, 1.0])
def test_outlines_that_touch_take_few_evaluations(depth, monkeypatch):
    """A bar that touches a disc meets it in two places next to each other, or nowhere."""
    r, k = 100.0, 400 / 3 * (np.sqrt(2) - 1)
    quarter = np.array([(r, 0), (r, k), (k, r), (0, r)])
    turns = [
        np.array([[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]])
        for a in np.pi / 2 * np.arange(4)
    ]
    disc = Shape(np.stack([quarter @ turn for turn in turns]), [4])
    counted, gaps = [], crossings._gaps
    monkeypatch.setattr(crossings, "_gaps", lambda *a: counted.append(0) or gaps(*a))
    bar = box(-300, r - depth, 600, 50)
    expected = 4 / 3 * depth * np.sqrt(2 * r * depth)
    assert area(disc, bar) == pytest.approx(expected, rel=0.03, abs=1e-6)
    assert len(counted) <= 30
