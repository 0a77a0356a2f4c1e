"""Constraints of an editor, as JSON that the view reads and writes, and as terms of an energy."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ..energy.handle_terms import PIN_WEIGHT, Collinear, Distance, SharedX, SharedY
from ..energy.term import LARGEST, Term
from ..energy.word_terms import Width
from ..errors import SolveError
from ..solver.problem import is_number
from ..text import Handle, Text

MOST = 1000
"""Points of one constraint: each is a row of the solver's matrices."""
COUNTS = {"SharedX": (2, MOST), "SharedY": (2, MOST), "Collinear": (3, MOST), "Distance": (2, 2)}
"""The least and the greatest number of points of each kind."""
VALUED = ("Distance", "Width")
"""Kinds with a length in font units."""


def place(handle: Handle) -> list[Any]:
    """A handle as JSON: ``[letter, contour, segment, t]``."""
    return [handle.glyph, handle.contour, handle.segment, handle.t]


def checked_constraints(constraints: Any, text: Text) -> tuple[dict[str, Any], ...]:
    """Constraints given as JSON or as terms, as JSON.

    Parameters
    ----------
    constraints : list of dict or Term
        ``{"kind": "SharedX" | "SharedY" | "Collinear", "handles": [[letter, contour, segment, t],
        …]}``, the same with ``"kind": "Distance"`` and ``"value"``, or ``{"kind": "Width",
        "value": …}``; or the terms of these names.
    text : Text

    Raises
    ------
    SolveError
        They are not a list, or one of them is malformed, or has a point that the text lacks.
    """
    if not isinstance(constraints, list | tuple):
        raise SolveError(f"constraints must be a list; received {constraints!r}.")
    return tuple(_checked(constraint, text) for constraint in constraints)


def _checked(constraint: Any, text: Text) -> dict[str, Any]:
    raw = _from_term(constraint, text) if isinstance(constraint, Term) else constraint
    kind = raw.get("kind") if isinstance(raw, Mapping) else None
    if not isinstance(kind, str) or (kind != "Width" and kind not in COUNTS):
        kinds = ", ".join([*COUNTS, "Width"])
        raise SolveError(f"A constraint is one of {kinds}; received {constraint!r}.")
    checked: dict[str, Any] = {"kind": kind, "handles": []}
    if kind in COUNTS:
        least, most = COUNTS[kind]
        handles = raw.get("handles")
        if not isinstance(handles, list | tuple) or not least <= len(handles) <= most:
            number = f"{least} points" if most == least else f"{least} to {most} points"
            raise SolveError(f"{kind} takes {number}; received {handles!r}.")
        checked["handles"] = [_checked_place(handle, text) for handle in handles]
    if kind in VALUED:
        checked["value"] = _checked_length(kind, raw.get("value"))
    return checked


def _checked_length(kind: str, value: Any) -> float:
    if is_number(value) and 0 <= value <= LARGEST:
        return float(value)
    raise SolveError(
        f"The value of a {kind} is a length ≥ 0 of at most {LARGEST:g} font units; "
        f"received {value!r:.200}."
    )


def _checked_place(handle: Any, text: Text) -> list[Any]:
    if isinstance(handle, Handle):
        handle = place(handle)
    if isinstance(handle, list | tuple) and len(handle) == 4:
        return place(text.handle(*handle))
    raise SolveError(f"A point is [letter, contour, segment, t]; received {handle!r}.")


def _from_term(term: Term, text: Text) -> dict[str, Any]:
    """A term in the form of JSON, which need not be valid.

    The handles may belong to a former word with the same letters.
    """
    handles: Any = term.handles
    raw: dict[str, Any] = {
        "kind": type(term).__name__,
        "handles": list(handles) if isinstance(handles, Sequence) else handles,
    }
    if isinstance(term, Width):
        return {"kind": "Width", "value": term.width}
    if isinstance(term, Distance):
        if term.along is not None:
            raise SolveError("An editor keeps distances that are measured straight: along=None.")
        raw["value"] = term.length
        if term.length is None:
            ends = [text.position(text.handle(*_checked_place(h, text))) for h in handles]
            raw["value"] = float((ends[1] - ends[0]).norm())
    return raw


def terms(constraints: tuple[dict[str, Any], ...], text: Text) -> list[Term]:
    """The terms of checked constraints. They outweigh targets, as pins do."""
    made: list[Term] = []
    for constraint in constraints:
        handles = [text.handle(*handle) for handle in constraint["handles"]]
        kind = constraint["kind"]
        if kind == "Width":
            made.append(Width(constraint["value"], weight=PIN_WEIGHT))
        elif kind == "Distance":
            first, second = handles
            made.append(Distance(first, second, constraint["value"], weight=PIN_WEIGHT))
        else:
            several = {"SharedX": SharedX, "SharedY": SharedY, "Collinear": Collinear}[kind]
            made.append(several(handles, weight=PIN_WEIGHT))
    return made
