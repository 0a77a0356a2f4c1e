"""Reports and figures of animations say what the arrays hold."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pytest

import vfwidget as vf


@pytest.fixture(scope="module")
def fall():
    floor = [(-500, -100), (1500, -100), (1500, 0), (-500, 0)]
    text = vf.Text("recursive", "O", offsets=[(0, 100)])
    return vf.simulate(
        text,
        60,
        forces=(0, -4000),
        obstacles=[floor],
        positions=True,
        restitution=0.0,
        damping=30.0,
        progress=False,
    )


@pytest.fixture(autouse=True)
def no_figures_left():
    yield
    plt.close("all")


def test_the_report_tells_duration_motion_and_rest(fall) -> None:
    report = fall.report()
    assert report.startswith("'O' in Recursive")
    assert "61 frames, 1 s, 60 frames per second" in report
    way = np.hypot(*(fall.positions - fall.positions[0])[:, 0].T).max()
    assert f"letters move by at most {way:.4g} font units" in report
    assert "at rest from" in report


def test_the_report_of_keyframes_has_no_energy() -> None:
    thin = vf.Text("recursive", "a", axes={"wght": 300})
    report = vf.Animation.from_keyframes([(0, thin), (1, thin.at(axes={"wght": 700}))]).report()
    assert "energy" not in report
    assert "contact" not in report
    assert "wght        300 to 700" in report
    assert "at rest" not in report


def test_the_figure_draws_the_arrays(fall) -> None:
    theta, height, energy, depth = fall.plot()
    np.testing.assert_array_equal(height.lines[0].get_ydata(), fall.positions[:, 0, 1])
    np.testing.assert_allclose(energy.lines[0].get_ydata(), fall.energy - fall.energy.min())
    np.testing.assert_array_equal(depth.lines[0].get_ydata(), fall.penetration)
    assert len(theta.lines) <= len(fall.text.font.axes)


def test_a_contact_sheet_shows_frames_in_order(fall) -> None:
    sheet = vf.plot.frames(fall, 4)
    assert [panel.get_title() for panel in sheet] == ["0.00 s", "0.33 s", "0.67 s", "1.00 s"]
    # The floor and the letter; the letter is lower at the end.
    floor, first = sheet[0].patches
    assert floor.get_path().vertices[:, 1].max() == 0
    last = sheet[-1].patches[1]
    assert last.get_path().vertices[:, 1].min() < first.get_path().vertices[:, 1].min() - 80
    with pytest.raises(vf.VFWidgetError, match="count must be a whole number from 2 to 200"):
        vf.plot.frames(fall, 1)
    with pytest.raises(vf.VFWidgetError, match="received Text"):
        vf.plot.frames(fall.text)
