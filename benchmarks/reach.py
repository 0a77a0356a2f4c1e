"""How many reachable positions one solve reaches, and how steadily a drag follows the pointer.

*Positions.* A point of a letter is dragged from the default to a position that it can reach. Half
of the positions are those of the point at random instances. The others lie anywhere within 0.3 em
of its default, and are used if a brute-force search comes within one font unit of them: it tries
1,000 random instances and a solve from each of the nearest few. The benchmark reports the share of
positions that one solve reaches to within one font unit.

*Drags.* The pointer follows circles and lines, within reach and beyond it, by 0.1 % of the em per
event. Each event is handled as the editor handles a move. The benchmark reports the steps of the
axes as shares of their ranges, and the number of leaps. A leap is a change by more than a tenth of
the range that is undone within three events; a person sees it as flicker.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from time import process_time

import numpy as np

import vfwidget as vf
from vfwidget.view.drag import CALM, MOVE_ITERATIONS

from .table import Row, milliseconds
from .timing import Array

GLYPHS = "aRg&8"
PLACES = 80
"""Positions for each glyph of each font, both kinds together."""
WITHIN = 1.0
"""Largest distance, in font units, at which a position counts as reached."""
FARTHEST = 0.3
"""Largest distance from the default position, in em."""
STAY_CLOSE = 1e-3
INSTANCES, REFINED = 1000, 5
TRIES, KEPT = 8, 2
"""Random positions for each handle, and the number of reachable ones that are used."""
STEP = 1e-3
"""Distance that the pointer moves at each event, in em."""
RADIUS, LENGTH = 0.1, 0.3
"""Radius of the circles and length of the lines, in em."""
SWING = 0.1
DRAGGED = "ag"


@dataclass(frozen=True)
class Place:
    """A handle and its target position, starting from the axes of ``text``."""

    text: vf.Text
    handle: vf.Handle
    target: Array


@dataclass(frozen=True)
class Attempt:
    """Remaining distance of a solve, in font units, and its time in milliseconds."""

    miss: float
    time: float


def run(quick: bool) -> Iterator[Row]:
    """Yield for each font the share of reached positions, then the steps of its axes."""
    for name in vf.bundled_fonts():
        found = places(name, GLYPHS, PLACES // 20 if quick else PLACES)
        yield _reach_row(name, found)
    for name in vf.bundled_fonts():
        yield _steadiness_row(name, DRAGGED[:1] if quick else DRAGGED)


def places(font: str, glyphs: str, count: int) -> list[Place]:
    """Return reachable positions of points of each glyph, of both kinds."""
    found: list[Place] = []
    for glyph in glyphs:
        text, rng = vf.Text(font, glyph), np.random.default_rng(ord(glyph))
        found += islice(_at_instances(text, rng), count // 2)
        found += islice(_anywhere(text, rng), count - count // 2)
    return found


def _at_instances(text: vf.Text, rng: np.random.Generator) -> Iterator[Place]:
    while True:
        handle = random_handle(text, rng)
        theta = rng.uniform(*text.font.bounds, tuple(text.theta.shape))
        yield Place(text, handle, text.at(theta=theta).position(handle).numpy())


def _anywhere(text: vf.Text, rng: np.random.Generator) -> Iterator[Place]:
    while True:
        handle = random_handle(text, rng)
        away = FARTHEST * text.font.units_per_em * rng.random(TRIES)
        angle = rng.uniform(0, 2 * np.pi, TRIES)
        moved = away * np.array([np.cos(angle), np.sin(angle)])
        targets = text.position(handle).numpy() + moved.T
        misses = brute_force(text, handle, targets, rng)
        yield from (Place(text, handle, target) for target in targets[misses <= WITHIN][:KEPT])


def random_handle(text: vf.Text, rng: np.random.Generator) -> vf.Handle:
    """Return a random point of the outline of the first letter."""
    contours = text.glyphs[0].contours
    contour = int(rng.integers(len(contours)))
    return text.handle(0, contour, int(rng.integers(contours[contour])), rng.random())


def brute_force(
    text: vf.Text, handle: vf.Handle, targets: Array, rng: np.random.Generator
) -> Array:
    """Return the smallest distances (t,) that a search finds to targets (t, 2)."""
    points = text.point_set([handle])
    lower, upper = text.font.bounds
    instances = rng.uniform(lower, upper, (INSTANCES, len(lower)))
    places = text.positions(points, instances[:, None])[:, 0]
    distance = np.linalg.norm(places - targets[:, None], axis=-1)
    nearest = distance.argpartition(REFINED, axis=1)[:, :REFINED]
    goals = np.repeat(targets, REFINED, axis=0)
    found = vf.least_squares(
        lambda x: text.positions(points, x[:, None])[:, 0] - goals,
        instances[nearest.ravel()],
        lambda x: text.positions_and_jacobian(points, x[:, None])[1][:, 0, :, 0],
        (lower, upper),
        kinks=text.breakpoints,
        scale="none",
        max_iterations=30,
        absolute_cost_tolerance=1e-3,
        cost_floor=1e-3,
    )
    return np.sqrt(found.cost).reshape(-1, REFINED).min(1)


def attempt(place: Place, restarts: int) -> Attempt:
    """Run one solve."""
    terms = [vf.Target(place.handle, place.target), vf.StayClose(STAY_CLOSE)]
    begun = process_time()
    solution = vf.solve(place.text, terms, restarts=restarts)
    return Attempt(solution.misses[0], 1e3 * (process_time() - begun))


def _reach_row(font: str, found: list[Place]) -> Row:
    ours = [attempt(place, restarts=8) for place in found]
    alone = [attempt(place, restarts=0) for place in found]
    return Row(
        benchmark="reach",
        case=f"{font}, {len(found)} places",
        ours=_share(ours),
        baseline=f"no restarts {_share(alone)}",
        ratio="",
        notes=f"{_time(ours)} | {_time(alone)}",
    )


def _share(tried: list[Attempt]) -> str:
    """Format the share of attempts that reached their position."""
    return f"{np.mean([a.miss <= WITHIN for a in tried]):.1%}".replace("%", " %")


def _time(tried: list[Attempt]) -> str:
    return milliseconds(float(np.median([a.time for a in tried])))


def _steadiness_row(font: str, glyphs: str) -> Row:
    calm = (CALM * vf.load_font(font).units_per_em) ** 2
    ours, plain = (
        [follow(*drag, weight) for drag in _drags(font, glyphs)] for weight in (calm, STAY_CLOSE)
    )
    return Row(
        benchmark="reach",
        case=f"{font}, {sum(len(axes) for axes in ours)} moves",
        ours=f"{sum(map(leaps, ours))} leaps",
        baseline=f"λ = {STAY_CLOSE} {sum(map(leaps, plain))} leaps",
        ratio="",
        notes=f"axis steps 99 % (all) ≤ {_steps(ours)} | {_steps(plain)}",
    )


def _steps(drags: list[Array]) -> str:
    """Format the largest step of any axis per event: 99th percentile and (maximum)."""
    steps = np.concatenate([abs(np.diff(axes, axis=0)).max(1) for axes in drags])
    return f"{np.percentile(steps, 99):.2g} ({steps.max():.2g})"


def _drags(font: str, glyphs: str) -> Iterator[tuple[vf.Text, vf.Handle, Array]]:
    """Yield a circle and a line from a point of each glyph, as offsets (events, 2)."""
    for glyph in glyphs:
        text, rng = vf.Text(font, glyph), np.random.default_rng(ord(glyph))
        for path in (circle(), line()):
            angle = rng.uniform(0, 2 * np.pi)
            turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
            yield text, random_handle(text, rng), text.font.units_per_em * path @ turn


def circle() -> Array:
    """Return a full circle that starts and ends at the origin."""
    events = round(2 * np.pi * RADIUS / STEP)
    angle = np.linspace(0, 2 * np.pi, events + 1)
    return RADIUS * np.stack([1 - np.cos(angle), np.sin(angle)], -1)


def line() -> Array:
    """Return a line that starts and ends at the origin."""
    x = np.linspace(0, LENGTH, round(LENGTH / STEP) + 1)
    x = np.concatenate([x, x[-2::-1]])
    return np.stack([x, np.zeros_like(x)], -1)


def follow(text: vf.Text, handle: vf.Handle, offsets: Array, stay_close: float) -> Array:
    """Drag a handle along offsets; return the axes (events, n) as shares of their ranges."""
    lower, upper = text.font.bounds
    places = text.position(handle).numpy() + offsets
    axes = []
    for place in places:
        terms = [vf.Target(handle, place), vf.StayClose(stay_close)]
        text = vf.solve(text, terms, max_iterations=MOVE_ITERATIONS, restarts=0).text
        axes.append(text.theta.numpy()[0] / (upper - lower))
    return np.array(axes)


def leaps(axes: Array) -> int:
    """Count the events at which an axis changes by more than SWING and changes back."""
    turning = np.zeros(len(axes), dtype=bool)
    for before, after in ((1, 1), (1, 2), (2, 1)):
        to = axes[before:-after] - axes[: -before - after]
        back = axes[before:-after] - axes[before + after :]
        swings = (to * back > 0) & (np.minimum(abs(to), abs(back)) > SWING)
        turning[before:-after] |= swings.any(-1)
    return int(turning.sum())
