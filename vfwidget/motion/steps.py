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

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..arrays import Array, BoolArray
from ..energy import Term
from ..overlap.gaps import Gaps
from ..text.place import OFFSETS, ROTATIONS, Place
from .body import Body
from .flight import Flight
from .free_step import MARGIN, FreeStep
from .laws import Laws, State
from .scene import NEARBY, Scene
from .start import separated
from .terms import (
    SLIP,
    STIFFNESS,
    Contact,
    Friction,
    Inertia,
    Rolling,
    Sliding,
    Touches,
)

CLOSE = 0.05
"""Font units: a smaller gap is a contact."""
PART = 0.4
"""Part of the thinnest stroke that a step may move an outline beyond a gap."""
MOST_CUTS = 64
"""A step is cut into at most so many, where outlines only pass along each other."""
FINEST = 2**16
"""A step is cut into at most so many, where outlines approach each other. These cuts are few: the
step before leads almost to the contact."""
GROWTH = 1.2
"""A step is at most so many times as long as the one before could have been."""
FAST = 3.0
"""A contact that approaches faster than this times acceleration times frame time is an impact."""
JAMMED = 10.0
"""An impact that would change the velocity of letters of constant shape by more than this times the
speed of approach jams them between obstacles that close in on them. They do not bounce."""
IMPACT = 1.0
"""Font units of the fastest point in the solve that finds the velocities after an impact."""
MOST_ROUNDS, DEEPEST = 8, 0.02
"""Contacts are found again until none is deeper than the second number, in font units."""
DEEP = 100.0
"""Font units: they are found within the motion of the step, but at most within this distance."""
LEFT = 0.25
"""Font units: if a deeper contact is left, the step is tried again with half of its time."""
SAME = 1e-6
"""Font units. A contact counts as deeper than before the step only if its depth has grown by more
than this."""
BLOCKED = 4.0
"""Font units: a deeper contact that is left at the end of the shortest step cannot be resolved. The
next step may resolve one that is less deep; a frame that shows it causes a warning."""
UNCLEAR = 1.0
"""Font units: contacts that are deeper are found where the contacts before the step lead."""
ROLLING = 0.08, 0.5
"""Rolling resistance is so large a part of the friction, at an arm of so many ems."""


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

    def moved(
        self, state: State, time: float, until: float, acceleration: Array, rest: Array
    ) -> State:
        """The state at a later time, at most one frame later.

        Parameters
        ----------
        state : State
        time, until : float
            In seconds.
        acceleration : (l, 2) array
        rest : (p, n) array
            Rest state of the axes.
        """
        whole = self.laws.frame
        parts = max(math.ceil((until - time) / whole * (self.laws.substeps or 1) - 1e-9), 1)
        left = most_h = (until - time) / parts
        impacts = 0
        most = 2 * len(self.body.rows)
        for part in range(parts):
            now = time + part * left
            end = now + left
            while end - now > 1e-9 * whole:
                bounce = self.laws.restitution > 0 and impacts < most
                h = min(end - now, most_h)
                state = self._uncovered(state, now, now + h)
                step = _Step(self.body, self.scene, self.laws, state, now, h, acceleration, rest)
                state, used = step.taken(bounce)
                impacts += used == 0
                now += used
                most_h = min(left, max(GROWTH * step.longest, whole / MOST_CUTS))
        return state

    def _uncovered(self, state: State, time: float, later: float) -> State:
        """The state, with letters moved out of obstacles that appear until a later time."""
        if not self.scene.over(time, later).appeared:
            return state
        text = self.body.text.moved_to(state.place)
        free = separated(self.body, text, self.scene, later)
        if free is None or free is text:
            return state
        return replace(state, place=self.body.start(free))


class _Step(FreeStep):
    """A step with contact and impact."""

    longest = np.inf

    def taken(self, bounce: bool) -> tuple[State, float]:
        """The state after the step, and its duration; 0 for an impact."""
        near = self.gaps(self.now, self.reach)
        if self.settled and not len(near.gap):
            return self.after(self.free), self.h
        part = self._part(near)
        self.longest = part * self.h
        if part < 1 and self.laws.substeps is None:
            self.set_duration(0.9 * part * self.h)
        before = self._before()
        inside = self._resting(before)
        resting = bool(len(inside.gap))
        if not resting and not self.settled:
            self.set_duration(self.h)
            return self.taken(bounce)
        if not resting:
            ahead = self.gaps(self.ends, self.reach)
            inside = ahead.some(ahead.gap < 0)
            moment = self._impact(inside) if bounce and len(inside.gap) else None
            if moment == 0.0:
                bounced = self._reflected()
                if bounced is not None:
                    return bounced, 0.0
            elif moment is not None:
                self.set_duration(moment)
                before = self._before()
                ahead = self.gaps(self.ends, self.reach)
                # On the way to the impact, slower contacts may press.
                inside = ahead.some(ahead.gap < -LEFT)
            if not len(inside.gap):
                return self.after(self.free), self.h
        self.touching = self.touching | self.letters_of(inside)
        while True:
            state, depth = self._in_contact(before, resting)
            shortest = self.h <= self.laws.frame / MOST_CUTS
            if depth < max(LEFT, self.state.depth + SAME) or shortest:
                break
            # Contacts that come and go from round to round are fewer in a shorter step. One that
            # was as deep before is not.
            self.set_duration(max(self.h / 2, self.laws.frame / MOST_CUTS))
            before = self._before()
        if depth > BLOCKED:
            raise BlockedError(depth)
        return replace(state, depth=depth), self.h

    def _before(self) -> Touches:
        """All pairs of points that are near each other before the step."""
        return Touches(self.body, self.gaps(self.now, self.reach), self.later)

    def _resting(self, before: Touches) -> Gaps:
        """The contacts that this step presses together, if nothing near approaches fast.

        Then the contacts before the step are those of the step, and no others are looked for.
        """
        near = before.gaps
        pressed = (near.gap < CLOSE) & (before.apart.value(self.end) < 0)
        if pressed.any() and self._fast(near).any():
            pressed[:] = False
        return near.some(pressed)

    def _fast(self, gaps: Gaps) -> BoolArray:
        """Which gaps close so fast that their contact is an impact, before any force acts."""
        size = float(np.hypot(*self.acceleration.T).max(initial=0.0))
        return np.asarray(
            self._approach(gaps, self.state.velocity) > max(FAST * size * self.laws.frame, 1e-6)
        )

    def _approach(self, gaps: Gaps, velocity: Array) -> Array:
        """By how many font units per second gaps close at the start of the step, (C,).

        The velocity (r,) is that of the letters.
        """
        own = self.body.points(velocity)[self.body.controls]
        velocities = np.concatenate([own, (self.later - self.obstacles) / self.h])
        return np.asarray(-(self.relative(gaps, velocities) * gaps.normal).sum(1))

    def _impact(self, inside: Gaps) -> float | None:
        """Seconds until the first impact, 0 if it is now; None if all contacts are slow."""
        before = (self.relative(inside, self.now) * inside.normal).sum(1)
        fast = self._fast(inside) & (before > inside.gap)
        if not fast.any():
            return None
        start, end = np.maximum(before[fast], 0.0), inside.gap[fast]
        # A gap closes like a parabola: start - speed τ + bend τ², with τ from 0 to 1.
        speed = self.h * self._approach(inside, self.state.velocity)[fast]
        bend = end - start + speed
        root = np.sqrt(np.maximum(speed * speed - 4 * bend * start, 0.0))
        part = float(np.clip(2 * start / (speed + root), 0.0, 1.0).min())
        return part * self.h if part * float((start - end).max()) > CLOSE else 0.0

    def _part(self, near: Gaps) -> float:
        """The part of the step after which outlines have moved as far as they may."""
        room = np.maximum(near.gap, 0.0) + PART * self.scene.stroke[near.shape].min(1)

        def part(way: Array) -> float:
            return float((room / np.maximum(way, 1e-12)).min(initial=np.inf))

        frame = self.laws.frame / self.h
        closing = -(self.relative(near, self.moved) * near.normal).sum(1)
        least = min(frame / MOST_CUTS, max(part(closing), frame / FINEST))
        return max(part(self.ways[near.shape[:, 0], near.shape[:, 1]]), least)

    def _in_contact(self, before: Touches, resting: bool) -> tuple[State, float]:
        """The state after a step with contact, without bounce, and its deepest contact."""
        terms, place = self.motion(), self.state.place if resting else self.free
        touches = before
        if not resting:
            found = self._gaps_at(place, self.reach)
            if found.gap.min(initial=0.0) < -UNCLEAR:
                # Deep inside, the nearest way out may lead to the wrong side. Before the step the
                # sides were clear.
                place = self.solve(terms, Contact(before), place)
                found = self._gaps_at(place, self.reach)
            touches = Touches(self.body, found, self.later)
        rough, depth = resting and self.laws.friction > 0, 0.0
        if rough:
            # Forces that are nearly right limit the friction, and the solve with friction finds
            # the contacts again.
            force = self.pressed(terms, Contact(touches), place)
        else:
            place, touches, depth = self._apart(terms, touches, place)
            force = Contact(touches).force_at(place)
        # A step that is left this deep is tried again, or has failed.
        rubs = self.laws.friction > 0 and depth < LEFT and force.any()
        rubbing = self._frictions(touches, force) if rubs else []
        slipping = any(abs(one.moved(place)).max() > SLIP / 10 for one in rubbing)
        if slipping or rough:
            place, touches, depth = self._apart([*terms, *rubbing], touches, place)
            force = Contact(touches).force_at(place)
        state = self.after(place, self.letters_of(touches.gaps.some(force > 0)))
        return state if self.scene.moving else self._without_gain(state), depth

    def _frictions(self, touches: Touches, force: Array) -> list[Friction]:
        """The friction of contacts that press with a force (C,)."""
        pressed = np.flatnonzero(force > 0)
        rubbing = Touches(self.body, touches.gaps.some(pressed), self.later)
        limit = self.laws.friction * force[pressed]
        found: list[Friction] = [Sliding(limit, rubbing, self.relative(rubbing.gaps, self.now))]
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
        depth = np.inf
        reach = max(min(max(self.reach, NEARBY), DEEP), self.depth + MARGIN)
        for _ in range(MOST_ROUNDS):
            place = self.solve(terms, Contact(touches), place)
            found = self._gaps_at(place, reach)
            before, depth = depth, -float(found.gap.min(initial=0.0))
            if depth < DEEPEST or depth == before:
                break
            touches = Touches(self.body, found, self.later)
        return place, touches, depth

    def _gaps_at(self, place: Mapping[str, Array], reach: float) -> Gaps:
        """The gaps at a place at the end of the step."""
        return self.gaps(self.segments(place, self.later), reach)

    def _without_gain(self, state: State) -> State:
        """The state with no more energy than before the step; contact takes energy only."""
        before, after = (self.potential(s.place) for s in (self.state, state))
        kinetic = 0.5 * float(self.state.velocity @ self.state.velocity)
        most, has = before + kinetic - after, 0.5 * float(state.velocity @ state.velocity)
        if has <= most:
            return state
        return replace(state, velocity=state.velocity * np.sqrt(max(most, 0.0) / has))

    def _is_jammed(self, gaps: Gaps, before: Array, after: Array) -> bool:
        """Whether letters that keep their shape would have to leave moving obstacles very fast.

        The velocities (r,) are those of letters that move as a whole, before and after an impact.
        """
        closing = self._approach(gaps, before).max(initial=0.0)
        change = np.linalg.norm(self.body.points(after - before), axis=1).max()
        return self.scene.moving and bool(change > JAMMED * closing)

    def _reflected(self) -> State | None:
        """The state after an impact: the same place, with other velocities.

        None if letters are jammed, so that they cannot bounce.
        """
        gaps = self.gaps(self.now, 2 * CLOSE)
        fastest = float(np.linalg.norm(self.moved, axis=2).max())
        moment = IMPACT * self.h / max(fastest, 1e-9)
        obstacles = self.obstacles + moment / self.h * (self.later - self.obstacles)
        least = (self.relative(gaps, self.now) * gaps.normal).sum(1)
        touches = Touches(self.body, gaps, obstacles)
        contact = Contact(touches, 100 * STIFFNESS, least)

        def stopped(velocity: Array, free: tuple[str, ...]) -> Array:
            """The nearest velocity that brings no contact closer."""
            onwards = Inertia(self.body, self.reduced + moment * velocity)
            place = self.solve([onwards], contact, free=free)
            return (self.body.reduced_at(place) - self.reduced) / moment

        body, e, velocity = self.body, self.laws.restitution, self.state.velocity
        soft = stopped(velocity, body.free)
        if OFFSETS not in body.free:
            after = soft + e * (soft - velocity)
        else:
            whole = self.flight.rigid
            rigid = stopped(whole, (OFFSETS,))
            if self._is_jammed(gaps, whole, rigid):
                return None
            after = (1 + e) * rigid - e * whole
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
        hit = self.letters_of(gaps)
        if len(self.body.free) == 1 or self.body.text.shared:
            return np.full(len(hit), hit.any())
        return hit
