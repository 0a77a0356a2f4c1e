"""The search for the place where a step with contact is least."""

from __future__ import annotations

import numpy as np
import pytest

import vfwidget as vf
from vfwidget.arrays import to_array
from vfwidget.energy.descent import descend
from vfwidget.energy.energy import Energy
from vfwidget.motion.body import Body
from vfwidget.motion.scene import Scene
from vfwidget.motion.terms import Contact, Inertia, Springs, Touches
from vfwidget.motion.warm import TOLERANCES, approach, least


# The axes of Roboto Flex have kinks at their defaults; those of Recursive end there.
@pytest.mark.parametrize(("font", "string"), [("roboto-flex", "8"), ("recursive", "HO")])
@pytest.mark.parametrize("depth", [0.3, 8.0, 40.0])
def test_the_search_settles_where_the_solver_ends(font, string, depth) -> None:
    text = vf.Text(font, string)
    low = to_array(text.points())[:, 1].min() + depth
    floor = [(-3000, -900), (4000, -900), (4000, low), (-3000, low)]
    body, scene = Body(text, np.ones(len(string)), positions=True), Scene(text, [floor])
    place, (outlines, obstacles) = body.start(text), scene.at(0.0)
    segments = np.concatenate([body.positions(place)[body.controls], obstacles])
    contact = Contact(Touches(body, outlines.gaps(segments, 2 * depth), obstacles))
    rest = text.coordinates + 0.01
    terms = [Inertia(body, body.reduced_at(place)), Springs(0.1 * body.inertia, rest)]
    energy = Energy(text, terms, free=body.free)
    x, settled = approach(energy, contact, energy.unknowns.start)
    assert settled
    whole = energy.at(text, [*terms, contact])
    found = descend(whole, x, TOLERANCES, 40, scale_by_columns=True)
    again = descend(whole, whole.unknowns.start, TOLERANCES, 200, scale_by_columns=True)
    here = found.problem.cost(whole.residual(x), x)
    assert here == pytest.approx(found.state.cost, abs=1e-7)
    assert here <= again.state.cost + 1e-7


def test_the_active_rows_are_those_of_the_minimum_also_if_the_exchanges_do_not_settle(
    monkeypatch,
) -> None:
    random = np.random.default_rng(3)
    normals, gaps, slope = (random.normal(size=shape) for shape in ((9, 4), 9, 4))
    settled = least(np.eye(4), slope, normals, gaps)[1]
    monkeypatch.setattr("vfwidget.motion.warm.MOST_EXCHANGES", 1)
    found, active = least(np.eye(4), slope, normals, gaps)
    assert (active != settled).any()
    rows = normals[active]
    expected = -np.linalg.solve(np.eye(4) + rows.T @ rows, slope + gaps[active] @ rows)
    np.testing.assert_allclose(found, expected, atol=1e-9)
