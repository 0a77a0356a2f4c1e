"""A picture as one term among others."""

from __future__ import annotations

import numpy as np
import pytest

import vfwidget as vf
from vfwidget.energy.energy import Energy


def picture(text: vf.Text, size: tuple[int, int] = (48, 64)) -> np.ndarray:
    return 1 - vf.rasterize(text, size).numpy()


def test_a_picture_and_a_pin_are_met_together() -> None:
    text = vf.Text("recursive", "no", axes={"wght": 500})
    bold = text.at(axes={"wght": 760, "CASL": 0.6})
    handle = text.nearest(400, 500)
    found = vf.solve(text, [vf.Looks(picture(bold)), vf.Pin(handle, bold.position(handle))])
    assert found.status == "converged"
    assert found.axes["wght"] == pytest.approx(760, abs=3)
    assert found.misses[1] < 0.5
    assert {"picture.x", "picture.size", "picture.blur"} <= set(found.place)


def test_a_pin_can_contradict_a_picture_and_both_are_told() -> None:
    bold = vf.Text("dynapuff", "S", axes={"wght": 650, "wdth": 80})
    text = vf.Text("dynapuff", "S")
    handle = text.nearest(300, 700)
    found = vf.solve(text, [vf.Looks(picture(bold), fit=["blur"]), vf.Pin(handle)])
    assert found.status == "unreachable"
    assert found.misses[1] < 0.5
    missed = f"by {100 * found.misses[0]:.1f} % of the ink"
    assert missed in found.message
    # The share is no number of font units, as those of the other terms are.
    row = next(line for line in found.report().splitlines() if line.startswith("Looks"))
    assert row.split()[1] == "missed" and row.endswith(missed)


def test_a_picture_of_something_else_is_not_met() -> None:
    stripes = np.tile(np.repeat([0.0, 1.0], 4), (48, 6))
    found = vf.solve(vf.Text("dynapuff", "S"), vf.Looks(stripes), restarts=0)
    assert found.status != "converged"
    assert found.misses[0] > 0.3


@pytest.mark.parametrize("loss", ["linear", "soft_l1", "huber", "cauchy", "arctan"])
def test_its_jacobian_against_differences(loss: str) -> None:
    # Away from kinks, and free in everything.
    text = vf.Text("recursive", "an", shared=False)
    theta = [[0.31, 0.43, 0.37, -0.29, 0.2], [0.62, 0.23, 0.77, -0.71, 0.1]]
    shown = picture(text.at(theta=np.array(theta) * 0.9))
    energy = Energy(text.at(theta=theta), [vf.Looks(shown, loss=loss)], ["axes", "offsets"])
    x = energy.unknowns.start.copy()
    x[energy.unknowns.slices["picture.blur"]] = 0.4
    jacobian = energy.jacobian(x)
    # A loss changes the rows of all columns alike, so some columns of each show it.
    for i in range(0, len(x), 1 if loss == "soft_l1" else 6):
        step = np.zeros(len(x))
        step[i] = 1e-4 if i >= 10 and i < 14 else 1e-6
        central = (energy.residual(x + step) - energy.residual(x - step)) / (2 * step[i])
        assert jacobian[:, i] == pytest.approx(central, rel=1e-4, abs=1e-3 * abs(central).max())


def test_two_pictures_need_two_names() -> None:
    text = vf.Text("dynapuff", "S")
    shown = picture(text)
    with pytest.raises(vf.SolveError, match=r"unknowns called 'picture\.x'"):
        vf.solve(text, [vf.Looks(shown), vf.Looks(shown)])
    found = vf.solve(text, [vf.Looks(shown), vf.Looks(shown, name="second")])
    assert found.status == "converged"


def test_the_name_of_a_picture_may_begin_with_that_of_another() -> None:
    text = vf.Text("recursive", "n")
    image = picture(text.at({"wght": 700}), (24, 24))
    terms = [vf.Looks(image, name="a"), vf.Looks(image, name="a.b")]
    found = vf.solve(text, terms, max_iterations=3, restarts=0)
    assert found.cost < vf.solve(text, terms, max_iterations=0, restarts=0).cost


def test_bad_pictures_are_refused() -> None:
    text = vf.Text("dynapuff", "S")
    for looks, says in (
        (vf.Looks(np.ones((20, 20))), "uniform"),
        (vf.Looks(picture(text), loss="l3"), "no loss 'l3'"),
        (vf.Looks(picture(text), fit=["skew"]), "cannot be fitted"),
        (vf.Looks(picture(text), placement=np.eye(3)), "placement"),
    ):
        with pytest.raises(vf.ImageError, match=says):
            vf.solve(text, looks)
    with pytest.raises(vf.ImageError, match="blank"):
        vf.solve(vf.Text("dynapuff", " "), vf.Looks(picture(text)))
