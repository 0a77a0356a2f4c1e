"""What a match says, and what it leaves undetermined."""

from __future__ import annotations

import numpy as np
import pytest
from pictures import SIZE, draw, match

import vfwidget as vf
from vfwidget.matching import Match
from vfwidget.raster import frame


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


def test_a_match_is_shown_in_two_lines(found, ignorant):
    first, second = repr(found).splitlines()
    assert first.startswith("<Match: matched: DynaPuff explains ")
    assert second.startswith(" axes {") and "wght: 6" in second
    assert len(repr(ignorant).splitlines()) == 2


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


def test_a_fit_that_ends_too_early_says_so(image, found):
    assert found.converged
    assert "before it converged" not in found.report()
    early = match(image, "S", "dynapuff", max_iterations=0)
    assert not early.converged
    assert "The fit ended before it converged; a larger max_iterations" in early.report()


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
    assert all(type(value) is float for value in found.uncertainty.values())


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


def test_the_report_of_a_good_match_names_font_ink_and_axes(found):
    report = found.report()
    assert report.startswith("matched: ")
    assert found.text.font.family_name in report
    assert "100.0 % of the ink of 'S'" in report
    assert "wght        620 ± " in report
    assert "does not show an instance" not in report


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
