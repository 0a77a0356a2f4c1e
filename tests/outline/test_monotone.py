"""Roots on monotone stretches of cubics."""

from __future__ import annotations

import numpy as np
import pytest

from vfwidget.outline.monotone import climbs, evaluate, reach

STRETCHES = np.array(
    [
        [0.0, 0.0, 2.0, 1.0],  # turns at its start
        [0.0, 0.0, 0.0, 1.0],  # has an inflection at its start
        [0.0, 3.0, 0.0, 0.0],  # a line
        [1.0, 4.0, -1.0, -0.5],
    ]
).T


def reached(part: float) -> tuple[np.ndarray, np.ndarray]:
    """The parameters found where the stretches have run through a part of their change, and it."""
    ends = np.zeros(4), np.ones(4)
    about = climbs(STRETCHES, *ends, *(evaluate(STRETCHES, end) for end in ends))
    goal = about[2] + part * about[3]
    with np.errstate(all="ignore"):
        return reach(STRETCHES, about, goal), goal


def test_the_start_of_a_stretch_is_found_exactly_even_where_it_turns() -> None:
    assert np.array_equal(reached(0.0)[0], np.zeros(4))


@pytest.mark.parametrize("part", [1e-12, 1e-6, 0.1, 0.5, 0.9, 1.0])
def test_a_value_is_found_wherever_it_lies(part: float) -> None:
    t, goal = reached(part)
    assert ((t >= 0) & (t <= 1)).all()
    assert np.abs(evaluate(STRETCHES, t) - goal).max() < 1e-10
