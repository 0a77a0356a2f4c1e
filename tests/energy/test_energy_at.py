"""The energy of a drag is kept from event to event: it must be the one that is made anew."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

import vfwidget as vf
from vfwidget.energy.energy import Energy
from vfwidget.energy.tied import energy_of


@pytest.fixture(params=[True, False], ids=["shared", "per letter"])
def text(request: pytest.FixtureRequest) -> vf.Text:
    return vf.Text("recursive", "hand", {"wght": 500}, shared=request.param, tracking=12)


def terms(text: vf.Text, shift: float) -> list[vf.Term]:
    a, b = text.handle(1, 0, 2, 0.3), text.handle(3, 0, 1, 0.6)
    x, y = text.position(a).tolist()
    return [vf.Target(a, (x + shift, y - shift), weight=2.0), vf.Pin(b), vf.StayClose(0.5)]


def assert_same(found: Energy, expected: Energy) -> None:
    x = expected.unknowns.start + 0.013
    for values in ("lower", "upper", "kinks"):
        assert np.array_equal(getattr(found, values), getattr(expected, values))
    assert np.array_equal(found.unknowns.start, expected.unknowns.start)
    assert np.array_equal(found.residual(x), expected.residual(x))
    assert np.array_equal(found.jacobian(x), expected.jacobian(x))
    for mine, other in zip(found.proximity, expected.proximity, strict=True):
        assert np.array_equal(mine, other)
    results = [[(r.miss, r.cost) for r in energy.results(x)] for energy in (found, expected)]
    assert results[0] == results[1]


@pytest.mark.parametrize("options", [{}, {"locks": ("CASL",)}, {"free": ("axes", "offsets")}])
def test_a_goal_that_moves(text: vf.Text, options: dict[str, Any]) -> None:
    first = energy_of(text, terms(text, 10), **options)
    moved = text.at(theta=0.9 * text.theta, offsets=np.full((4, 2), 3.0), tracking=-7)
    again = energy_of(moved, terms(moved, -20), **options)
    assert again._compiled is first._compiled
    assert_same(again, Energy(moved, terms(moved, -20), **options))
    # The first energy is as it was.
    assert_same(first, Energy(text, terms(text, 10), **options))


def test_other_weights_handles_and_options(text: vf.Text) -> None:
    energy_of(text, terms(text, 10))
    target, pin, calm = terms(text, 10)
    other = vf.Pin(text.handle(2, 0, 1, 0.5))
    for changed in ([target, pin, vf.StayClose(3.0)], [target, other, calm], [pin, target, calm]):
        assert_same(energy_of(text, changed), Energy(text, changed))
    free = ["axes"]
    energy_of(text, [target, calm], free)
    free.append("offsets")
    assert_same(energy_of(text, [target, calm], free), Energy(text, [target, calm], free))


def test_letters_that_are_rotated(text: vf.Text) -> None:
    energy_of(text, terms(text, 10))
    rotated = text.at(rotations=[0.1, 0.2, -0.3, 0.0])
    assert_same(energy_of(rotated, terms(rotated, 10)), Energy(rotated, terms(rotated, 10)))


@dataclass(frozen=True)
class Stretched(vf.Target):
    """A class derived from a term, with a field of its own."""

    factor: float = 1.0

    def residual(self, points: Any, theta: Any) -> Any:
        return self.factor * (points[0] - self.position)

    def derivative(self, points: Any, theta: Any) -> vf.Derivative:
        return vf.Derivative(points=self.factor * np.eye(2)[:, None, :])


def test_a_class_that_is_derived_elsewhere(text: vf.Text) -> None:
    handle = text.handle(1, 0, 2, 0.3)
    for factor in (1.0, 3.0):
        stretched = [Stretched(handle, (50.0, 60.0), factor=factor)]
        assert_same(energy_of(text, stretched), Energy(text, stretched))


def test_goals_are_still_checked(text: vf.Text) -> None:
    energy_of(text, terms(text, 10))
    target, pin, calm = terms(text, 10)
    bad = vf.Target(target.handle, (np.nan, 0.0), weight=2.0)
    with pytest.raises(vf.SolveError, match="two finite numbers"):
        energy_of(text, [bad, pin, calm])
    with pytest.raises(vf.SolveError, match="list of terms"):
        energy_of(text, [])
