"""Clip paths that are shapes of CSS, such as ``circle(40%)`` or ``inset(3px round 2px)``."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence

from ...arrays import Array
from .maths import computed, end_of_brackets, words
from .parts import Drawn, lengths
from .transforms import Frame, inside, place_of, shifted

CALL = re.compile(r"([a-z]+)\(", re.IGNORECASE)
STRING = re.compile(r"""\s*(?:"([^"]*)"|'([^']*)')\s*""")
FILLS = frozenset({"fill-box", "content-box", "padding-box"})
BOXES = FILLS | {"stroke-box", "border-box", "margin-box", "view-box"}
"""Boxes in which a shape is measured; the others are around the stroke, or the viewport."""
RULES = frozenset({"nonzero", "evenodd"})


def shape_and_box(value: str) -> tuple[str, str, str] | None:
    """The name of a shape, what is in its brackets, and its box; None if that is not known.

    The name of a box alone has no shape.
    """
    parts = words(value)
    boxes = [part.lower() for part in parts if part.lower() in BOXES]
    shapes = [part for part in parts if part.lower() not in BOXES]
    if len(boxes) > 1 or len(shapes) > 1 or not parts:
        return None
    box = boxes[0] if boxes else "border-box"
    if not shapes:
        return "inset", "0", box
    found = CALL.match(shapes[0])
    if not found or found[1].lower() not in SHAPES:
        return None
    if end_of_brackets(shapes[0], found.end()) != len(shapes[0]):
        return None
    return found[1].lower(), shapes[0][found.end() : -1], box


def is_shape(value: str) -> bool:
    """Whether a value is a shape that can be read."""
    found = shape_and_box(value)
    return found is not None and _form(found[0], found[1], Frame((1.0, 1.0))) is not None


def clip_of(
    name: str, arguments: str, box: Array, matrix: Array, fonts: tuple[float, float]
) -> Drawn | None:
    """A shape as one of a clip path; None if it has no finite size.

    Parameters
    ----------
    name, arguments : str
        From :func:`shape_and_box`.
    box : (2, 2) array
        The box in which it is measured.
    matrix : (3, 2) array
        From its coordinates to those of the document.
    """
    (left, top), (width, height) = box[0].tolist(), (box[1] - box[0]).tolist()
    found = _form(name, arguments, Frame((width, height), fonts=fonts))
    if found is None:
        return None
    tag, attributes, rule = found
    return Drawn(tag, attributes, {"clip-rule": rule}, inside(matrix, shifted(left, top)), ())


_Form = tuple[str, dict[str, str], str]
"""An element with its attributes, and the rule by which it is filled."""


def _form(name: str, arguments: str, frame: Frame) -> _Form | None:
    """The element that has the form of a shape, in a box at the origin; None if it has an error."""
    make = SHAPES[name]
    try:
        return make(arguments, frame)
    except _ShapeError:
        return None


class _ShapeError(Exception):
    """A shape has an error."""


def _length(source: str, side: float, frame: Frame) -> float:
    found = computed(source, lengths(side, frame.fonts))
    if found is None or (found.kind != "length" and found.size):
        raise _ShapeError
    return found.size


def _radius(source: str, side: float, frame: Frame) -> float:
    if source.startswith("-"):
        raise _ShapeError
    return max(_length(source, side, frame), 0.0)


def _circle(arguments: str, frame: Frame) -> _Form:
    radii, (x, y) = _radii_and_place(arguments, frame, 1)
    away = [abs(x), abs(frame.size[0] - x), abs(y), abs(frame.size[1] - y)]
    named = {"closest-side": min(away), "farthest-side": max(away)}
    r = named.get(radii[0])
    r = _radius(radii[0], math.hypot(*frame.size) / 2**0.5, frame) if r is None else r
    return "circle", {"cx": repr(x), "cy": repr(y), "r": repr(r)}, "nonzero"


def _ellipse(arguments: str, frame: Frame) -> _Form:
    radii, place = _radii_and_place(arguments, frame, 2)
    sizes = list[float]()
    for part, at, side in zip(radii, place, frame.size, strict=True):
        away = [abs(at), abs(side - at)]
        named = {"closest-side": min(away), "farthest-side": max(away)}
        sizes.append(named[part] if part in named else _radius(part, side, frame))
    (x, y), (rx, ry) = place, sizes
    return "ellipse", {"cx": repr(x), "cy": repr(y), "rx": repr(rx), "ry": repr(ry)}, "nonzero"


def _radii_and_place(
    arguments: str, frame: Frame, count: int
) -> tuple[list[str], tuple[float, float]]:
    """The radii of a circle or an ellipse, as they are stated, and its centre."""
    parts = words(arguments.lower())
    at = parts.index("at") if "at" in parts else len(parts)
    place = place_of(" ".join(parts[at + 1 :]) if at < len(parts) else "center", frame)
    radii = parts[:at] or ["closest-side"] * count
    if place is None or len(radii) != count:
        raise _ShapeError
    return radii, place


def _inset(arguments: str, frame: Frame) -> _Form:
    sides, corners = _sides(arguments, frame)
    top, right, bottom, left = sides
    return _rounded(
        left, top, frame.size[0] - left - right, frame.size[1] - top - bottom, corners, frame
    )


def _sides(arguments: str, frame: Frame) -> tuple[list[float], list[str]]:
    """Distances from the top, right, bottom and left side, and what is said of the corners."""
    given, corners = _before_corners(arguments)
    width, height = frame.size
    sides = zip(_four(given), (height, width, height, width), strict=True)
    return [_length(part, side, frame) for part, side in sides], corners


def _before_corners(arguments: str) -> tuple[list[str], list[str]]:
    """The arguments before the word ``round``, and those after it."""
    parts = words(arguments)
    cut = next((i for i, part in enumerate(parts) if part.lower() == "round"), len(parts))
    if cut == len(parts) - 1:
        raise _ShapeError
    return parts[:cut], parts[cut + 1 :]


def _four(parts: Sequence[str]) -> list[str]:
    """Values for four sides or corners, of which those that are missing repeat others."""
    if not 1 <= len(parts) <= 4:
        raise _ShapeError
    one = list(parts)
    for i in range(len(one), 4):
        one.append(one[max(0, i - 2)])
    return one


def _rounded(
    x: float, y: float, width: float, height: float, corners: list[str], frame: Frame
) -> _Form:
    """A rectangle whose corners may be rounded, as a path."""
    width, height = max(width, 0.0), max(height, 0.0)
    if not corners:
        corners = ["0"]
    cut = corners.index("/") if "/" in corners else len(corners)
    across = [_radius(part, frame.size[0], frame) for part in _four(corners[:cut])]
    up = [
        _radius(part, frame.size[1], frame) for part in _four(corners[cut + 1 :] or corners[:cut])
    ]
    # Radii that do not fit side by side are made smaller together.
    rooms = [
        (width, across[0] + across[1]), (width, across[2] + across[3]),
        (height, up[0] + up[3]), (height, up[1] + up[2]),
    ]  # fmt: skip
    scale = min([1.0, *(room / need for room, need in rooms if need > 0)])
    (a, b, c, d), (e, f, g, h) = ([scale * size for size in row] for row in (across, up))
    right, bottom = x + width, y + height
    path = (
        f"M{x + a!r} {y!r}L{right - b!r} {y!r}A{b!r} {f!r} 0 0 1 {right!r} {y + f!r}"
        f"L{right!r} {bottom - g!r}A{c!r} {g!r} 0 0 1 {right - c!r} {bottom!r}"
        f"L{x + d!r} {bottom!r}A{d!r} {h!r} 0 0 1 {x!r} {bottom - h!r}"
        f"L{x!r} {y + e!r}A{a!r} {e!r} 0 0 1 {x + a!r} {y!r}Z"
    )
    return "path", {"d": path}, "nonzero"


def _rule(arguments: str) -> tuple[str, list[str]]:
    """The rule by which a polygon or a path is filled, and the rest."""
    parts = words(arguments, ",")
    if parts and parts[0].lower() in RULES:
        return parts[0].lower(), parts[1:]
    return "nonzero", parts


def _polygon(arguments: str, frame: Frame) -> _Form:
    rule, parts = _rule(arguments)
    points = [words(part) for part in parts]
    if not points or any(len(point) != 2 for point in points):
        raise _ShapeError
    pairs = [zip(point, frame.size, strict=True) for point in points]
    numbers = [_length(part, side, frame) for pair in pairs for part, side in pair]
    return "polygon", {"points": " ".join(map(repr, numbers))}, rule


def _path(arguments: str, frame: Frame) -> _Form:
    rule, parts = _rule(arguments)
    found = STRING.fullmatch(parts[0]) if len(parts) == 1 else None
    if not found:
        raise _ShapeError
    return "path", {"d": found[1] or found[2] or ""}, rule


def _xywh(arguments: str, frame: Frame) -> _Form:
    given, corners = _before_corners(arguments)
    if len(given) != 4:
        raise _ShapeError
    x, y, width, height = (
        _length(part, side, frame) for part, side in zip(given, frame.size * 2, strict=True)
    )
    return _rounded(x, y, width, height, corners, frame)


def _rect(arguments: str, frame: Frame) -> _Form:
    """A rectangle by the distances of its sides from the left and from the top."""
    ends = {"auto": "0%"}, {"auto": "100%"}, {"auto": "100%"}, {"auto": "0%"}
    parts = words(arguments)
    given = [end.get(part.lower(), part) for part, end in zip(parts, ends, strict=False)]
    (top, right, bottom, left), corners = _sides(" ".join([*given, *parts[4:]]), frame)
    if len(given) < 4 or given[3].lower() == "round":
        raise _ShapeError
    return _rounded(left, top, right - left, bottom - top, corners, frame)


SHAPES: dict[str, Callable[[str, Frame], _Form]] = {
    **{"circle": _circle, "ellipse": _ellipse, "inset": _inset},
    **{"polygon": _polygon, "path": _path, "xywh": _xywh, "rect": _rect},
}
