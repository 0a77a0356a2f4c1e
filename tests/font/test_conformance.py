"""The table of docs/conformance.md, by fewer glyphs and places."""

from __future__ import annotations

import conformance
import pytest


@pytest.mark.parametrize("build", conformance.MADE_UP)
def test_formats_made_up_agree_with_harfbuzz(build):
    covers = conformance.MADE_UP[build]
    row = conformance.compare(build.__name__, covers, build(), glyphs=2, count=12)
    assert row.holds, row


@pytest.mark.slow
def test_every_font_of_the_table_agrees_with_harfbuzz():
    rows = [
        conformance.compare(name, covers, read(), glyphs=4, count=40)
        for name, covers, read in conformance.sources()
    ]
    rows = [row for row in rows if row]
    assert len(rows) >= 15
    assert [str(row) for row in rows if not row.holds] == []
