"""Every term: its Jacobian against central differences, what it achieves, what it refuses."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import torch

import vfwidget as vf
from vfwidget.energy.energy import Energy
from vfwidget.raster import frame


@pytest.fixture(params=[True, False], ids=["shared", "per letter"])
def text(request: pytest.FixtureRequest) -> vf.Text:
    word = vf.Text("recursive", "hand", shared=request.param)
    # Away from every kink, so that central differences mean something.
    lower, upper = word.font.bounds
    theta = np.random.default_rng(1).uniform(lower, upper, tuple(word.theta.shape)) * 0.61 + 0.013
    return word.at(theta=theta.clip(lower + 0.01, upper - 0.01))


def handles(text: vf.Text) -> list[vf.Handle]:
    return [text.handle(i, 0, 2 + i, 0.3) for i in range(4)]


def terms_of(text: vf.Text) -> list[vf.Term]:
    a, b, c, d = handles(text)
    return [
        vf.Target(a, (100, 200), weight=2.0),
        vf.Pin(b),
        vf.Pin(b, (3, 4), weight=7.0),
        vf.SharedX([a, b, c]),
        vf.SharedY([a, c, d], weight=3.0),
        vf.Collinear([a, b, c, d]),
        vf.Distance(a, b, 140),
        vf.Distance(b, c, along="x"),
        vf.Distance(c, d, 77, along="y"),
        vf.Width(2300),
        vf.Area(4e5),
        vf.StayClose(0.5, theta=text.theta * 0),
        vf.AxisTarget({"wght": 800, "CASL": 0.2}, weight=4.0),
        vf.Residual(lambda p: (p[0] - p[1]) ** 2 / 100, handles=[a, b]),
        vf.Residual(lambda p: p.mean(0)),
    ]


@pytest.mark.parametrize("index", range(15))
def test_the_jacobian_against_central_differences(text: vf.Text, index: int) -> None:
    energy = Energy(text, [terms_of(text)[index]])
    theta = text.theta.numpy().ravel()
    jacobian = energy.jacobian(theta)
    assert jacobian.shape == (len(energy.residual(theta)), theta.size)
    for i in range(theta.size):
        step = (np.arange(theta.size) == i) * 1e-6
        central = (energy.residual(theta + step) - energy.residual(theta - step)) / 2e-6
        assert jacobian[:, i] == pytest.approx(central, rel=1e-5, abs=1e-3)


def solved(text: vf.Text, *terms: vf.Term) -> vf.Text:
    solution = vf.solve(text, [*terms, vf.StayClose()])
    assert solution.status == "converged", solution.report()
    return solution.text


def test_shared_x_and_y_align() -> None:
    text = vf.Text("roboto-flex", "nb", shared=False)
    tops = [text.nearest(600, 1080), text.nearest(1600, 1080), text.nearest(1400, 1500)]
    level = solved(text, vf.SharedY(tops[:2]))
    heights = [float(level.position(h)[1]) for h in tops[:2]]
    assert abs(heights[0] - heights[1]) < 0.5
    assert abs(float(text.position(tops[0])[1] - text.position(tops[1])[1])) > 0.5
    italic = vf.Text("roboto-flex", "l", axes={"slnt": -6})
    stem = [italic.nearest(150, 0), italic.nearest(350, 1500)]
    upright = solved(italic, vf.SharedX(stem))
    assert abs(float(upright.position(stem[0])[0] - upright.position(stem[1])[0])) < 0.6
    assert upright.axes["slnt"] > italic.axes["slnt"]


def test_collinear_puts_the_middle_on_the_line_of_the_ends() -> None:
    text = vf.Text("roboto-flex", "nmn", shared=False)
    tops = [text.nearest(600, 1100), text.nearest(1800, 1100), text.nearest(3300, 1100)]
    raised = text.at(axes=[{}, {"YTLC": 560}, {}])
    flat = solved(raised, vf.Collinear(tops))
    points = np.array([flat.position(h).tolist() for h in tops])
    across = points[2] - points[0]
    beside = points[1] - points[0]
    off = (across[0] * beside[1] - across[1] * beside[0]) / np.hypot(*across)
    assert abs(off) < 0.5


def test_distance_sets_a_stem_and_keeps_one() -> None:
    text = vf.Text("roboto-flex", "l")
    left, right = text.nearest(0, 700), text.nearest(400, 700)
    stem = float(text.position(right)[0] - text.position(left)[0])
    wider = solved(text, vf.Distance(left, right, stem + 60, along="x"))
    assert float(wider.position(right)[0] - wider.position(left)[0]) == pytest.approx(
        stem + 60, abs=0.5
    )
    # The height changes, the stem is kept.
    top = text.nearest(200, 1500)
    goal = text.position(top) + torch.tensor([0, 60])
    taller = solved(text, vf.Target(top, goal), vf.Distance(left, right, along="x", weight=100))
    assert float(taller.position(right)[0] - taller.position(left)[0]) == pytest.approx(
        stem, abs=0.5
    )


@pytest.mark.parametrize("shared", [True, False])
def test_width_fits_a_line_to_a_measure(shared: bool) -> None:
    text = vf.Text("roboto-flex", "measure", shared=shared)
    narrower = solved(text, vf.Width(0.9 * text.advance()))
    assert narrower.advance() == pytest.approx(0.9 * text.advance(), abs=0.5)


def test_area_counts_overlapping_contours_once():
    # The stem and the arms of these letters are contours that overlap.
    for name in ("recursive", "roboto-flex"):
        text, size = vf.Text(name, "NAt&"), (200, 800)
        scale = frame(text, size)
        ink = float(vf.rasterize(text, size, scale).sum() / scale[0, 0] ** 2)
        assert vf.Area().bind(text).area == pytest.approx(ink, rel=1e-6)
    # Letters that overlap each other, too.
    apart = vf.Text("recursive", "ll")
    stacked = apart.at(offsets=[(0, 0), (-apart.advance() / 2, 0)])
    whole = vf.Area().bind(apart).area
    assert vf.Area().bind(stacked).area == pytest.approx(whole / 2, rel=1e-6)


def test_area_against_the_polygon_and_towards_a_goal() -> None:
    text = vf.Text("roboto-flex", "o")
    term = vf.Area().bind(text)
    area = 0.0
    t = torch.linspace(0, 1, 2001, dtype=torch.float64)[:-1, None]
    for contour in text.segments():
        p = contour[:, :, None, :]
        x, y = (
            (1 - t) ** 3 * p[:, 0]
            + 3 * (1 - t) ** 2 * t * p[:, 1]
            + 3 * (1 - t) * t**2 * p[:, 2]
            + t**3 * p[:, 3]
        ).reshape(-1, 2).T  # fmt: skip
        area -= float((x * (torch.roll(y, -1) - torch.roll(y, 1))).sum() / 2)
    assert term.area == pytest.approx(abs(area), rel=1e-5)
    heavier = solved(text, vf.Area(1.3 * term.area))
    assert vf.Area().bind(heavier).area == pytest.approx(1.3 * term.area, rel=2e-3)


def test_axis_target_pulls_one_letter_or_all() -> None:
    text = vf.Text("recursive", "no", shared=False)
    one = vf.solve(text, [vf.AxisTarget({"wght": 800}, letter=1)]).axes
    assert [axes["wght"] for axes in one] == pytest.approx([300, 800], abs=0.1)
    both = vf.solve(text, [vf.AxisTarget({"wght": 800})]).axes
    assert [axes["wght"] for axes in both] == pytest.approx([800, 800], abs=0.1)


def test_a_report_names_what_is_met_what_is_missed_and_what_holds_it() -> None:
    text = vf.Text("roboto-flex", "H")
    foot, top = text.nearest(200, 0), text.nearest(1200, 1400)
    solution = vf.solve(text, [vf.Target(top, (9000, 9000)), vf.Pin(foot), vf.StayClose()])
    lines = solution.report().splitlines()
    assert lines[0].startswith("unreachable")
    (target,) = [line for line in lines if line.startswith("Target ")]
    assert f"{solution.misses[0]:.1f}" in target
    (pin,) = [line for line in lines if line.startswith("Pin ")]
    assert " met " in pin
    held = [line.split()[0] for line in lines if "held at its" in line]
    bounds = text.font.bounds
    tags = [axis.tag for axis in text.font.axes]
    assert held
    for tag in held:
        at = float(solution.theta[0, tags.index(tag)])
        assert at in (bounds[0][tags.index(tag)], bounds[1][tags.index(tag)])


def test_the_report_lists_a_tracking_that_has_changed() -> None:
    text = vf.Text("dynapuff", "no", tracking=10)
    wide = vf.Width(text.advance() + 80)
    found = vf.solve(text, wide, free=["tracking"])
    assert found.text.tracking == pytest.approx(50, abs=0.01)
    row = next(line for line in found.report().splitlines() if line.startswith("tracking"))
    assert row.split() == ["tracking", "10", "50"]
    assert "tracking" not in vf.solve(text, wide).report()


def test_bad_terms_say_what_is_wrong() -> None:
    text, other = vf.Text("dynapuff", "no"), vf.Text("dynapuff", "no")
    a, b = text.handle(0), text.handle(1)
    bad = {
        "at least 2": vf.SharedX([a]),
        "at least 3": vf.Collinear([a, b]),
        "not a handle": vf.SharedY([a, other.handle()]),
        "along": vf.Distance(a, b, along="z"),
        "length must be": vf.Distance(a, b, -5),
        "width": vf.Width(float("nan")),
        "area": vf.Area(0),
        "Unknown axis": vf.AxisTarget({"nope": 1}),
        "no letter 7": vf.AxisTarget({"wght": 500}, letter=7),
    }
    for says, term in bad.items():
        with pytest.raises((vf.SolveError, vf.AxisError), match=says):
            vf.solve(text, [term])
    with pytest.raises(vf.SolveError, match="no outline"):
        vf.solve(vf.Text("dynapuff", " "), [vf.Area()])


@pytest.mark.parametrize("name", vf.bundled_fonts())
def test_a_target_that_moves_evenly_does_not_make_the_axes_flicker(name: str) -> None:
    text = vf.Text(name, "a")
    em = text.font.units_per_em
    handle = text.nearest(text.advance() * 0.6, 0.3 * em)
    # Twice around a circle in small steps, in and out of reach.
    angles = np.linspace(0, 4 * np.pi, 241)
    circle = 0.02 * em * np.stack([np.cos(angles) - 1, np.sin(angles)], -1)
    here, thetas = text, []
    for place in text.position(handle).numpy() + circle:
        terms = [vf.Target(handle, place), vf.StayClose((0.001 * em) ** 2)]
        here = vf.solve(here, terms, restarts=0).text
        thetas.append(here.theta.numpy()[0])
    steps = np.diff(thetas, axis=0)
    # Flicker: an axis that leaps a tenth of its range and within three events leaps back.
    for gap in (1, 2, 3):
        leaps = (np.abs(steps[gap:]) > 0.1) & (np.abs(steps[:-gap]) > 0.1)
        assert not (leaps & (steps[gap:] * steps[:-gap] < 0)).any()


def test_a_proximity_may_be_of_tensors() -> None:
    text = vf.Text("recursive", "n", axes={"wght": 600})

    class Middle(vf.Term):
        tolerance = None

        def locate(self, text: vf.Text) -> None:
            return None

        def proximity(self, text: vf.Text) -> Any:
            return {"axes": (torch.ones_like(text.theta), text.theta / 2)}

    found = vf.solve(text, Middle())
    assert np.allclose(found.theta, text.theta / 2, atol=1e-3)


def test_a_small_miss_is_not_said_to_be_zero() -> None:
    text = vf.Text("recursive", "n")

    class Ratio(vf.Term):
        handles = (text.nearest(0, 0), text.nearest(500, 500))
        tolerance = 1e-3

        def residual(self, points: Any, theta: Any) -> Any:
            return 0 * points[:1, 0] + 0.0123

    found = vf.solve(text, Ratio(), restarts=0)
    assert "missed by 0.012 font units" in found.message
    assert "0.012" in found.report().split("axis")[0]


@pytest.mark.parametrize("free", ["offsets", "tracking"])
@pytest.mark.parametrize("aligned", [True, False])
def test_letters_stay_where_they_are_if_moving_them_changes_no_area(free: str, aligned: bool):
    text = vf.Text("afacad-flux", "AHno", axes={"wght": 860, "slnt": 8.8})
    terms: list[vf.Term] = [vf.Area(1_516_817)]
    if aligned:
        terms.append(vf.SharedX([text.nearest(200, 700), text.nearest(1500, 500)]))
    solution = vf.solve(text, terms, free=[free])
    assert solution.status == "unreachable"
    assert abs(solution.place["offsets"]).max() < 2000
    assert abs(solution.place["tracking"]).max() < 2000


@pytest.mark.parametrize("free", [["axes"], ["axes", "offsets"]])
def test_the_offset_of_a_letter_adds_nothing_to_the_width_of_a_line(free: list[str]):
    text = vf.Text("afacad-flux", "AHn").moved_to(
        {**vf.Text("afacad-flux", "AHn").place, "offsets": np.array([[0.0, 0], [0, 0], [90, 0]])}
    )
    width = text.advance() + 40
    solution = vf.solve(text, vf.Width(width), free=free)
    assert solution.status == "converged"
    assert solution.text.advance() == pytest.approx(width, abs=0.5)


def test_a_term_without_points_may_be_solved_over_offsets():
    class Sum(vf.Term):
        def residual(self, points, theta):
            return theta.sum().reshape(1)

    text = vf.Text("afacad-flux", "AHn", axes={"wght": 700})
    assert vf.solve(text, Sum(), free=["offsets"]).iterations == 0


def test_points_at_one_height_separate_vertically():
    text = vf.Text("recursive", "nh")
    arch, stem = text.nearest(300, 550), text.nearest(650, 550)
    level = vf.solve(text, vf.Distance(arch, stem, 0, along="y"), free=["offsets"]).text
    here = level.position(arch)[1] - level.position(stem)[1]
    assert abs(here) < 0.5
    level = level.moved_to({**level.place, "offsets": level.place["offsets"] + [[0, here], [0, 0]]})
    term = vf.Distance(arch, stem, 80, along="y")
    points = np.array([[300.0, 550.0], [650.0, 550.0]])
    assert term.derivative(points, level.coordinates).points.tolist() == [[[0, -1], [0, 1]]]
    solution = vf.solve(level, term, free=["offsets"])
    assert solution.status == "converged"
    assert abs(level.position(arch)[0] - solution.text.position(arch)[0]) < 1e-9


@pytest.mark.parametrize("shared", [True, False])
def test_the_cost_holds_what_axes_cost_that_are_not_free(shared: bool) -> None:
    text = vf.Text("recursive", "hand", axes={"wght": 600}, shared=shared)
    top = text.nearest(100, 700)
    goal = text.position(top) + 40
    terms = [vf.Target(top, goal), vf.AxisTarget({"wght": 300}, weight=8.0), vf.StayClose(2.0)]
    away = float((text.theta - vf.Text("recursive", "hand", shared=shared).theta).pow(2).sum())
    for _ in range(2):
        solution = vf.solve(text, terms, free=["offsets"])
        assert solution.status == "converged"
        assert solution.terms[1].cost == pytest.approx(8 * away)
        assert solution.terms[2].cost == 0
        assert solution.history[-1].cost == pytest.approx(solution.cost)
    bold = text.at(axes={"wght": 900})
    solution = vf.solve(bold, [terms[0], vf.StayClose(2.0, text.theta)], free=["offsets"])
    apart = float((bold.theta - text.theta).pow(2).sum())
    assert solution.terms[1].cost == pytest.approx(2 * apart)
