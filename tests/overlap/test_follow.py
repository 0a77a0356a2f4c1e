"""Drags that avoid overlaps: nothing passes a bar unseen, and no accepted state overlaps more."""

from __future__ import annotations

import numpy as np
import pytest

import vfwidget as vf
from benchmarks.overlap_drags import increases, random_drags
from vfwidget.energy.descent import descend
from vfwidget.energy.tied import energy_of
from vfwidget.overlap.follow import _Way, follow
from vfwidget.overlap.shape import read_obstacles
from vfwidget.overlap.swept import first_contact
from vfwidget.solver.problem import Tolerances


def common(text, obstacles=()):
    return sum(overlap.area for overlap in vf.overlaps(text, obstacles))


def bar(width, angle):
    corners = np.array([(0, -300), (width, -300), (width, 900), (0, 900)])
    turn = [[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]]
    return corners @ np.array(turn)


def contact(text, end, obstacles=(), between_glyphs=True):
    """Where the way from a text to another place is first blocked."""
    points, start, word = text.point_set(), text.place, text.word.contours

    def at(t):
        place = {name: start[name] + t * (end[name] - start[name]) for name in start}
        return points.positions(place)[word.segments]

    contours = [glyph.contours for glyph in text.glyphs]
    return first_contact(at, contours, obstacles, between_glyphs)


def moved(text, x, y=0.0):
    return {**text.place, "offsets": text.place["offsets"] + [(x, y)]}


@pytest.mark.parametrize("width", [0.5, 5, 10, 40, 120])
@pytest.mark.parametrize("step", [5, 20, 60, 150, 2000])
def test_no_bar_is_passed_unseen(width, step):
    text = vf.Text("roboto-flex", "l")
    beam = bar(width, 0.01 * step % 0.7 - 0.3)
    obstacles = read_obstacles([beam])
    text = text.at(offsets=[(-min(1600, 500 + 2 * step), 0)])
    for _ in range(3000 // step + 1):
        part, beyond = contact(text, moved(text, step), obstacles)
        if part < 1:
            break
        text = text.moved_to(moved(text, step))
    assert part < 1
    assert common(text.moved_to(moved(text, part * step)), [beam]) == 0
    assert common(text.moved_to(moved(text, beyond * step)), [beam]) > 0
    # Little is lost of the way to the contact.
    assert (beyond - part) * step < 0.8


def test_the_whole_way_is_free_where_nothing_is_near():
    text = vf.Text("recursive", "variable", shared=False)
    end = {**text.place, "axes": text.place["axes"] + 0.2}
    assert contact(text, end).free == 1.0
    assert contact(vf.Text("recursive", " "), vf.Text("recursive", " ").place).free == 1.0


def test_letters_meet_each_other():
    text = vf.Text("dynapuff", "oo")
    start = text.at(offsets=[(-300, 0), (0, 0)])
    end = {**start.place, "offsets": np.array([(1500.0, 0), (0, 0)])}
    part = contact(start, end).free
    assert 0.1 < part < 0.9
    assert contact(start, end, between_glyphs=False).free == 1.0


def drag(text, handle, way, obstacles=(), between=True):
    """The states of a drag in steps, and the contacts of the last one."""
    start, press, states = text.position(handle).numpy(), text.theta, [text]
    calm = vf.StayClose((0.001 * text.font.units_per_em) ** 2, press)
    keep, held = vf.NoOverlap(read_obstacles(obstacles), between), None
    for delta in way:
        found = follow(states[-1], [vf.Target(handle, start + delta), calm], keep, held=held)
        held = found.held
        states.append(found.solution.text)
    return states, found


def test_a_bar_stops_a_stem_at_once_and_in_steps():
    text = vf.Text("roboto-flex", "l")
    right = float(text.segments()[0][..., 0].max())
    beam = [(right + 60, 100), (right + 70, 100), (right + 70, 900), (right + 60, 900)]
    handle = text.nearest(right, 500)
    for way in ([(200, 0)], [(20 * i, 0) for i in range(1, 9)]):
        states, found = drag(text, handle, way, [beam])
        end = float(states[-1].segments()[0][..., 0].max())
        assert right + 55 < end <= right + 60.001
        assert all(common(state, [beam]) == 0 for state in states)
        assert found.solution.status == "unreachable"
        assert abs(found.contacts - (right + 60, 500)).min(0)[0] < 1


def test_neighbours_give_way():
    # The descender of a "p" stands on an "o", the top of which is dragged upwards.
    text = vf.Text("roboto-flex", "op", shared=False)
    o, p = (glyph.default.numpy() for glyph in text.glyphs)
    middle, top = o[:, 0].mean(), o[:, 1].max()
    stem = p[p[:, 1] < p[:, 1].min() + 1, 0].mean()
    up = top - p[:, 1].min() + 10
    text = text.at(offsets=[(0, 0), (middle - stem - text.layout[1].x, up)])
    handle = text.nearest(middle, top)
    states, found = drag(text, handle, [(0, 10 * i) for i in range(1, 9)])
    assert all(common(state) <= 1e-6 for state in states)
    assert len(found.contacts)
    assert float(states[-1].position(handle)[1]) > top + 25
    # The descender has become shorter.
    bottoms = [float(s.points()[len(o) :, 1].min()) for s in (text, states[-1])]
    assert bottoms[1] > bottoms[0] + 15


@pytest.mark.slow
def test_no_accepted_state_overlaps_more_than_the_one_before():
    for drag in random_drags(60):
        assert max(increases(drag)) <= 1e-6, drag


def test_where_a_way_is_blocked_the_descent_has_the_values_of_that_state():
    text = vf.Text("recursive", "n", axes={"wght": 600})
    foot = text.nearest(600, 0)
    x, y = text.position(foot).tolist()
    wish = energy_of(text, [vf.Target(foot, (x + 60, y)), vf.StayClose()])
    start = wish.unknowns.start
    direct = descend(wish, start, Tolerances(), 1)
    assert abs(direct.state.x - start).max() > 0
    ended = _Way(text, wish, vf.NoOverlap(), ()).ended(start, direct)
    np.testing.assert_array_equal(ended.state.residual, wish.residual(start))
    assert ended.state.model is None and ended.state.cost > direct.state.cost
