"""What cannot be drawn is refused with a clear error."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from shapes import SIZE, SQUARE, TURNED

import vfwidget as vf
from vfwidget.raster import frame, image_and_jacobian


@pytest.mark.parametrize("size", [5, (5,), (5, 6, 7), (5.5, 6), ("a", 6), (np.nan, 6), None])
def test_sizes_that_are_none(size):
    with pytest.raises(
        vf.ImageError, match=r"size must be \(height, width\) in whole pixels; received"
    ):
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
        (torch.tensor(SQUARE), r"Contours must be a list of \(s, 4, 2\) arrays"),
        (SQUARE[None], "Contours must be a list"),
        ([SQUARE[0]], r"A contour must have the shape \(s, 4, 2\); received \(4, 2\)"),
        ([np.zeros((4, 3, 2))], r"A contour must have the shape \(s, 4, 2\); received \(4, 3, 2\)"),
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
    with pytest.raises(
        vf.ImageError, match=r"transform must have the shape \(2, 3\); received \(3, 3\)"
    ):
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
    with pytest.raises(vf.ImageError, match=r"Each contour \(s, 4, 2\) needs tangents"):
        image_and_jacobian(segments, moves, SIZE)


def test_backends_that_are_none():
    with pytest.raises(vf.ImageError, match="no backend 'cairo': choose one of exact, diffvg"):
        vf.rasterize([SQUARE], SIZE, backend="cairo")
