r"""Letters in flight: where the motion leads, and the velocity when it gets there.

Without rotation, a step of h seconds leads from q straight on to q + h v, and the velocity after it
is the difference of both places, divided by h. A letter that rotates does not go straight on. Its
velocity has three parts,

    v = V + ω J y + u,

the velocity V of the centre of mass, a rotation by ω radians per second about it, where y are the
points as seen from it, and a deformation u. A step leads to

    y → R(h ω) ((1 + h² ω²) y + h u),

where h² ω² y is the way of the centrifugal force. The angular momentum L = I ω is kept, with the
moment of inertia I = Σ m |y|². If contact turns the letter by Δ in addition, it changes by I Δ / h.
So a rotation in free flight loses no angular momentum to the errors of the steps.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..arrays import Array
from ..text.place import OFFSETS, ROTATIONS, Place
from .body import Body


class Flight:
    """The motion of a body from a place on.

    Parameters
    ----------
    body : Body
    place : mapping of str to array
    velocity : (r,) array
        In reduced coordinates.

    Attributes
    ----------
    reduced : (r,) array
        The reduced coordinates of the place.
    """

    def __init__(self, body: Body, place: Mapping[str, Array], velocity: Array) -> None:
        self.body, self.place, self.velocity = body, place, velocity
        self.reduced = body.reduced_at(place)
        if body.rotates:
            self._own = self.reduced - body.translation(self.reduced)
            self._across = body.quarter(self._own)
            self._momentum = body.dot(self._across, velocity)
            self._turns = _quotient(self._momentum, body.dot(self._own, self._own))

    def rotation(self, turns: Array) -> Array:
        """The velocity (r,) of letters that only rotate, by so many radians per second, (l,)."""
        return turns[self.body.letter] * self._across

    @property
    def rigid(self) -> Array:
        """The part of the velocity that moves letters without deforming them, (r,)."""
        whole = self.body.translation(self.velocity)
        return whole + self.rotation(self._turns) if self.body.rotates else whole

    def ahead(self, h: float) -> Array:
        """Reduced coordinates (r,) in h seconds, without forces."""
        if not self.body.rotates:
            return self.reduced + h * self.velocity
        angles = h * self._turns
        deformed = (1 + angles**2)[self.body.letter] * self._own
        deformed += h * (self.velocity - self.rigid)
        whole = self.body.translation(self.reduced + h * self.velocity)
        return whole + self.body.rotated(deformed, angles)

    def carried(self, goal: Array, h: float) -> Place:
        """The place of undeformed letters in h seconds, whose mean points are those of ``goal``."""
        place = dict(self.place)
        if self.body.rotates:
            place[ROTATIONS] = place[ROTATIONS] + h * self._turns
        if OFFSETS in self.body.free:
            way = goal - self.body.reduced_at(place)
            place[OFFSETS] = place[OFFSETS] + self.body.means(way)
        return Place(place)

    def velocity_at(self, place: Mapping[str, Array], goal: Array, h: float) -> Array:
        """The velocity (r,) at a place h seconds later, where ``goal`` (r,) is without contact."""
        body, reduced = self.body, self.body.reduced_at(place)
        if not body.rotates:
            return (reduced - self.reduced) / h
        whole = body.translation(reduced)
        own, free = reduced - whole, goal - body.translation(goal)
        across, inertia = body.quarter(own), body.dot(own, own)
        turned = np.arctan2(body.dot(body.quarter(free), own), body.dot(free, own))
        turns = _quotient(self._momentum + inertia * turned / h, inertia)
        before = body.rotated(self._own, place[ROTATIONS] - self.place[ROTATIONS])
        shape = (own - before) / h
        shape -= _quotient(body.dot(across, shape), inertia)[body.letter] * across
        whole = (whole - body.translation(self.reduced)) / h
        return whole + turns[body.letter] * across + shape


def _quotient(values: Array, masses: Array) -> Array:
    """Values of letters divided by their masses; 0 for a letter without any."""
    return np.divide(values, masses, out=np.zeros_like(values), where=masses > 0)
