"""Transforms of SVG: of attributes, of style sheets, and from a view box to its viewport.

A matrix (3, 2) takes (x, y, 1) to the coordinates outside.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from functools import reduce
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...errors import OverlapError
from .maths import NUMBER, Measure, computed, end_of_brackets, words
from .parts import FONT_SIZE, LONG, lengths

CALL = re.compile(r"([a-zA-Z]\w*)(\s*)\(", re.ASCII)
ARGUMENT = re.compile(rf"\s*({NUMBER})\s*(,?)", re.ASCII)
GAP = re.compile(r"\s*,?\s*")
STYLED = {name: f"style {name}" for name in ("transform", "translate", "rotate", "scale")}
"""The keys of transforms that a style sheet states; their grammar is not that of attributes."""
VIEW_BOX = re.compile(rf"\s*({NUMBER})(?:\s*,\s*|\s+|(?=[+-]))" * 3 + rf"({NUMBER})\s*", re.ASCII)
ASPECT = re.compile(r"\s*(?:none|x(Min|Mid|Max)Y(Min|Mid|Max))(?:\s+(meet|slice))?\s*")
SHARES = {"Min": 0.0, "Mid": 0.5, "Max": 1.0}
TURNS = {"deg": 1.0, "grad": 0.9, "rad": 180 / math.pi, "turn": 360.0}
"""Units of angle, in degrees."""
SIDES = {"left": "0%", "top": "0%", "center": "50%", "right": "100%", "bottom": "100%"}
DEFAULT_ASPECT = "xMidYMid"


class Frame(NamedTuple):
    """What the lengths and the origin of a transform refer to.

    Attributes
    ----------
    size : (width, height)
        Of which percentages are.
    origin : (x, y)
        The point that stays in its place if the element states none.
    corner : (x, y)
        From where a stated origin is measured.
    fonts : (float, float)
        The sizes of the fonts of the element and of the document.
    """

    size: tuple[float, float]
    origin: tuple[float, float] = (0.0, 0.0)
    corner: tuple[float, float] = (0.0, 0.0)
    fonts: tuple[float, float] = (FONT_SIZE, FONT_SIZE)


NOWHERE = Frame((1.0, 1.0))
"""Where a transform is read only to know whether it can be."""


def transform_of(own: Mapping[str, str], frame: Frame) -> Array | None:
    """The transform that an element states, around its origin; None if it states none.

    Raises
    ------
    OverlapError
        The transform is too long.
    """
    # The order is fixed: shift, turn, scale, and then the list of functions.
    order = [STYLED[name] for name in ("translate", "rotate", "scale", "transform")]
    if STYLED["transform"] not in own:
        order[-1] = "transform"
    matrices = [matrix_of(name, own[name], frame) for name in order if name in own]
    found = [matrix for matrix in matrices if matrix is not None]
    if not found:
        return None
    whole = reduce(inside, found)
    around = _origin(own.get("transform-origin", ""), frame)
    if around == (0.0, 0.0):
        return whole
    return inside(inside(shifted(*around), whole), shifted(-around[0], -around[1]))


def matrix_of(name: str, value: str, frame: Frame = NOWHERE) -> Array | None:
    """The matrix of an attribute, or of a property of a style sheet; None if it cannot be read."""
    if len(value) > LONG:
        raise OverlapError(f"A transform has {len(value):,} characters; simplify the SVG.")
    if name == "transform":
        return _product(value, frame, styled=False)
    value = value.strip().lower()
    if value == "none":
        return np.eye(3, 2)
    if name == STYLED["transform"]:
        return _product(value, frame, styled=True) if value else None
    parts = words(value)
    if name == STYLED["rotate"]:
        # A turn around an axis that comes to the front is not read.
        parts = [part for part in parts if part != "z"] if parts.count("z") == 1 else parts
        parts = parts[3:] if parts[:3] == ["0", "0", "1"] else parts
    function = {"translate": "translate3d", "scale": "scale3d"}.get(name.split()[1], "rotate")
    return _called(function, parts, frame)


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
_Functions = dict[str, tuple[tuple[int, ...], str, _Make]]
FUNCTIONS: _Functions = {
    "matrix": ((6,), "n", lambda *numbers: np.reshape(numbers, (3, 2))),
    "translate": ((1, 2), "xy", lambda x, y=0.0: shifted(x, y)),
    "scale": ((1, 2), "n", lambda x, y=None: scaled(x, x if y is None else y)),
    "rotate": ((1, 3), "a", _turned_around),
    "skewX": ((1,), "a", lambda angle: skewed(angle, 0.0)),
    "skewY": ((1,), "a", lambda angle: skewed(0.0, angle)),
}
"""By name: how many arguments a function may have, what they are (along x or y, number or angle;
the last one stands for all that follow), and its matrix."""
STYLED_FUNCTIONS: _Functions = {
    **{name.lower(): function for name, function in FUNCTIONS.items()},
    "rotate": ((1,), "a", turned),
    "rotatez": ((1,), "a", turned),
    "translatex": ((1,), "x", lambda x: shifted(x, 0.0)),
    "translatey": ((1,), "y", lambda y: shifted(0.0, y)),
    "translatez": ((1,), "z", lambda z: shifted(0.0, 0.0)),
    "translate3d": ((1, 2, 3), "xyz", lambda x, y=0.0, z=0.0: shifted(x, y)),
    "scalex": ((1,), "n", lambda x: scaled(x, 1.0)),
    "scaley": ((1,), "n", lambda y: scaled(1.0, y)),
    "scalez": ((1,), "n", lambda z: scaled(1.0, 1.0)),
    "scale3d": ((1, 2, 3), "n", lambda x, y=None, z=1.0: scaled(x, x if y is None else y)),
    "skew": ((1, 2), "a", lambda x, y=0.0: skewed(x, y)),
}
"""The same for style sheets, whose lengths and angles have units. What is seen from the front does
not depend on z, because functions that turn it to the front are not read."""


def _product(source: str, frame: Frame, styled: bool) -> Array | None:
    """The matrix of a list of functions; None if it cannot be read as a whole."""
    matrix, place = np.eye(3, 2), len(source) - len(source.lstrip())
    while place < len(source):
        found = CALL.match(source, place)
        end = end_of_brackets(source, found.end()) if found else 0
        if not found or not end or (styled and found[2]):
            return None
        arguments = source[found.end() : end - 1]
        parts = words(arguments, ",") if styled else _numbers(arguments)
        one = None if parts is None else _called(found[1], parts, frame, styled)
        if one is None:
            return None
        gap = GAP.match(source, end)
        assert gap is not None
        if "," in gap[0] and (styled or gap.end() == len(source)):
            return None
        matrix, place = inside(matrix, one), gap.end()
    return matrix


def _numbers(source: str) -> list[str] | None:
    """The numbers between the brackets of an attribute's function; None if there is an error."""
    found, place, comma = list[str](), 0, ""
    while place < len(source.rstrip()):
        part = ARGUMENT.match(source, place)
        if not part:
            return None
        comma, place = part[2], part.end()
        found.append(part[1])
    return None if comma else found


def _called(name: str, parts: Sequence[str], frame: Frame, styled: bool = True) -> Array | None:
    """The matrix of a function with arguments; None if there is no such function."""
    functions = STYLED_FUNCTIONS if styled else FUNCTIONS
    counts, kinds, make = functions.get(name.lower() if styled else name, ((), "", shifted))
    if len(parts) not in counts:
        return None
    numbers = [
        _measured(part, kinds[min(i, len(kinds) - 1)], frame, styled)
        for i, part in enumerate(parts)
    ]
    return None if None in numbers else make(*numbers)


def _measured(source: str, kind: str, frame: Frame, styled: bool) -> float | None:
    """An argument of a function, as a number; None if it is of another kind."""
    side = frame.size[kind == "y"]
    known = lengths(side, frame.fonts)

    def unit(size: float, unit: str) -> Measure | None:
        small = unit.lower()
        if kind == "n":
            return Measure(size / 100 if unit else size) if unit in ("", "%") else None
        if small in TURNS:
            return Measure(size * TURNS[small], "angle")
        return None if kind == "z" and unit == "%" else known(size, unit)

    found = computed(source, unit)
    # Style sheets need units, except for zero.
    wanted = {"n": "", "a": "angle"}.get(kind, "length")
    if found is None or (styled and found.kind != wanted and (found.size or found.kind)):
        return None
    return found.size


def _origin(source: str, frame: Frame) -> tuple[float, float]:
    """The point that a transform leaves in its place."""
    found = place_of(" ".join(words(source)[:2]), frame, plain=True)
    return frame.origin if found is None else found


def place_of(source: str, frame: Frame, plain: bool = False) -> tuple[float, float] | None:
    """A point by one or two words or lengths; None if it cannot be read.

    With ``plain``, as in attributes, lengths need no units.
    """
    parts = words(source.lower())
    if not 1 <= len(parts) <= 2:
        return None
    if parts[0] in ("top", "bottom") or parts[-1] in ("left", "right"):
        parts.reverse()
    parts = parts if len(parts) == 2 else [*parts, "center"]
    if parts[0] in ("top", "bottom"):
        parts.reverse()
    found = [
        computed(SIDES.get(part, part), lengths(side, frame.fonts))
        for part, side in zip(parts, frame.size, strict=True)
    ]
    if any(one is None or (one.size and not one.kind and not plain) for one in found):
        return None
    x, y = (one.size + corner for one, corner in zip(found, frame.corner, strict=True) if one)
    return x, y


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
