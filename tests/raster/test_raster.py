"""Coverage against scanlines, above all where contours cross, touch and coincide; its gradient."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import numpy as np
import pytest
import scan as referee
import torch
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scan import scan
from torch.autograd import forward_ad

import vfwidget as vf
from vfwidget.outline.contours import Contours
from vfwidget.raster import frame, image_and_jacobian
from vfwidget.raster.coverage import fill

checked = settings(deadline=None, derandomize=True, max_examples=100)
few = settings(deadline=None, derandomize=True, max_examples=30)
SIZE = (12, 14)
NEAR = 0.05
"""The referee's own error where curves are steep: it has 64 lines a pixel and 64 chords a cubic."""
STEP = 1e-6
REFERENCE = Path(os.environ.get("VFWIDGET_DIFFVG_IMAGES", "unset"))
"""An archive of outlines and of what diffvg makes of them."""

wild = st.floats(-4, 18, allow_nan=False).map(lambda x: round(x, 3))
halves = st.integers(-6, 34).map(lambda i: i / 2)


def contours(coordinate, most=4):
    """Lists of closed contours of one to five cubics, as (s, 4, 2) arrays."""
    point = st.tuples(coordinate, coordinate)
    one = st.integers(1, 5).flatmap(
        lambda s: st.lists(point, min_size=3 * s, max_size=3 * s).map(
            lambda points: np.array(points)[Contours([s]).segments]
        )
    )
    return st.lists(one, min_size=1, max_size=most)


def lines(*corners):
    """A polygon's sides as cubics, (s, 4, 2)."""
    begin = np.array(corners, dtype=float)
    end = np.roll(begin, -1, 0)
    return np.stack([begin, begin + (end - begin) / 3, begin + (end - begin) * 2 / 3, end], 1)


def rectangle(x, y, width, height):
    return lines((x, y), (x + width, y), (x + width, y + height), (x, y + height))


def reverse(contour):
    return contour[::-1, ::-1].copy()


def shape(cubic, *corners):
    """What a cubic and the way back from its end by these corners enclose."""
    return np.concatenate([[cubic], lines(cubic[3], *corners, cubic[0])[:-1]])


def blob(x, y, radii, turn=0.0):
    """A smooth contour around (x, y) through a point at each of these distances."""
    count = len(radii)
    angle = turn + 2 * np.pi * np.arange(count) / count
    out = np.stack([np.cos(angle), np.sin(angle)], -1) * np.asarray(radii)[:, None]
    way = 4 / 3 * np.tan(np.pi / (2 * count)) * np.stack([-out[:, 1], out[:, 0]], -1)
    begin = out + np.array([x, y])
    end, back = np.roll(begin, -1, 0), np.roll(way, -1, 0)
    return np.stack([begin, begin + way, end - back, end], 1)


blobs = st.lists(
    st.builds(
        blob,
        st.floats(-2, 16),
        st.floats(-2, 14),
        st.lists(st.floats(2, 7), min_size=3, max_size=6),
        st.floats(0, 6),
    ),
    min_size=1,
    max_size=3,
)
"""Contours whose features are larger than a pixel."""


def image_of(segments, size=SIZE, **options):
    return vf.rasterize(segments, size, **options).numpy()


def misses(segments, size=SIZE):
    """The largest error of a pixel, the referee looking closely where it is large."""
    image = image_of(segments, size)
    assert image.shape == tuple(size)
    error = abs(image - scan(segments, *size))
    if error.max() > 0.02:
        chords, referee.CHORDS = referee.CHORDS, 512
        try:
            error = abs(image - scan(segments, *size, lines=512))
        finally:
            referee.CHORDS = chords
    return error.max()


def placed(text, size):
    """A text's contours in pixels."""
    placement = frame(text, size).numpy()
    return [s.numpy() @ placement[:, :2].T + placement[:, 2] for s in text.segments()]


def somewhere(name, letter, seed=0):
    """A letter at a random place of its font's design space, and not on an axis' kink."""
    text = vf.Text(name, letter)
    rng = np.random.default_rng([seed, ord(letter)])
    return text.at(theta=rng.uniform(*text.font.bounds)[None])


# Found wrong, all of them minimal; each is wrong by far more than the referee can be.
CASES = {
    # The chords cross between other pieces than the arcs, with a turn in between: Newton's method
    # stops at a piece's end, the two arcs are cut at different places, and a row stays open.
    "arcs cross beyond the pieces whose chords do": (
        [
            shape(
                np.array([(2.43, -1.5), (1.13, 0.93), (0.13, 1.23), (0.93, 4.5)]), (-3, 5), (-3, -3)
            ),
            shape(
                np.array([(1.93, -1.5), (0.83, 0.73), (0.73, 2.13), (0.13, 4.5)]), (8, 5), (8, -3)
            ),
        ],
        (3, 4),
    ),
    "arcs cross beyond the pieces, again": (
        [
            shape(
                np.array([(2.53, -1.5), (0.83, 0.93), (1.43, 2.03), (1.83, 4.5)]), (-3, 5), (-3, -3)
            ),
            shape(
                np.array([(2.43, -1.5), (1.53, 0.13), (1.23, 1.93), (0.13, 4.5)]), (8, 5), (8, -3)
            ),
        ],
        (3, 4),
    ),
    # One passage through a pixel crosses itself: both sides of the crossing are one run.
    "a contour crosses itself within a pixel": (
        [
            np.array(
                [
                    [(3.43, 1.63), (3.33, 0.83), (0.13, 1.13), (1.83, 0.03)],
                    [(1.83, 0.03), (0.73, 1.83), (-0.17, 2.03), (3.43, 1.63)],
                ]
            )
        ],
        (3, 4),
    ),
    "a bow tie within a pixel": ([lines((0.1, 0.1), (0.9, 0.9), (0.9, 0.1), (0.1, 0.9))], (1, 2)),
    # The crossing lies on the corner of four pixels, and the two share none of them.
    "edges cross on a pixel's corner": (
        [lines((1, 1), (3, 3), (3, 0.75)), lines((3, 1), (1, 3), (3, 2.5))],
        (4, 5),
    ),
    # What ends on the border does so in the pixel to the left, and the edge along the border is
    # the right one's: its run is not broken there, nor where two edges begin to coincide.
    "a side ends on a side along a pixel border": (
        [reverse(rectangle(0.5, 1.5, 0.5, 0.5)), rectangle(1, 1, 0.5, 1.5)],
        (4, 4),
    ),
    "a small rectangle in a large one's corner": (
        [rectangle(0.5, 1, 0.5, 1.5), reverse(rectangle(0.5, 1, 0.5, 0.5))],
        (4, 4),
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_crossings_that_are_hard(name):
    segments, size = CASES[name]
    assert misses(segments, size) < 0.02


@pytest.mark.parametrize(
    "name, letter, theta",
    [
        ("recursive", "W", [0.889, 0.916, 0.574, -0.89, -0.482]),
        ("recursive", "A", [0.054, 0.782, 0.224, -0.664, -0.933]),
        ("dynapuff", "t", [0.825, -0.567]),
        ("shantell-sans", "w", [0.572, 0.734, -0.945, 0.664]),
    ],
)
def test_letters_of_32_pixels(name, letter, theta):
    text = vf.Text(name, letter).at(theta=[theta])
    assert misses(placed(text, (32, 32)), (32, 32)) < NEAR


@checked
@given(contours(wild))
def test_any_contours(segments):
    assert misses(segments) < NEAR


@checked
@given(blobs)
def test_contours_larger_than_a_pixel(segments):
    assert misses(segments) < NEAR


@checked
@given(contours(halves))
def test_contours_on_a_grid_of_half_pixels(segments):
    assert misses(segments) < NEAR


@checked
@given(
    st.lists(
        st.tuples(halves, halves, *[st.integers(1, 16)] * 2, st.booleans()), min_size=2, max_size=5
    )
)
def test_rectangles_that_touch_and_coincide(drawn):
    segments = []
    for x, y, width, height, turned in drawn:
        one = rectangle(x, y, width / 2, height / 2)
        segments.append(reverse(one) if turned else one)
    assert misses(segments) < 0.02


def close_to_scanlines(name, letter):
    segments = placed(somewhere(name, letter), (256, 256))
    error = abs(image_of(segments, (256, 256)) - scan(segments, 256, 256))
    assert error.mean() <= 2e-4
    assert error.max() <= 0.05


@pytest.mark.parametrize("name", vf.bundled_fonts())
def test_letters(name):
    close_to_scanlines(name, "R")


@pytest.mark.slow
@pytest.mark.parametrize("letter", "AQRSWXagkt48&@$%éöß§")
@pytest.mark.parametrize("name", vf.bundled_fonts())
def test_a_hundred_letters(name, letter):
    close_to_scanlines(name, letter)


# Edges that coincide, or nearly do.

DISTANCES = [10.0**-k for k in range(3, 13)]
KINDS = (np.float64, np.float32, torch.float64, torch.float32)


def turned(segments, angle):
    """Contours turned about the middle of the image."""
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return [(s - (7, 6)) @ turn.T + (7, 6) for s in segments]


def nearly_one_edge(distance, rng):
    """Pairs of contours whose edges lie about this far from each other."""
    round_one = blob(7, 6, rng.uniform(2, 5, 4), rng.uniform(0, 6))
    shift = distance * rng.normal(size=2)
    yield [rectangle(2.3, 2.1, 4, 6), rectangle(6.3 + shift[0], 2.1 + shift[1], 4, 6)]
    yield [rectangle(2.3, 2.1, 4, 6), reverse(rectangle(4.3, 2.1 + shift[0], 5, 6))]
    yield [round_one, round_one + shift]
    yield [round_one, reverse(round_one) + shift]
    yield [round_one, round_one * (1 + distance)]


@pytest.mark.parametrize("kind", KINDS, ids=str)
@pytest.mark.parametrize("distance", DISTANCES)
def test_edges_that_nearly_coincide(distance, kind):
    rng = np.random.default_rng(round(-np.log10(distance)))
    for segments in nearly_one_edge(distance, rng):
        for angle in (0.0, rng.uniform(0, 6)):
            if isinstance(kind, torch.dtype):
                given = [torch.tensor(s, dtype=kind) for s in turned(segments, angle)]
                points = torch.cat(given)[None].double()
                image = fill(points, [len(s) for s in given], *SIZE)[0][0].numpy()
                seen = [s.numpy() for s in given]
            else:
                seen = [s.astype(kind) for s in turned(segments, angle)]
                image = image_of(seen)
            assert abs(image - scan(seen, *SIZE)).max() < NEAR


@pytest.mark.parametrize("name", ["recursive", "roboto-flex"])
def test_letters_in_single_precision_turned(name):
    text = vf.Text(name, "NHg@")
    for angle in np.linspace(0, 3, 5):
        turn = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
        contours = [s.numpy() / 100 @ np.transpose(turn) + (14, 14) for s in text.segments()]
        contours = [torch.tensor(s, dtype=torch.float32) for s in contours]
        # The same contours twice: all edges coincide.
        single = vf.rasterize(contours, (40, 40))
        torch.testing.assert_close(vf.rasterize(contours * 2, (40, 40)), single, rtol=0, atol=1e-5)
        error = abs(single.double().numpy() - scan([s.numpy() for s in contours], 40, 40))
        assert error.max() < NEAR


def test_curves_that_coincide_are_not_cut_again_and_again():
    contour = blob(7.1, 6.2, [4, 3, 5, 4])
    counts = []
    for shift in (0, 1e-13, 1e-10):
        segments = np.concatenate([contour, contour + shift])[None]
        counts.append(len(fill(segments, [4, 4], *SIZE)[1].cubic))
    single = len(fill(contour[None], [4], *SIZE)[1].cubic)
    assert max(counts) <= 2 * single + 16


# What must hold whatever the contours.


@few
@given(blobs)
def test_a_window_sees_what_a_larger_image_has_there(segments):
    height, width = SIZE
    whole = image_of([s + 16 for s in segments], (48, 48))
    np.testing.assert_allclose(
        image_of(segments), whole[16 : 16 + height, 16 : 16 + width], rtol=0, atol=1e-9
    )


@few
@given(blobs, st.randoms(use_true_random=False))
def test_order_start_and_direction_do_not_matter(segments, random):
    want = image_of(segments)
    others = [np.roll(s, random.randrange(9), 0) for s in segments]
    random.shuffle(others)
    np.testing.assert_allclose(image_of(others), want, rtol=0, atol=1e-9)
    others = [reverse(s) for s in segments]
    np.testing.assert_allclose(image_of(others), want, rtol=0, atol=1e-9)


@few
@given(blobs)
def test_segments_of_no_length_change_nothing(segments):
    others = [np.concatenate([s[:1], np.tile(s[0, 3], (2, 4, 1)), s[1:]]) for s in segments]
    np.testing.assert_allclose(image_of(others), image_of(segments), rtol=0, atol=1e-9)


@few
@given(st.lists(st.floats(2, 6), min_size=3, max_size=6), st.floats(0, 6))
def test_pixels_sum_to_the_area(radii, turn):
    contour = blob(9.3, 8.6, radii, turn)
    # ½ ∮ x dy − y dx, by Gauss: exact for a polynomial of degree 5.
    t, weight = np.polynomial.legendre.leggauss(3)
    t, weight = (t + 1) / 2, weight / 2
    basis = np.stack([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3], -1)
    slope = 3 * np.stack([(1 - t) ** 2, 2 * t * (1 - t), t**2], -1)
    x, y = np.moveaxis(basis @ contour, -1, 0)
    dx, dy = np.moveaxis(slope @ np.diff(contour, axis=1), -1, 0)
    area = ((x * dy - y * dx) / 2 @ weight).sum()
    assert image_of([contour], (18, 19)).sum() == pytest.approx(area, rel=1e-9)


def test_union_of_two_rectangles_is_counted_once():
    segments = [rectangle(1.25, 2.5, 6, 4), reverse(rectangle(3.5, 1.75, 2, 8))]
    # Of opposite direction they cancel where they overlap: nonzero fill of 1 − 1.
    assert image_of(segments).sum() == pytest.approx(24 + 16 - 2 * 8, rel=1e-9)
    segments[1] = reverse(segments[1])
    assert image_of(segments).sum() == pytest.approx(24 + 16 - 8, rel=1e-9)


def test_edges_on_pixel_borders():
    want = np.zeros(SIZE)
    want[2:7, 3:9] = 1
    np.testing.assert_allclose(image_of([rectangle(3, 2, 6, 5)]), want, rtol=0, atol=1e-9)
    # Another beside it, and one upon it.
    segments = [rectangle(3, 2, 3, 5), rectangle(6, 2, 3, 5), rectangle(3, 2, 6, 5)]
    np.testing.assert_allclose(image_of(segments), want, rtol=0, atol=1e-9)
    np.testing.assert_allclose(image_of([rectangle(0, 0, 14, 12)]), 1, rtol=0, atol=1e-9)


@pytest.mark.parametrize("x, y", [(-9, 3), (17, 3), (3, -9), (3, 15), (-9, -9), (17, 15)])
def test_contours_beside_the_image(x, y):
    assert abs(image_of([blob(x, y, [2, 2, 2, 2])])).max() < 1e-12


def test_huge_and_tiny_contours():
    np.testing.assert_allclose(image_of([blob(3e5, 2e5, [1e6] * 4)]), 1, rtol=0, atol=1e-6)
    edge = image_of([rectangle(4.25, -1e6, 1e6, 2e6)])
    np.testing.assert_allclose(edge[:, 3:6], [[0, 0.75, 1]] * 12, rtol=0, atol=1e-6)
    tiny = image_of([rectangle(4.25, 3.25, 1e-4, 1e-4)])
    assert tiny[3, 4] == pytest.approx(1e-8, rel=1e-3)
    assert tiny.sum() == pytest.approx(tiny[3, 4], rel=1e-3)


def test_nothing_to_draw():
    for nothing in (vf.Text("recursive", " "), [], [np.zeros((0, 4, 2))]):
        image = vf.rasterize(nothing, (5, 7))
        assert image.shape == (5, 7) and image.dtype == torch.float64
        assert not image.any()


def batch_of(count=3):
    """The same two contours, at several places: (count, s, 4, 2) each, and as a list of singles."""
    shifts = np.random.default_rng(0).uniform(-3, 3, (count, 1, 1, 2))
    whole = [blob(5.3, 6.1, [3, 4, 5]) + shifts, blob(8.7, 5.2, [4, 3, 3, 4]) - shifts]
    return whole, [[contour[i] for contour in whole] for i in range(count)]


def test_a_batch_is_its_images():
    whole, singles = batch_of()
    image = image_of(whole)
    np.testing.assert_allclose(image, [image_of(one) for one in singles], rtol=0, atol=1e-12)
    deeper = [contour[None] for contour in whole]
    np.testing.assert_array_equal(image_of(deeper), image[None])
    tensors = [torch.tensor(contour, requires_grad=True) for contour in whole]
    vf.rasterize(tensors, SIZE).square().sum().backward()
    for i, one in enumerate(singles):
        alone = [torch.tensor(contour, requires_grad=True) for contour in one]
        vf.rasterize(alone, SIZE).square().sum().backward()
        for tensor, contour in zip(tensors, alone, strict=True):
            np.testing.assert_allclose(tensor.grad[i], contour.grad, rtol=0, atol=1e-10)


TURNED = np.array([[0.8, -0.3, 1.3], [0.4, 0.7, -0.6]])


def test_a_transform_places():
    whole, singles = batch_of()
    moved = [contour @ TURNED[:, :2].T + TURNED[:, 2] for contour in singles[0]]
    got = image_of(singles[0], transform=TURNED)
    np.testing.assert_allclose(got, image_of(moved), rtol=0, atol=1e-9)
    # Several placements of one shape, and one of each.
    several = np.stack([TURNED, TURNED + 0.1, TURNED - 0.1])
    for shape, ones in ((singles[0], [singles[0]] * 3), (whole, singles)):
        got = image_of(shape, transform=several)
        want = [image_of(one, transform=t) for one, t in zip(ones, several, strict=True)]
        np.testing.assert_allclose(got, want, rtol=0, atol=1e-9)


def test_a_text_is_framed_unless_it_is_placed():
    text = vf.Text("recursive", "ag")
    image = image_of(text, (40, 60))
    np.testing.assert_array_equal(image, image_of(text, (40, 60), transform=frame(text, (40, 60))))
    np.testing.assert_allclose(image, image_of(placed(text, (40, 60)), (40, 60)), rtol=0, atol=1e-9)
    image[3:-3, 4:-4] = 0
    assert image.max() < 1e-9


def test_float32_stays():
    contour = torch.tensor(blob(6, 5, [4, 3, 5]), dtype=torch.float32, requires_grad=True)
    image = vf.rasterize([contour], SIZE)
    image.sum().backward()
    assert image.dtype == contour.grad.dtype == torch.float32
    want = image_of([contour.detach().double()])
    np.testing.assert_allclose(image.detach(), want, rtol=0, atol=1e-6)


# Gradients.


def crossing():
    """Two convex contours that overlap, and how their control points are moved: (2, 4, 4, 2)."""
    pair = np.stack([blob(3.6, 3.9, [2.9] * 4, 0.3), blob(5.2, 4.7, [2.4] * 4, 0.9)])
    moves = np.random.default_rng(3).normal(size=pair.shape)
    moves[:, :, 3] = np.roll(moves[:, :, 0], -1, 1)
    return pair, moves


def slope_of(segments, weight):
    """What Σ weight · coverage is by the control points."""
    tensors = [torch.tensor(s, requires_grad=True) for s in segments]
    (torch.tensor(weight) * vf.rasterize(tensors, weight.shape)).sum().backward()
    return [tensor.grad.numpy() for tensor in tensors]


def agrees_with_differences(segments, weight, rtol=1e-5):
    """Whether each control point's slope is the difference of exact areas."""
    slopes = slope_of(segments, weight)
    scale = max(abs(slope).max() for slope in slopes)
    for contour, slope in enumerate(slopes):
        for index in np.ndindex(len(slope), 3, 2):
            sums = []
            for step in (STEP, -STEP):
                moved = [s.copy() for s in segments]
                moved[contour][index] += step
                if index[1] == 0:
                    # A contour stays closed; the end of the one before it is as good as its own.
                    moved[contour][index[0] - 1, 3, index[2]] += step
                sums.append((weight * image_of(moved, weight.shape)).sum())
            want = (sums[0] - sums[1]) / (2 * STEP)
            got = slope[index]
            if index[1] == 0:
                got = got + slope[index[0] - 1, 3, index[2]]
            assert abs(got - want) < rtol * scale


def test_gradient_is_the_difference_of_exact_areas():
    weight = np.random.default_rng(0).normal(size=(9, 10))
    agrees_with_differences(list(crossing()[0]), weight)
    agrees_with_differences([blob(1.3, 4.2, [4.1, 3, 5]), blob(7.1, 8.2, [3, 2.2, 4])], weight)


@few
@given(blobs, st.integers(0, 99))
def test_derivative_is_the_difference_of_exact_areas(segments, seed):
    # Where a contour lies upon another one, the two sides of the slope differ.
    shapes = {np.asarray(s).tobytes() for s in segments}
    assume(len(shapes) == len(segments))
    # On a pixel's border there is no slope to compare, and there round numbers lie.
    segments = [s + np.array([0.1372, 0.2419]) for s in segments]
    rng = np.random.default_rng(seed)
    weight, moves = rng.normal(size=SIZE), []
    for s in segments:
        move = rng.normal(size=s.shape)
        move[:, 3] = np.roll(move[:, 0], -1, 0)
        moves.append(move)
    slopes = slope_of(segments, weight)
    got = sum((slope * move).sum() for slope, move in zip(slopes, moves, strict=True))
    both = [
        image_of([s + step * move for s, move in zip(segments, moves, strict=True)])
        for step in (STEP, -STEP)
    ]
    want = (weight * (both[0] - both[1])).sum() / (2 * STEP)
    scale = sum(abs(slope * move).sum() for slope, move in zip(slopes, moves, strict=True))
    assert abs(got - want) <= 1e-5 * scale + 1e-6


def flatten(contour, chords=256):
    t = (np.arange(chords) / chords)[:, None]
    weights = np.concatenate([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3], 1)
    return np.einsum("tj,sjd->std", weights, contour).reshape(-1, 2)


def clip(polygon, point, way):
    """The part (n, 2) of a polygon on the left of a line: Sutherland and Hodgman's."""
    if not len(polygon):
        return polygon
    side = (polygon - point) @ (-way[1], way[0])
    following, beyond = np.roll(polygon, -1, 0), np.roll(side, -1)
    crosses = (side >= 0) != (beyond >= 0)
    part = side / np.where(crosses, side - beyond, 1.0)
    both = np.stack([polygon, polygon + part[:, None] * (following - polygon)], 1)
    return both[np.stack([side >= 0, crosses], 1)]


def area(polygon):
    if not len(polygon):
        return 0.0
    x, y = (polygon - polygon[0]).T
    return (x * np.roll(y, -1) - y * np.roll(x, -1)).sum() / 2


def union_by_clipping(pair, size):
    """Coverage of two convex contours, from their chords: areas of A, of B, less that of both."""
    one, other = (flatten(contour) for contour in pair)
    both = one
    for point, end in zip(other, np.roll(other, -1, 0), strict=True):
        both = clip(both, point, end - point)
    image = np.zeros(size)
    for polygon, sign in ((one, 1), (other, 1), (both, -1)):
        for row in range(size[0]):
            band = clip(polygon, (0, row), (1, 0))
            band = clip(band, (0, row + 1), (-1, 0))
            for column in range(size[1]):
                pixel = clip(band, (column, 0), (0, -1))
                image[row, column] += sign * area(clip(pixel, (column + 1, 0), (0, 1)))
    return image


def test_coverage_and_derivative_by_clipping_polygons():
    pair, moves = crossing()
    size, step = (9, 9), 1e-4
    np.testing.assert_allclose(
        image_of(list(pair), size), union_by_clipping(pair, size), rtol=0, atol=1e-4
    )
    both = [union_by_clipping(pair + sign * step * moves, size) for sign in (1, -1)]
    want = (both[0] - both[1]) / (2 * step)
    _, got = image_and_jacobian(list(pair), list(moves[..., None]), size)
    np.testing.assert_allclose(got[..., 0], want, rtol=0, atol=2e-3 * abs(want).max())


@few
@given(blobs, st.integers(0, 99))
def test_backward_forward_and_jacobian_agree(segments, seed):
    rng = np.random.default_rng(seed)
    moves = [rng.normal(size=(*s.shape, 2)) for s in segments]
    image, jacobian = image_and_jacobian(segments, moves, SIZE)
    np.testing.assert_array_equal(image, image_of(segments))
    for i in range(2):
        with forward_ad.dual_level():
            duals = [
                forward_ad.make_dual(torch.tensor(s), torch.tensor(move[..., i]))
                for s, move in zip(segments, moves, strict=True)
            ]
            tangent = forward_ad.unpack_dual(vf.rasterize(duals, SIZE)).tangent
        np.testing.assert_allclose(tangent, jacobian[..., i], rtol=0, atol=1e-10)
    weight = rng.normal(size=SIZE)
    slopes = slope_of(segments, weight)
    for i in range(2):
        got = sum((slope * m[..., i]).sum() for slope, m in zip(slopes, moves, strict=True))
        assert got == pytest.approx((weight * jacobian[..., i].numpy()).sum(), rel=0, abs=1e-10)


@pytest.mark.filterwarnings("ignore:.*torch.jit:DeprecationWarning")
def test_torch_func():
    text = vf.Text("recursive", "a", axes={"wght": 600, "CASL": 0.4, "slnt": -7})
    placement, theta = frame(text, (24, 24)), text.theta

    def image(theta):
        return vf.rasterize(text.segments(theta), (24, 24), placement)

    jacobian = torch.func.jacfwd(image)(theta)
    assert jacobian.shape == (24, 24, *theta.shape)
    for axis in range(theta.shape[1]):
        along = torch.zeros_like(theta)
        along[0, axis] = 1
        _, tangent = torch.func.jvp(image, (theta,), (along,))
        torch.testing.assert_close(jacobian[..., 0, axis], tangent, rtol=0, atol=1e-12)
    slope = torch.func.grad(lambda theta: (image(theta) ** 2).sum())(theta)
    want = 2 * torch.einsum("hw,hwij->ij", image(theta), jacobian)
    torch.testing.assert_close(slope, want, rtol=0, atol=1e-9)
    thetas = torch.stack([theta, 0.5 * theta])
    images = torch.func.vmap(image)(thetas)
    torch.testing.assert_close(images[1], image(thetas[1]), rtol=0, atol=1e-12)


def test_gradcheck():
    pair, _ = crossing()
    # A contour must stay closed as its points are moved one by one.
    indices = Contours([4]).segments
    free = torch.tensor(pair[:, :, :3].reshape(2, 12, 2), requires_grad=True)
    transform = torch.tensor(TURNED, requires_grad=True)

    def image(points, transform):
        return vf.rasterize([p[indices] for p in points], (4, 5), transform=transform)

    assert torch.autograd.gradcheck(image, (free, transform), check_forward_ad=True)
    several = torch.stack([transform, transform + 0.1]).detach().requires_grad_()
    assert torch.autograd.gradcheck(image, (free.detach(), several), check_forward_ad=True)


@pytest.mark.parametrize("name", vf.bundled_fonts())
def test_gradient_through_a_text(name):
    text, size = somewhere(name, "R"), (24, 20)
    weight = np.random.default_rng(0).normal(size=size)
    theta = text.theta.clone().requires_grad_()
    transform = frame(text, size)

    def loss(theta):
        return (torch.tensor(weight) * vf.rasterize(text.segments(theta), size, transform)).sum()

    (got,) = torch.autograd.grad(loss(theta), theta)
    with torch.no_grad():
        for axis in range(theta.shape[1]):
            step = torch.zeros_like(theta)
            step[0, axis] = 1e-5
            want = (loss(theta + step) - loss(theta - step)) / 2e-5
            assert got[0, axis] == pytest.approx(float(want), rel=0, abs=1e-4 * float(got.norm()))


def test_what_lies_left_of_the_image_has_no_slope():
    (slope,) = slope_of([rectangle(-5, 2.5, 9, 4)], np.ones(SIZE))
    # The left side only; the others end at the image's border.
    np.testing.assert_allclose(slope[3, 1:3], 0, rtol=0, atol=1e-12)
    assert slope[1, :, 0].sum() == pytest.approx(4)


# The same arithmetic on torch's tensors, and elsewhere.


def agrees_on(device):
    whole, _ = batch_of()
    points, sizes = np.concatenate(whole, 1), [3, 4]
    rng = np.random.default_rng(1)
    slope, moves = rng.normal(size=(3, *SIZE)), rng.normal(size=(21, 4, 2, 2))
    want, boundary = fill(points, sizes, *SIZE)
    got, other = fill(torch.tensor(points, device=device), sizes, *SIZE)
    assert got.device.type == device
    pairs = [
        (got, want),
        (other.gradient(torch.tensor(slope, device=device)), boundary.gradient(slope)),
        (other.derivative(torch.tensor(moves, device=device)), boundary.derivative(moves)),
    ]
    for tensor, array in pairs:
        np.testing.assert_allclose(tensor.cpu(), array, rtol=0, atol=1e-10)


def test_tensors_and_arrays_agree():
    agrees_on("cpu")
    text = somewhere("shantell-sans", "w")
    segments = placed(text, (32, 32))
    points, sizes = np.concatenate(segments)[None], [len(s) for s in segments]
    got, want = fill(torch.tensor(points), sizes, 32, 32)[0], fill(points, sizes, 32, 32)[0]
    np.testing.assert_allclose(got, want, rtol=0, atol=1e-10)


@pytest.mark.skipif(not torch.cuda.is_available(), reason="needs a GPU")
def test_cuda_and_arrays_agree():
    agrees_on("cuda")
    whole, _ = batch_of()
    there = [torch.tensor(c, device="cuda", requires_grad=True) for c in whole]
    image = vf.rasterize(there, SIZE, transform=TURNED)
    image.square().sum().backward()
    here = [torch.tensor(c, requires_grad=True) for c in whole]
    want = vf.rasterize(here, SIZE, transform=TURNED)
    want.square().sum().backward()
    np.testing.assert_allclose(image.detach().cpu(), want.detach(), rtol=0, atol=1e-10)
    for one, other in zip(there, here, strict=True):
        np.testing.assert_allclose(one.grad.cpu(), other.grad, rtol=0, atol=1e-10)


# Bad input.

SQUARE = rectangle(1, 1, 2, 2)


@pytest.mark.parametrize("size", [5, (5,), (5, 6, 7), (5.5, 6), ("a", 6), (np.nan, 6), None])
def test_sizes_that_are_none(size):
    with pytest.raises(vf.ImageError, match=r"A size is \(height, width\) in whole pixels, not"):
        vf.rasterize([SQUARE], size)
    with pytest.raises(vf.ImageError, match="in whole pixels"):
        frame(vf.Text("recursive", "a"), size)


@pytest.mark.parametrize("size", [(0, 5), (5, 0), (-3, 5)])
def test_images_without_pixels(size):
    with pytest.raises(vf.ImageError, match=f"An image of {size[0]} × {size[1]} has no pixels"):
        vf.rasterize([SQUARE], size)


def test_images_of_too_many_pixels():
    with pytest.raises(vf.ImageError, match="10000 × 10000 has more than 33,554,432 pixels"):
        vf.rasterize([SQUARE], (10_000, 10_000))


def hole(value):
    contour = SQUARE.copy()
    contour[1, 1, 0] = value
    return [contour]


@pytest.mark.parametrize(
    "contours, message",
    [
        (torch.tensor(SQUARE), r"Contours come as a list of \(s, 4, 2\) arrays, one for each"),
        (SQUARE[None], "Contours come as a list"),
        ([SQUARE[0]], r"A contour is \(s, 4, 2\), not \(4, 2\)"),
        ([np.zeros((4, 3, 2))], r"A contour is \(s, 4, 2\), not \(4, 3, 2\)"),
        ([SQUARE, SQUARE[None]], "batch dimensions differ"),
        (hole(np.nan), "NaN or infinity"),
        (hole(np.inf), "NaN or infinity"),
        ([SQUARE * 1e11], r"reach 3e\+11 pixels; the largest coordinate is 1e\+09"),
        ([torch.tensor(SQUARE, device="meta")], "dense tensor that holds its numbers"),
        ([torch.tensor(SQUARE).to_sparse()], "dense tensor that holds its numbers"),
        ([SQUARE[:-1]], "Each segment begins where the one before it ends; one is 2 off"),
        ([SQUARE, SQUARE[[0, 2, 1, 3]]], "Each segment begins where the one before it ends"),
    ],
)
def test_contours_that_are_none(contours, message):
    with pytest.raises(vf.ImageError, match=message):
        vf.rasterize(contours, SIZE)


@pytest.mark.parametrize("size", [1e2, 1e8, 3e8])
def test_a_square_far_around_the_image_fills_it(size):
    around = size * (SQUARE - SQUARE.mean((0, 1)))
    assert vf.rasterize([around], SIZE).min() > 1 - 1e-12


def test_transforms_that_are_none():
    with pytest.raises(vf.ImageError, match=r"A transform is \(2, 3\), not \(3, 3\)"):
        vf.rasterize([SQUARE], SIZE, transform=np.eye(3))
    with pytest.raises(vf.ImageError, match="NaN or infinity"):
        vf.rasterize([SQUARE], SIZE, transform=TURNED * np.nan)


@pytest.mark.parametrize(
    "segments, moves",
    [
        ([SQUARE], []),
        ([SQUARE], [np.zeros((4, 4, 2))]),
        ([SQUARE], [np.zeros((3, 4, 2, 1))]),
        ([SQUARE[None]], [np.zeros((1, 4, 4, 2, 1))]),
    ],
)
def test_moves_that_are_not_those_of_the_segments(segments, moves):
    with pytest.raises(vf.ImageError, match=r"Each contour \(s, 4, 2\) needs its moves"):
        image_and_jacobian(segments, moves, SIZE)


def test_backends_that_are_none():
    with pytest.raises(vf.ImageError, match="no backend 'cairo': choose one of exact, diffvg"):
        vf.rasterize([SQUARE], SIZE, backend="cairo")


# diffvg, where it is.


def test_without_diffvg_the_error_says_how_to_get_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "pydiffvg", None)
    with pytest.raises(vf.ImageError, match=r"build it from github\.com/BachiLi/diffvg"):
        vf.rasterize([SQUARE], SIZE, backend="diffvg")


@pytest.mark.parametrize("name, letter", [("recursive", "R"), ("roboto-flex", "t")])
def test_diffvg_agrees_within_its_noise(name, letter):
    pytest.importorskip("pydiffvg")
    text, size = somewhere(name, letter), (256, 256)
    images, slopes = [], []
    for backend in ("exact", "diffvg"):
        segments = [torch.tensor(s, requires_grad=True) for s in placed(text, size)]
        image = vf.rasterize(segments, size, backend=backend)
        assert image.dtype == torch.float64
        image.sum().backward()
        images.append(image.detach().numpy())
        # Which of two names of a corner has its slope is a matter of taste.
        grads = [s.grad.numpy() for s in segments]
        slopes.append(np.concatenate([g[:, :3] for g in grads]))
        slopes[-1][:, 0] += np.concatenate([np.roll(g[:, 3], 1, 0) for g in grads])
    # Of 2 × 2 samples one decides over a quarter of a pixel.
    error = abs(images[1] - images[0])
    assert error.mean() < 0.003
    assert error.max() < 0.6
    assert np.linalg.norm(slopes[1] - slopes[0]) < 0.02 * np.linalg.norm(slopes[0])


def test_diffvg_takes_batches_and_transforms():
    pytest.importorskip("pydiffvg")
    whole, singles = batch_of()
    image = image_of(whole, transform=TURNED, backend="diffvg")
    assert image.shape == (3, *SIZE)
    for got, one in zip(image, singles, strict=True):
        want = image_of(one, transform=TURNED, backend="diffvg")
        np.testing.assert_allclose(got, want, rtol=0, atol=1e-6)


@pytest.mark.skipif(not REFERENCE.exists(), reason="VFWIDGET_DIFFVG_IMAGES names no file")
def test_reference_images():
    data = np.load(REFERENCE)
    for name in data["names"]:
        cubics, contour = data[f"{name}_cubics"], data[f"{name}_contour"]
        segments = [cubics[contour == i] for i in np.unique(contour)]
        image = image_of(segments, (256, 256))
        assert abs(image - data[f"{name}_scan64"]).max() < 0.01
        # Of 64 samples and four seeds; diffvg's cubics have an artefact that its quadratics lack.
        error = abs(image - data[f"{name}_img8x4_native"])
        assert error.mean() < 2e-4
        assert error.max() < 0.05
