"""Lines in mixed directions are cut into runs as Unicode Standard Annex 9 says."""

from __future__ import annotations

import pytest

from vfwidget.font.bidi import direction_runs

A, B = "\u05d0", "\u05d1"


def shown(line: str, base: str | None = None) -> str:
    """The characters from left to right."""
    parts = [(line[run.start : run.end], run.rtl) for run in direction_runs(line, base)]
    return "".join(part[::-1] if rtl else part for part, rtl in parts)


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("ab 12", "ab 12"),
        (A + B, B + A),
        (f"{A}{B} 12", f"12 {B}{A}"),
        (f"ab {A}{B}", f"ab {B}{A}"),
        (f"{A} 12 ab 3", f"ab 3 12 {A}"),
        (f"{A} ab, {B}", f"{B} ,ab {A}"),
        # Rule N0: brackets follow what they enclose and the paragraph around them.
        (f"a ({B}) {B}", f"a ({B}) {B}"),
        # Rule L2 with levels 0, 1 and 2.
        (f"x {A} 12 {B} y", f"x {B} 12 {A} y"),
        # Rules X5a to X6a: an isolate has a direction of its own.
        (f"a \u2067{B} c\u2069 d", f"a \u2067c {B}\u2069 d"),
        # Characters beyond U+FFFF take two units of UTF-16 and four of UTF-8.
        (f"\U0001f600 {A}{B}", f"{B}{A} \U0001f600"),
        ("levels: " + A, f"levels: {A}"),
        # Rule L1: spaces at the end of the line, and tabs, stand as the paragraph says.
        (f"a \u202b{A}{B}  ", f"a \u202b{B}{A}  "),
        (f"{A} \u202aab ", f" ab\u202a {A}"),
        (f"a {A} \t{B}", f"a {A} \t{B}"),
        (f"a \u2067{A} \u2069 ", f"a \u2067{A} \u2069 "),
        ("", ""),
    ],
)
def test_order_from_left_to_right(line: str, expected: str) -> None:
    assert shown(line) == expected


def test_direction_of_the_paragraph() -> None:
    assert shown("abc!", "rtl") == "!abc"
    assert shown(f"{A} ab", "ltr") == f"{A} ab"
    assert shown(f"{A} ab") == f"ab {A}"


def test_a_line_of_one_direction_is_one_run() -> None:
    (run,) = direction_runs("one, two: 3")
    assert run == (0, 11, False)
