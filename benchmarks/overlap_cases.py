"""Seeded cases in which letters overlap, each with a state at which they are known to be free."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

import vfwidget as vf

WORDS = ("NT", "ello", "AVA", "rock", "Type", "glyph", "wave")
KINDS = ("tracked", "per letter", "artwork")
LEAST = 200.0
"""Square font units, for an em of 1,000: smaller overlaps are no case."""


class Case(NamedTuple):
    """A text whose letters overlap, obstacles, and the witness: Θ at which nothing overlaps."""

    kind: str
    text: vf.Text
    obstacles: list[Any]
    witness: Any


def cases(count: int, seed: int = 0) -> Iterator[Case]:
    """So many cases, the kinds in turn, on the bundled fonts."""
    rng = np.random.default_rng(seed)
    fonts = {name: vf.load_font(name) for name in vf.bundled_fonts()}
    made = 0
    while made < count:
        case = _case(KINDS[made % len(KINDS)], rng, fonts)
        if case is not None:
            made += 1
            yield case


def _case(kind: str, rng: Any, fonts: dict[str, vf.Font]) -> Case | None:
    name, word = rng.choice(list(fonts)), rng.choice(WORDS)
    text = vf.Text(fonts[str(name)], str(word), shared=kind != "per letter")
    lower, upper = text.font.bounds
    em = text.font.units_per_em
    witness, start = rng.uniform(lower, upper, (2, *text.theta.shape))
    obstacles = []
    if kind == "artwork":
        (left, _), (right, top) = _box(text.at(theta=start))
        x, y = rng.uniform(left, right), rng.uniform(0, top)
        width, height = em * rng.uniform(0.04, 0.4, 2)
        corners = [(x, y), (x + width, y), (x + width, y + height), (x, y + height)]
        obstacles = [np.array(corners) @ _turn(rng.uniform(-0.5, 0.5))]
    else:
        tracking = -em * rng.uniform(0, 0.15)
        text = text.at(offsets=[(i * tracking, 0) for i in range(len(text.glyphs))])
    here, there = text.at(theta=start), text.at(theta=witness)
    if vf.overlaps(there, obstacles):
        return None
    area = sum(overlap.area for overlap in vf.overlaps(here, obstacles))
    return Case(kind, here, obstacles, witness) if area > LEAST * (em / 1000) ** 2 else None


def _box(text: vf.Text) -> Any:
    points = text.points().numpy()
    return points.min(0), points.max(0)


def _turn(angle: float) -> Any:
    return np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
