r"""Drag letters without passing through each other or through obstacles (Sec. 5.2).

A text moves from a free state towards the place at which its terms are met. Where it meets
something, it slides on: the common area just beyond the contact is linearised, which gives one
inequality for each pair that touches, and the terms are minimised under these inequalities. So the
dragged letter slides along obstacles, and its neighbours give way. A step is accepted only if the
way to it is free, by :mod:`.swept`.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from ..arrays import Array, BoolArray
from ..energy import Solution, StayClose, Term
from ..energy.descent import Descent, descend
from ..energy.energy import Energy
from ..energy.solve import solution_of
from ..energy.tied import Ties, energy_of
from ..outline.monotone import evaluate
from ..solver.problem import Tolerances
from ..text import Text
from .collisions import Collisions
from .no_overlap import NoOverlap
from .overlaps import TOUCH
from .walls import Room, Walls

ROUNDS = 3
"""Most times that the inequalities are found again."""
SUBSTEP = 40.0
"""Font units by which points move at most in a substep along a contact."""
ENOUGH = 0.1
"""A substep is cut short if at least this part of it is free: the next one goes on from there."""
SHARES = (1.0, 0.5, 0.1)
"""Of the free part of a step. The first one counts whose common area is within the limit."""
STILL = 0.1
"""Font units: a step on which points move less is not taken."""
LESS = 1e-2
"""A further substep is tried if one lowers the cost by this part of it."""
CALM = 0.02
"""Ems: a substep moves an axis over its range only if the distance to a goal falls by more."""
NOWHERE = np.zeros((0, 2))
TOLERANCES = Tolerances(step=1e-5, absolute_cost=1e-2, cost_floor=1e-4)
"""In normalized coordinates, and in square font units."""


@dataclass(frozen=True)
class Followed:
    """The result of :func:`follow`.

    Attributes
    ----------
    solution : Solution
        Of the terms, at the state that was accepted.
    contacts : (c, 2) array
        Where the text presses against something, in font units. By default nowhere.
    """

    solution: Solution
    contacts: Array = field(default_factory=lambda: NOWHERE)


def follow(
    text: Text,
    terms: Sequence[Term],
    keep: NoOverlap,
    *,
    locks: Collection[str] = (),
    ties: Ties = (),
    max_iterations: int = 30,
    substeps: int = 1,
) -> Followed:
    """Move a text towards the minimum of its terms, as far as the way is free.

    Parameters
    ----------
    text : Text
        The last state that was accepted. It is not changed.
    terms : sequence of Term
        Such as a target, pins and :class:`StayClose`.
    keep : NoOverlap
        What must not overlap.
    locks : collection of str
        Tags of axes that keep their values.
    ties : sequence of sequences of int
        As for :func:`~vfwidget.solve`.
    max_iterations : int
        Most steps of the solver while nothing is met. Default 30.
    substeps : int
        Most steps along what is met. Default 1, because the next event of the pointer goes on.

    Returns
    -------
    Followed
        The state has no more common area than ``text``, where the letters of a group are taken
        at the axes of its first one.
    """
    wish = energy_of(text, terms, locks=locks, ties=ties)
    direct = descend(wish, wish.unknowns.start, TOLERANCES, max_iterations)
    x, goal = wish.unknowns.start, direct.state.x
    way = _Way(text, terms, wish, keep, locks, ties)
    contacts, cost = [NOWHERE], way.cost(x)
    for _ in range(substeps):
        following, touched = way.slide(x, goal)
        contacts.append(touched)
        if following is goal:
            return Followed(solution_of(wish, direct), np.concatenate(contacts))
        less = way.cost(following)
        if less > (1 - LESS) * cost:
            break
        x, cost = following, less
    return Followed(solution_of(wish, way.ended(x, direct)), np.concatenate(contacts))


class _Way:
    """The energy of a drag, and what is free on the way."""

    def __init__(
        self,
        text: Text,
        terms: Sequence[Term],
        wish: Energy,
        keep: NoOverlap,
        locks: Collection[str],
        ties: Ties,
    ) -> None:
        self.text, self.terms, self.wish, self.keep = text, terms, wish, keep
        self.locks, self.ties = locks, ties
        self.room = Room(wish, keep.bind(text))

    @cached_property
    def limit(self) -> float:
        """The largest common area of an accepted state."""
        return max(float(self.room.areas(self.wish.unknowns.start)[0]), TOUCH)

    def allowed(self, *states: Array) -> BoolArray:
        """Whether the common area of states is within the limit."""
        areas = self.room.areas(*states)
        # Where the first state is free, the limit need not be known.
        return np.asarray(areas <= (TOUCH if areas[0] <= TOUCH else self.limit))

    def place(self, x: Array) -> dict[str, Array]:
        """All blocks of the text at a state."""
        return self.wish.unknowns.place(x)

    def slide(self, x: Array, goal: Array) -> tuple[Array, Array]:
        """Move from x to a goal, or up to what is in the way and one substep along it.

        The second value are the contacts (c, 2).
        """
        room, contact = self.room, self.room.contact(x, goal)
        if contact.free == 1 and self.allowed(goal)[0]:
            return goal, NOWHERE
        beyond = x + contact.beyond * (goal - x)
        if contact.free * self.longest(x, goal) > SUBSTEP:
            x = self.accepted(x, goal, contact.free)
        room = room.under(self.energy_near(x))
        walls, contacts = list[Walls](), []
        for _ in range(ROUNDS):
            look = room.look(beyond)
            contacts.append(middles(look.found))
            goal, found = room.step(look, walls)
            walls.append(found)
            goal = self.nearby(x, goal)
            contact = room.contact(x, goal)
            if contact.free >= ENOUGH:
                break
            beyond = x + contact.beyond * (goal - x)
        return self.accepted(x, goal, contact.free), np.concatenate(contacts)

    def energy_near(self, x: Array) -> Energy:
        """The terms, and a calm that keeps axes where they are unless a goal comes closer."""
        here = self.text.moved_to(self.place(x))
        calm = StayClose((CALM * self.text.font.units_per_em) ** 2, here.theta)
        return energy_of(self.text, [*self.terms, calm], locks=self.locks, ties=self.ties)

    def accepted(self, x: Array, goal: Array, part: float) -> Array:
        """A state on the free part of the way whose common area is within the limit, or x."""
        if part * self.longest(x, goal) < STILL:
            return x
        states = [x + part * share * (goal - x) for share in SHARES]
        within = np.flatnonzero(self.allowed(*states))
        return states[within[0]] if len(within) else x

    def nearby(self, x: Array, goal: Array) -> Array:
        """The goal, or a state on the way to it if points would move farther than a substep."""
        longest = self.longest(x, goal)
        return goal if longest <= SUBSTEP else x + SUBSTEP / longest * (goal - x)

    def longest(self, x: Array, goal: Array) -> float:
        """The longest way of a control point between two states, in font units."""
        points = [self.room.positions(state) for state in (x, goal)]
        return float(np.hypot(*(points[1] - points[0]).T).max(initial=0.0))

    def cost(self, x: Array) -> float:
        """The cost of the terms."""
        return sum(result.cost for result in self.wish.results(x))

    def ended(self, x: Array, former: Descent) -> Descent:
        """A state as the end of a descent."""
        results = self.wish.results(x)
        state = replace(former.state, x=x, cost=sum(result.cost for result in results))
        return replace(former, state=state, results=results)


def middles(found: Collisions) -> Array:
    """The middle of each common area, (c, 2)."""
    common, spans = found.common, found.common.spans
    bound = np.flatnonzero(spans.weight)
    cubic, pair = spans.cubic[bound], common.pair[spans.cubic[bound]]
    middle = evaluate(common.curves[..., cubic], (spans.start + spans.end)[bound] / 2)
    count = np.bincount(pair, minlength=len(common.area))
    touched = np.flatnonzero(count)
    sums = np.array([np.bincount(pair, side, len(count)) for side in middle])
    return (sums[:, touched] / count[touched]).T + common.origin[touched]
