"""The paths of SVG shapes: moves, and cubics from there.

A path is read up to its first error, as browsers do.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from ...arrays import Array
from ...outline.cubics import chord
from .parts import number

COMMA = re.compile(r"\s*,?\s*")
NUMBER = re.compile(r"[+-]?(?:\d*\.\d+|\d+)(?:[eE][+-]?\d+)?", re.ASCII)
FLAG = re.compile(r"[01]")
COMMAND = re.compile(r"\s*([MmZzLlHhVvCcSsQqTtAa])\s*")
COUNTS = {"M": 2, "L": 2, "H": 1, "V": 1, "C": 6, "S": 4, "Q": 4, "T": 2, "A": 7, "Z": 0}
"""How many numbers a command takes; more of them repeat it."""
LARGEST, LEAST = float(np.finfo(np.float32).max), float(np.finfo(np.float32).smallest_subnormal)
"""Browsers read no larger numbers, so a path ends before them; smaller ones are 0."""
FLAT = 1e-7
"""An arc is straight if half its chord is shorter, by the size of its radius: its height above the
chord is a quarter of that."""
QUARTER = math.pi / 2
ROUNDING = 1e-9
"""Sides of a rectangle that are shorter, by its size, are no sides."""
MOVE, DRAW, CLOSE = "move", "draw", "close"


class Step(NamedTuple):
    """One command of a path.

    Attributes
    ----------
    kind : str
        "move", "draw" or "close".
    curves : list of (4, 2) arrays
        The cubics that it draws; none for a move.
    end : (2,) array
        Where it ends.
    """

    kind: str
    curves: list[Array]
    end: Array


def path_of(tag: str, form: Mapping[str, str]) -> list[Step]:
    """The path of a shape, from its attributes; empty if it draws nothing."""
    if tag == "path":
        return _commands(form.get("d", ""))
    if tag in ("polyline", "polygon"):
        return _polygon(form.get("points", ""), tag == "polygon")
    given = {name: number(form.get(name), 0.0) for name in ("x1", "y1", "x2", "y2", "cx", "cy")}
    if tag == "line":
        ends = [(given["x1"], given["y1"]), (given["x2"], given["y2"])]
        return _through(ends, closed=False)
    if tag == "rect":
        return _rectangle(form)
    radii = [
        number(form.get(name), 0.0) for name in (("r", "r") if tag == "circle" else ("rx", "ry"))
    ]
    return _ellipse(np.array([given["cx"], given["cy"]]), *radii)


def subpaths(path: Sequence[Step]) -> list[tuple[Array, bool]]:
    """The cubic segments (s, 4, 2) of each subpath, and whether it is closed."""
    found: list[tuple[list[Array], bool]] = []
    for step in path:
        ended = step.kind != MOVE and found[-1][1]
        if ended and step.kind == CLOSE:
            continue
        if step.kind == MOVE or ended:
            # After the end of a closed subpath, the next one begins at the same point.
            found.append(([], False))
        if step.kind != MOVE:
            found[-1][0].extend(step.curves)
        if step.kind == CLOSE:
            found[-1] = (found[-1][0], True)
    return [(np.array(segments), closed) for segments, closed in found if segments]


def _through(points: Sequence[Sequence[float]], closed: bool) -> list[Step]:
    """Straight lines from point to point."""
    places = [np.array(point, dtype=float) for point in points]
    steps = [Step(MOVE, [], places[0])]
    for start, end in pairwise(places):
        steps.append(Step(DRAW, [chord(start, end)], end))
    if closed:
        steps.append(Step(CLOSE, [chord(places[-1], places[0])], places[0]))
    return steps


def _polygon(source: str, closed: bool) -> list[Step]:
    """A polygon or a row of lines through points, up to the first error."""
    numbers, place = list[float](), len(source) - len(source.lstrip())
    while (found := NUMBER.match(source, place)) and abs(float(found[0])) <= LARGEST:
        numbers.append(float(found[0]))
        gap = COMMA.match(source, found.end())
        place = gap.end() if gap else found.end()
    pairs = list(zip(numbers[::2], numbers[1::2], strict=False))
    return _through(pairs, closed) if pairs and place >= len(source) else []


def _rectangle(form: Mapping[str, str]) -> list[Step]:
    """A rectangle, whose corners may be rounded."""
    x, y, width, height = (number(form.get(n), 0.0) for n in ("x", "y", "width", "height"))
    given = [number(form.get(name), -1.0) for name in ("rx", "ry")]
    # A radius that is not stated, or below 0, is the other one.
    rx, ry = (one if one >= 0 else max(other, 0.0) for one, other in (given, given[::-1]))
    rx, ry = min(rx, width / 2), min(ry, height / 2)
    right, bottom = x + width, y + height
    if min(rx, ry) <= 0:
        return _through([(x, y), (right, y), (right, bottom), (x, bottom)], closed=True)
    steps = [Step(MOVE, [], np.array([x + rx, y]))]
    corners = [
        ((right - rx, y), (right, y + ry)),
        ((right, bottom - ry), (right - rx, bottom)),
        ((x + rx, bottom), (x, bottom - ry)),
        ((x, y + ry), (x + rx, y)),
    ]
    for before, after in corners:
        start, end = np.array(before), np.array(after)
        if abs(steps[-1].end - start).max() > ROUNDING * (width + height):
            steps.append(Step(DRAW, [chord(steps[-1].end, start)], start))
        start = steps[-1].end
        steps.append(Step(DRAW, _arc(start, rx, ry, 0.0, False, True, end), end))
    # Rounding leaves no side between two corners that meet.
    steps[-1].curves[-1][3] = steps[0].end
    return [*steps, Step(CLOSE, [chord(steps[0].end, steps[0].end)], steps[0].end)]


def _ellipse(centre: Array, rx: float, ry: float) -> list[Step]:
    """An ellipse, clockwise from its right end."""
    ends = [centre + np.array(one) * [rx, ry] for one in ((1, 0), (0, 1), (-1, 0), (0, -1), (1, 0))]
    steps = [Step(MOVE, [], ends[0])]
    for start, end in pairwise(ends):
        steps.append(Step(DRAW, _arc(start, rx, ry, 0.0, False, True, end), end))
    return [*steps, Step(CLOSE, [chord(ends[0], ends[0])], ends[0])]


def _commands(source: str) -> list[Step]:
    """The steps of path data, up to the first error; the library would refuse it as a whole."""
    from svg.path import parse_path

    return [_step(segment) for segment in parse_path(" ".join(_tokens(source)))]


def _step(segment: Any) -> Step:
    """A step from a segment of the library, whose points are complex numbers."""
    from svg.path import Arc, Close, CubicBezier, Move, QuadraticBezier

    start, end = _point(segment.start), _point(segment.end)
    if isinstance(segment, Move):
        return Step(MOVE, [], end)
    if isinstance(segment, Arc):
        rx, ry = _point(segment.radius)
        curves = _arc(start, rx, ry, segment.rotation, segment.arc, segment.sweep, end)
        return Step(DRAW, curves, end)
    if isinstance(segment, CubicBezier):
        handles = [_point(segment.control1), _point(segment.control2)]
    elif isinstance(segment, QuadraticBezier):
        # Exactly at the ends where the control point is.
        handles = [one + 2 / 3 * (_point(segment.control) - one) for one in (start, end)]
    else:
        return Step(CLOSE if isinstance(segment, Close) else DRAW, [chord(start, end)], end)
    return Step(DRAW, [np.stack([start, *handles, end])], end)


def _point(place: complex) -> Array:
    return np.array([place.real, place.imag])


def _tokens(source: str) -> Iterator[str]:
    """Commands with their numbers, one after the other; those that repeat a move are lines."""
    place, first = 0, True
    while found := COMMAND.match(source, place):
        letter, place = found[1], found.end()
        if first and letter not in "Mm":
            return  # A path that does not begin with a move is not drawn.
        first = False
        if letter in "Zz":
            yield letter
            continue
        while True:
            numbers, after = _numbers(source, place, letter)
            if numbers is None:
                return
            yield f"{letter} {' '.join(numbers)}"
            letter = {"M": "L", "m": "l"}.get(letter, letter)
            gap = COMMA.match(source, after)
            place = gap.end() if gap else after
            if not NUMBER.match(source, place):
                if gap and "," in gap[0]:
                    return
                break


def _numbers(source: str, place: int, letter: str) -> tuple[list[str] | None, int]:
    """The numbers of one command, and where they end; None if some are missing."""
    found = list[str]()
    for i in range(COUNTS[letter.upper()]):
        if found:
            gap = COMMA.match(source, place)
            place = gap.end() if gap else place
        pattern = FLAG if letter in "Aa" and i in (3, 4) else NUMBER
        part = pattern.match(source, place)
        if not part or abs(float(part[0])) > LARGEST:
            return None, place
        text = part[0] if abs(float(part[0])) >= LEAST else "0"
        # The library refuses radii below zero, of which the size counts.
        found.append(text.lstrip("-") if letter in "Aa" and i < 2 else text)
        place = part.end()
    return found, place


def _arc(
    start: Array, rx: float, ry: float, turn: float, large: bool, clockwise: bool, end: Array
) -> list[Array]:
    """An elliptical arc as cubics, by the notes on implementation of SVG 1.1 (F.6)."""
    rx, ry = abs(rx), abs(ry)
    half = (start - end) / 2
    if rx == 0 or ry == 0 or not half.any():
        return [chord(start, end)]
    cosine, sine = math.cos(math.radians(turn)), math.sin(math.radians(turn))
    axes = np.array([[cosine, sine], [-sine, cosine]])
    # In units of the radii the ellipse is a circle of radius 1.
    away = axes @ half / [rx, ry]
    square = float(away @ away)
    if square < FLAT**2 and (not large or not square):
        return [chord(start, end)]
    if square > 1:
        rx, ry, away, square = (
            rx * math.sqrt(square),
            ry * math.sqrt(square),
            away / math.sqrt(square),
            1.0,
        )
    side = -1.0 if large == clockwise else 1.0
    centre = side * math.sqrt(max(0.0, 1 / square - 1)) * np.array([away[1], -away[0]])
    first, last = away - centre, -away - centre
    begin = math.atan2(first[1], first[0])
    sweep = (math.atan2(last[1], last[0]) - begin) % (2 * math.pi)
    if not clockwise:
        sweep -= 2 * math.pi
    if square == 1.0:
        sweep = math.pi if clockwise else -math.pi
    count = max(1, math.ceil(abs(sweep) / QUARTER - 1e-9))
    angles = begin + sweep / count * np.arange(count + 1)
    along = 4 / 3 * math.tan(sweep / count / 4)
    on = np.stack([np.cos(angles), np.sin(angles)], 1)
    way = along * np.stack([-on[:, 1], on[:, 0]], 1)
    unit = np.stack([on[:-1], on[:-1] + way[:-1], on[1:] - way[1:], on[1:]], 1)
    curves = ((unit + centre) * [rx, ry]) @ axes + (start + end) / 2
    curves[0, 0], curves[-1, 3] = start, end
    return list(curves)
