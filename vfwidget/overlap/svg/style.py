"""The properties that style sheets within an SVG, and style attributes, give to its elements."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import NamedTuple
from xml.etree import ElementTree

from ...errors import OverlapError
from .paint import accepted
from .parts import LENGTHS, LONG, is_length
from .transforms import STYLED

NAMESPACES = ("", "http://www.w3.org/2000/svg")
MOST_RULES = 1_000
"""Rules of style sheets that are read."""
MOST_PARTS = 20
"""Parts of a selector that is read."""
SHAPING = frozenset({"d", "points", "transform"})
"""Attributes that may be longer."""
IMPORTANT = re.compile(r"\s*!\s*important\s*$", re.IGNORECASE)
NAMES = re.compile(r"([.#])([\w-]+)")
ATTRIBUTES = re.compile(r"""\[\s*([\w:-]+)\s*(?:=\s*("[^"]*"|'[^']*'|[\w-]+)\s*)?\]""")
SIMPLE = re.compile(rf"(\*|[\w-]+)?((?:[.#][\w-]+|:root|{ATTRIBUTES.pattern})*)")
NEVER = re.compile(r"::|:(?:hover|active|focus|focus-within|focus-visible|visited|target)\b")
"""Selectors that match nothing in a document that nobody uses."""
MEDIA = re.compile(r"\s*(?:only\s+)?(?:all|screen)?\s*", re.IGNORECASE)
"""A query of a style sheet that is always meant for a screen."""


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
        sheets = [element.text or "" for element in root.iter() if _is_sheet(element)]
        self.unread: dict[str, None] = {}
        """Selectors that are not read."""
        self._rules = _rules("\n".join(sheets), self.unread)
        self.dropped: dict[ElementTree.Element, list[str]] = {}
        """What elements state of their form and place that cannot be read."""
        self._root = root
        self._known: dict[_Within, dict[str, str]] = {}
        self._reached: dict[_Within, list[_Reached]] = {}

    def stated(
        self, element: ElementTree.Element, top: ElementTree.Element | None = None
    ) -> dict[str, str]:
        """Attributes, and the properties that rules and the element's own style give it.

        Of the elements around it only those within ``top`` count: rules do not look out of what a
        ``use`` draws.
        """
        if (element, top) not in self._known:
            self._known[element, top] = self._read(element, top)
        return self._known[element, top]

    def path(self, element: ElementTree.Element) -> list[ElementTree.Element]:
        """An element and those around it, from the outside in."""
        found = [element]
        while (above := self._parents.get(found[-1])) is not None:
            found.append(above)
        return found[::-1]

    def _read(
        self, element: ElementTree.Element, top: ElementTree.Element | None
    ) -> dict[str, str]:
        declared = [pair for rule in self._matching(element, top) for pair in rule.pairs]
        declared += _pairs(element.get("style", ""))
        important = [pair for pair in declared if IMPORTANT.search(pair[1])]
        own, dropped = dict[str, str](), list[str]()
        for name, value in element.attrib.items():
            value = value if name in SHAPING else value.strip()
            if not _state(own, name, value) and _is_told(name, value):
                dropped.append(f"{name}={value!r:.80}")
        for name, value in [*declared, *important]:
            value = IMPORTANT.sub("", value)
            if not _state(own, STYLED.get(name, name), value) and _is_told(name, value):
                dropped.append(f"{name}: {value:.80}")
        if dropped:
            self.dropped[element] = dropped
        if "marker" in own:
            own = {f"marker-{kind}": own["marker"] for kind in ("start", "mid", "end")} | own
        return {name: value for name, value in own.items() if value != "inherit"}

    def _above(
        self, element: ElementTree.Element, top: ElementTree.Element | None
    ) -> ElementTree.Element | None:
        """The element around one, if it is within ``top``."""
        return None if element is top else self._parents.get(element)

    def _progress(
        self, element: ElementTree.Element | None, top: ElementTree.Element | None
    ) -> list[_Reached]:
        """How many parts of each rule, from the outside in, an element and those around it match.

        The last part of a rule is left out. An element continues where the one around it ends, so
        nothing is compared again for each element inside.
        """
        path, above = [], element
        while above is not None and (above, top) not in self._reached:
            path.append(above)
            above = self._above(above, top)
        nothing = [NOTHING] * len(self._rules)
        reached = nothing if above is None else self._reached[above, top]
        for one in reversed(path):
            facts = self._facts(one)
            reached = [
                _inside(rule, before, facts) if len(rule.parts) > 1 else NOTHING
                for before, rule in zip(reached, self._rules, strict=True)
            ]
            self._reached[one, top] = reached
        return reached

    def _matching(
        self, element: ElementTree.Element, top: ElementTree.Element | None
    ) -> list[_Rule]:
        """The rules whose last part matches an element, and the others elements around it."""
        facts = self._facts(element)
        return [
            rule
            for before, rule in zip(
                self._progress(self._above(element, top), top), self._rules, strict=True
            )
            if before.allows(rule, len(rule.parts) - 1) and rule.parts[-1].fits(facts)
        ]

    def _facts(self, element: ElementTree.Element) -> _Facts:
        return _Facts(
            tag_of(element),
            self._classes.get(element, frozenset()),
            element.attrib,
            element is self._root,
        )


_Within = tuple[ElementTree.Element, ElementTree.Element | None]
"""An element, and the one that a ``use`` draws with it."""


class _Facts(NamedTuple):
    """The facts about an element that selectors ask for."""

    tag: str
    classes: frozenset[str]
    attributes: dict[str, str]
    is_root: bool


class _Part(NamedTuple):
    """One part of a selector, such as ``rect.a``: the type, the classes and the ids it states.

    ``attributes`` are names with values, or with None for any value. ``child`` says whether the
    element must lie directly in the one of the part before.
    """

    tag: str | None
    classes: frozenset[str]
    attributes: tuple[tuple[str, str | None], ...]
    root: bool
    child: bool

    def fits(self, facts: _Facts) -> bool:
        """Whether an element matches the part."""
        return (
            (self.tag is None or self.tag == facts.tag)
            and self.classes <= facts.classes
            and (facts.is_root or not self.root)
            and all(
                name in facts.attributes and value in (None, facts.attributes[name])
                for name, value in self.attributes
            )
        )


class _Rule(NamedTuple):
    """One selector of a style sheet, its parts from the outside in, and what it declares."""

    weight: int
    parts: list[_Part]
    pairs: list[tuple[str, str]]


class _Reached(NamedTuple):
    """How much of a rule matches an element and those around it.

    Bit k of ``here`` says whether the first k parts match, the last of them this element; that of
    ``within``, whether they match this element or one around it.
    """

    here: int
    within: int

    def allows(self, rule: _Rule, index: int) -> bool:
        """Whether an element directly inside may be that of a part."""
        bits = self.here if rule.parts[index].child else self.within
        return bool(bits >> index & 1)


NOTHING = _Reached(0, 1)


def _inside(rule: _Rule, before: _Reached, facts: _Facts) -> _Reached:
    """How much of a rule matches an element, by how much of it matches the one around it."""
    here = 0
    for index in range(min(before.within.bit_length(), len(rule.parts) - 1)):
        if before.allows(rule, index) and rule.parts[index].fits(facts):
            here |= 2 << index
    return _Reached(here, before.within | here)


def _state(own: dict[str, str], name: str, value: str) -> bool:
    """Take a value into the properties of an element, if it is one that is accepted."""
    if len(value) > LONG and name not in SHAPING:
        return False
    found = accepted(name, value)
    if found is not None:
        own[name] = found
    return found is not None


def _is_told(name: str, value: str) -> bool:
    """Whether it is said that a value is ignored; a length below 0 is meant to be."""
    return name in STYLED or (name in LENGTHS and not is_length(value) and value != "")


def _is_sheet(element: ElementTree.Element) -> bool:
    """Whether an element is a style sheet for a screen."""
    kind = element.get("type", "").strip().lower()
    return (
        tag_of(element) == "style"
        and kind in ("", "text/css")
        and _is_for_screen(element.get("media", ""))
    )


def _is_for_screen(media: str) -> bool:
    """Whether one of several queries has no condition; conditions of windows are not known."""
    return any(MEDIA.fullmatch(query) for query in media.split(","))


def _rules(css: str, unread: dict[str, None]) -> list[_Rule]:
    """The rules of a style sheet, the one that decides last.

    Selectors of types, classes, ids, attributes and the root are read, and those of elements
    within others. Others are added to ``unread``.
    """
    rules, known = [], dict[str, _Part]()
    for selectors, body in _blocks(_without_comments(css)):
        pairs = _pairs(body)
        for selector in selectors.split(",") if pairs else ():
            words = selector.replace(">", " > ").split()
            parts = [word for word in words if word != ">"]
            ends = not words or words[0] == ">" or words[-1] == ">" or "> >" in " ".join(words)
            if ends or len(parts) > MOST_PARTS or not all(map(SIMPLE.fullmatch, parts)):
                if not NEVER.search(selector):
                    unread[selector.strip()[:80]] = None
                continue
            keys = [
                ">" * (i > 0 and words[i - 1] == ">") + word
                for i, word in enumerate(words)
                if word != ">"
            ]
            # A hostile sheet may repeat a part a million times.
            known |= {key: _part(key) for key in set(keys) - known.keys()}
            rules.append(_Rule(sum(map(_weight, parts)), [known[key] for key in keys], pairs))
    if len(rules) > MOST_RULES:
        raise OverlapError(
            f"The SVG has {len(rules):,} rules of style, and at most {MOST_RULES:,} are read; "
            "simplify it."
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


SIGN = re.compile(r"[{};]")


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


def _weight(part: str) -> int:
    """The specificity of a part of a selector, as one number."""
    bare = ATTRIBUTES.sub("", part)
    types = part[0] not in ".#*[:"
    classes = bare.count(".") + len(ATTRIBUTES.findall(part)) + bare.count(":root")
    return 10_000 * bare.count("#") + 100 * classes + types


def _part(source: str) -> _Part:
    """A part of a selector, from its text."""
    child = source.startswith(">")
    source = source.removeprefix(">")
    stated = [(m[1], m[2] and m[2].strip("\"'")) for m in ATTRIBUTES.finditer(source)]
    bare = ATTRIBUTES.sub("", source)
    tag = re.match(r"[\w-]+", bare)
    names = NAMES.findall(bare)
    classes = frozenset(name for kind, name in names if kind == ".")
    stated += [("id", name) for kind, name in names if kind == "#"]
    return _Part(tag[0] if tag else None, classes, tuple(stated), ":root" in bare, child)


def _without_comments(css: str) -> str:
    first, *others = css.replace("<!--", "").replace("-->", "").split("/*")
    return first + "".join(other.partition("*/")[2] for other in others)


def _pairs(body: str) -> list[tuple[str, str]]:
    """The names and values of declarations."""
    found = [part.partition(":") for part in body.split(";")]
    return [(name.strip().lower(), value.strip()) for name, colon, value in found if colon]
