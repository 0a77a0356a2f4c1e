"""Figures of instances, outlines and layouts show what the library computes."""

from __future__ import annotations

from itertools import combinations

import fonts
import numpy as np
import pytest
from figures import (
    BLUE,
    FONTS,
    GREEN,
    VERMILLION,
    arrows,
    filled,
    heading,
    index,
    some_place,
    vertices,
)
from matplotlib.colors import to_hex
from matplotlib.path import Path
from matplotlib.quiver import Quiver

import vfwidget as vf
from vfwidget import plot


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
    with pytest.raises(vf.TextError, match="must be a Text"):
        plot.layout("word")


def test_a_mark_has_no_advance_in_the_figure_of_a_layout():
    """Its glyph has a width in the font, by which the next letter does not move."""
    text = vf.Text("roboto-flex", "x\u0309n")
    mark = text.layout[1]
    assert mark.advance == 0 and mark.glyph.advance(text.theta[0]) > 500
    ax = plot.layout(text)
    arrows = [note for note in ax.texts if not note.get_text()]
    ends = sorted((note.xyann[0], note.xy[0]) for note in arrows)
    letters = [record for record in text.layout if record.advance]
    assert ends == [pytest.approx((r.x, r.x + r.advance)) for r in letters]
    right = float(mark.glyph.side_bearings(text.theta[0])[1] - mark.glyph.advance(text.theta[0]))
    band = ax.collections[3].get_paths()[0].vertices[:, 0]
    assert [band.min(), band.max()] == pytest.approx([mark.x, mark.x - right])
