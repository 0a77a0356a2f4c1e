"""Numbers with units in values of CSS, and the functions that compute with them.

Expressions are read once from left to right; their nesting is limited.
"""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Sequence
from typing import NamedTuple

NUMBER = r"[+-]?(?:\d*\.\d+|\d+)(?:[eE][+-]?\d+)?"
TOKEN = re.compile(
    rf"(\s*)(?:({NUMBER})(%|[a-z][\w-]*)?|([a-z][a-z-]*)?\(|([-+*/),]))", re.IGNORECASE | re.ASCII
)
DIVIDED = re.compile(r"""\"[^\"]*\"|'[^']*'|[()\[\],]|\s+""")
DEEPEST = 20
"""Brackets within brackets that are read."""


class Measure(NamedTuple):
    """A number, a length or an angle, in the unit of its kind."""

    size: float
    kind: str = ""


Unit = Callable[[float, str], "Measure | None"]
"""What a number with a unit is; None if the unit is not known."""
_Token = tuple[str, str, str, str, str]


def computed(source: str, unit: Unit) -> Measure | None:
    """The value of a number with a unit, or of an expression; None if it cannot be read.

    Parameters
    ----------
    source : str
        Such as ``3px``, ``calc(50% - 2em)`` or ``max(10px, 5%)``.
    unit : callable
        From a number and its unit to its measure.
    """
    tokens, place = list[_Token](), 0
    source = source.strip()
    while found := TOKEN.match(source, place):
        tokens.append((found[1], found[2] or "", found[3] or "", found[0], found[5] or ""))
        place = found.end()
    if place < len(source) or not tokens:
        return None
    reader = _Reader(tokens, unit)
    try:
        value = reader.atom(0)
    except (_UnreadError, ArithmeticError):
        return None
    whole = reader.place == len(tokens) and math.isfinite(value.size)
    # Brackets alone are no expression.
    return value if whole and tokens[0][3] != "(" else None


def words(source: str, sign: str = "") -> list[str]:
    """The parts of a value between spaces, or between signs, that are not within brackets."""
    source, found, begun, depth = source.strip(), list[str](), 0, 0
    for part in DIVIDED.finditer(source):
        if part[0] in ("(", "[", ")", "]"):
            depth += 1 if part[0] in ("(", "[") else -1
        elif depth == 0 and (part[0] == sign if sign else part[0].isspace()):
            found.append(source[begun : part.start()].strip())
            begun = part.end()
    last = source[begun:].strip()
    return [*found, last] if sign or last else found


def listed(source: str) -> list[str]:
    """The parts of a list that commas or spaces divide; empty where two commas meet."""
    return [word for part in words(source, ",") for word in words(part) or [""]]


def end_of_brackets(
    source: str, place: int, signs: re.Pattern[str] = DIVIDED, pair: str = "()"
) -> int:
    """The place after the bracket that closes the one before a place; 0 if there is none.

    ``signs`` finds the brackets of the pair; by default those that are not within strings.
    """
    depth = 1
    for found in signs.finditer(source, place):
        depth += {pair[0]: 1, pair[1]: -1}.get(found[0], 0)
        if depth == 0:
            return found.end()
    return 0


class _UnreadError(Exception):
    """The expression has an error."""


class _Reader:
    """What reads the tokens of an expression, one after the other."""

    def __init__(self, tokens: Sequence[_Token], unit: Unit) -> None:
        self.tokens, self.unit, self.place = tokens, unit, 0

    def atom(self, depth: int) -> Measure:
        """A number, or a function or brackets with what is in them."""
        _, number, unit, text, sign = self._next()
        if sign or depth > DEEPEST:
            raise _UnreadError
        if number:
            value = self.unit(float(number), unit)
            if value is None:
                raise _UnreadError
            return value
        name = text.strip().rstrip("(").lower()
        values = [self._sum(depth)]
        while self._sign() == ",":
            self.place += 1
            values.append(self._sum(depth))
        if self._next()[4] != ")":
            raise _UnreadError
        return _called(name, values)

    def _sum(self, depth: int) -> Measure:
        total = self._product(depth)
        while (sign := self._sign()) in ("+", "-"):
            before = self.tokens[self.place][0]
            self.place += 1
            # A sign without spaces around it would be that of a number.
            if not (before and self.place < len(self.tokens) and self.tokens[self.place][0]):
                raise _UnreadError
            other = self._product(depth)
            if other.kind != total.kind:
                raise _UnreadError
            total = total._replace(size=total.size + (other.size if sign == "+" else -other.size))
        return total

    def _product(self, depth: int) -> Measure:
        total = self.atom(depth + 1)
        while (sign := self._sign()) in ("*", "/"):
            self.place += 1
            other = self.atom(depth + 1)
            if other.kind and (sign == "/" or total.kind):
                raise _UnreadError
            make = operator.mul if sign == "*" else operator.truediv
            total = Measure(make(total.size, other.size), total.kind or other.kind)
        return total

    def _sign(self) -> str:
        return self.tokens[self.place][4] if self.place < len(self.tokens) else ""

    def _next(self) -> _Token:
        if self.place == len(self.tokens):
            raise _UnreadError
        self.place += 1
        return self.tokens[self.place - 1]


def _called(name: str, values: Sequence[Measure]) -> Measure:
    """The value of a function."""
    sizes, kind = [value.size for value in values], values[0].kind
    if any(value.kind != kind for value in values):
        raise _UnreadError
    if name in ("", "calc") and len(sizes) == 1:
        return values[0]
    if name in ("min", "max"):
        return Measure(min(sizes) if name == "min" else max(sizes), kind)
    if name == "clamp" and len(sizes) == 3:
        return Measure(max(sizes[0], min(sizes[1], sizes[2])), kind)
    raise _UnreadError
