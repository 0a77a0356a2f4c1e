"""Matching finds known axes, places and glyphs again."""

from __future__ import annotations

import importlib
from itertools import pairwise

import numpy as np
import pytest
from pictures import CLEAN, SIZE, axis_error, draw, match, miss, random_place, turned

import vfwidget as vf
from vfwidget.energy.descent import descend
from vfwidget.matching.fit import Options, fit
from vfwidget.matching.looks import View
from vfwidget.matching.placement import read_placement
from vfwidget.matching.scene import Scene, State
from vfwidget.matching.start import settled
from vfwidget.raster import frame

FIT = importlib.import_module("vfwidget.matching.fit")
"""The module; the package exports its function under the same name."""
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
    assert scene.text.moved(fit(view, Options(()), 40).state.theta).glyphs == text.glyphs
    found = fit(view, Options(()), 40, crosses=True)
    assert scene.text.moved(found.state.theta).glyphs == truth.glyphs
    assert found.loss < 1e-9
    assert len(found.path) == 1 + found.iterations + 1


def view_of_letters_beyond_boundaries(string: str, **more: float) -> View:
    """The picture of some upright k, and those in italics next to the boundary to start from."""
    text = vf.Text("recursive", string, axes={"slnt": -14.9, "CRSV": 0.5}, shared=False)
    truth = text.at({"slnt": -13.9, "CRSV": 0.5, **more})
    size = (32, 32 * len(string))
    start = State(
        theta=text.coordinates,
        placement=read_placement(frame(truth, size), text),
        blur=0.0,
        light=np.array([1.0]),
        ink=0.0,
        offsets=np.zeros((len(string), 2)),
        tracking=np.zeros(1),
    )
    return View(Scene(text, size), draw(truth, size), start, ())


@pytest.mark.parametrize("multiple", [0, 1, 5])
def test_letters_with_their_own_axes_cross_boundaries_in_a_limited_number_of_steps(
    multiple, monkeypatch
):
    steps = []

    def counted(*given):
        found = descend(*given)
        steps.append(found.iterations)
        return found

    view = view_of_letters_beyond_boundaries("kkk")
    monkeypatch.setattr(FIT, "descend", counted)
    monkeypatch.setattr(FIT, "MOST_BEYOND", multiple)
    found = fit(view, Options(()), 3, crosses=True)
    assert sum(steps[1:]) <= multiple * 3
    names = [glyph.name for glyph in view.scene.text.moved(found.state.theta).glyphs]
    assert names.count("k") == {0: 0, 1: 2, 5: 3}[multiple]
    assert found.converged is (multiple == 5)


def test_a_promising_trial_beyond_a_boundary_goes_on_where_it_ended(monkeypatch):
    limits = []

    def noted(*given):
        limits.append(given[3])
        return descend(*given)

    view = view_of_letters_beyond_boundaries("k", slnt=-9.0, wght=900.0, CASL=1.0)
    monkeypatch.setattr(FIT, "descend", noted)
    found = fit(view, Options(()), 40, crosses=True)
    assert limits == [40, FIT.TRIAL_STEPS, 40 - FIT.TRIAL_STEPS]
    assert found.converged
    assert view.scene.text.moved(found.state.theta).glyphs[0].name == "k"
    # The start, every step, and the start beyond the boundary, each of them once.
    assert len(found.path) == found.iterations + 2
    thetas = [state.theta for state in found.path]
    assert all((a != b).any() for a, b in pairwise(thetas))


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


def test_an_axis_that_moves_nothing_stands_where_the_text_has_it():
    text = vf.Text("recursive", "Rig", axes={"wght": 640})
    cursive = [axis.tag for axis in text.font.axes].index("CRSV")
    theta = text.coordinates.copy()
    theta[0, :2] = 0.3
    # Beyond two boundaries the glyphs are those of the text again.
    theta[0, cursive] = -0.9
    found = settled(text, theta)
    assert found[0, cursive] == 0
    np.testing.assert_array_equal(np.delete(found, cursive, 1), np.delete(theta, cursive, 1))
    # These glyphs are others, so the axis has to stay.
    theta[0, cursive] = 0.9
    np.testing.assert_array_equal(settled(text, theta), theta)
