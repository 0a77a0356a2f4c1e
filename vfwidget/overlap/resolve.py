"""Resolve overlaps through the axes, as near to the user's state as possible (Sec. 5.2)."""

from __future__ import annotations

import math
import time
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Any, cast

import numpy as np

from ..arrays import Array, between
from ..energy import Solution, StayClose, Term
from ..energy.descent import descend
from ..energy.solution import UNREACHABLE
from ..energy.solve import ends_reached, solution_of
from ..energy.tied import Ties, energy_of
from ..errors import SolveError
from ..solver.problem import Tolerances, is_count, is_number
from ..solver.status import CONVERGED, TIME_LIMIT, Outcome
from ..text import Text
from ..threads import one_thread
from .inequalities import Model, Walls
from .no_overlap import NoOverlap
from .overlaps import TOUCH
from .walls import Look, Room

SEARCHED = Outcome(CONVERGED, "the search for the nearest free state has ended")
FREE_AREA = 1e-3
"""Square font units: a state with a smaller common area is called free, although a search
looks for states whose shapes touch at most."""
TRIES, TIGHTENED = 8, 5
"""Steps that do not halve the common area, before a search ends; and further steps after it has
found a free state."""
ENOUGH = 0.99
"""A search ends when a free state keeps more than this part of the distance of the last one."""
CLOSE = 0.5
"""Font units: a model is exact if it was made where overlaps are less deep."""
SLACK = 0.01
"""If nothing is free: states whose area is larger than the least by this part are as good."""
NEAREST, PUSHED = 1.0, 1e-6
"""Weights of the distance from the user's state: in a search along inequalities, and in a descent
of the common area, in square font units."""
MOST_STEPS = 60
"""Steps of a descent of the common area."""
BACK = 0.01
"""The way back to the user's state is halved down to this part of it."""
STILL = 1e-6
"""A search ends at a step that is shorter, in normalized coordinates."""
CHOICES = 2
"""Times that the best bound of each unknown is chosen for a restart."""
TOLERANCES = Tolerances(step=1e-5, absolute_cost=1e-4, cost_floor=1e-5)
"""Of a descent of the common area: in normalized coordinates, and in square font units."""


@dataclass(frozen=True, repr=False)
class Resolution(Solution):
    """The result of :func:`resolve_overlaps`: a :class:`Solution`, and whether it is free.

    The status is ``"converged"`` if it is free and meets the goals of all terms; ``"unreachable"``
    if overlaps are left, or a goal is missed; and ``"time_limit"`` if overlaps are left because the
    search had no more time. The message says which goals are missed, and by how much.

    Attributes
    ----------
    area : float
        Common area that is left, in square font units.
    free : bool
        Whether no overlap is left. Goals of other terms may be missed all the same.
    blocked_by : tuple of str
        The axis bounds that stand in the way, such as ``"wght is at its minimum"``; empty if it
        is free.
    """

    area: float = 0.0
    free: bool = True
    blocked_by: tuple[str, ...] = ()


@one_thread
def resolve_overlaps(
    text: Text,
    obstacles: Any = (),
    gap: float = 0.0,
    *,
    between_glyphs: bool = True,
    method: str = "area",
    terms: Term | Sequence[Term] = (),
    locks: Collection[str] = (),
    ties: Ties = (),
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
    terms : Term, or sequence of Term
        Further terms, such as pins.
    locks : collection of str
        Tags of axes that keep their values.
    ties : sequence of sequences of int
        Groups of letters that share one axis vector, as for :func:`solve`. Default: none.
    restarts : int
        If no free state is found from the user's state, the search is repeated from this many
        other places. The nearest state is the result. Default 5.
    seconds : float, optional
        The search ends after this time, with what it has found. Default: no limit, so that a
        result can be repeated exactly.

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
    Where shapes overlap, their common area is linearised, which gives one inequality for each
    pair. The state nearest to the user's that obeys them is the next one to look at. Once a state
    is free, the search goes on from just beyond the boundary of the free states. If this finds no
    free state, the common area itself is minimised, from the user's state and from others, and
    the search is repeated from there.

    If nothing is free, the result is the nearest state whose common area is within 1 % of the
    least that was found.

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
    terms = [terms] if isinstance(terms, Term) else terms
    if not isinstance(terms, Sequence):
        raise SolveError(f"terms must be a term or a sequence of terms; received {terms!r:.200}.")
    until = math.inf if seconds is None else time.perf_counter() + seconds
    keep = NoOverlap(obstacles, between_glyphs, gap, method=method)
    search = _Search(text, keep, terms, locks, ties, until)
    if search.excess(search.start) <= TOUCH:
        return search.resolution(search.start)
    best = search.near(search.start)
    if best is None:
        places = chain([search.start], search.other_places(restarts))
        # To find another place may take minutes.
        while not search.late and (x := next(places, None)) is not None:
            best = search.nearer(best, search.near(search.pushed(x)))
    return search.resolution(search.least() if best is None else best)


class _Search:
    """The free states of one text, and which of them is nearest to the user's state."""

    def __init__(
        self,
        text: Text,
        keep: NoOverlap,
        terms: Sequence[Term],
        locks: Collection[str],
        ties: Ties,
        until: float,
    ) -> None:
        self.text, self.until = text, until
        self.push = energy_of(text, [keep, StayClose(PUSHED), *terms], locks=locks, ties=ties)
        wish = energy_of(text, [StayClose(NEAREST), *terms], locks=locks, ties=ties)
        # The first term of the descent keeps its overlaps, so nothing is computed twice.
        self.room = Room(wish, cast(NoOverlap, self.push.terms[0]))
        # A text may stand beyond the ends of its axes.
        self.start = between(self.push.unknowns.start, self.push.lower, self.push.upper)
        self.ends: list[Look] = []
        self.steps = 0

    @property
    def late(self) -> bool:
        """Whether the time of the search is over."""
        return time.perf_counter() > self.until

    def distance(self, x: Array) -> float:
        """How far x is from the user's state, in normalized coordinates."""
        away = x - self.start
        return math.sqrt(away.dot(away))

    def excess(self, x: Array) -> float:
        """The common area at x, in square font units, with the squares of gaps not kept."""
        return self.room.look(x).excess

    def near(self, x: Array) -> Array | None:
        """The nearest free state that is found from x, along inequalities; or None."""
        best, model, walls, left, least = None, None, list[Walls](), TRIES, math.inf
        while left > 0:
            look = self.room.look(x)
            if look.excess > least / 2:
                left -= 1
            least = min(least, look.excess)
            if look.excess <= TOUCH:
                left, best = min(left, TIGHTENED), self.nearer(best, x)
                if model is not None and self.ends_at(best, model):
                    return best
                best, look = self.back(x, TOUCH)
                walls, least = [], look.excess
            model = self.room.model(look, walls)
            walls.append(model.own)
            x = model.minimum()
            self.steps += 1
            if self.no_nearer(x, best):
                return best
            if abs(x - look.x).max() <= STILL or self.late:
                break
        self.ends.append(look)
        return best

    def ends_at(self, best: Array | None, model: Model) -> bool:
        """Whether no state much nearer than the best one is free, by a model from close by."""
        if best is None or model.own.margins.max(initial=0.0) >= CLOSE:
            return False
        return self.no_nearer(model.bound(best), best)

    def no_nearer(self, x: Array, best: Array | None) -> bool:
        """Whether x is about as far from the user's state as the best one, or farther."""
        return best is not None and self.distance(x) > ENOUGH * self.distance(best)

    def pushed(self, x: Array) -> Array:
        """Where a descent of the common area from x ends."""
        found = descend(self.push, x, TOLERANCES, MOST_STEPS, deadline=self.until)
        self.steps += found.iterations
        self.ends.append(self.room.look(found.state.x))
        return found.state.x

    def nearer(self, one: Array | None, other: Array | None) -> Array | None:
        """The one of two states that is nearer to the user's; None stands for no state."""
        if one is None or other is None:
            return one if other is None else other
        return min(one, other, key=self.distance)

    def other_places(self, count: int) -> Iterator[Array]:
        """Places to start from, the same ones at every call."""
        chance, bounds = np.random.default_rng(0), np.stack([self.push.lower, self.push.upper])
        # Some blocks of unknowns have no bounds.
        lower, upper = bounds = np.where(np.isfinite(bounds), bounds, self.start)
        if count:
            yield self.each_best(bounds)
        for _ in range(count - 1):
            yield chance.uniform(lower, upper)

    def each_best(self, ends: Array) -> Array:
        """The place at which each unknown has the value, of its start and its bounds, that is best.

        For each of them the common area is compared while the others stay. This is repeated from
        the place that was found, because some unknowns matter only once others have changed.
        """
        x, count = self.start, len(self.start)
        for _ in range(CHOICES):
            states = [np.where(np.arange(count) == i, end, x) for end in ends for i in range(count)]
            area, *others = self.room.areas(x, *states)
            least = np.reshape(others, (2, count))
            best = ends[least.argmin(0), np.arange(count)]
            x = np.where(least.min(0) < area - TOUCH, best, x)
        return x

    def back(self, x: Array, limit: float) -> tuple[Array, Look]:
        """The last state on the way from x to the user's state before the excess passes a limit.

        The second value is a look at a state just beyond.
        """
        low, high = 0.0, BACK
        beyond = self.look_between(x, high)
        while high < 1 and beyond.excess <= limit and not self.late:
            low, high = high, min(2 * high, 1.0)
            beyond = self.look_between(x, high)
        while high - low > BACK and not self.late:
            middle = self.look_between(x, (low + high) / 2)
            if middle.excess <= limit:
                low = (low + high) / 2
            else:
                high, beyond = (low + high) / 2, middle
        return x + low * (self.start - x), beyond

    def look_between(self, x: Array, part: float) -> Look:
        """What overlaps at a part of the way from x to the user's state."""
        return self.room.look(x + part * (self.start - x))

    def least(self) -> Array:
        """If nothing is free: the nearest state of those with about the least excess."""
        ends = [self.room.look(self.start), *self.ends]
        limit = (1 + SLACK) * min(look.excess for look in ends)
        x = min((look.x for look in ends if look.excess <= limit), key=self.distance)
        return self.back(x, limit)[0] if self.distance(x) > 0 else x

    def left(self, look: Look) -> str:
        """In words: what is left of the overlaps."""
        if look.area > FREE_AREA:
            return f"{look.area:.3g} square font units overlap"
        return f"nothing overlaps, but the gap of {self.room.keep.gap:g} font units is not kept"

    def resolution(self, x: Array) -> Resolution:
        """The state x as a result."""
        look = self.room.look(x)
        # Planes may be met while a sliver is left between their points.
        free = look.excess <= FREE_AREA and look.area <= FREE_AREA
        ended = descend(self.push, x, TOLERANCES, 0)
        ended.state.outcome = SEARCHED
        found = solution_of(self.push, ended._replace(earlier=self.steps))
        values = dict(vars(found))
        blocked = () if free else tuple(ends_reached(self.text, found.active))
        missed = [one.missed for one in found.terms[1:] if not one.met]
        if not free:
            late = self.late
            why = "the time limit was reached" if late else "no free state was found"
            parts = [f"{self.left(look)}, and {why}", *missed, *blocked]
            values |= {
                "status": TIME_LIMIT if late else UNREACHABLE,
                "message": "; ".join(parts),
            }
        elif missed:
            parts = ["nothing overlaps", *missed, *ends_reached(self.text, found.active)]
            values |= {"message": "; ".join(parts)}
        return Resolution(**values, area=look.area, free=free, blocked_by=blocked)
