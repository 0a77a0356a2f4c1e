"""Keyframes, easing, delays, and compositions of animations."""

from __future__ import annotations

import numpy as np
import pytest

import vfwidget as vf

BACK = (0.36, -0.6, 0.66, 1.6)
"""An easing that goes beyond both ends of the way."""


@pytest.fixture(scope="module")
def thin():
    return vf.Text("recursive", "abc", axes={"wght": 300})


@pytest.fixture(scope="module")
def bold(thin):
    return thin.at(axes={"wght": 900}, offsets=[(0, 0), (0, 100), (0, 0)])


@pytest.fixture(scope="module")
def rise(thin, bold):
    return vf.Animation.from_keyframes([(0, thin), (1, bold)], "linear", fps=10)


def test_keyframes_are_reached_and_the_way_is_straight(thin, bold, rise) -> None:
    assert len(rise) == 11
    np.testing.assert_array_equal(rise.theta[0], thin.theta)
    np.testing.assert_array_equal(rise.theta[-1], bold.theta)
    np.testing.assert_allclose(rise.theta[5], (thin.theta + bold.theta) / 2)
    assert rise.offsets[5, 1, 1] == pytest.approx(50)


def test_named_easings_are_those_of_css(thin, bold) -> None:
    def parts(easing):
        eased = vf.Animation.from_keyframes([(0, thin), (1, bold)], easing, fps=4)
        return eased.offsets[:, 1, 1] / 100

    # Chromium computes 0.1291 for ease-in-out at 0.25 and 0.4085 for ease.
    np.testing.assert_allclose(parts("ease-in-out")[:3], [0, 0.1291, 0.5], atol=2e-4)
    assert parts("ease")[1] == pytest.approx(0.4085, abs=2e-4)
    np.testing.assert_allclose(parts((0, 0, 1, 1)), parts("linear"), atol=1e-9)
    np.testing.assert_allclose(parts(lambda part: part**2), [0, 1 / 16, 1 / 4, 9 / 16, 1])


def test_a_delay_makes_a_wave(thin, bold) -> None:
    wave = vf.Animation.from_keyframes([(0, thin), (0.5, bold)], "linear", delay=0.2, fps=10)
    assert not wave.text.shared
    assert wave.duration == pytest.approx(0.9)
    first, last = wave.theta[:, 0], wave.theta[:, 2]
    np.testing.assert_allclose(last[4:], first[:-4])
    np.testing.assert_array_equal(last[:5], np.repeat(last[:1], 5, axis=0))


def test_solved_edits_are_keyframes(thin) -> None:
    handle = thin.nearest(100, 500)
    x, y = thin.position(handle).tolist()
    edited = vf.solve(thin, vf.Target(handle, (x - 20, y))).text
    between = vf.Animation.from_keyframes([(0, thin), (1, edited)])
    assert float(between[-1].position(handle)[0]) == pytest.approx(x - 20, abs=0.5)


def test_a_target_that_moves_is_followed(thin) -> None:
    handle = thin.nearest(100, 500)
    x, y = thin.position(handle).tolist()

    def terms(time):
        return [vf.Target(handle, (x - 20 * time, y)), vf.StayClose()]

    led = vf.Animation.from_terms(thin, terms, 1.0, fps=5)
    found = [float(frame.position(handle)[0]) for frame in led]
    np.testing.assert_allclose(found, x - 20 * led.times, atol=0.5)


@pytest.mark.parametrize("free", [["tracking"], ["offsets", "tracking"], ["axes", "tracking"]])
def test_the_frames_of_terms_show_the_tracking_that_was_solved_for(thin, free) -> None:
    point = thin.handle(glyph=2, contour=0, segment=0)
    x, y = thin.position(point)

    def terms(time):
        return [vf.Target(point, (x + 50 + 100 * time, y)), vf.StayClose()]

    animation = vf.Animation.from_terms(thin, terms, 0.2, fps=10, free=free)
    for time, frame in zip(animation.times, animation, strict=True):
        np.testing.assert_allclose(frame.position(point), (x + 50 + 100 * time, y), atol=0.5)


def test_chains_loops_and_reversals(rise) -> None:
    back = rise.reverse()
    np.testing.assert_array_equal(back.theta, rise.theta[::-1])
    np.testing.assert_allclose(back.times, rise.times)
    both = rise.chain(back)
    assert len(both) == 22
    assert both.times[11] == pytest.approx(1.1)
    again = rise.loop(3)
    assert len(again) == 33
    np.testing.assert_array_equal(again.theta[22:], rise.theta)


def test_retiming_keeps_the_frames_and_changes_the_speed(rise) -> None:
    slow = rise.retime(2.0)
    assert slow.duration == 2
    assert slow.fps == pytest.approx(rise.fps)
    np.testing.assert_allclose(slow.theta[::2], rise.theta)
    eased = rise.retime(easing="ease-in")
    assert eased.offsets[5, 1, 1] < 40
    assert eased.offsets[-1, 1, 1] == 100


def test_an_overlay_adds_a_motion(thin, rise) -> None:
    shift = vf.Animation.from_keyframes(
        [(0, thin), (2, thin.at(offsets=[(10, 0)] * 3))], "linear", fps=10
    )
    both = rise.overlay(shift)
    assert both.duration == 2
    np.testing.assert_allclose(both.offsets[-1], [[10, 0], [10, 100], [10, 0]])
    np.testing.assert_allclose(both.theta[:11], rise.theta, atol=1e-12)
    # Two motions to the bold end stay there.
    assert (rise.overlay(rise).theta <= 1).all()


def test_an_easing_that_overshoots_stays_within_the_design_space(thin, bold) -> None:
    there, back = (
        vf.Animation.from_keyframes([(0, one), (1, other.at(offsets=[(0, 100)] * 3))], BACK)
        for one, other in ((thin, bold), (bold, thin))
    )
    for animation in (there, back):
        assert animation.offsets.max() > 105 and animation.offsets.min() < -5
        low, high = thin.font.bounds
        assert (animation.theta >= low).all() and (animation.theta <= high).all()


def test_the_energy_and_the_penetration_go_along(thin) -> None:
    fall = vf.simulate(thin, 4, forces=(0, -100), positions=True, progress=False)
    assert fall.chain(fall).energy.shape == (10,)
    np.testing.assert_array_equal(fall.reverse().energy, fall.energy[::-1])
    assert fall.overlay(fall).energy is None


@pytest.mark.parametrize(
    ("keyframes", "message"),
    [
        ([], "pairs of seconds and a Text"),
        ([(0, "a")], "pairs of seconds and a Text"),
        (7, "pairs of seconds and a Text"),
        ("decreasing", "must increase"),
        ("enormous", "at most 1e"),
        ("other", "'abc' and 'abd' differ in: string; font"),
    ],
)
def test_wrong_keyframes_are_refused(thin, keyframes, message) -> None:
    if keyframes == "decreasing":
        keyframes = [(1, thin), (0, thin)]
    elif keyframes == "enormous":
        keyframes = [(-1e308, thin), (1e308, thin)]
    elif keyframes == "other":
        keyframes = [(0, thin), (1, vf.Text("recursive", "abd"))]
    with pytest.raises(vf.MotionError, match=message):
        vf.Animation.from_keyframes(keyframes)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"features": {"kern": False}}, "differ in: features, language, script or direction. Make"),
        ({"direction": "rtl"}, "differ in: features, language, script or direction"),
        ({"line_height": 900}, "differ in: line height"),
        ({"tracking": 10}, "differ in: tracking"),
        ({"shared": False}, "differ in: value of shared"),
    ],
)
def test_keyframes_set_in_other_ways_are_refused(thin, options, message) -> None:
    other = vf.Text(thin.font, "abc", **options)
    with pytest.raises(vf.MotionError, match=message):
        vf.Animation.from_keyframes([(0, thin), (1, other)])


def test_keyframes_between_which_a_ligature_is_made_are_refused_with_a_remedy() -> None:
    upright = vf.Text("recursive", "fi")
    slanted = upright.at(axes={"slnt": -15})
    with pytest.raises(vf.MotionError, match=r"number of glyphs.*\{'liga': False\}"):
        vf.Animation.from_keyframes([(0, upright), (1, slanted)])
    apart = vf.Text("recursive", "fi", features={"liga": False})
    states = [(0, apart), (1, apart.at(axes={"slnt": -15}))]
    assert vf.Animation.from_keyframes(states).to_css()


def test_a_font_that_was_loaded_twice_is_named(thin) -> None:
    other = vf.Text("recursive", "abc")
    with pytest.raises(vf.MotionError, match="load a font once and pass it to each Text"):
        vf.Animation.from_keyframes([(0, thin), (1, other)])


def test_only_animations_are_combined(thin, rise) -> None:
    for combine in rise.chain, rise.overlay:
        with pytest.raises(vf.MotionError, match="another Animation; received list"):
            combine([rise])
    with pytest.raises(vf.MotionError, match="terms must be a function"):
        vf.Animation.from_terms(thin, vf.StayClose(), 1.0)
    with pytest.raises(vf.MotionError, match="time must be a finite number"):
        rise.at(float("nan"))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"easing": "bouncy"}, "easing must be one of"),
        ({"easing": lambda part: None}, "easing must take an array"),
        ({"easing": lambda part: 0.5}, "easing must take an array"),
        ({"easing": lambda part: part * np.nan}, "easing must take an array"),
        ({"easing": (2, 0, 1, 1)}, "easing must be one of"),
        ({"delay": -1}, "delay must be"),
        ({"delay": [1, 2]}, "delay must be"),
        ({"fps": 0}, "fps must be"),
        ({"fps": 10**400}, "fps must be"),
        ({"fps": 1e9}, "100,000"),
        ({"fps": 1e300}, "100,000"),
        ({"delay": np.inf}, "delay must be"),
        ({"delay": -np.inf}, "delay must be"),
        ({"delay": 1e300}, "delay must be"),
        ({"delay": 1e9}, "100,000"),
        ({"easing": np.zeros((2, 2))}, "easing must be one of"),
    ],
)
def test_wrong_options_are_refused(thin, bold, options, message) -> None:
    with pytest.raises(vf.MotionError, match=message):
        vf.Animation.from_keyframes([(0, thin), (1, bold)], **options)
    with pytest.raises(vf.MotionError, match="count must be"):
        vf.Animation.from_keyframes([(0, thin), (1, bold)]).loop(0)


def test_too_many_frames_are_refused_before_any_is_made(thin, rise) -> None:
    for make in (
        lambda: rise.loop(99_999),
        lambda: rise.retime(1e9),
        lambda: rise.retime(fps=1e300),
        lambda: vf.Animation.from_terms(thin, lambda time: vf.StayClose(), 1e300),
    ):
        with pytest.raises(vf.MotionError, match="100,000"):
            make()


def test_terms_are_a_function_of_the_time(thin) -> None:
    with pytest.raises(vf.MotionError, match="function of the time"):
        vf.Animation.from_terms(thin, vf.StayClose(), 1)
