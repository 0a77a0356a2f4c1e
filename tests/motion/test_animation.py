"""Animations hold frames, and refuse arrays that are none."""

from __future__ import annotations

import numpy as np
import pytest

import vfwidget as vf


@pytest.fixture(scope="module")
def wave():
    """Three letters whose weight rises, while the second one is lifted."""
    text = vf.Text("afacad-flux", "abc", shared=False)
    theta = np.zeros((5, 3, 2))
    theta[:, 1, 1] = np.linspace(0, 0.5, 5)
    offsets = np.zeros((5, 3, 2))
    offsets[:, 1, 1] = np.linspace(0, 200, 5)
    return vf.Animation(text, np.linspace(1, 2, 5), theta, offsets)


def test_frames_are_texts_at_their_positions(wave) -> None:
    assert len(wave) == len(list(wave)) == 5
    last = wave[-1]
    assert isinstance(last, vf.Text)
    np.testing.assert_array_equal(last.theta, wave.theta[-1])
    placed = [(glyph.x, glyph.y) for glyph in last.layout]
    np.testing.assert_array_equal(wave.positions[-1], placed)
    assert wave.positions[-1, 1, 1] == 200
    # The second letter becomes narrower.
    assert wave.positions[-1, 2, 0] < wave.positions[0, 2, 0]
    assert wave.duration == 1
    assert wave.fps == 4


def test_a_slice_is_an_animation(wave) -> None:
    part = wave[1:4]
    assert isinstance(part, vf.Animation)
    np.testing.assert_array_equal(part.times, wave.times[1:4])
    np.testing.assert_array_equal(part.offsets, wave.offsets[1:4])
    with pytest.raises(vf.MotionError, match="order of time"):
        wave[::-1]
    for empty in (slice(3, 3), slice("a", None), slice(None, None, 0)):
        with pytest.raises(vf.MotionError, match="must hold frames"):
            wave[empty]


def test_an_animation_cannot_be_changed(wave) -> None:
    with pytest.raises(ValueError, match="read-only"):
        wave.theta[0] = 1


def test_an_energy_and_contours_of_obstacles_are_optional(wave) -> None:
    assert wave.energy is None
    assert wave.scenery == ((),) * 5
    assert not wave.penetration.any()


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"text": "abc"}, "text must be a Text"),
        ({"times": [0, 0, 1, 2, 3]}, "increasing"),
        ({"times": []}, "increasing"),
        ({"times": [0, 1, 2, 3, np.nan]}, "finite"),
        ({"theta": np.zeros((5, 1, 2))}, r"\(5, 3, 2\)"),
        ({"theta": np.full((5, 3, 2), np.inf)}, "finite"),
        ({"offsets": np.zeros((5, 2))}, r"\(5, 3, 2\)"),
        ({"rotations": "turned"}, r"\(5, 3\)"),
        ({"energy": [1, 2]}, r"\(5,\)"),
        ({"scenery": [[]]}, "5 frames"),
        ({"scenery": 7}, "scenery must hold"),
        ({"scenery": [[[1, 2]]] * 5}, "shape"),
        ({"scenery": [[np.full((1, 4, 2), np.nan)]] * 5}, "finite"),
        ({"times": [-1.7e308, 0, 1, 2, 1.7e308]}, "at most 1e"),
        ({"offsets": np.full((5, 3, 2), 1e300)}, "at most 1e"),
        ({"energy": [10**400] * 5}, "energy must be"),
    ],
)
def test_wrong_arrays_are_refused(wave, changed, message) -> None:
    given = {"text": wave.text, "times": wave.times, "theta": wave.theta, **changed}
    with pytest.raises(vf.MotionError, match=message):
        vf.Animation(**given)


@pytest.mark.parametrize("time", [np.nan, np.inf, 10**400, "now", None, [0, 1]])
def test_a_time_is_a_finite_number(wave, time) -> None:
    with pytest.raises(vf.MotionError, match="time must be a finite number; received"):
        wave.at(time)


def test_far_times_are_those_of_the_ends(wave) -> None:
    with np.errstate(all="raise"):
        assert wave.at(1e308).axes == wave[-1].axes
        assert wave.at(-1e308).axes == wave[0].axes


@pytest.mark.parametrize("index", [1.5, "first", [0, 1], None, 5, -6, 10**400])
def test_a_frame_has_a_whole_number(wave, index) -> None:
    with pytest.raises(vf.MotionError, match=r"has frames 0 to 4.* -1; received "):
        wave[index]


@pytest.mark.parametrize("axes", ["x", [1, 2, 3, 4], [None]])
def test_a_plot_needs_four_axes(wave, axes) -> None:
    with pytest.raises(vf.MotionError, match="axes must be four matplotlib Axes; received"):
        wave.plot(axes)


@pytest.mark.parametrize("other", [None, 1, "again", []])
def test_only_animations_can_be_joined(wave, other) -> None:
    for join in (wave.chain, wave.overlay):
        with pytest.raises(vf.MotionError, match="Pass another Animation"):
            join(other)


def test_coordinates_beyond_the_axes_are_clamped_with_a_warning(wave) -> None:
    with pytest.warns(vf.AxisWarning, match="clamped"):
        wide = vf.Animation(wave.text, [0, 1], [wave.theta[0] + 3, wave.theta[1]])
    assert wide.theta.max() == 1
    drawn = wave.text.at(theta=np.ones((3, 2))).points()
    np.testing.assert_array_equal(wide[0].points(), drawn)
