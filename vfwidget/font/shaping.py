"""From a string to rows of glyphs with their positions, by HarfBuzz."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from itertools import groupby
from threading import Lock, RLock, current_thread, main_thread
from typing import Any

import numpy as np
import uharfbuzz as hb
from fontTools import unicodedata
from fontTools.ttLib import TTFont

from ..arrays import Array
from ..errors import GlyphError, TextError
from .bidi import Run, direction_runs
from .shaping_options import ShapingOptions
from .source import damage

TABLES = (
    *("head", "maxp", "hhea", "hmtx", "cmap", "fvar", "avar"),
    *("GDEF", "GSUB", "GPOS", "kern", "morx", "kerx", "ankr", "feat"),
)
"""Tables that HarfBuzz needs for shaping. Advance widths come from this package."""
OUTLINES = ("glyf", "loca", "gvar", "CFF ", "CFF2", "VARC", "COLR", "CPAL")
"""Where HarfBuzz uses no GPOS, it places marks by the extents of what these tables draw."""
UNROUNDED = 1e-9
"""A slant that moves no point. HarfBuzz rounds the extents of outlines to font units, unless these
are slanted, and rounded extents have no derivative."""
LINE_BREAK = re.compile("\r\n|\r|\n")
"""What separates the lines of a text. Fonts have glyphs for these characters, which are blank."""
SCRIPT_LIST, FEATURE_LIST = 4, 6
INVISIBLE = 0x7FFFFFFF
"""A glyph id that no font has. HarfBuzz gives it to characters such as a joiner."""
COMMON = frozenset(("Zyyy", "Zinh", "Zzzz"))
"""Scripts of characters that are common to several scripts."""
ALIKE = frozenset("Armn Bopo Copt Cyrl Geor Grek Hani Hira Kana Latn".split())
"""Scripts that are shaped by the same rules. They stay in one run, as in hb-shape, so that their
letters are kerned with one another."""
SCALE = 1024
"""HarfBuzz gives positions in whole numbers, here in 1/1024 of a font unit."""


@dataclass(frozen=True)
class ShapedRow:
    """Glyphs in drawing order: line after line, each from left to right.

    Attributes
    ----------
    glyph_ids, clusters, lines : tuple of int
        For each glyph its id, the index in the string of the first character that it stands for,
        and the number of its line.
    rtl : tuple of bool
        Whether the glyph belongs to a run from right to left.
    by_extents : bool
        Whether the extents of outlines may place marks: a run has marks, and the font has no GPOS
        table or HarfBuzz does not use it for the run.
    positions : (l, 3) array
        Advance width, x offset and y offset of each glyph, in font units.
    """

    glyph_ids: tuple[int, ...]
    clusters: tuple[int, ...]
    lines: tuple[int, ...]
    rtl: tuple[bool, ...]
    by_extents: bool
    positions: Array = field(repr=False, compare=False)


class Shaper:
    """HarfBuzz over the tables of one font.

    Parameters
    ----------
    font : TTFont
        Its tables have to be as the file has them.
    reading : lock
        Held while a table is read.
    """

    def __init__(self, font: TTFont, reading: RLock) -> None:
        # HarfBuzz reads a table at any later time, and cannot be told of a damaged one, so all
        # tables are copied here but for those that are seldom needed and large.
        self._tables = {tag: font.getTableData(tag) for tag in TABLES if tag in font}
        self._file, self._reading = font, reading
        self._advance: Callable[[int], float] = lambda _: 0.0
        self._failure: BaseException | None = None
        self._open()
        self._lock = Lock()

    def _open(self) -> None:
        self._face = hb.Face.create_for_tables(self._table, None)
        # The functions of the second font replace those of the first.
        self._outlines = hb.Font(self._face)
        self._font = hb.Font(self._outlines)
        functions = hb.FontFuncs()
        functions.set_glyph_h_advance_func(self._tell_advance)
        self._font.funcs = functions

    def _table(self, _face: hb.Face, tag: str, _data: object) -> bytes:
        if tag in OUTLINES and tag in self._file and tag not in self._tables:
            try:
                with self._reading, damage("The outlines are damaged"):
                    # The bindings keep no table alive.
                    self._tables[tag] = self._file.reader[tag]
            except BaseException as error:
                # HarfBuzz would print an exception and go on without this table.
                self._failure = error
        return self._tables.get(tag, b"")

    @cached_property
    def features(self) -> frozenset[str]:
        """Tags of the features that the font has."""
        tables = (self._tables.get(tag, b"") for tag in ("GSUB", "GPOS"))
        return frozenset(tag for table in tables for tag in _tags(table, FEATURE_LIST))

    @cached_property
    def _positioned_scripts(self) -> set[str]:
        """Tags of the scripts of GPOS."""
        return _tags(self._tables.get("GPOS", b""), SCRIPT_LIST)

    def _ignores_gpos(self, script: str | None) -> bool:
        """Whether HarfBuzz places the glyphs of a script without GPOS.

        It uses GPOS for Hebrew only if the table has this script, because the marks of many fonts
        have no anchors.
        """
        if script == "Hebr":
            return "hebr" not in self._positioned_scripts
        return "GPOS" not in self._tables

    def shape(
        self,
        string: str,
        w: Array,
        options: ShapingOptions,
        advance: Callable[[int], float],
        by_grapheme: bool = False,
        rounded: bool = False,
    ) -> ShapedRow:
        r"""Shape a text at one location of the design space.

        Parameters
        ----------
        string : str
            Lines are separated by ``"\n"``, ``"\r\n"`` or ``"\r"``.
        w : (n,) array
            Normalized coordinates; HarfBuzz rounds them to 1/16384.
        options : ShapingOptions
        advance : function
            Gives the advance width of a glyph at ``w``, by glyph id, in font units.
        by_grapheme : bool
            Whether a cluster is a grapheme with its marks. By default each character has a
            cluster of its own, unless its glyph stands for others as well.
        rounded : bool
            Whether the extents that place marks are in whole font units, as in HarfBuzz by
            itself. Default false.

        Raises
        ------
        TextError
            ``string`` is empty, or has invisible characters only.
        FontError
            The outlines are needed, and are damaged.
        GlyphError
            The font has no glyph for a character.
        """
        infos, positions, lines, rtl = [], [], [], []
        by_extents = False
        with self._lock, self._heard_interrupts():
            self._go_to(w)
            self._font.synthetic_slant = 0.0 if rounded else UNROUNDED
            self._advance = advance
            for number, (start, line) in enumerate(_lines(string)):
                for run, script in _script_runs(line, options):
                    buffer = self._shape_run(string, start, run, script, options, by_grapheme)
                    both = zip(buffer.glyph_infos, buffer.glyph_positions, strict=True)
                    visible = [one for one in both if one[0].codepoint != INVISIBLE]
                    infos += [info for info, _ in visible]
                    positions += [position for _, position in visible]
                    lines += [number] * len(visible)
                    rtl += [run.rtl] * len(visible)
                    by_extents |= self._ignores_gpos(buffer.script) and _has_marks(
                        line[run.start : run.end]
                    )
            failure, self._failure = self._failure, None
            if failure is not None:
                # The face may lack a table.
                self._open()
        if failure is not None:
            raise failure
        if not infos:
            raise TextError(f"The text {string!r} is empty: it has no visible character.")
        missing = sorted({string[info.cluster] for info in infos if info.codepoint == 0})
        if missing:
            raise GlyphError(
                "The font has no glyph for " + ", ".join(f"{c!r} (U+{ord(c):04X})" for c in missing)
            )
        return ShapedRow(
            tuple(info.codepoint for info in infos),
            tuple(info.cluster for info in infos),
            tuple(lines),
            tuple(rtl),
            by_extents,
            np.array([(p.x_advance, p.x_offset, p.y_offset) for p in positions]) / SCALE,
        )

    @contextmanager
    def _heard_interrupts(self) -> Iterator[None]:
        """Raise an interrupt that arrives when HarfBuzz calls a function of this class.

        The bindings would print it and go on without the advance or the table, which HarfBuzz
        would not ask for again. Interrupts reach the main thread only.
        """
        if current_thread() is not main_thread():
            yield
            return
        heard, before = [], sys.unraisablehook

        def hook(lost: Any) -> None:
            if isinstance(lost.exc_value, KeyboardInterrupt):
                heard.append(lost.exc_value)
            else:
                before(lost)

        sys.unraisablehook = hook
        try:
            yield
        finally:
            sys.unraisablehook = before
            if heard:
                self._open()
                raise heard[0]

    def _tell_advance(self, _font: hb.Font, glyph_id: int, _data: object) -> int:
        if glyph_id >= self._face.glyph_count:
            return 0  # A damaged cmap names a glyph that does not exist.
        try:
            return round(SCALE * self._advance(glyph_id))
        except BaseException as error:
            # HarfBuzz would print an exception and go on without this advance.
            self._failure = error
            return 0

    def _go_to(self, w: Array) -> None:
        coordinates = [float(x) for x in w]
        for font in (self._outlines, self._font):
            font.scale = (SCALE * self._face.upem, SCALE * self._face.upem)
            font.set_var_coords_normalized(coordinates)

    def _shape_run(
        self,
        string: str,
        start: int,
        run: Run,
        script: str | None,
        options: ShapingOptions,
        by_grapheme: bool,
    ) -> hb.Buffer:
        buffer = hb.Buffer()
        level = hb.BufferClusterLevel
        # A mark keeps its own cluster, so that a missing one is not taken for its base.
        buffer.cluster_level = (
            level.MONOTONE_GRAPHEMES if by_grapheme else level.MONOTONE_CHARACTERS
        )
        # uharfbuzz takes no subclass, such as numpy's strings.
        buffer.add_str(str(string), start + run.start, run.end - run.start)
        # A joiner and its like say how to shape, and then become invisible. Where HarfBuzz removes
        # one between a letter and its mark, it leaves the mark as far away as that glyph is wide.
        buffer.invisible_glyph = INVISIBLE
        buffer.direction = "rtl" if run.rtl else "ltr"
        if script is not None:
            buffer.script = script
        # Without a language HarfBuzz would take that of the machine.
        buffer.language = options.language or "und"
        buffer.guess_segment_properties()
        # Ranges count from the start of the string, as clusters do.
        hb.shape(self._font, buffer, options.feature_values)
        return buffer


@lru_cache
def _has_marks(characters: str) -> bool:
    """Whether some characters are combining marks, or HarfBuzz may split them into such."""
    parts = unicodedata.normalize("NFKD", characters)
    return any(unicodedata.category(part).startswith("M") for part in parts)


def _lines(string: str) -> Iterator[tuple[int, str]]:
    """Each line of a text with the index of its first character."""
    start = 0
    for found in LINE_BREAK.finditer(string):
        yield start, string[start : found.start()]
        start = found.end()
    yield start, string[start:]


@lru_cache
def _script_runs(line: str, options: ShapingOptions) -> tuple[tuple[Run, str | None], ...]:
    """The runs of a line from left to right, each of one direction, with their scripts.

    HarfBuzz shapes a run by the rules of one script.
    """
    found: list[tuple[Run, str | None]] = []
    for run in direction_runs(line, options.direction):
        scripts = _scripts(line[run.start : run.end])
        if options.script is not None or scripts[0] is None:
            found.append((run, options.script or next(filter(None, _scripts(line)), None)))
            continue
        parts, start = [], run.start
        for script, characters in groupby(scripts):
            end = start + len(list(characters))
            parts.append((Run(start, end, run.rtl), script))
            start = end
        found += parts[::-1] if run.rtl else parts
    return tuple(found)


def _scripts(characters: str) -> list[str | None]:
    """The script by whose rules each character is shaped, None if no character has one.

    A character that is common to several scripts goes with the one before it (Unicode Standard
    Annex 24, "Unicode Script Property").
    """
    own = [None if script in COMMON else script for script in map(unicodedata.script, characters)]
    alike = next((script for script in own if script in ALIKE), None)
    latest = next(filter(None, own), None)
    found = []
    for script in own:
        if script is not None:
            latest = alike if script in ALIKE else script
        found.append(latest)
    return found


def _tags(table: bytes, at: int) -> set[str]:
    """Tags in a list of a GSUB or GPOS table (OpenType, "Script List" and "Feature List table").

    Parameters
    ----------
    at : int
        Where the table states the start of the list.
    """
    start = int.from_bytes(table[at : at + 2], "big")
    count = int.from_bytes(table[start : start + 2], "big")
    tags = (table[start + 2 + 6 * i :][:4] for i in range(count))
    return {tag.decode("latin-1") for tag in tags}
