"""Figures of delta sets, Jacobians and the effect of axes show what the library computes."""

from __future__ import annotations

import re

import matplotlib.pyplot as plt
import numpy as np
import pytest
from figures import (
    BLUE,
    FONTS,
    ORANGE,
    arrows,
    filled,
    heading,
    index,
    normalized,
    some_place,
    vertices,
)
from matplotlib.colors import to_hex
from matplotlib.patches import Rectangle
from matplotlib.quiver import Quiver

import vfwidget as vf
from vfwidget import plot


@pytest.mark.parametrize("name", FONTS)
@pytest.mark.parametrize("key", ["a", "&"])
def test_delta_sets_add_up_to_the_outline(name, key):
    font = vf.load_font(name)
    glyph = font.glyph(key)
    place = some_place(font)
    w = font.normalize(place)
    panels = plot.delta_sets(font, key, place)
    default, points = glyph.default.numpy(), glyph.points(w).numpy()
    gamma = glyph.scalars(w).numpy()
    starts = np.zeros(len(font.axes))
    np.testing.assert_allclose(
        filled(panels[0])[0].get_path().vertices, vertices(glyph.segments(starts))
    )
    np.testing.assert_allclose(
        filled(panels[-1])[-1].get_path().vertices, vertices(glyph.segments(w))
    )
    total = default[::3].copy()
    counted = 0
    for panel in panels[1:-1]:
        where, by = arrows(panel)
        np.testing.assert_allclose(where, default[::3])
        total += by
        title = panel.get_title()
        if match := re.fullmatch(r"set (\d+)\nγ = (.*)", title):
            j = int(match[1])
            counted += 1
            assert float(match[2]) == pytest.approx(gamma[j], rel=1e-2)
            np.testing.assert_allclose(by, gamma[j] * glyph.deltas[::3, :, j].numpy(), atol=1e-9)
        else:
            counted += int(re.fullmatch(r"sum of (\d+)\nother sets", title)[1])
    np.testing.assert_allclose(total, points[::3], atol=1e-9)
    moving = np.abs(glyph.deltas.numpy()).max((0, 1)) > 0
    assert counted == (moving & (gamma > 0)).sum()
    assert len(panels) <= 6
    signs = ["".join(t.get_text() for t in panel.texts) for panel in panels]
    assert signs == ["", *"+" * (len(panels) - 2), "="]
    # All to one scale.
    assert len({panel.get_xlim() + panel.get_ylim() for panel in panels}) == 1
    assert all(panel.get_aspect() == 1 for panel in panels)


def test_paper_figure_5a():
    # Afacad Flux's a at the light end and just short of the heaviest.
    light = plot.delta_sets("afacad-flux", "a", {"wght": 100})
    assert [panel.get_title() for panel in light] == ["default", "set 2\nγ = 1", "outline at w"]
    heavy = plot.delta_sets("afacad-flux", "a", {"wght": 999})
    assert len(heavy) == 4
    assert heavy[1].get_xlabel() == "γ = 1 at wght 1"


def places(font):
    """Off every kink, at the default, at both ends."""
    ends = [{a.tag: getattr(a, side) for a in font.axes} for side in ("minimum", "maximum")]
    return [some_place(font), {}, *ends]


@pytest.mark.parametrize("name", FONTS)
def test_jacobian_draws_the_motion_as_an_axis_rises_and_falls(name):
    font = vf.load_font(name)
    glyph = font.glyph("a")
    low, high = font.bounds
    for place in places(font):
        w = normalized(font, **place)
        here = glyph.points(w).numpy()[::3]
        panels = plot.jacobian(font, "a", place)
        strongest = []
        for panel in panels:
            i = index(font, panel.get_title().split()[0])
            motion = {}
            for colour, sign in (BLUE, 1), (ORANGE, -1):
                nearby = w.copy()
                nearby[i] += sign * 1e-5
                if low[i] <= nearby[i] <= high[i]:
                    motion[colour] = (glyph.points(nearby).numpy()[::3] - here) / 1e-5
            if len(motion) == 2 and np.allclose(
                motion[BLUE], -motion[ORANGE], rtol=1e-4, atol=0.01
            ):
                del motion[ORANGE]
            quivers = [c for c in panel.collections if isinstance(c, Quiver)]
            moving = {colour for colour in motion if abs(motion[colour]).max() > 1e-3}
            assert {to_hex(c.get_facecolor()[0]) for c in quivers} == moving
            for colour in moving:
                where, drawn = arrows(panel, colour)
                np.testing.assert_allclose(where, here)
                np.testing.assert_allclose(drawn, motion[colour], rtol=1e-4, atol=1e-3)
            longest = max(np.linalg.norm(m, axis=1).max() for m in motion.values())
            stated = float(panel.get_title().split(": ")[1])
            assert stated == pytest.approx(longest, rel=0.02, abs=0.51)
            strongest.append(longest)
        assert sorted(strongest, reverse=True) == pytest.approx(strongest)
        # Every axis is shown or named beneath.
        shown = [panel.get_title().split()[0] for panel in panels]
        assert all(a.tag in shown or a.tag in heading(panels)[1] for a in font.axes)
        plt.close("all")


@pytest.mark.parametrize("name", FONTS)
@pytest.mark.parametrize("at_default", [True, False])
def test_axis_effect_is_the_farthest_way_of_the_points(name, at_default):
    font = vf.load_font(name)
    glyph, place = font.glyph("g"), {} if at_default else some_place(font)
    ax = plot.axis_effect(font, "g", place)
    w = normalized(font, **place)
    here = glyph.points(w).numpy()
    count = len(font.axes)
    bars = [patch for patch in ax.patches if isinstance(patch, Rectangle)]
    largest, mean = (
        np.array([b.get_width() for b in part]) for part in (bars[:count], bars[count:])
    )
    assert (np.diff(largest) <= 0).all()
    labels = [label.get_text().split()[0] for label in ax.get_yticklabels()]
    assert sorted(labels) == sorted(axis.tag for axis in font.axes)
    for tag, most, average, note in zip(labels, largest, mean, ax.texts, strict=True):
        i = index(font, tag)
        along = np.repeat(w[None], 401, 0)
        along[:, i] = np.linspace(font.bounds[0][i], font.bounds[1][i], 401)
        way = np.linalg.norm(glyph.points(along).numpy() - here, axis=-1).max(0)
        assert way.max() - 1e-6 <= most <= way.max() * 1.01 + 1e-6
        assert way.mean() - 1e-6 <= average <= way.mean() * 1.01 + 1e-6
        assert note.get_text() == "no displacement" or float(note.get_text()) == pytest.approx(
            most, rel=0.05
        )
        assert (note.get_text() == "no displacement") == (most == 0)
