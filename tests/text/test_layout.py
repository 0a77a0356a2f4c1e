"""Where letters stand: HarfBuzz as referee, and derivatives against differences."""

from __future__ import annotations

import json
import warnings

import fonts
import formats
import numpy as np
import pytest
import registry_fonts
from fontTools.varLib.featureVars import addFeatureVariations
from layout_table import NO_KERNING, difference, locations, measure, setters
from referee import Typesetter

import vfwidget as vf
from vfwidget.outline.cubics import bernstein

WORDS = ["AVATAR Toy.", "Wave «fig»", "fjord 1,750 $k", "e\u0301x\u0301y\u0308z", "T.V. LTÝo"]


@pytest.mark.parametrize("features", [None, NO_KERNING], ids=["kerned", "not kerned"])
@pytest.mark.parametrize("name", vf.bundled_fonts())
def test_letters_stand_where_harfbuzz_puts_them(name: str, features: dict | None) -> None:
    font, setter = setters(name)
    for word in WORDS:
        text = vf.Text(font, word, features=features)
        for w in locations(font, 8):
            expected = setter.line(word, w, features)
            # HarfBuzz gives multiples of 1/1024 of a font unit, for each letter.
            assert difference(text.at(theta=w), expected) < 0.02


@pytest.mark.slow
@pytest.mark.parametrize("file", registry_fonts.FILES)
def test_every_script_stands_where_harfbuzz_puts_it(file: str) -> None:
    """A sample of the words; ``python tests/layout_table.py`` measures all of them."""
    path, words = str(registry_fonts.path(file)), registry_fonts.words(file)
    for features, sample in ((None, words[::7]), (NO_KERNING, words[3::14])):
        found = measure(path, sample, 4, features)
        assert (found.count, found.wrong, found.refused) == (4 * len(sample), 0, 0)
        assert found.worst < 0.02


# Derivatives


def differences(text: vf.Text, theta: np.ndarray, step: float) -> np.ndarray:
    """Central differences of all control points by Θ."""
    columns = []
    for i in range(theta.size):
        move = np.zeros(theta.size)
        move[i] = step
        move = move.reshape(theta.shape)
        columns.append((text.points(theta + move) - text.points(theta - move)).numpy() / (2 * step))
    return np.stack(columns, -1).reshape(*columns[0].shape, *theta.shape)


@pytest.mark.parametrize("shared", [True, False])
@pytest.mark.parametrize("name", ["recursive", "roboto-flex", "afacad-flux"])
def test_derivatives_with_kerning(name: str, shared: bool) -> None:
    text = vf.Text(name, "AVTo\nx\u0301Ly", shared=shared, tracking=13)
    lower, upper = text.font.bounds
    rng = np.random.default_rng(3)
    theta = rng.uniform(lower + 1e-3, np.maximum(upper - 1e-3, lower + 1e-3), text.theta.shape)
    jacobian = text.jacobian(theta).numpy()
    expected = differences(text, theta, 1e-6)
    assert np.abs(jacobian - expected).max() < 1e-6 * np.abs(expected).max()


def kerned(features: str, axes=(fonts.WEIGHT,), deltas=None) -> vf.Font:
    glyphs = {c: fonts.outline(fonts.SQUARE) for c in "abn"}
    glyphs["mark"] = fonts.outline([(-50, 550), (50, 550), (50, 700), (-50, 700)])

    def edit(builder) -> None:
        builder.setupCharacterMap({**{ord(c): c for c in "abn"}, 0x301: "mark"})
        builder.addOpenTypeFeatures(features)

    data = fonts.build(glyphs, deltas or {}, axes=axes, edit=edit, metrics={"mark": (0, -50)})
    return vf.load_font(data)


KERN = "languagesystem DFLT dflt; feature kern { pos a b (wght=400:-50 wght=900:-150); } kern;"
MARK = """
    languagesystem DFLT dflt;
    markClass mark <anchor 0 (wght=400:500 wght=900:700)> @top;
    feature mark {
        pos base n <anchor (wght=400:300 wght=900:400) (wght=400:500 wght=900:700)> mark @top;
    } mark;
    table GDEF { GlyphClassDef [n a b], , [mark], ; } GDEF;
"""


def test_a_kern_has_kinks_of_its_own() -> None:
    text = vf.Text(kerned(KERN), "ab")
    for w, right, left in ((0.0, -100.0, 0.0), (0.5, -100.0, -100.0)):
        for side, slope in ((0.0, right), (-1e-8, left)):
            jacobian = text.jacobian([[w + side]]).numpy()
            assert jacobian[:12, 0].ravel() == pytest.approx(0)
            assert jacobian[12:, 0].ravel() == pytest.approx(slope)
    assert 0 in text.breakpoints[0]


def test_letters_with_axes_of_their_own_share_a_kern() -> None:
    """The kern is the mean of -50 at the default and of -150 at the end of the axis."""
    text = vf.Text(kerned(KERN), "ab", shared=False)
    for theta, kern in (([0, 0], -50), ([1, 1], -150), ([1, 0], -100), ([0, 1], -100)):
        placed = text.at(theta=np.reshape(theta, (2, 1))).layout
        assert placed[1].x == pytest.approx(600 + kern)


@pytest.mark.parametrize("shared", [True, False])
def test_an_advance_reaches_the_next_letter(shared: bool) -> None:
    text = vf.Text("afacad-flux", "AVATo", shared=shared, tracking=10)
    for theta in np.random.default_rng(2).uniform(*text.font.bounds, (4, *text.theta.shape)):
        moved = text.at(theta=theta)
        ends = [*(record.x for record in moved.layout[1:]), moved.advance()]
        assert ends == pytest.approx([record.x + record.advance for record in moved.layout])


def test_a_mark_follows_its_anchor() -> None:
    text = vf.Text(kerned(MARK), "n\u0301a")
    for wght, x, y in ((400, 300, 0), (900, 400, 0), (650, 350, 0)):
        base, mark, after = text.at({"wght": wght}).layout
        assert (mark.x, mark.y) == pytest.approx((x, y))
        assert (base.x, mark.advance, after.x) == pytest.approx((0, 0, 600))


@pytest.mark.parametrize(
    "hidden, direction",
    [
        ("\u034f", None),
        ("\xad", None),
        ("\u2060\u200b", None),
        ("\u034f", "rtl"),
        ("\ufe0f", "rtl"),
    ],
    ids=ascii,
)
def test_an_invisible_character_does_not_push_a_mark_away(hidden, direction) -> None:
    """Hebrew has U+034F between two vowels. Fonts that lack it would draw a box for it."""
    font = kerned(MARK)
    for before, after in ("n", "\u0301a"), ("an\u0301", "an\u0301"), ("an", f"{hidden}\u0301n"):
        string = before + hidden + after
        if direction:
            string = f"\u202e{string}\u202c"
        for wght in 400, 900:
            text, plain = (
                vf.Text(font, one, {"wght": wght}, direction=direction, script="Latn")
                for one in (string, string.replace(hidden, ""))
            )
            found = [(r.glyph_id, r.x, r.y, r.advance) for r in text.layout]
            assert found == [(r.glyph_id, r.x, r.y, r.advance) for r in plain.layout]


def test_a_mark_with_axes_of_its_own_stays_between_the_anchors() -> None:
    text = vf.Text(kerned(MARK), "n\u0301a", shared=False)
    _, mark, after = text.at(theta=[[1.0], [0.0], [0.0]]).layout
    assert (mark.x, mark.y) == pytest.approx((350, 0))
    assert after.x == pytest.approx(600)


def test_cursive_letters_are_joined() -> None:
    font = kerned(
        """
        languagesystem DFLT dflt;
        feature curs { pos cursive a <anchor 50 0> <anchor 300 (wght=400:0 wght=900:80)>;
                       pos cursive b <anchor 50 0> <anchor 300 0>; } curs;
        """
    )
    text = vf.Text(font, "ab").at({"wght": 900})
    assert [(r.x, r.y) for r in text.layout] == [(0, 0), (250, 80)]
    assert text.advance() == 850


def test_marks_without_anchors_stand_over_the_letter() -> None:
    """Without GPOS HarfBuzz centres a mark by the extents of the outlines, in whole units."""
    glyphs = {"a": fonts.outline(fonts.SQUARE)}
    glyphs["mark"] = fonts.outline([(-40, 550), (60, 550), (60, 700), (-40, 700)])
    wider = [(-40, 0), (60, 0), (60, 30), (-40, 30), (0, 0), (80, 0), (0, 0), (0, 0)]
    taller = [(-10, 0), (30, 0), (30, 10), (-10, 10), *fonts.STILL]

    def edit(builder) -> None:
        builder.setupCharacterMap({ord("a"): "a", 0x301: "mark"})

    data = fonts.build(
        glyphs,
        {"a": [(fonts.BOLD, wider)], "mark": [(fonts.WIDE, taller)]},
        edit=edit,
        metrics={"mark": (0, -40)},
    )
    text, setter = vf.Text(data, "a\u0301"), Typesetter(fonts.open_font(data))
    for w in locations(text.font, 20):
        assert difference(text.at(theta=w), setter.line("a\u0301", w)) < 1.5


def test_a_mark_without_a_base_stands_ahead_of_the_pen_where_the_font_has_no_anchors() -> None:
    glyphs = {"a": fonts.outline(fonts.SQUARE), "mark": fonts.outline(fonts.SQUARE)}
    wider = [*[(0, 0)] * 4, (0, 0), (80, 0), (0, 0), (0, 0)]

    def edit(builder) -> None:
        builder.setupCharacterMap({ord("a"): "a", 0x301: "mark"})

    data = fonts.build(glyphs, {"mark": [(fonts.BOLD, wider)]}, edit=edit)
    for string in "\u0301", "\u0301a", "a\n\u0301aa":
        text, setter = vf.Text(data, string), Typesetter(fonts.open_font(data))
        for w in locations(text.font, 6):
            records = text.at(theta=w).layout
            line = setter.line(string.rpartition("\n")[2], w)
            found = [(r.x, r.advance) for r in records][-len(line) :]
            assert found == [(pytest.approx(x, abs=0.6), pytest.approx(d, abs=0.6))
                             for *_, x, _, d in line]  # fmt: skip


# Lines, tracking and width


def test_lines_stand_below_one_another() -> None:
    text = vf.Text("recursive", "AV\n\nx", line_height=1000)
    assert [(r.cluster, r.x, r.y) for r in text.layout][::2] == [(0, 0, 0), (4, 0, -2000)]
    first, second = vf.Text("recursive", "AV"), vf.Text("recursive", "x")
    assert text.advance() == max(first.advance(), second.advance())
    default = vf.Text("recursive", "A\nV")
    assert default.layout[1].y == default.font.descender - default.font.ascender


def test_tracking_adds_space_after_each_letter() -> None:
    font = kerned(MARK)
    loose = vf.Text(font, "n\u0301a", tracking=70)
    plain = loose.at(tracking=0)
    assert (plain.tracking, loose.tracking) == (0, 70)
    moved = [b.x - a.x for a, b in zip(plain.layout, loose.layout, strict=True)]
    assert moved == [0, 0, 70]
    assert loose.advance() - plain.advance() == 140
    shift = (loose.points() - plain.points()).numpy()
    assert shift[:, 0].tolist() == [0] * 24 + [70] * 12


def test_the_width_of_a_line_counts_kerning_and_tracking() -> None:
    text = vf.Text("afacad-flux", "AVAToy", tracking=20)
    wanted = text.advance() + 200
    found = vf.solve(text, [vf.Width(wanted), vf.StayClose()])
    assert found.converged and found.text.advance() == pytest.approx(wanted, abs=0.5)


def test_tracking_can_be_an_unknown() -> None:
    text = vf.Text("recursive", "AVAToy")
    wanted = text.advance() + 120
    found = vf.solve(text, vf.Width(wanted), free=["tracking"])
    assert found.text.tracking == pytest.approx(20)
    assert found.text.axes == text.axes


# Glyphs that change


def test_a_text_takes_the_glyphs_of_its_location() -> None:
    text = vf.Text("recursive", "king")
    cursive = text.at({"CRSV": 1})
    assert text.layout[0].glyph.name == "k"
    assert cursive.layout[0].glyph.name == "k.italic"
    assert cursive.at({}).word is text.word


def test_each_letter_takes_the_glyph_of_its_own_location() -> None:
    text = vf.Text("recursive", "kkk", shared=False)
    moved = text.at([{}, {"CRSV": 1}, {}])
    assert [glyph.name for glyph in moved.glyphs] == ["k", "k.italic", "k"]
    assert moved.layout[2].x > moved.layout[1].x > 0


def test_letters_with_axes_of_their_own_are_joined_as_at_the_default() -> None:
    text = vf.Text("recursive", "fig", shared=False)
    rows = text.composition.settings.rows
    assert {len(row.glyph_ids) for row in rows} == {2, 3}
    for w in locations(text.font, 20):
        assert len(text.at(theta=np.tile(w, (3, 1))).glyphs) == 3


@pytest.mark.parametrize("value", [float("nan"), "1", None, True, float("inf")], ids=repr)
def test_bad_tracking_and_line_heights(value) -> None:
    for name in ("tracking", "line_height"):
        if (name, value) != ("line_height", None):
            with pytest.raises(vf.TextError, match=f"{name} must be a finite number"):
                vf.Text("recursive", "a", **{name: value})


def test_positions_that_the_font_does_not_explain_are_refused(monkeypatch) -> None:
    font = kerned(KERN)
    monkeypatch.setattr(vf.font.font.Font, "positioning_support", np.zeros((0, 1, 3)))
    with pytest.raises(vf.TextError, match="variation data do not state"):
        vf.Text(font, "ab")


@pytest.mark.parametrize("space", ["\u2007", "\u2008"], ids=ascii)
def test_spaces_as_wide_as_another_glyph_are_refused(space: str) -> None:
    """HarfBuzz gives a space that the font lacks the width of a figure or of a full stop."""
    with pytest.raises(vf.TextError, match="spaces of the width of another character"):
        vf.Text("roboto-flex", f"A{space}V")
    assert len(vf.Text("roboto-flex", "A\u2009V\u202fA").layout) == 5


# Handles in another setting


def test_a_handle_keeps_its_parameter_where_contours_correspond() -> None:
    text = vf.Text("roboto-flex", "a$")
    heavy = text.at({"wght": 1000})
    handle = text.handle(0, 0, 3, 0.25)
    assert heavy.word is not text.word
    carried = heavy.carry(handle)
    assert (carried.glyph, carried.contour, carried.segment, carried.t) == (0, 0, 3, 0.25)
    assert heavy.position(handle).tolist() == heavy.position(carried).tolist()
    assert heavy.carry(carried) == carried


def test_a_handle_keeps_its_point_where_a_contour_starts_elsewhere() -> None:
    """The alternate s of a font in the registry has its segments, but starts half way round."""
    bowl = fonts.BOWL
    turned = [(x + 20, y, *on) for x, y, *on in (*bowl[3:], *bowl[:3])]

    def edit(builder) -> None:
        builder.setupCharacterMap({ord("a"): "a"})
        variations = [([{"wght": (0.5, 1)}], {"a": "b"})]
        addFeatureVariations(builder.font, variations, "rvrn")

    glyphs = {"a": fonts.outline(bowl, fonts.SQUARE), "b": fonts.outline(turned, fonts.SQUARE)}
    text = vf.Text(fonts.build(glyphs, {}, axes=(fonts.WEIGHT,), edit=edit), "a")
    bold = text.at({"wght": 900})
    assert bold.glyphs[0].name == "b" and bold.glyphs[0].contours == text.glyphs[0].contours
    for contour, shift in ((0, 20), (1, 0)):
        for segment in range(text.glyphs[0].contours[contour]):
            handle = text.handle(0, contour, segment, 0.25)
            found = bold.position(handle) - text.position(handle)
            assert found.tolist() == pytest.approx([shift, 0])
            assert text.carry(bold.carry(handle)) == handle


def test_a_handle_goes_to_the_nearest_point_of_another_glyph() -> None:
    text = vf.Text("recursive", "ok")
    at = {"CRSV": 1, "wght": 500}
    cursive, upright = text.at(at), text.at({"wght": 500})
    before, after = upright.glyphs[1], cursive.glyphs[1]
    assert before.contours != after.contours
    handle = upright.handle(1, 0, 2, 0.5)
    carried = cursive.carry(handle)
    # The point does not depend on where the text stands, so that a drag does not slide along.
    w = np.zeros(5)
    old = bernstein(0.5) @ before.segments(w)[0][2].numpy()
    outline = np.concatenate([contour.numpy() for contour in after.segments(w)])
    samples = (bernstein(np.linspace(0, 1, 801)).T @ outline).reshape(-1, 2)
    new = bernstein(carried.t) @ after.segments(w)[carried.contour][carried.segment].numpy()
    assert np.hypot(*(new - old)) <= np.hypot(*(samples - old).T).min() + 1e-4
    # Everything that takes a handle takes that of another setting as well.
    assert cursive.owns(handle)
    assert cursive.position(handle).tolist() == cursive.position(carried).tolist()


def test_a_letter_that_joins_another_takes_no_handle_along() -> None:
    text = vf.Text("recursive", "fig")
    places = [text.at(theta=w) for w in locations(text.font, 40)]
    joined = next(t for t in places if len(t.glyphs) == 2)
    parted = next(t for t in places if len(t.glyphs) == 3)
    with pytest.raises(vf.GlyphError, match="i is not a letter by itself there"):
        joined.carry(parted.handle(1))
    assert parted.carry(joined.handle(1)).glyph == 2


@pytest.mark.skipif(not formats.CONFORMANCE.is_dir(), reason="the conformance data are not here")
def test_text_rendering_tests_of_unicode() -> None:
    """Origins and advances of all their cases with TrueType outlines, in thousandths of the em."""
    cases = json.loads((formats.CONFORMANCE / "text-rendering-tests.json").read_text("utf-8"))
    wrong = []
    for case in cases:
        file = formats.CONFORMANCE / "trt-fonts" / case["font"]
        if file.suffix == ".otf":
            continue
        font = vf.load_font(file)
        tags = {axis.tag for axis in font.axes}
        axes = {tag: value for tag, value in case["variations"].items() if tag in tags}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", vf.AxisWarning)
            text = vf.Text(font, case["text"], axes=axes)
        scale = 1000 / font.units_per_em
        found = [(scale * r.x, scale * r.y) for r in text.layout]
        expected = [(glyph["x"], glyph["y"]) for glyph in case["glyphs"]]
        off = np.abs(np.subtract(found, expected)).max()
        if max(off, abs(scale * text.advance() - case["advance"])) > 2:
            wrong.append(case["id"])
    assert not wrong
