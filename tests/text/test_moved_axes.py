"""Glyphs that change at locations that other axes move (avar 2 with condition sets)."""

from __future__ import annotations

import fonts
import formats
import numpy as np
import pytest
import torch
import variation_tables
from referee import HarfBuzz

import vfwidget as vf

BOWL_DELTAS = [(0, 0)] * 3 + [(0, 300)] * 3
SQUARE_DELTAS = [(0, 0)] * 2 + [(0, 100)] * 2


@pytest.fixture(scope="module")
def data() -> bytes:
    """Weight displaces width by -0.5; below -0.2 of the final width the square is a bowl."""
    wider = {"a": [(fonts.BOLD, SQUARE_DELTAS + fonts.STILL)]}
    wider["bowl"] = [(fonts.BOLD, BOWL_DELTAS + fonts.STILL)]
    return fonts.swapping([{"wdth": (-1, -0.2)}], variation_tables.add_avar_2, wider)


@pytest.fixture(scope="module")
def font(data: bytes) -> vf.Font:
    return vf.load_font(data)


def test_the_glyph_is_that_of_harfbuzz(font: vf.Font, data: bytes) -> None:
    referee, text = HarfBuzz(fonts.open_font(data)), vf.Text(font, "a")
    assert font.moves_axes
    rng = np.random.default_rng(1)
    seen = set()
    for _ in range(60):
        axes = {axis.tag: rng.uniform(axis.minimum, axis.maximum) for axis in font.axes}
        referee.font.set_variations(axes)
        moved = text.at(axes)
        assert [glyph.glyph_id for glyph in moved.glyphs] == referee.glyph_ids("a")
        seen.add(moved.glyphs[0].name)
    assert seen == {"a", "bowl"}


def test_the_glyph_is_the_same_in_the_whole_box(font: vf.Font) -> None:
    text, rng = vf.Text(font, "a"), np.random.default_rng(2)
    lower, upper = font.bounds
    sizes = []
    for _ in range(40):
        here = text.moved(rng.uniform(lower, upper)[None])
        low, high = (side[0] for side in here.composition.bounds_at(here.coordinates))
        assert (low <= here.coordinates).all() and (here.coordinates <= high).all()
        corners = np.array([[low[0], low[1]], [low[0], high[1]], [high[0], low[1]], high])
        for w in [*corners, *rng.uniform(low, high, (20, 2))]:
            assert text.moved(w[None]).word is here.word
        sizes.append(np.prod(high - low) / np.prod(upper - lower))
    assert np.mean(sizes) > 0.2


@formats.needs_conformance
def test_where_final_coordinates_are_clamped_the_derivative_is_that_into_the_range() -> None:
    text, step = vf.Text(formats.CONFORMANCE / "formats" / "avar2checker.ttf", "BAB"), 1e-6
    for theta in np.stack(np.meshgrid([0, 0.4, 1], [0, 0.3, 1]), -1).reshape(-1, 1, 2):
        here, jacobian = text.points(theta), text.jacobian(theta)
        for axis in range(2):
            side = -step if theta[0, axis] >= 1 else step
            there = theta + side * np.eye(2)[axis]
            slope = (text.points(there) - here) / side
            torch.testing.assert_close(jacobian[:, :, 0, axis], slope, rtol=1e-6, atol=1e-4)


@pytest.mark.parametrize("shift", [(-400, 0), (-200, 400)])
def test_the_end_of_an_axis_that_another_one_moves_is_said_to_hold_it(shift) -> None:
    """At weights close to 0 the final width is below -1, and so width alone moves nothing."""
    text = vf.Text(variation_tables.avar_2(), "a").at(theta=[[0.3, -0.6]])
    left = text.handle(segment=1, t=0.3)
    goal = text.position(left) + torch.tensor(shift)
    found = vf.solve(text, [vf.Target(left, goal), vf.StayClose()], restarts=0)
    assert found.theta.tolist() == [[0, -1]]
    wider = found.text.at(theta=[[0, -1 + 1e-6]]).position(left)
    assert (wider - goal).norm() > (found.text.position(left) - goal).norm()
    assert found.active[0, 1] == -1
    assert "wdth is at its minimum" in found.message


def test_a_solve_crosses_and_ends_with_the_glyph_of_its_location(font: vf.Font) -> None:
    start = vf.Text(font, "a", axes={"wght": 400, "wdth": 100})
    corner = start.handle(segment=2)
    goal = start.at({"wght": 900, "wdth": 100})
    assert goal.glyphs != start.glyphs
    target = goal.position(goal.carry(corner))
    solution = vf.solve(start, vf.Target(corner, target), locks=["wdth"])
    again = start.at(theta=solution.theta)
    assert solution.text.glyphs == again.glyphs == goal.glyphs
    assert again.position(again.carry(corner)).numpy() == pytest.approx(target.numpy(), abs=0.5)
    assert solution.converged
    assert [(met.axis, met.crossed) for met in solution.boundaries] == [("wght", True)]
