"""The picture that a scene draws, and its derivative."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.ndimage

import vfwidget as vf
from vfwidget.matching.images import basis
from vfwidget.matching.scene import PLACEMENT, Scene, State, _blur


def scene_and_state(seed, factor, blur=0.7):
    rng = np.random.default_rng(seed)
    text = vf.Text("recursive", "an", shared=False)
    # Away from where the outline's slope jumps.
    theta = np.array([[0.31, 0.43, 0.37, -0.29, 0.2], [0.62, 0.23, 0.77, -0.71, 0.1]])
    size = (37, 52)
    scene = Scene(text, size, factor)
    placement = np.array([26.3, 18.2, np.log(0.026), 0.1]) + rng.normal(0, 0.02, 4)
    light = np.array([0.9, 0.05, -0.04, 0.02, 0.03, -0.02])
    return scene, State(theta, placement, blur, light, 0.13, np.zeros((2, 2)), np.zeros(1))


PARTS = {
    "axes": "theta",
    "offsets": "offsets",
    "tracking": "tracking",
    "x": "placement",
    "y": "placement",
    "size": "placement",
    "rotation": "placement",
    "blur": "blur",
    "background": "light",
    "ink": "ink",
}
"""The parts of a state in the order of a picture's derivative, and the field of each."""


def moved(state, part, index, step):
    """The state with one number of a part changed."""
    value = np.array(getattr(state, PARTS[part]), dtype=float)
    if part in PLACEMENT:
        index = PLACEMENT.index(part)
    value.flat[index] += step
    return replace(state, **{PARTS[part]: value if value.ndim else float(value)})


def size_of(state, part):
    return 1 if part in PLACEMENT else np.size(getattr(state, PARTS[part]))


@pytest.mark.parametrize("factor", [1, 2])
@pytest.mark.parametrize("seed", [1, 2])
def test_the_derivative_of_a_picture(factor, seed):
    scene, state = scene_and_state(seed, factor)
    jacobian = scene.jacobian(state, list(PARTS))
    entries = [(part, i) for part in PARTS for i in range(size_of(state, part))]
    assert jacobian.shape == (len(entries), *scene.shape)
    for row, (part, i) in zip(jacobian, entries, strict=True):
        step = 1e-3 if part in ("offsets", "tracking") else 1e-5
        there, back = (scene.image(moved(state, part, i, s)) for s in (step, -step))
        assert row == pytest.approx(
            (there - back) / (2 * step), rel=1e-5, abs=1e-5 * abs(row).max()
        )


def test_the_derivative_by_blur_where_there_is_none():
    scene, state = scene_and_state(3, 1, blur=0.0)
    step = 1e-4
    there, further = (scene.image(replace(state, blur=s)) for s in (step, 2 * step))
    slope = (4 * there - further - 3 * scene.image(state)) / (2 * step)
    row = scene.jacobian(state, ["blur"])[0]
    assert row == pytest.approx(slope, abs=1e-4 * abs(slope).max())


def test_the_derivative_by_some_of_the_variables():
    scene, state = scene_and_state(4, 1)
    every = scene.jacobian(state, list(PARTS))
    owners = np.repeat(list(PARTS), [size_of(state, part) for part in PARTS])
    rng = np.random.default_rng(5)
    for _ in range(8):
        wanted = [part for part in PARTS if rng.random() < 0.4]
        rows = every[np.isin(owners, wanted)]
        assert np.allclose(scene.jacobian(state, wanted), rows, rtol=0, atol=1e-12)


def test_the_picture_is_made_of_paper_and_ink():
    scene, state = scene_and_state(6, 1, blur=0.0)
    covered = vf.rasterize(
        scene.text.at(theta=state.theta), (37, 52), scene.matrix(state.placement)
    )
    paper = basis(37, 52, 6) @ state.light
    expected = paper * (1 - covered.numpy()) + state.ink * covered.numpy()
    assert scene.image(state) == pytest.approx(expected)
    assert scene.paper(state) == pytest.approx(paper)
    many = scene.coverage(state.theta[None], state.placement[None])
    assert many[0] == pytest.approx(covered.numpy())


@pytest.mark.parametrize("variance", [1e-4, 0.05, 0.5, 2.0, 10.0])
def test_blur_keeps_the_ink_and_has_the_variance_asked_for(variance):
    point = np.zeros((2, 61, 63))
    point[:, 30, 31] = 1, -2
    one, other = _blur(point, variance)
    assert other == pytest.approx(-2 * one)
    assert one.sum() == pytest.approx(1)
    assert one.min() > -1e-12
    y, x = np.mgrid[:61, :63]
    assert (one * x).sum() == pytest.approx(31)
    assert (one * (x - 31) ** 2).sum() == pytest.approx(variance, rel=2e-3)
    assert (one * (y - 30) ** 2).sum() == pytest.approx(variance, rel=2e-3)


@pytest.mark.parametrize("variance", [0.05, 60.0])
def test_a_large_picture_is_blurred_as_by_scipy(variance):
    noise = np.random.default_rng(0).normal(size=(2, 530, 700))
    point = np.zeros((1, 1, 201))
    point[0, 0, 100] = 1
    kernel = _blur(point, variance)[0, 0]
    kernel /= kernel.sum()
    expected = scipy.ndimage.convolve1d(noise, kernel, 2, mode="constant")
    expected = scipy.ndimage.convolve1d(expected, kernel, 1, mode="constant")
    assert _blur(noise, variance) == pytest.approx(expected, abs=1e-12)
