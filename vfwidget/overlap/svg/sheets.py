"""The rules of style sheets."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import NamedTuple
from xml.etree import ElementTree

from ...errors import OverlapError
from .maths import words
from .selectors import Part, UnreadError, parts_of

MOST_RULES, MOST_TESTS = 1_000, 4_000
"""Rules of style sheets that are read, and conditions of all of their selectors."""
MEDIA = re.compile(r"\s*(?:only\s+)?(?:all|screen)?\s*", re.IGNORECASE)
"""A query of a style sheet that is always meant for a screen."""
SIGN = re.compile(r"[{};]")


class Rule(NamedTuple):
    """One selector of a style sheet, its parts from the outside in, and what it declares."""

    weight: int
    parts: list[Part]
    pairs: list[tuple[str, str]]


def is_sheet(element: ElementTree.Element) -> bool:
    """Whether a ``style`` element is a style sheet for a screen."""
    kind = element.get("type", "").strip().lower()
    return kind in ("", "text/css") and _is_for_screen(element.get("media", ""))


def _is_for_screen(media: str) -> bool:
    """Whether one of several queries has no condition; conditions of windows are not known."""
    return any(MEDIA.fullmatch(query) for query in media.split(","))


def rules_of(css: str, unread: dict[str, None]) -> list[Rule]:
    """The rules of a style sheet, the one that decides last.

    Selectors that are not read are added to ``unread``.

    Raises
    ------
    OverlapError
        There are too many rules, or conditions of selectors.
    """
    rules, count, tests = list[Rule](), 0, 0
    for selectors, body in _blocks(without_comments(css)):
        pairs, listed = pairs_of(body), words(selectors, ",")
        # Browsers ignore a list with an empty selector.
        for selector in listed if pairs and all(listed) else ():
            count += 1
            if count > MOST_RULES or tests > MOST_TESTS:
                continue  # The rest of a hostile sheet is only counted.
            try:
                parts = parts_of(selector)
            except UnreadError:
                unread[selector[:80]] = None
                continue
            rules.append(Rule(sum(part.weight for part in parts), parts, pairs))
            tests += sum(part.size for part in parts)
    if count > MOST_RULES or tests > MOST_TESTS:
        raise OverlapError(
            f"The SVG has {count:,} rules of style, and at most {MOST_RULES:,} are read, with at "
            f"most {MOST_TESTS:,} conditions; simplify it."
        )
    return sorted(rules, key=lambda rule: rule.weight)


def _blocks(css: str) -> Iterator[tuple[str, str]]:
    """The selectors and the declarations of each rule, also of those for screens only."""
    place, begun, groups = 0, 0, 0
    while found := SIGN.search(css, place):
        place, before = found.end(), css[begun : found.start()].strip()
        rule = before.startswith("@")
        if found[0] == "{" and rule and _is_group(before):
            groups += 1
        elif found[0] == "{":
            end = _end_of_block(css, place)
            if not rule:
                yield before, css[place:end]
            place = end + 1
        elif found[0] == "}" and groups:
            groups -= 1
        elif not (found[0] == ";" and rule):
            continue  # A sign where it means nothing spoils the selector.
        begun = place


def _is_group(rule: str) -> bool:
    """Whether the rules within this one are for screens."""
    name, _, media = rule.partition(" ")
    return name.lower() == "@layer" or (name.lower() == "@media" and _is_for_screen(media))


def _end_of_block(css: str, place: int) -> int:
    """Where the block ends that begins before a place."""
    depth = 1
    for found in SIGN.finditer(css, place):
        depth += {"{": 1, "}": -1}.get(found[0], 0)
        if depth == 0:
            return found.start()
    return len(css)


def without_comments(css: str) -> str:
    """A style sheet, or declarations, without comments."""
    first, *others = css.replace("<!--", "").replace("-->", "").split("/*")
    return first + "".join(other.partition("*/")[2] for other in others)


def pairs_of(body: str) -> list[tuple[str, str]]:
    """The names and values of declarations."""
    found = [part.partition(":") for part in body.split(";")]
    names = [(name.strip(), value.strip()) for name, colon, value in found if colon]
    return [(name if name.startswith("--") else name.lower(), value) for name, value in names]
