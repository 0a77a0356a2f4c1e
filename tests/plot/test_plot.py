"""What holds for every figure: it is readable, and names are checked."""

from __future__ import annotations

import re

import fonts
import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
from figures import heading, some_place
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.text import Text

import vfwidget as vf
from vfwidget import plot


def every_figure(font, key, ax=None):
    """Each function once, as (name, function)."""
    tag, tag2 = font.axes[0].tag, font.axes[1].tag
    place = some_place(font)
    return {
        "normalization": lambda ax=None: plot.normalization(font, ax=ax),
        "gallery": lambda ax=None: plot.gallery(font, key, tag, ax=ax),
        "gallery of two": lambda ax=None: plot.gallery(font, key, tag, tag2, ax=ax),
        "outline": lambda ax=None: plot.outline(font, key, place, ax=ax),
        "support": lambda ax=None: plot.support(font, key, tag, ax=ax),
        "delta_sets": lambda ax=None: plot.delta_sets(font, key, place, ax=ax),
        "scalars": lambda ax=None: plot.scalars(font, key, tag, tag2, place, ax=ax),
        "surfaces": lambda ax=None: plot.scalars(font, key, tag, tag2, place, True, ax=ax),
        "layout": lambda ax=None: plot.layout(vf.Text(font, "fill jig"), ax=ax),
        "jacobian": lambda ax=None: plot.jacobian(font, key, place, ax=ax),
        "axis_effect": lambda ax=None: plot.axis_effect(font, key, place, ax=ax),
    }


FIGURES = list(every_figure(vf.load_font("recursive"), "a"))


def visible_texts(figure):
    """What can be read on a figure once it is drawn, (t,), and where, (t, 2, 2)."""
    figure.canvas.draw()
    # Ticks beyond the limits keep a label that is never drawn.
    beyond = set()
    for axis in figure.findobj(Axis):
        low, high = sorted(axis.get_view_interval())
        ticks = [tick for tick in axis.get_major_ticks() if not low <= tick.get_loc() <= high]
        beyond |= {label for tick in ticks for label in (tick.label1, tick.label2)}
    texts = [
        text
        for text in figure.findobj(Text)
        if text.get_text().strip() and text.get_visible() and text not in beyond
    ]
    boxes = [text.get_window_extent().get_points() for text in texts]
    return np.array([text.get_text() for text in texts]), np.array(boxes)


@pytest.mark.parametrize("figure", [name for name in FIGURES if name != "surfaces"])
def test_every_text_is_on_the_figure_and_on_no_other(figure):
    # With 13 axes of long names and 70 delta sets there is most to say.
    every_figure(vf.load_font("roboto-flex"), "a")[figure]()
    texts, boxes = visible_texts(plt.gcf())
    low, high = boxes[:, 0], boxes[:, 1]
    on_page = (low > -1).all(1) & (high < np.array(plt.gcf().bbox.size) + 1).all(1)
    assert on_page.all(), texts[~on_page]
    # Side by side, words want a gap.
    gap = np.array([2, -1])
    low, high = low - gap, high + gap
    meet = ((low < high[:, None]) & (low[:, None] < high)).all(-1)
    assert (meet == np.eye(len(texts))).all(), [texts[list(pair)] for pair in np.argwhere(meet)]


@pytest.mark.parametrize("figure", FIGURES)
def test_a_given_axes_is_used(figure):
    font = vf.load_font("afacad-flux")
    own, axs = plt.subplots(2, 2)
    before = dict(mpl.rcParams)
    drawn = every_figure(font, "a")[figure](ax=axs[0, 1])
    assert plt.get_fignums() == [own.number]
    assert dict(mpl.rcParams) == before
    if isinstance(drawn, Axes):
        assert drawn is axs[0, 1]
    else:
        assert axs[0, 1] not in own.axes
        assert set(drawn) <= set(own.axes)
    with pytest.raises(vf.VFWidgetError, match="matplotlib Axes"):
        every_figure(font, "a")[figure](ax=axs)
    if not isinstance(drawn, Axes):
        with pytest.raises(vf.VFWidgetError, match="grid"):
            every_figure(font, "a")[figure](ax=own.add_axes((0, 0, 1, 1)))


@pytest.mark.parametrize("figure", ["gallery", "outline", "delta_sets", "layout", "jacobian"])
def test_glyphs_have_equal_aspect(figure):
    drawn = every_figure(vf.load_font("dynapuff"), "a")[figure]()
    plt.gcf().canvas.draw()
    for ax in np.ravel([drawn]):
        (x0, y0), (x1, y1) = ax.transData.transform([(0, 0), (100, 100)])
        # matplotlib leaves a difference of half a percent alone.
        assert x1 - x0 == pytest.approx(y1 - y0, rel=0.006)


@pytest.mark.parametrize("figure", [name for name in FIGURES if name != "layout"])
def test_a_glyph_without_an_outline_or_without_deltas(figure):
    bare = {"a": fonts.outline(fonts.SQUARE), "s": fonts.outline()}
    still = vf.load_font(fonts.build(bare, {}))
    for font, key in (still, "a"), (still, "s"), (vf.load_font("recursive"), " "):
        drawn = every_figure(font, key)[figure]()
        words = " ".join(text.get_text() for text in plt.gcf().findobj(Text))
        said = "no outline|no displacement|No axis moves|No delta set|Every γ is 0"
        assert re.search(said, words) or figure in ("normalization", "outline")
        assert heading(drawn)[0]


def test_text_from_a_font_is_shown_as_it_is():
    glyphs = {"$": fonts.outline(fonts.SQUARE), "a": fonts.outline(fonts.SQUARE)}
    axes = [("$ht$", 0, 0, 1, "$x_1$ axis"), ("wdth", 0, 0, 1, "字幅\n")]
    move = [(0, 0), (50, 0), (50, 0), (0, 0), *fonts.STILL]
    moved = {"$": [({"$ht$": (0, 1, 1)}, move), ({"wdth": (0, 1, 1)}, move)]}
    font = vf.load_font(
        fonts.build(
            glyphs,
            moved,
            axes,
            edit=lambda f: f.setupNameTable({"familyName": "字$^2$", "styleName": "Regular"}),
        )
    )
    for name, figure in every_figure(font, "$").items():
        if name != "layout":
            figure()
            # No warning of a missing sign, and no mathematics.
            plt.gcf().canvas.draw()
    plot.layout(vf.Text(font, "$a$"))
    plt.gcf().canvas.draw()
    assert plt.gca().get_title() == r"“\$a\$” in ?\$^2\$"
    # What cannot be seen goes by its name.
    assert plot.outline("recursive", " ").get_title() == "space in Recursive Sans Linear Light"


def test_named_instances_are_the_axes_of_a_figure():
    font = vf.load_font("recursive")
    instance = font.instances[5]
    calls = {
        "gallery": lambda axes: plot.gallery(font, "a", "wght", axes=axes),
        "outline": lambda axes: plot.outline(font, "a", axes),
        "delta_sets": lambda axes: plot.delta_sets(font, "a", axes),
        "scalars": lambda axes: plot.scalars(font, "a", "wght", "slnt", axes),
        "jacobian": lambda axes: plot.jacobian(font, "a", axes),
        "axis_effect": lambda axes: plot.axis_effect(font, "a", axes),
        "settings": lambda axes: plot.settings(font, "k", axes),
    }
    for name, call in calls.items():
        drawn = []
        for axes in (instance.axes, instance, instance.name):
            call(axes)
            drawn.append(sorted(visible_texts(plt.gcf())[0].tolist()))
            plt.close()
        assert drawn[0] == drawn[1] == drawn[2], name


def test_unknown_names_are_clear_errors():
    font = vf.load_font("recursive")
    for figure in (
        lambda **k: plot.gallery(font, k["glyph"], k["tag"]),
        lambda **k: plot.gallery(font, k["glyph"], "wght", k["tag"]),
        lambda **k: plot.gallery(font, k["glyph"], "wght", axes={k["tag"]: 1}),
        lambda **k: plot.outline(font, k["glyph"], {k["tag"]: 1}),
        lambda **k: plot.support(font, k["glyph"], k["tag"]),
        lambda **k: plot.scalars(font, k["glyph"], k["tag"], "wght"),
        lambda **k: plot.scalars(font, k["glyph"], "slnt", "wght", {k["tag"]: 1}),
        lambda **k: plot.delta_sets(font, k["glyph"], {k["tag"]: 1}),
        lambda **k: plot.jacobian(font, k["glyph"], {k["tag"]: 1}),
        lambda **k: plot.axis_effect(font, k["glyph"], {k["tag"]: 1}),
    ):
        for glyph in "字", "no such glyph", -1, None:
            with pytest.raises(vf.GlyphError):
                figure(glyph=glyph, tag="wght")
        with pytest.raises(vf.AxisError, match="This font has: MONO"):
            figure(glyph="a", tag="xxxx")
    with pytest.raises(vf.AxisError, match="This font has"):
        plot.normalization(font, ["xxxx"])
    for figure in plot.gallery, plot.scalars:
        with pytest.raises(vf.AxisError, match="twice"):
            figure(font, "a", "wght", "wght")
    for count in 1, 101, 10**9, 2.5, "five":
        with pytest.raises(vf.VFWidgetError, match="count must be a whole number from 2 to 100"):
            plot.gallery(font, "a", "wght", count=count)
    for samples in -1, 10**9, 1.5, "one":
        with pytest.raises(vf.VFWidgetError, match="samples must be a whole number from 0"):
            plot.outline(font, "a", samples=samples)
    assert plt.get_fignums() == []
