"""Resolve overlaps through the axes, as near to the user's state as possible (Sec. 5.2)."""

from __future__ import annotations

import math
import time
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from ..arrays import Array
from ..energy import Solution, StayClose, Term
from ..energy.descent import descend
from ..energy.energy import Energy
from ..energy.solve import ends_reached, solution_of
from ..errors import SolveError
from ..solver.problem import Tolerances, is_count, is_number
from ..text import Text
from .no_overlap import NoOverlap
from .overlaps import overlaps

FREE_AREA = 1e-3
"""Square font units: a state with a smaller common area is free."""
PUSH, PULL = (1.0, 1e-6), (100.0, 100.0)
"""Weights of the area, and of the distance from the user's state, in the two energies."""
ROUNDS, ENOUGH = 3, 0.99
"""Most searches for a nearer state. They end when one keeps more than this part of the distance."""
MOST_STEPS = 60
"""Steps of a descent."""
BACK = 10
"""Halvings of the way from a free state back to the user's state."""
INSIDE = 0.02
"""Part of that way from which the boundary of the free states is followed."""
TOLERANCES = Tolerances(step=1e-5, absolute_cost=1e-4, cost_floor=1e-5)
"""Of a descent: in normalized coordinates, and in square font units."""


@dataclass(frozen=True, repr=False)
class Resolution(Solution):
    """The result of :func:`resolve_overlaps`: a :class:`Solution`, and whether it is free.

    Attributes
    ----------
    area : float
        Common area that is left, in square font units.
    free : bool
        Whether no overlap is left.
    blocked_by : tuple of str
        The axis bounds that stand in the way, such as ``"wght is at its minimum"``; empty if it
        is free.
    """

    area: float = 0.0
    free: bool = True
    blocked_by: tuple[str, ...] = ()


def resolve_overlaps(
    text: Text,
    obstacles: Any = (),
    gap: float = 0.0,
    *,
    between_glyphs: bool = True,
    method: str = "area",
    terms: Sequence[Term] = (),
    locks: Collection[str] = (),
    restarts: int = 5,
    seconds: float | None = None,
) -> Resolution:
    """Find the axes nearest to those of the text at which nothing overlaps.

    Parameters
    ----------
    text : Text
        It is not changed.
    obstacles : obstacle, or sequence of obstacles
        As for :func:`~vfwidget.overlaps`.
    gap : float
        Smallest distance between letters, and to obstacles, in font units. Default 0.
    between_glyphs : bool
        Whether letters must not overlap each other. Default True.
    method : {"area", "planes"}
        As for :class:`NoOverlap`.
    terms : sequence of Term
        Further terms, such as pins.
    locks : collection of str
        Tags of axes that keep their values.
    restarts : int
        Number of other places from which free states are searched as well. The nearest state is
        the result. Default 5.
    seconds : float, optional
        Restarts end after this time. Default: no limit, so that a result can be repeated exactly.

    Returns
    -------
    Resolution

    Raises
    ------
    OverlapError
        As for :class:`NoOverlap`.
    SolveError
        A term is not valid for this text, or another argument is not what is described above.

    Notes
    -----
    Two energies are minimised. One is the common area alone, and leads to a free state. The other
    adds the distance from the user's state, and leads along the boundary of the free states to
    the nearest of them. The first is also minimised from other places.

    Examples
    --------
    >>> import vfwidget as vf
    >>> text = vf.Text("roboto-flex", "NT").at(offsets=[(0, 0), (-260, 0)])
    >>> solution = vf.resolve_overlaps(text)
    >>> solution.free, vf.overlaps(solution.text)
    (True, [])
    """
    if not isinstance(text, Text):
        raise SolveError(f"resolve_overlaps needs a Text first; received {type(text).__name__}.")
    if not is_count(restarts):
        raise SolveError(f"restarts must be a whole number ≥ 0; received {restarts!r}.")
    if not (seconds is None or (is_number(seconds) and seconds >= 0)):
        raise SolveError(f"seconds must be a number ≥ 0, or None; received {seconds!r:.200}.")
    if not isinstance(terms, Sequence):
        raise SolveError(f"terms must be a sequence of terms; received {terms!r:.200}.")
    until = math.inf if seconds is None else time.perf_counter() + seconds
    keep = NoOverlap(obstacles, between_glyphs, gap, method=method)
    search = _Search(text, keep, terms, locks)
    if search.is_free(search.start):
        return search.resolution(search.start)
    best = search.nearer(search.pulled(search.start), search.pushed(search.start))
    for x in search.other_places(restarts):
        if time.perf_counter() > until:
            break
        best = search.nearer(best, search.pushed(x))
    return search.resolution(search.least if best is None else search.nearest(best))


class _Search:
    """The free states of one text, and which of them is nearest to the user's state."""

    def __init__(
        self, text: Text, keep: NoOverlap, terms: Sequence[Term], locks: Collection[str]
    ) -> None:
        self.text, self.keep = text, keep
        self.push, self.pull = (
            Energy(text, [replace(keep, weight=area), StayClose(near), *terms], locks=locks)
            for area, near in (PUSH, PULL)
        )
        self.start = self.push.unknowns.start
        self.least = self.start

    def excess(self, x: Array) -> float:
        """The common area at x, in square font units, with the squares of gaps not kept."""
        if self.push.moves:
            self.push.renew(x)
        return self.push.results(x)[0].cost

    def distance(self, x: Array) -> float:
        """How far x is from the user's state, in normalized coordinates."""
        return float(np.linalg.norm(x - self.start))

    def moved(self, energy: Energy, x: Array) -> Array:
        """Where a descent from x ends."""
        return descend(energy, x, TOLERANCES, MOST_STEPS).state.x

    def is_free(self, x: Array) -> bool:
        """Whether nothing overlaps at x."""
        return self.excess(x) <= FREE_AREA

    def pushed(self, x: Array) -> Array | None:
        """A free state that is reached from x, moved back towards the user's; or None."""
        x = self.moved(self.push, x)
        if self.excess(x) <= self.excess(self.least):
            self.least = x
        return self.back(x) if self.is_free(x) else None

    def pulled(self, x: Array) -> Array | None:
        """A free state near to the user's, reached from x by way of the least total energy."""
        return self.pushed(self.moved(self.pull, x))

    def nearer(self, one: Array | None, other: Array | None) -> Array | None:
        """The one of two states that is nearer to the user's; None stands for no state."""
        if one is None or other is None:
            return one if other is None else other
        return min(one, other, key=self.distance)

    def other_places(self, count: int) -> Iterator[Array]:
        """Places to start from, the same ones at every call."""
        chance = np.random.default_rng(0)
        for _ in range(count):
            yield chance.uniform(self.push.lower, self.push.upper)

    def nearest(self, x: Array) -> Array:
        """The nearest free state that is found from a free state x."""
        for _ in range(ROUNDS):
            other = self.pulled(x + INSIDE * (self.start - x))
            if other is None or self.distance(other) > ENOUGH * self.distance(x):
                break
            x = other
        return x

    def back(self, x: Array) -> Array:
        """The last free state on the way from a free state x to the user's state."""
        low, high = 0.0, 1.0
        for _ in range(BACK):
            middle = (low + high) / 2
            if self.is_free(x + middle * (self.start - x)):
                low = middle
            else:
                high = middle
        return x + low * (self.start - x)

    def resolution(self, x: Array) -> Resolution:
        """The state x as a result."""
        energy = self.push
        found = solution_of(energy, descend(energy, x, TOLERANCES, MOST_STEPS))
        left = overlaps(found.text, self.keep.obstacles)
        area = sum(o.area for o in left if o.obstacle or self.keep.between_glyphs)
        # Planes may be met while a sliver is left between their points.
        free = self.is_free(x) and area <= FREE_AREA
        values = {field.name: getattr(found, field.name) for field in fields(found)}
        blocked = () if free else tuple(ends_reached(self.text, found.active))
        return Resolution(**values, area=area, free=free, blocked_by=blocked)
