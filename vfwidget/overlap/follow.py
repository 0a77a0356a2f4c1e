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
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..energy import Solution, Term
from ..energy.descent import Descent, descend
from ..energy.energy import Energy
from ..energy.solve import solution_of
from ..energy.tied import Ties, energy_of
from ..outline.monotone import evaluate
from ..solver.problem import Tolerances
from ..text import Text
from .collisions import Collisions
from .inequalities import Model, Walls
from .no_overlap import NoOverlap
from .overlaps import TOUCH
from .walls import Look, Room

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


class Held(NamedTuple):
    """What a text presses against. It is kept, so that the next event need not find it again.

    Attributes
    ----------
    look : Look
        Just beyond the contact.
    walls : Walls
        The inequalities there.
    valid : tuple
        What must be the same at the next event: the composition, the obstacles and the ties.
    """

    look: Look
    walls: Walls
    valid: tuple[Any, ...]


@dataclass(frozen=True)
class Followed:
    """The result of :func:`follow`.

    Attributes
    ----------
    solution : Solution
        Of the terms, at the state that was accepted.
    contacts : (c, 2) array
        Where the text presses against something, in font units. By default nowhere.
    held : Held, optional
        What it presses against, for the next call.
    """

    solution: Solution
    contacts: Array = field(default_factory=lambda: NOWHERE)
    held: Held | None = field(default=None, repr=False)


def follow(
    text: Text,
    terms: Sequence[Term],
    keep: NoOverlap,
    *,
    locks: Collection[str] = (),
    ties: Ties = (),
    max_iterations: int = 30,
    substeps: int = 1,
    held: Held | None = None,
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
    held : Held, optional
        That of the last result, which makes this call quicker while the text stays in contact.

    Returns
    -------
    Followed
        The state has no more common area than ``text``, where the letters of a group are taken
        at the axes of its first one.
    """
    wish = energy_of(text, terms, locks=locks, ties=ties)
    direct = descend(wish, wish.unknowns.start, TOLERANCES, max_iterations)
    x, goal = wish.unknowns.start, direct.state.x
    way = _Way(text, wish, keep, ties)
    contacts, cost = [NOWHERE], way.cost(x)
    for _ in range(substeps):
        following, held = way.slide(x, goal, held)
        if held is None:
            return Followed(solution_of(wish, direct), np.concatenate(contacts))
        contacts.append(middles(held.look.found))
        less = way.cost(following)
        if less > (1 - LESS) * cost:
            break
        x, cost = following, less
    solution = solution_of(wish, way.ended(x, direct))
    return Followed(solution, np.concatenate(contacts), held)


class _Way:
    """The energy of a drag, and what is free on the way."""

    def __init__(
        self,
        text: Text,
        wish: Energy,
        keep: NoOverlap,
        ties: Ties,
    ) -> None:
        self.text, self.wish = text, wish
        self.room = Room(wish, keep.bind(text))
        self.valid = (text.composition, self.room.keep.shapes, ties)

    @cached_property
    def limit(self) -> float:
        """The largest common area of an accepted state."""
        return max(float(self.room.areas(self.wish.unknowns.start)[0]), TOUCH)

    def allowed(self, x: Array) -> bool:
        """Whether the common area of a state is within the limit."""
        area = float(self.room.areas(x)[0])
        # Where the state is free, the limit need not be known.
        return area <= TOUCH or area <= self.limit

    def slide(self, x: Array, goal: Array, held: Held | None) -> tuple[Array, Held | None]:
        """Move from x to a goal, or up to what is in the way and one substep along it.

        The second value is what the text presses against; None if it reaches the goal.
        """
        walls = list[Walls]()
        if held is not None and self.holds(held, x, goal):
            room, look = self.calmed(x), held.look
            model = room.model(look, x=x)
        else:
            contact = self.room.contact(x, goal)
            if contact.free == 1 and self.allowed(goal):
                return goal, None
            beyond = x + contact.beyond * (goal - x)
            if contact.free * self.longest(x, goal) > SUBSTEP:
                x = self.accepted(x, goal, contact.free)
            room = self.calmed(x)
            look = room.look(beyond)
            model = room.model(look)
        for _ in range(ROUNDS):
            walls.append(model.own)
            end, part, beyond = self.along(x, model)
            if part >= ENOUGH:
                break
            look = room.look(beyond)
            model = room.model(look, walls)
        return self.accepted(x, end, part), Held(look, model.own, self.valid)

    def along(self, x: Array, model: Model) -> tuple[Array, float, Array]:
        """Where a substep leads, which part of it is free, and a state beyond that part."""
        end = model.minimum()
        longest = self.longest(x, end)
        if longest < STILL:
            return end, 1.0, end
        if longest > SUBSTEP:
            end = x + SUBSTEP / longest * (end - x)
        contact = self.room.contact(x, end)
        return end, contact.free, x + contact.beyond * (end - x)

    def holds(self, held: Held, x: Array, goal: Array) -> bool:
        """Whether the text still presses against the same, close to where it did."""
        return (
            held.valid == self.valid
            and bool(held.walls.beyond(goal).any())
            and self.longest(held.look.x, x) < SUBSTEP / 2
        )

    def calmed(self, x: Array) -> Room:
        """The room with a calm that keeps axes where they are unless a goal comes closer."""
        return self.room.calmed(x, (CALM * self.text.font.units_per_em) ** 2)

    def accepted(self, x: Array, goal: Array, part: float) -> Array:
        """A state on the free part of the way whose common area is within the limit, or x."""
        if part * self.longest(x, goal) < STILL:
            return x
        for share in SHARES:
            state = x + part * share * (goal - x)
            if self.allowed(state):
                return state
        return x

    def longest(self, x: Array, goal: Array) -> float:
        """The longest way of a control point between two states, in font units."""
        points = [self.room.positions(state) for state in (x, goal)]
        return float(np.hypot(*(points[1] - points[0]).T).max(initial=0.0))

    def cost(self, x: Array) -> float:
        """The cost of the terms."""
        return sum(result.cost for result in self.wish.results(x))

    def ended(self, x: Array, former: Descent) -> Descent:
        """A state as the end of a descent."""
        residual = self.wish.residual(x)
        results = self.wish.results(x, residual)
        cost = sum(result.cost for result in results)
        # The model of the former end has the slopes of another state.
        state = replace(former.state, x=x, residual=residual, cost=cost, model=None)
        return former._replace(state=state, results=results)


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
