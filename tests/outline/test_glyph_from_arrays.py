"""Glyphs made from arrays: by a stranger's reader, with gradients, and with wrong shapes."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest
import torch

import vfwidget as vf
from vfwidget.outline.varying import Varying

SUPPORT = np.array([[[0.0, 1, 1], [0, 0, 0]], [[0, 0.5, 1], [-1, -1, 0]]])


def read_masters(regular: str, bold: str) -> vf.Glyph:
    """A stranger's reader: two drawings in the path language of SVG, lines only, as one axis."""

    def control_points(path: str) -> np.ndarray:
        corners = np.array(path.replace("M", "").replace("Z", "").split("L"), dtype=str)
        corners = np.array([corner.split(",") for corner in corners], dtype=float)
        ends = np.roll(corners, -1, axis=0)
        thirds = [corners, (2 * corners + ends) / 3, (corners + 2 * ends) / 3]
        return np.stack(thirds, axis=1).reshape(-1, 2)

    default, heavy = control_points(regular), control_points(bold)
    deltas = (heavy - default)[..., None]
    return vf.Glyph(
        default,
        deltas,
        support=[[[0, 1, 1]]],
        contours=[len(default) // 3],
        advance=(default[:, 0].max() + 50, [deltas[:, 0].max()], [[[0, 1, 1]]]),
        name="bar",
    )


def test_a_reader_of_another_format_can_make_a_glyph():
    bar = read_masters("M0,0L100,0L100,700L0,700Z", "M0,0L220,0L220,700L0,700Z")
    assert bar.contours == (4,)
    assert bar.points([0.5])[::3].tolist() == [[0, 0], [160, 0], [160, 700], [0, 700]]
    assert bar.advance([0.5]).item() == 210
    assert [bearing.item() for bearing in bar.side_bearings([1.0])] == [0, 50]
    assert repr(bar) == "<Glyph 'bar': 12 control points, 1 delta set>"


def random_parts(grad: bool = False) -> dict:
    rng = np.random.default_rng(3)
    parts = {"default": rng.normal(size=(9, 2)), "deltas": rng.normal(size=(9, 2, 2))}
    advance = [600.0, rng.normal(size=2)]
    if grad:
        parts = {name: torch.tensor(part, requires_grad=True) for name, part in parts.items()}
        advance = [torch.tensor(part, dtype=torch.float64, requires_grad=True) for part in advance]
    return {**parts, "support": SUPPORT, "contours": [2, 1], "advance": (*advance, SUPPORT)}


def test_a_glyph_of_a_font_is_that_of_its_arrays():
    font = vf.load_font("recursive")
    read = font.glyph("g")
    width = read.affine
    made = vf.Glyph(
        read.default, read.deltas, read.support, read.contours,
        (width.advance_base, width.advance_deltas, width.advance_support),
    )  # fmt: skip
    w = font.normalize({"wght": 650, "CASL": 0.3, "slnt": -7})
    for method in "scalars", "points", "jacobian", "advance":
        assert torch.equal(getattr(made, method)(w), getattr(read, method)(w))


@pytest.mark.parametrize("kind", [np.asarray, torch.tensor, lambda part: part.tolist()])
def test_arrays_of_any_kind(kind):
    parts = random_parts()
    want = vf.Glyph(**parts).points([0.3, -0.2])
    parts |= {name: kind(parts[name]) for name in ("default", "deltas", "support")}
    assert torch.equal(vf.Glyph(**parts).points([0.3, -0.2]), want)


@pytest.mark.parametrize("kind", [np.asarray, torch.tensor])
def test_later_changes_of_the_arrays_do_not_change_the_glyph(kind):
    parts = random_parts()
    arrays = [kind(part) for part in (parts["default"], parts["deltas"], SUPPORT.copy())]
    advance = (600.0, kind(np.ones(2)), kind(SUPPORT.copy()))
    glyph = vf.Glyph(*arrays, parts["contours"], advance)
    w = [0.3, -0.2]
    points, width = glyph.points(w), glyph.advance(w)
    for array in (*arrays, *advance[1:]):
        array[:] = 7
    assert torch.equal(glyph.points(w), points) and torch.equal(glyph.advance(w), width)


@pytest.mark.filterwarnings("error")
def test_arrays_may_be_read_only():
    parts = random_parts()
    for name in ("default", "deltas"):
        parts[name].flags.writeable = False
    assert vf.Glyph(**parts).points([0.3, -0.2]).shape == (9, 2)


def test_an_advance_may_be_one_number():
    glyph = vf.Glyph(**random_parts() | {"advance": 512})
    assert glyph.advance([0.5, 0.5]).item() == 512


@pytest.mark.parametrize("method", ["points", "jacobian", "advance"])
def test_gradients_reach_the_arrays(method):
    w = torch.tensor([0.3, -0.2], dtype=torch.float64)
    parts = random_parts(grad=True)
    default, deltas, (base, rows, _) = parts["default"], parts["deltas"], parts["advance"]

    def value(default, deltas, base, rows):
        twin = parts | {"default": default, "deltas": deltas, "advance": (base, rows, SUPPORT)}
        return getattr(vf.Glyph(**twin), method)(w)

    assert torch.autograd.gradcheck(value, (default, deltas, base, rows))


def test_gradients_reach_the_arrays_through_segments_and_side_bearings():
    parts = random_parts(grad=True)
    glyph = vf.Glyph(**parts)
    left, right = glyph.side_bearings([0.3, -0.2])
    (sum(part.square().sum() for part in glyph.segments([0.3, -0.2])) + left + right).backward()
    assert parts["default"].grad.abs().min() > 0
    assert parts["deltas"].grad.abs().max() > 0
    assert parts["advance"][0].grad.item() == 1


@pytest.mark.parametrize(
    "part, value, message",
    [
        ("default", np.zeros((9, 3)), r"default must have the shape \(k, 2\).*received \(9, 3\)"),
        ("default", np.zeros(9), r"default must have the shape \(k, 2\)"),
        ("default", np.full((9, 2), np.nan), "must be finite"),
        ("default", "outline", "arrays of numbers"),
        ("default", [[1, 2], [3]], "arrays of numbers"),
        ("deltas", np.zeros((9, 2)), r"\(9, 2, m\); received \(9, 2\)"),
        ("deltas", np.zeros((8, 2, 2)), r"\(9, 2, m\); received \(8, 2, 2\)"),
        ("deltas", np.zeros((9, 2, 3)), r"support of 3 delta sets must have the shape \(3, n, 3\)"),
        ("support", np.zeros((2, 2)), r"support of 2 delta sets must have the shape \(2, n, 3\)"),
        ("support", np.zeros((2, 2, 2)), r"received \(2, 2, 2\)"),
        ("contours", [2], r"2\] segments have 3 control points for each segment, \(6, 2\) in all"),
        ("contours", [3.0], "number of segments"),
        ("contours", [], r"\(0, 2\) in all; received \(9, 2\)"),
        ("advance", "wide", "arrays of numbers"),
        (
            "advance",
            np.zeros(2),
            r"one number over the 2 axes of the outline; received the shape \(2,\)",
        ),
        ("advance", (1, [2]), "triple .*received 2 parts"),
        ("advance", (1, [2], [[[0, 1, 1]]]), "over 1 axes"),
        ("advance", (1, [2, 3], [[[0, 1, 1]] * 2]), r"the shape \(2, n, 3\)"),
    ],
)
def test_parts_that_do_not_fit(part, value, message):
    with pytest.raises(vf.GlyphError, match=message):
        vf.Glyph(**random_parts() | {part: value})


@pytest.mark.parametrize(
    "copied", [copy.copy, copy.deepcopy, lambda x: pickle.loads(pickle.dumps(x))]
)
def test_a_glyph_is_copied_whole(copied):
    glyph = vf.load_font("dynapuff").glyph("a")
    twin = copied(glyph)
    w = [0.25, -0.5]
    assert torch.equal(twin.points(w), glyph.points(w))
    assert (twin.name, twin.contours) == (glyph.name, glyph.contours)


class Circle(Varying):
    """A control point that runs round a circle: not affine in any scalars."""

    shape = (3, 2)
    breakpoints = (np.zeros(0),)

    def value(self, w):
        xp = torch if isinstance(w, torch.Tensor) else np
        x, y = xp.cos(w[..., 0]), xp.sin(w[..., 0])
        return xp.stack([xp.stack([x, y], -1)] * 3, -2)

    def value_and_jacobian(self, w):
        value = self.value(w)
        turned = (torch if isinstance(w, torch.Tensor) else np).stack(
            [-value[..., 1], value[..., 0]], -1
        )
        return value, turned[..., None]


def test_a_glyph_of_another_form():
    width = vf.Glyph(
        np.zeros((0, 2)), np.zeros((0, 2, 0)), np.zeros((0, 1, 3)), [], 7
    ).advance_width
    glyph = vf.Glyph.of(Circle(), width, [1], name="o")
    assert not glyph.is_affine
    autograd = torch.autograd.functional.jacobian(glyph.points, torch.tensor([0.5]).double())
    torch.testing.assert_close(glyph.jacobian([0.5]), autograd)
    assert glyph.advance([0.5]).item() == 7
    for question in ("default", "deltas", "support", "affine"):
        with pytest.raises(vf.GlyphError, match=r"'o' is not affine in scalars.*points"):
            getattr(glyph, question)
    with pytest.raises(vf.GlyphError, match="not affine"):
        glyph.scalars([0.5])


def drawing(scale: float = 1.0) -> vf.Glyph:
    """The n of Roboto Flex from arrays, wider by a factor."""
    font = vf.load_font("roboto-flex")
    numbers = font.glyph("n").affine
    factor = np.array([scale, 1.0])
    return vf.Glyph(
        numbers.base * factor,
        numbers.deltas * factor[:, None],
        numbers.support,
        font.glyph("n").contours,
        (scale * numbers.advance_base, scale * numbers.advance_deltas, numbers.advance_support),
    )


@pytest.mark.parametrize("shared", [True, False])
def test_a_glyph_from_arrays_is_set_and_dragged_as_one_of_the_file(shared):
    file = vf.load_font("roboto-flex")
    font = file.with_glyphs({"n": drawing()})
    place = {"wght": 640, "wdth": 120}
    given, made = (vf.Text(one, "ann", place, shared) for one in (file, font))
    assert torch.allclose(given.points(), made.points())
    assert [one.name for one in made.glyphs] == [one.name for one in given.glyphs]
    handle, other = given.handle(1, 0, 2, 0.5), made.handle(1, 0, 2, 0.5)
    goal = given.position(handle) + 12
    found = [vf.solve(t, vf.Target(h, goal)) for t, h in ((given, handle), (made, other))]
    assert torch.allclose(found[0].theta, found[1].theta, atol=1e-9)


def test_letters_after_a_wider_drawing_stand_farther_to_the_right():
    file = vf.load_font("roboto-flex")
    before = vf.Text(file, "na").layout
    text = vf.Text(file.with_glyphs({"n": drawing(1.5)}), "na")
    added = 0.5 * file.glyph("n").advance(np.zeros(len(file.axes))).item()
    assert text.layout[1].x == pytest.approx(before[1].x + added)
    # The file's own glyphs stay as they were, and copies keep the drawing.
    assert vf.Text(file, "na").layout[1].x == before[1].x
    again = pickle.loads(pickle.dumps(text))
    assert again.layout[1].x == text.layout[1].x


def test_what_cannot_be_set_or_written_is_one_error(tmp_path):
    file = vf.load_font("roboto-flex")
    square = read_masters("M0,0L100,0L100,700L0,700Z", "M0,0L220,0L220,700L0,700Z")
    for glyphs, says in (
        ({"n": square}, "must be a Glyph over 13 axes"),
        ({"n": "n"}, "received 'n'"),
        ({"\u4e00": square}, "no glyph"),
    ):
        with pytest.raises(vf.GlyphError, match=says):
            file.with_glyphs(glyphs)
    font = file.with_glyphs({"n": drawing(1.5)})
    for write in (lambda: font.save(tmp_path / "font.ttf"), lambda: font.instance({"wght": 500})):
        with pytest.raises(vf.FontError, match="drawings of uni006E"):
            write()


@pytest.mark.parametrize("glyphs", [None, 7, "ab", [1, 2]])
def test_drawings_of_a_font_are_a_mapping(glyphs) -> None:
    with pytest.raises(vf.GlyphError, match="must be a mapping"):
        vf.load_font("recursive").with_glyphs(glyphs)
