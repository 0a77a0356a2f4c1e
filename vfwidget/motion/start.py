"""Letters that overlap at the start, or that a new obstacle covers, are moved apart at rest.

The contact of a step would do so as well, but within the time of the step, which would throw the
letters away.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..energy import StayClose
from ..energy.descent import descend
from ..energy.energy import Energy
from ..errors import MotionError, MotionWarning, warn_caller
from ..overlap.overlaps import Overlap, overlaps
from ..overlap.resolve import resolve_overlaps
from ..overlap.shape import Shape, letters
from ..overlap.way_out import way_out
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
        The letters cannot move freely, and their axes do not resolve the overlaps.
    """
    before = deepest(body.text, scene.given(0.0))
    if before <= DEEP:
        return body.start(body.text)
    text = separated(body, body.text, scene, 0.0)
    if text is None:
        raise MotionError(
            f"At the start the text overlaps itself or an obstacle by {before:.3g} font units, and "
            "the search found no axes at which it is free. Move the obstacle or the text, or pass "
            "positions=True."
        )
    warn_caller(
        f"At the start the text overlapped itself or an obstacle by {before:.3g} font units. It "
        "starts from the nearest free state that was found.",
        MotionWarning,
    )
    return body.start(text)


def separated(body: Body, text: Text, scene: Scene, time: float) -> Text | None:
    """The nearest free state to a text that is found, among the obstacles of a time; or None.

    Letters that move freely always have one, because they can leave everything on a straight way.
    """
    goal = body.reduced_at(text.place)
    found = [_pressed_apart(body, text, scene, time)]
    if OFFSETS in body.free:
        found.append(_moved_out(text, scene, time))
    free = [one for one in found if one is not None]
    return min(
        free,
        key=lambda one: float(np.linalg.norm(body.reduced_at(one.place) - goal)),
        default=None,
    )


def _pressed_apart(body: Body, text: Text, scene: Scene, time: float) -> Text | None:
    """A free state to which contacts press the text, by axes and by positions; or None."""
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


def _moved_out(text: Text, scene: Scene, time: float) -> Text | None:
    """The text, in which each letter that overlaps something has left it; None if one cannot."""
    obstacles = scene.shapes(time)
    offsets = text.place[OFFSETS].copy()
    # A letter that has moved overlaps nothing any more.
    for _ in range(1 + len(text.glyphs)):
        own = letters(text)
        deep = [o for o in overlaps(text, obstacles) if _depth(o, own) > DEEP]
        if not deep:
            return text
        letter = deep[0].pair[0]
        others = [*own[:letter], *own[letter + 1 :], *obstacles]
        offsets[letter] += way_out(own[letter], others)
        text = text.moved_to({**text.place, OFFSETS: offsets.copy()})
    return None


def deepest(text: Text, obstacles: Any) -> float:
    """The depth of the deepest overlap, in font units."""
    own = letters(text)
    return max((_depth(overlap, own) for overlap in overlaps(text, obstacles)), default=0.0)


def _depth(overlap: Overlap, own: Sequence[Shape]) -> float:
    """How deep an overlap is, in font units; ``own`` are the shapes of the letters.

    The outlines of shapes that lie exactly on each other have no depth. Such an overlap counts as
    deep as its area is wide on average, which is less than the depth of any other overlap.
    """
    segments = own[overlap.pair[0]].segments
    length = np.hypot(*np.diff(segments, axis=1).T).sum()
    return max(overlap.depth, overlap.area / max(length, 1.0))
