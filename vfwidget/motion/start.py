"""Letters that overlap at the start, or that a new obstacle covers, are moved apart at rest.

The contact of a step would do so as well, but within the time of the step, which would throw the
letters away.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..energy import StayClose
from ..energy.descent import descend
from ..energy.energy import Energy
from ..errors import MotionError, MotionWarning, warn_caller
from ..overlap.overlaps import overlaps
from ..overlap.resolve import resolve_overlaps
from ..overlap.shape import letters
from ..solver.problem import Tolerances
from ..text import Text
from ..text.place import OFFSETS, Place
from .body import Body
from .scene import Scene
from .terms import STIFFNESS, Contact, Inertia, Touches

DEEP = 0.5
"""Font units: a deeper overlap is resolved."""
ROUNDS = 12
"""Searches for a free state nearby."""


def apart(body: Body, scene: Scene) -> Place:
    """The place of the text; if letters overlap, the nearest free place that is found.

    Raises
    ------
    MotionError
        The overlaps cannot be resolved.
    """
    before = deepest(body.text, scene.given(0.0))
    if before <= DEEP:
        return body.start(body.text)
    text = separated(body, body.text, scene, 0.0)
    if text is None:
        raise MotionError(
            f"At the start the text overlaps itself or an obstacle by {before:.3g} font units, and "
            "no free state was found nearby. Move the obstacle or the text"
            + ("." if OFFSETS in body.free else ", or pass positions=True.")
        )
    warn_caller(
        f"At the start the text overlapped itself or an obstacle by {before:.3g} font units. It "
        "starts from the nearest free state that was found.",
        MotionWarning,
    )
    return body.start(text)


def separated(body: Body, text: Text, scene: Scene, time: float) -> Text | None:
    """The nearest free state to a text that is found, among the obstacles of a time; or None."""
    obstacles = scene.given(time)
    if OFFSETS not in body.free and deepest(text, obstacles) > DEEP:
        text = resolve_overlaps(text, obstacles).text
    outlines, segments = scene.at(time)
    goal = body.reduced_at(text.place)
    for _ in range(ROUNDS):
        depth = deepest(text, obstacles)
        if depth <= DEEP:
            return text
        here = np.concatenate([body.positions(text.place)[body.controls], segments])
        touches = Touches(body, outlines.gaps(here, 2 * depth), segments)
        terms = [Inertia(body, goal), StayClose(), Contact(touches, 100 * STIFFNESS)]
        energy = Energy(text, terms, free=body.free)
        found = descend(energy, energy.unknowns.start, Tolerances(), 60, scale_by_columns=True)
        text = text.moved_to(energy.unknowns.place(found.state.x))
    return text if deepest(text, obstacles) <= DEEP else None


def deepest(text: Text, obstacles: Any) -> float:
    """The depth of the deepest overlap, in font units.

    The outlines of shapes that lie exactly on each other have no depth. Such an overlap counts as
    deep as its area is wide on average, which is less than the depth of any other overlap.
    """
    lengths = [np.hypot(*np.diff(shape.segments, axis=1).T).sum() for shape in letters(text)]
    return max(
        (max(o.depth, o.area / max(lengths[o.pair[0]], 1.0)) for o in overlaps(text, obstacles)),
        default=0.0,
    )
