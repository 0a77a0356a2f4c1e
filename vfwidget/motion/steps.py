"""Time steps: free motion, contact and impact.

A step minimises inertia, springs and contact over the text's place (implicit Euler, with exact
parabolas for letters in free flight). It is cut so that no outline moves farther than a part of the
thinnest stroke beyond the gap to the next outline. A step that ends in a fast contact ends at the
moment of impact instead, where the velocity is reflected by Moreau's law: with P the nearest
velocity, in the metric of the masses, that brings no contact closer,

    v⁺ = P(v) + e (P(v) − v) = v + (1 + e) (P(v) − v).

P is a projection onto a cone, so an impact never increases the kinetic energy.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..arrays import Array, BoolArray
from ..energy import Term
from ..energy.descent import descend
from ..energy.energy import Energy
from ..overlap.gaps import Gaps
from ..solver.problem import Tolerances
from ..text.place import AXES, OFFSETS, ROTATIONS, Place
from .body import Body
from .flight import Flight
from .laws import Laws, State
from .scene import Scene
from .terms import (
    SLIP,
    STIFFNESS,
    Contact,
    Friction,
    Inertia,
    Rolling,
    Sliding,
    Springs,
    Touches,
)
from .warm import start_of

TOLERANCES = Tolerances(step=1e-10, absolute_cost=1e-8, relative_cost=1e-13)
MOST_STEPS = 40
"""Of the solver, for each solve."""
CLOSE = 0.05
"""Font units: a smaller gap is a contact."""
PART = 0.4
"""Part of the thinnest stroke that a step may move an outline beyond a gap."""
MOST_CUTS = 64
"""A step is cut into at most so many."""
GROWTH = 1.2
"""A step is at most so many times as long as the one before could have been."""
FAST = 3.0
"""A contact that approaches faster than this times acceleration times frame time is an impact."""
IMPACT = 1.0
"""Font units of the fastest point in the solve that finds the velocities after an impact."""
MOST_ROUNDS, DEEPEST = 8, 0.02
"""Contacts are found again until none is deeper than the second number, in font units."""
NEARBY, DEEP = 6.0, 100.0
"""They are found within the motion of the step, but within these numbers at least and at most."""
LEFT = 0.25
"""Font units: if a deeper contact is left, the step is tried again with half of its time."""
BLOCKED = 4.0
"""Font units: a deeper contact that is left at the end of a step cannot be resolved."""
UNCLEAR = 1.0
"""Font units: contacts that are deeper are found where the contacts before the step lead."""
ROLLING = 0.08, 0.5
"""Rolling resistance is so large a part of the friction, at an arm of so many ems."""
MARGIN = 1.0
"""Font units beyond the motion of a step within which contacts are found."""


class BlockedError(Exception):
    """A contact of this depth, in font units, from which no letter can get out."""


class Stepper:
    """Moves a body in time.

    Parameters
    ----------
    body : Body
    scene : Scene
    laws : Laws
    """

    def __init__(self, body: Body, scene: Scene, laws: Laws) -> None:
        self.body, self.scene, self.laws = body, scene, laws

    def frame(self, state: State, time: float, acceleration: Array, rest: Array) -> State:
        """The state one frame later.

        Parameters
        ----------
        state : State
        time : float
            In seconds.
        acceleration : (l, 2) array
        rest : (p, n) array
            Rest state of the axes.
        """
        whole = self.laws.frame
        left = most_h = whole / (self.laws.substeps or 1)
        impacts = 0
        most = 2 * len(self.body.rows)
        for part in range(self.laws.substeps or 1):
            now = time + part * left
            end = now + left
            while end - now > 1e-9 * whole:
                bounce = self.laws.restitution > 0 and impacts < most
                step = _Step(self, state, now, min(end - now, most_h), acceleration, rest)
                state, used = step.taken(bounce)
                impacts += used == 0
                now += used
                most_h = min(left, max(GROWTH * step.longest, whole / MOST_CUTS))
        return state


class _Step:
    """One step from a state, over at most h seconds."""

    def __init__(
        self,
        stepper: Stepper,
        state: State,
        time: float,
        h: float,
        acceleration: Array,
        rest: Array,
    ) -> None:
        self.body, self.scene, self.laws = stepper.body, stepper.scene, stepper.laws
        self.state, self.time = state, time
        self.acceleration, self.rest = acceleration, rest
        self.touching = state.touching
        self.flight = Flight(self.body, state.place, state.velocity)
        self.reduced = self.flight.reduced
        self.outlines, self.obstacles = self.scene.at(time)
        self.longest = np.inf
        self.now = self._segments(state.place, self.obstacles)
        self._last(h)

    def _last(self, h: float) -> None:
        """Let the step last h seconds: the place to which it leads without contact."""
        self.h = h
        self.free = self._solve(self._motion())
        outlines, self.later = self.scene.at(self.time + h)
        self.matches = outlines is self.outlines
        self.outlines = outlines
        later = self._segments(self.free, self.later)
        self.moved = np.zeros_like(later)
        self.moved[: len(self.body.controls)] = (later - self.now)[: len(self.body.controls)]
        if self.matches:
            self.moved = later - self.now
        # Shapes that move together have no motion relative to each other.
        count, owner = len(self.scene.stroke), outlines.owner
        size = np.maximum(np.bincount(owner, minlength=count), 1)
        mean = np.stack(
            [np.bincount(owner, self.moved[..., i].mean(1), count) / size for i in range(2)], 1
        )
        spread = np.zeros(count)
        np.maximum.at(spread, owner, np.linalg.norm(self.moved - mean[owner, None], axis=2).max(1))
        between = np.linalg.norm(mean[:, None] - mean, axis=2)
        self.ways = between + spread[:, None] + spread
        letters = len(self.body.rows)
        self.reach = float(self.ways[:letters].max()) + MARGIN

    def _motion(self) -> list[Term]:
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

    def _solve(
        self,
        terms: Sequence[Term],
        contact: Contact | None = None,
        start: Mapping[str, Array] | None = None,
        free: tuple[str, ...] = (),
    ) -> Place:
        """The place at which the terms are least, from the place of the state or from ``start``.

        A search for contact starts where the motion leads without it. There the contacts that
        matter are active, while at the place of the state they have no slope yet.
        """
        text = self.body.text.moved_to(self.state.place)
        energy = Energy(text, terms, free=free or self.body.free)
        begin = energy.unknowns.start if start is None else energy.unknowns.flat(start)
        if contact is not None:
            begin = start_of(energy, contact, begin)
            energy = energy.at(text, [*terms, contact])
        found = descend(energy, begin, TOLERANCES, MOST_STEPS, scale_by_columns=True)
        return Place(energy.unknowns.place(found.state.x))

    def _gaps(self, segments: Array, reach: float) -> Gaps:
        return self.scene.gaps(self.outlines, segments, reach)

    def _segments(self, place: Mapping[str, Array], obstacles: Array) -> Array:
        return np.concatenate([self.body.positions(place)[self.body.controls], obstacles])

    def taken(self, bounce: bool) -> tuple[State, float]:
        """The state after the step, and its duration; 0 for an impact."""
        near = self._gaps(self.now, self.reach)
        if not len(near.gap):
            return self._moved(self.free), self.h
        part = self._part(near)
        self.longest = part * self.h
        if part < 1 and self.laws.substeps is None:
            self._last(max(0.9 * part * self.h, self.laws.frame / MOST_CUTS))
        ahead = self._gaps(self._segments(self.free, self.later), self.reach)
        inside = ahead.some(ahead.gap < 0)
        if not len(inside.gap):
            return self._moved(self.free), self.h
        before = self._relative(inside, self.now)
        start = (before * inside.normal).sum(1)
        speed = (start - inside.gap) / self.h
        size = float(np.hypot(*self.acceleration.T).max(initial=0.0))
        fast = np.minimum(speed, self._approach(inside)) > max(FAST * size * self.laws.frame, 1e-6)
        if bounce and fast.any():
            way = start[fast] / (start[fast] - inside.gap[fast])
            part = float(np.clip(way, 0.0, 1.0).min())
            if part * self.h * float(speed[fast].max()) > CLOSE:
                self._last(part * self.h)
                return self._moved(self.free), self.h
            return self._reflected(), 0.0
        self.touching = self.touching | self._letters_of(inside)
        while True:
            state, depth = self._in_contact()
            shortest = self.h <= self.laws.frame / MOST_CUTS
            if depth < LEFT or shortest:
                break
            # Contacts that come and go from round to round are fewer in a shorter step.
            self._last(max(self.h / 2, self.laws.frame / MOST_CUTS))
        if depth > BLOCKED:
            raise BlockedError(depth)
        return state, self.h

    def _part(self, near: Gaps) -> float:
        """The part of the step after which outlines have moved as far as they may."""
        way = self.ways[near.shape[:, 0], near.shape[:, 1]]
        room = np.maximum(near.gap, 0.0) + PART * self.scene.stroke[near.shape].min(1)
        return float((room / np.maximum(way, 1e-12)).min())

    def _relative(self, gaps: Gaps, segments: Array) -> Array:
        """The first points of some gaps as seen from the second ones, at given segments."""
        first, second = gaps.ends(segments)
        return first - second

    def _approach(self, gaps: Gaps) -> Array:
        """The speed at which some gaps close before the forces of this step act, (C,)."""
        velocities = np.zeros_like(self.now)
        own = self.body.velocities(self.state.velocity)[self.body.controls]
        velocities[: len(own)] = own
        if self.matches:
            velocities[len(own) :] = (self.later - self.obstacles) / self.h
        return -(self._relative(gaps, velocities) * gaps.normal).sum(1)

    def _moved(self, place: Place, touching: BoolArray | None = None) -> State:
        """The state at a place that the step has led to."""
        velocity = self.flight.velocity_at(place, self.goal, self.h)
        velocity += self.h * self.body.force(self.acceleration - self.share)
        if touching is None:
            touching = np.zeros(len(self.body.rows), dtype=bool)
        return State(place, velocity, touching)

    def _in_contact(self) -> tuple[State, float]:
        """The state after a step with contact, without bounce, and its deepest contact."""
        terms, place, touches = self._motion(), self.free, self._touches(self.free, self.reach)
        if touches.gaps.gap.min() < -UNCLEAR and self.matches:
            # Deep inside, the nearest way out may lead to the wrong side. Before the step the
            # sides were clear.
            before = Touches(self.body, self._gaps(self.now, self.reach), self.later)
            place = self._solve(terms, Contact(before), place)
            touches = self._touches(place, self.reach)
        place, touches, depth = self._apart(terms, touches, place)
        force = Contact(touches).force_at(place)
        if self.laws.friction and force.any():
            frictions = self._frictions(touches, force)
            if max(abs(one.moved(place)).max() for one in frictions) > SLIP / 10:
                place, touches, depth = self._apart([*terms, *frictions], touches, place)
                force = Contact(touches).force_at(place)
        state = self._moved(place, self._letters_of(touches.gaps.some(force > 0)))
        return state if self.scene.moving else self._without_gain(state), depth

    def _frictions(self, touches: Touches, force: Array) -> list[Friction]:
        """The friction of contacts that press with a force (C,)."""
        pressed = np.flatnonzero(force > 0)
        rubbing = Touches(self.body, touches.gaps.some(pressed), self.later)
        limit = self.laws.friction * force[pressed]
        found: list[Friction] = [Sliding(limit, rubbing, self._relative(rubbing.gaps, self.now))]
        if self.body.rotates:
            loads = np.zeros(len(self.scene.stroke))
            np.add.at(loads, rubbing.gaps.shape, limit[:, None])
            angles, (part, arm) = self.state.place[ROTATIONS], ROLLING
            arm *= self.body.text.font.units_per_em
            found.append(Rolling(part * loads[: len(angles)], arm, angles))
        return found

    def _apart(
        self, terms: Sequence[Term], touches: Touches, place: Place
    ) -> tuple[Place, Touches, float]:
        """The least place whose contacts are found there, the contacts, and how deep one is."""
        for _ in range(MOST_ROUNDS):
            place = self._solve(terms, Contact(touches), place)
            found = self._touches(place, min(max(self.reach, NEARBY), DEEP))
            depth = -float(found.gaps.gap.min(initial=0.0))
            if depth < DEEPEST:
                break
            touches = found
        return place, touches, depth

    def _touches(self, place: Mapping[str, Array], reach: float) -> Touches:
        """The contacts at a place at the end of the step."""
        gaps = self._gaps(self._segments(place, self.later), reach)
        return Touches(self.body, gaps, self.later)

    def _without_gain(self, state: State) -> State:
        """The state with no more energy than before the step; contact takes energy only."""
        before, after = (self._potential(s.place) for s in (self.state, state))
        kinetic = 0.5 * float(self.state.velocity @ self.state.velocity)
        most, has = before + kinetic - after, 0.5 * float(state.velocity @ state.velocity)
        if has <= most:
            return state
        return replace(state, velocity=state.velocity * np.sqrt(max(most, 0.0) / has))

    def _potential(self, place: Mapping[str, Array]) -> float:
        """Energy of the springs and of the forces."""
        stretch = self.laws.stiffness * (place[AXES] - self.rest) ** 2
        reduced = self.body.reduced_at(place)
        return 0.5 * float(stretch.sum()) - float(self.body.force(self.acceleration) @ reduced)

    def _letters_of(self, gaps: Gaps) -> BoolArray:
        touching = np.zeros(len(self.scene.stroke) + 1, dtype=bool)
        touching[gaps.shape.ravel()] = True
        return touching[: len(self.body.rows)]

    def _reflected(self) -> State:
        """The state after an impact: the same place, with other velocities."""
        gaps = self._gaps(self.now, 2 * CLOSE)
        fastest = float(np.linalg.norm(self.moved, axis=2).max())
        moment = IMPACT * self.h / max(fastest, 1e-9)
        obstacles = self.obstacles
        if self.matches:
            obstacles = obstacles + moment / self.h * (self.later - self.obstacles)
        least = (self._relative(gaps, self.now) * gaps.normal).sum(1)
        touches = Touches(self.body, gaps, obstacles)
        contact = Contact(touches, 100 * STIFFNESS, least)

        def stopped(velocity: Array, free: tuple[str, ...]) -> Array:
            """The nearest velocity that brings no contact closer."""
            onwards = Inertia(self.body, self.reduced + moment * velocity)
            place = self._solve([onwards], free=free)
            place = self._solve([onwards], contact, place, free)
            return (self.body.reduced_at(place) - self.reduced) / moment

        body, e, velocity = self.body, self.laws.restitution, self.state.velocity
        soft = stopped(velocity, body.free)
        if OFFSETS not in body.free:
            after = soft + e * (soft - velocity)
        else:
            whole = self.flight.rigid
            after = (1 + e) * stopped(whole, (OFFSETS,)) - e * whole
            lost = float(velocity @ velocity - after @ after)
            inner = soft - Flight(body, self.state.place, soft).rigid
            size = float(inner @ inner)
            after = after + inner * np.sqrt(min(1.0, max(lost, 0.0) / max(size, 1e-12)))
        hit = self._together(gaps)
        after = np.where(hit[body.letter], after, velocity)
        if not self.scene.moving:
            # Rounding and the curvature of the path must not add energy.
            before, then = float(velocity @ velocity), float(after @ after)
            after = after * min(1.0, np.sqrt(before / then)) if then > 0 else after
        return replace(self.state, velocity=after, touching=self.state.touching & ~hit)

    def _together(self, gaps: Gaps) -> BoolArray:
        """The letters that take part in an impact, (l,)."""
        hit = self._letters_of(gaps)
        if len(self.body.free) == 1 or self.body.text.shared:
            return np.full(len(hit), hit.any())
        return hit
