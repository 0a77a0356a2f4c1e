"""Obstacles that change over time: they appear, bend, and become invalid."""

from __future__ import annotations

import numpy as np
import pytest
from shapely.geometry import Polygon
from shapely.ops import unary_union

import vfwidget as vf
from tests.motion.falls import FLOOR, simulated
from tests.overlap.polygons import filled, simple
from vfwidget.motion.body import Body
from vfwidget.motion.free_step import FreeStep
from vfwidget.motion.laws import Laws, State
from vfwidget.motion.scene import Scene, _stroke
from vfwidget.motion.steps import Stepper
from vfwidget.overlap.shape import letters


def pusher(time, speed=3000.0, more=False):
    """A bar that comes from the left; with ``more``, its lower side has another corner."""
    x = -260 + speed * time
    corners = [(x - 200, -200), (x, -200), (x, 900), (x - 200, 900)]
    return [*corners[:1], (x - 100, -200), *corners[1:]] if more else corners


def odd(time):
    """Whether the frame of 1/60 s at a time has an odd number."""
    return int(60 * time + 1e-6) % 2 == 1


@pytest.mark.parametrize("changes", ["a later obstacle", "an earlier obstacle", "corners"])
def test_a_bar_pushes_a_letter_while_the_structure_of_the_obstacles_changes(changes) -> None:
    far = [(9000, 0), (9100, 0), (9100, 100), (9000, 100)]

    def obstacles(time):
        if changes == "corners":
            return [pusher(time, more=odd(time))]
        both = [pusher(time), far] if changes == "a later obstacle" else [far, pusher(time)]
        return both if odd(time) else [pusher(time)]

    pushed = simulated(vf.Text("recursive", "I"), 11, obstacles=obstacles, positions=True)
    assert pushed.penetration.max() < 0.5
    found = vf.overlaps(pushed[-1], [pusher(pushed.times[-1])])
    assert sum(overlap.area for overlap in found) < 100
    assert pushed.positions[-1, 0, 0] > 200


def rectangle(left, bottom, right, top):
    return [(left, bottom), (right, bottom), (right, top), (left, top)]


@pytest.mark.parametrize("later", [False, True], ids=["at the start", "later"])
@pytest.mark.parametrize("string", ["I", "ab"])
@pytest.mark.parametrize(
    "obstacles",
    [
        [rectangle(-3000, 300, 3000, 400)],
        [rectangle(100, -3000, 300, 3000)],
        [rectangle(-2000, -2000, 4000, 4000)],
        [rectangle(-300, -300, 250, 900), rectangle(250, -300, 1200, 900)],
    ],
    ids=["a bar across the stems", "a column", "a large square", "two squares"],
)
@pytest.mark.filterwarnings("ignore:At the start:vfwidget.errors.MotionWarning")
def test_letters_inside_obstacles_are_moved_out(string, obstacles, later) -> None:
    text = vf.Text("recursive", string)
    given = (lambda t: obstacles if t > 0.02 else []) if later else obstacles
    moved = simulated(text, 4, obstacles=given, positions=True)
    assert moved.penetration.max() < 0.5
    ink = [filled(simple(letter)) for letter in letters(moved[-1])]
    others = unary_union([Polygon(corners) for corners in obstacles])
    for i, one in enumerate(ink):
        assert one.intersection(unary_union([others, *ink[:i]])).area < 5
    # They do not leave farther than the obstacles reach, and are not thrown.
    assert abs(moved.positions[-1] - moved.positions[0]).max() < 3300
    assert abs(np.diff(moved.positions[2:], axis=0)).max() < 10


@pytest.mark.parametrize("size", [200, 2000])
def test_a_letter_that_a_new_obstacle_covers_is_moved_out_and_not_thrown(size: int) -> None:
    text = vf.Text("recursive", "o")
    (_, low), (right, high) = text.points().amin(0).tolist(), text.points().amax(0).tolist()
    left, bottom = right - size / 10, (low + high - size) / 2
    square = [(left, bottom), (left + size, bottom)]
    square += [(x, y + size) for x, y in reversed(square)]
    # The letter moves along the side of the square at 120 units a second.
    moved = simulated(
        text,
        30,
        obstacles=lambda t: [square] if t > 0.1 else [],
        impulses=[(0, (0, 120))],
        friction=0,
        positions=True,
    )
    assert vf.overlaps(moved[-1], [square]) == []
    steps = np.diff(moved.positions[:, 0], axis=0)
    appears = int(np.argmax(moved.times > 0.1)) - 1
    # Axes that made room swing back, and the outline with them.
    np.testing.assert_allclose(np.delete(steps[:, 1], appears), 2, atol=1)
    assert abs(np.delete(steps[:, 0], appears)).max() < 2
    assert moved.positions[-1, 0, 0] < -size / 20


@pytest.mark.parametrize(("low", "high"), [(300, 400), (-3000, 3000)])
def test_a_frame_with_a_deep_overlap_says_how_deep_it_is(monkeypatch, low, high) -> None:
    # The steps are replaced by steps that do not see the bar. It crosses the stem, and no corner of
    # either shape lies in the other one; or it covers the letter.
    monkeypatch.setattr(Stepper, "moved", lambda self, state, *rest: state)
    bar = [(-3000, low), (3000, low), (3000, high), (-3000, high)]
    text = vf.Text("recursive", "I")
    with pytest.warns(vf.MotionWarning, match="shapes enter each other"):
        crossed = simulated(text, 2, obstacles=lambda t: [bar] if t > 0.02 else [], positions=True)
    (overlap,) = vf.overlaps(crossed[2], [bar])
    assert crossed.penetration.tolist() == [0, 0, pytest.approx(overlap.depth)]
    assert overlap.depth > 40


@pytest.mark.parametrize(
    ("later", "said"),
    [
        ([[(-3000, -700), (3000, -700), (3000, -699.5), (-3000, -699.5)]], "0.5 font units thick"),
        ([[(0, np.nan), (1, 0), (1, 1), (0, 1)]], "obstacles cannot be read"),
    ],
)
def test_obstacles_that_become_wrong_are_refused_and_the_frames_so_far_kept(later, said) -> None:
    floor = [[(-3000, -750), (3000, -750), (3000, -700), (-3000, -700)]]
    with pytest.raises(vf.MotionError, match=said) as caught:
        simulated(
            vf.Text("recursive", "O"),
            9,
            obstacles=lambda t: later if t > 0.07 else floor,
            positions=True,
        )
    assert "t 0.08333 s" in str(caught.value)
    assert len(caught.value.animation) == 5


def test_a_stroke_is_measured_again_only_where_an_obstacle_bends(monkeypatch) -> None:
    measured = []

    def stroke(shape):
        measured.append(shape)
        return _stroke(shape)

    monkeypatch.setattr("vfwidget.motion.scene._stroke", stroke)
    corners = np.array([(0, 0), (200, 0), (200, 40), (0, 40)], dtype=float)

    def bar(time):
        turn = np.array([[np.cos(time), -np.sin(time)], [np.sin(time), np.cos(time)]])
        return [corners * [1, min(1.0, 2.0 - time)] @ turn]

    scene = Scene(vf.Text("recursive", "I"), bar)
    count = len(measured)
    for time in np.linspace(0.1, 1.0, 10):
        scene.at(time)
    assert len(measured) == count
    scene.at(1.5)
    assert len(measured) == count + 1
    assert scene.stroke == pytest.approx([scene.stroke[0], 20])


@pytest.mark.parametrize("vanishing", [0, 1], ids=["the first", "the last"])
@pytest.mark.parametrize("substeps", ["auto", 3])
def test_an_obstacle_is_there_until_it_vanishes(substeps, vanishing) -> None:
    plate, far = rectangle(-500, -120, 1500, -20), rectangle(8000, -9000, 8100, -20)
    end = 0.25

    def obstacles(time):
        both = [far, plate] if vanishing else [plate, far]
        return both if time < end - 1e-9 else [far]

    text = vf.Text("recursive", "I")
    fall = simulated(
        text,
        30,
        obstacles=obstacles,
        forces=(0, -6000),
        positions=True,
        restitution=0.0,
        stiffness=1e7,
        substeps=substeps,
    )
    last = round(60 * end)
    height = fall.positions[: last + 1, 0, 1]
    assert fall.penetration.max() < 0.5
    assert np.ptp(height[-8:]) < 0.1
    # From then on it falls freely.
    for frame in (last + 1, last + 5):
        way = 3000 * (fall.times[frame] - end) ** 2
        assert height[-1] - fall.positions[frame, 0, 1] == pytest.approx(way, rel=0.5, abs=1)


def test_a_structure_that_comes_back_has_the_same_outlines() -> None:
    bar, far = FLOOR, [(9000, 0), (9100, 0), (9100, 100)]
    scene = Scene(vf.Text("recursive", "I"), lambda t: [bar, far] if 1 < t < 2 else [bar])
    (first, _), (second, _), (third, _) = (scene.at(time) for time in (0.5, 1.5, 2.5))
    assert first is third
    assert first is not second


def test_a_step_that_is_shortened_before_an_obstacle_appears_starts_as_without_it() -> None:
    def bars(time):
        low = -500 + 100 * time
        bar = [(-9000, low), (9000, low), (9000, low + 90), (-9000, low + 90)]
        return [bar, [(5000, 0), (5100, 0), (5100, 100)]] if time > 0.5 else [bar]

    text = vf.Text("recursive", "I")
    body, scene = Body(text, np.ones(1), True), Scene(text, bars)
    rate = np.zeros_like(text.coordinates)
    laws = Laws(rate, rate, 0.3, 0.5, 1.0, None)
    state = State(body.start(text), np.zeros(len(body.lift)), np.zeros(1, dtype=bool))
    step = FreeStep(body, scene, laws, state, 0.2, 0.7, np.zeros((1, 2)), text.coordinates)
    np.testing.assert_array_equal(step.obstacles[:4], scene.at(0.2)[1])
    np.testing.assert_array_equal(step.obstacles[4:], scene.at(0.9)[1][4:])
    step.set_duration(0.1)
    np.testing.assert_array_equal(step.obstacles, scene.at(0.2)[1])
    np.testing.assert_array_equal(step.later, scene.at(0.3)[1])
    assert step.outlines is scene.at(0.2)[0]


@pytest.mark.parametrize(
    ("font", "string", "left", "right", "speeds", "frames"),
    [
        # From about 0.8 s on, both letters are narrower than by default.
        ("dynapuff", "om", -300, 1900, (600, -500), 60),
        ("roboto-flex", "il.", -30, 1450, (300, -300), 96),
    ],
)
def test_letters_between_walls_that_close_are_not_thrown_out(
    font, string, left, right, speeds, frames
) -> None:
    def walls(time):
        inner = left + speeds[0] * time, right + speeds[1] * time
        return [
            [(x, -400), (x + 900, -400), (x + 900, 1600), (x, 1600)]
            for x in (inner[0] - 900, inner[1])
        ]

    text = vf.Text(font, string, shared=False)
    pressed = simulated(text, frames, obstacles=walls, positions=True)
    speed = np.linalg.norm(np.diff(pressed.positions, axis=0), axis=2).max() * 60
    assert speed < 5 * max(speeds)
    assert pressed.penetration.max() < 0.5


def closing(speed):
    """Two walls that close in on letters from both sides, until they touch."""

    def walls(time):
        room = max(900.0 - speed * time, 0.0)
        return [
            rectangle(500 - room - 400, -600, 500 - room, 1500),
            rectangle(500 + room, -600, 500 + room + 400, 1500),
        ]

    return walls


def test_letters_that_walls_squeeze_out_are_named():
    text = vf.Text("recursive", "OO")
    options = {"obstacles": closing(2000), "positions": True}
    with pytest.warns(vf.MotionWarning, match=r"squeezed letter [01] \('O'\) out at .* frame"):
        thrown = simulated(text, 32, **options)
    speeds = np.linalg.norm(np.diff(thrown.positions, axis=0), axis=2).max(1) * 60
    assert speeds.max() > 10 * 2000


def test_letters_that_have_room_or_fall_fast_are_not_called_squeezed(recwarn):
    text = vf.Text("recursive", "OO")
    simulated(text, 20, obstacles=closing(700), positions=True)
    # Forces and impulses explain the speed, while an obstacle creeps.
    options = {"obstacles": closing(1), "positions": True}
    simulated(text, 10, forces=(0, -4e5), **options)
    simulated(text, 10, impulses=[(0.05, (0, 5e4))], **options)
    # A letter that an obstacle covers when it appears is moved out at once.
    bars = [rectangle(-3000, -1000, 3000, 1000), rectangle(9000, 0, 9100, 100)]
    simulated(text, 6, obstacles=lambda time: bars[1:] if time < 0.05 else bars, positions=True)
    assert not [one for one in recwarn if "squeezed" in str(one.message)]
