"""The figure of the settings shows which glyph stands in which box."""

from __future__ import annotations

import fonts
import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.patches import PathPatch, Rectangle

import vfwidget as vf
from vfwidget import plot


@pytest.fixture(autouse=True)
def no_figures_left():
    yield
    plt.close("all")


def cells(panel):
    """The colour of each cell by its corner."""
    found = [patch for patch in panel.patches if type(patch) is Rectangle]
    return {cell.get_xy(): to_hex(cell.get_facecolor()) for cell in found}


def labels(ticks):
    return [tick.get_text() for tick in ticks]


def legend():
    (found,) = plt.gcf().subfigs[0].legends
    named = zip(found.legend_handles, found.get_texts(), strict=True)
    return {
        text.get_text(): to_hex(handle.get_facecolor())
        for handle, text in named
        if text.get_text() != "default"
    }


def test_a_font_that_exchanges_nothing():
    (panel,) = plot.settings("dynapuff", "S")
    assert len(cells(panel)) == 1
    assert list(legend()) == ["S"]
    assert "everywhere" in plt.gcf().subfigs[0].get_supxlabel()


def test_one_axis_has_a_row_of_boxes():
    font = vf.load_font(fonts.swapping([{"wght": (0.25, 0.5)}, {"wght": (0.9, 1)}]))
    (panel,) = plot.settings(font, "a")
    names = legend()
    square, bowl = names["a"], names["bowl"]
    assert [cells(panel)[i, 0] for i in range(4)] == [square, bowl, square, bowl]
    assert labels(panel.get_xticklabels()) == ["100", "525", "650", "850", "900"]
    assert not len(panel.get_yticks())
    assert panel.get_xlabel() == "wght (Weight)"


def test_two_axes_have_a_grid_of_boxes():
    (panel,) = plot.settings("recursive", "k", axes={"wght": 800})
    names, font = legend(), vf.load_font("recursive")
    assert set(names) == {"k", "k.italic"}
    assert labels(panel.get_xticklabels()) == ["0", "0.1", "0.9", "1"]
    assert labels(panel.get_yticklabels()) == ["-15", "-14.04", "0"]
    for x, cursive in enumerate([0.05, 0.5, 0.95]):
        for y, slant in enumerate([-14.9, -7]):
            text = vf.Text(font, "k", axes={"CRSV": cursive, "slnt": slant})
            assert cells(panel)[x, y] == names[text.glyphs[0].name]
    drawn = [patch for patch in panel.patches if isinstance(patch, PathPatch)]
    assert len(drawn) == 6


def test_more_axes_get_a_panel_for_each_part():
    panels = plot.settings("recursive", "g")
    assert [panel.get_title() for panel in panels] == ["slnt -15 to -14.04", "slnt -14.04 to 0"]
    assert set(legend()) == {"g", "g.italic", "g.mono"}
    assert all(len(cells(panel)) == 6 for panel in panels)
    assert np.unique([*cells(panels[0]).values()]).size == 3


def test_a_text_is_shown_with_its_glyphs_that_change():
    text = vf.Text("roboto-flex", "$1", axes={"XTRA": 500})
    (panel,) = plot.settings(text)
    assert list(legend()) == ["uni0024", "uni0024.rvrn"]
    assert len(cells(panel)) == 4


def test_bad_input_is_refused():
    with pytest.raises(vf.TextError, match="A font needs a string"):
        plot.settings("recursive")
    with pytest.raises(vf.TextError, match="is empty"):
        plot.settings("recursive", "")
    with pytest.raises(vf.AxisError):
        plot.settings("recursive", "k", axes={"nope": 1})
    with pytest.raises(vf.VFWidgetError, match="grid"):
        plot.settings("recursive", "k", ax=plt.figure().add_axes((0, 0, 1, 1)))
