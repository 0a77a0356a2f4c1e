"""Fonts of many scripts against HarfBuzz, as a table: ``python tests/layout_table.py``.

The command measures 20 words at 8 locations in every font, with the default features and without
kerning, which takes some minutes, and writes ``docs/layout.md``. The slow tests measure a sample.
"""

from __future__ import annotations

import functools
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np
import registry_fonts
from referee import Typesetter

import vfwidget as vf
from vfwidget.errors import VFWidgetError
from vfwidget.font.source import open_font

F2DOT14 = 16384
NO_KERNING = {"kern": False}
PLACES = 8
TARGET = Path(__file__).parents[1] / "docs" / "layout.md"
HEAD = f"""# Layout against HarfBuzz

Each row compares 20 words at {PLACES} locations of a font's design space with HarfBuzz: the glyphs,
and their positions and advances. The last columns give the largest difference of a number in
thousandths of the em, with the default features and with kerning off. HarfBuzz receives the same
unrounded advance widths as vfwidget and works at a scale of 1024 steps a font unit. The column
"Whole units" compares with HarfBuzz at its own settings, which round advance widths to whole font
units.

HarfBuzz places the marks of a font without GPOS by the extents of outlines, which it rounds to font
units. vfwidget does not round them. At some locations another point of the outline may be the
extreme one. vfwidget compares several hundred locations, and refuses a text in which a mark stands
more than a thousandth of the em from its position in HarfBuzz, or more than half of that without
rounding.

This command repeats the measurement: `python tests/layout_table.py`.

| Font | Texts | Wrong glyphs | Refused | Default features | Kerning off | Whole units |
| --- | ---: | ---: | ---: | ---: | ---: | ---: |
"""


class Measured(NamedTuple):
    """How a font's layout compares with HarfBuzz.

    Attributes
    ----------
    count, wrong, refused : int
        Texts that were compared, those with a wrong glyph, and words that were refused.
    worst, rounded : float
        Largest difference in ‰ of the em: with exact advance widths, and with rounded ones.
    """

    count: int
    wrong: int
    refused: int
    worst: float
    rounded: float


@functools.cache
def setters(name: str) -> tuple[vf.Font, Typesetter]:
    return vf.load_font(name), Typesetter(open_font(name))


def locations(font: vf.Font, count: int, seed: int = 5) -> np.ndarray:
    """Locations that HarfBuzz does not round: two random ones of three, and ends of axes."""
    rng = np.random.default_rng(seed)
    lower, upper = font.bounds
    uniform = rng.uniform(lower, upper, (count, len(lower)))
    ends = rng.choice([-1.0, 0.0, 1.0], uniform.shape).clip(lower, upper)
    mixed = np.where(rng.random(uniform.shape) < 1 / 3, ends, uniform)
    return np.round(mixed * F2DOT14) / F2DOT14


def difference(text: vf.Text, expected: list) -> float:
    """The largest difference of an origin or an advance, ‰ of the em; infinite for other glyphs."""
    found = text.layout
    if [(r.glyph_id, r.cluster) for r in found] != [row[:2] for row in expected]:
        return float("inf")
    ours = np.array([(r.x, r.y, r.advance) for r in found])
    theirs = np.array([row[2:] for row in expected])
    return float(1000 * np.abs(ours - theirs).max() / text.font.units_per_em)


def measure(name: str, words: list[str], places: int, features: dict | None) -> Measured:
    """Compare words at some locations of a font."""
    font, setter = setters(name)
    count = wrong = refused = 0
    worst = rounded = 0.0
    for word in words:
        try:
            text = vf.Text(font, word, features=features)
            texts = [text.at(theta=w) for w in locations(font, places)]
        except VFWidgetError as error:
            print(f"{name} {word}: {error}", file=sys.stderr)
            refused += 1
            continue
        for moved in texts:
            w = moved.theta.numpy()[0]
            off = difference(moved, setter.line(word, w, features))
            count += 1
            wrong += off == float("inf")
            if off < float("inf"):
                worst = max(worst, off)
                whole = setter.line(word, w, features, rounded=True)
                rounded = max(rounded, difference(moved, whole))
    return Measured(count, wrong, refused, worst, rounded)


def main() -> None:
    rows = []
    files = {name: (name, registry_fonts.LATIN) for name in vf.bundled_fonts()}
    files |= {
        file.partition("/")[2]: (str(registry_fonts.path(file)), registry_fonts.words(file))
        for file in registry_fonts.FILES
    }
    for label, (name, words) in files.items():
        kerned, plain = (measure(name, words, PLACES, f) for f in (None, NO_KERNING))
        cells = [
            label,
            f"{kerned.count}",
            f"{kerned.wrong + plain.wrong}",
            f"{kerned.refused + plain.refused}",
            *(f"{one.worst:.4f}" for one in (kerned, plain)),
            f"{kerned.rounded:.2f}",
        ]
        rows.append("| " + " | ".join(cells) + " |")
        print(rows[-1], flush=True)
    TARGET.write_text(HEAD + "\n".join(rows) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
