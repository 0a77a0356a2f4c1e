"""The rules of style sheets."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import NamedTuple
from xml.etree import ElementTree

from ...errors import OverlapError
from .maths import end_of_brackets, words
from .paint import INITIAL, accepted
from .parts import LENGTHS, LONG, SHAPING, is_length
from .selectors import Part, UnreadError, parts_of
from .transforms import STYLED

MOST_RULES, MOST_TESTS, MOST_PROPERTIES, MOST_TOLD = 1_000, 4_000, 20_000, 3
"""Rules of style sheets that are read, conditions of all of their selectors, properties that they
declare, and values of an element of which it is said that they cannot be read."""
READ = frozenset(
    (LENGTHS - {"x1", "y1", "x2", "y2"})
    | STYLED.keys()
    | INITIAL.keys()
    | {"clip-path", "mask", "filter", "transform-box", "transform-origin", "overflow"}
    | {"vector-effect", "marker", "d"}
)
"""Properties of style sheets that are read, besides custom ones."""
PATH = re.compile(r"""path\(\s*(?:"([^"]*)"|'([^']*)')\s*\)|none""", re.IGNORECASE)
IMPORTANT = re.compile(r"\s*!\s*important\s*$", re.IGNORECASE)
MEDIA = re.compile(r"\s*(?:only\s+)?(?:all|screen)?\s*", re.IGNORECASE)
"""A query of a style sheet that is always meant for a screen."""
SIGN = re.compile(r"[{};]")


class Declared(NamedTuple):
    """What a rule, or an element's own style, declares of the properties that are read.

    ``dropped`` are values that cannot be read, in words.
    """

    normal: dict[str, str]
    important: dict[str, str]
    dropped: list[str]


class Rule(NamedTuple):
    """One selector of a style sheet, its parts from the outside in, and what it declares."""

    weight: int
    parts: list[Part]
    declared: Declared


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
    rules, count, tests, properties = list[Rule](), 0, 0, 0
    for selectors, body in _blocks(without_comments(css)):
        declared, listed = declared_in(body), words(selectors, ",")
        if not any(declared) or not all(listed):
            continue  # Browsers ignore a list with an empty selector.
        for selector in listed:
            count += 1
            if count > MOST_RULES or tests > MOST_TESTS or properties > MOST_PROPERTIES:
                continue  # The rest of a hostile sheet is only counted.
            try:
                parts = parts_of(selector)
            except UnreadError:
                unread[selector[:80]] = None
                continue
            rules.append(Rule(sum(part.weight for part in parts), parts, declared))
            tests += sum(part.size for part in parts)
            properties += len(declared.normal) + len(declared.important)
    if count > MOST_RULES or tests > MOST_TESTS or properties > MOST_PROPERTIES:
        raise OverlapError(
            f"The SVG has {count:,} rules of style, and at most {MOST_RULES:,} are read, with at "
            f"most {MOST_TESTS:,} conditions and {MOST_PROPERTIES:,} properties; simplify it."
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
            # The last block may be open.
            end = end_of_brackets(css, place, SIGN, "{}") or len(css) + 1
            if not rule:
                yield before, css[place : end - 1]
            place = end
        elif found[0] == "}" and groups:
            groups -= 1
        elif not (found[0] == ";" and rule):
            continue  # A sign where it means nothing spoils the selector.
        begun = place


def _is_group(rule: str) -> bool:
    """Whether the rules within this one are for screens."""
    name, _, media = rule.partition(" ")
    return name.lower() == "@layer" or (name.lower() == "@media" and _is_for_screen(media))


def without_comments(css: str) -> str:
    """A style sheet, or declarations, without comments."""
    first, *others = css.replace("<!--", "").replace("-->", "").split("/*")
    return first + "".join(other.partition("*/")[2] for other in others)


def declared_in(body: str) -> Declared:
    """What declarations state of the properties that are read."""
    found = Declared({}, {}, [])
    for part in body.split(";"):
        name, colon, value = part.partition(":")
        name, value = name.strip(), value.strip()
        name = name if name.startswith("--") else name.lower()
        if not colon or not (name in READ or name.startswith("--")):
            continue
        bare = IMPORTANT.sub("", value)
        own = found.normal if bare == value else found.important
        if path := PATH.fullmatch(bare) if name == "d" else None:
            own["d"] = path[1] or path[2] or ""
        if name == "d":
            continue
        dropped = not state(own, STYLED.get(name, name), bare) and is_told(name, bare)
        if dropped and len(found.dropped) < MOST_TOLD:
            found.dropped.append(f"{name}: {bare:.80}")
    return found


def state(own: dict[str, str], name: str, value: str) -> bool:
    """Take a value into the properties of an element, if it is one that is accepted."""
    if len(value) > LONG and name not in SHAPING:
        return False
    found = accepted(name, value)
    if found is not None:
        own[name] = found
    return found is not None


def is_told(name: str, value: str) -> bool:
    """Whether it is said that a value is ignored; a length below 0 is meant to be."""
    said = name in STYLED or name == "clip-path"
    return value != "" and (said or (name in LENGTHS and not is_length(value)))
