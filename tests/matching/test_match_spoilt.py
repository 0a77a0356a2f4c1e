"""Pictures that are spoilt, or that show something else."""

from __future__ import annotations

import numpy as np
import pytest
from pictures import CLEAN, SIZE, axis_error, blurred, draw, match, miss, random_place

import vfwidget as vf
from vfwidget.raster import frame


def ramp(size=SIZE):
    y, x = np.mgrid[: size[0], : size[1]] / max(size)
    return 0.55 + 0.35 * x - 0.15 * y


def stained(image):
    y, x = np.mgrid[: image.shape[0], : image.shape[1]] / max(image.shape)
    return np.where(np.hypot(x - 0.8, y - 0.2) < 0.06, 0.1, image)


@pytest.mark.parametrize("name", ["afacad-flux", "recursive"])
def test_a_disc_is_no_o(name):
    assert match(disc(20), "o", name).status == "poor"


def small(image):
    return image.reshape(SIZE[0] // 2, 2, SIZE[1] // 2, 2).mean((1, 3))


SPOILT = {
    # how, the axes' error (normalized) and the outline's (pixels) that is allowed
    "8 bits": (lambda image, rng: np.round(image * 255).astype(np.uint8), 0.005, 0.05),
    "light on dark": (lambda image, rng: 1 - image, 0.002, 0.03),
    "pale": (lambda image, rng: 0.5 + 0.2 * image, 0.002, 0.03),
    "blur": (lambda image, rng: np.clip(blurred(image, 1.5), 0, 1), 0.02, 0.1),
    "noise": (lambda image, rng: 0.2 + 0.6 * image + rng.normal(0, 0.05, SIZE), 0.03, 0.3),
    "much noise": (lambda image, rng: 0.2 + 0.6 * image + rng.normal(0, 0.1, SIZE), 0.06, 0.6),
    "uneven light": (lambda image, rng: (0.1 + 0.9 * image) * ramp(), 0.01, 0.1),
    "stain": (lambda image, rng: stained(image), 0.005, 0.05),
    "32 pixels": (lambda image, rng: small(image), 0.005, 0.05),
    "all but the stain": (
        lambda image, rng: np.clip(
            blurred((0.1 + 0.9 * image) * ramp(), 1) + rng.normal(0, 0.03, SIZE), 0, 1
        ),
        0.05,
        0.4,
    ),
}


@pytest.mark.parametrize(
    "how, seed",
    [
        *[(how, 1) for how in SPOILT if how not in ("pale", "much noise")],
        *[pytest.param(how, i, marks=pytest.mark.slow) for how in SPOILT for i in (2, 3, 4)],
    ],
)
def test_spoilt_pictures_are_matched(how, seed):
    spoil, error, pixels = SPOILT[how]
    rng = np.random.default_rng(seed)
    truth = random_place(vf.Text("dynapuff", "S"), rng)
    image = spoil(draw(truth, SIZE), rng)
    found = match(image, "S", "dynapuff")
    scale = len(image) / SIZE[0]
    assert found.status == "matched"
    assert abs(found.text.theta - truth.theta).max() < error
    assert miss(found, truth, frame(truth, SIZE).numpy() * scale) < pixels
    if how == "light on dark":
        assert found.image[0, 0] < 0.1
    if how == "blur":
        assert found.blur == pytest.approx(1.5, abs=0.15)
    elif "bits" in how or "light" in how:
        assert found.blur < 0.2


@pytest.mark.parametrize(
    "name, string",
    [
        ("afacad-flux", "a"),
        ("recursive", "Q&"),
        *[
            pytest.param(name, string, marks=pytest.mark.slow)
            for name in ("afacad-flux", "dynapuff", "recursive", "shantell-sans")
            for string in ("g", "R", "and", "i", "é")
        ],
    ],
)
@pytest.mark.parametrize("dark", [True, False])
def test_a_dark_patch_beside_the_text_is_not_the_text(name, string, dark):
    # Alone it has more ink than many a thin letter.
    truth = random_place(vf.Text(name, string), np.random.default_rng(len(string)))
    image = draw(truth, (96, 96))
    image[4:15, 67:90] = 0.3
    found = match(image if dark else 1 - image, string, name)
    assert axis_error(found, truth) < 0.01
    assert miss(found, truth, frame(truth, (96, 96)).numpy()) < 0.1


def test_noise_is_not_held_against_a_match(text, image):
    rng = np.random.default_rng(4)
    found = match(np.clip(image + rng.normal(0, 0.1, SIZE), 0, 1), "S", "dynapuff")
    assert found.score > 0.99


def test_a_robust_loss_puts_a_stain_aside(text, image):
    robust = match(stained(image), "S", "dynapuff", loss="soft_l1")
    plain = match(stained(image), "S", "dynapuff", loss="linear")
    assert axis_error(plain, text) > 5 * axis_error(robust, text)


@pytest.mark.parametrize(
    "loss", ["cauchy", *[pytest.param(x, marks=pytest.mark.slow) for x in ("linear", "huber")]]
)
def test_every_loss_finds_a_clean_picture(loss, text, image):
    assert axis_error(match(image, "S", "dynapuff", loss=loss), text) < CLEAN


def test_uneven_light_has_to_be_asked_for(text, image):
    lit = (0.1 + 0.9 * image) * ramp()
    uneven = match(lit, "S", "dynapuff", background="uneven")
    even = match(lit, "S", "dynapuff", background="even")
    assert abs(uneven.residual).mean() < 0.01
    assert abs(even.residual).mean() > 5 * abs(uneven.residual).mean()


def test_ink_may_be_told(image, text):
    for ink, shown in ("dark", image), ("light", 1 - image):
        assert axis_error(match(shown, "S", "dynapuff", ink=ink), text) < CLEAN
    with pytest.raises(vf.ImageError, match="no ink in the image that is lighter than its paper"):
        match(image, "S", "dynapuff", ink="light")


def disc(radius, hole=0):
    y, x = np.mgrid[:64, :64]
    return 1 - ((abs(np.hypot(x - 31.5, y - 31.5) - (radius + hole) / 2)) < (radius - hole) / 2)


OTHERS = {
    # and the most of it that an R may explain
    "a disc": (lambda: disc(20), 0.9),
    "noise": (lambda: np.random.default_rng(1).random(SIZE), 0.5),
    "a ring": (lambda: disc(22, 18), 0.5),
    "stripes": (lambda: np.tile(np.repeat([0.0, 1.0], 4), (64, 8)), 0.5),
    "another letter": (lambda: draw(vf.Text("recursive", "X"), SIZE), 0.7),
    "a letter upside down": (lambda: draw(vf.Text("recursive", "R"), SIZE)[::-1], 0.9),
}


@pytest.mark.parametrize(
    "what, name",
    [
        *[(what, "recursive") for what in list(OTHERS)[:2]],
        *[
            pytest.param(what, name, marks=pytest.mark.slow)
            for what in OTHERS
            for name in ("recursive", "dynapuff")
        ],
    ],
)
def test_a_picture_of_something_else_is_a_poor_match(what, name):
    picture, score = OTHERS[what]
    found = match(picture(), "R", name)
    assert found.status == "poor"
    assert found.score < score
    assert found.report().startswith("poor: ")
    assert "does not show an instance of this font" in found.report()
