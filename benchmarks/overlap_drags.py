"""Drags with overlap on: the time of an update, its growth with the letters, and random drags.

An update is one event of the pointer: the kernel solves for the target and follows the way as far
as it is free, as the editor does while ``avoid_overlaps`` is on.
"""

from __future__ import annotations

from collections.abc import Iterator
from time import process_time
from typing import Any, NamedTuple

import numpy as np

import vfwidget as vf
from vfwidget.overlap.follow import Followed, follow
from vfwidget.overlap.shape import read_obstacles

from .table import Row, milliseconds

CALM = 1e-3
"""Ems: as the editor weights the distance from the state at the press."""
ITERATIONS = 30
"""Most steps of the solver, as in the editor."""
EVENTS = 8
AHEAD, WIDTH = 40.0, 10.0
"""Font units between the word and the bar, and the width of the bar."""
LIMIT = 16.0
"""Milliseconds: one frame of a screen."""
WORDS = ("no", "Type", "lo", "gab")


class Drag(NamedTuple):
    """A text, the outline point that is dragged, where the pointer goes, and obstacles.

    Attributes
    ----------
    way : (e, 2) array
        The pointer's distance from where it was pressed, in font units, at each event.
    """

    text: vf.Text
    handle: vf.Handle
    way: Any
    obstacles: list[Any]

    def states(self) -> Iterator[tuple[Followed, float]]:
        """The result of every event, and the milliseconds of processor time it took."""
        text, press = self.text, self.text.position(self.handle).numpy()
        calm = vf.StayClose((CALM * text.font.units_per_em) ** 2, text.theta)
        keep, held = vf.NoOverlap(read_obstacles(self.obstacles)), None
        for delta in self.way:
            terms = [vf.Target(self.handle, press + delta), calm]
            begun = process_time()
            found = follow(text, terms, keep, max_iterations=ITERATIONS, held=held)
            yield found, 1e3 * (process_time() - begun)
            text, held = found.solution.text, found.held


def run(quick: bool) -> Iterator[Row]:
    """Times of blocked updates, and the areas of random drags."""
    turns = 2 if quick else 9
    for name in ("recursive", "roboto-flex"):
        for shared in (True, False):
            found = blocked_updates([against_a_bar(name, shared, 8)], turns)[0]
            yield Row(
                benchmark="overlap",
                case=f"a blocked update, 8 letters, {name}",
                ours=milliseconds(float(np.median(found))),
                baseline=f"limit {LIMIT:.0f} ms",
                ratio=f"{LIMIT / np.median(found):.1f}×",
                notes=f"longest of {len(found)} blocked updates {milliseconds(max(found))}, "
                f"{'shared axes' if shared else 'axes of their own'}",
            )
    lines = [against_a_bar("recursive", True, letters) for letters in (20, 80)]
    few, many = (float(np.median(times)) for times in blocked_updates(lines, turns))
    yield Row(
        benchmark="overlap",
        case="a blocked update, 80 letters",
        ours=milliseconds(many),
        baseline=f"20 letters {milliseconds(few)}",
        ratio=f"{many / few:.1f}×",
        notes="at most 4.5 times as long",
    )
    count = 10 if quick else 200
    steps = [step for drag in random_drags(count) for step in increases(drag)]
    yield Row(
        benchmark="overlap",
        case=f"{count} random drags",
        ours=f"{sum(step > 1e-6 for step in steps)} steps",
        baseline="0 steps",
        ratio="",
        notes=f"of {len(steps)} that overlap more than the one before; largest {max(steps):.1g}",
    )


def against_a_bar(name: str, shared: bool, letters: int) -> Drag:
    """The last letter of a line is dragged to the right, where a bar stands in the way."""
    text = vf.Text(name, ("variable" * 10)[:letters], shared=shared)
    points = text.points().numpy()
    right, (low, high) = float(points[:, 0].max()), (points[:, 1].min(), points[:, 1].max())
    x = right + AHEAD
    bar = np.array([(x, low - 50), (x + WIDTH, low - 50), (x + WIDTH, high + 50), (x, high + 50)])
    handle = text.nearest(right, 0.3 * text.font.units_per_em)
    way = 1.5 * AHEAD * np.arange(1, EVENTS + 1)[:, None] * [1.0, 0.0]
    return Drag(text, handle, way, [bar])


def blocked_updates(drags: list[Drag], turns: int) -> list[list[float]]:
    """For each drag, the milliseconds of its updates with a contact; the least of some turns."""
    least: list[dict[int, float]] = [{} for _ in drags]
    for _ in range(turns):
        for times, drag in zip(least, drags, strict=True):
            for event, (found, spent) in enumerate(drag.states()):
                if len(found.contacts):
                    times[event] = min(spent, times.get(event, np.inf))
    return [list(times.values()) for times in least]


def random_drags(count: int, seed: int = 0) -> Iterator[Drag]:
    """Drags of a random outline point in a random direction, with a bar across the word."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        name, word = rng.choice(vf.bundled_fonts()), rng.choice(WORDS)
        text = vf.Text(str(name), str(word), shared=bool(rng.integers(2)))
        em, points = text.font.units_per_em, text.points().numpy()
        width, angle = em * rng.uniform(0.005, 0.1), rng.uniform(-2, 2)
        corners = np.array([(0, -300), (width, -300), (width, 900), (0, 900)])
        turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        bar = 0.4 * corners @ turn + rng.uniform(points.min(0), points.max(0))
        handle = text.nearest(*points[rng.integers(len(points))])
        way = em * rng.normal(0, 0.15, 2) * np.linspace(0, 1, 5)[1:, None]
        yield Drag(text, handle, way, [bar])


def increases(drag: Drag) -> list[float]:
    """By how much the common area grows at each event, in square font units."""
    texts = [drag.text, *(found.solution.text for found, _ in drag.states())]
    areas = [sum(found.area for found in vf.overlaps(text, drag.obstacles)) for text in texts]
    return np.diff(areas).tolist()
