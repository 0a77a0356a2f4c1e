"""The term that keeps letters apart, and the search for the nearest free state."""

from __future__ import annotations

import time

import numpy as np
import pytest

import vfwidget as vf
from benchmarks.overlap_cases import cases
from vfwidget.energy.tied import energy_of
from vfwidget.overlap import resolve
from vfwidget.overlap.inequalities import Walls
from vfwidget.overlap.walls import Room

HUGE = [(-5000, -5000), (5000, -5000), (5000, 5000), (-5000, 5000)]


def pushed_together(name="recursive", string="NT", by=150.0, shared=False):
    text = vf.Text(name, string, shared=shared)
    return text.at(offsets=[(-i * by, 0) for i in range(len(text.glyphs))])


def distance(text):
    """The smallest distance between sampled points of the first two letters."""
    t = np.linspace(0, 1, 50)
    weights = np.stack([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t * t * (1 - t), t**3], -1)
    contours = [np.einsum("tj,sjd->std", weights, s.numpy()) for s in text.segments()]
    count = len(text.glyphs[0].contours)
    sides = [
        np.concatenate([c.reshape(-1, 2) for c in part])
        for part in (contours[:count], contours[count:])
    ]
    return np.sqrt(((sides[0][:, None] - sides[1][None]) ** 2).sum(-1)).min()


@pytest.mark.parametrize(
    "options", [{}, {"gap": 30.0}, {"method": "planes"}, {"method": "planes", "gap": 30.0}], ids=str
)
def test_derivatives(options):
    # An obstacle as well, and not at a kink.
    text = pushed_together().at(theta=[[0.3, 0.4, 0.2, -0.3, 0.1], [0.2, 0.1, 0.5, -0.2, 0.3]])
    text = text.at(offsets=[(0, 0), (-200, 3)])
    bar = [(100, 300), (160, 290), (170, 420)]
    assert vf.check_derivative(vf.NoOverlap([bar], **options), text) < 1e-4


class Writing(vf.NoOverlap):
    """A term that writes to its arguments."""

    def residual(self, points, theta):
        found = super().residual(points, theta)
        points += 50.0
        return found


def test_a_term_that_writes_to_its_arguments_does_not_move_the_text():
    text = pushed_together()
    rows = Writing([[(100, 300), (160, 290), (170, 420)]]).bind(text).locate(text)
    before = rows.residual(text.place)
    assert before.any()
    assert (rows.residual(text.place) == before).all()


def test_a_bound_term_has_the_points_of_the_text_that_it_is_located_at():
    text = pushed_together()
    bound = vf.NoOverlap().bind(text)
    for other in text.at(rotations=[0.3, -0.2]), text.at(tracking=40), text.at({"wght": 900}):
        found = bound.locate(other).points.positions(other.place)
        np.testing.assert_allclose(found, other.points().numpy(), atol=1e-9)


def test_the_square_of_the_residual_is_the_area():
    text = pushed_together(by=200)
    solution = vf.solve(text, [vf.NoOverlap(weight=2.0)], max_iterations=0, restarts=0)
    area = sum(overlap.area for overlap in vf.overlaps(text))
    assert area > 100
    assert solution.terms[0].cost == pytest.approx(2 * area)
    assert solution.terms[0].miss == pytest.approx(np.sqrt(area))


def test_a_solve_with_other_terms():
    text = pushed_together()
    top = text.nearest(100, 700)
    solution = vf.solve(text, [vf.NoOverlap(), vf.Pin(top), vf.StayClose()])
    assert vf.overlaps(solution.text) == []
    np.testing.assert_allclose(solution.text.position(top), text.position(top), rtol=0, atol=0.5)


@pytest.mark.parametrize("method", ["area", pytest.param("planes", marks=pytest.mark.slow)])
def test_letters_are_resolved(method):
    text = pushed_together()
    solution = vf.resolve_overlaps(text, method=method)
    if method == "planes":
        # Planes at samples may leave a sliver, which is not called free.
        assert solution.area < 0.01 and solution.free == (solution.area <= 1e-3)
        return
    assert solution.free and solution.area == 0
    assert vf.overlaps(solution.text) == []
    assert 0 < float((solution.theta - text.theta).norm()) < 1


@pytest.mark.slow
def test_a_gap_is_kept():
    solution = vf.resolve_overlaps(pushed_together(), gap=15.0)
    assert solution.free
    assert distance(solution.text) > 14.5


def test_only_letters_that_must_change_do():
    text = pushed_together(string="NTll", by=0.0).at(offsets=[(0, 0), (-150, 0), (0, 0), (0, 0)])
    solution = vf.resolve_overlaps(text)
    assert solution.free
    np.testing.assert_allclose(solution.theta[2:], text.theta[2:], rtol=0, atol=1e-9)


def test_a_free_text_stays():
    text = vf.Text("recursive", "NT")
    solution = vf.resolve_overlaps(text)
    assert solution.free and solution.area == 0
    np.testing.assert_array_equal(solution.theta, text.theta)


def test_a_free_state_at_the_bounds_of_several_axes_is_found():
    # Descents of the common area end in local minima.
    text = vf.Text("roboto-flex", "HH", tracking=-500)
    solution = vf.resolve_overlaps(text, restarts=1)
    assert solution.free and vf.overlaps(solution.text) == []
    assert float((solution.theta - text.theta).norm()) < 2.0


def test_a_free_state_has_no_inequalities():
    text = vf.Text("recursive", "NT")
    energy = energy_of(text, [vf.StayClose()])
    room, x = Room(energy, vf.NoOverlap().bind(text)), energy.unknowns.start
    model = room.model(room.look(x))
    assert model.own.slopes.shape == (0, len(x))
    np.testing.assert_array_equal(model.minimum(), x)


@pytest.mark.parametrize("bulge", [0.0, 0.5, 1.0])
def test_the_bulge_of_an_overlap_is_measured_from_a_deeper_one(bulge):
    slopes, unknown = np.zeros((3, 2)), np.full(3, 0.5)
    pair, depths, lengths = np.array([4, 7, 7]), np.array([4.0, 2, 2]), np.array([10.0, 5, 5])
    before = Walls(pair, slopes, -depths, depths, lengths, unknown)
    now = Walls(pair, slopes, -depths / 8, depths / 8, lengths / 8**bulge, unknown)
    # The two overlaps of pair 7 cannot be told apart.
    np.testing.assert_allclose(now.since(before).bulges, [bulge, 0.5, 0.5])
    np.testing.assert_array_equal(before.since(now).bulges, unknown)


def test_locks_are_respected():
    text = pushed_together()
    solution = vf.resolve_overlaps(text, locks=["slnt", "MONO"])
    tags = [axis.tag for axis in text.font.axes]
    locked = [tags.index("slnt"), tags.index("MONO")]
    np.testing.assert_array_equal(solution.theta[:, locked], text.theta[:, locked])
    assert solution.free


def test_letters_that_are_tied_together_stay_equal():
    text = vf.Text("roboto-flex", "lon", axes={"wght": 900, "wdth": 120}, shared=False)
    text = text.at(offsets=[(0, 0), (-200, 0), (0, 0)])
    assert vf.overlaps(text)
    solution = vf.resolve_overlaps(text, ties=[(0, 2)])
    assert solution.free and vf.overlaps(solution.text) == []
    first, second, third = solution.axes
    assert first == third != second


def test_what_cannot_be_resolved():
    solution = vf.resolve_overlaps(vf.Text("dynapuff", "o"), [HUGE], restarts=1)
    assert not solution.free
    assert solution.area > 1e4
    assert solution.blocked_by and all("imum" in bound for bound in solution.blocked_by)


def test_the_nearest_state_is_found_where_nothing_is_free():
    # Making the letter smaller gains much. The little that is gained beyond that does not
    # justify a large move.
    text = vf.Text("dynapuff", "o", axes={"wght": 600})
    solution = vf.resolve_overlaps(text, [HUGE], restarts=2)
    assert not solution.free and solution.status == "unreachable"
    assert solution.iterations > 0
    again = vf.resolve_overlaps(solution.text, [HUGE], restarts=2)
    assert float((again.theta - solution.theta).norm()) < 0.1
    assert again.area >= 0.97 * solution.area


def test_nothing_moves_where_nothing_is_gained():
    text = vf.Text("recursive", "H")
    locks = [axis.tag for axis in text.font.axes if axis.tag != "CRSV"]
    solution = vf.resolve_overlaps(text, [HUGE], locks=locks)
    assert not solution.free
    np.testing.assert_array_equal(solution.theta, text.theta)


def test_an_axis_leaves_its_kink_to_the_better_side():
    # The default is a kink of every axis, and the end of the slant's range.
    solution = vf.resolve_overlaps(pushed_together())
    assert solution.free
    assert float(solution.theta.norm()) < 0.11


@pytest.mark.parametrize("case", list(cases(6)), ids=lambda case: case.kind)
def test_cases_with_a_witness(case):
    solution = vf.resolve_overlaps(case.text, case.obstacles)
    left = sum(overlap.area for overlap in vf.overlaps(solution.text, case.obstacles))
    assert solution.free
    assert left <= 1e-3
    # The witness is free as well, and a nearer state was found.
    away = float((solution.theta - case.text.theta).norm())
    assert away <= float(np.linalg.norm(case.witness - case.text.theta.numpy()))


@pytest.mark.parametrize(
    "options, message",
    [
        ({"gap": -1}, "gap must be a number of font units"),
        ({"gap": float("nan")}, "gap must be"),
        ({"gap": 1e300}, "gap must be"),
        ({"between_glyphs": np.zeros(2)}, "between_glyphs must be"),
        ({"method": np.zeros(2)}, "method must be one of"),
        ({"method": "voxels"}, "method must be one of"),
        ({"between_glyphs": False}, "needs obstacles, or between_glyphs=True"),
        ({"obstacles": [[(0, 0), (1, np.inf), (2, 3)]]}, "must be finite"),
    ],
)
def test_terms_that_are_none(options, message):
    with pytest.raises(vf.OverlapError, match=message):
        vf.solve(vf.Text("recursive", "a"), vf.NoOverlap(**options))
    with pytest.raises(vf.OverlapError, match=message):
        vf.resolve_overlaps(vf.Text("recursive", "a"), **options)


def test_swapped_and_bad_arguments_are_refused() -> None:
    text = vf.Text("recursive", "NT")
    with pytest.raises(vf.SolveError, match="needs a Text first; received str"):
        vf.resolve_overlaps("NT")  # type: ignore[arg-type]
    with pytest.raises(vf.SolveError, match="restarts must be a whole number"):
        vf.resolve_overlaps(text, restarts="many")  # type: ignore[arg-type]
    for seconds in ("soon", float("nan"), -1):
        with pytest.raises(vf.SolveError, match="seconds must be"):
            vf.resolve_overlaps(text, seconds=seconds)  # type: ignore[arg-type]
    with pytest.raises(vf.SolveError, match="terms must be a term or a sequence"):
        vf.resolve_overlaps(text, terms=3)  # type: ignore[arg-type]


@pytest.mark.parametrize("gap", [np.int64(20), np.float32(20), 20])
def test_a_gap_is_any_real_number(gap):
    text = pushed_together(by=10)
    start = {"max_iterations": 0, "restarts": 0}
    solutions = [vf.solve(text, vf.NoOverlap(gap=one), **start) for one in (gap, 20.0)]
    assert solutions[0].terms[0].miss == solutions[1].terms[0].miss


def test_true_is_no_gap():
    with pytest.raises(vf.OverlapError, match="gap must be a number"):
        vf.resolve_overlaps(pushed_together(), gap=True)


def test_no_other_place_is_looked_for_after_the_time(monkeypatch):
    def fails(*_):
        raise AssertionError("another place was looked for")

    # Finding it may take minutes.
    monkeypatch.setattr("vfwidget.overlap.resolve._Search.each_best", fails)
    text = vf.Text("recursive", "NT")
    assert not vf.resolve_overlaps(text, [HUGE], seconds=0).free


def test_little_is_computed_after_the_time(monkeypatch):
    text = vf.Text("roboto-flex", "NT", tracking=-300, shared=False)
    looks = []
    look_between = resolve._Search.look_between

    def counted(search, *arguments):
        looks.append(time.perf_counter() > search.until)
        return look_between(search, *arguments)

    def fails(*_):
        raise AssertionError("the common area was minimised")

    monkeypatch.setattr(resolve._Search, "look_between", counted)
    monkeypatch.setattr(resolve._Search, "pushed", fails)
    # A state is halved towards the user's state by several looks, each of which may take long.
    assert not vf.resolve_overlaps(text, [HUGE], gap=5.0, seconds=0).free
    assert sum(looks) <= 1


@pytest.mark.filterwarnings("error")
def test_a_text_beyond_the_ends_of_its_axes_is_brought_back():
    text = vf.Text("roboto-flex", "ello", shared=False)
    lower, upper = text.font.bounds
    rng = np.random.default_rng(4)
    for tracking in (-60.0, 200.0):
        there = text.at(theta=rng.uniform(-1, 1, tuple(text.theta.shape)), tracking=tracking)
        found = vf.resolve_overlaps(there, gap=60.0).theta.numpy()
        assert ((lower <= found) & (found <= upper)).all()


def test_one_term_needs_no_list():
    text = pushed_together()
    pin = vf.Pin(text.handle(0, 0, 0, 0))
    one, listed = (vf.resolve_overlaps(text, terms=terms) for terms in (pin, [pin]))
    assert (one.theta == listed.theta).all()


def test_a_free_result_says_which_goals_it_misses():
    text = vf.Text("roboto-flex", "NT").at(offsets=[(0, 0), (-260, 0)])
    solution = vf.resolve_overlaps(text, terms=[vf.Pin(text.nearest(700, 700), (700, 5000))])
    miss = solution.terms[-1].miss
    assert solution.free and miss > 1
    assert solution.status == "unreachable"
    assert solution.message.startswith(f"nothing overlaps; Pin N is missed by {miss:.1f}")
    met = vf.resolve_overlaps(text)
    assert met.free and (met.status, met.message) == ("converged", "every goal is met")


def test_what_is_left_is_said_with_the_goals_that_are_missed():
    text = vf.Text("dynapuff", "o")
    target = vf.Target(text.handle(0), (900, 900))
    solution = vf.resolve_overlaps(text, [HUGE], terms=[target], restarts=0)
    assert solution.status == "unreachable"
    assert "square font units overlap, and no free state was found; Target o" in solution.message


def test_a_search_that_ends_by_time_says_so():
    solution = vf.resolve_overlaps(vf.Text("dynapuff", "o"), [HUGE], seconds=0)
    assert not solution.free
    assert solution.status == "time_limit" and not solution.converged
    assert "the time limit was reached" in solution.message


def test_a_gap_that_is_not_kept_is_no_overlap():
    text = vf.Text("recursive", "HH", shared=False)
    solution = vf.resolve_overlaps(text, gap=3000.0, restarts=0)
    assert solution.area == 0 and not solution.free
    assert "the gap of 3000 font units is not kept" in solution.message
