"""Strokes as areas: strips along the segments of a path, joins at its corners, caps at its ends.

All contours of a stroke have one direction, so that together they are filled nonzero.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...outline.cubics import bernstein, chord
from ...outline.union import without_overlaps
from ..shape import polygon

STEPS, PER_CUBIC = 16, 2
"""Points at which the bend of a curve is looked at, and how many of them a cubic of the stroke's
outline replaces."""
STRAIGHT = 1e-6
"""A segment is straight if its handles are so near to the thirds of its chord, by its size."""
ROUNDING = 1e-9
"""Handles that are shorter, by the size of the curve, have no direction."""
SHARP, MOST_CUTS = 0.3, 4
"""Radians between two steps along a curve above which it is cut, and how often."""
FINE = 64
"""Straight steps by which the length of a curve is measured."""
LEAST_CURVES = 4
"""Curves around a straight side of a stroke."""
PARALLEL = 1e-6
"""Sine of the angle between two segments below which they need no join."""
QUARTER = np.array([[0.0, -1.0], [1.0, 0.0]])
"""Turns vectors to the right by a right angle; y points up."""
OVERLAP = 1e-3
"""By how much of half a stroke's width a join and a cap reach into the strip, so that rounding
leaves no crack between them."""
ROUND = 4 / 3 * math.tan(math.pi / 8)
"""Length of the handles of a quarter circle of radius 1."""


class Pen(NamedTuple):
    """How a path is stroked.

    Attributes
    ----------
    width : float
    cap : str
        "butt", "round" or "square".
    join : str
        "miter", "round" or "bevel".
    limit : float
        The longest miter, by the width of the stroke. Longer ones are cut off.
    dashes : tuple of float
        Lengths of dashes and gaps in turn; empty for a line without gaps.
    offset : float
        Where in the dashes the path begins.
    """

    width: float
    cap: str = "butt"
    join: str = "miter"
    limit: float = 4.0
    dashes: tuple[float, ...] = ()
    offset: float = 0.0


def stroked(segments: Array, closed: bool, pen: Pen) -> Iterator[Array]:
    """The contours of the stroke of a path (s, 4, 2)."""
    long = _with_length(segments)
    half = pen.width / 2
    if not len(long):
        yield from _dot(segments[0, 0], half, pen.cap)
        return
    if closed and not np.array_equal(long[-1, 3], long[0, 0]):
        long = np.concatenate([long, chord(long[-1, 3], long[0, 0])[None]])
    for line in _dashed(long, closed, pen) if pen.dashes else [long]:
        whole, start = closed and line is long, line[0, 0]
        line = _gentle(_with_length(line))
        if not len(line):
            yield from _dot(start, half, pen.cap)
            continue
        yield from _bars(line, whole, pen)
        if not whole:
            yield from _cap(line[0, 0], -_direction(line[0], 0), half, pen.cap)
            yield from _cap(line[-1, 3], _direction(line[-1], 1), half, pen.cap)


def _with_length(segments: Array) -> Array:
    """Segments (s, 4, 2) without those that are points; rounding leaves points a little length."""
    return segments[(np.ptp(segments, 1) > ROUNDING * abs(segments).max(initial=0.0)).any(1)]


def _gentle(segments: Array) -> Array:
    """A path (s, 4, 2) with segments cut where they turn too fast for the steps along an edge."""
    found, waiting = list[Array](), [(cubic, 0) for cubic in segments[::-1]]
    while waiting:
        cubic, depth = waiting.pop()
        slopes = _quadratic(np.linspace(0, 1, STEPS + 1)).T @ np.diff(cubic, axis=0)
        slopes[abs(slopes).max(1) < ROUNDING * np.ptp(cubic, 0).max()] = 0.0
        before, after = slopes[:-1], slopes[1:]
        turns = abs(np.arctan2(_cross(before, after), (before * after).sum(-1)))
        worst = int(turns.argmax())
        if turns[worst] <= SHARP or depth == MOST_CUTS:
            found.append(cubic)
            continue
        middle = np.clip((worst + 0.5) / STEPS, 1 / STEPS, 1 - 1 / STEPS)
        parts = _cut(cubic, float(middle))
        waiting += [(part, depth + 1) for part in parts[::-1] if np.ptp(part, 0).any()]
    return np.array(found).reshape(-1, 4, 2)


def _bars(line: Array, closed: bool, pen: Pen) -> Iterator[Array]:
    """The strips along the segments of a path (s, 4, 2), and the joins between them."""
    half = pen.width / 2
    edges, turns = zip(*(_edges(cubic, half) for cubic in line), strict=True)
    folded = [bool(one.any()) for one in turns]
    run = list[Edges]()
    followers = [*line[1:], *(line[:1] if closed else [])]
    pairs = list(zip(line, followers, strict=False))
    smooth = [_is_smooth(*pair) for pair in pairs]
    if closed and all(smooth) and not any(folded):
        yield from _ring(edges)
        return
    for pair, goes_on in zip(pairs, smooth, strict=True):
        yield from [] if goes_on else _join(*pair, pen)
    # In a closed path, the first strip is one after a corner.
    first = smooth.index(False) + 1 if closed and False in smooth else 0
    order = np.roll(np.arange(len(line)), -first).tolist()
    for i in order:
        if folded[i]:
            yield from _folded(edges[i], turns[i])
            continue
        run.append(edges[i])
        following = (i + 1) % len(line)
        if i >= len(smooth) or not smooth[i] or folded[following] or i == order[-1]:
            yield _strip(run)
            run = []


def count_dashes(segments: Array, pen: Pen) -> int:
    """About how many dashes a path (s, 4, 2) has."""
    if not pen.dashes:
        return 0
    length = np.hypot(*np.diff(segments, axis=1).reshape(-1, 2).T).sum()
    return int(min(length / sum(pen.dashes) * len(pen.dashes) / 2, 1e9))


def _direction(cubic: Array, end: int) -> Array:
    """The unit vector along a cubic (4, 2) at its start (0) or its end (1)."""
    points = cubic[::-1] if end else cubic
    # A handle may have no length, or one that rounding has left.
    least = ROUNDING * np.ptp(points, 0).max()
    way = next(point - points[0] for point in points[1:] if abs(point - points[0]).max() > least)
    way = way / np.hypot(*way)
    return -way if end else way


Edges = tuple[Array, Array]
"""The right and the left edge of a strip, cubics (e, 4, 2) in the direction of the path."""


def _edges(cubic: Array, half: float) -> tuple[Edges, Array]:
    """The edges of the strip along a cubic (4, 2), and which cubics of them may turn back."""
    thirds = (2 * cubic[[0, 3]] + cubic[[3, 0]]) / 3
    if np.allclose(cubic[1:3], thirds, rtol=0, atol=STRAIGHT * np.ptp(cubic, 0).max()):
        right = half * _direction(cubic, 0) @ QUARTER
        one, other = (chord(cubic[0] + side, cubic[3] + side)[None] for side in (right, -right))
        return (one, other), np.zeros(1, dtype=bool)
    t = np.linspace(0, 1, STEPS + 1)
    sides = np.diff(cubic, axis=0)
    middle, slope = bernstein(t).T @ cubic, 3 * _quadratic(t).T @ sides
    bend = 6 * np.stack([1 - t, t], 1) @ np.diff(sides, axis=0)
    speed = np.hypot(*slope.T)[:, None]
    speed[speed < ROUNDING * np.ptp(cubic, 0).max()] = 0.0
    along = slope / np.where(speed > 0, speed, 1.0)
    along[[0, -1]] = _direction(cubic, 0), _direction(cubic, 1)
    right = half * along @ QUARTER
    # An edge is longer or shorter than the middle where the curve is bent.
    turn = half * _cross(along, bend)[:, None] / np.where(speed > 0, speed, np.inf) ** 2
    one, other = (_smooth(middle + s * right, slope * (1 + s * turn)) for s in (1, -1))
    back = np.abs(turn[:, 0]) >= 1
    back[1:-1] |= ~(speed[1:-1, 0] > 0)
    return (one, other), back[:-1].reshape(-1, PER_CUBIC).any(1) | back[PER_CUBIC::PER_CUBIC]


def _folded(edges: Edges, turns: Array) -> Iterator[Array]:
    """The strip between edges that turn back in some pieces, so that parts of it run backwards."""
    for right, left, back in zip(*edges, turns, strict=True):
        piece = _strip([(right[None], left[None])])
        # Outlines without overlaps run the other way round.
        parts = without_overlaps(piece, [len(piece)]) if back else [piece[::-1, ::-1]]
        yield from (part[::-1, ::-1] for part in parts)


def _strip(edges: Sequence[Edges]) -> Array:
    """The strip between the edges of segments that continue each other."""
    right, left = (_continued(side) for side in zip(*edges, strict=True))
    back = left[::-1, ::-1]
    over = chord(right[-1, 3], back[0, 0]), chord(back[-1, 3], right[0, 0])
    return np.concatenate([right, over[0][None], back, over[1][None]])


def _ring(edges: Sequence[Edges]) -> list[Array]:
    """The strip along a closed path without corners: two contours."""
    right, left = (_continued(side) for side in zip(*edges, strict=True))
    right[-1, 3], left[-1, 3] = right[0, 0], left[0, 0]
    return [right, left[::-1, ::-1]]


def _continued(parts: Sequence[Array]) -> Array:
    """Cubics one after the other, each from the end of the one before."""
    edge = np.concatenate(parts)
    edge[1:, 0] = edge[:-1, 3]
    return edge


def _quadratic(t: Array) -> Array:
    """The weights of the three control points of a quadratic at parameters t: (3, …)."""
    return np.array([(1 - t) ** 2, 2 * t * (1 - t), t * t])


def _cross(first: Array, second: Array) -> Array:
    return np.asarray(first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0])


def _smooth(points: Array, slopes: Array) -> Array:
    """Cubics through some of the points (STEPS + 1, 2), with the slopes there by t in 0 … 1."""
    points, handles = points[::PER_CUBIC], slopes[::PER_CUBIC] * PER_CUBIC / STEPS / 3
    corners = [points[:-1], points[:-1] + handles[:-1], points[1:] - handles[1:], points[1:]]
    return np.stack(corners, 1)


def _is_smooth(before: Array, after: Array) -> bool:
    """Whether a path goes on in the same direction."""
    first, second = _direction(before, 1), _direction(after, 0)
    return bool(abs(_cross(first, second)) < PARALLEL and first @ second > 0)


def _join(before: Array, after: Array, pen: Pen) -> list[Array]:
    """The area beyond the strips of two segments where the path turns."""
    corner, half = after[0], pen.width / 2
    first, second = _direction(before, 1), _direction(after, 0)
    sine, cosine = float(_cross(first, second)), float(first @ second)
    if abs(sine) < PARALLEL and (pen.join != "round" or cosine > 0):
        return []
    # The outer side of the turn.
    side = half if sine > 0 else -half
    one, other = (corner + side * way @ QUARTER for way in (first, second))
    within = OVERLAP * half
    inner = corner - OVERLAP * (one + other - 2 * corner)
    back, ahead = one - within * first, other + within * second
    if pen.join == "round":
        arc = _turned(corner, one, first, math.atan2(abs(sine), cosine))
        sides = [(arc[-1, 3], ahead), (ahead, inner), (inner, back), (back, one)]
        sector = np.concatenate([arc, [chord(*pair) for pair in sides]])
        return [sector if sine > 0 else sector[::-1, ::-1]]
    corners = [inner, back, one, other, ahead]
    miter = math.sqrt(2 / (1 + cosine))
    if pen.join != "bevel" and miter <= pen.limit:
        corners.insert(3, corner + (one + other - 2 * corner) * miter**2 / 2)
    return [polygon(np.array(corners if sine > 0 else corners[::-1]))]


def _turned(centre: Array, start: Array, way: Array, angle: float) -> Array:
    """An arc around a centre as cubics, which begins in the direction of a unit vector."""
    count = max(1, math.ceil(angle / (math.pi / 2)))
    out = start - centre
    radius = math.hypot(*out)
    turns = np.linspace(0, angle, count + 1)[:, None]
    on = np.cos(turns) * out + np.sin(turns) * radius * way
    along = np.cos(turns) * radius * way - np.sin(turns) * out
    along *= 4 / 3 * math.tan(angle / count / 4)
    return centre + np.stack([on[:-1], on[:-1] + along[:-1], on[1:] - along[1:], on[1:]], 1)


def _cap(end: Array, out: Array, half: float, cap: str) -> list[Array]:
    """What is beyond the end of an open path."""
    if cap == "round":
        return [_half_disc(end, half * out)]
    return [_bar(end - OVERLAP * half * out, end + half * out, half)] if cap == "square" else []


def _dot(place: Array, half: float, cap: str) -> list[Array]:
    """The stroke of a path without length."""
    if cap == "square":
        side = np.array([half, 0.0])
        return [_bar(place - side, place + side, half)]
    return [_disc(place, half)] if cap == "round" else []


def _bar(start: Array, end: Array, half: float) -> Array:
    """The strip along a straight line."""
    right = half * (end - start) / np.hypot(*(end - start)) @ QUARTER
    return polygon(np.array([start + right, end + right, end - right, start - right]))


def _disc(centre: Array, radius: float) -> Array:
    out = radius * np.array([[1.0, 0], [0, 1], [-1, 0], [0, -1]])
    along = ROUND * np.roll(out, -1, 0)
    following = np.roll(out, -1, 0)
    return centre + np.stack([out, out + along, following + ROUND * out, following], 1)


def length_of(segments: Array) -> float:
    """The length of a path (s, 4, 2)."""
    return float(_lengths(segments)[-1])


def _lengths(segments: Array) -> Array:
    """The length of a path (s, 4, 2) up to each of ``FINE`` places on each segment."""
    steps = np.diff(bernstein(np.linspace(0, 1, FINE + 1)).T @ segments, axis=1)
    return np.concatenate([[0.0], np.hypot(*steps.reshape(-1, 2).T).cumsum()])


def _half_disc(centre: Array, out: Array) -> Array:
    """Half a disc around a point, on the side of its radius ``out``."""
    right = out @ QUARTER
    one, tip, other = centre + right, centre + out, centre - right
    quarters = [
        [one, one + ROUND * out, tip + ROUND * right, tip],
        [tip, tip - ROUND * right, other + ROUND * out, other],
    ]
    back = [other, other - OVERLAP * out, one - OVERLAP * out, one]
    return np.concatenate([quarters, [chord(*pair) for pair in pairwise(back)]])


def _dashed(segments: Array, closed: bool, pen: Pen) -> list[Array]:
    """The dashes of a path (s, 4, 2), each a path of its own."""
    lengths = _lengths(segments)
    places = np.arange(len(lengths)) / FINE
    pattern = np.array(pen.dashes * (1 + len(pen.dashes) % 2))
    ends = np.concatenate([[0.0], pattern.cumsum()])
    begin = -(pen.offset % ends[-1])
    repeats = np.arange(math.ceil((lengths[-1] - begin) / ends[-1]))
    starts = (begin + repeats[:, None] * ends[-1] + ends[:-1:2]).ravel()
    stops = starts + np.tile(pattern[::2], len(repeats))
    inside = ((stops > 0) | (starts == 0)) & (starts < lengths[-1])
    starts, stops = starts[inside], stops[inside]
    cuts = np.interp([starts, stops], lengths, places).T
    dashes = [_between(segments, *cut) for cut in cuts.tolist()]
    # Over the end of a closed path a dash goes on.
    if closed and len(dashes) > 1 and starts[0] <= 0 and stops[-1] >= lengths[-1]:
        dashes[0] = np.concatenate([dashes.pop(), dashes[0]])
    return dashes


def _between(segments: Array, low: float, high: float) -> Array:
    """The part of a path from segment and parameter ``low`` to ``high``, as one number each."""
    first, last = int(low), max(int(low), math.ceil(high) - 1)
    first, last = min(first, len(segments) - 1), min(last, len(segments) - 1)
    part = segments[first : last + 1].copy()
    part[-1] = _cut(part[-1], high - last)[0]
    start = low - first
    # The last segment may be the first one too, of which only a part is left.
    scale = high - last if first == last else 1.0
    part[0] = _cut(part[0], start / scale if scale else 0.0)[1]
    return part


def _cut(cubic: Array, t: float) -> tuple[Array, Array]:
    """Both parts of a cubic (4, 2)."""
    rows = [cubic]
    for _ in range(3):
        rows.append(rows[-1][:-1] * (1 - t) + rows[-1][1:] * t)
    return np.stack([row[0] for row in rows]), np.stack([row[-1] for row in rows[::-1]])
