"""Order on the line of text in mixed directions, by the Unicode bidirectional algorithm.

HarfBuzz shapes text of one direction. A line in mixed directions is therefore cut into runs, each
of one direction, and the runs are put in their order from left to right
(Unicode Standard Annex 9, "Unicode Bidirectional Algorithm", rules P2 to L2).
"""

from __future__ import annotations

import re
from functools import partial
from itertools import groupby
from typing import NamedTuple
from unicodedata import bidirectional

ONLY_LEFT_TO_RIGHT = frozenset(("", "L", "EN", "ES", "ET", "CS", "NSM", "BN", "B", "S", "WS", "ON"))
"""Bidirectional classes of characters that need no reordering among themselves."""

SEPARATORS = frozenset(("S", "B"))
BLANKS = frozenset("WS BN FSI LRI RLI PDI LRE RLE LRO RLO PDF".split())
"""Classes of spaces, and of invisible characters that may stand among them."""


class Run(NamedTuple):
    """A stretch of a line that has one direction.

    Attributes
    ----------
    start, end : int
        The characters ``line[start:end]``.
    rtl : bool
        Whether the run is read from right to left.
    """

    start: int
    end: int
    rtl: bool


def direction_runs(line: str, base: str | None = None) -> list[Run]:
    """Cut a line into runs of one direction, in their order from left to right.

    Parameters
    ----------
    line : str
        One paragraph, without a line break.
    base : "ltr", "rtl" or None
        Direction of the paragraph. By default the direction of its first strong character.
    """
    if base != "rtl" and all(bidirectional(c) in ONLY_LEFT_TO_RIGHT for c in line):
        return [Run(0, len(line), False)] if line else []
    runs: list[tuple[int, Run]] = []
    start = 0
    for level, characters in groupby(_levels(line, base)):
        end = start + len(list(characters))
        runs.append((level, Run(start, end, bool(level % 2))))
        start = end
    return [run for _, run in _reordered(runs)]


def _levels(line: str, base: str | None) -> list[int]:
    """The embedding level of each character; odd levels are read from right to left."""
    from bidi import get_display

    # The library takes no half of a surrogate pair; the replacement character has as many bytes.
    whole = re.sub("[\ud800-\udfff]", "\ufffd", line)
    # With debug the library returns its resolved levels in print, one for each byte of UTF-8, and
    # then the paragraphs with theirs.
    side = {"ltr": "L", "rtl": "R"}.get(base or "")
    report = str(get_display(whole, base_dir=side, debug=True)).rpartition("levels:")[2]
    levels = [int(level) for level in re.findall(r"Level\(\s*(\d+)", report)]
    of_characters, byte = [], 0
    for character in whole:
        of_characters.append(levels[byte])
        byte += len(character.encode())
    return _with_blanks_at(levels[byte], line, of_characters) if line else []


def _with_blanks_at(paragraph: int, line: str, levels: list[int]) -> list[int]:
    """Rule L1: blanks before a tab and at the end of the line, and tabs, as the paragraph has it.

    The library gives the levels before this rule.
    """
    settled, trails = list(levels), True
    for i, kind in reversed(list(enumerate(map(bidirectional, line)))):
        trails = kind in SEPARATORS or (trails and kind in BLANKS)
        if trails:
            settled[i] = paragraph
    return settled


def _reordered(runs: list[tuple[int, Run]]) -> list[tuple[int, Run]]:
    """Rule L2: from the highest level to the lowest odd one, reverse what is at least there."""
    highest = max((level for level, _ in runs), default=0)
    for least in range(highest, 0, -1):
        turned: list[tuple[int, Run]] = []
        for inside, stretch in groupby(runs, partial(_reaches, least)):
            part = list(stretch)
            turned += part[::-1] if inside else part
        runs = turned
    return runs


def _reaches(least: int, run: tuple[int, Run]) -> bool:
    return run[0] >= least
