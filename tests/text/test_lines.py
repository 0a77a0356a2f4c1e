"""Lines of a text: how they are separated, how wide they are, and where tracking adds space."""

from __future__ import annotations

import fonts
import numpy as np
import pytest

import vfwidget as vf


@pytest.mark.parametrize("ending", ["\r\n", "\r", "\n"], ids=ascii)
def test_every_usual_line_ending_separates_lines(ending: str) -> None:
    """Recursive has a glyph for the carriage return that is as wide as a letter."""
    text = vf.Text("recursive", f"AV{ending}{ending}x{ending}")
    placed = [(r.glyph.name, r.cluster, r.x) for r in text.layout]
    assert placed[::2] == [("A", 0, 0), ("x", 2 + 2 * len(ending), 0)]
    assert text.layout[2].y == 2 * (text.font.descender - text.font.ascender)
    assert text.advance() == vf.Text("recursive", "AV").advance()


def test_the_last_letter_of_a_line_has_its_character_as_its_name() -> None:
    text = vf.Text("roboto-flex", "ab\r\nc\n")
    assert [text.handle(i).letter_name for i in range(3)] == ["a", "b", "c"]


@pytest.mark.parametrize("string", ["\nAV", "AV\n\nAV", "AV\n"], ids=ascii)
def test_a_line_without_letters_has_no_width_to_reach(string: str) -> None:
    text = vf.Text("afacad-flux", string)
    wanted = text.advance() + 30
    found = vf.solve(text, vf.Width(wanted))
    assert found.status == "converged"
    assert found.text.advance() == pytest.approx(wanted, abs=0.1)


@pytest.mark.parametrize("number", [np.float32(30), np.float16(30), np.int8(30)], ids=repr)
def test_lengths_may_be_numbers_of_numpy(number) -> None:
    text = vf.Text("recursive", "a\nb", tracking=number, line_height=number)
    assert (text.tracking, text.layout[1].y) == (30, -30)


def devanagari() -> vf.Font:
    """A consonant, a vowel that is drawn before it, one drawn after it, and a combining mark."""
    letters = {0x915: "ka", 0x93F: "i", 0x93E: "aa", 0x902: "dot"}

    def edit(builder) -> None:
        builder.setupCharacterMap(letters)
        builder.addOpenTypeFeatures(
            "languagesystem dev2 dflt; feature abvs { sub ka by ka; } abvs;"
            "table GDEF { GlyphClassDef [ka i aa], , [dot], ; } GDEF;"
        )

    glyphs = {name: fonts.outline(fonts.SQUARE) for name in letters.values()}
    return vf.load_font(fonts.build(glyphs, {}, edit=edit, metrics={"dot": (0, 100)}))


def test_tracking_adds_no_space_within_a_syllable() -> None:
    """A browser adds it after each grapheme cluster (CSS Text, "letter-spacing")."""
    plain = vf.Text(devanagari(), "\u0915\u093f\u0902\u0915\u093e\u0902\n\u0915\u0915\u093e")
    loose = plain.at(tracking=70)
    pairs = list(zip(plain.layout, loose.layout, strict=True))
    assert [(a.glyph.name, b.x - a.x, b.advance - a.advance) for a, b in pairs] == [
        ("i", 0, 0),
        ("ka", 0, 0),
        ("dot", 0, 70),
        ("ka", 70, 0),
        ("aa", 70, 0),
        ("dot", 70, 70),
        ("ka", 0, 70),
        ("ka", 70, 0),
        ("aa", 70, 70),
    ]
    assert loose.advance() - plain.advance() == 140
