"""Marks that HarfBuzz places by the extents of outlines, because the font's GPOS is not used."""

from __future__ import annotations

import fonts
import formats
import pytest
from layout_table import difference, locations
from referee import Typesetter

import vfwidget as vf

ALEF, QAMATS, DAGESH = "\u05d0", "\u05b8", "\u05bc"
KERN = "feature kern {{ script {script}; pos alef alef -50; }} kern;"


def hebrew(script: str) -> bytes:
    """A letter that widens, and two marks of which one grows, with kerning for one script."""
    glyphs = {"alef": fonts.outline(fonts.SQUARE)}
    for name in ("qamats", "dagesh"):
        glyphs[name] = fonts.outline([(-40, 550), (60, 550), (60, 700), (-40, 700)])
    wider = [(-40, 0), (60, 0), (60, 30), (-40, 30), (0, 0), (80, 0), (0, 0), (0, 0)]
    taller = [(-10, 0), (30, 0), (30, 10), (-10, 10), *fonts.STILL]

    def edit(builder) -> None:
        names = zip((ALEF, QAMATS, DAGESH), ("alef", "qamats", "dagesh"), strict=True)
        builder.setupCharacterMap({ord(c): name for c, name in names})
        builder.addOpenTypeFeatures(KERN.format(script=script))

    return fonts.build(
        glyphs,
        {"alef": [(fonts.BOLD, wider)], "qamats": [(fonts.WIDE, taller)]},
        edit=edit,
        metrics={"qamats": (0, -40), "dagesh": (0, -40)},
    )


@pytest.mark.parametrize("script", ["latn", "hebr"])
def test_hebrew_in_a_font_whose_gpos_has_or_lacks_hebrew(script: str) -> None:
    """HarfBuzz uses GPOS for Hebrew only if the table has this script."""
    data = hebrew(script)
    string = ALEF + QAMATS + ALEF + DAGESH + QAMATS
    text, setter = vf.Text(data, string), Typesetter(fonts.open_font(data))
    for w in locations(text.font, 20):
        expected = setter.line(string, w)
        assert any(y for *_, y, _ in expected) == (script == "latn")
        # HarfBuzz takes the extents, and the referee the advances, in whole units.
        assert difference(text.at(theta=w), expected) < 1.5


def test_damaged_outlines_are_told_when_they_are_needed(monkeypatch: pytest.MonkeyPatch) -> None:
    font = vf.load_font(hebrew("latn"))
    reader = type(font._ttfont.reader)
    read = reader.__getitem__

    def broken(self: object, tag: str) -> bytes:
        if tag == "glyf":
            raise ValueError("no bytes")
        return read(self, tag)

    monkeypatch.setattr(reader, "__getitem__", broken)
    with pytest.raises(vf.FontError, match=r"outlines are damaged .*no bytes"):
        vf.Text(font, ALEF + QAMATS)
    monkeypatch.undo()
    assert vf.Text(font, ALEF + QAMATS).layout[0].y != 0


def test_marks_over_cubic_outlines_without_gpos() -> None:
    grows = [40] * len(formats.REGIONS)
    across = [400, *grows, 1, "blend", "hlineto"]
    back = [-400, *(-x for x in grows), 1, "blend", "hlineto"]
    data = formats.cff2(
        {
            "a": [100, 0, "rmoveto", *across, 700, "vlineto", *back],
            "\u0301": [-40, 550, "rmoveto", 100, "hlineto", 150, "vlineto", -100, "hlineto"],
        }
    )
    text, setter = vf.Text(data, "a\u0301"), Typesetter(fonts.open_font(data))
    for w in locations(text.font, 20):
        expected = setter.line("a\u0301", w)
        assert expected[1][3] != 0
        assert difference(text.at(theta=w), expected) < 1.5


def test_a_mark_that_cannot_follow_the_extents_is_named() -> None:
    """From some weight on, another point of the letter is its lowest."""
    base, still = fonts.SQUARE, [(0, 0)] * 4
    glyphs = {"a": fonts.outline(base, [(200, 100), (300, 100), (300, 300), (200, 300)])}
    glyphs["dot"] = fonts.outline([(-40, -150), (60, -150), (60, -50), (-40, -50)])
    lower = [*still, *[(0, -300)] * 4, *fonts.STILL]

    def edit(builder) -> None:
        builder.setupCharacterMap({ord("a"): "a", 0x323: "dot"})

    data = fonts.build(glyphs, {"a": [(fonts.BOLD, lower)]}, edit=edit, metrics={"dot": (0, -40)})
    with pytest.raises(vf.TextError, match=r"glyph .dot. .*character 1.* no anchors"):
        vf.Text(data, "a\u0323")
