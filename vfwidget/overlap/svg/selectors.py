"""Selectors of style sheets: how they are read, and which elements they match."""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

from .maths import end_of_brackets, words
from .parts import LONG

MOST_PARTS, MOST_NESTED = 20, 4
"""Parts of a selector that is read, and functions within functions."""
IDENT = r"(?:[\w-]|\\(?:[0-9a-fA-F]{1,6}\s?|[^\n0-9a-fA-F]))+"
SIMPLE = re.compile(rf"(\*|{IDENT})|([.#])({IDENT})|(::?)({IDENT})(\()?|\[")
ATTRIBUTE = re.compile(
    rf"\s*({IDENT})\s*(?:([~|^$*]?=)\s*(?:\"([^\"]*)\"|'([^']*)'|({IDENT}))\s*(?:\b([iIsS])\s*)?)?\]"
)
SIGN = re.compile(r"\s*([>+~])\s*|\s+")
ESCAPE = re.compile(r"\\(?:([0-9a-fA-F]{1,6})\s?|(.))")
NTH = re.compile(
    r"(?:(odd|even)|([+-]?\d{0,9})n(?:\s*([+-])\s*(\d{1,9}))?|([+-]?\d{1,9}))", re.IGNORECASE
)
NEVER = frozenset(
    "hover active focus focus-within focus-visible visited target target-within checked".split()
)
"""States that nothing has in a document that nobody uses."""
PLACES = {
    **{"first-child": (0,), "last-child": (1,), "only-child": (0, 1)},
    **{"first-of-type": (2,), "last-of-type": (3,), "only-of-type": (2, 3)},
}
"""Which of the places of an element must be 1."""
NTHS = {"nth-child": 0, "nth-last-child": 1, "nth-of-type": 2, "nth-last-of-type": 3}


class Facts(NamedTuple):
    """The facts about an element that selectors ask for.

    Attributes
    ----------
    places : (int, int, int, int)
        The number of the element among its siblings from the first and from the last one, and the
        same among those with its name.
    """

    tag: str
    classes: frozenset[str]
    attributes: Mapping[str, str]
    places: tuple[int, int, int, int]
    is_root: bool
    is_empty: bool


Test = Callable[[Facts], bool]


class Part(NamedTuple):
    """One part of a selector, such as ``rect.a:not([x])``.

    ``sign`` says where the element of the part before is: around it (a space), directly around it
    (``>``), directly before it (``+``), or before it in the same element (``~``).
    """

    sign: str
    tag: str | None
    classes: frozenset[str]
    tests: tuple[Test, ...]
    weight: int
    size: int

    def fits(self, facts: Facts) -> bool:
        """Whether an element matches the part."""
        return (
            (self.tag is None or self.tag == facts.tag)
            and self.classes <= facts.classes
            and all(test(facts) for test in self.tests)
        )


class UnreadError(Exception):
    """A selector is not read."""


def parts_of(selector: str) -> list[Part]:
    """The parts of a selector, from the outside in.

    Raises
    ------
    UnreadError
        It has an error, or it is of a kind that is not read.
    """
    selector, place, sign = selector.strip(), 0, " "
    found = list[Part]()
    while True:
        part, place = _part(selector, place, sign, 0)
        found.append(part)
        if place == len(selector):
            return found
        after = SIGN.match(selector, place)
        if after is None or len(found) == MOST_PARTS:
            raise UnreadError
        sign, place = after[1] or " ", after.end()


def _part(source: str, place: int, sign: str, depth: int) -> tuple[Part, int]:
    """The part that begins at a place, and where it ends."""
    begun, tag = place, None
    classes, tests, weight, size = set[str](), list[Test](), 0, 1
    while found := SIMPLE.match(source, place):
        place = found.end()
        if found[1]:
            if place - len(found[0]) != begun:
                raise UnreadError
            tag, weight = (None, weight) if found[1] == "*" else (_plain(found[1]), weight + 1)
        elif found[2] == ".":
            classes.add(_plain(found[3]))
            weight += 100
        elif found[2] == "#":
            tests.append(_attribute("id", "=", _plain(found[3]), ""))
            weight += 10_000
        elif found[0] == "[":
            stated = ATTRIBUTE.match(source, place)
            if not stated:
                raise UnreadError
            value = next(
                (_plain(value) for value in stated.group(3, 4, 5) if value is not None), ""
            )
            tests.append(_attribute(_plain(stated[1]), stated[2], value, stated[6]))
            place, weight = stated.end(), weight + 100
        else:
            end = end_of_brackets(source, place) if found[6] else place
            if found[6] and not end:
                raise UnreadError
            inner = source[place : end - 1].strip() if found[6] else None
            name = "never" if found[4] == "::" else found[5].lower()
            test, added, more = _pseudo(name, inner, depth)
            tests.append(test)
            place, weight, size = end, weight + added, size + more
    if place == begun:
        raise UnreadError
    size += len(tests)
    return Part(sign, tag, frozenset(classes), tuple(tests), weight, size), place


def _pseudo(name: str, inner: str | None, depth: int) -> tuple[Test, int, int]:
    """The test of a pseudo-class, its weight, and how many others it makes."""
    if inner is None:
        if name == "root":
            return operator.attrgetter("is_root"), 100, 0
        if name == "empty":
            return operator.attrgetter("is_empty"), 100, 0
        if name in PLACES:
            places = PLACES[name]
            return (lambda facts: all(facts.places[i] == 1 for i in places)), 100, 0
        if name in NEVER or name in ("never", "before", "after"):
            return (lambda facts: False), 100, 0
        raise UnreadError
    if name in NTHS:
        return _nth(inner, NTHS[name]), 100, 0
    if name not in ("not", "is", "where") or depth == MOST_NESTED:
        raise UnreadError
    parts = list[Part]()
    for one in words(inner, ","):
        part, end = _part(one, 0, " ", depth + 1)
        if end < len(one):
            raise UnreadError
        parts.append(part)
    weight = 0 if name == "where" else max(part.weight for part in parts)
    wanted = name != "not"
    return (
        (lambda facts: any(part.fits(facts) for part in parts) == wanted),
        weight,
        sum(part.size for part in parts),
    )


def _nth(source: str, which: int) -> Test:
    """The test whether the number of an element is one of a row, such as ``2n + 1``."""
    found = NTH.fullmatch(source)
    if not found:
        raise UnreadError
    if found[1]:
        step, first = 2, int(found[1].lower() == "odd")
    elif found[5]:
        step, first = 0, int(found[5])
    else:
        step = int(found[2] + "1" if found[2] in ("", "+", "-") else found[2])
        first = int((found[3] or "") + (found[4] or "0"))

    def test(facts: Facts) -> bool:
        beyond = facts.places[which] - first
        return beyond == 0 if step == 0 else beyond % step == 0 and beyond // step >= 0

    return test


def _attribute(name: str, sign: str | None, wanted: str, flag: str | None) -> Test:
    """The test of an attribute's value; long values, such as paths, have only presence."""
    if sign is None:
        return lambda facts: name in facts.attributes
    folded = (flag or "").lower() == "i"
    wanted = wanted.lower() if folded else wanted
    compare = COMPARED[sign]

    def test(facts: Facts) -> bool:
        value = facts.attributes.get(name)
        if value is None or len(value) > LONG:
            return False
        return compare(value.lower() if folded else value, wanted)

    return test


COMPARED: dict[str, Callable[[str, str], bool]] = {
    "=": operator.eq,
    "~=": lambda value, wanted: wanted in value.split(),
    "|=": lambda value, wanted: value == wanted or value.startswith(wanted + "-"),
    "^=": lambda value, wanted: bool(wanted) and value.startswith(wanted),
    "$=": lambda value, wanted: bool(wanted) and value.endswith(wanted),
    "*=": lambda value, wanted: bool(wanted) and wanted in value,
}


def _plain(name: str) -> str:
    """A name without escapes."""
    if "\\" not in name:
        return name
    return ESCAPE.sub(lambda m: chr(min(int(m[1], 16), 0x10FFFF)) if m[1] else m[2], name)


def places_among(children: Sequence[str]) -> list[tuple[int, int, int, int]]:
    """The places of all elements in one, from their names."""
    forwards, backwards = _counted(children), _counted(children[::-1])[::-1]
    return [
        (i + 1, len(children) - i, first, last)
        for i, (first, last) in enumerate(zip(forwards, backwards, strict=True))
    ]


def _counted(names: Sequence[str]) -> list[int]:
    """How often each name has come up to its place."""
    counts, found = dict[str, int](), list[int]()
    for name in names:
        counts[name] = counts.get(name, 0) + 1
        found.append(counts[name])
    return found
