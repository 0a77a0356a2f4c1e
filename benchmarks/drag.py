"""One update of a drag: ours against the paper's recipe, on the same pointer positions.

Each method starts every update from the result of its own previous update, as in a real drag.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import torch

import vfwidget as vf

from .recipe import Recipe
from .table import Row, milliseconds
from .timing import Array, Times, interleave

EVENTS = 30
STAY_CLOSE = 1e-3
LIMIT = 30
"""Iterations of one update; the editor has the same limit while the pointer moves."""
TOLERATED = 0.5
"""Font units by which our distance to the target may exceed that of the recipe."""
WORD = "variable"


@dataclass(frozen=True)
class Drag:
    """A point of the last letter of a word, and the positions of the pointer.

    Every axis of the text starts at a fifth of the way from the default to its farther end. At the
    default, φ as printed has no slope for an axis that only decreases, so the recipe would stop.
    """

    text: vf.Text
    handle: vf.Handle
    targets: list[Array]

    @staticmethod
    def reachable(text: vf.Text) -> Drag:
        """Return positions of the handle while all axes move to four fifths of their range."""
        text, handle, far = _start(text)
        places = [text.at(theta=way * far) for way in np.linspace(0.2, 0.8, EVENTS + 1)[1:]]
        return Drag(text, handle, [place.position(handle).numpy() for place in places])

    @staticmethod
    def beyond(text: vf.Text) -> Drag:
        """Return positions up to half an em to the upper right, which no axis can reach."""
        text, handle, _ = _start(text)
        end = text.font.units_per_em * np.array([0.4, 0.3])
        start = text.position(handle).numpy()
        parts = np.linspace(0, 1, EVENTS + 1)[1:]
        return Drag(text, handle, [start + part * end for part in parts])


def _start(text: vf.Text) -> tuple[vf.Text, vf.Handle, Array]:
    lower, upper = text.font.bounds
    far = np.broadcast_to(np.where(-lower > upper, lower, upper), tuple(text.theta.shape))
    text = text.at(theta=0.2 * far)
    last = len(text.glyphs) - 1
    return text, text.handle(last, 0, text.glyphs[last].contours[0] // 2, 0.5), far


class Ours:
    """Does what the editor does at a pointer move."""

    def __init__(self, drag: Drag) -> None:
        self.drag = drag
        self.misses = np.zeros(EVENTS)
        self.steps = np.zeros(EVENTS)

    def start(self) -> None:
        self.text = self.drag.text

    def update(self, event: int) -> None:
        target = vf.Target(self.drag.handle, self.drag.targets[event])
        terms = [target, vf.StayClose(STAY_CLOSE)]
        solution = vf.solve(self.text, terms, max_iterations=LIMIT, restarts=0)
        self.text = solution.text
        self.misses[event] = solution.misses[0]
        self.steps[event] = solution.iterations


class Theirs:
    """Does what the recipe does at a pointer move."""

    def __init__(self, drag: Drag, trimmed: bool) -> None:
        self.drag = drag
        self.recipe = Recipe(drag.text, drag.handle, STAY_CLOSE, trimmed)
        self.targets = [torch.from_numpy(target) for target in drag.targets]
        self.thetas = [drag.text.theta] * EVENTS
        self.steps = np.zeros(EVENTS)

    def start(self) -> None:
        self.theta = self.drag.text.theta

    def update(self, event: int) -> None:
        self.theta, self.steps[event] = self.recipe.update(self.theta, self.targets[event], LIMIT)
        self.thetas[event] = self.theta

    @property
    def misses(self) -> Array:
        places = [self.recipe.point(theta) for theta in self.thetas]
        return np.array([float((p - t).norm()) for p, t in zip(places, self.targets, strict=True)])


def run(quick: bool) -> Iterator[Row]:
    """Drag a glyph and a word of each bundled font, a word with shared axes, and out of reach."""
    for name in vf.bundled_fonts():
        glyph = Drag.reachable(vf.Text(name, "a"))
        yield from _compare(f"{name} a", glyph, rounds=5 if quick else 20)
    shared = Drag.reachable(vf.Text("recursive", WORD))
    yield from _compare(f"recursive {WORD}, shared", shared, rounds=3 if quick else 7)
    for name in vf.bundled_fonts():
        word = Drag.reachable(vf.Text(name, WORD, shared=False))
        yield from _compare(f"{name} {WORD}, per letter", word, rounds=3 if quick else 7)
    away = Drag.beyond(vf.Text("recursive", "a"))
    yield from _compare("recursive a, out of reach", away, rounds=3 if quick else 7)


def _compare(case: str, drag: Drag, rounds: int) -> Iterator[Row]:
    ours, plain, trimmed = Ours(drag), Theirs(drag, trimmed=False), Theirs(drag, trimmed=True)
    times = interleave([ours, plain, trimmed], EVENTS, rounds)
    yield _row(case, times, 1, "recipe", ours, plain)
    yield _row(case, times, 2, "trimmed recipe", ours, trimmed)


def _row(case: str, times: Times, rival: int, name: str, ours: Ours, theirs: Theirs) -> Row:
    steps = f"steps {ours.steps.mean():.1f} | {theirs.steps.mean():.1f}"
    miss = f"miss {ours.misses.max():.2g} | {theirs.misses.max():.2g}"
    worse = (ours.misses > theirs.misses + TOLERATED).any()
    return Row(
        benchmark="drag",
        case=case,
        ours=milliseconds(times.median(0)),
        baseline=f"{name} {milliseconds(times.median(rival))}",
        ratio=str(times.ratio(rival, 0)),
        notes=f"{steps}, {miss}" + (", OURS MISSES MORE" if worse else ""),
    )
