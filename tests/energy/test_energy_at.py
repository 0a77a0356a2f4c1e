"""The energy of a drag is kept from event to event: it must be the one that is made anew."""

from __future__ import annotations

import gc
import weakref
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
import varc_fonts
import variation_tables
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

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


def test_beyond_a_boundary_the_rows_of_those_glyphs_are_kept() -> None:
    upright = vf.Text("recursive", "k", {"slnt": -13, "CRSV": 0.5})
    italic = upright.at({"slnt": -15, "CRSV": 1})
    assert upright.glyphs[0].name != italic.glyphs[0].name

    def pull(text: vf.Text) -> list[vf.Term]:
        return [vf.Target(text.handle(0, 0, 1), (100, 200)), vf.StayClose(1e-3)]

    there = energy_of(italic, pull(italic))
    found = energy_of(upright, pull(upright)).at(italic, pull(italic))
    assert found._compiled is there._compiled
    assert_same(found, Energy(italic, pull(italic)))
    # Also where the energy left behind had no such terms.
    other = Energy(upright, pull(upright)[:1])
    energy_of(italic, pull(italic))
    assert_same(other.at(italic, pull(italic)), Energy(italic, pull(italic)))
    locked = energy_of(upright, pull(upright), locks=("wght",)).at(italic, pull(italic))
    assert_same(locked, Energy(italic, pull(italic), locks=("wght",)))


@pytest.mark.parametrize("name", vf.bundled_fonts())
def test_at_the_ends_of_axes_derivatives_are_those_into_the_range(name: str) -> None:
    text = vf.Text(name, "a")
    energy = Energy(text, [vf.Target(text.handle(0, 0, 1, 0.25), (100, 200))])
    lower, upper = text.font.bounds
    kinks = energy.kinks
    assert ((kinks > lower[:, None]) & ((kinks < upper[:, None]) | (kinks == np.inf))).all()
    rng = np.random.default_rng(5)
    for _ in range(40):
        x = np.where(rng.random(len(lower)) < 0.5, lower, upper)
        x = np.where(rng.random(len(x)) < 0.3, rng.uniform(lower, upper), x)
        for i in range(len(x)):
            step = (1e-6 if x[i] < upper[i] else -1e-6) * (np.arange(len(x)) == i)
            slope = (energy.residual(x + step) - energy.residual(x)) / step[i]
            np.testing.assert_allclose(energy.jacobian(x)[:, i], slope, rtol=1e-5, atol=1e-4)


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
    heavy = vf.Target(target.handle, target.position, weight=np.array([1.0, 2.0]))
    with pytest.raises(vf.SolveError, match="weight"):
        energy_of(text, [heavy, pin, calm])
    nowhere = vf.Target(np.zeros(2), target.position, weight=2.0)
    with pytest.raises(vf.SolveError, match="not a handle"):
        energy_of(text, [nowhere, pin, calm])
    with pytest.raises(vf.SolveError, match=r"must be a Term.*received 1"):
        energy_of(text, [1, 2, 3])
    with pytest.raises(vf.SolveError, match="list of terms"):
        energy_of(text, [])


def assert_equal_solutions(found: vf.Solution, expected: vf.Solution) -> None:
    assert (found.status, found.message) == (expected.status, expected.message)
    assert (found.cost, found.iterations) == (expected.cost, expected.iterations)
    assert found.misses == expected.misses
    assert set(found.place) == set(expected.place)
    for name, value in found.place.items():
        assert np.array_equal(value, expected.place[name])
    assert np.array_equal(found.active, expected.active)
    for mine, other in zip(found.history, expected.history, strict=True):
        assert np.array_equal(mine.x, other.x) and mine.cost == other.cost


def moved_and_swapped() -> bytes:
    """An axis moves another one, and glyphs change."""
    return variation_tables.avar_2_with_conditions()


TEXTS: dict[str, Callable[[], vf.Text]] = {
    "shared": lambda: vf.Text("recursive", "hk", {"wght": 500}, tracking=9),
    "per letter": lambda: vf.Text("recursive", "hk", {"wght": 500}, shared=False),
    "moved": lambda: vf.Text("recursive", "hk", offsets=[(3, -40), (12, 0)]),
    "rotated": lambda: vf.Text("recursive", "hk", {"wght": 500}, rotations=[0.2, -0.1]),
    "other glyphs": lambda: vf.Text(
        "recursive", "hk", {"CRSV": 0.5, "slnt": -7, "wght": 400}, shared=False
    ),
    "components": lambda: vf.Text(vf.load_font(varc_fonts.varc()), "ac"),
    "moved axes": lambda: vf.Text(vf.load_font(moved_and_swapped()), "aa", shared=False),
}


@pytest.mark.parametrize("name", TEXTS)
def test_a_drag_is_that_of_new_texts(name: str) -> None:
    text = TEXTS[name]()
    for shift in (10, -25, 40):
        solutions = []
        for own in (text, TEXTS[name]()):
            handle = own.handle(1, 0, 1, 0.5)
            x, y = own.position(handle).tolist()
            goal = vf.Target(handle, (x + shift, y))
            solutions.append(vf.solve(own, [goal, vf.StayClose(0.5)], restarts=1))
        assert_equal_solutions(*solutions)


def test_the_limit_of_a_solve_may_be_lowered(
    text: vf.Text, monkeypatch: pytest.MonkeyPatch
) -> None:
    vf.solve(text, terms(text, 10))
    monkeypatch.setattr(vf.limits, "step_products", 1)
    with pytest.raises(vf.SolveError, match="too large"):
        vf.solve(text, terms(text, 20))


def test_a_tolerance_may_be_changed(text: vf.Text, monkeypatch: pytest.MonkeyPatch) -> None:
    energy_of(text, terms(text, 10)).least_goal  # noqa: B018
    monkeypatch.setattr(vf.Target, "tolerance", 0.01)
    expected = Energy(text, terms(text, 20)).least_goal
    assert energy_of(text, terms(text, 20)).least_goal == expected < 1e-2


def test_locks_of_every_kind(text: vf.Text) -> None:
    for locks in (
        ["CASL", "wght"],
        ("wght",),
        {"slnt"},
        {"slnt": 1},
        np.array(["CASL"]),
        np.array(["CASL", "wght"]),
        np.array([]),
        [],
        None,
        ("CASL",),
    ):
        for shift in (10, 20):
            found = energy_of(text, terms(text, shift), locks=locks)
            assert_same(found, Energy(text, terms(text, shift), locks=locks))
    locks = ["CASL"]
    energy_of(text, terms(text, 10), locks=locks)
    locks.append("wght")
    for other in (locks, ["CASL"]):
        found = energy_of(text, terms(text, 10), locks=other)
        assert_same(found, Energy(text, terms(text, 10), locks=other))


def test_a_goal_is_a_copy_of_an_array(text: vf.Text) -> None:
    handle, goals = text.handle(1, 0, 2, 0.3), np.full((3, 2), 70.0)
    start = text.theta.numpy().copy()
    found = vf.solve(text, [vf.Target(handle, goals[1]), vf.StayClose(1.0, start)])
    goals[:], start[:] = 0, 0
    result, calm = found.terms
    assert result.term.position.tolist() == [70, 70]
    assert np.array_equal(calm.term.theta, text.theta)
    # The text keeps the energy, but not an array of which a goal is a part.
    left = weakref.ref(goals)
    del goals
    gc.collect()
    assert left() is None


class Named(vf.Term):
    """A user's term may have any attribute."""

    affine = True

    def __init__(self, handle: vf.Handle, height: float, form: str) -> None:
        self.handles, self.height, self.form = (handle,), height, form

    def residual(self, points: Any, theta: Any) -> Any:
        return points[:, 1] - self.height

    def derivative(self, points: Any, theta: Any) -> vf.Derivative:
        return vf.Derivative(points=np.array([[[0.0, 1.0]]]))


def test_a_term_of_a_user_has_any_attributes(text: vf.Text) -> None:
    handle = text.handle(1, 0, 2, 0.3)
    for height in (50.0, 90.0):
        named = [Named(handle, height, "round")]
        assert_same(energy_of(text, named), Energy(text, named))


# Random sequences of solves


@dataclass(frozen=True)
class Doubled(vf.StayClose):
    """A class derived from a term, with another proximity and no field of its own."""

    def proximity(self, text: vf.Text) -> Any:
        weights, reference = super().proximity(text)["axes"]
        return {"axes": (2 * weights, reference)}


KINDS = ("target", "target", "pin", "calm", "calm at zero", "doubled", "stretched", "width", "same")


def made(text: vf.Text, kind: str, letter: int, shift: float, weight: float) -> vf.Term:
    handle, other = text.handle(letter, 0, 1, 0.25), text.handle(1 - letter, 0, 0)
    x, y = text.position(handle).tolist()
    goal = (x + shift, y - shift / 2)
    terms: dict[str, Callable[[], vf.Term]] = {
        "target": lambda: vf.Target(handle, goal, weight),
        "pin": lambda: vf.Pin(handle, weight=weight),
        "calm": lambda: vf.StayClose(weight),
        "calm at zero": lambda: vf.StayClose(weight, np.zeros(text.theta.shape)),
        "doubled": lambda: Doubled(weight),
        "stretched": lambda: Stretched(handle, goal, weight, factor=2 + shift / 100),
        "width": lambda: vf.Width(700 + shift, weight),
        "same": lambda: vf.SharedX((handle, other), weight),
    }
    return terms[kind]()


KIND = st.tuples(st.sampled_from(KINDS), st.integers(0, 1), st.sampled_from([1.0, 2.0, 1e3]))
OPTIONS: list[dict[str, Any]] = [
    {},
    {"locks": ("wght",)},
    {"locks": ["wght"]},
    {"free": ("axes", "offsets")},
    {"free": ("axes", "tracking")},
    {"ties": [(0, 1)]},
]


@settings(max_examples=25, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(
    name=st.sampled_from(sorted(TEXTS)),
    kinds=st.lists(KIND, min_size=1, max_size=3),
    steps=st.lists(
        st.tuples(
            st.sampled_from(["goal", "goal", "result", "theta", "tracking", "rotations"]),
            st.sampled_from([0, 5, -20, 45]),
            st.sampled_from([*3 * OPTIONS[:1], *OPTIONS]),
            st.integers(0, 9),
        ),
        min_size=2,
        max_size=5,
    ),
)
def test_each_solve_of_a_text_is_that_of_a_new_text(name: str, kinds: Any, steps: Any) -> None:
    text = TEXTS[name]()
    for change, shift, options, seed in steps:
        rng = np.random.default_rng(seed)
        if change == "theta":
            text = text.at(theta=rng.uniform(-0.9, 0.9, tuple(text.theta.shape)))
        elif change in ("tracking", "rotations"):
            text = text.at(**{change: 7.0 * seed if change == "tracking" else [0.1 * seed, 0]})
        place = {name: value.copy() for name, value in text.place.items() if name != "axes"}
        new = TEXTS[name]().at(
            theta=text.theta.clone(),
            offsets=place["offsets"],
            tracking=text.tracking,
            rotations=text.rotations.copy(),
        )
        solutions = []
        for own in (text, new):
            # The first term is the one whose goal moves.
            all_terms = [made(own, *kinds[0][:2], shift, kinds[0][2])]
            all_terms += [made(own, kind, letter, 8, weight) for kind, letter, weight in kinds[1:]]
            solutions.append(vf.solve(own, all_terms, restarts=0, max_iterations=25, **options))
        assert_equal_solutions(*solutions)
        if change == "result":
            text = solutions[0].text
