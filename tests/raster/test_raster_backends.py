"""The coverage of tensors, on a GPU, and by diffvg."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import numpy as np
import pytest
import torch
from shapes import SIZE, SQUARE, TURNED, batch_of, image_of, placed, somewhere

import vfwidget as vf
from vfwidget.raster.coverage import fill

REFERENCE = Path(os.environ.get("VFWIDGET_DIFFVG_IMAGES", "unset"))
"""An archive of outlines and of what diffvg makes of them."""


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
def test_images_agree_with_those_of_diffvg():
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
