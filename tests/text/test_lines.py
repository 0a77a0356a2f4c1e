"""Lines of a text: how they are separated, what they are called, and how wide they are."""

from __future__ import annotations

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
