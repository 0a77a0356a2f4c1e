"""The properties that style sheets within an SVG, and style attributes, give to its elements."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple
from xml.etree import ElementTree

from ...errors import OverlapError
from ...limits import limits
from .parts import SHAPING
from .selectors import Facts, places_among
from .sheets import (
    MOST_TOLD,
    Rule,
    declared_in,
    is_sheet,
    is_told,
    rules_of,
    state,
    without_comments,
)

NAMESPACES = ("", "http://www.w3.org/2000/svg")
ROOM = 4
"""Elements at which rules for elements after others look, by those that may be drawn."""


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
        sheets = [e.text or "" for e in root.iter() if tag_of(e) == "style" and is_sheet(e)]
        self.unread: dict[str, None] = {}
        """Selectors that are not read."""
        self._rules = rules_of("\n".join(sheets), self.unread)
        parts = [part for rule in self._rules for part in rule.parts]
        self._before = dict[ElementTree.Element, ElementTree.Element]()
        if any(part.sign in "+~" for part in parts):
            self._before = {after: one for e in root.iter() for one, after in pairwise(e)}
        self.dropped: dict[ElementTree.Element, list[str]] = {}
        """What elements state of their form and place that cannot be read."""
        self._root, self._start = root, [START] * len(self._rules)
        self._known: dict[_Within, dict[str, str]] = {}
        self._reached: dict[_Within, list[_Reached]] = {}
        self._facts: dict[ElementTree.Element, Facts] = {}

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
        own, dropped = dict[str, str](), list[str]()
        for name, value in element.attrib.items():
            value = value if name in SHAPING else value.strip()
            if not state(own, name, value) and is_told(name, value):
                dropped.append(f"{name}={value!r:.80}")
        declared = [rule.declared for rule in self._matching(element, top)]
        declared.append(declared_in(without_comments(element.get("style", ""))))
        for one in declared:
            own |= one.normal
            dropped += one.dropped
        for one in declared:
            own |= one.important
        if dropped:
            self.dropped[element] = dropped[:MOST_TOLD]
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

        The last part of a rule is left out. An element continues where the one around it and the
        one before it end, so nothing is compared again for each element inside.
        """
        path, above = [], element
        while above is not None and (above, top) not in self._reached:
            path.append(above)
            above = self._above(above, top)
        around = self._start if above is None else self._reached[above, top]
        for one in reversed(path):
            around = self._along(one, top, around)
        return around

    def _along(
        self,
        element: ElementTree.Element | None,
        top: ElementTree.Element | None,
        around: list[_Reached],
    ) -> list[_Reached]:
        """The same for an element, by that of the one around it and those of the ones before it."""
        row = []
        while element is not None and (element, top) not in self._reached:
            row.append(element)
            element = self._previous(element, top)
        beside = self._start if element is None else self._reached[element, top]
        for one in reversed(row):
            facts = self._facts_of(one)
            beside = [
                _inside(rule, outer, before, facts) if len(rule.parts) > 1 else START
                for rule, outer, before in zip(self._rules, around, beside, strict=True)
            ]
            self._reached[one, top] = beside
        self._check_size()
        return beside

    def _check_size(self) -> None:
        """Refuse a document in which rules for siblings look at too many elements."""
        if len(self._reached) > ROOM * limits.svg_elements:
            raise OverlapError(
                "The SVG has rules of style for elements after others, and more than "
                f"{ROOM * limits.svg_elements:,} elements; simplify it or raise "
                "vf.limits.svg_elements."
            )

    def _previous(
        self, element: ElementTree.Element, top: ElementTree.Element | None
    ) -> ElementTree.Element | None:
        """The element before one, if a rule asks for it."""
        return None if element is top else self._before.get(element)

    def _matching(
        self, element: ElementTree.Element, top: ElementTree.Element | None
    ) -> list[Rule]:
        """The rules that an element matches."""
        around = self._progress(self._above(element, top), top)
        beside = self._along(self._previous(element, top), top, around)
        facts = self._facts_of(element)
        return [
            rule
            for rule, outer, before in zip(self._rules, around, beside, strict=True)
            if _allows(rule, len(rule.parts) - 1, outer, before) and rule.parts[-1].fits(facts)
        ]

    def _facts_of(self, element: ElementTree.Element) -> Facts:
        """The facts about an element; those of all elements beside it are collected at once."""
        if element not in self._facts:
            above = self._parents.get(element)
            row = [element] if above is None else list(above)
            for one, places in zip(row, places_among([e.tag for e in row]), strict=True):
                self._facts[one] = Facts(
                    tag_of(one),
                    frozenset(one.get("class", "").split()),
                    one.attrib,
                    places,
                    one is self._root,
                    not len(one) and not one.text,
                )
        return self._facts[element]


_Within = tuple[ElementTree.Element, ElementTree.Element | None]
"""An element, and the one that a ``use`` draws with it."""


class _Reached(NamedTuple):
    """How much of a rule matches an element and those around it and before it.

    Bit k of ``here`` says whether the first k parts match, the last of them this element; that of
    ``within``, whether they match this element or one around it; that of ``beside``, whether they
    match this element or one before it in the same element.
    """

    here: int
    within: int
    beside: int


START = _Reached(0, 1, 0)


def _allows(rule: Rule, index: int, around: _Reached, before: _Reached) -> bool:
    """Whether an element may be that of a part, by how much matches those around and before it."""
    sign = rule.parts[index].sign
    if sign in (" ", ">"):
        bits = around.within if sign == " " else around.here
    else:
        bits = before.here if sign == "+" else before.beside
    return bool(bits >> index & 1)


def _inside(rule: Rule, around: _Reached, before: _Reached, facts: Facts) -> _Reached:
    """How much of a rule matches an element."""
    here, reached = 0, around.within | before.beside
    for index in range(min(reached.bit_length(), len(rule.parts) - 1)):
        if _allows(rule, index, around, before) and rule.parts[index].fits(facts):
            here |= 2 << index
    return _Reached(here, around.within | here, before.beside | here)
