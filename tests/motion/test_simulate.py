"""Physics of text: falls, impacts, stacks and pushes, and input that is refused."""

from __future__ import annotations

import numpy as np
import pytest
import torch

import vfwidget as vf
from tests.motion.falls import FLOOR, G, fallen, simulated


def high(string="O", font="recursive", y=1000.0):
    return vf.Text(font, string, offsets=[(0, y)] * len(string))


@pytest.fixture(scope="module")
def bounce():
    """A letter that falls by 1,000 units, and bounces twice."""
    return fallen(high(), 70, restitution=0.7)


def heights(animation):
    """Apexes of the lowest points of the text, in font units above the floor."""
    low = np.array([f.point_set().positions(f.place)[:, 1].min() for f in animation])
    inner = (low[1:-1] >= low[:-2]) & (low[1:-1] > low[2:])
    return low[1:-1][inner]


def test_a_free_fall_is_an_exact_parabola() -> None:
    fall = simulated(high(), 10, forces=(0, -G), positions=True)
    expected = 1000 - G / 2 * fall.times**2
    np.testing.assert_allclose(fall.positions[:, 0, 1], expected, atol=1e-6)
    np.testing.assert_allclose(np.diff(fall.energy), 0, atol=1e-3)
    np.testing.assert_allclose(fall.theta - fall.theta[0], 0, atol=1e-9)


def test_a_bounce_loses_energy_and_never_enters_the_floor(bounce) -> None:
    assert bounce.penetration.max() < 0.5
    # Per frame, relative to m g h.
    assert np.diff(bounce.energy).max() <= 1e-4 * G * 1000
    (first, *_) = heights(bounce)
    assert 0.4 * 1000 < first < 0.52 * 1000


def test_the_penetration_is_the_depth_that_overlaps_finds(bounce) -> None:
    for i in range(30, 40, 3):
        found = vf.overlaps(bounce[i], [FLOOR])
        depth = max((overlap.depth for overlap in found), default=0.0)
        assert depth <= max(0.05, 1.1 * bounce.penetration[i])


def test_an_impact_squashes_a_letter_and_the_letter_recovers(bounce) -> None:
    moved = abs(bounce.theta - bounce.theta[0]).max((1, 2))
    assert moved.max() > 0.02
    lower, upper = bounce.text.font.bounds
    assert (bounce.theta >= lower).all()
    assert (bounce.theta <= upper).all()


def test_the_same_input_gives_the_same_animation(bounce) -> None:
    again = fallen(high(), 70, restitution=0.7)
    np.testing.assert_array_equal(again.theta, bounce.theta)
    np.testing.assert_array_equal(again.offsets, bounce.offsets)


@pytest.mark.slow
@pytest.mark.parametrize("font", ["recursive", "roboto-flex"])
def test_apexes_do_not_depend_on_the_substeps(font) -> None:
    few, many = (
        heights(fallen(high(font=font), 80, restitution=0.7, substeps=substeps))
        for substeps in (1, 8)
    )
    np.testing.assert_allclose(few[:2], many[:2], rtol=0.05)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("font", "string", "substeps"),
    [("recursive", "O", 2), ("roboto-flex", "H", "auto"), ("dynapuff", "o", "auto")],
)
def test_with_restitution_1_a_letter_bounces_as_high_for_ten_seconds(
    font, string, substeps
) -> None:
    text = high(string, font, y=800)
    bounces = fallen(text, 600, restitution=1.0, substeps=substeps)
    start = text.point_set().positions(text.place)[:, 1].min()
    apexes = heights(bounces)
    # A bounce takes about 1.03 s.
    assert len(apexes) >= 9
    np.testing.assert_allclose(apexes, start, rtol=0.05)
    # Per frame, and in all.
    assert np.diff(bounces.energy).max() <= 1e-4 * G * 800
    assert bounces.energy.max() <= bounces.energy[0] + 1e-4 * G * 800
    assert bounces.penetration.max() < 0.5


def test_without_restitution_a_letter_stays_on_the_floor() -> None:
    fall = fallen(high(y=200), 40, restitution=0.0)
    low = fall[-1].point_set().positions(fall[-1].place)[:, 1].min()
    assert abs(low) < 0.5
    assert np.diff(fall.energy).max() <= 1e-4 * G * 200


def test_springs_swing_with_the_given_frequency_and_come_to_rest() -> None:
    text = vf.Text("afacad-flux", "n", axes={"wght": 500})
    rest = text.at(axes={"wght": 560})
    swing = simulated(text, 90, rest=rest, stiffness=100.0, damping=2.0, substeps=8)
    place = swing.theta[:, 0, 1] - rest.theta[0, 1].item()
    turns = np.flatnonzero(np.diff(np.sign(place)))
    # Half a swing of angular frequency 10.
    assert swing.times[turns[1]] - swing.times[turns[0]] == pytest.approx(np.pi / 10, rel=0.15)
    assert abs(place[-1]) < 0.3 * abs(place[0])


def test_friction_stops_a_sliding_letter() -> None:
    def way(friction):
        slide = fallen(vf.Text("recursive", "H"), 20, impulses=[(0, (1000, 0))], friction=friction)
        return slide.positions[-1, 0, 0]

    assert way(0.0) == pytest.approx(1000 * 20 / 60, rel=0.01)
    # μ g slows it down by 3,000 units/s²: it stops after a third of a second.
    assert way(0.5) == pytest.approx(1000**2 / (2 * 0.5 * G), rel=0.1)


@pytest.mark.parametrize("thickness", [1, 2.5])
def test_a_thin_floor_is_not_passed(thickness: float) -> None:
    floor = [(-500, -300 - thickness), (1500, -300 - thickness), (1500, -300), (-500, -300)]
    fall = simulated(
        vf.Text("dynapuff", "H"), 30, forces=(0, -9000), obstacles=[floor], positions=True
    )
    assert fall.penetration.max() < 0.5
    assert min(float(c[..., 1].min()) for c in fall[-1].segments()) > -301


@pytest.mark.parametrize("speed", [3300, 10_000, 200_000])
@pytest.mark.parametrize(("string", "across"), [("H", 0.0), ("oN", 0.3)])
def test_a_floor_of_one_unit_stops_letters_of_any_speed(string, across, speed) -> None:
    floor = [(-1e5, -301), (1e5, -301), (1e5, -300), (-1e5, -300)]
    text = vf.Text("dynapuff", string, shared=False)
    fall = simulated(
        text,
        8,
        obstacles=[floor],
        positions=True,
        impulses=[(0, (across * speed, -speed))],
        restitution=0.5,
    )
    assert fall.penetration.max() < 0.5
    assert min(float(c[..., 1].min()) for frame in fall for c in frame.segments()) > -301
    # The letter has come back by half of the way that it would have gone on.
    time = fall.times[-1] - 300 / speed
    assert fall.positions[-1, 0, 1] == pytest.approx(-300 + 0.5 * speed * time, rel=0.2, abs=200)


def test_obstacles_appear_and_vanish() -> None:
    ledge = [(-500, 300), (1500, 300), (1500, 400), (-500, 400)]
    text = high("O", y=500)

    def height(obstacles):
        fall = fallen(text, 40, obstacles=obstacles, restitution=0.0)
        assert fall.penetration.max() < 0.5
        return fall.positions[-1, 0, 1]

    # The letter reaches the ledge after 0.16 s, and leaves it after half a second.
    assert height(lambda t: [FLOOR, ledge] if t < 0.5 else [FLOOR]) < 380
    assert height(lambda t: [FLOOR] if t < 0.1 else [FLOOR, ledge]) > 400


def test_an_obstacle_that_letters_could_pass_unseen_is_refused() -> None:
    floor = [(0, -1), (900, -1), (900, -0.5), (0, -0.5)]
    with pytest.raises(vf.MotionError, match=r"obstacles\[1\] is 0\.5 font units thick"):
        simulated(vf.Text("dynapuff", "H"), 2, obstacles=[FLOOR, floor])


def test_axes_alone_make_room_for_an_obstacle() -> None:
    text = vf.Text("roboto-flex", "I", axes={"wght": 900})
    right = text.point_set().positions(text.place)[:, 0].max()

    def wall(time):
        x = right - 400 * time
        return [[(x, -50), (right + 500, -50), (right + 500, 1500), (x, 1500)]]

    pushed = simulated(text, 12, obstacles=wall, restitution=0.0)
    assert pushed.penetration.max() < 0.5
    assert (pushed.positions[-1] == pushed.positions[0]).all()
    assert abs(pushed.theta[-1] - pushed.theta[0]).max() > 0.01


@pytest.mark.slow
def test_a_stack_comes_to_rest() -> None:
    text = vf.Text("recursive", "HEO", shared=False)
    places = [(-g.x + 40 * (-1) ** i, 30 + 760 * i) for i, g in enumerate(text.layout)]
    stack = fallen(text.at(offsets=places), 130, forces=(0, -4000))
    assert stack.penetration.max() < 0.5
    assert np.diff(stack.energy).max() <= 1e-4 * 4000 * 1000
    points = np.array([f.point_set().positions(f.place) for f in stack[-5:]])
    assert abs(np.diff(points, axis=0)).max() < 0.01
    # It is still a stack.
    assert (np.diff(stack.positions[-1, :, 1]) > 500).all()


@pytest.mark.slow
@pytest.mark.parametrize("speed", [3000, 30_000])
def test_a_fast_bar_pushes_letters_and_passes_through_none(speed) -> None:
    text = vf.Text("recursive", "in", shared=False)

    def bar(time):
        x = min(speed * time, 1200.0)
        return [[(x - 260, 100), (x - 140, 100), (x - 140, 400), (x - 260, 400)]]

    pushed = simulated(text, 30, obstacles=bar, positions=True)
    assert pushed.penetration.max() < 0.5
    points = np.array([f.point_set().positions(f.place) for f in pushed])
    # The bar ends at x = 1,060, and every letter is to the right of it.
    assert points[-1, :, 0].min() > 1059


@pytest.mark.slow
# Round letters begin below the floor, and are lifted first.
@pytest.mark.filterwarnings("ignore:At the start:vfwidget.errors.MotionWarning")
@pytest.mark.parametrize(
    ("string", "weight", "speed", "restitution", "low"),
    # The corner of "i" reaches into "n"; the tip of "E" lies between the curves of "O".
    [("in", 500, 1500, 0.3, 60), ("HEO", 607, 1472, 0.3, 150), ("ab", 553, 2185, 0.0, 200)],
)
def test_letters_that_are_pushed_into_each_other_are_never_blocked(
    string, weight, speed, restitution, low
) -> None:
    def bar(time):
        x = -200 + min(speed * time, 700)
        corners = [(x - 100, low), (x, low), (x, low + 360), (x - 100, low + 360)]
        return [corners, FLOOR]

    word = vf.Text("recursive", string, axes={"wght": weight}, shared=False)
    pushed = fallen(word, 26, forces=(0, -4000), obstacles=bar, restitution=restitution)
    assert pushed.penetration.max() < 0.1
    first, last = pushed.positions[[0, -1], :, 0]
    assert (last > first).all()


def test_letters_that_overlap_at_the_start_are_moved_apart_first() -> None:
    bar = [(-100, -100), (900, -100), (900, 20), (-100, 20)]
    text = vf.Text("recursive", "o")
    with pytest.warns(vf.MotionWarning, match="overlapped itself or an obstacle"):
        moved = simulated(text, 2, obstacles=[bar], positions=True)
    assert moved.penetration.max() < 0.5
    covering = [(-5000, -5000), (5000, -5000), (5000, 5000), (-5000, 5000)]
    with pytest.raises(vf.MotionError, match="positions=True"):
        simulated(text, 2, obstacles=[covering])


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("positions", [False, True])
@pytest.mark.parametrize("given", ["forces", "impulses"])
def test_forces_that_overflow_are_told_without_a_warning(given: str, positions: bool) -> None:
    value = (1e300, 0.0) if given == "forces" else [(0.0, (1e300, 0.0))]
    text = vf.Text("recursive", "hk", shared=False)
    with pytest.raises(vf.MotionError, match="is larger than any number"):
        vf.simulate(text, 3, 1 / 30, mass=1e20, positions=positions, **{given: value})


def test_an_exploding_force_keeps_the_frames_so_far() -> None:
    with pytest.raises(vf.MotionError, match="motion exploded") as caught:
        simulated(high(), 40, forces=lambda t: (0, 10.0 ** (100 * t)), positions=True)
    assert 2 < len(caught.value.animation) < 40


def test_letters_that_cannot_get_out_of_the_way_are_said_so() -> None:
    def bar(time):
        x = 4000 * time - 300
        return [[(x - 100, 100), (x, 100), (x, 400), (x - 100, 400)]]

    with pytest.raises(vf.MotionError, match="positions=True") as caught:
        simulated(vf.Text("recursive", "N"), 30, obstacles=bar)
    assert 2 < len(caught.value.animation) < 30


@pytest.mark.slow
@pytest.mark.parametrize(("end", "said"), [(92, "In .* frames, shapes enter"), (120, "cannot get")])
def test_a_letter_that_makes_too_little_room_is_said_to_be_entered(end, said) -> None:
    def bar(time):
        x = min(1500 * time - 60, end)
        return [[(x - 100, 100), (x, 100), (x, 400), (x - 100, 400)]]

    text = vf.Text("recursive", "N")
    if end > 100:
        # Without this error the bar went through the stem.
        with pytest.raises(vf.MotionError, match=said):
            simulated(text, 9, obstacles=bar)
        return
    with pytest.warns(vf.MotionWarning, match=said):
        pressed = simulated(text, 9, obstacles=bar)
    (overlap,) = vf.overlaps(pressed[-1], bar(pressed.times[-1]))
    assert overlap.depth == pytest.approx(pressed.penetration[-1], abs=0.05)


def test_letters_that_lie_on_each_other_are_moved_apart() -> None:
    text = vf.Text("recursive", "HH", shared=False)
    way = text.layout[1].x - text.layout[0].x
    stacked = text.at(offsets=[(0, 5), (-way, 5)])
    with pytest.warns(vf.MotionWarning, match="overlapped itself"):
        moved = simulated(stacked, 2, obstacles=[FLOOR], positions=True)
    assert vf.overlaps(moved[0], [FLOOR]) == []
    with pytest.raises(vf.MotionError, match=r"overlaps itself.*positions=True"):
        simulated(stacked, 2, obstacles=[FLOOR])


def test_an_interrupted_simulation_keeps_the_frames_so_far() -> None:
    def forces(time):
        if time > 0.1:
            raise KeyboardInterrupt
        return 0, -G

    with pytest.warns(vf.MotionWarning, match="interrupted"):
        short = simulated(high(), 40, forces=forces, positions=True)
    assert 4 < len(short) < 10


def test_a_named_instance_can_be_the_rest_state() -> None:
    font = vf.load_font("recursive")
    bold = next(one for one in font.instances if one.axes["wght"] == 800)
    text = vf.Text(font, "no")
    apart = text.at(shared=False)
    frames = [simulated(text, 3, rest=rest) for rest in (bold.axes, bold, bold.name)]
    assert (frames[0].theta[-1] != frames[0].theta[0]).any()
    for each in frames[1:]:
        np.testing.assert_array_equal(each.theta, frames[0].theta)
    lists = [simulated(apart, 3, rest=[rest, rest]) for rest in (bold.axes, bold, bold.name)]
    for each in lists[1:]:
        np.testing.assert_array_equal(each.theta, lists[0].theta)


def test_an_animation_can_be_the_rest_state_and_an_obstacle() -> None:
    text = vf.Text("afacad-flux", "n", axes={"wght": 500})
    theta = np.stack([text.theta.numpy(), text.at(axes={"wght": 700}).theta.numpy()])
    bolder = vf.Animation(text, [0.0, 0.2], theta)
    assert bolder.at(0.1).theta[0, 1] == pytest.approx(theta[:, 0, 1].mean())
    other = vf.Text("afacad-flux", "o", offsets=[(0, -2000)])
    follows = simulated(text, 20, rest=bolder, obstacles=vf.Animation(other, [0.0], [other.theta]))
    assert follows.theta[-1, 0, 1] > theta[:, 0, 1].mean()
    assert len(follows.scenery[0]) == 2


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"dt": 0}, "dt must be a finite number > 0"),
        ({"dt": -1}, "dt must be"),
        ({"steps": 0}, "steps must be a whole number from 1"),
        ({"steps": 10**9}, "from 1 to 100,000"),
        ({"dt": 10**400}, "dt must be a finite number"),
        ({"positions": "yes"}, "positions must be True or False"),
        ({"rest": 10**400}, "rest is no state"),
        ({"rest": torch.zeros(1, 2, device="meta")}, "rest is no state"),
        ({"forces": 10**400}, "forces must be"),
        ({"substeps": 10**400}, 'substeps, unless "auto", must be a whole'),
        ({"obstacles": 10**400}, "obstacles cannot be read"),
        ({"mass": -1}, "mass must be at least 1e-12"),
        ({"mass": 5e-324}, "mass must be at least 1e-12"),
        ({"mass": [1, 2, 3]}, "mass must be a number"),
        ({"forces": (0, np.nan)}, "forces must be finite"),
        ({"forces": lambda t: (0, 0, 0)}, "forces must be"),
        ({"stiffness": {"wgth": 2}}, "no axis 'wgth'"),
        ({"stiffness": -1}, "stiffness must be at least 0"),
        ({"damping": np.inf}, "damping must be finite"),
        ({"restitution": 1.5}, "restitution must be"),
        ({"friction": -0.1}, "friction must be"),
        ({"substeps": "many"}, 'substeps, unless "auto", must be a whole'),
        ({"substeps": 0}, 'substeps, unless "auto", must be a whole'),
        ({"rest": "Bould"}, "rest is no state"),
        ({"rest": vf.Text("afacad-flux", "ab", shared=False)}, "rest must be a text"),
        ({"impulses": [(0, "up")]}, "impulse must be"),
        ({"obstacles": [[(0, 0), (1, 0)]]}, "obstacles cannot be read"),
        ({"obstacles": lambda t: [[(0, np.nan), (1, 0), (1, 1)]]}, "At 0 s"),
    ],
)
def test_bad_input_is_refused(options, message) -> None:
    text = vf.Text("recursive", "ab")
    with pytest.raises(vf.MotionError, match=message):
        simulated(text, **{"steps": 3, **options})


@pytest.mark.parametrize("string", ["a b", "a "])
def test_a_space_has_no_mass_and_stays_where_it_is(string) -> None:
    text = high(string, y=300)
    fall = fallen(text, 4)
    dropped = fall.positions[-1] - fall.positions[0]
    np.testing.assert_allclose(dropped[0], (0, -G / 2 * fall.times[-1] ** 2), atol=1e-6)
    np.testing.assert_array_equal(dropped[1], 0)
    np.testing.assert_array_equal(text.place["offsets"], high(string, y=300).place["offsets"])
    assert not simulated(vf.Text("recursive", string), 2).penetration.any()


def test_a_text_without_outlines_cannot_move() -> None:
    with pytest.raises(vf.MotionError, match="has no outlines"):
        simulated(vf.Text("recursive", "  "), 2, positions=True)


def test_simulate_needs_a_text() -> None:
    with pytest.raises(vf.MotionError, match="needs a Text"):
        vf.simulate("word")
