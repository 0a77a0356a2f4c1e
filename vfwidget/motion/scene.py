"""The letters and obstacles of a simulation as outlines in time."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..errors import MotionError, OverlapError
from ..outline.monotone import coefficients, evaluate
from ..outline.union import without_overlaps
from ..overlap.contacts import SAMPLES, sampled
from ..overlap.gaps import Gaps, Outlines
from ..overlap.shape import Shape, letters, read_obstacles
from ..text import Text
from ..text.memo import Memo

LEAST_STROKE = 4.0
"""Font units: the two sides of one curve are at least this far apart."""
THINNEST = 1.0
"""Font units: an obstacle that is thinner is refused, because letters could pass it unseen."""
NEAREST = 1e-6
"""Font units: sides that are nearer to a point are its own."""
NEARBY = 6.0
"""Font units. Gaps are searched at least up to this distance, because the next steps need the near
ones again."""
THIN = 0.1
"""Part of the outline at which a shape may be thinner than its stroke, because of corners."""


class _Moment(NamedTuple):
    """The obstacles at one time, and the outlines that have their structure."""

    outlines: Outlines
    shapes: list[Shape]
    segments: Array


class Passage(NamedTuple):
    """The obstacles during a step.

    Attributes
    ----------
    outlines : Outlines
        All outlines, letters first.
    before, after : (S', 4, 2) arrays
        The segments of the obstacles at the start and at the end of the step.
    appeared : bool
        Whether one is new.
    """

    outlines: Outlines
    before: Array
    after: Array
    appeared: bool


class Scene:
    """Obstacles that stand still, or move along a path over time.

    Parameters
    ----------
    text : Text
    obstacles : obstacles, or a function of the time that returns obstacles

    Attributes
    ----------
    moving : bool
    stroke : (s,) array
        Thickness of the thinnest stroke of each shape, letters first, in font units.
    """

    def __init__(self, text: Text, obstacles: Any) -> None:
        self.moving = callable(obstacles)
        self._obstacles = obstacles
        self._letters = letters(text)
        self._moments: Memo[_Moment] = Memo(16)
        self._outlines: Memo[Outlines] = Memo()
        self._measured: dict[int, tuple[Shape, float]] = {}
        self._gaps: dict[tuple[Outlines, bytes], tuple[float, Gaps]] = {}
        self.stroke = np.array([max(_stroke(letter), THINNEST) for letter in self._letters])
        self.at(0.0)

    def _measure(self, obstacles: list[Shape], time: float) -> None:
        """Keep the thinnest stroke that each obstacle has had."""
        for i, obstacle in enumerate(obstacles):
            if i in self._measured:
                shape, stroke = self._measured[i]
                # A stroke shrinks by at most twice the motion of the outline.
                most = min(stroke / 4, stroke - THINNEST)
                if _structure(shape) == _structure(obstacle) and 2 * _bent(shape, obstacle) <= most:
                    continue
            stroke = _stroke(obstacle)
            if stroke < THINNEST - NEAREST:
                when = f" at {time:.4g} s" if self.moving else ""
                raise MotionError(
                    f"obstacles[{i}] is {stroke:.3g} font units thick{when}, and letters could "
                    f"pass it unseen. Make it at least {THINNEST:g} unit thick."
                )
            self._measured[i] = obstacle, stroke
            number = len(self._letters) + i
            if number == len(self.stroke):
                self.stroke = np.append(self.stroke, np.inf)
            self.stroke[number] = min(self.stroke[number], stroke)

    def at(self, time: float) -> tuple[Outlines, Array]:
        """All outlines, and the segments (S', 4, 2) of the obstacles, at a time in seconds."""
        moment = self._at(time)
        return moment.outlines, moment.segments

    def shapes(self, time: float) -> list[Shape]:
        """The obstacles at a time."""
        return self._at(time).shapes

    def over(self, time: float, later: float) -> Passage:
        """The obstacles from a time to a later one.

        An obstacle that is new at the later time is already where it will be. If none is new,
        those that vanish stay where they are until then.
        """
        first, second = self._at(time), self._at(later)
        if first.outlines is second.outlines:
            return Passage(first.outlines, first.segments, second.segments, False)
        found = _counterparts(first.shapes, second.shapes)
        if len(found) < len(second.shapes):
            shapes = [found.get(i, shape) for i, shape in enumerate(second.shapes)]
            return Passage(second.outlines, _segments(shapes), second.segments, True)
        kept = [found[i] for i in range(len(second.shapes))]
        vanished = [shape for shape in first.shapes if not any(shape is one for one in kept)]
        after = [*second.shapes, *vanished]
        self._measure(after, later)
        return Passage(
            self._outlines_of(after), _segments([*kept, *vanished]), _segments(after), False
        )

    def gaps(self, outlines: Outlines, segments: Array, reach: float) -> Gaps:
        """The gaps between outlines that are smaller than ``reach``; the latest ones are kept."""
        key = outlines, segments.tobytes()
        known = self._gaps.get(key)
        if known is None or known[0] < reach:
            if len(self._gaps) > 4:
                self._gaps.clear()
            most = max(reach, NEARBY)
            self._gaps[key] = known = most, outlines.gaps(segments, most)
        found = known[1]
        return found if known[0] == reach else found.some(abs(found.gap) < reach)

    def given(self, time: float) -> Any:
        """The obstacles as the caller gives them."""
        return self._obstacles(time) if self.moving else self._obstacles

    def contours(self, time: float) -> tuple[Array, ...]:
        """The closed contours (s, 4, 2) of the obstacles."""
        return tuple(contour for shape in self.shapes(time) for contour in shape.contours)

    def _at(self, time: float) -> _Moment:
        return self._moments.get(time if self.moving else 0.0, lambda: self._read(time))

    def _read(self, time: float) -> _Moment:
        try:
            shapes = [_simple(shape) for shape in read_obstacles(self.given(time))]
        except OverlapError as error:
            when = f" At {time:.4g} s:" if self.moving else ""
            raise MotionError(f"The obstacles cannot be read.{when} {error}") from error
        self._measure(shapes, time)
        return _Moment(self._outlines_of(shapes), shapes, _segments(shapes))

    def _outlines_of(self, shapes: list[Shape]) -> Outlines:
        """All outlines; the structure decides which points correspond at two times."""
        return self._outlines.get(
            tuple(map(_structure, shapes)),
            lambda: Outlines([*self._letters, *shapes], len(self._letters)),
        )


def _segments(shapes: Sequence[Shape]) -> Array:
    """The segments of some shapes, (S', 4, 2)."""
    return np.concatenate([np.zeros((0, 4, 2)), *(shape.segments for shape in shapes)])


def _structure(shape: Shape) -> Hashable:
    """The number of segments of each contour, and whether it runs counterclockwise."""
    start, end = shape.segments[:, :3], shape.segments[:, 1:]
    twice = (start[..., 0] * end[..., 1] - start[..., 1] * end[..., 0]).sum(1)
    first = np.cumsum([0, *shape.sizes[:-1]])
    return shape.sizes, tuple((np.add.reduceat(twice, first) > 0).tolist())


def _counterparts(before: Sequence[Shape], after: Sequence[Shape]) -> dict[int, Shape]:
    """The earlier obstacle for each later one of equal structure, by its index.

    Equally many correspond in their order. Otherwise the nearest ones correspond.
    """
    found = dict[int, Shape]()
    for structure in {_structure(shape) for shape in after}:
        old = [shape for shape in before if _structure(shape) == structure]
        new = [i for i, shape in enumerate(after) if _structure(shape) == structure]
        if len(old) == len(new):
            found.update(zip(new, old, strict=True))
            continue
        way = np.array([[abs(s.segments - after[i].segments).max() for i in new] for s in old])
        for _ in range(min(way.shape) if len(old) else 0):
            row, column = np.unravel_index(int(way.argmin()), way.shape)
            found[new[column]] = old[row]
            way[row], way[:, column] = np.inf, np.inf
    return found


def _bent(before: Shape, after: Shape) -> float:
    """How far the control points are from where the best rigid motion leads, at most."""
    old, new = (shape.segments.reshape(-1, 2) @ [1, 1j] for shape in (before, after))
    old, new = old - old.mean(), new - new.mean()
    turn = np.vdot(old, new)
    return float(abs(new - turn / (abs(turn) or 1.0) * old).max())


def _simple(shape: Shape) -> Shape:
    """The shape without overlaps between its contours."""
    if len(shape.sizes) == 1 and len(shape.segments) <= 8 and _is_convex(shape):
        return shape
    contours = without_overlaps(shape.segments, shape.sizes)
    return Shape(np.concatenate(contours), [len(contour) for contour in contours])


def _is_convex(shape: Shape) -> bool:
    """Whether the control polygon always turns the same way."""
    sides = np.diff(shape.segments, axis=1).reshape(-1, 2)
    sides = sides[np.hypot(*sides.T) > 0]
    turns = sides[:, 0] * np.roll(sides[:, 1], -1) - sides[:, 1] * np.roll(sides[:, 0], -1)
    scale = 1e-9 * float((sides * sides).sum(1).max())
    angle = np.arctan2(turns, (sides * np.roll(sides, -1, 0)).sum(1)).sum()
    return bool(((turns >= -scale).all() or (turns <= scale).all()) and abs(angle) < 7)


def _stroke(shape: Shape) -> float:
    """The thickness that all but a tenth of the outline exceed, measured straight inwards."""
    if not shape.sizes:
        return np.inf
    spans = shape.union()
    points = sampled(shape, spans)
    # Chords between neighbouring samples of one span stand for the outline.
    bound = np.flatnonzero(spans.weight)
    t = np.linspace(spans.start[bound], spans.end[bound], SAMPLES + 1)
    corners = evaluate(coefficients(shape.segments)[..., spans.cubic[bound]][:, :, None], t)
    corners = corners.swapaxes(1, 2)
    low, high = corners[..., :-1].reshape(2, -1), corners[..., 1:].reshape(2, -1)
    along = high - low
    inwards = -points.outward
    away = low[:, None] - points.position.T[..., None]
    across = inwards.T[0][:, None] * along[1] - inwards.T[1][:, None] * along[0]
    with np.errstate(divide="ignore", invalid="ignore"):
        depth = (away[0] * along[1] - away[1] * along[0]) / across
        part = (away[0] * inwards.T[1][:, None] - away[1] * inwards.T[0][:, None]) / across
    # The chords of a curve lie near it, and are not its opposite side.
    span = np.repeat(np.arange(len(bound)), SAMPLES)
    least = np.where(span[:, None] == span, LEAST_STROKE, NEAREST)
    hits = (depth > least) & (part >= 0) & (part <= 1)
    first = np.where(hits, depth, np.inf).min(1)
    order = np.argsort(first)
    passed = np.cumsum(np.hypot(*along)[order])
    found = first[order[np.searchsorted(passed, THIN * passed[-1])]]
    return float(found) if np.isfinite(found) else LEAST_STROKE
