"""Descent along kinks that are not parallel to the axes, which fonts have whose axes move others.

There a region begins at a plane of *final* coordinates, and that plane is oblique in the unknowns.
The solver takes kinks to be parallel to the axes, so it may stop on such planes although the cost
falls along them. Where a descent has ended so, steps of a model that knows the planes
(:mod:`.planes`) are tried, and the descent goes on from the best point that they reach. If the
model has no step that lowers the cost, the descent has converged.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import product

import numpy as np

from ..arrays import Array, BoolArray
from ..solver.status import CONVERGED, ITERATION_LIMIT, OUT_OF_TIME, STALLED, Outcome
from ..text.place import AXES
from .descent import Descent
from .energy import Energy
from .planes import ON_PLANE, RADIUS, PlaneModel, onto, planes_at, snapped

MOST_STEPS = 100
MANY_STEPS = Outcome(ITERATION_LIMIT, "The cost still falls along planes of kinks.")
ON_PLANES = Outcome(CONVERGED, "No step lowers the cost, along the planes of kinks or off them.")
LEAST_GAIN = 1e-6
"""A step counts if it lowers the cost by a larger share than this."""
NEAR = 3e-3
"""Planes this near, in normalized coordinates, are tried as well: the cost may rise a little as far
as a plane, and fall beyond it."""
DAMPINGS = 1e-6 * 10.0 ** np.arange(14)
"""Tried in this order, relative to the largest squared column norm of the Jacobian on
either side of the planes."""
FAIR_GAIN = 0.5
"""A step that achieves this share of the predicted decrease is taken at once."""
MOST_CROSSED = 6
"""A step may also end on one of so many planes that it crosses first."""
MOST_CHOICES = 8
"""So many choices of the sides of planes are tried, where the cost falls to both sides of some."""


def along_planes(
    energy: Energy,
    found: Descent,
    descend: Callable[[Energy, Array], Descent],
    deadline: float = math.inf,
) -> Descent:
    """Go on from where a descent ended on planes of kinks, as long as the cost falls along them.

    ``deadline`` is the value of ``time.perf_counter()`` after which no step is tried.
    """
    if not energy.text.font.moves_axes or AXES not in energy.unknowns.slices:
        return found
    steps = 0
    while not _is_done(found):
        search = _Search(energy, found, deadline)
        taken = search.run(MOST_STEPS - steps)
        steps += taken
        if taken:
            found = descend(energy, search.x).after(found)
        if search.limit is not None:
            return _ended(found, search.limit)
        if not found.state.cost < search.cost * (1 - LEAST_GAIN):
            return _settled(found)
    return found


def _is_done(found: Descent) -> bool:
    """Whether a descent has converged with every goal met, or has run out of time."""
    outcome = found.state.outcome
    if outcome is None or outcome.status != CONVERGED:
        return outcome is OUT_OF_TIME
    has_goals = any(result.miss is not None for result in found.results)
    return has_goals and not found.missed


def _settled(found: Descent) -> Descent:
    """A descent beyond whose end no step leads; it has converged, unless a limit ended it."""
    outcome = found.state.outcome
    if outcome is None or outcome.status != STALLED:
        return found
    return _ended(found, ON_PLANES)


def _ended(found: Descent, outcome: Outcome) -> Descent:
    return found._replace(state=replace(found.state, outcome=outcome))


class _Search:
    """Steps along planes from the end of a descent.

    Attributes
    ----------
    x, cost : (N,) array, float
        The best point so far.
    limit : Outcome or None
        Why the search was ended although it could go on.
    """

    def __init__(self, energy: Energy, found: Descent, deadline: float) -> None:
        self.energy, self.problem, self.deadline = energy, found.problem, deadline
        self.x, self.cost = found.state.x, found.state.cost
        self.chance = np.random.default_rng(0)
        self.limit: Outcome | None = None

    def run(self, most: int) -> int:
        """Take steps until none lowers the cost; how many were taken."""
        for count in range(most):
            if time.perf_counter() > self.deadline:
                self.limit = OUT_OF_TIME
                return count
            if not self._step():
                return count
        self.limit = MANY_STEPS
        return most

    @property
    def _least(self) -> float:
        return max(self.problem.tolerances.absolute_cost, LEAST_GAIN * self.cost)

    def _step(self) -> bool:
        """Take the first step that helps, from the planes at x or else from those near x."""
        return any(self._step_from(*start) for start in self._starts())

    def _starts(self) -> Iterator[tuple[Array, Array]]:
        """Points on planes, and the sides of the kinks of the displacement to which to step."""
        before = -1
        for reach in (ON_PLANE, NEAR):
            snapped_x, on = snapped(self.energy, self.x, reach)
            near = abs(planes_at(self.energy, snapped_x).gaps) < reach
            count = int(on.sum() + near.sum())
            if count == before:
                return
            before = count
            for side in self._sides(snapped_x, on):
                yield onto(self.energy, snapped_x, side, near), side

    def _step_from(self, x: Array, side: Array) -> bool:
        model = PlaneModel(self.energy, x, side, self.chance)
        for upper in self._choices(int(model.concave.sum())):
            cost, new = self._best(model, x, side, upper)
            if cost < self.cost - self._least:
                self.x, self.cost = new, cost
                return True
        return False

    def _best(self, model: PlaneModel, x: Array, side: Array, upper: Array) -> tuple[float, Array]:
        """The lowest cost of steps with more and more damping, and where it is."""
        start = self._cost(x)
        best, above = (start, x), max(start - self.cost, 0.0)
        for damping in DAMPINGS * (model.steepest or 1.0):
            d = model.step(upper, damping)
            predicted = model.decrease(d)
            if predicted <= self._least + above:
                break
            for new in self._ends(model, x, side, d):
                best = min(best, (self._cost(new), new), key=lambda one: one[0])
            if start - best[0] > FAIR_GAIN * predicted:
                break
        return best

    def _ends(self, model: PlaneModel, x: Array, side: Array, d: Array) -> Iterator[Array]:
        """The end of a step, and points of it on the planes that it crosses first."""
        planes = model.planes
        speeds = planes.normals.dot(d)
        stays = model.on & (abs(speeds) <= RADIUS * np.linalg.norm(d))
        crossed = ~model.on & (planes.gaps * speeds > 0)
        shares = np.sort(planes.gaps[crossed] / speeds[crossed])
        for share in (1.0, *shares[shares < 1][:MOST_CROSSED]):
            new = np.clip(x + share * d, self.energy.lower, self.energy.upper)
            yield onto(self.energy, new, side, stays)

    def _cost(self, x: Array) -> float:
        residual = self.energy.residual(x)
        return self.problem.cost(residual, x) if np.isfinite(residual).all() else np.inf

    def _sides(self, x: Array, on: BoolArray) -> Iterator[Array]:
        """The sides of the kinks of the displacement that x is on, (N,): 0 off the kinks.

        First the side to which the cost falls most steeply, then the other one for each kink.
        """
        energy, residual = self.energy, self.energy.residual(x)
        slopes = []
        for sign in (1, -1):
            jacobian = energy.jacobian(np.clip(x + sign * RADIUS * on, energy.lower, energy.upper))
            slopes.append(sign * self.problem.half_gradient(residual, jacobian, x))
        below, above = x <= energy.lower, x >= energy.upper
        right = ((slopes[0] <= slopes[1]) | below) & ~above
        side = np.where(on, np.where(right, 1.0, -1.0), 0.0)
        yield side
        for i in np.flatnonzero(on & ~below & ~above):
            yield np.where(np.arange(len(x)) == i, -side, side)

    def _choices(self, count: int) -> Iterator[Array]:
        """For each of so many planes 0 or 1, in different ways."""
        if 2**count <= MOST_CHOICES:
            for chosen in product((0.0, 1.0), repeat=count):
                yield np.array(chosen)
        else:
            yield from self.chance.integers(0, 2, (MOST_CHOICES, count)).astype(float)
