"""What a solve promises whatever its terms are: no cache mixes them up, no claim is too large."""

from __future__ import annotations

import copy
import pickle
from dataclasses import dataclass
from typing import Any, ClassVar

import fonts
import numpy as np
import pytest
import torch

import vfwidget as vf
from vfwidget.energy.energy import Energy


def word(shared: bool = True) -> tuple[vf.Text, vf.Handle, vf.Handle, vf.Handle]:
    text = vf.Text("recursive", "hand", shared=shared)
    return text, text.handle(0, 0, 2, 0.3), text.handle(1, 0, 3, 0.3), text.handle(2, 0, 1, 0.3)


@pytest.mark.parametrize("shared", [True, False])
def test_solves_on_one_word_do_not_disturb_each_other(shared: bool) -> None:
    def solves() -> tuple[vf.Text, list[list[vf.Term]]]:
        text, a, b, c = word(shared)
        goal = text.position(a) + 20
        return text, [
            [vf.Target(a, goal), vf.StayClose()],
            [vf.Distance(a, b, 60)],
            [vf.Area()],
            [vf.Collinear([a, b, c])],
            [vf.Target(a, goal)],
            [vf.Width(2000)],
        ]

    # Each on a word of its own, on which nothing was solved before.
    fresh = []
    for i in range(6):
        text, terms = solves()
        fresh.append(vf.solve(text, terms[i]))
    text, terms = solves()
    for i in (*range(6), *range(5, -1, -1)):
        assert np.allclose(vf.solve(text, terms[i]).theta, fresh[i].theta, atol=1e-9)


@dataclass(frozen=True)
class Scaled(vf.Term):
    """A stranger's affine term with one more field: the x of a handle, times a factor."""

    handle: vf.Handle
    factor: float
    goal: float
    affine: ClassVar[bool] = True

    @property
    def handles(self) -> tuple[vf.Handle, ...]:
        return (self.handle,)

    def residual(self, points: np.ndarray, theta: np.ndarray) -> np.ndarray:
        return self.factor * points[:, 0] - self.goal

    def derivative(self, points: np.ndarray, theta: np.ndarray) -> vf.Derivative:
        return vf.Derivative(points=np.array([[[self.factor, 0.0]]]))


def test_an_affine_term_with_a_field_more_gets_its_own_derivative() -> None:
    text, a, _, _ = word()
    x = float(text.position(a)[0])
    for factor in (1.0, 2.0, -3.0):
        term = Scaled(a, factor, factor * (x - 12))
        found = vf.solve(text, [term, vf.StayClose()])
        assert float(found.text.position(a)[0]) == pytest.approx(x - 12, abs=0.05)
        moved = text.at(axes={"wght": 533, "CASL": 0.31, "slnt": -3.3, "MONO": 0.2})
        assert vf.check_derivative(term, moved) < 1e-6


def test_the_curved_and_the_compiled_form_of_a_term_agree() -> None:
    class Curved(Scaled):
        affine = False

    text, a, _, _ = word()
    x = float(text.position(a)[0])
    one, other = (
        vf.solve(text, [kind(a, 2.0, 2 * x - 30), vf.StayClose()]) for kind in (Scaled, Curved)
    )
    assert np.allclose(one.theta, other.theta, atol=1e-6)


@pytest.mark.parametrize("shared", [True, False])
@pytest.mark.parametrize(
    ("font", "string"),
    [
        (lambda: "recursive", "AVATofo"),
        (lambda: "roboto-flex", "LTAvo"),
        # The advance of c is clamped at 0 in a part of the design space.
        (fonts.phantom_points, "cacc"),
    ],
)
def test_the_compiled_rows_of_many_letters_are_those_of_the_terms(
    font: Any, string: str, shared: bool
) -> None:
    class Curved(vf.Target):
        affine = False

    text = vf.Text(font(), string, shared=shared)
    handles = [text.handle(letter) for letter in (*range(len(string)), 2, 0)]
    one, other = (
        Energy(text, [kind(h, (30.0 * i, 7.0)) for i, h in enumerate(handles)])
        for kind in (vf.Target, Curved)
    )
    chance = np.random.default_rng(0)
    for _ in range(8):
        x = chance.uniform(one.lower, one.upper)
        np.testing.assert_allclose(one.residual(x), other.residual(x), atol=1e-8)
        np.testing.assert_allclose(one.jacobian(x), other.jacobian(x), atol=1e-8)


def test_a_goal_that_is_missed_is_never_called_met() -> None:
    text, a, _, _ = word()
    far = vf.Residual(lambda p: p[:, 0] - 9e4, handles=[a])
    found = vf.solve(text, far)
    assert found.status == "unreachable"
    assert found.misses[0] > 8e4
    assert "met" not in found.message
    detached = vf.Residual(lambda p: (p[:, 0] - 9e4).detach(), handles=[a])
    with pytest.raises(vf.SolveError, match="cannot be differentiated"):
        vf.solve(text, detached)


def test_a_preference_has_no_goal_to_miss() -> None:
    text, a, _, _ = word()
    lean = vf.Residual(lambda p: p[:, 0] - 9e4, handles=[a], weight=1e-12, tolerance=None)
    found = vf.solve(text, [vf.Pin(a), lean])
    assert found.status == "converged"
    assert found.misses == [pytest.approx(0, abs=0.5), 0.0]


# A term of one's own


class SameHeight(vf.Term):
    """The tops of two letters at one height, without a derivative of its own."""

    def __init__(self, first: vf.Handle, second: vf.Handle) -> None:
        self.handles = (first, second)

    def residual(self, points: torch.Tensor, theta: torch.Tensor) -> torch.Tensor:
        return points[:1, 1] - points[1:, 1]


class WholePixels(vf.Term):
    """A stem whose width is a whole number of pixels, at a given size."""

    def __init__(self, left: vf.Handle, right: vf.Handle, pixel: float) -> None:
        self.handles, self.pixel = (left, right), pixel

    def residual(self, points: torch.Tensor, theta: torch.Tensor) -> torch.Tensor:
        width = (points[1, 0] - points[0, 0]) / self.pixel
        return (width - width.detach().round()).reshape(1) * self.pixel


def test_strangers_terms_in_ten_lines() -> None:
    text = vf.Text("roboto-flex", "nb", shared=False)
    tops = text.nearest(600, 1080), text.nearest(1600, 1080)
    found = vf.solve(text, [SameHeight(*tops), vf.StayClose()])
    heights = [float(found.text.position(top)[1]) for top in tops]
    assert heights[0] == pytest.approx(heights[1], abs=0.5)
    stem = vf.Text("roboto-flex", "l")
    sides = stem.nearest(0, 700), stem.nearest(400, 700)
    fitted = vf.solve(stem, [WholePixels(*sides, pixel=64), vf.StayClose()]).text
    width = float(fitted.position(sides[1])[0] - fitted.position(sides[0])[0])
    assert width / 64 == pytest.approx(round(width / 64), abs=0.01)
    assert "l l" in WholePixels(*sides, pixel=64).label()


def test_what_a_term_lacks_is_said() -> None:
    class NoResidual(vf.Term):
        pass

    class NotATensor(SameHeight):
        def residual(self, points, theta):  # type: ignore[no-untyped-def]
            return 3.0

    class WrongShape(SameHeight):
        def residual(self, points, theta):  # type: ignore[no-untyped-def]
            return points[:1, 1] - points[1:, 1]

        def derivative(self, points, theta):  # type: ignore[no-untyped-def]
            return vf.Derivative(points=np.ones((1, 3, 2)))

    class Growing(SameHeight):
        def residual(self, points, theta):  # type: ignore[no-untyped-def]
            moved = bool(theta.detach().abs().sum() != start)
            return points[:, 1].repeat(1 + moved)

    text, a, b, _ = word()
    before = text.theta.clone()
    start = text.theta.abs().sum()
    for term, says in (
        (NoResidual(), "defines no residual"),
        (NotATensor(a, b), "must return a tensor, not float"),
        (WrongShape(a, b), r"by points must have the shape \(r, 2, 2\); received \(1, 3, 2\)"),
        (Growing(a, b), "had 2 values and now has 4"),
    ):
        with pytest.raises(vf.SolveError, match=says):
            vf.solve(text, [term, vf.StayClose()])
        assert torch.equal(text.theta, before)


# Terms that look again


class LeftOf(vf.Term):
    """No point of the outline lies to the right of a wall: the points beyond it are pushed back.

    Which points those are, and how many, is looked up again after every step.
    """

    moving = True

    def __init__(self, wall: float) -> None:
        self.wall, self.looks, self.weight = wall, 0, 100.0

    def beyond(self, text: vf.Text) -> list[vf.Handle]:
        ends = [
            text.handle(letter, contour, segment)
            for letter, glyph in enumerate(text.glyphs)
            for contour, segments in enumerate(glyph.contours)
            for segment in range(segments)
        ]
        places = text.point_set(ends).positions(text.place)
        return [end for end, (x, _) in zip(ends, places, strict=True) if x > self.wall]

    def points(self, text: vf.Text):  # type: ignore[no-untyped-def]
        self.looks += 1
        return text.point_set(self.beyond(text))

    def residual(self, points: torch.Tensor, theta: torch.Tensor) -> torch.Tensor:
        return points[:, 0] - self.wall


def test_a_term_that_looks_again_finds_the_points_of_the_moment() -> None:
    text = vf.Text("roboto-flex", "H")
    top = text.nearest(2000, 1400)
    x, y = text.position(top).tolist()
    wall = LeftOf(x + 40)
    pulled = [vf.Target(top, (x + 400, y)), wall, vf.StayClose()]
    assert not wall.beyond(text)
    found = vf.solve(text, pulled, restarts=0)
    assert wall.looks > 2
    assert found.status in ("unreachable", "stalled")
    # Pushed by 100 times the pull, it gives way by a hundredth of what the pull misses.
    assert float(found.text.position(top)[0]) < x + 40 + 8
    free = vf.solve(text, [pulled[0], pulled[2]], restarts=0)
    assert float(free.text.position(top)[0]) > x + 60


def test_only_a_moving_term_may_look_again() -> None:
    class Fixed(LeftOf):
        moving = False

    text = vf.Text("roboto-flex", "H")
    top = text.nearest(2000, 1400)
    x, y = text.position(top).tolist()
    wall = Fixed(x + 40)
    vf.solve(text, [vf.Target(top, (x + 400, y)), wall, vf.StayClose()], restarts=0)
    assert wall.looks == 1


# Blocks of unknowns


def test_letters_can_be_moved_by_a_solve() -> None:
    text = vf.Text("roboto-flex", "nb")
    dot, stem = text.nearest(600, 1080), text.nearest(1600, 1080)
    x, y = text.position(stem).tolist()
    found = vf.solve(text, [vf.Pin(dot), vf.Target(stem, (x + 300, y - 40))], free=["offsets"])
    assert found.status == "converged"
    assert torch.equal(found.theta, text.theta)
    assert found.place["offsets"][1] == pytest.approx([300, -40], abs=0.1)
    assert found.text.position(stem).tolist() == pytest.approx([x + 300, y - 40], abs=0.1)
    both = vf.solve(text, [vf.Pin(dot), vf.Target(stem, (x, y + 900))], free=["axes", "offsets"])
    assert both.misses[1] < 0.5


def test_offsets_move_points_and_nothing_else() -> None:
    text = vf.Text("recursive", "no")
    shifts = np.array([[0.0, 0.0], [30.0, -20.0]])
    moved = text.at(offsets=shifts)
    first = text.word.first_point[1]
    assert torch.equal(moved.points()[:first], text.points()[:first])
    assert np.allclose(moved.points()[first:] - text.points()[first:], [30, -20])
    assert np.allclose(moved.at(axes={"wght": 800}).place["offsets"], shifts)
    with pytest.raises(vf.TextError, match=r"offsets must be finite numbers of shape \(2, 2\)"):
        text.at(offsets=[[1, 2]])


def test_locked_axes_stay() -> None:
    text = vf.Text("roboto-flex", "H")
    top = text.nearest(1200, 1400)
    goal = text.at(axes={"wdth": 130, "slnt": -6}).position(top)
    free = vf.solve(text, [vf.Target(top, goal), vf.StayClose()])
    assert free.axes["slnt"] != text.axes["slnt"]
    held = vf.solve(text, [vf.Target(top, goal), vf.StayClose()], locks=["slnt", "GRAD"])
    assert held.axes["slnt"] == text.axes["slnt"]
    assert held.axes["GRAD"] == text.axes["GRAD"]
    assert held.axes["wdth"] != text.axes["wdth"]
    assert "slnt" not in held.message


def test_bad_calls_say_what_is_wrong() -> None:
    text, a, _, _ = word()
    term = vf.Target(a, (0, 0))
    for call, says in (
        (lambda: vf.solve(term, text), "needs a Text first"),  # type: ignore[arg-type]
        (lambda: vf.solve(text, term, free=["positions"]), "'axes', 'offsets'"),
        (lambda: vf.solve(text, term, free="axes"), "sequence of names"),
        (lambda: vf.solve(text, term, free=[]), "received \\[\\]"),
        (lambda: vf.solve(text, term, locks=["nope"]), "tags of axes"),
        (lambda: vf.solve(text, vf.Target(a, (0, 0), weight="heavy")), "weight must be a finite"),
        (lambda: vf.solve(text, vf.AxisTarget({"wght": 500}, letter=0.5)), "no letter 0.5"),
        (lambda: vf.solve(text, vf.StayClose(theta=float("nan"))), "theta must be finite"),
    ):
        with pytest.raises(vf.VFWidgetError, match=says):
            call()


# Little things


def test_named_instances_are_axis_values() -> None:
    font = vf.load_font("recursive")
    instance = font.instances[3]
    text = vf.Text(font, "no", axes=instance)
    assert text.axes == vf.Text(font, "no").at(instance.name).axes == text.at(instance).axes
    assert vf.Text(font, "no", axes=[instance, "Mono Linear Light"], shared=False)
    with pytest.raises(vf.AxisError, match=r"Boldest.*Mono Linear Bold") as error:
        text.at("Boldest")
    # The font has 64 instances.
    assert len(str(error.value)) < 400
    for wish in (instance, instance.name):
        found = vf.solve(vf.Text(font, "no"), vf.AxisTarget(wish))
        assert found.theta.numpy() == pytest.approx(text.theta.numpy(), abs=1e-4)
    with pytest.raises(vf.AxisError, match="is not an instance of Recursive"):
        text.at(vf.load_font("roboto-flex").instances[0])


def test_solutions_are_pickled_and_copied() -> None:
    text, a, _, _ = word()
    found = vf.solve(text, [vf.Target(a, text.position(a) + 30), vf.StayClose()])
    for twin in (pickle.loads(pickle.dumps(found)), copy.deepcopy(found), copy.copy(found)):
        assert twin.axes == found.axes
        assert twin.report() == found.report()
    same, handle = pickle.loads(pickle.dumps((text, a)))
    assert torch.equal(same.position(handle), text.position(a))


def test_a_solution_shows_itself_in_a_few_lines() -> None:
    text, a, _, _ = word()
    found = vf.solve(text, vf.Target(a, (9e4, 0)))
    assert 1 <= repr(found).count("\n") + 1 <= 3
    assert "unreachable" in repr(found)
    assert "0 of 1 goals met" in repr(found)
    assert found._repr_html_().startswith("<pre>")


def test_a_match_and_a_solution_show_the_axes_of_letters_in_the_same_form() -> None:
    text = vf.Text("dynapuff", "abc", axes={"wght": 600}, shared=False)
    found = vf.solve(text, vf.StayClose())
    match = vf.match(1 - vf.rasterize(text, (24, 48)), text, progress=False)
    one = "{wght: 600, wdth: 100}"
    assert repr(found).splitlines()[-1] == f" axes [{one}, {one}, …]>"
    own = match.axes[0]
    start = f" axes [{{wght: {own['wght']:.4g}, wdth: {own['wdth']:.4g}}}, {{"
    last = repr(match).splitlines()[-1]
    assert last.startswith(start) and last.endswith("}, …]>")
    word = vf.Text("dynapuff", "abc", axes={"wght": 600})
    assert repr(vf.solve(word, vf.StayClose())).endswith(f"\n axes {one}>")


def test_the_package_lists_its_public_names() -> None:
    names = dir(vf)
    assert {"Editor", "match", "Looks", "rasterize", "plot", "Derivative"} <= set(names)
    assert not {"importlib", "Any", "LAZY", "annotations"} & set(names)
    assert all(getattr(vf, name) is not None for name in names)
