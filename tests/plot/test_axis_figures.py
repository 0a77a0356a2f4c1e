"""Figures of normalization, supports and scalars show the numbers that the library computes."""

from __future__ import annotations

import re

import fonts
import matplotlib.pyplot as plt
import numpy as np
import pytest
from figures import FONTS, heading, index, normalized
from matplotlib.contour import QuadContourSet

import vfwidget as vf
from vfwidget import plot


def phi(support, w):
    """OpenType's support function of one axis, at coordinates (v,)."""
    start, peak, end = support
    if peak == 0 or start > peak or peak > end or start < 0 < end:
        return np.ones_like(w)
    rise, fall = max(peak - start, 1e-300), max(end - peak, 1e-300)
    value = np.where(w < peak, (w - start) / rise, (end - w) / fall)
    return np.where(w == peak, 1, np.where((w <= start) | (w >= end), 0, value))


@pytest.mark.parametrize("name", FONTS)
def test_normalization_draws_the_map_of_each_axis(name):
    font = vf.load_font(name)
    panels = plot.normalization(font)
    shown = []
    for panel in panels:
        tag = panel.get_title().split()[0]
        axis = font.axes[index(font, tag)]
        shown.append(tag)
        straight, mapped, default = panel.lines
        users = mapped.get_xdata()
        between = np.linspace(axis.minimum, axis.maximum, 41)
        want = [normalized(font, **{tag: user})[index(font, tag)] for user in between]
        np.testing.assert_allclose(
            np.interp(between, users, mapped.get_ydata()), want, rtol=0, atol=1e-12
        )
        ends = [axis.minimum, axis.default, axis.maximum]
        want = np.sign([end - axis.default for end in ends])
        np.testing.assert_allclose(
            np.interp(ends, straight.get_xdata(), straight.get_ydata()), want, atol=1e-12
        )
        half = (axis.minimum + axis.default) / 2, (axis.maximum + axis.default) / 2
        np.testing.assert_allclose(
            np.interp(half, straight.get_xdata(), straight.get_ydata()),
            [want[0] / 2, want[2] / 2],
            atol=1e-12,
        )
        assert [*default.get_xdata(), *default.get_ydata()] == [axis.default, 0]
        bent = [t.get_text() for t in panel.texts] != ["identity map"]
        assert bent == (axis.segment_map != tuple((x, x) for x, _ in axis.segment_map))
    # The notes name the axes that are not shown.
    rest = [axis.tag for axis in font.axes if axis.tag not in shown]
    assert len(shown) == min(6, len(font.axes))
    assert all(tag in heading(panels)[1] for tag in rest)


def test_normalization_of_chosen_axes():
    font = vf.load_font("roboto-flex")
    tags = [axis.tag for axis in font.axes]
    assert len(plot.normalization(font, tags)) == 13
    chosen = plot.normalization(font, ("wght", "opsz"))
    assert [panel.get_title().split()[0] for panel in chosen] == ["opsz", "wght"]
    assert "Not shown" not in heading(chosen)[1]
    assert len(plot.normalization("roboto-flex", "YTFI")) == 1
    with pytest.raises(vf.VFWidgetError, match="empty"):
        plot.normalization(font, [])


def test_normalization_of_two_axes_with_one_tag():
    font = vf.load_font(fonts.one_tag_on_two_axes())
    panels = plot.normalization(font, "wght")
    at = [np.interp(650, *panel.lines[1].get_data()) for panel in panels]
    np.testing.assert_allclose(at, normalized(font, wght=650))


def numbers(label):
    return [int(j) for j in re.findall(r"\d+", label.split("(")[0])]


@pytest.mark.parametrize("name", FONTS)
def test_support_draws_phi(name):
    font = vf.load_font(name)
    glyph = font.glyph("a")
    support = glyph.support.numpy()
    for i, axis in enumerate(font.axes):
        ax = plot.support(font, "a", axis.tag)
        active = [
            j for j in range(len(support)) if (phi(support[j, i], np.array([0.0])) == 0).any()
        ]
        regions = {tuple(support[j, i]) for j in active}
        if not active:
            assert "φ is 1 everywhere" in heading(ax)[1]
            assert (ax.lines[0].get_ydata() == 1).all()
            plt.close("all")
            continue
        assert len(ax.lines) == min(6, len(regions))
        for line in ax.lines:
            w, drawn = line.get_data()
            sets = numbers(line.get_label())
            for j in sets:
                np.testing.assert_allclose(drawn, phi(support[j, i], w), atol=1e-12)
            every = [j for j in active if (support[j, i] == support[sets[0], i]).all()]
            assert sets == every or f"({len(every)} in all)" in line.get_label()
            # Dashed where no set depends on this axis alone.
            along = np.zeros((len(w), len(font.axes)))
            along[:, i] = w
            alone = glyph.scalars(along).numpy()[:, every].any()
            assert (line.get_linestyle() == "-") == alone
        top = ax.child_axes[0]
        for w, label in zip(top.get_xticks(), top.get_xticklabels(), strict=True):
            at = normalized(font, **{axis.tag: float(label.get_text())})[i]
            assert at == pytest.approx(w, abs=1e-3)
        plt.close("all")


def test_support_of_every_shape_shows_the_strongest_and_says_so():
    font = vf.load_font(fonts.regions_of_every_shape())
    glyph = font.glyph("a")
    ax = plot.support(font, "a", "wght")
    shown = {j for line in ax.lines for j in numbers(line.get_label())}
    effect = np.linalg.norm(glyph.deltas.numpy(), axis=1).max(0)
    assert len(ax.lines) == 6
    assert "Not shown: 3 supports of delta sets with a smaller effect" in heading(ax)[1]
    assert min(effect[9:][[j - 9 for j in shown if j >= 9]]) > max(
        effect[j] for j in range(9, 18) if j not in shown
    )
    for line in ax.lines:
        w, drawn = line.get_data()
        j = numbers(line.get_label())[0]
        support = glyph.support[j, 0].numpy()
        np.testing.assert_allclose(drawn, phi(support, w), atol=1e-9)
        # Cliffs are upright: the line is true between its corners too.
        wide = np.diff(w) > 1e-5
        middle = ((w[1:] + w[:-1]) / 2)[wide]
        np.testing.assert_allclose(np.interp(middle, w, drawn), phi(support, middle), atol=1e-9)


SLICES = [
    ("afacad-flux", "a", "wght", "slnt", {"wght": 800, "slnt": 10}),
    ("dynapuff", "a", "wdth", "wght", {}),
    ("roboto-flex", "g", "wght", "wdth", {"opsz": 100, "wght": 900, "XOPQ": 120}),
    ("recursive", "a", "slnt", "CASL", {"MONO": 1}),
    ("shantell-sans", "a", "wght", "BNCE", {"INFM": 100}),
]


@pytest.mark.parametrize("surface", [False, True])
@pytest.mark.parametrize("name, key, tag, tag2, axes", SLICES)
def test_scalars_draw_gamma(name, key, tag, tag2, axes, surface):
    font = vf.load_font(name)
    glyph, w = font.glyph(key), normalized(font, **axes)
    pair = [index(font, tag), index(font, tag2)]
    low, high = (bound[pair] for bound in font.bounds)

    def gamma(places):
        every = np.repeat(w[None], len(places), 0)
        every[:, pair] = np.clip(places, low, high)
        return glyph.scalars(every).numpy()

    panels = plot.scalars(font, key, tag, tag2, axes, surface=surface)
    shown = []
    for panel in panels:
        j, value = re.fullmatch(r"set (\d+): γ\(w\) = (.*)", panel.get_title()).groups()
        j = int(j)
        shown.append(j)
        assert float(value) == pytest.approx(gamma(w[None, pair])[0, j], rel=1e-2)
        assert not value.startswith("-")
        assert [panel.get_xlabel(), panel.get_ylabel()] == [tag, tag2]
        if surface:
            assert panel.name == "3d"
            dot = np.ravel(panel.collections[-1]._offsets3d)
            np.testing.assert_allclose(dot, [*w[pair], gamma(w[None, pair])[0, j]])
            for line, side in zip(panel.lines, (0, 1), strict=True):
                along, drawn = line.get_data_3d()[side], line.get_data_3d()[2]
                want = phi(glyph.support[j, pair[side]].numpy(), along)
                np.testing.assert_allclose(drawn, want, atol=1e-12)
            continue
        np.testing.assert_allclose(np.ravel(panel.lines[0].get_data()), w[pair])
        contours = next(c for c in panel.collections if isinstance(c, QuadContourSet))
        np.testing.assert_allclose(contours.levels, np.linspace(0, 1, 11))
        for lower, upper, path in zip(
            contours.levels, contours.levels[1:], contours.get_paths(), strict=False
        ):
            if len(path.vertices):
                inside = gamma(path.vertices)[:, j]
                assert lower - 0.01 <= inside.min() <= inside.max() <= upper + 0.01

    # The strongest on this slice are shown, and the others counted.
    places = np.stack(np.meshgrid(*np.linspace(low, high, 41).T), -1).reshape(-1, 2)
    places = np.concatenate([places, glyph.support[:, pair, 1].numpy()])
    heights = gamma(places)
    varying = np.ptp(heights, axis=0) > 1e-9
    effect = heights.max(0) * np.linalg.norm(glyph.deltas.numpy(), axis=1).max(0) * varying
    want = np.sort(effect)[::-1][: len(shown)]
    np.testing.assert_allclose(effect[shown], want, rtol=0.05)
    smaller = (effect > 0).sum() - len(shown)
    assert (f"Not shown: {smaller} delta sets with a smaller effect" in heading(panels)[1]) == (
        smaller > 0
    )
    assert len(shown) == min(6, (effect > 0).sum())
