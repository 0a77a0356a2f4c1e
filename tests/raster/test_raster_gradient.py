"""The derivative of the coverage: differences of exact areas and clipped polygons as referees."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from hypothesis import assume, given
from hypothesis import strategies as st
from shapes import SIZE, TURNED, blob, blobs, few, image_of, rectangle, somewhere
from torch.autograd import forward_ad

import vfwidget as vf
from vfwidget.outline.contours import Contours
from vfwidget.raster import frame, image_and_jacobian

STEP = 1e-6


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
def test_the_transforms_of_torch_func_work():
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


@pytest.mark.filterwarnings("ignore:.*torch.jit:DeprecationWarning")
def test_derivatives_of_torch_func_in_a_batch():
    func, contour = torch.func, blob(5, 4, [3, 2, 4])
    rng = np.random.default_rng(4)
    places = torch.tensor(np.eye(2, 3) + 0.1 * rng.normal(size=(2, 3, 2, 3)))
    weight = torch.tensor(rng.normal(size=(7, 9)))

    def image(place):
        return vf.rasterize([contour], (7, 9), place)

    # A sum's slope by the image is the same for all, and a square's is not.
    for derivative in (
        func.jacrev(image),
        func.jacfwd(image),
        func.grad(lambda place: (image(place) * weight).sum()),
        func.grad(lambda place: (image(place) ** 2).sum()),
        lambda place: func.jvp(image, (place,), (torch.ones(2, 3).double(),))[1],
    ):
        want = torch.stack([torch.stack([derivative(place) for place in row]) for row in places])
        got = func.vmap(derivative)(places[0])
        torch.testing.assert_close(got, want[0], rtol=0, atol=1e-9)
        got = func.vmap(func.vmap(derivative))(places)
        torch.testing.assert_close(got, want, rtol=0, atol=1e-9)
        got = func.vmap(func.vmap(derivative), in_dims=1, out_dims=1)(places)
        torch.testing.assert_close(got, want, rtol=0, atol=1e-9)


def test_gradcheck_of_torch_passes():
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
