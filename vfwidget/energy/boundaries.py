"""Boundaries between settings: where a text would get other glyphs, and what lies beyond.

The energy jumps where a glyph changes, so the solver works within the box of the design space in
which the glyphs stay. Where it ends at a side of that box, it goes on just beyond the side, and the
better of both results is kept.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from typing import NamedTuple, TypeAlias

import numpy as np

from ..arrays import Array, BoolArray, holds_anywhere
from ..errors import GlyphError, SolveError
from ..font.settings import F2DOT14
from ..solver.status import ITERATION_LIMIT, OUT_OF_TIME, Outcome
from ..text import Text
from ..text.place import AXES
from .descent import Descent, held_axes
from .energy import Energy

MOST_CROSSINGS = 16
"""A solve that keeps crossing boundaries ends after this many for each letter."""
MOST_BOXES = 64
"""Or after so many boxes: where axes move others, several boxes lead up to a boundary."""
NARROW = 0.02
"""Part of an axis, in normalized coordinates. If the box beyond a boundary is narrower, what lies
beyond that box is tried as well: fonts have slivers where the ends of condition sets differ."""
MOST_NARROW = 3
"""So many narrow boxes in a row are looked beyond."""
MANY_BOUNDARIES = Outcome(
    ITERATION_LIMIT, "More locations at which glyphs change were met than a solve crosses."
)

Entry: TypeAlias = tuple[int, int]
"""A letter and an axis: an entry of Θ."""


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


Descend = Callable[[Energy, Array], "Descent | None"]
"""Minimises an energy from one point of its free unknowns; None if time or steps are used up.

A descent that ends because its time has passed is the last one as well."""


class Crossing(NamedTuple):
    """Where a search across boundaries has ended.

    Attributes
    ----------
    energy : Energy
    found : Descent
        In the setting of the energy.
    boundaries : list of Boundary
        Those met, in order.
    cut : Outcome or None
        Why the search was ended although it could go on; None if every side was tried.
    """

    energy: Energy
    found: Descent
    boundaries: list[Boundary]
    cut: Outcome | None = None


def cross(energy: Energy, found: Descent, descend: Descend) -> Crossing:
    """Go on from where a descent ended beyond the boundaries that it met, where that costs less.

    Of the boundaries that one letter has met, the one whose other side costs least is crossed. A
    side that costs more is tried again after the same letter has crossed another boundary, and at
    the end if another letter has.

    Parameters
    ----------
    energy : Energy
    found : Descent
    descend : Descend
        Once it returns None, no further side is tried.

    Returns
    -------
    Crossing
    """
    met: list[Boundary] = []
    if len(energy.text.composition.settings.rows) == 1:
        return Crossing(energy, found, met)
    letters = len(energy.text.coordinates)
    refused: dict[Entry, _Refused] = {}
    former = set[Entry]()
    for _ in range(MOST_BOXES * letters):
        sides = list(_sides(energy, found))
        if not sides:
            return Crossing(energy, found, met)
        better, ended = list[_Side](), False
        # Letters with axes of their own hardly affect one another, so each is decided by itself.
        for _, own in groupby(sides, key=lambda side: side[0][0]):
            new = [side for side in own if side[0] not in refused]
            tried, ended = _tried(energy, found, new, descend)
            better = [side for side in tried if side.found.state.cost < found.state.cost]
            if better or ended:
                break
            for side in tried:
                # The boundary is that of the next box. Descents beyond that may be cut short too.
                known = refused.setdefault(side.entry, _Refused(side.boundary, None))
                refused[side.entry] = known._replace(cut=known.cut or side.found.cut)
            former.difference_update(side.entry for side in tried)
        if not (better or ended) and former.intersection(entry for entry, _ in sides):
            refused = {entry: side for entry, side in refused.items() if entry not in former}
            former = set()
            continue
        if not better:
            stays = [refused[entry] for entry, _ in sides if entry in refused]
            met += [side.boundary for side in stays if side.boundary.before and not side.cut]
            cuts = [side.cut for side in stays if side.cut is not None]
            cut = OUT_OF_TIME if ended else next(iter(cuts), None)
            return Crossing(energy, found, met, cut)
        best = min(better, key=lambda side: side.found.state.cost)
        energy, found = best.energy, best.found.after(found)
        if best.boundary.before:
            met.append(replace(best.boundary, crossed=True))
        if len(met) == MOST_CROSSINGS * letters:
            break
        letter = best.entry[0]
        refused = {entry: side for entry, side in refused.items() if entry[0] != letter}
        former = set(refused)
    return Crossing(energy, found, met, MANY_BOUNDARIES)


_Step: TypeAlias = tuple[Entry, float]
"""An entry of Θ that a side of the box holds, and the step that leads just beyond it."""


class _Side(NamedTuple):
    """What lies beyond a side of the box: an energy there, and where its descent ends."""

    entry: Entry
    energy: Energy
    found: Descent
    boundary: Boundary


class _Refused(NamedTuple):
    """A side whose descents ended at higher costs, and why one of them ended early, if one did."""

    boundary: Boundary
    cut: Outcome | None


def _tried(
    energy: Energy,
    found: Descent,
    sides: Sequence[_Step],
    descend: Descend,
) -> tuple[list[_Side], bool]:
    """Descend from the end of a descent beyond each of these sides.

    Returns
    -------
    tried : list of _Side
    ended : bool
        Whether time or steps were used up.
    """
    here = energy.unknowns.place(found.state.x)
    tried: list[_Side] = []
    beyond = ((side[0], text) for side in sides for text in _beyond(energy, found, *side))
    for entry, other in beyond:
        try:
            there = energy.at(other, energy.terms)
            end = descend(there, there.unknowns.flat({**here, **other.place}))
        except (GlyphError, SolveError):
            # A glyph on the other side has no such point, or a term has no value there.
            continue
        if end is None:
            return tried, True
        tried.append(_Side(entry, there, end, _boundary(energy.text, other, entry)))
        if end.state.outcome is OUT_OF_TIME:
            return tried, True
    return tried, False


def _sides(energy: Energy, found: Descent) -> Iterator[_Step]:
    """The sides of the box that hold the end of a descent, except for the ends of axes.

    Yields
    ------
    entry, step
        The entry of Θ that a side holds, and the step that leads just beyond it. Those of one
        letter follow one another.
    """
    text, at_bounds = energy.text, found.at_bounds
    if AXES not in energy.unknowns.slices or at_bounds is None:
        return
    theta = energy.unknowns.value(AXES, found.state.x)
    at_side = energy.by_letter(at_bounds) & ~at_ends(text, theta)
    if not holds_anywhere(at_side):
        return
    steps = held_axes(energy, found) / F2DOT14
    unknown = energy.by_letter(np.arange(len(energy.lower)))
    held: dict[int, Entry] = {}
    for entry in zip(*(part.tolist() for part in (at_side & (steps != 0)).nonzero()), strict=True):
        # Letters that are tied together have one unknown for each axis, and so one side.
        held.setdefault(int(unknown[entry]), entry)
    for entry in held.values():
        yield entry, float(steps[entry])


def _beyond(energy: Energy, found: Descent, entry: Entry, step: float) -> Iterator[Text]:
    """The text at the end of a descent after a step of the unknown of one entry of Θ.

    If the box there is narrow, a text beyond that box follows.

    With many letters a text takes long to make, so each is made only when it is tried.
    """
    unknown = energy.by_letter(np.arange(len(found.state.x)))[entry]
    ends = [bound[entry[1]] for bound in energy.text.font.bounds]
    for _ in range(1 + MOST_NARROW):
        x = found.state.x.copy()
        # Where axes move others, the end of the axis may be nearer than the step is long.
        x[unknown] = np.clip(x[unknown] + step, *ends)
        place = energy.unknowns.place(x)
        other = energy.text.moved_to({name: place[name] for name in energy.text.place})
        yield other
        if other.word is energy.text.word:
            # Where axes move others, several boxes with the same glyphs lead up to a boundary.
            return
        ahead = int(step > 0)
        end = other.composition.bounds_at(other.coordinates)[ahead][entry]
        width = abs(float(end - other.coordinates[entry]))
        if width > NARROW or end == ends[ahead]:
            return
        step += float(np.copysign(width + 1 / F2DOT14, step))


def at_ends(text: Text, theta: Array) -> BoolArray:
    """Which axes are at an end of their range in the font, in the shape of Θ."""
    lower, upper = text.font.bounds
    return (theta <= lower) | (theta >= upper)


def _boundary(text: Text, other: Text, entry: Entry) -> Boundary:
    """The boundary between two neighbouring texts, which an entry of Θ crosses."""
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
