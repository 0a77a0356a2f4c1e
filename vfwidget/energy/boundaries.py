"""Boundaries between settings: where a text would get other glyphs, and what lies beyond.

The energy jumps where a glyph changes, so the solver works within the box of the design space in
which the glyphs stay. Where it ends at a side of that box, it goes on just beyond the side, and the
better of both results is kept.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Array, BoolArray
from ..errors import GlyphError
from ..font.settings import F2DOT14
from ..text import Text
from ..text.place import AXES
from .descent import Descent, held_axes
from .energy import Energy

MOST_CROSSINGS = 16
"""A solve that keeps crossing boundaries ends after this many."""
MOST_BOXES = 64
"""Or after so many boxes: where axes move others, several boxes lead up to a boundary."""


@dataclass(frozen=True)
class Boundary:
    """A boundary between two rows of glyphs that a solve has met.

    Attributes
    ----------
    axis : str
        Tag of the axis that the boundary crosses.
    value : float
        Where it does, as a user value.
    letter : int or None
        The letter, where each has axes of its own.
    before, after : tuple of str
        Names of the glyphs that change, on the near and on the far side.
    crossed : bool
        Whether the solve went on beyond it.
    """

    axis: str
    value: float
    letter: int | None
    before: tuple[str, ...]
    after: tuple[str, ...]
    crossed: bool = False

    def __str__(self) -> str:
        where = "" if self.letter is None else f" of letter {self.letter + 1}"
        change = f"{' '.join(self.before)} becomes {' '.join(self.after)}"
        end = "crossed" if self.crossed else "not crossed, because that would cost more"
        return f"{change} at {self.axis}{where} = {self.value:.4g}: {end}"


Descend = Callable[[Energy, Array], Descent]
"""Minimises an energy from one point of its free unknowns."""


def cross(
    energy: Energy, found: Descent, descend: Descend, deadline: float = math.inf
) -> tuple[Energy, Descent, list[Boundary]]:
    """Go on from where a descent ended beyond the boundaries that it met, where that costs less.

    Parameters
    ----------
    energy : Energy
    found : Descent
    descend : Descend
    deadline : float
        The value of ``time.perf_counter()`` after which no boundary is crossed. Default: no limit.

    Returns
    -------
    energy, descent
        Those of the setting in which the search ended.
    boundaries : list of Boundary
        Those met, in order.
    """
    met: list[Boundary] = []
    if len(energy.text.composition.settings.rows) == 1:
        return energy, found, met
    for _ in range(MOST_BOXES):
        best: tuple[Energy, Descent, Boundary] | None = None
        stays: list[Boundary] = []
        for entry, other in _beyond(energy, found):
            if time.perf_counter() > deadline:
                break
            try:
                there = energy.at(other, energy.terms)
            except GlyphError:
                # A glyph on the other side has no such point.
                continue
            here = energy.unknowns.place(found.state.x)
            start = there.unknowns.flat({**here, **other.place})
            end = descend(there, start)
            side = _boundary(energy.text, other, entry)
            stays.append(side)
            if end.state.cost < (best[1] if best else found).state.cost:
                best = there, end.after(found), side
        if best is None:
            return energy, found, met + [side for side in stays if side.before]
        energy, found, side = best
        if side.before:
            met.append(replace(side, crossed=True))
        if len(met) == MOST_CROSSINGS:
            break
    return energy, found, met


def _beyond(energy: Energy, found: Descent) -> Iterator[tuple[tuple[int, int], Text]]:
    """The texts next to the end of a descent, beyond the sides of the box that hold it there.

    Yields
    ------
    (letter, axis), text
        The entry of Θ that leaves the box.
    """
    text, x, at_bounds = energy.text, found.state.x, found.at_bounds
    if AXES not in energy.unknowns.slices or at_bounds is None:
        return
    place = energy.unknowns.place(x)
    at_side = energy.by_letter(at_bounds) & ~at_ends(text, place[AXES])
    if not np.count_nonzero(at_side):
        return
    own = {name: place[name] for name in text.place}
    steps = held_axes(energy, found) / F2DOT14
    for letter, axis in np.argwhere(at_side & (steps != 0)).tolist():
        theta = place[AXES].copy()
        theta[letter, axis] += steps[letter, axis]
        yield (letter, axis), text.moved_to({**own, AXES: theta})


def at_ends(text: Text, theta: Array) -> BoolArray:
    """Which axes are at an end of their range in the font, in the shape of Θ."""
    lower, upper = text.font.bounds
    return (theta <= lower) | (theta >= upper)


def _boundary(text: Text, other: Text, entry: tuple[int, int]) -> Boundary:
    """The boundary between two neighbouring texts, which an entry (letter, axis) of Θ crosses."""
    letter, axis = entry
    before, after = ([glyph.name for glyph in one.glyphs] for one in (text, other))
    if len(before) == len(after):
        changed = [i for i, name in enumerate(before) if name != after[i]]
        before, after = [before[i] for i in changed], [after[i] for i in changed]
    value = text.font.axes[axis].denormalize(float(other.coordinates[letter, axis]))
    return Boundary(
        axis=text.font.axes[axis].tag,
        value=value,
        letter=None if text.shared else letter,
        before=tuple(before),
        after=tuple(after),
    )
