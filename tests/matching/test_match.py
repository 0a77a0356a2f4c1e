"""Matching finds known axes again, and reports what a picture does not determine."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import matplotlib as mpl
import numpy as np
import pytest
from pictures import axis_error, blurred, draw, miss, random_place, turned

import vfwidget as vf
from vfwidget.matching import Match
from vfwidget.matching.fit import Options, fit
from vfwidget.matching.images import basis
from vfwidget.matching.looks import View
from vfwidget.matching.placement import read_placement
from vfwidget.matching.scene import PLACEMENT, Scene, State, _blur
from vfwidget.raster import frame
from vfwidget.raster.coverage import fill

mpl.use("Agg")

SIZE = (64, 64)
CLEAN = 0.01
"""Within which every axis that can be told is found in a clean picture, normalized."""


def match(image, string, font, **options) -> Match:
    return vf.match(image, string, font, progress=False, **options)


@pytest.fixture(scope="module")
def text() -> vf.Text:
    return vf.Text("dynapuff", "S", axes={"wght": 620, "wdth": 84})


@pytest.fixture(scope="module")
def image(text) -> np.ndarray:
    return draw(text, SIZE)


@pytest.fixture(scope="module")
def found(image) -> Match:
    return match(image, "S", "dynapuff")


# Places are found again

FEW = [("dynapuff", "S"), ("recursive", "a"), ("afacad-flux", "g")]
MORE = [("shantell-sans", "hand"), ("recursive", "Rag"), ("roboto-flex", "R"), ("dynapuff", "&")]


@pytest.mark.parametrize(
    "name, string, seed",
    [
        *[(*word, 1) for word in FEW],
        *[
            pytest.param(*word, seed, marks=pytest.mark.slow)
            for word in [*FEW, *MORE]
            for seed in (2, 3, 4)
        ],
    ],
)
def test_a_place_is_found_in_its_own_picture(name, string, seed):
    truth = random_place(vf.Text(name, string), np.random.default_rng(seed))
    size = (128, 128)
    found = match(draw(truth, size), string, name)
    assert found.status == "matched"
    assert found.score > 0.9999
    assert axis_error(found, truth) < CLEAN
    assert abs(found.residual).max() < 0.02


@pytest.mark.parametrize(
    "name, string, seed",
    [
        ("dynapuff", "Sa", 1),
        pytest.param("recursive", "ag", 2, marks=pytest.mark.slow),
        pytest.param("afacad-flux", "ten", 3, marks=pytest.mark.slow),
    ],
)
def test_every_letter_has_its_own_axes(name, string, seed):
    truth = random_place(vf.Text(name, string, shared=False), np.random.default_rng(seed))
    found = match(draw(truth, (96, 128)), string, name, shared=False)
    assert found.text.theta.shape == truth.theta.shape
    assert found.status == "matched"
    assert axis_error(found, truth) < CLEAN
    for part in (found.axes, found.uncertainty, found.undetermined):
        assert isinstance(part, list)
        assert len(part) == len(string)


def test_a_placement_that_is_known_is_kept(text, image, found):
    placement = frame(text, SIZE)
    fixed = match(image, "S", "dynapuff", placement=placement, fit=())
    assert axis_error(fixed, text) < CLEAN
    assert fixed.status == "matched"
    assert fixed.placement.numpy() == pytest.approx(placement.numpy(), abs=1e-9)
    assert fixed.blur == 0
    assert abs(fixed.residual).max() < 0.02
    by_array = match(image, "S", "dynapuff", placement=placement.numpy(), fit=())
    assert by_array.axes == fixed.axes


@pytest.mark.parametrize("shift, fit, near", [(4, ("x", "y"), True), (4, (), False)])
def test_only_what_is_asked_for_is_fitted(shift, fit, near, text, image):
    placement = frame(text, SIZE).numpy()
    truth = placement.copy()
    placement[:, 2] += shift
    found = match(image, "S", "dynapuff", placement=placement, fit=fit)
    assert (miss(found, text, truth) < 0.1) is near
    assert found.placement[:, :2].numpy() == pytest.approx(placement[:, :2])


@pytest.mark.parametrize("degrees, scale, shift", [(0, 1, (0, 0)), (8, 0.9, (2, -3)), (-6, 1, 0)])
def test_where_the_letter_stands_is_found(degrees, scale, shift, text):
    truth = turned(text, SIZE, degrees, scale, shift)
    found = match(draw(text, SIZE, truth), "S", "dynapuff")
    assert found.status == "matched"
    assert axis_error(found, text) < CLEAN
    assert found.placement[:, :2].numpy() == pytest.approx(truth[:, :2], rel=1e-2, abs=1e-4)
    assert miss(found, text, truth) < 0.1


def test_fitting_may_begin_at_given_axes(text, image):
    start = {"wght": 600, "wdth": 86}
    found = match(image, "S", "dynapuff", axes=start, optimizer="adam", max_iterations=3)
    _, begin = found.history[0]
    elsewhere = match(
        image, "S", "dynapuff", axes={"wght": 400}, optimizer="adam", max_iterations=0
    )
    assert begin < elsewhere.history[0][1] / 2
    assert found.history[0][0].ravel() == pytest.approx(
        vf.load_font("dynapuff").normalize(start).numpy()
    )


def test_given_axes_are_fitted(text, image):
    found = match(image, "S", "dynapuff", axes={"wght": 560, "wdth": 90})
    assert axis_error(found, text) < CLEAN


def test_a_large_picture_is_made_smaller(text):
    image = draw(text, (200, 180))
    found = match(image, "S", "dynapuff", resolution=50)
    assert found.image.shape == found.target.shape == (200, 180)
    assert axis_error(found, text) < CLEAN
    assert miss(found, text, frame(text, (200, 180)).numpy()) < 0.3


# Glyphs that change at boundaries

SWAPPED = [
    ("g", {"MONO": 0.66, "wght": 500}, "g.mono"),
    ("k", {"CRSV": 0.95, "CASL": 0.5, "wght": 600, "slnt": -9}, "k.italic"),
]


@pytest.mark.parametrize("string, axes, glyph", SWAPPED)
def test_the_glyph_in_the_picture_is_found(string, axes, glyph):
    truth = vf.Text("recursive", string, axes=axes)
    assert [g.name for g in truth.glyphs] == [glyph]
    found = match(draw(truth, (96, 96)), string, "recursive")
    assert [g.name for g in found.text.glyphs] == [glyph]
    assert found.score > 0.9999
    assert axis_error(found, truth) < CLEAN


@pytest.mark.parametrize("string, axes, glyph", SWAPPED)
def test_a_fit_that_begins_with_another_glyph_finds_the_right_one(string, axes, glyph):
    truth = vf.Text("recursive", string, axes=axes)
    found = match(draw(truth, (96, 96)), string, "recursive", axes={"CRSV": 0.3})
    assert [g.name for g in found.text.glyphs] == [glyph]
    assert found.score > 0.9999


def test_a_fit_goes_on_beyond_a_boundary():
    text = vf.Text("recursive", "k", axes={"slnt": -14.9, "CRSV": 0.5})
    truth = text.at({"slnt": -13.9, "CRSV": 0.5, "wght": 350})
    assert text.glyphs != truth.glyphs
    size = (64, 64)
    scene = Scene(text, size)
    own = np.zeros((1, 2)), np.zeros(1)
    placement = read_placement(frame(truth, size), text)
    start = State(text.coordinates, placement, 0.0, np.array([1.0]), 0.0, *own)
    view = View(scene, draw(truth, size), start, ())
    found = fit(view, Options(()), 40)
    assert scene.text.moved(found.state.theta).glyphs == truth.glyphs
    assert found.loss < 1e-9
    assert len(found.path) == 1 + found.iterations + 1


def test_a_scene_has_the_glyphs_of_each_location():
    text = vf.Text("recursive", "kg")
    places = [{}, {"CRSV": 1}, {"MONO": 1}, {"MONO": 1, "slnt": -15}, {"CRSV": 0.9}]
    texts = [text.at(axes) for axes in places]
    scene = Scene(text, (40, 60))
    placement = read_placement(frame(text, (40, 60)), text)
    thetas = np.stack([one.coordinates for one in texts])
    covered = scene.coverage(thetas, np.tile(placement, (len(texts), 1)))
    for image, one in zip(covered, texts, strict=True):
        alone = vf.rasterize(one, (40, 60), scene.matrix(placement))
        assert image == pytest.approx(alone.numpy())
    assert len({tuple(g.name for g in one.glyphs) for one in texts}) == 3


# Pictures that are spoilt


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
def test_spoilt_pictures(how, seed):
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


# The two optimisers


def test_both_optimisers_come_to_the_same_axes(text, image, found):
    adam = match(image, "S", "dynapuff", optimizer="adam")
    assert adam.status == found.status == "matched"
    assert adam.text.theta.numpy() == pytest.approx(text.theta.numpy(), abs=CLEAN)
    assert adam.text.theta.numpy() == pytest.approx(found.text.theta.numpy(), abs=CLEAN)
    assert len(adam.history) == 101
    assert adam.loss == pytest.approx(min(loss for _, loss in adam.history), rel=1e-12)


@pytest.mark.parametrize("optimizer", ["gauss-newton", "adam"])
def test_the_loss_falls(optimizer):
    # So few pixels that all of the fit is at one resolution.
    truth = vf.Text("dynapuff", "S", axes={"wght": 455, "wdth": 91})
    found = match(draw(truth, (44, 44)), "S", "dynapuff", optimizer=optimizer)
    losses = [loss for _, loss in found.history]
    assert len(losses) > 2
    assert losses[-1] < losses[0] / 50
    assert found.loss == pytest.approx(min(losses))
    for theta, _ in found.history:
        assert theta.shape == tuple(found.text.theta.shape)
    if optimizer == "gauss-newton":
        assert all(b <= a for a, b in pairwise(losses))
        assert np.array_equal(found.history[-1][0], found.text.theta)


@pytest.mark.parametrize("optimizer", ["gauss-newton", "adam"])
def test_fits_are_watched(optimizer, image):
    seen = []
    found = match(
        image,
        "S",
        "dynapuff",
        optimizer=optimizer,
        max_iterations=15,
        watch=lambda text, loss: seen.append((text, loss)),
    )
    assert len(seen) > 1
    assert all(isinstance(text, vf.Text) and text.string == "S" for text, _ in seen)
    assert all(isinstance(loss, float) and loss >= 0 for _, loss in seen)
    best, _ = min(seen[-20:], key=lambda step: step[1])
    assert best.theta.numpy() == pytest.approx(found.text.theta.numpy(), abs=1e-3)
    unwatched = match(image, "S", "dynapuff", optimizer=optimizer, max_iterations=15)
    assert unwatched.axes == found.axes


def test_an_editor_shows_the_fit(image):
    editor = vf.Editor("recursive", "N")
    found = match(image, "S", "dynapuff", watch=editor)
    assert editor.text.string == "S"
    assert editor.text.font.family_name == found.text.font.family_name
    assert editor.axes == pytest.approx(found.axes, abs=1)
    assert editor.axes != vf.Text("dynapuff", "S").axes


def test_progress_is_shown_unless_declined(image, capsys):
    vf.match(image, "S", "dynapuff", max_iterations=1)
    assert "match" in capsys.readouterr().err
    match(image, "S", "dynapuff", max_iterations=1)
    assert capsys.readouterr().err == ""


# What a match says


def test_a_match_speaks_of_one_state(found, text, image):
    assert found.axes == found.text.axes
    assert found.axes == pytest.approx({"wght": 620, "wdth": 84}, abs=1)
    assert found.loss == pytest.approx(found.outcome.loss)
    assert found.ranking in ((), (found,))
    assert found.left_out == {}
    assert np.array_equal(found.target, image)
    # The fitted picture is that of the text found, at the placement found.
    redrawn = 1 - vf.rasterize(found.text, SIZE, found.placement)
    assert found.image.numpy() == pytest.approx(redrawn.numpy(), abs=0.01)
    assert np.array_equal(found.residual.numpy(), found.image.numpy() - image)
    assert abs(found.residual).max() < 0.01
    assert found.placement.numpy() == pytest.approx(frame(text, SIZE).numpy(), abs=0.1)


def test_an_image_is_not_changed(image, text):
    given = image.copy()
    match(given, "S", "dynapuff")
    assert np.array_equal(given, image)


@pytest.fixture(scope="module")
def ignorant() -> Match:
    """Of a letter that two of its font's axes do not move."""
    axes = {"CASL": 0.4, "wght": 700, "slnt": -5}
    truth = vf.Text("recursive", "g", axes=axes, shared=False)
    return match(draw(truth, SIZE), "g", "recursive", shared=False)


def test_what_the_letter_ignores_is_undetermined(ignorant):
    assert ignorant.undetermined == [("MONO", "CRSV")]
    (axes,), (spread,) = ignorant.axes, ignorant.uncertainty
    assert (axes["MONO"], axes["CRSV"]) == (0, 0.5)
    assert axes["wght"] == pytest.approx(700, abs=2)
    assert [tag for tag, value in spread.items() if value == np.inf] == ["MONO", "CRSV"]


def test_what_one_letter_of_several_ignores_is_undetermined():
    axes = [{"MONO": 1, "wght": 700}, {"wght": 500}]
    truth = vf.Text("recursive", "ag", axes=axes, shared=False)
    found = match(draw(truth, (64, 96)), "ag", "recursive", shared=False)
    # MONO changes the kern before the g, but CRSV changes nothing of it.
    assert "CRSV" in found.undetermined[1]
    assert found.axes[1]["MONO"] == pytest.approx(0, abs=1e-6)


def test_uncertainty_is_in_user_units(found):
    font, theta = found.text.font, found.text.theta[0].numpy()
    for i, axis in enumerate(font.axes):
        step = 1e-5 * np.eye(len(theta))[i]
        there, back = (font.denormalize(theta + s)[axis.tag] for s in (step, -step))
        expected = (there - back) / 2e-5 * found.outcome.deviation[0, i]
        assert found.uncertainty[axis.tag] == pytest.approx(expected, rel=1e-3)


def errors_in_deviations(name, string, axes, noise, count):
    """|Δw| by the deviation claimed, (count, axes that are seen)."""
    truth = vf.Text(name, string, axes=axes)
    clean = 0.1 + 0.8 * draw(truth, (48, 48))
    ratios = []
    for seed in range(count):
        rng = np.random.default_rng(seed)
        found = match(clean + rng.normal(0, noise, clean.shape), string, name, background="even")
        seen = found.outcome.deviation < 0.05
        assert seen.any()
        error = (found.text.theta - truth.theta).abs().numpy()
        ratios.append(error[seen] / found.outcome.deviation[seen])
    return np.concatenate(ratios)


@pytest.mark.parametrize(
    "name, string, axes, count",
    [
        ("dynapuff", "S", {"wght": 570, "wdth": 88}, 10),
        pytest.param("dynapuff", "S", {"wght": 570, "wdth": 88}, 60, marks=pytest.mark.slow),
        pytest.param("afacad-flux", "g", {"wght": 610, "slnt": -6}, 40, marks=pytest.mark.slow),
    ],
)
def test_uncertainty_covers_the_truth(name, string, axes, count):
    ratios = errors_in_deviations(name, string, axes, 0.03, count)
    assert (ratios < 4).mean() > 0.95
    # Nor is it more than need be: of a normal deviate the mean is 0.8.
    assert 0.3 < ratios.mean() < 1.6


def test_a_report(found):
    report = found.report()
    assert report.startswith("matched: ")
    assert found.text.font.family_name in report
    assert "100.0 % of the ink of 'S'" in report
    assert "wght        620 ± " in report
    assert "trust no axis" not in report


def test_a_report_of_each_letter_and_of_what_is_not_seen(ignorant):
    lines = ignorant.report().splitlines()
    assert len(lines) == 1 + len(ignorant.text.font.axes)
    assert all(line.startswith("g ") for line in lines[1:])
    hidden = [line.split()[1] for line in lines if line.endswith("not determined by this picture")]
    assert hidden == ["MONO", "CRSV"]


def test_a_plot_shows_what_the_match_holds(found):
    import matplotlib.pyplot as plt

    panels = found.plot()
    try:
        given, fitted, left, loss = panels
        shown = [panel.images[0].get_array() for panel in (given, fitted, left)]
        assert np.array_equal(shown[0], found.target)
        assert np.array_equal(shown[1], found.image)
        assert np.array_equal(shown[2], found.residual)
        assert np.array_equal(loss.lines[0].get_ydata(), [value for _, value in found.history])
        low, high = left.images[0].get_clim()
        assert low == -high
        assert found.text.font.family_name in fitted.get_title()
        _, own = plt.subplots(2, 2)
        assert list(found.plot(own)) == list(own.ravel())
    finally:
        plt.close("all")


# The scene and its derivative


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


# Pictures of something else


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


# Bad input

SHEAR = [[0.03, 0.01, 10], [0, -0.03, 50]]
OPTIONS = {
    "a fit of nothing known": ({"fit": ["x", "skew"]}, "'skew' cannot be fitted: choose from x, y"),
    "a fit as one word": ({"fit": "blur"}, "fit is a sequence of names"),
    "optimizer": ({"optimizer": "newton"}, "no optimizer 'newton': choose one of gauss-newton"),
    "loss": ({"loss": "l3"}, "There is no loss 'l3': choose one of linear"),
    "ink": ({"ink": "red"}, "ink is one of auto, dark, light, not 'red'"),
    "background": ({"background": "odd"}, "background is one of even, uneven, not 'odd'"),
    "a sheared placement": ({"placement": SHEAR}, "A placement scales, rotates and shifts"),
    "a placement with y up": ({"placement": np.eye(2, 3)}, "turns y down"),
    "a placement of no size": ({"placement": np.zeros((2, 3))}, "A placement scales"),
    "a square placement": ({"placement": np.eye(3)}, r"finite \(2, 3\) matrix, not \(3, 3\)"),
    "a placement of NaN": ({"placement": np.full((2, 3), np.nan)}, "A placement is a finite"),
    "a second font": ({"fonts": ["dynapuff"]}, r"Give a font, or several as fonts=\[…\]"),
}


@pytest.mark.parametrize("options, message", OPTIONS.values(), ids=OPTIONS)
def test_options_that_are_none(options, message, image):
    with pytest.raises(vf.ImageError, match=message):
        match(image, "S", "dynapuff", **options)


def test_a_font_has_to_be_given(image):
    with pytest.raises(vf.ImageError, match=r"Give a font, or several as fonts=\[…\]"):
        vf.match(image, "S", progress=False)


@pytest.mark.parametrize("string", [" ", "  ", "\u00a0"], ids=ascii)
def test_a_text_without_ink(string, image):
    with pytest.raises(vf.ImageError, match="no ink to match"):
        match(image, string, "recursive")


@pytest.mark.parametrize(
    "string, font, options, error, message",
    [
        ("あ", "dynapuff", {}, vf.GlyphError, "no glyph"),
        ("", "dynapuff", {}, vf.TextError, "is empty"),
        ("S", "no-such-font", {}, vf.FontError, "no-such-font"),
        ("S", b"no font", {}, vf.FontError, "Not a font file"),
        ("S", "dynapuff", {"axes": {"opsz": 9}}, vf.AxisError, "Unknown axis 'opsz'"),
    ],
)
def test_texts_and_fonts_fail_as_everywhere(string, font, options, error, message, image):
    with pytest.raises(error, match=message):
        match(image, string, font, **options)


def test_a_text_brings_its_font_and_how_axes_are_shared():
    text = vf.Text("dynapuff", "n", shared=False).at(axes=[{"wght": 600}])
    found = vf.match(1 - vf.rasterize(text, (48, 48)).numpy(), text, progress=False)
    assert not found.text.shared
    assert found.axes[0]["wght"] == pytest.approx(600, abs=1)


def test_candidates_of_a_long_text_are_drawn_a_few_at_a_time(monkeypatch):
    text = vf.Text("dynapuff", "long text", axes={"wght": 600})
    drawn = []

    def watched(points, *others):
        drawn.append(points.shape[:2])
        return fill(points, *others)

    monkeypatch.setattr("vfwidget.matching.scene.fill", watched)
    here = Scene(text, (12, 48))
    thetas = np.linspace(0, 1, 7)[:, None, None] * text.coordinates
    places = np.tile(np.array([24.0, 6.0, np.log(0.01), 0.0]), (7, 1))
    together = here.coverage(thetas, places)
    curves = drawn[0][1]
    monkeypatch.setattr("vfwidget.matching.scene.BATCH", 3 * curves)
    np.testing.assert_allclose(here.coverage(thetas, places), together, atol=1e-12)
    monkeypatch.setattr("vfwidget.matching.scene.BATCH", curves // 2)
    np.testing.assert_allclose(here.coverage(thetas, places), together, atol=1e-12)
    assert [count for count, _ in drawn] == [7, 3, 2, 2, 1, 1, 1, 1, 1, 1, 1]
