"""Letters that touch nothing: slow motion goes on, and impulses act at their time."""

from __future__ import annotations

import numpy as np
import pytest

import vfwidget as vf
from tests.motion.falls import fallen, simulated


def test_a_letter_that_drifts_slowly_is_not_stopped() -> None:
    drift = simulated(vf.Text("recursive", "o"), 120, impulses=[(0, (3, 0))], positions=True)
    np.testing.assert_allclose(drift.positions[:, 0, 0], 3 * drift.times, atol=1e-6)


@pytest.mark.parametrize("g", [0.01, 4.0])
def test_weak_gravity_makes_a_letter_fall(g: float) -> None:
    fall = simulated(vf.Text("recursive", "o"), 120, forces=(0, -g), positions=True)
    np.testing.assert_allclose(fall.positions[:, 0, 1], -g / 2 * fall.times**2, atol=1e-6)


@pytest.mark.parametrize("options", [{"stiffness": 0.02, "damping": 0.0}, {"damping": 1e4}])
def test_springs_that_pull_slowly_are_followed(options) -> None:
    text = vf.Text("recursive", "o")
    rest = text.at(axes={"wght": 600})
    pulled = simulated(text, 240, rest=rest, **options)
    weight = [frame.axes["wght"] for frame in pulled]
    assert (np.diff(weight) > 0).all()


def test_a_letter_that_still_drifts_does_not_stop_with_those_that_lie() -> None:
    text = vf.Text("recursive", "HH", shared=False, offsets=[(0, 0), (0, 900)])
    both = fallen(text, 120, forces=[(0, -6000), (0, -1)])
    fallen_by = both.positions[0, 1, 1] - both.positions[:, 1, 1]
    np.testing.assert_allclose(fallen_by, both.times**2 / 2, atol=1e-6)


@pytest.mark.parametrize("substeps", ["auto", 3])
def test_an_impulse_acts_at_its_time_also_between_frames(substeps) -> None:
    text = vf.Text("recursive", "o")
    impulses = [(0.45, (1000, 0)), (0.02, (0, 300)), (0.03, (0, -300)), (9.0, (5, 5))]
    kicked = simulated(text, 12, dt=1 / 24, impulses=impulses, positions=True, substeps=substeps)
    x, y = kicked.positions[:, 0].T
    np.testing.assert_allclose(x, 1000 * np.maximum(kicked.times - 0.45, 0), atol=1e-6)
    np.testing.assert_allclose(y[1:], 3.0, atol=1e-6)


def test_an_impulse_between_frames_wakes_letters_that_lie() -> None:
    text = vf.Text("recursive", "o")
    kicked = simulated(text, 60, impulses=[(0.805, (0, 600))], positions=True)
    np.testing.assert_allclose(
        kicked.positions[:, 0, 1], 600 * np.maximum(kicked.times - 0.805, 0), atol=1e-6
    )


@pytest.mark.parametrize("substeps", [1, 4])
def test_the_steps_damp_swings_by_as_much_as_is_said(substeps: int) -> None:
    # No axis of this text reaches an end of its range, where it would lose energy.
    text = vf.Text("afacad-flux", "n", axes={"wght": 600})
    swing = simulated(text, 60, rest={"wght": 620}, stiffness=400, damping=0, substeps=substeps)
    energy = swing.energy
    assert energy is not None
    assert np.log(energy[0] / energy[60]) == pytest.approx(400 / 60 / substeps, rel=0.1)
