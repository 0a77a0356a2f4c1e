"""The figures show the numbers that the library computes, and they are readable."""

from __future__ import annotations

import re
from itertools import combinations

import fonts
import matplotlib as mpl

mpl.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.colors import to_hex
from matplotlib.contour import QuadContourSet
from matplotlib.patches import PathPatch, Rectangle
from matplotlib.path import Path
from matplotlib.quiver import Quiver
from matplotlib.text import Text

import vfwidget as vf
from vfwidget import plot

FONTS = vf.bundled_fonts()
BLUE, VERMILLION, GREEN, ORANGE = "#0072b2", "#d55e00", "#009e73", "#e69f00"


@pytest.fixture(autouse=True)
def no_figures_left():
    yield
    plt.close("all")


def normalized(font, **axes):
    return font.normalize(axes).numpy()


def index(font, tag):
    return [axis.tag for axis in font.axes].index(tag)


def some_place(font):
    """User values off the default, inside and at the ends, by turns."""
    parts = [0.3, 1, 0.8, 0]
    return {
        axis.tag: axis.minimum + parts[i % 4] * (axis.maximum - axis.minimum)
        for i, axis in enumerate(font.axes)
    }


def filled(ax):
    return [patch for patch in ax.patches if isinstance(patch, PathPatch)]


def vertices(contours):
    """Contours (s, 4, 2) as the points a pen goes through, back at the start."""
    parts = [np.zeros((0, 2))]
    for cubics in contours:
        cubics = np.asarray(cubics)
        parts += [cubics[0, :1], cubics[:, 1:].reshape(-1, 2), cubics[0, :1]]
    return np.concatenate(parts)


def arrows(ax, colour=None):
    """Where arrows start and what they are, (p, 2) each, of one colour."""
    found = [c for c in ax.collections if isinstance(c, Quiver)]
    found = [c for c in found if colour is None or to_hex(c.get_facecolor()[0]) == colour]
    return (
        np.concatenate([c.XY for c in found]),
        np.concatenate([np.stack([c.U, c.V], -1) for c in found]),
    )


def phi(support, w):
    """OpenType's support function of one axis, at coordinates (v,)."""
    start, peak, end = support
    if peak == 0 or start > peak or peak > end or start < 0 < end:
        return np.ones_like(w)
    rise, fall = max(peak - start, 1e-300), max(end - peak, 1e-300)
    value = np.where(w < peak, (w - start) / rise, (end - w) / fall)
    return np.where(w == peak, 1, np.where((w <= start) | (w >= end), 0, value))


def heading(ax):
    """Title and notes of a figure of one Axes, or of what panels are in."""
    if isinstance(ax, Axes):
        return ax.get_title(), ax.get_xlabel()
    return ax[0].figure.get_suptitle(), ax[0].figure.get_supxlabel()


# Normalization


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
    # Whatever is not shown is named.
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


# Gallery


@pytest.mark.parametrize(
    "name, glyph, tag, tag2",
    [
        ("afacad-flux", "a", "wght", None),
        ("afacad-flux", "a", "wght", "slnt"),
        ("roboto-flex", "g", "wdth", "YTDE"),
        ("recursive", "é", "CRSV", None),
        ("dynapuff", "B", "wdth", "wght"),
    ],
)
@pytest.mark.parametrize("count", [2, 4])
def test_gallery_draws_instances_at_its_ticks(name, glyph, tag, tag2, count):
    font = vf.load_font(name)
    others = {} if tag2 or name == "recursive" else {"slnt": 5}
    ax = plot.gallery(font, glyph, tag, tag2, count=count, axes=others)
    xs, ys = (
        {float(label.get_text()): at for at, label in zip(ticks, labels, strict=True)}
        for ticks, labels in (
            (ax.get_xticks(), ax.get_xticklabels()),
            (ax.get_yticks(), ax.get_yticklabels()),
        )
    )
    axis = font.axes[index(font, tag)]
    assert (min(xs), max(xs), len(xs)) == (axis.minimum, axis.maximum, count)
    assert count == 2 or axis.default in xs
    cells = [(x, y) for x in xs for y in ys or [None]]
    assert len(filled(ax)) == len(cells)
    rows = {}
    for patch, (user, user2) in zip(filled(ax), cells, strict=True):
        shown = {tag: user} | ({tag2: user2} if tag2 else {})
        w = font.normalize(others | shown)
        want = vertices(font.glyph(glyph).segments(w))
        shift = patch.get_path().vertices - want
        # The ticks state four digits.
        np.testing.assert_allclose(shift, np.broadcast_to(shift[0], shift.shape), atol=0.1)
        middle = xs[user] - float(font.glyph(glyph).advance(w)) / 2
        assert shift[0, 0] == pytest.approx(middle, abs=0.1)
        rows.setdefault(user2, shift[0, 1])
        assert rows[user2] == pytest.approx(shift[0, 1], abs=0.1)
        at_default = all(font.axes[index(font, t)].default == v for t, v in shown.items())
        assert (to_hex(patch.get_facecolor()) == BLUE) == at_default
    if tag2:
        baselines = [rows[user2] for user2 in sorted(rows)]
        np.testing.assert_allclose(np.diff(baselines), np.diff(sorted(ys.values())), atol=0.2)
        assert (np.diff(baselines) > 0).all()
    assert ("No delta set" in heading(ax)[1]) == (name == "recursive")
    assert ("slnt 5" in heading(ax)[0]) == bool(others)
    # It fits a projector.
    assert ax.figure.get_figheight() <= 5.5
    # Instances keep out of each other's way.
    boxes = [patch.get_path().get_extents() for patch in filled(ax)]
    assert not any(a.overlaps(b) for a, b in combinations(boxes, 2))


def test_overlapping_contours_are_filled():
    inner = [(200, 200), (400, 200), (400, 500), (200, 500)]
    both_ways = {
        "a": fonts.outline(fonts.SQUARE, inner),
        "b": fonts.outline(fonts.SQUARE, inner[::-1]),
    }
    font = vf.load_font(fonts.build(both_ways, {}))
    for glyph, ink in ("a", 0), ("b", 255):
        ax = plot.gallery(font, glyph, "wght", count=2)
        ax.figure.canvas.draw()
        x, y = ax.transData.transform(np.mean(filled(ax)[1].get_path().vertices, 0)).astype(int)
        pixels = np.asarray(ax.figure.canvas.buffer_rgba())
        assert pixels[pixels.shape[0] - y, x, 0] == ink


# Outline


@pytest.mark.parametrize("name", FONTS)
def test_outline_draws_control_points_and_handles(name):
    font = vf.load_font(name)
    glyph, place = font.glyph("g"), some_place(font)
    ax = plot.outline(font, "g", place)
    points = glyph.points(font.normalize(place)).numpy()
    on, off, _ = (np.stack(line.get_data(), -1) for line in ax.lines)
    np.testing.assert_allclose(on, points[::3])
    np.testing.assert_allclose(off, points[np.arange(len(points)) % 3 != 0])
    lines = next(c for c in ax.collections if not isinstance(c, Quiver)).get_segments()
    segments = np.concatenate(glyph.segments(font.normalize(place)))
    np.testing.assert_allclose(lines, segments.reshape(-1, 2, 2))
    for patch in filled(ax):
        want = vertices(glyph.segments(font.normalize(place)))
        np.testing.assert_allclose(patch.get_path().vertices, want)
        codes = list(patch.get_path().codes)
        assert codes.count(Path.MOVETO) == codes.count(Path.CLOSEPOLY) == len(glyph.contours)
        assert codes.count(Path.CURVE4) == 3 * sum(glyph.contours)


@pytest.mark.parametrize("name", FONTS)
def test_outline_samples_have_normals_and_contours_a_direction(name):
    font = vf.load_font(name)
    text = vf.Text(font, "o", axes=some_place(font))
    ax = plot.outline(text, samples=3)
    owners = [
        (contour, segment)
        for contour, s in enumerate(text.glyphs[0].contours)
        for segment in range(s)
    ]

    def position(contour, segment, t):
        return text.position(text.handle(0, contour, segment, t)).numpy()

    middles = [position(*owner, t) for owner in owners for t in (1 / 6, 1 / 2, 5 / 6)]
    tangents = np.array(
        [
            position(*owner, t + 1e-4) - position(*owner, t - 1e-4)
            for owner in owners
            for t in (1 / 6, 1 / 2, 5 / 6)
        ]
    )
    points, normals = arrows(ax, GREEN)
    np.testing.assert_allclose(points, middles)
    np.testing.assert_allclose(np.stack(ax.lines[2].get_data(), -1), middles)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1)
    tangents /= np.linalg.norm(tangents, axis=1)[:, None]
    np.testing.assert_allclose((normals * tangents).sum(1), 0, atol=1e-6)
    points, directions = arrows(ax, VERMILLION)
    for point, direction in zip(points, directions, strict=True):
        k = np.linalg.norm(middles - point, axis=1).argmin()
        np.testing.assert_allclose(point, middles[k])
        np.testing.assert_allclose(direction, tangents[k], atol=1e-6)


@pytest.mark.parametrize("direction", [1, -1])
def test_normals_point_out_of_the_ink(direction):
    font = vf.load_font("afacad-flux")
    contours = [c.numpy() for c in font.glyph("o").segments([0, 0])]
    raw = [[(int(x), int(y)) for x, y in c[::direction, 0]] for c in contours]
    font = vf.load_font(fonts.build({"o": fonts.outline(*raw)}, {}))
    ax = plot.outline(font, "o")
    points, normals = arrows(ax, GREEN)
    rim, hole = (Path(contour) for contour in raw)
    for at, inked in (points - 2 * normals, True), (points + 2 * normals, False):
        assert ((rim.contains_points(at) & ~hole.contains_points(at)) == inked).all()


def test_outline_of_a_text_or_one_of_its_letters():
    text = vf.Text("recursive", "ello", axes={"wght": 800})
    every = [cubics.numpy() for cubics in text.segments()]
    whole = filled(plot.outline(text))[0].get_path().vertices
    np.testing.assert_allclose(whole, vertices(every))
    for letter in "o", 3, text.font.glyph("o").name:
        ax = plot.outline(text, letter)
        np.testing.assert_allclose(filled(ax)[0].get_path().vertices, vertices(every[-2:]))
        assert heading(ax)[0].startswith("letter 3 of “ello”")
    light = filled(plot.outline(text, axes={"wght": 300}))[0].get_path().vertices
    np.testing.assert_allclose(light, vertices(text.at(axes={"wght": 300}).segments()))
    for letter in "a", 4, -1:
        with pytest.raises(vf.GlyphError, match="letters"):
            plot.outline(text, letter)


def test_segments_of_no_length_have_no_normal():
    corner = [*fonts.SQUARE[:2], fonts.SQUARE[1], *fonts.SQUARE[2:]]
    font = vf.load_font(fonts.build({"a": fonts.outline(corner)}, {}))
    points, normals = arrows(plot.outline(font, "a"), GREEN)
    assert len(points) == 4
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1)


# Support functions and scalars


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


# Delta sets


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


# Layout


@pytest.mark.parametrize(
    "text, place",
    [
        (vf.Text("recursive", "word", features={"kern": False}), ""),
        (
            vf.Text("dynapuff", "fj ay", axes={"wght": 700}, features={"kern": False}),
            " at wght 700",
        ),
        (
            vf.Text("afacad-flux", "ab", axes=[{"wght": 900}, {"slnt": 10}], shared=False),
            ", letters with separate axes",
        ),
    ],
    ids=["word", "fj ay", "ab"],
)
def test_layout_draws_origins_bearings_and_advances(text, place):
    ax = plot.layout(text)
    assert heading(ax)[0] == f"“{text.string}” in {text.font.family_name}{place}"
    rows = text.theta.expand(len(text.glyphs), -1)
    advances = [float(g.advance(w)) for g, w in zip(text.glyphs, rows, strict=True)]
    origins = np.cumsum([0, *advances])
    upright = [line.get_xdata()[0] for line in ax.lines if np.ptp(line.get_xdata()) == 0]
    np.testing.assert_allclose(upright, origins)
    np.testing.assert_allclose(filled(ax)[0].get_path().vertices, vertices(text.segments()))
    bands = [band.get_paths()[0].vertices[:, 0] for band in ax.collections]
    labels = [t.get_text() for t in ax.texts if t.get_text()]
    negative = False
    for i, (glyph, w) in enumerate(zip(text.glyphs, rows, strict=True)):
        left, right = (float(side) for side in glyph.side_bearings(w))
        for band, (a, b), side in zip(
            ax.collections[2 * i : 2 * i + 2],
            [(origins[i], origins[i] + left), (origins[i + 1] - right, origins[i + 1])],
            (left, right),
            strict=True,
        ):
            x = band.get_paths()[0].vertices[:, 0]
            assert [x.min(), x.max()] == pytest.approx(sorted([a, b]))
            assert bool(band.get_hatch()) == (band.get_linewidth()[0] > 0) == (side < 0)
            negative |= side < 0
        want = [advances[i], left, right] if glyph.contours else [advances[i]]
        for value in want:
            assert float(labels.pop(0)) == pytest.approx(value, abs=0.51)
    assert (not labels) and len(bands) == 2 * len(rows)
    assert ("hatched" in heading(ax)[1]) == negative


def test_layout_of_a_long_line_leaves_out_its_numbers():
    ax = plot.layout(vf.Text("recursive", "thirteen chars"))
    assert not [t for t in ax.texts if t.get_text()]
    assert "more than 12 letters" in heading(ax)[1]
    with pytest.raises(TypeError, match="must be a Text"):
        plot.layout("word")


# The Jacobian and what axes do


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
                beside = w.copy()
                beside[i] += sign * 1e-5
                if low[i] <= beside[i] <= high[i]:
                    motion[colour] = (glyph.points(beside).numpy()[::3] - here) / 1e-5
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


# What holds for all


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
    with pytest.raises(TypeError, match="matplotlib Axes"):
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
    with pytest.raises(vf.VFWidgetError, match="at least 2"):
        plot.gallery(font, "a", "wght", count=1)
    assert plt.get_fignums() == []
