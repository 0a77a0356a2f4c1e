"""Where one solve gets to, and how steadily a drag follows the pointer.

*Places.* A point of a letter is dragged from the default to a place it can reach: half of the
places are the point's own at random instances, half lie anywhere within 0.3 em of its default and
are kept where brute force comes within a unit of them: 1,000 random instances, and a solve from
each of the nearest few. The share of places that one solve comes within a unit of is reported.

*Drags.* The pointer goes along circles and lines, in reach and out of it, 0.1 % of the em at each
event, which is answered as the editor answers a move. Reported are the steps that axes take, as
shares of their ranges, and leaps: swings by over a tenth of the range and back within three
events, which is seen as flicker.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from time import process_time

import numpy as np

import vfwidget as vf
from vfwidget.view.editor import CALM, MOVE_ITERATIONS

from .table import Row, milliseconds
from .timing import Array

GLYPHS = "aRg&8"
PLACES = 80
"""For each glyph of each font, of both kinds together."""
WITHIN = 1.0
"""Font units."""
FARTHEST = 0.3
"""Ems."""
STAY_CLOSE = 1e-3
INSTANCES, REFINED = 1000, 5
TRIES, KEPT = 8, 2
"""Places drawn anywhere for each handle, and how many of the reachable ones are taken."""
STEP = 1e-3
"""Ems by which the pointer moves at each event."""
RADIUS, LENGTH = 0.1, 0.3
"""Of the circles and the lines, in ems."""
SWING = 0.1
DRAGGED = "ag"


@dataclass(frozen=True)
class Place:
    """A handle and where it is to go from the text's own place."""

    text: vf.Text
    handle: vf.Handle
    target: Array


@dataclass(frozen=True)
class Attempt:
    """How near a solve came, in font units, and the milliseconds that took."""

    miss: float
    time: float


def run(quick: bool) -> Iterator[Row]:
    """Each font: what is reached, then how its axes step."""
    for name in vf.bundled_fonts():
        found = places(name, GLYPHS, PLACES // 20 if quick else PLACES)
        yield _reach_row(name, found)
    for name in vf.bundled_fonts():
        yield _steadiness_row(name, DRAGGED[:1] if quick else DRAGGED)


def places(font: str, glyphs: str, count: int) -> list[Place]:
    """Reachable places of points of each glyph: half at instances, half anywhere."""
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
    """Any point of the first letter's outline."""
    contours = text.glyphs[0].contours
    contour = int(rng.integers(len(contours)))
    return text.handle(0, contour, int(rng.integers(contours[contour])), rng.random())


def brute_force(
    text: vf.Text, handle: vf.Handle, targets: Array, rng: np.random.Generator
) -> Array:
    """How near a handle is found to come to targets (t, 2), (t,)."""
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
        gain_tolerance=1e-3,
        zero=1e-3,
    )
    return np.sqrt(found.cost).reshape(-1, REFINED).min(1)


def attempt(place: Place, restarts: int) -> Attempt:
    """One solve."""
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
    """How many of a hundred came near enough."""
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
    """The largest step of any axis at an event: 99th percentile and, in brackets, most."""
    steps = np.concatenate([abs(np.diff(axes, axis=0)).max(1) for axes in drags])
    return f"{np.percentile(steps, 99):.2g} ({steps.max():.2g})"


def _drags(font: str, glyphs: str) -> Iterator[tuple[vf.Text, vf.Handle, Array]]:
    """A circle and a line there and back from a point of each glyph, as offsets (events, 2)."""
    for glyph in glyphs:
        text, rng = vf.Text(font, glyph), np.random.default_rng(ord(glyph))
        for path in (circle(), line()):
            angle = rng.uniform(0, 2 * np.pi)
            turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
            yield text, random_handle(text, rng), text.font.units_per_em * path @ turn


def circle() -> Array:
    """Once round, from and to the origin."""
    events = round(2 * np.pi * RADIUS / STEP)
    angle = np.linspace(0, 2 * np.pi, events + 1)
    return RADIUS * np.stack([1 - np.cos(angle), np.sin(angle)], -1)


def line() -> Array:
    """There and back."""
    x = np.linspace(0, LENGTH, round(LENGTH / STEP) + 1)
    x = np.concatenate([x, x[-2::-1]])
    return np.stack([x, np.zeros_like(x)], -1)


def follow(text: vf.Text, handle: vf.Handle, offsets: Array, stay_close: float) -> Array:
    """Axes (events, n) as shares of their ranges, while a handle is dragged along offsets."""
    lower, upper = text.font.bounds
    places = text.position(handle).numpy() + offsets
    axes = []
    for place in places:
        terms = [vf.Target(handle, place), vf.StayClose(stay_close)]
        text = vf.solve(text, terms, max_iterations=MOVE_ITERATIONS, restarts=0).text
        axes.append(text.theta.numpy()[0] / (upper - lower))
    return np.array(axes)


def leaps(axes: Array) -> int:
    """How many events an axis swings by more than :data:`SWING` to and leaves again at once."""
    turning = np.zeros(len(axes), dtype=bool)
    for before, after in ((1, 1), (1, 2), (2, 1)):
        to = axes[before:-after] - axes[: -before - after]
        back = axes[before:-after] - axes[before + after :]
        swings = (to * back > 0) & (np.minimum(abs(to), abs(back)) > SWING)
        turning[before:-after] |= swings.any(-1)
    return int(turning.sum())
