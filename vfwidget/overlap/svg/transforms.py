"""Transforms of SVG: of attributes, of style sheets, and from a view box to its viewport.

A matrix (3, 2) takes (x, y, 1) to the coordinates outside.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from ...arrays import Array
from ...errors import OverlapError
from .parts import NUMBER, length
from .style import LONG, STYLED

FUNCTION = re.compile(r"([a-zA-Z]+)\s*\(([^()]*)\)[\s,]*", re.ASCII)
ARGUMENT = re.compile(rf"\s*({NUMBER})(%|[a-zA-Z]*)\s*(,?)", re.ASCII)
VIEW_BOX = re.compile(rf"\s*({NUMBER})(?:\s*,\s*|\s+|(?=[+-]))" * 3 + rf"({NUMBER})\s*", re.ASCII)
ASPECT = re.compile(r"\s*(?:none|x(Min|Mid|Max)Y(Min|Mid|Max))(?:\s+(meet|slice))?\s*")
SHARES = {"Min": 0.0, "Mid": 0.5, "Max": 1.0}
TURNS = {"": 1.0, "deg": 1.0, "grad": 0.9, "rad": 180 / math.pi, "turn": 360.0}
"""Units of angle, in degrees."""
SIDES = {"left": "0%", "top": "0%", "center": "50%", "right": "100%", "bottom": "100%"}
DEFAULT_ASPECT = "xMidYMid"


def transform_of(
    own: Mapping[str, str], size: tuple[float, float], origin: tuple[float, float] = (0.0, 0.0)
) -> Array | None:
    """The transform that an element states, around its origin; None if it states none.

    Parameters
    ----------
    own : mapping of str to str
        The attributes and properties of the element.
    size : (width, height)
        Of the viewport, of which percentages are.
    origin : (x, y)
        The point that stays in its place if the element states none.

    Raises
    ------
    OverlapError
        The transform is too long, or cannot be read.
    """
    styled = own.get(STYLED)
    source = own.get("transform") if styled is None else styled
    if not source:
        return None
    if len(source) > LONG:
        raise OverlapError(f"A transform has {len(source):,} characters; simplify the SVG.")
    matrix = _product(source, size, styled is not None)
    if matrix is None and source.strip().lower() == "none":
        return None
    if matrix is None:
        raise OverlapError(
            f"The transform {source!r:.100} cannot be read; state it as in translate(3, 4)."
        )
    around = _origin(own.get("transform-origin", ""), size) or origin
    if around == (0.0, 0.0):
        return matrix
    return inside(inside(shifted(*around), matrix), shifted(-around[0], -around[1]))


def inside(outer: Array, inner: Array) -> Array:
    """The matrix (3, 2) of a transform within another one."""
    return np.asarray(np.column_stack([inner, [0.0, 0.0, 1.0]]) @ outer)


def shifted(x: float, y: float) -> Array:
    """The matrix of a shift."""
    return np.array([[1.0, 0.0], [0.0, 1.0], [x, y]])


def turned(degrees: float) -> Array:
    """The matrix of a turn; the y axis points down."""
    cosine, sine = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return np.array([[cosine, sine], [-sine, cosine], [0.0, 0.0]])


def scaled(x: float, y: float) -> Array:
    """The matrix of a change of size."""
    return np.array([[x, 0.0], [0.0, y], [0.0, 0.0]])


def skewed(x: float, y: float) -> Array:
    """The matrix that slants by angles in degrees."""
    along, up = (math.tan(math.radians(angle)) for angle in (x, y))
    return np.array([[1.0, up], [along, 1.0], [0.0, 0.0]])


def _turned_around(degrees: float, x: float = 0.0, y: float = 0.0) -> Array:
    return inside(inside(shifted(x, y), turned(degrees)), shifted(-x, -y))


_Make = Callable[..., Array]
FUNCTIONS: dict[str, tuple[tuple[int, ...], str, _Make]] = {
    "matrix": ((6,), "", lambda *numbers: np.reshape(numbers, (3, 2))),
    "translate": ((1, 2), "xy", lambda x, y=0.0: shifted(x, y)),
    "scale": ((1, 2), "", lambda x, y=None: scaled(x, x if y is None else y)),
    "rotate": ((1, 3), "angle", _turned_around),
    "skewX": ((1,), "angle", lambda angle: skewed(angle, 0.0)),
    "skewY": ((1,), "angle", lambda angle: skewed(0.0, angle)),
}
"""By name: how many arguments a function may have, what they are, and its matrix."""
STYLED_FUNCTIONS: dict[str, tuple[tuple[int, ...], str, _Make]] = {
    **FUNCTIONS,
    "rotate": ((1,), "angle", turned),
    "translateX": ((1,), "x", lambda x: shifted(x, 0.0)),
    "translateY": ((1,), "y", lambda y: shifted(0.0, y)),
    "scaleX": ((1,), "", lambda x: scaled(x, 1.0)),
    "scaleY": ((1,), "", lambda y: scaled(1.0, y)),
    "skew": ((1, 2), "angle", lambda x, y=0.0: skewed(x, y)),
}
"""The same for style sheets, whose lengths and angles have units."""


def _product(source: str, size: tuple[float, float], styled: bool) -> Array | None:
    """The matrix of a list of functions; None if it cannot be read as a whole."""
    functions = STYLED_FUNCTIONS if styled else FUNCTIONS
    known = {name.lower(): one for name, one in functions.items()} if styled else functions
    matrix, place = np.eye(3, 2), len(source) - len(source.lstrip())
    while place < len(source):
        found = FUNCTION.match(source, place)
        name = found[1].lower() if found and styled else found and found[1]
        if not found or name not in known:
            return None
        counts, kind, make = known[name]
        numbers = _arguments(found[2], kind, size, styled)
        if numbers is None or len(numbers) not in counts:
            return None
        matrix, place = inside(matrix, make(*numbers)), found.end()
    return matrix


def _arguments(
    source: str, kind: str, size: tuple[float, float], styled: bool
) -> list[float] | None:
    """The numbers between the brackets of a function; None if they cannot be read."""
    found, place, comma = list[float](), 0, ""
    while place < len(source.rstrip()):
        part = ARGUMENT.match(source, place)
        if not part:
            return None
        number, unit, comma = float(part[1]), part[2], part[3]
        if not math.isfinite(number):
            return None
        if styled and number and not unit and kind:
            return None  # Style sheets need units.
        if unit and not styled:
            return None
        if kind == "angle" and unit.lower() in TURNS:
            number *= TURNS[unit.lower()]
        elif unit and kind in ("x", "y", "xy"):
            side = "x" if kind == "x" or (kind == "xy" and not found) else "y"
            number = length(side, part[1] + unit, size) or 0.0
        elif unit:
            return None
        found.append(number)
        place = part.end()
    return None if comma else found


def _origin(source: str, size: tuple[float, float]) -> tuple[float, float] | None:
    """The point that a transform leaves in its place, if one is stated."""
    words = source.lower().split()[:2]
    if not words:
        return None
    if words[0] in ("top", "bottom") or words[-1] in ("left", "right"):
        words.reverse()
    words = words if len(words) == 2 else [*words, "center"]
    if words[0] in ("top", "bottom"):
        words.reverse()
    found = [length(n, SIDES.get(w, w), size) for n, w in zip("xy", words, strict=True)]
    return None if None in found else (float(found[0] or 0), float(found[1] or 0))


def view_box(own: Mapping[str, str]) -> list[float] | None:
    """Left, top, width and height of a view box; None if none can be read."""
    found = VIEW_BOX.fullmatch(own.get("viewBox", ""))
    numbers = [float(number) for number in found.groups()] if found else [math.inf]
    return numbers if all(map(math.isfinite, numbers)) and min(numbers[2:]) >= 0 else None


def fitted(box: Sequence[float], form: Sequence[float], aspect: str | None) -> Array:
    """The matrix from the coordinates of a view box to those around its viewport.

    Parameters
    ----------
    box, form : (left, top, width, height)
        The view box, and the viewport.
    aspect : str, optional
        The attribute preserveAspectRatio.
    """
    found = ASPECT.fullmatch(aspect or "") or ASPECT.fullmatch(DEFAULT_ASPECT)
    assert found is not None
    wide, high = form[2] / box[2], form[3] / box[3]
    if found[1] is None:
        return np.array([[wide, 0], [0, high], [form[0] - wide * box[0], form[1] - high * box[1]]])
    scale = max(wide, high) if found[3] == "slice" else min(wide, high)
    shift = [
        form[i] - scale * box[i] + SHARES[found[1 + i]] * (form[2 + i] - scale * box[2 + i])
        for i in (0, 1)
    ]
    return np.array([[scale, 0.0], [0.0, scale], shift])
