"""Letters that rotate: exact rigid bodies, toppling, rolling, and every export of their angles."""

from __future__ import annotations

import json

import numpy as np
import pytest

import vfwidget as vf
from tests.motion.falls import FLOOR, G, fallen, simulated
from vfwidget.arrays import to_array
from vfwidget.energy.energy import Energy
from vfwidget.motion.body import Body
from vfwidget.motion.scene import Scene
from vfwidget.motion.terms import Contact, Inertia, Rolling, Sliding, Touches
from vfwidget.motion.warm import least
from vfwidget.outline.cubics import bernstein
from vfwidget.text.place import ROTATIONS, Place

STIFF = 1e9


def masses(text):
    """The mass of every control point: each segment shares its length among its four points."""
    points, index = to_array(text.points()), text.word.contours.segments
    length = np.linalg.norm(np.diff(points[index], axis=1), axis=2).sum(1)
    shares = np.bincount(index.ravel(), np.repeat(length, 4), len(points))
    return shares / shares.sum()


def centre(text, mass):
    return mass @ to_array(text.points())


def outline(text):
    """Points of the outline, densely sampled."""
    segments = to_array(text.points())[text.word.contours.segments]
    blend = np.array([bernstein(t) for t in np.linspace(0, 1, 60)])
    return (blend @ segments).reshape(-1, 2)


def test_letters_that_start_rotated_are_computed_anew_for_other_angles() -> None:
    text = vf.Text("recursive", "I", rotations=[0.3])
    body = Body(text, np.ones(1), positions=True)
    for angle in (0.3, 1.3):
        place = Place({**text.place, ROTATIONS: np.array([angle])})
        other = text.at(rotations=[angle])
        np.testing.assert_allclose(body.positions(place), to_array(other.points()), atol=1e-9)


def motion_at_the_end(animation):
    points = np.array([to_array(frame.points()) for frame in animation[-5:]])
    return abs(np.diff(points, axis=0)).max()


def test_a_rotated_text_is_rotated_about_the_origins_of_its_letters() -> None:
    axes = {"wght": 500, "CASL": 0.3, "slnt": -5}
    text = vf.Text(
        "recursive", "Av", [axes] * 2, offsets=[(0, 40), (9, 0)], tracking=12, shared=False
    )
    angles = np.array([0.4, -1.3])
    rotated = text.at(rotations=angles)
    letter = text.point_set().letter
    origins = np.array([(g.x, g.y) for g in text.layout])[letter]
    own = to_array(text.points()) - origins
    cos, sin = np.cos(angles)[letter], np.sin(angles)[letter]
    expected = np.stack([cos * own[:, 0] - sin * own[:, 1], sin * own[:, 0] + cos * own[:, 1]], 1)
    np.testing.assert_allclose(to_array(rotated.points()), expected + origins, atol=1e-9)
    # The picture, the handles and the derivative show it as well.
    assert rotated.to_svg() != text.to_svg()
    handle = rotated.nearest(300, 300)
    goal = rotated.at(axes=[{**axes, "wght": 700}] * 2).position(handle)
    solved = vf.solve(rotated, vf.Target(handle, goal))
    np.testing.assert_array_equal(solved.text.rotations, angles)
    assert solved.terms[0].met
    step = 1e-6
    theta = rotated.theta + 0.2
    bolder = theta.clone()
    bolder[0, 2] += step
    slope = (rotated.points(bolder) - rotated.points(theta)) / step
    np.testing.assert_allclose(slope, rotated.jacobian(theta)[:, :, 0, 2], atol=1e-3)
    with pytest.raises(vf.TextError, match=r"rotations must be finite numbers of shape \(2,\)"):
        text.at(rotations=[0, np.nan])


@pytest.mark.parametrize("shared", [True, False])
def test_the_derivatives_of_all_terms_are_exact(shared) -> None:
    text = vf.Text(
        "recursive", "HO", shared=shared, rotations=[0.4, -0.7], axes={"wght": 500, "slnt": -4}
    )
    low = to_array(text.points())[:, 1].min()
    floor = [(-3000, -900), (4000, -900), (4000, low + 30), (-3000, low + 30)]
    body, scene = Body(text, np.ones(2), positions=True, rotations=True), Scene(text, [floor])
    place, (outlines, obstacles) = body.start(text), scene.at(0.0)
    np.testing.assert_allclose(
        body.reduced(body.positions(place)), body.reduced_at(place), atol=1e-9
    )
    segments = np.concatenate([body.positions(place)[body.controls], obstacles])
    touches = Touches(body, outlines.gaps(segments, 60), obstacles)
    # Points and gaps are linear in the reduced coordinates.
    np.testing.assert_allclose(body.positions(place), to_array(text.points()), atol=1e-9)
    np.testing.assert_allclose(touches.apart.at(place), touches.gaps.gap, atol=1e-9)
    apart = touches.gaps.ends(segments)
    moved = apart[0] - apart[1] + 0.3
    terms = [
        Inertia(body, body.reduced_at(place) + 1),
        Contact(touches),
        Sliding(np.ones(len(moved)), touches, moved),
        Rolling(np.ones(2), 500.0, text.rotations + np.array([0.3, -1e-5])),
    ]
    energy = Energy(text, terms, free=body.free)
    x, jacobian = energy.unknowns.start, energy.jacobian(energy.unknowns.start)
    for i in np.flatnonzero(jacobian.any(0)):
        step = 1e-6 * np.eye(len(x))[i]
        sides = [
            (energy.residual(x + end) - energy.residual(x)) / end[i] for end in (step, step / 2)
        ]
        # From the right, because some axes are at their default, where they have a kink.
        slope = 2 * sides[1] - sides[0]
        np.testing.assert_allclose(slope, jacobian[:, i], atol=1e-2, rtol=1e-4)


def test_a_free_letter_keeps_its_angular_momentum_and_its_energy() -> None:
    text = vf.Text("recursive", "I", offsets=[(0, 500)])
    spin = simulated(
        text, 30, stiffness=STIFF, impulses=[(0, (100, 50, 6))], positions=True, rotations=True
    )
    np.testing.assert_allclose(spin.rotations[:, 0], 6 * spin.times, atol=2e-3)
    assert np.ptp(spin.energy) < 1e-3 * spin.energy[0]
    mass = masses(text)
    centres = np.array([centre(frame, mass) for frame in spin])
    np.testing.assert_allclose(centres - centres[0], spin.times[:, None] * (100, 50), atol=1e-3)


def test_a_spinning_letter_is_stretched_and_keeps_its_angular_momentum() -> None:
    text = vf.Text("recursive", "I")
    spin = simulated(
        text, 40, stiffness=400, impulses=[(0, (0, 0, 8))], positions=True, rotations=True
    )
    assert abs(spin.theta - spin.theta[0]).max() > 1e-3
    assert np.diff(spin.energy).max() <= 1e-4 * spin.energy[0]
    mass, points = masses(text), np.array([to_array(frame.points()) for frame in spin])
    own = points - (mass[:, None] * points).sum(1, keepdims=True)
    middle, change = (own[1:] + own[:-1]) / 2, np.diff(own, axis=0) * 60
    cross = middle[..., 0] * change[..., 1] - middle[..., 1] * change[..., 0]
    momentum = (mass * cross).sum(1)
    np.testing.assert_allclose(momentum, momentum[0], rtol=5e-3)


@pytest.mark.parametrize("angle", [1.1, -0.3])
def test_an_impact_off_the_centre_is_that_of_a_rigid_body(angle) -> None:
    e, text = 0.7, vf.Text("recursive", "L", offsets=[(0, 500)], rotations=[angle])
    mass, start = masses(text), centre(text, masses(text))
    inertia = mass @ ((to_array(text.points()) - start) ** 2).sum(1)
    points = outline(text)
    x, y = points[points[:, 1].argmin()]
    moment = np.sqrt(2 * y / G)
    # The impulse of a frictionless impact at a lever arm of x, for a mass of 1.
    lever = x - start[0]
    impulse = (1 + e) * G * moment / (1 + lever**2 / inertia)
    frame = int(moment * 60) + 2
    fall = fallen(text, frame + 3, stiffness=STIFF, restitution=e, friction=0.0, rotations=True)
    spin = np.diff(fall.rotations[frame:, 0]).mean() * 60
    assert spin == pytest.approx(lever * impulse / inertia, rel=0.02)
    below, above = (centre(fall[i], mass)[1] for i in (frame, frame + 1))
    middle = fall.times[frame : frame + 2].mean()
    speed = (above - below) * 60 + G * (middle - moment)
    assert speed == pytest.approx(impulse - G * moment, abs=10)


def test_the_model_of_contacts_has_the_least_value_that_scipy_finds() -> None:
    from scipy.optimize import lsq_linear

    rng = np.random.default_rng(3)
    for _ in range(20):
        root, normals = rng.normal(size=(6, 4)), rng.normal(size=(40, 4))
        gaps, slope = rng.normal(size=40), rng.normal(size=4)
        found, _ = least(root.T @ root, slope, normals, gaps)
        # One-sided springs are springs with a slack s ≥ 0: min over d, s of |g + N d − s|².
        shift = np.linalg.lstsq(root.T, slope, rcond=None)[0]
        system = np.block([[root, np.zeros((6, 40))], [normals, -np.eye(40)]])
        low = np.r_[np.full(4, -np.inf), np.zeros(40)]
        referee = lsq_linear(system, -np.r_[shift, gaps], (low, np.inf), tol=1e-13)
        np.testing.assert_allclose(found, referee.x[:4], atol=1e-5)


@pytest.mark.slow
def test_an_i_that_bounces_on_its_edge_never_gains_energy_and_comes_to_rest() -> None:
    text = vf.Text("recursive", "I", offsets=[(0, 800)], rotations=[0.5])
    fall = fallen(text, 230, restitution=0.7, rotations=True)
    assert fall.penetration.max() < 0.5
    assert np.diff(fall.energy).max() <= 1e-4 * G * 800
    # It has tipped over onto its side.
    assert fall.rotations[-1, 0] == pytest.approx(np.pi / 2, abs=0.2)
    assert motion_at_the_end(fall) < 0.01


@pytest.mark.slow
def test_a_letter_on_its_corner_tips_over_and_comes_to_rest() -> None:
    text = vf.Text("recursive", "H", offsets=[(0, 700)], rotations=[0.4])
    fall = fallen(text, 140, rotations=True)
    assert fall.penetration.max() < 0.5
    assert np.diff(fall.energy).max() <= 1e-4 * G * 700
    assert fall.rotations[-1, 0] == pytest.approx(-np.pi / 2, abs=1e-3)
    assert motion_at_the_end(fall) < 0.01


@pytest.mark.slow
# Of all bundled fonts, these letters were the last to come to rest, or entered the floor.
@pytest.mark.parametrize(
    ("font", "string", "frames"),
    [("roboto-flex", "N", 300), ("dynapuff", "o", 120), ("dynapuff", "T", 330)],
)
def test_letters_of_all_shapes_come_to_rest(font, string, frames) -> None:
    text = vf.Text(font, string, rotations=[0.4])
    em = text.font.units_per_em
    gravity, height = 6 * em, 0.7 * em
    fall = fallen(
        text.at(offsets=[(0, height)]),
        frames,
        forces=(0, -gravity),
        obstacles=[np.array(FLOOR) * em / 1000],
        damping=12.0,
        rotations=True,
    )
    assert fall.penetration.max() < 0.5
    assert np.diff(fall.energy).max() <= 1e-4 * gravity * height
    assert motion_at_the_end(fall) < 0.01


@pytest.mark.slow
def test_letters_that_rock_for_ten_seconds_lose_energy_and_come_to_rest() -> None:
    # The round foot of V rocks on the floor, and only friction against rolling slows it down.
    text = vf.Text("dynapuff", "Vf", shared=False, rotations=[0.7, -0.23])
    em = text.font.units_per_em
    rocking = fallen(
        text.at(offsets=[(0, 1.1 * em), (0.3 * em, 1.1 * em)]),
        800,
        forces=(0, -6 * em),
        obstacles=[np.array(FLOOR) * em / 500],
        impulses=[(0, (210, 950, 7.6))],
        restitution=0.7,
        friction=0.3,
        damping=12.0,
        rotations=True,
    )
    assert rocking.penetration.max() < 0.5
    assert np.diff(rocking.energy).max() <= 1e-4 * 6 * em * 1.1 * em
    assert motion_at_the_end(rocking) < 0.01


def test_friction_makes_a_round_letter_roll() -> None:
    text = vf.Text("recursive", "o")
    low = to_array(text.points())[:, 1].min()
    text = text.at(offsets=[(0, -low)])

    def turn(friction):
        roll = fallen(
            text,
            16,
            stiffness=STIFF,
            friction=friction,
            impulses=[(0, (700, 0))],
            restitution=0.0,
            rotations=True,
        )
        assert roll.penetration.max() < 0.5
        return roll.rotations[-1, 0]

    assert turn(1.0) < -0.25 < turn(0.0) + 0.2


def test_rotations_survive_keyframes_and_are_exported() -> None:
    text = vf.Text("recursive", "ab", shared=False)
    turned = text.at(rotations=[0.0, np.pi / 2])
    film = vf.Animation.from_keyframes([(0, text), (1, turned)], easing="linear", fps=10)
    np.testing.assert_allclose(film.rotations[:, 1], np.pi / 2 * film.times, atol=1e-12)
    np.testing.assert_allclose(to_array(film[-1].points()), to_array(turned.points()), atol=1e-9)
    letters = json.loads(film.to_json())["letters"]
    assert letters[1]["rotation"][-1] == pytest.approx(np.pi / 2, abs=1e-4)
    assert "rotate" in film.to_css()
    assert film.loop(2).rotations.max() == pytest.approx(np.pi / 2)


def test_rotations_need_positions_and_an_editor_needs_upright_letters() -> None:
    text = vf.Text("recursive", "ab")
    with pytest.raises(vf.MotionError, match="needs positions=True"):
        vf.simulate(text, 2, rotations=True, progress=False)
    with pytest.raises(vf.MotionError, match="rotations must be True or False"):
        vf.simulate(text, 2, positions=True, rotations=0.3, progress=False)
    with pytest.raises(vf.MotionError, match="impulse must be"):
        vf.simulate(text, 2, positions=True, impulses=[(0, (0, 0, 3))], progress=False)
    with pytest.raises(vf.TextError, match="rotations"):
        vf.Editor(text.at(rotations=[1, 0]))


@pytest.mark.parametrize("string", ["a b", " i", "a  "])
@pytest.mark.parametrize("rotations", [False, True])
def test_a_space_among_rotated_letters_stays_where_it_is(string, rotations) -> None:
    angles = [0.3] * len(string)
    text = vf.Text("recursive", string, offsets=[(0, 300)] * len(string), rotations=angles)
    fall = fallen(text, 30, rotations=rotations, impulses=[(0, (0, 10))])
    for space in np.flatnonzero([c == " " for c in string]):
        np.testing.assert_array_equal(fall.rotations[:, space], 0.3)
        np.testing.assert_array_equal(np.ptp(fall.offsets[:, space], axis=0), 0)
    assert fall.penetration.max() < 0.5
    assert np.diff(fall.energy).max() <= 1e-4 * G * 300
