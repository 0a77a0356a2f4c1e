"""Coverage where edges nearly coincide, or lie at the angles by which outlines are turned."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from scan import scan
from shapes import NEAR, SIZE, blob, image_of, misses, rectangle, reverse

import vfwidget as vf
from vfwidget.outline.arrangement import TURNS
from vfwidget.outline.contours import Contours
from vfwidget.raster.coverage import fill

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


def copies_of(points, moves, distance):
    """A contour of the points (3 s, 2), and a copy for each of the moves, which are as large."""
    whole = Contours([len(points) // 3]).segments
    return [(np.array(points) + distance * np.array(move))[whole] for move in (0, *moves)]


def test_levels_near_a_turn_that_rounding_puts_in_the_wrong_order():
    copies = copies_of([(3, 7), (9, 10), (8, 6)], [[(0, 0), (-2, 0), (0, 0)]], 1e-11)
    assert misses(copies) < 0.02


def test_curves_that_nearly_coincide_and_would_cross_beyond_their_ends():
    points = [(5, 9), (4, 2), (5, 5), (9, 2), (2, 1), (8, 11)]
    moves = [[(-1, -2), (0, 0), (0, 0), (0, 0), (-3, 0), (-2, 0)]]
    assert misses(copies_of(points, moves, 1e-11)) < 0.02


@pytest.mark.parametrize("distance", [1e-7, 1e-9, 1e-10, 1e-11, 1e-12])
def test_copies_of_a_contour_are_one_contour(distance):
    rng = np.random.default_rng(round(-np.log10(distance)))
    for _ in range(100):
        points = rng.uniform(-2, 14, (3 * rng.integers(1, 5), 2))
        moved = rng.normal(size=(3, *points.shape)) * (rng.random((3, *points.shape)) < 0.5)
        single = image_of(copies_of(points, [], distance))
        assert abs(image_of(copies_of(points, moved, distance)) - single).max() < 1e-4


def test_curves_that_coincide_are_not_cut_again_and_again():
    contour = blob(7.1, 6.2, [4, 3, 5, 4])
    counts = []
    for shift in (0, 1e-13, 1e-10):
        segments = np.concatenate([contour, contour + shift])[None]
        counts.append(len(fill(segments, [4, 4], *SIZE)[1].cubic))
    single = len(fill(contour[None], [4], *SIZE)[1].cubic)
    assert max(counts) <= 2 * single + 16


@pytest.mark.parametrize("off", [0.0, 1e-14, 1e-11, 1e-8, -1e-6, 1e-3])
def test_edges_at_the_angles_by_which_outlines_are_turned(off):
    """They would be level afterwards, and a level edge is in no slab."""
    for turn in TURNS:
        for angle in np.arctan2(turn[1, 0], turn[0, 0]) * np.array([-1, 1]) + off:
            segments = turned([rectangle(2.3, 2.1, 8, 5), rectangle(4, 3, 7, 6)], angle)
            assert abs(image_of(segments) - scan(segments, *SIZE)).max() < NEAR


def test_a_polygon_with_edges_in_all_directions():
    angle = np.linspace(0, 2 * np.pi, 20_001)
    corners = 5 * np.stack([np.cos(angle), np.sin(angle)], 1) + (7, 6)
    sides = np.linspace(corners[:-1], corners[1:], 4).swapaxes(0, 1)
    area = len(sides) * 12.5 * np.sin(angle[1])
    assert image_of([sides]).sum() == pytest.approx(area, rel=1e-9)
    # The same one twice, once with sides of no length.
    flat = np.concatenate([sides, np.broadcast_to(corners[0], (1, 4, 2))])
    assert image_of([sides, flat]).sum() == pytest.approx(area, rel=1e-9)
