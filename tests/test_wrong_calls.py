"""Wrong calls of public functions: each gets one clear error of the package, none is silent."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
import torch

import vfwidget as vf

NAN, HUGE = math.nan, 10**400
NUMBERS = ("x", None, NAN, math.inf, 1j, [1, 2], HUGE)
"""None of these is a finite number."""
COUNTS = ("x", 1.5, NAN, -1, [1], 1j)
"""None of these is a whole number ≥ 0."""
POINTS = ((1,), (1, 2, 3), (NAN, 0), ("a", "b"), 3, None, (1j, 0))
SQUARE = [(0.0, 0.0), (100.0, 0.0), (100.0, 100.0), (0.0, 100.0)]
CONTOUR = torch.zeros((3, 4, 2), dtype=torch.float64)
PICTURE = np.ones((20, 20))
PICTURE[5:15, 8:12] = 0.0

text = vf.Text("recursive", "ha")
font = text.font
point = text.nearest(100, 700)
other = text.nearest(300, 0)
stranger = vf.Text("recursive", "x").nearest(0, 0)
target = vf.Target(point, (100, 700))
Call = tuple[str, Callable[[], Any]]


def solving(*terms: Any, **options: Any) -> Any:
    return vf.solve(text, list(terms), **options)


def of_terms() -> Iterator[Call]:
    for value in ("x", None, NAN, math.inf, -1, 0, 1j, True, HUGE):
        for kind in (vf.Target(point, (1, 2)), vf.Pin(point), vf.StayClose(), vf.Width(300)):
            name = f"{type(kind).__name__} of weight {value!r:.20}"
            yield name, lambda k=kind, v=value: solving(_with(k, weight=v))
    for value in POINTS[:-2] + POINTS[-1:]:
        yield f"Target at {value}", lambda v=value: solving(vf.Target(point, v))
        yield f"Pin at {value}", lambda v=value: solving(vf.Pin(point, v))
    yield "Target at 3", lambda: solving(vf.Target(point, 3))
    for value in ("x", None, NAN, math.inf, 1j, [1, 2]):
        yield f"Width {value!r}", lambda v=value: solving(vf.Width(v))
    for value in ("x", NAN, math.inf, 1j, [1, 2]):
        yield f"Area {value!r}", lambda v=value: solving(vf.Area(v))
        yield f"Distance {value!r}", lambda v=value: solving(vf.Distance(point, other, v))
    yield "Distance −1", lambda: solving(vf.Distance(point, other, -1))
    for term in (vf.Target(stranger, (0, 0)), vf.Pin(stranger), vf.SharedX([point, stranger])):
        yield f"{type(term).__name__} of another text", lambda t=term: solving(t)
    for handles in ([], [point], 3, "ab", [1, 2]):
        yield f"SharedX of {handles}", lambda h=handles: solving(vf.SharedX(h))
        yield f"Collinear of {handles}", lambda h=handles: solving(vf.Collinear(h))
    yield "AxisTarget of half a letter", lambda: solving(vf.AxisTarget({"wght": 500}, letter=0.5))
    yield "AxisTarget of a missing axis", lambda: solving(vf.AxisTarget({"none": 500}))
    yield "AxisTarget of a word", lambda: solving(vf.AxisTarget({"wght": "bold"}))
    yield "StayClose to a number", lambda: solving(vf.StayClose(theta=0.5))
    yield "StayClose to NaN", lambda: solving(vf.StayClose(theta=[[NAN] * 5]))
    yield "a Residual that is detached", lambda: solving(vf.Residual(_detached))
    yield "a Residual of complex numbers", lambda: solving(vf.Residual(lambda p: p[:, 0] * 1j))
    yield "a Residual of a number", lambda: solving(vf.Residual(lambda p: 3))
    for value in ("x", NAN, -1, 1e300j, None):
        yield f"NoOverlap with gap {value!r}", lambda v=value: solving(vf.NoOverlap(gap=v))
    yield "NoOverlap by a guess", lambda: solving(vf.NoOverlap(method="guess"))
    yield "Looks like nothing", lambda: solving(vf.Looks(None))
    for value in (3, "x", []):
        yield f"Looks with view {value!r}", lambda v=value: solving(vf.Looks(PICTURE, view=v))


def _with(term: Any, **changes: Any) -> Any:
    from dataclasses import replace

    return replace(term, **changes)


def _detached(points: Any) -> Any:
    return (points.detach()[:3] - 1000).flatten()


def of_solve() -> Iterator[Call]:
    for value in (-5, 2.5, NAN, "3", None):
        yield f"{value!r} iterations", lambda v=value: solving(target, max_iterations=v)
    for value in (NAN, "a", None, -1.0, math.inf):
        yield f"a step of {value!r}", lambda v=value: solving(target, step_tolerance=v)
    for value in COUNTS:
        yield f"{value!r} restarts", lambda v=value: solving(target, restarts=v)
        yield (
            f"{value!r} restarts of overlaps",
            lambda v=value: vf.resolve_overlaps(text.at(tracking=-300), restarts=v),
        )
    for value in (-1, NAN, "x", 1j):
        yield f"{value!r} seconds", lambda v=value: solving(target, restart_seconds=v)
    for value in (["bad"], "axes", [], None, 3, [["axes"]]):
        yield f"free {value!r}", lambda v=value: solving(target, free=v)
    for value in (["bad"], "wght", 3, [3], [["wght"]]):
        yield f"locks {value!r}", lambda v=value: solving(target, locks=v)
    for value in (3, "ab", "01", [[0, 7]], [[-1]], [[0, 0]], [["a"]], [[0, 0.5]], [[0, math.inf]]):
        yield f"ties {value!r}", lambda v=value: solving(target, ties=v)
    for terms in ([], None, 3, "ab", [3], [target, None], text):
        yield f"terms {terms!r:.30}", lambda t=terms: vf.solve(text, t)
    yield "swapped arguments", lambda: vf.solve(target, text)  # type: ignore[arg-type]
    yield "swapped arguments in a list", lambda: vf.solve([target], text)  # type: ignore[arg-type]
    for value in (None, "a", [NAN], [1j], [math.inf]):
        yield f"least squares from {value!r}", lambda v=value: vf.least_squares(lambda x: x, v)
    yield "least squares of nothing", lambda: vf.least_squares(None, [0.0])  # type: ignore
    yield "an unknown loss", lambda: vf.least_squares(lambda x: x, [1.0], loss="foo")
    yield "−1 iterations", lambda: vf.least_squares(lambda x: x, [1.0], max_iterations=-1)
    yield "complex residuals", lambda: vf.least_squares(lambda x: x * 1j, [1.0])


def of_texts() -> Iterator[Call]:
    for value in (None, 3, ["a"], b"a"):
        yield f"a text of {value!r}", lambda v=value: vf.Text("recursive", v)
    for value in (None, 3, [], "no such font", "x" * 10_000_000, b"", b"junk"):
        yield f"a font of {value!r:.20}", lambda v=value: vf.load_font(v)
        yield f"a text in {value!r:.20}", lambda v=value: vf.Text(v, "a")
    for value in ("no", None, 1, 0.5, []):
        yield f"shared={value!r}", lambda v=value: vf.Text("recursive", "ha", shared=v)
    for value in ("x", NAN, None, 1j, math.inf, 10**400):
        yield f"tracking {value!r:.9}", lambda v=value: vf.Text("recursive", "a", tracking=v)
        yield (
            f"line_height {value!r:.9}",
            lambda v=value or 1j: vf.Text("recursive", "a", line_height=v),
        )
    for key in ("features", "language", "script", "direction"):
        for value in (3, "no such thing", {"toolong": 1}, [1]):
            yield f"{key}={value!r}", lambda k=key, v=value: vf.Text("recursive", "a", **{k: v})
    for value in ({"none": 1}, {"wght": "x"}, {"wght": NAN}, {"wght": 1j}, "No Such", 3, [{}] * 3):
        yield f"axes {value!r}", lambda v=value: vf.Text("recursive", "a", axes=v)
        yield f"at {value!r}", lambda v=value: text.at(v)
    yield "an axis of ten million letters", lambda: text.at({"x" * 10_000_000: 1})
    for value in (np.zeros((1, 5), complex), [[NAN] * 5], [[0.0]], "x"):
        yield f"theta {value!r:.30}", lambda v=value: text.at(theta=v)
    yield "axes and theta", lambda: text.at({"wght": 500}, theta=[[0.0] * 5])
    for value in (3, "x", [[NAN, 0]] * 2, [[0.0, 0.0]], [[1j, 0]] * 2):
        yield f"offsets {value!r}", lambda v=value: text.at(offsets=v)
    for x, y in (("a", 1), (1j, 1), (NAN, 0), (None, None), (math.inf, 0)):
        yield f"nearest to {x, y}", lambda x=x, y=y: text.nearest(x, y)
    for options in ({"glyph": 0.5}, {"glyph": 9}, {"glyph": -1}, {"t": "x"}, {"t": 2.0}):
        yield f"a handle at {options}", lambda o=options: text.handle(**o)
    for options in ({"contour": 9}, {"segment": 999}, {"t": NAN}, {"segment": None}):
        yield f"a handle at {options}", lambda o=options: text.handle(**o)
    yield "the position of a word", lambda: text.position("x")  # type: ignore[arg-type]
    yield "the position of a stranger", lambda: text.position(stranger)


def of_fonts() -> Iterator[Call]:
    for value in ("x", {"wght": "a"}, {"wght": 1j}, {"none": 1}, 3, {"wght": NAN}):
        yield f"normalize {value!r}", lambda v=value: font.normalize(v)
        yield f"metrics at {value!r}", lambda v=value: font.metrics(v)
        yield f"instance at {value!r}", lambda v=value: font.instance(v)
    for value in ("x", [0] * 3, [NAN] * 5, 1j):
        yield f"denormalize {value!r}", lambda v=value: font.denormalize(v)
    for value in (0.5, -1, 10**9, None, "no such glyph"):
        yield f"glyph {value!r}", lambda v=value: font.glyph(v)
    for value in ("ab", 3.5, None):
        yield f"axis_effect {value!r}", lambda v=value: font.axis_effect(v)


def of_pictures() -> Iterator[Call]:
    for value in (None, "no such file.png", 3, np.zeros((20, 20), complex), np.zeros((0, 0))):
        yield f"match {value!r:.30}", lambda v=value: vf.match(v, "a", "recursive")
    for value in (torch.zeros((20, 20), device="meta"), torch.zeros((20, 20)).to_sparse()):
        yield f"match {value.layout} {value.device}", lambda v=value: vf.match(v, "a", "recursive")
    yield "match a nested tensor", lambda: vf.match(_nested(), "a", "recursive")
    yield "match, swapped", lambda: vf.match("a", PICTURE, "recursive")  # type: ignore[arg-type]
    yield "match without letters", lambda: vf.match(PICTURE, "", "recursive")
    yield "match without fonts", lambda: vf.match(PICTURE, "a", [])
    for size in (None, 3.5, (0, 8), (8, -8), ("a", 8), (10**9, 10**9), (8, 8, 8), (NAN, 8)):
        yield f"an image of {size}", lambda s=size: vf.rasterize([CONTOUR], size=s)
    for dtype in (torch.complex128, torch.complex64):
        yield f"raster of {dtype}", lambda d=dtype: vf.rasterize([CONTOUR.to(d)], size=(8, 8))
    for value in (CONTOUR.to("meta"), CONTOUR.to_sparse(), CONTOUR[0], CONTOUR + NAN, None, 3):
        yield f"raster of {value!r:.30}", lambda v=value: vf.rasterize([v], size=(8, 8))
    for far in (1e11, 1e15, 1e300):
        corners = torch.tensor(SQUARE) * far
        yield f"raster of {far}", lambda c=corners: vf.rasterize([_closed(c)], size=(8, 8))


def _nested() -> torch.Tensor:
    with warnings.catch_warnings():
        # torch calls them a prototype.
        warnings.simplefilter("ignore", UserWarning)
        return torch.nested.nested_tensor([torch.ones(9), torch.ones(8)])


def _closed(corners: torch.Tensor) -> torch.Tensor:
    ends = corners.roll(-1, 0)
    return torch.stack([corners, corners, ends, ends], 1)


def of_overlaps() -> Iterator[Call]:
    for value in (["x"], 3, [[(NAN, 0), (1, 0), (1, 1)]], [[(1j, 0), (1, 0), (1, 1)]], [[(0, 0)]]):
        yield f"obstacles {value!r}", lambda v=value: vf.overlaps(text, v)
        yield f"obstacles {value!r} in the way", lambda v=value: vf.resolve_overlaps(text, v)
    for value in ("x", None, 3):
        yield f"overlaps of {value!r}", lambda v=value: vf.overlaps(v)
        yield f"resolve {value!r}", lambda v=value: vf.resolve_overlaps(v)
    for value in ("<svg", "no svg", "", 3, "<svg><rect width='1e308' height='1e308'/></svg>"):
        yield f"artwork {value!r}", lambda v=value: vf.Artwork(v)


def of_motion() -> Iterator[Call]:
    def simulate(**options: Any) -> Any:
        return vf.simulate(text, **{"steps": 2, "progress": False, **options})

    for name in ("dt", "mass", "stiffness", "damping", "restitution", "friction"):
        for value in ("x", None, NAN, -1, 1j):
            yield f"{name}={value!r}", lambda n=name, v=value: simulate(**{n: v})
    for value in COUNTS:
        yield f"{value!r} steps", lambda v=value: simulate(steps=v)
    for value in (3, "xy", (NAN, 0), (1, 2, 3), (1j, 0)):
        yield f"forces {value!r}", lambda v=value: simulate(forces=v)
    for value in ("no", 3, None):
        yield f"positions {value!r}", lambda v=value: simulate(positions=v)
    for value in (0, -1, "often", 1.5):
        yield f"{value!r} substeps", lambda v=value: simulate(substeps=v)
    for value in ([], 3, [(0, text), (0, text)], [(NAN, text), (1, text)]):
        yield f"keyframes {value!r:.40}", lambda v=value: vf.Animation.from_keyframes(v)
    yield "a Player of nothing", lambda: vf.Player(None)  # type: ignore[arg-type]


def of_limits() -> Iterator[Call]:
    for value in ("x", None, NAN, 0, -1, True, 1j, [1]):
        yield f"a limit of {value!r}", lambda v=value: setattr(vf.limits, "image_pixels", v)


KINDS = (of_terms, of_solve, of_texts, of_fonts, of_pictures, of_overlaps, of_motion, of_limits)
CALLS = [call for kind in KINDS for call in kind()]


def test_more_than_300_wrong_calls_are_made() -> None:
    assert len(CALLS) > 300


@pytest.mark.parametrize(("name", "call"), CALLS, ids=[name[:60] for name, _ in CALLS])
def test_a_wrong_call_gets_a_clear_error(name: str, call: Callable[[], Any]) -> None:
    with pytest.raises(vf.VFWidgetError) as caught:
        call()
    assert 10 < len(str(caught.value)) <= 4003


@pytest.mark.parametrize("size", [1e-300, 1e-310, 5e-324])
def test_numbers_too_small_to_square_draw_nothing(size: float) -> None:
    triangle = _closed(size * torch.tensor([(-1.0, -1), (1, -1), (0, 1)], dtype=torch.float64))
    for contour in (CONTOUR + size, triangle):
        assert float(vf.rasterize([contour], size=(8, 8)).sum()) == 0
