"""A solve answers bad input by one clear error, and never by a wrong result."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import torch

import vfwidget as vf
from vfwidget.text.place import Block

Function = Callable[[Any], Any]
BY_X = vf.Derivative(points=np.array([[[1.0, 0.0]]]))


@pytest.fixture
def text() -> vf.Text:
    return vf.Text("recursive", "hand", axes={"wght": 600})


@pytest.fixture
def handle(text: vf.Text) -> vf.Handle:
    return text.nearest(100, 700)


def make(handle: Any, residual: Function, derivative: Any = None, **attributes: Any) -> vf.Term:
    """A term over one handle, with a derivative if one is given."""
    own = {"residual": lambda self, points, theta: residual(points), **attributes}
    if derivative is not None:
        own["derivative"] = lambda self, points, theta: derivative
    term = type("Mine", (vf.Term,), own)()
    term.handles = handle if not isinstance(handle, vf.Handle) else (handle,)
    return term


def x_at(goal: float) -> Function:
    return lambda points: points[:, 0] - goal


@pytest.mark.parametrize("affine", [False, True])
@pytest.mark.parametrize(
    ("derivative", "says"),
    [
        ((BY_X.points, None), "must return a vf.Derivative; received tuple"),
        (vf.Derivative(), "has 0 rows, and its residual has 1 values"),
        (vf.Derivative(points=np.ones((2, 1, 2))), "has 2 rows, and its residual has 1 values"),
        (vf.Derivative(points=np.zeros((0, 1, 2))), "has 0 rows, and its residual has 1"),
        (vf.Derivative(BY_X.points, np.zeros((2, 1, 5))), "1 rows by points and 2 by theta"),
        (vf.Derivative(points="a"), r"the shape \(r, 1, 2\); received str"),
    ],
)
def test_a_wrong_derivative_is_an_error(
    text: vf.Text, handle: vf.Handle, derivative: Any, says: str, affine: bool
) -> None:
    term = make(handle, x_at(0), derivative, affine=affine)
    with pytest.raises(vf.SolveError, match=says):
        vf.solve(text, term)
    with pytest.raises(vf.SolveError, match=says):
        vf.check_derivative(term, text)


@pytest.mark.parametrize("kind", [list, torch.tensor])
def test_a_derivative_may_be_a_list_or_a_tensor(
    text: vf.Text, handle: vf.Handle, kind: Callable[[Any], Any]
) -> None:
    goal = float(text.position(handle)[0]) + 20
    derivative = vf.Derivative(points=kind([[[1.0, 0.0]]]))
    for affine in (False, True):
        term = make(handle, x_at(goal), derivative, affine=affine)
        assert vf.solve(text, term).status == "converged"


def test_the_check_finds_a_term_that_is_affine_in_name_only(
    text: vf.Text, handle: vf.Handle
) -> None:
    class Square(vf.Term):
        affine = True
        handles = (handle,)

        def residual(self, points: np.ndarray, theta: np.ndarray) -> np.ndarray:
            return points[:, 0] ** 2

        def derivative(self, points: np.ndarray, theta: np.ndarray) -> vf.Derivative:
            return vf.Derivative(points=np.array([[[2 * points[0, 0], 0.0]]]))

    assert vf.check_derivative(Square(), text) > 0.1
    Square.affine = False
    assert vf.check_derivative(Square(), text) < 1e-4


def test_a_residual_that_writes_to_its_arguments_does_not_move_the_text(
    text: vf.Text, handle: vf.Handle
) -> None:
    class Careless(vf.Term):
        handles = (handle,)

        def residual(self, points: np.ndarray, theta: np.ndarray) -> np.ndarray:
            theta += 1
            return points[:, 0]

        def derivative(self, points: np.ndarray, theta: np.ndarray) -> vf.Derivative:
            theta -= 1
            return BY_X

    before = text.theta.clone()
    vf.solve(text, Careless(), restarts=0)
    vf.solve(text, Careless(), free=["offsets"], restarts=0)
    assert torch.equal(text.theta, before)


def test_a_term_without_a_value_elsewhere_does_not_spoil_the_first_result(
    text: vf.Text, handle: vf.Handle
) -> None:
    x = float(text.position(handle)[0])

    def residual(points: np.ndarray) -> np.ndarray:
        return np.where(points[:, 0] > x + 5, np.nan, points[:, 0] - x - 20)

    found = vf.solve(text, make(handle, residual, BY_X))
    assert found.status != "converged"
    assert found.misses[0] == pytest.approx(15, abs=0.1)


@pytest.mark.parametrize("weight", [1e-7, 1e-12, 1e-100])
def test_a_small_weight_alone_changes_nothing(
    text: vf.Text, handle: vf.Handle, weight: float
) -> None:
    goal = text.position(handle) + torch.tensor([20.0, 0.0])
    assert vf.solve(text, vf.Target(handle, goal, weight=weight)).misses[0] < 0.5


@pytest.mark.parametrize("weight", [1e-300, 1e300])
def test_a_weight_beyond_the_range_of_squares_is_refused(
    text: vf.Text, handle: vf.Handle, weight: float
) -> None:
    with pytest.raises(vf.SolveError, match="weight must be between"):
        vf.solve(text, vf.Target(handle, (0, 0), weight=weight))


@pytest.mark.parametrize("weight", [np.float32(2), np.int64(2)])
def test_numbers_of_numpy_are_weights(text: vf.Text, handle: vf.Handle, weight: Any) -> None:
    assert vf.solve(text, vf.Pin(handle, weight=weight)).status == "converged"


def test_a_term_without_residuals_is_met(text: vf.Text, handle: vf.Handle) -> None:
    empty = vf.Derivative(points=np.zeros((0, 1, 2)))
    for term in (
        make(handle, lambda points: points[:0, 0]),
        make(handle, lambda points: points[:0, 0], empty),
        make(handle, lambda points: points[:0, 0], empty, affine=True),
    ):
        assert vf.solve(text, term).cost == 0
    blank = vf.Text("recursive", "  ")
    assert vf.solve(blank, vf.Residual(lambda points: points[:, 0])).cost == 0


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"restarts": 1.5}, "restarts must be a whole number ≥ 0; received 1.5"),
        ({"restarts": None}, "restarts must be"),
        ({"restarts": -1}, "restarts must be"),
        ({"restart_seconds": math.nan}, "restart_seconds must be"),
        ({"restart_seconds": -1}, "restart_seconds must be"),
        ({"restart_seconds": "3"}, "received '3'"),
        ({"locks": 3}, "locks must be tags"),
    ],
)
def test_bad_options_are_refused(
    text: vf.Text, handle: vf.Handle, options: dict[str, Any], says: str
) -> None:
    with pytest.raises(vf.VFWidgetError, match=says):
        vf.solve(text, vf.Pin(handle), **options)


def test_bad_terms_are_refused(text: vf.Text, handle: vf.Handle) -> None:
    for term, says in (
        (make(3, x_at(0)), "handles of Mine must be a sequence of handles; received 3"),
        (make(handle, x_at(0), tolerance="a"), "tolerance must be None or a number from 0 to"),
        (make(handle, x_at(0), tolerance=1e300), "received 1e\\+300"),
        (make(handle, x_at(0), tolerance=math.nan), "received nan"),
        (make(handle, x_at(0), tolerance=math.inf), "received inf"),
        (make(handle, x_at(0), bind=lambda self, text: None), "must return a term, such as self"),
        (make(handle, lambda points: points.to(torch.complex128)), "must be real numbers"),
        (vf.SharedX(handle), "must be a sequence of handles"),  # type: ignore[arg-type]
        (vf.SharedX(None), "at least 2 handles"),  # type: ignore[arg-type]
        (vf.Residual(lambda points: points, handle), "must be a sequence"),  # type: ignore[arg-type]
        (vf.Target(handle, "ab"), "position must be two finite numbers"),
        (vf.Distance(handle, handle, "x"), "length must be a finite number"),  # type: ignore[arg-type]
        (vf.Target(handle, (1e300, 0)), "position .* none of them beyond 1e\\+12"),
        (vf.Pin(handle, (0, -1e200)), "position .* none of them beyond 1e\\+12"),
        (vf.Distance(handle, handle, 1e300), "length .* from 0 to 1e\\+12"),
        (vf.Width(1e300), "width .* at most 1e\\+12"),
        (vf.Area(1e300), "area .* at most 1e\\+24"),
    ):
        with pytest.raises(vf.SolveError, match=says):
            vf.solve(text, term)
    for bad in (None, "hand"):
        with pytest.raises(vf.SolveError, match="needs a Text"):
            vf.check_derivative(vf.Pin(handle), bad)  # type: ignore[arg-type]
    with pytest.raises(vf.GlyphError, match="3 is not a handle of this text"):
        text.position(3)  # type: ignore[arg-type]


def test_a_report_names_moved_letters_and_the_better_result() -> None:
    text = vf.Text("recursive", "no")
    o = text.handle(1)
    goal = text.position(o) + torch.tensor([30.0, -20.0])
    report = vf.solve(text, vf.Target(o, goal), free=["offsets"]).report()
    assert report.splitlines()[-1].split() == ["o", "30.0", "-20.0"]
    wavy = vf.Text("afacad-flux", "wavy")
    handles = [wavy.handle(1, 0, segment, 0.2) for segment in range(6)]
    found = [
        vf.solve(wavy, [vf.Target(h, wavy.position(h) + torch.tensor([100, 60])), vf.StayClose()])
        for h in handles
    ]
    assert any(solution.elsewhere for solution in found)
    for solution in found:
        told = "see solution.elsewhere" in solution.report()
        assert told == (solution.elsewhere is not None)


def test_solutions_are_equal_only_to_themselves(text: vf.Text, handle: vf.Handle) -> None:
    one, other = (vf.solve(text, vf.Pin(handle)) for _ in range(2))
    assert one != other
    assert len({one, other}) == 2


def test_a_place_to_stay_close_to_has_a_value_for_each_axis(text: vf.Text) -> None:
    vf.solve(text, vf.StayClose(theta=np.zeros(5)))
    for theta in (0.5, [0.5], np.zeros((2, 5))):
        with pytest.raises(vf.SolveError, match=r"finite numbers of shape \(1, 5\)"):
            vf.solve(text, vf.StayClose(theta=theta))


@pytest.mark.parametrize(
    ("method", "result", "says"),
    [
        ("bind", None, r"bind\(\) of Mine must return a term"),
        ("blocks", ["more"], r"blocks\(\) of Mine must return a mapping"),
        ("blocks", {"more": np.zeros(2)}, r"blocks\(\) of Mine must give each name a Block"),
        ("blocks", {"more": Block(np.zeros(2, int))}, "finite float64 numbers"),
        ("blocks", {"more": Block(np.array([np.nan]))}, "finite float64 numbers"),
        ("blocks", {"more": Block(np.zeros(2), lower=np.ones(2))}, "bounds around them"),
        ("blocks", {"more": Block(np.zeros(2), upper=np.zeros(3))}, "of the same shape"),
        (
            "blocks",
            {"more": Block(np.zeros(2), kinks=np.zeros(2))},
            r"kinks of the shape \(size, q",
        ),
        ("locate", 3, r"locate\(\) of Mine must return None or an object with the methods"),
        ("miss", "much", r"miss\(\) of Mine must return a number or None; received 'much'"),
        ("miss", math.nan, "received nan"),
        ("proximity", 3, r"proximity\(\) of Mine must give"),
        ("proximity", {"axes": 1.0}, r"proximity\(\) of Mine must give"),
        ("proximity", {"nowhere": (np.ones((1, 5)),) * 2}, r"proximity\(\) of Mine must give"),
        ("proximity", {"axes": (np.ones(5), np.ones(5))}, "of the block's shape"),
        ("proximity", {"axes": (-np.ones((1, 5)), np.ones((1, 5)))}, "weights ≥ 0"),
        ("proximity", {"axes": (np.ones((1, 5)), np.full((1, 5), np.nan))}, "finite"),
    ],
)
def test_what_a_term_of_ones_own_returns_is_checked(
    text: vf.Text, handle: vf.Handle, method: str, result: Any, says: str
) -> None:
    term = make(handle, x_at(0), BY_X, **{method: lambda self, given: result})
    with pytest.raises(vf.SolveError, match=says):
        vf.solve(text, term)


def first_point(points: Any) -> Any:
    return points[0] - 1.0


@pytest.mark.parametrize("handles", [(), "one"])
@pytest.mark.parametrize("method", ["residual", "derivative", "locate"])
def test_a_term_that_reads_points_it_does_not_have_is_told_to_set_handles(
    text: vf.Text, handle: vf.Handle, method: str, handles: Any
) -> None:
    count = 1 if handles else 0
    methods = {
        "residual": lambda self, points, theta: first_point(points[count:]),
        "derivative": lambda self, points, theta: vf.Derivative(points=points[count:][0]),
        "locate": lambda self, text: first_point(np.ones((count, 2))[count:]),
    }
    own = {"residual": lambda self, points, theta: points.sum(0), method: methods[method]}
    term = type("Mine", (vf.Term,), own)()
    term.handles = (handle,) * count
    says = rf"^{method}\(\) of Mine has read beyond .* {count} points .* Set its handles"
    if method == "derivative":
        term.residual = lambda points, theta: np.ones(2)
    with pytest.raises(vf.SolveError, match=says):
        vf.solve(text, term)


def test_a_solve_whose_steps_would_take_too_long_is_refused(
    text: vf.Text, handle: vf.Handle, monkeypatch: pytest.MonkeyPatch
) -> None:
    target = vf.Target(handle, (100, 700))
    # A target has two residuals, and the text five axes.
    monkeypatch.setattr(vf.limits, "step_products", 20)
    assert vf.solve(text, [target, vf.StayClose()]).converged
    monkeypatch.setattr(vf.limits, "step_products", 19)
    for terms in ([target], [target] * 3):
        with pytest.raises(vf.SolveError, match=r"too large.*the limit is 19.*step_products"):
            vf.solve(text, terms)


@pytest.mark.parametrize("method", ["residual", "derivative"])
@pytest.mark.parametrize(
    ("wrong", "cause"),
    [
        (lambda self, points: points[:, 0], "positional argument"),
        (lambda self, points, theta: points[:, 0] + None, "unsupported operand"),
    ],
)
def test_a_type_error_of_a_term_names_it_and_its_arguments(
    text: vf.Text, handle: vf.Handle, method: str, wrong: Any, cause: str
) -> None:
    term = make(handle, x_at(0), BY_X)
    setattr(type(term), method, wrong)
    says = rf"{method}\(\) of Mine .*{cause}.* two arrays: points of the shape \(1, 2\) and theta"
    with pytest.raises(vf.SolveError, match=says) as caught:
        vf.solve(text, term)
    assert isinstance(caught.value.__cause__, TypeError)


def test_a_type_error_of_a_function_says_what_it_receives(text: vf.Text) -> None:
    with pytest.raises(
        vf.SolveError, match=r"function of a Residual .*one tensor: points"
    ) as caught:
        vf.solve(text, vf.Residual(lambda points, theta: points[:, 0]))  # type: ignore[arg-type]
    assert isinstance(caught.value.__cause__, TypeError)
    automatic = make((), lambda points: points + None)
    with pytest.raises(vf.SolveError, match=r"of Mine has raised a TypeError .*two tensors"):
        vf.solve(text, automatic)


def test_the_check_of_a_derivative_that_is_not_finite_is_an_error(
    text: vf.Text, handle: vf.Handle
) -> None:
    broken = vf.Derivative(points=np.full((1, 1, 2), np.nan))
    for term in (
        make(handle, x_at(0), broken),
        make(handle, lambda points: torch.sqrt(-(points[:, 0] ** 2) - 1)),
    ):
        with pytest.raises(vf.SolveError, match="NaN or infinity"):
            vf.check_derivative(term, text)


def test_complex_numbers_are_refused(text: vf.Text, handle: vf.Handle) -> None:
    imaginary = np.ones(5) * 1j
    for call in (
        lambda: vf.solve(text, vf.Target(handle, imaginary[:2])),
        lambda: vf.solve(text, vf.Target(handle, torch.tensor(imaginary[:2]))),
        lambda: vf.solve(text, vf.StayClose(theta=imaginary)),
        lambda: text.at(theta=torch.tensor(imaginary)),
        lambda: text.at(offsets=np.ones((4, 2)) * 1j),
        lambda: text.font.glyph("n").points(imaginary),
        lambda: vf.rasterize([np.ones((3, 4, 2)) * 1j], (10, 10)),
    ):
        with pytest.raises(vf.VFWidgetError):
            call()


def nested(*names: str) -> list[Any]:
    """Names in arrays that are no list of names, and names that can be read once only."""
    pair = np.array(names)
    return [np.array(names[0]), pair[None], [pair], (pair,), (pair[:1],), iter(names)]


@pytest.mark.parametrize(
    "free",
    [
        *["axes", (), ["axes", 3], ["axes", "size"], [["axes"]], 5, None],
        *nested("axes", "offsets"),
    ],
)
def test_free_is_a_sequence_of_blocks(text: vf.Text, handle: vf.Handle, free: Any) -> None:
    # The text keeps the energy of a solve.
    vf.solve(text, vf.Target(handle, (0, 0)), restarts=0)
    with pytest.raises(vf.SolveError, match="free must be a sequence of names of blocks"):
        vf.solve(text, vf.Target(handle, (0, 0)), free=free)


@pytest.mark.parametrize("locks", [["wght", ["wght"]], "", *nested("wght", "slnt")])
def test_locks_are_tags(text: vf.Text, handle: vf.Handle, locks: Any) -> None:
    vf.solve(text, vf.Target(handle, (0, 0)), restarts=0)
    with pytest.raises(vf.AxisError, match="locks must be tags of axes"):
        vf.solve(text, vf.Target(handle, (0, 0)), locks=locks)


def test_a_residual_in_numpy_is_named():
    class Wave(vf.Term):
        def __init__(self, handle):
            self.handles = (handle,)

        def residual(self, points, theta):
            return points[:, 1] - np.sin(points.numpy()[0, 0])

    text = vf.Text("roboto-flex", "n")
    with pytest.raises(vf.SolveError, match="Wave uses numpy"):
        vf.solve(text, Wave(text.nearest(0, 900)))


def test_what_is_no_term_is_shown():
    text = vf.Text("roboto-flex", "n")
    with pytest.raises(vf.SolveError, match="received 3"):
        vf.solve(text, [vf.StayClose(), 3])
