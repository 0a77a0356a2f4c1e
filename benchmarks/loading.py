"""Unpacking all glyphs of a font, compared with fontTools, which merely draws them at one location.

Both read the same glyphs of a freshly opened file, in small groups that take turns. The times are
processor times, and each is the minimum of the rounds.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from importlib import import_module, resources
from importlib.util import find_spec
from pathlib import Path
from time import process_time
from typing import Any

from fontTools.pens.basePen import NullPen

import vfwidget as vf
from vfwidget.font.source import open_font

from .table import Row, milliseconds

GROUPS = 10
"""Groups of glyphs that both sides read by turns."""
MOST_GLYPHS = 500
"""Glyphs that are read of a large font, spread over all."""
CJK = "manimgx_fonts_cjk"
"""A package that brings Noto Sans CJK, a collection of fonts with 65,535 glyphs in CFF2."""


def sources() -> Iterator[tuple[str, str, bytes]]:
    """The name of each font, its format, and its file."""
    package = resources.files("vfwidget") / "fonts"
    for name in vf.bundled_fonts():
        yield name, "glyf", (package / f"{name}.woff2").read_bytes()
    spec = find_spec(CJK)
    if spec and spec.origin:
        file = Path(spec.origin).parent / "NotoSansCJK-VF.otf.ttc"
        yield "Noto Sans CJK", "CFF2", file.read_bytes()
    # The builders of small fonts import one another as the tests do.
    sys.path.append(str(Path(__file__).parents[1] / "tests"))
    yield "made up", "CFF2", import_module("formats").random_cff2()
    yield "made up", "VARC", import_module("varc_fonts").varc()


def seconds(data: bytes) -> tuple[float, float]:
    """Processor time for one glyph of ours, which unpacks it, and of fontTools, which draws it."""
    font, opened = vf.load_font(data), open_font(data)
    place = {axis.tag: (axis.minimum + axis.maximum) / 2 for axis in font.axes}
    drawn = opened.getGlyphSet(location=place)
    names = font.glyph_names[:: len(font) // MOST_GLYPHS or 1]
    ours = theirs = 0.0
    for group in (names[i::GROUPS] for i in range(GROUPS)):
        ours += _timed(font.glyph, group)
        theirs += _timed(lambda name: drawn[name].draw(NullPen()), group)
    return ours / len(names), theirs / len(names)


def _timed(read: Callable[[str], Any], names: Sequence[str]) -> float:
    begun = process_time()
    for name in names:
        read(name)
    return process_time() - begun


def run(quick: bool) -> Iterator[Row]:
    """Compare each font."""
    for name, form, data in sources():
        seconds(data)
        rounds = [seconds(data) for _ in range(2 if quick else 8)]
        ours, theirs = map(min, zip(*rounds, strict=True))
        yield Row(
            benchmark="loading",
            case=f"{name}, {form}",
            ours=milliseconds(1e3 * ours),
            baseline=f"fontTools {milliseconds(1e3 * theirs)}",
            ratio=f"{ours / theirs:.2f}×",
            notes="a glyph; the ratio is our time divided by that of fontTools",
        )
