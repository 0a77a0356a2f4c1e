"""Letters that share one axis vector in a solve."""

import numpy as np
import pytest
import torch

import vfwidget as vf
from vfwidget.energy.tied import energy_of
from vfwidget.overlap.follow import follow


@pytest.fixture(scope="module")
def text() -> vf.Text:
    return vf.Text("recursive", "none", axes={"wght": 500, "CASL": 0.3}, shared=False)


def target(text: vf.Text, letter: int, dx: float, dy: float) -> vf.Target:
    handle = text.handle(letter, 0, 3, 0.5)
    x, y = text.position(handle).tolist()
    return vf.Target(handle, (x + dx, y + dy))


def test_all_letters_tied_are_a_word_with_shared_axes(text):
    shared = vf.Text("recursive", "none", axes={"wght": 500, "CASL": 0.3})
    # The squares of each of the four letters count.
    tied = vf.solve(text, [target(text, 2, 25, 10), vf.StayClose(2.5e-4)], ties=[range(4)])
    one = vf.solve(shared, [target(shared, 2, 25, 10), vf.StayClose()])
    assert tied.status == one.status
    assert tied.cost == pytest.approx(one.cost, abs=1e-6)
    assert np.allclose(tied.theta, one.theta.expand(4, -1), atol=1e-6)


def test_letters_of_a_group_stay_equal_and_the_others_are_free(text):
    solution = vf.solve(text, [target(text, 2, 5, 20), vf.StayClose(1e-3)], ties=[(1, 2)])
    assert solution.converged
    first, second, third, _ = solution.theta
    assert torch.equal(second, third)
    assert not torch.equal(second, text.theta[1])
    assert not torch.equal(first, second)


def test_a_group_starts_from_its_first_letter():
    text = vf.Text("recursive", "no", axes=[{"wght": 400}, {"wght": 900}], shared=False)
    solution = vf.solve(text, vf.StayClose(), ties=[(1, 0)])
    assert [values["wght"] for values in solution.axes] == [900, 900]


def test_the_axes_of_every_letter_of_a_group_are_pulled():
    text = vf.Text("recursive", "no", axes=[{"wght": 400}, {"wght": 900}], shared=False)
    pulled = vf.solve(text, vf.AxisTarget({"wght": 700}, letter=1), ties=[(0, 1)])
    assert [round(values["wght"]) for values in pulled.axes] == [700, 700]
    assert pulled.cost == pytest.approx(0, abs=1e-4)
    both = [vf.AxisTarget({"wght": 500}, letter=0), vf.AxisTarget({"wght": 800}, 1, weight=3e4)]
    between = vf.solve(text, both, ties=[(0, 1)])
    wanted = (text.font.normalize({"wght": 500}) + 3 * text.font.normalize({"wght": 800})) / 4
    assert torch.allclose(between.theta, wanted.expand(2, -1), atol=1e-4)


def test_the_cost_is_that_of_all_letters():
    text = vf.Text("recursive", "no", axes=[{"wght": 400}, {"wght": 900}], shared=False)
    theta, weight = text.theta.numpy(), 200.0
    found = vf.solve(text, [vf.StayClose(weight, theta), target(text, 0, 9, 3)], ties=[(0, 1)])
    away = (found.theta.numpy() - theta) ** 2
    missed = (found.text.position(found.terms[1].term.handle) - torch.tensor(
        found.terms[1].term.position
    )).square().sum()  # fmt: skip
    assert found.terms[0].cost == pytest.approx(weight * away.sum())
    assert found.cost == pytest.approx(weight * away.sum() + float(missed))
    assert found.history[-1].cost == pytest.approx(found.cost)


def test_the_jacobian_follows_from_differences(text):
    terms = [target(text, 1, 5, 5), vf.SharedY([text.handle(0, 0, 1), text.handle(3, 0, 2)])]
    energy = energy_of(text, terms, ties=[(0, 1), (3, 2)])
    z = np.random.default_rng(4).uniform(0.2, 0.6, len(energy.lower))
    differences = [
        (energy.residual(z + step) - energy.residual(z - step)) / 2e-6
        for step in 1e-6 * np.eye(len(z))
    ]
    assert np.allclose(energy.jacobian(z), np.transpose(differences), atol=1e-3)


def test_locks_and_pins_hold(text):
    handle = text.handle(0, 0, 0)
    terms = [target(text, 1, 30, 0), vf.Pin(handle), vf.StayClose()]
    solution = vf.solve(text, terms, locks=["slnt"], ties=[(0, 1)])
    assert all(values["slnt"] == 0 for values in solution.axes)
    assert torch.dist(solution.text.position(handle), text.position(handle)) < 0.5


@pytest.mark.parametrize("shared", [True, False])
def test_nothing_tied_is_the_usual_energy(shared):
    text = vf.Text("recursive", "no", shared=shared)
    for ties in [(), [(0,), (1,)]]:
        assert type(energy_of(text, [vf.StayClose()], ties=ties)).__name__ == "Energy"


@pytest.mark.parametrize("ties", [3, [3], [(0, 9)], [(-1, 0)], [(0, 1), (1, 2)], [(1, 1)], ["ab"]])
def test_wrong_ties_are_refused(text, ties):
    with pytest.raises(vf.SolveError, match="ties"):
        vf.solve(text, vf.StayClose(), ties=ties)


def test_tied_letters_avoid_an_obstacle_together():
    text = vf.Text("roboto-flex", "nn", shared=False)
    right = float(text.points()[:, 0].max())
    bar = [(right + a, b) for a, b in [(40, -300), (50, -300), (50, 1500), (40, 1500)]]
    handle = text.nearest(right, 400)
    x, y = text.position(handle).tolist()
    terms = [vf.Target(handle, (x + 200, y)), vf.StayClose()]
    followed = follow(text, terms, vf.NoOverlap(bar), ties=[(0, 1)], substeps=3)
    theta = followed.solution.theta
    assert torch.equal(theta[0], theta[1])
    assert followed.solution.text.points()[:, 0].max() == pytest.approx(right + 40, abs=0.5)
    assert len(followed.contacts) > 0


def test_the_limit_counts_the_unknowns_of_tied_letters_once(text, monkeypatch):
    terms = [target(text, letter, 2, 2) for letter in range(4)]
    # Eight residuals of five axes; without ties they would be twenty.
    monkeypatch.setattr(vf.limits, "step_products", 8 * 5 * 5)
    vf.solve(text, terms, ties=[range(4)], restarts=0)
    with pytest.raises(vf.SolveError, match=r"too large.*20 unknowns"):
        vf.solve(text, terms, restarts=0)
    monkeypatch.setattr(vf.limits, "step_products", 4 * 5 * 4 - 1)
    with pytest.raises(vf.SolveError, match=r"too large.*4 residuals and 5 unknowns"):
        vf.solve(text, terms, ties=[range(4)], restarts=0)


@pytest.mark.parametrize("free", [("axes",), ("offsets",), ("axes", "offsets")])
def test_half_of_the_letters_are_tied(text, free):
    terms = [target(text, letter, 3, 3) for letter in range(4)] + [vf.StayClose()]
    solution = vf.solve(text, terms, ties=[(0, 1)], free=free, restarts=0)
    assert torch.equal(solution.theta[0], solution.theta[1])
    assert solution.cost <= vf.solve(text, terms, max_iterations=0, restarts=0).cost
