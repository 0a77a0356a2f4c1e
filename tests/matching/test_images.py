"""Every kind of array, image and file that is read, and every kind that is refused."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pictures
import pytest
import torch
from PIL import Image

import vfwidget as vf
from vfwidget.matching.images import (
    basis,
    noise_variance,
    part,
    read_image,
    shrink,
)
from vfwidget.matching.start import readings

SIZE = (48, 56)
NAN = float("nan")


@pytest.fixture(scope="module")
def text() -> vf.Text:
    return vf.Text("dynapuff", "S", axes={"wght": 620, "wdth": 84})


@pytest.fixture(scope="module")
def coverage(text) -> np.ndarray:
    """Ink in steps of 1 / 255."""
    return np.round(vf.rasterize(text, SIZE).numpy() * 255) / 255


# What can be read: each form shows the same letter, black on white


def to_bytes(values):
    return np.round(values * 255).astype(np.uint8)


def in_colour(grey):
    return np.repeat(to_bytes(grey)[..., None], 3, -1)


def transparent(grey):
    """Black throughout; the letter is all that is opaque."""
    return np.dstack([np.zeros((*grey.shape, 3), np.uint8), to_bytes(1 - grey)])


def palette(grey):
    image = Image.fromarray(255 - to_bytes(grey)).convert("P")
    image.putpalette([255 - i // 3 for i in range(768)])
    return image


ARRAYS = {
    "float64": lambda grey: grey,
    "float32": lambda grey: grey.astype(np.float32),
    "uint8": to_bytes,
    "uint16": lambda grey: np.round(grey * 65535).astype(np.uint16),
    "one channel": lambda grey: grey[..., None],
    "grey with alpha": lambda grey: np.dstack([np.zeros_like(grey), 1 - grey]),
    "RGB": in_colour,
    "RGB of floats": lambda grey: np.dstack([grey] * 3),
    "RGBA": transparent,
    "not contiguous": lambda grey: np.asfortranarray(np.repeat(grey, 2, 1))[:, ::2],
    "read-only": lambda grey: np.broadcast_to(grey, grey.shape),
    "tensor": lambda grey: torch.from_numpy(grey.copy()),
    "tensor of float32": lambda grey: torch.from_numpy(grey.astype(np.float32)),
    "tensor of bytes": lambda grey: torch.from_numpy(to_bytes(grey)),
    "tensor with gradient": lambda grey: torch.tensor(grey, requires_grad=True),
    "list": lambda grey: grey.tolist(),
    "PIL L": lambda grey: Image.fromarray(to_bytes(grey)),
    "PIL RGB": lambda grey: Image.fromarray(in_colour(grey)),
    "PIL RGBA": lambda grey: Image.fromarray(transparent(grey)),
    "PIL LA": lambda grey: Image.fromarray(transparent(grey)).convert("LA"),
    "PIL P": palette,
    "PIL I;16": lambda grey: Image.fromarray(np.round(grey * 65535).astype(np.uint16)),
    "PIL I": lambda grey: Image.fromarray(np.round(grey * 65535).astype(np.int32)),
    "PIL F": lambda grey: Image.fromarray(grey.astype(np.float32)),
}


@pytest.mark.parametrize("form", ARRAYS.values(), ids=ARRAYS)
def test_every_kind_of_array_and_image(form, coverage):
    grey = 1 - coverage
    before = grey.copy()
    values = read_image(form(grey))
    assert values.dtype == np.float64
    assert values.shape == SIZE
    assert values == pytest.approx(grey, abs=1e-6)
    assert np.array_equal(grey, before)


FILES = {
    "grey.png": (lambda grey: Image.fromarray(to_bytes(grey)), 1e-9),
    "alpha.png": (lambda grey: Image.fromarray(transparent(grey)), 1e-9),
    "deep.png": (lambda grey: Image.fromarray(np.round(grey * 65535).astype(np.uint16)), 1e-9),
    "palette.png": (palette, 1e-9),
    "grey.tiff": (lambda grey: Image.fromarray(to_bytes(grey)), 1e-9),
    "grey.bmp": (lambda grey: Image.fromarray(to_bytes(grey)), 1e-9),
    "grey.gif": (lambda grey: Image.fromarray(to_bytes(grey)), 1e-9),
    "grey.jpg": (lambda grey: Image.fromarray(to_bytes(grey)), 0.04),
}


@pytest.mark.parametrize("name", FILES)
@pytest.mark.parametrize("kind", [Path, str])
def test_every_kind_of_file(name, kind, coverage, tmp_path):
    make, tolerance = FILES[name]
    image = make(1 - coverage)
    image.save(tmp_path / name, **({"quality": 95} if name.endswith("jpg") else {}))
    assert read_image(kind(tmp_path / name)) == pytest.approx(1 - coverage, abs=tolerance)


def test_a_photograph_is_turned_as_its_file_says(coverage, tmp_path):
    image = Image.fromarray(to_bytes(1 - coverage))
    exif = image.getexif()
    exif[0x0112] = 6  # the top is at the right
    image.save(tmp_path / "turned.png", exif=exif)
    assert read_image(tmp_path / "turned.png") == pytest.approx(np.rot90(1 - coverage, -1))


def test_a_mask_is_read_as_black_and_white():
    values = read_image(np.eye(7, 9) > 0)
    assert np.array_equal(values, np.eye(7, 9))
    assert np.array_equal(read_image(Image.fromarray(np.eye(8) > 0)), np.eye(8))


def test_colours_become_luminance():
    colours = np.eye(3)[None]
    assert read_image(colours)[0] == pytest.approx([0.2126, 0.7152, 0.0722])
    half = np.array([[[0, 0, 0, 128]]], dtype=np.uint8)
    assert read_image(half)[0, 0] == pytest.approx(127 / 255)


@pytest.mark.parametrize(
    "form",
    [
        *("uint8", "RGBA", "tensor", "grey.jpg"),
        *[
            pytest.param(form, marks=pytest.mark.slow)
            for form in ("uint16", "float32", "RGB", "PIL LA", "alpha.png")
        ],
    ],
)
def test_the_axes_are_found_from_any_of_them(form, text, coverage, tmp_path):
    if form in FILES:
        FILES[form][0](1 - coverage).save(tmp_path / form)
        source = tmp_path / form
    else:
        source = ARRAYS[form](1 - coverage)
    found = vf.match(source, "S", "dynapuff", progress=False)
    assert found.status == "matched"
    assert pictures.axis_error(found, text) < (0.03 if form == "grey.jpg" else 0.005)


# What is no picture of letters


def flat(value, shape=(32, 32)):
    return np.full(shape, value)


BAD = {
    "nothing at all": (np.zeros((0, 0)), "An image of 0 × 0 has no pixels"),
    "no rows": (np.zeros((0, 20)), "An image of 0 × 20 has no pixels"),
    "no columns": (torch.zeros(20, 0), "An image of 20 × 0 has no pixels"),
    "no pixels of PIL": (lambda: Image.new("L", (0, 3)), "An image of 3 × 0 has no pixels"),
    "few pixels": (np.eye(5), "The image is too small: it has 5 × 5 pixels"),
    "a line": (np.eye(1, 90), "The image is too small: it has 1 × 90 pixels"),
    "a narrow strip": (np.eye(6, 300), "too narrow: it has 6 × 300 pixels"),
    "a billion channels": (np.broadcast_to(0.5, (100, 100, 10**9)), r"not \(100, 100, 1000000000"),
    "a tensor without data": (torch.empty(8, 8, device="meta"), "on device meta cannot be read"),
    "a sparse tensor": (torch.eye(8).to_sparse(), "layout torch.sparse_coo"),
    "a complex tensor": (torch.eye(8) * 1j, "An image holds numbers, not complex64"),
    "white": (flat(1.0), "The image is uniform: there is no ink in it"),
    "black": (flat(0, (32, 40)).astype(np.uint8), "The image is uniform"),
    "grey": (flat(0.5), "The image is uniform"),
    "transparent": (np.zeros((20, 20, 4), np.uint8), "The image is uniform"),
    "almost white": (1 - 0.015 * np.pad(np.ones((8, 8)), 12), "The image is uniform"),
    "NaN": (flat(NAN), "The image holds NaN or infinity"),
    "one NaN": (np.where(np.eye(32) > 0, NAN, 1.0), "The image holds NaN or infinity"),
    "infinity": (flat(float("-inf")), "The image holds NaN or infinity"),
    "floats to 255": (np.eye(32) * 255.0, "Grey levels are floats in 0 … 1.* run from 0 to 255"),
    "signed bytes": (np.eye(32, dtype=np.int64) * 255, "whole numbers of an unsigned type"),
    "negative": (np.eye(32) - 1, "run from -1 to 0"),
    "PIL I beyond 16 bits": (
        lambda: Image.fromarray(np.eye(32, dtype=np.int32) * 70000),
        "have 16 bits: 0 … 65,535",
    ),
    "PIL I below 0": (
        lambda: Image.fromarray(-np.eye(32, dtype=np.int32)),
        "have 16 bits: 0 … 65,535",
    ),
    "no array": (None, r"An image is \(H, W\) or \(H, W, 3 or 4\), not \(\)"),
    "a number": (0.5, r"not \(\)"),
    "a row": (np.ones(9), r"not \(9,\)"),
    "no channels": (np.ones((8, 8, 0)), r"not \(8, 8, 0\)"),
    "five channels": (np.ones((8, 8, 5)), r"not \(8, 8, 5\)"),
    "a batch": (np.ones((1, 3, 8, 8)), r"not \(1, 3, 8, 8\)"),
    "ragged": ([[0.0] * 8, [1.0] * 7], "not ragged"),
    "letters": (np.full((8, 8), "R"), "An image holds numbers, not <U1"),
    "complex": (np.eye(8) * 1j, "An image holds numbers, not complex128"),
    "objects": (np.full((8, 8), None), "An image holds numbers, not object"),
    "100 megapixels": (
        np.broadcast_to(np.uint8(7), (10_000, 10_000)),
        f"An image of 10000 × 10000 is larger than the limit of {vf.limits.image_pixels:,} pixels",
    ),
    "100 megapixels in colour": (
        np.broadcast_to(np.uint8(7), (10_000, 10_000, 3)),
        "larger than the limit",
    ),
    "a view of one number": (torch.zeros(1, 1).expand(10**6, 10**6), "larger than the limit"),
    "a view with a billion channels": (
        torch.zeros(1, 1, 1).expand(100, 100, 10**9),
        r"not \(100, 100, 1000000000",
    ),
    "100 megapixels of PIL": (lambda: Image.new("1", (10_000, 10_000)), "larger than the limit"),
    "a wide one": (np.broadcast_to(0.5, (1, vf.limits.image_pixels + 1)), "larger than the limit"),
}


@pytest.mark.parametrize("source, message", BAD.values(), ids=BAD)
def test_an_image_that_is_none(source, message):
    with pytest.raises(vf.ImageError, match=message):
        vf.match(source() if callable(source) else source, "R", "recursive", progress=False)


def make_file(folder: Path, name: str) -> Path:
    path = folder / name
    if name == "text.png":
        path.write_text("no picture")
    elif name == "empty.png":
        path.touch()
    elif name == "folder":
        path.mkdir()
    elif name != "missing.png":
        size = (10_000, 10_000) if name == "huge.png" else (90, 90)
        image = Image.new("1", size)
        image.putpixel((3, 3), 1)
        image.save(path)
    if name == "cut.png":
        path.write_bytes(path.read_bytes()[:48])
    return path


@pytest.mark.parametrize(
    "name, message",
    [
        ("missing.png", r"missing\.png cannot be read as an image .*No such file"),
        ("text.png", r"text\.png cannot be read as an image .*cannot identify"),
        ("empty.png", r"empty\.png cannot be read as an image"),
        ("folder", r"folder cannot be read as an image"),
        ("cut.png", r"cut\.png cannot be read as an image"),
        ("huge.png", "An image of 10000 × 10000 is larger than the limit"),
    ],
)
def test_a_file_that_is_no_image(name, message, tmp_path):
    path = make_file(tmp_path, name)
    with pytest.raises(vf.ImageError, match=message):
        vf.match(path, "R", "recursive", progress=False)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no named pipes here")
def test_a_pipe_or_a_device_is_not_opened(tmp_path):
    os.mkfifo(tmp_path / "pipe.png")
    for path in (tmp_path / "pipe.png", Path("/dev/zero")):
        with pytest.raises(vf.ImageError, match="it is not a regular file"):
            read_image(path)


def test_bfloat16_is_read(coverage):
    grey = torch.tensor(1 - coverage).bfloat16()
    assert read_image(grey) == pytest.approx(1 - coverage, abs=2**-8)


def test_any_exception_of_a_decoder_becomes_an_image_error(tmp_path, monkeypatch):
    path = make_file(tmp_path, "plain.png")

    def fail(self):
        raise IndexError("index out of range")

    monkeypatch.setattr("PIL.ImageFile.ImageFile.load", fail)
    with pytest.raises(vf.ImageError, match=r"plain\.png cannot be read .*out of range"):
        read_image(path)


def test_a_larger_image_is_read_if_the_limit_is_raised(monkeypatch):
    monkeypatch.setattr(vf.limits, "image_pixels", 63)
    with pytest.raises(vf.ImageError, match=r"raise vfwidget\.limits\.image_pixels"):
        read_image(np.eye(8))
    monkeypatch.setattr(vf.limits, "image_pixels", 64)
    assert read_image(np.eye(8)).shape == (8, 8)
    with pytest.raises(AttributeError):
        vf.limits.image_pixel = 65


@pytest.mark.slow
@pytest.mark.parametrize("form", ["array", "PIL", "file"])
def test_the_largest_image_needs_less_than_a_gibibyte_to_read(form, tmp_path):
    code = """
import resource, sys
import numpy as np
from PIL import Image
from vfwidget.matching.images import read_image
side, form, path = 8192, sys.argv[1], sys.argv[2]
image = Image.new("RGBA", (side, side), (9, 8, 7, 255)) if form != "array" else None
if form == "array":
    image = np.broadcast_to(np.array([9, 8, 7, 255], np.uint8), (side, side, 4))
if form == "file":
    image.save(path)
    image = path
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
assert read_image(image).shape == (side, side)
print((resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 2**20)
"""
    command = [sys.executable, "-c", code, form, str(tmp_path / "large.png")]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert float(done.stdout) < 1


def test_a_huge_file_is_refused_before_it_is_unpacked(tmp_path, monkeypatch):
    path = make_file(tmp_path, "huge.png")
    monkeypatch.setattr(Image.Image, "load", lambda self: pytest.fail("unpacked"))
    monkeypatch.setattr("PIL.ImageFile.ImageFile.load", lambda self: pytest.fail("unpacked"))
    with pytest.raises(vf.ImageError, match="larger than the limit"):
        read_image(path)


def test_an_image_of_pil_that_cannot_be_unpacked(tmp_path):
    path = tmp_path / "cut.png"
    Image.fromarray(np.random.default_rng(1).integers(0, 255, (90, 90), np.uint8)).save(path)
    path.write_bytes(path.read_bytes()[:2000])
    with Image.open(path) as image:
        with pytest.raises(vf.ImageError, match="The image is damaged or truncated"):
            read_image(image)


# Made smaller, and parted into paper and ink


def test_shrinking_takes_means():
    rng = np.random.default_rng(2)
    image = rng.random((12, 18))
    small = shrink(image, 3)
    assert small.shape == (4, 6)
    assert small[1, 2] == pytest.approx(image[3:6, 6:9].mean())
    assert shrink(image, 1) is image
    ragged = shrink(image[:11, :17], 3)
    assert ragged[3, 5] == pytest.approx(
        np.pad(image[9:11, 15:17], ((0, 1), (0, 1)), mode="edge").mean()
    )


@pytest.mark.parametrize("deviation", [0.0, 0.01, 0.1])
def test_noise_is_told_from_letters(deviation):
    image = 0.2 + 0.6 * pictures.draw(vf.Text("afacad-flux", "ag"), (96, 128))
    image *= np.linspace(0.8, 1, 128)
    noise = np.random.default_rng(5).normal(0, deviation, image.shape)
    assert noise_variance(image + noise) == pytest.approx(deviation**2, rel=0.2, abs=1e-8)


def test_readings_of_ink():
    ink = np.zeros((20, 30))
    ink[5:9, 4:8] = 1
    # Joined at a corner, a diagonal, and so one with it.
    ink[9:12, 8:11] = np.eye(3)
    ink[4:14, 20:24] = 0.5
    ink[:2, 28:] = 1
    ink[18, 18] = 0.4
    left, right, corner, speck = (np.zeros_like(ink) for _ in range(4))
    left[5:12, 4:11] = ink[5:12, 4:11]
    right[:, 20:24] = ink[:, 20:24]
    corner[:2, 28:], speck[18, 18] = 1, 0.4
    assert (left + right + corner + speck == ink).all()
    expected = [right + corner + speck, left + corner + speck, left + right + speck, right]
    assert {one.tobytes() for one in readings(ink)} == {one.tobytes() for one in expected}
    assert readings(left) == []


def test_the_basis_of_the_light():
    over = basis(3, 4, 6)
    u, v = -0.75, 2 / 3
    assert over[2, 0] == pytest.approx([1, u, v, u * v, u * u, v * v])
    assert basis(3, 4, 1).shape == (3, 4, 1)
    with pytest.raises(ValueError, match="read-only"):
        over[0, 0, 0] = 2


@pytest.mark.parametrize("dark", [True, False])
@pytest.mark.parametrize("told", [True, False])
@pytest.mark.parametrize("terms", [1, 6])
def test_paper_and_ink_are_parted(dark, told, terms, coverage):
    rng = np.random.default_rng(3)
    over = basis(*SIZE, terms)
    light = np.array([0.8, 0.06, -0.05, 0.01, 0.02, -0.02])[:terms]
    ink = 0.15
    image = over @ light * (1 - coverage) + ink * coverage + rng.normal(0, 0.01, SIZE)
    if not dark:
        image, light, ink = 1 - image, -light, 1 - ink
        light[0] += 1
    levels, amount = part(image, terms, dark if told else None)
    assert levels.paper(*SIZE) == pytest.approx(over @ light, abs=0.02)
    assert levels.ink == pytest.approx(ink, abs=0.05)
    assert amount.min() == 0
    assert amount.max() == 1
    assert abs(amount - coverage).mean() < 0.02
    assert not amount[coverage == 0].any()
