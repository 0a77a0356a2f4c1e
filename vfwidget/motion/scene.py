"""The letters and obstacles of a simulation as outlines in time."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..arrays import Array
from ..errors import MotionError, OverlapError
from ..outline.monotone import coefficients, evaluate
from ..outline.union import without_overlaps
from ..overlap.contacts import SAMPLES, sampled
from ..overlap.gaps import Gaps, Outlines
from ..overlap.shape import Shape, letters, read_obstacles
from ..text import Text

LEAST_STROKE = 4.0
"""Font units: the two sides of one curve are at least this far apart."""
THINNEST = 1.0
"""Font units: an obstacle that is thinner is refused, because letters could pass it unseen."""
NEAREST = 1e-6
"""Font units: sides that are nearer to a point are its own."""
NEARBY = 6.0
"""Font units: gaps are found up to here, because those that are near are needed again."""
THIN = 0.1
"""Part of the outline at which a shape may be thinner than its stroke, because of corners."""


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
        self._known: dict[float, tuple[Outlines, Array, tuple[Array, ...]]] = {}
        self._shapes: list[Shape] = []
        self._outlines: Outlines | None = None
        self._gaps: dict[tuple[int, bytes], tuple[float, Gaps]] = {}
        self.stroke = np.array([max(_stroke(letter), THINNEST) for letter in self._letters])
        self.at(0.0)

    def _measure(self, obstacles: list[Shape]) -> None:
        """Keep the thinnest stroke that each obstacle has had."""
        strokes = np.array([_stroke(obstacle) for obstacle in obstacles])
        for number, stroke in enumerate(strokes, 1):
            if stroke < THINNEST:
                raise MotionError(
                    f"Obstacle {number} is {stroke:.3g} font units thick, and letters could pass "
                    f"it unseen. Make it at least {THINNEST:g} unit thick."
                )
        letters, known = np.split(self.stroke, [len(self._letters)])
        least = np.full(max(len(known), len(strokes)), np.inf)
        for some in (known, strokes):
            least[: len(some)] = np.minimum(least[: len(some)], some)
        self.stroke = np.concatenate([letters, least])

    def at(self, time: float) -> tuple[Outlines, Array]:
        """All outlines, and the segments (S', 4, 2) of the obstacles, at a time in seconds."""
        return self._at(time)[:2]

    def gaps(self, outlines: Outlines, segments: Array, reach: float) -> Gaps:
        """The gaps between outlines that are smaller than ``reach``; the latest ones are kept."""
        key = id(outlines), segments.tobytes()
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
        return self._at(time)[2]

    def _at(self, time: float) -> tuple[Outlines, Array, tuple[Array, ...]]:
        key = time if self.moving else 0.0
        if key not in self._known:
            if len(self._known) > 8:
                self._known.clear()
            self._known[key] = self._read(time)
        return self._known[key]

    def _read(self, time: float) -> tuple[Outlines, Array, tuple[Array, ...]]:
        try:
            shapes = [_simple(shape) for shape in read_obstacles(self.given(time))]
        except OverlapError as error:
            when = f" At {time:.4g} s:" if self.moving else ""
            raise MotionError(f"The obstacles cannot be read.{when} {error}") from error
        # The structure decides which points correspond to each other at two times.
        if self._outlines is None or [s.sizes for s in shapes] != [s.sizes for s in self._shapes]:
            self._measure(shapes)
            self._outlines = Outlines([*self._letters, *shapes], len(self._letters))
        self._shapes = shapes
        segments = [np.zeros((0, 4, 2)), *(shape.segments for shape in shapes)]
        contours = tuple(c for shape in shapes for c in shape.contours)
        return self._outlines, np.concatenate(segments), contours


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
