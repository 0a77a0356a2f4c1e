"""One time step without contact: where the motion leads, and how it is solved for.

A step minimises inertia and springs over the text's place (implicit Euler, with exact parabolas for
letters in free flight).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ..arrays import Array, BoolArray
from ..energy import Term
from ..energy.descent import descend
from ..energy.energy import Energy
from ..overlap.gaps import Gaps
from ..text.place import AXES, Place
from .body import Body
from .flight import Flight
from .laws import Laws, State
from .scene import Scene
from .start import deepest
from .terms import Contact, Inertia, Springs
from .warm import TOLERANCES, approach, pressed

MOST_STEPS = 40
"""Of the solver, for each solve."""
MARGIN = 1.0
"""Font units beyond the motion of a step within which contacts are found."""


class FreeStep:
    """One step from a state, over at most h seconds.

    Parameters
    ----------
    body : Body
    scene : Scene
    laws : Laws
    state : State
    time, h : float
        Start and duration of the step in seconds.
    acceleration : (l, 2) array
    rest : (p, n) array
        Rest state of the axes.

    Attributes
    ----------
    free : Place
        The place without contact at the end of the step. It exists only if ``settled`` is true.
    settled : bool
        Whether ``free`` was solved for. If letters were in contact before the step, it is false at
        first, and ``end`` follows from inertia alone.
    end : (r,) array
        Reduced coordinates after the step, without contact.
    now, ends : (S, 4, 2) arrays
        All segments before the step, and after it without contact.
    depth : float
        How deep shapes may be inside each other before the step: that of the state, or that of
        obstacles that have appeared.
    reach : float
        Font units within which shapes may meet.
    """

    def __init__(
        self,
        body: Body,
        scene: Scene,
        laws: Laws,
        state: State,
        time: float,
        h: float,
        acceleration: Array,
        rest: Array,
    ) -> None:
        self.body, self.scene, self.laws = body, scene, laws
        self.state, self.time = state, time
        self.text = body.text.moved_to(state.place)
        self.acceleration, self.rest = acceleration, rest
        self.touching = state.touching
        self.flight = Flight(self.body, state.place, state.velocity)
        self.reduced = self.flight.reduced
        self.set_duration(h, not self.touching.any())

    def set_duration(self, h: float, settled: bool = True) -> None:
        """Let the step last h seconds: the place to which it leads without contact."""
        self.h, self.settled = h, settled
        terms = self.motion()
        passage = self.scene.over(self.time, self.time + h)
        self.outlines, self.obstacles, self.later, appeared = passage
        self.now = self.segments(self.state.place, self.obstacles)
        self.depth = self.state.depth
        if appeared:
            shapes = self.scene.shapes(self.time + h)
            self.depth = max(self.depth, deepest(self.text, shapes))
        if settled:
            self.free = self.solve(terms, None, self.flight.carried(self.goal, h))
        self.end = self.body.reduced_at(self.free) if settled else self.goal
        self.ends = np.concatenate([self.body.points(self.end)[self.body.controls], self.later])
        self.moved = self.ends - self.now
        # Shapes that move together have no motion relative to each other.
        count, owner = len(self.scene.stroke), self.outlines.owner
        size = np.maximum(np.bincount(owner, minlength=count), 1)
        mean = np.stack(
            [np.bincount(owner, self.moved[..., i].mean(1), count) / size for i in range(2)], 1
        )
        spread = np.zeros(count)
        np.maximum.at(spread, owner, np.linalg.norm(self.moved - mean[owner, None], axis=2).max(1))
        between = np.linalg.norm(mean[:, None] - mean, axis=2)
        self.ways = between + spread[:, None] + spread
        letters = len(self.body.rows)
        self.reach = float(self.ways[:letters].max()) + MARGIN + self.depth

    def motion(self) -> list[Term]:
        """Inertia and springs over the step."""
        h, laws, state = self.h, self.laws, self.state
        # A letter in contact takes the force at the end of the step (implicit Euler). A letter in
        # free flight takes its mean, which gives an exact parabola.
        self.share = np.where(self.touching, 1.0, 0.5)[:, None] * self.acceleration
        self.goal = self.flight.ahead(h) + h * h * self.body.force(self.share)
        weights = h * h * laws.stiffness + h * laws.damping
        pull = h * h * laws.stiffness * self.rest + h * laws.damping * state.place[AXES]
        reference = np.divide(pull, weights, out=self.rest.copy(), where=weights > 0)
        terms: list[Term] = [Inertia(self.body, self.goal)]
        if weights.any():
            terms.append(Springs(weights, reference))
        return terms

    def solve(
        self,
        terms: Sequence[Term],
        contact: Contact | None = None,
        start: Mapping[str, Array] | None = None,
        free: tuple[str, ...] = (),
    ) -> Place:
        """The place at which the terms are least, from the place of the state or from ``start``.

        The solver takes over if the search does not settle.
        """
        energy = Energy(self.text, terms, free=free or self.body.free)
        begin = energy.unknowns.start if start is None else energy.unknowns.flat(start)
        x, found = approach(energy, contact, begin)
        if not found:
            if contact is not None:
                energy = energy.at(self.text, [*terms, contact])
            x = descend(energy, x, TOLERANCES, MOST_STEPS, scale_by_columns=True).state.x
        return Place(energy.unknowns.place(x))

    def pressed(self, terms: Sequence[Term], contact: Contact, start: Mapping[str, Array]) -> Array:
        """How strongly each contact presses after the first step of a search, (C,)."""
        energy = Energy(self.text, terms, free=self.body.free)
        return pressed(energy, contact, energy.unknowns.flat(start))

    def gaps(self, segments: Array, reach: float) -> Gaps:
        """The gaps between all shapes that are smaller than ``reach``, in font units."""
        return self.scene.gaps(self.outlines, segments, reach)

    def segments(self, place: Mapping[str, Array], obstacles: Array) -> Array:
        """The segments of the letters at a place, then those of the obstacles, (S, 4, 2)."""
        return np.concatenate([self.body.positions(place)[self.body.controls], obstacles])

    def relative(self, gaps: Gaps, segments: Array) -> Array:
        """The first points of some gaps as seen from the second ones, at given segments."""
        first, second = gaps.ends(segments)
        return first - second

    def after(self, place: Place, touching: BoolArray | None = None) -> State:
        """The state at a place that the step has led to."""
        velocity = self.flight.velocity_at(place, self.goal, self.h)
        velocity += self.h * self.body.force(self.acceleration - self.share)
        if touching is None:
            touching = np.zeros(len(self.body.rows), dtype=bool)
        return State(place, velocity, touching)

    def potential(self, place: Mapping[str, Array]) -> float:
        """Energy of the springs and of the forces."""
        stretch = self.laws.stiffness * (place[AXES] - self.rest) ** 2
        reduced = self.body.reduced_at(place)
        return 0.5 * float(stretch.sum()) - float(self.body.force(self.acceleration) @ reduced)

    def letters_of(self, gaps: Gaps) -> BoolArray:
        """The letters that take part in some gaps, (l,)."""
        touching = np.zeros(len(self.scene.stroke) + 1, dtype=bool)
        touching[gaps.shape.ravel()] = True
        return touching[: len(self.body.rows)]
