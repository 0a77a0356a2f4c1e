"""The properties that style sheets within an SVG, and style attributes, give to its elements."""

from __future__ import annotations

import re
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
        self._reached: dict[ElementTree.Element, list[int]] = {}

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
        declared = [pair for rule in self._matching(element) for pair in rule.pairs]
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

    def _progress(self, element: ElementTree.Element) -> list[int]:
        """How many parts of each rule, from the outside in, an element and those around it match.

        The last part of a rule is left out. An element continues where the one around it ends, so
        nothing is compared again for each element inside.
        """
        path = []
        above: ElementTree.Element | None = element
        while above is not None and above not in self._reached:
            path.append(above)
            above = self._parents.get(above)
        counts = [0] * len(self._rules) if above is None else self._reached[above]
        for one in reversed(path):
            facts = self._facts(one)
            counts = [
                count + (count < len(rule.parts) - 1 and rule.parts[count].fits(*facts))
                for count, rule in zip(counts, self._rules, strict=True)
            ]
        self._reached[element] = counts
        return counts

    def _matching(self, element: ElementTree.Element) -> list[_Rule]:
        """The rules whose last part matches an element, and the others elements around it."""
        above, facts = self._parents.get(element), self._facts(element)
        counts = [0] * len(self._rules) if above is None else self._progress(above)
        return [
            rule
            for count, rule in zip(counts, self._rules, strict=True)
            if count == len(rule.parts) - 1 and rule.parts[-1].fits(*facts)
        ]

    def _facts(self, element: ElementTree.Element) -> tuple[str, frozenset[str], str | None]:
        """The type of an element, its classes and its id."""
        return tag_of(element), self._classes.get(element, frozenset()), element.get("id")


class _Part(NamedTuple):
    """One part of a selector, such as ``rect.a``: the type, the classes and the ids it states."""

    tag: str | None
    classes: frozenset[str]
    ids: frozenset[str]

    def fits(self, tag: str, classes: frozenset[str], name: str | None) -> bool:
        """Whether an element of this type, these classes and this id matches the part."""
        return (
            (self.tag is None or self.tag == tag)
            and self.classes <= classes
            and all(one == name for one in self.ids)
        )


class _Rule(NamedTuple):
    """One selector of a style sheet, its parts from the outside in, and what it declares."""

    weight: int
    parts: list[_Part]
    pairs: list[tuple[str, str]]


def _rules(css: str) -> list[_Rule]:
    """The rules of a style sheet, the one that decides last.

    Selectors of types, classes and ids are read, and those of elements within others.
    """
    rules, known = [], dict[str, _Part]()
    for block in _without_comments(css).split("}"):
        selectors, _, body = block.rpartition("{")
        for selector in selectors.split(","):
            parts = selector.split()
            if parts and all(SIMPLE.fullmatch(part) for part in parts):
                types = sum(part[0] not in ".#*" for part in parts)
                ids, classes = selector.count("#"), selector.count(".")
                weight = 10_000 * ids + 100 * classes + types
                # A hostile sheet may repeat a part a million times.
                known |= {part: _part(part) for part in set(parts) - known.keys()}
                rules.append(_Rule(weight, [known[part] for part in parts], _pairs(body)))
    if len(rules) > MOST_RULES:
        raise OverlapError(
            f"The SVG has {len(rules):,} rules of style, and at most {MOST_RULES:,} are read; "
            "simplify it."
        )
    return sorted(rules, key=lambda rule: rule.weight)


def _part(source: str) -> _Part:
    """A part of a selector, from its text."""
    tag = re.match(r"[\w-]+", source)
    names = NAMES.findall(source)
    classes, ids = (frozenset(name for kind, name in names if kind == sign) for sign in ".#")
    return _Part(tag[0] if tag else None, classes, ids)


def _without_comments(css: str) -> str:
    first, *others = css.split("/*")
    return first + "".join(other.partition("*/")[2] for other in others)


def _pairs(body: str) -> list[tuple[str, str]]:
    """The names and values of declarations."""
    found = [part.partition(":") for part in body.split(";")]
    return [(name.strip().lower(), value.strip()) for name, colon, value in found if colon]
