"""The properties that style sheets within an SVG, and style attributes, give to its elements."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple
from xml.etree import ElementTree

from ..errors import OverlapError

NAMESPACES = ("", "http://www.w3.org/2000/svg")
MOST_RULES = 1_000
"""Rules of style sheets that are read."""
LONG = 1_000
"""Characters of a property that is read; it may be read again for each use of an element."""
SHAPING = frozenset({"d", "points", "transform"})
"""Attributes that may be longer."""
NAMES = re.compile(r"([.#])([\w-]+)")
SIMPLE = re.compile(r"(\*|[\w-]+)?((?:[.#][\w-]+)*)")


def tag_of(element: ElementTree.Element) -> str:
    """The name of an SVG element; empty for a comment or an element of another language."""
    if not isinstance(element.tag, str):
        return ""
    space, _, name = element.tag.rpartition("}")
    return name if space.lstrip("{") in NAMESPACES else ""


class Styles:
    """The style sheets of a document.

    Parameters
    ----------
    root : Element
    """

    def __init__(self, root: ElementTree.Element) -> None:
        self._parents = {child: parent for parent in root.iter() for child in parent}
        self._classes = {e: frozenset(e.get("class", "").split()) for e in root.iter()}
        sheets = [element.text or "" for element in root.iter() if tag_of(element) == "style"]
        self._rules = _rules("\n".join(sheets))
        self._known: dict[ElementTree.Element, dict[str, str]] = {}

    def stated(self, element: ElementTree.Element) -> dict[str, str]:
        """Attributes, and the properties that rules and the element's own style give it."""
        if element not in self._known:
            self._known[element] = self._read(element)
        return self._known[element]

    def path(self, element: ElementTree.Element) -> list[ElementTree.Element]:
        """An element and those around it, from the outside in."""
        found = [element]
        while (above := self._parents.get(found[-1])) is not None:
            found.append(above)
        return found[::-1]

    def _read(self, element: ElementTree.Element) -> dict[str, str]:
        own = dict(element.attrib)
        matching = [rule for rule in self._rules if self._matches(rule.parts, element)]
        declared = [pair for rule in matching for pair in rule.pairs]
        declared += _pairs(own.get("style", ""))
        important = [pair for pair in declared if pair[1].endswith("!important")]
        for name, value in [*declared, *important]:
            own[name] = value.removesuffix("!important").strip()
        if "marker" in own:
            own = {f"marker-{kind}": own["marker"] for kind in ("start", "mid", "end")} | own
        return {
            name: value
            for name, value in own.items()
            if value != "inherit" and (name in SHAPING or len(value) <= LONG)
        }

    def _matches(self, selector: Sequence[str], element: ElementTree.Element) -> bool:
        """Whether a selector matches an element: its last part the element, others those around."""
        if not self._is(selector[-1], element):
            return False
        rest = list(selector[:-1])
        above = self._parents.get(element)
        while rest and above is not None:
            if self._is(rest[-1], above):
                rest.pop()
            above = self._parents.get(above)
        return not rest

    def _is(self, part: str, element: ElementTree.Element) -> bool:
        """Whether an element matches one part of a selector, such as ``rect.a``."""
        match = SIMPLE.fullmatch(part)
        if match is None or match[1] not in (None, "*", tag_of(element)):
            return False
        classes = self._classes.get(element, ())
        return all(
            name in classes if kind == "." else name == element.get("id")
            for kind, name in NAMES.findall(match[2])
        )


class _Rule(NamedTuple):
    """One selector of a style sheet, its parts from the outside in, and what it declares."""

    weight: int
    parts: list[str]
    pairs: list[tuple[str, str]]


def _rules(css: str) -> list[_Rule]:
    """The rules of a style sheet, the one that decides last.

    Selectors of types, classes and ids are read, and those of elements within others.
    """
    rules = []
    for block in _without_comments(css).split("}"):
        selectors, _, body = block.rpartition("{")
        for selector in selectors.split(","):
            parts = selector.split()
            if parts and all(SIMPLE.fullmatch(part) for part in parts):
                types = sum(part[0] not in ".#*" for part in parts)
                ids, classes = selector.count("#"), selector.count(".")
                rules.append(_Rule(10_000 * ids + 100 * classes + types, parts, _pairs(body)))
    if len(rules) > MOST_RULES:
        raise OverlapError(
            f"The SVG has {len(rules):,} rules of style, and at most {MOST_RULES:,} are read; "
            "simplify it."
        )
    return sorted(rules, key=lambda rule: rule.weight)


def _without_comments(css: str) -> str:
    first, *others = css.split("/*")
    return first + "".join(other.partition("*/")[2] for other in others)


def _pairs(body: str) -> list[tuple[str, str]]:
    """The names and values of declarations."""
    found = [part.partition(":") for part in body.split(";")]
    return [(name.strip().lower(), value.strip()) for name, colon, value in found if colon]
