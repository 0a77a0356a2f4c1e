"""Planes of kinks that are oblique in the unknowns, and the linear model of an energy on them.

In a font whose axes move others (avar 2), a region begins at a plane of *final* coordinates, and
that plane is oblique in the unknowns. A point on several such planes lies in a corner of many
cells, and each of them has a Jacobian of its own. Two cells on either side of one plane differ by
a multiple of its normal n, because both agree along the plane. The residual therefore changes
along a small step d by

    J d + Σₖ aₖ max(nₖ·d, 0),

where J is the Jacobian on the lower sides of all planes. Jacobians at random points nearby give J
and the jumps aₖ.

The displacement of the axes has kinks too, which are parallel to the axes. There the planes
themselves have two directions, so the model holds for steps to one side of each such kink.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arrays import Array, BoolArray
from ..outline.composed import Displaced
from ..solver.quadratic import DenseQuadratic, minimise_over_box
from ..text.place import AXES
from .energy import Energy

ON_PLANE = 1e-6
"""Final coordinates this near to a kink count as lying on it."""
RADIUS = 1e-7
"""How far from a point the Jacobian is evaluated on either side of its planes."""
MORE_POINTS = 6
"""The Jacobian is evaluated at so many points besides two for each plane."""
CORRECTIONS = 2
"""Newton steps onto planes, which are curved where axes move others together."""
FLAT = 1e-10
"""Normals and singular values below this are zero."""


class Planes(NamedTuple):
    """The planes of kinks of an energy, linearised at a point.

    Attributes
    ----------
    normals : (K, N) array
    gaps : (K,) array
        The plane is where ``normals · (change of x) = gaps``.
    """

    normals: Array
    gaps: Array

    def some(self, which: BoolArray) -> Planes:
        """Some of the planes."""
        return Planes(self.normals[which], self.gaps[which])


def planes_at(energy: Energy, x: Array, side: Array | None = None) -> Planes:
    """All planes of final coordinates, also those at which a coordinate reaches -1 or 1.

    Where the displacement has a kink, it is that for steps whose signs are ``side``, (N,).
    """
    displacement = _displaced(energy).displacement
    theta = energy.by_letter(x)
    toward = np.ones_like(theta) if side is None else energy.by_letter(side)
    count = theta.shape[1]
    kinks = [
        np.union1d(own, (-1.0, 1.0)) if len(own) else own
        for own in energy.text.word.final_breakpoints
    ]
    owners = np.repeat(np.arange(count), [len(own) for own in kinks])
    normals = np.zeros((len(theta), len(owners), *theta.shape))
    gaps = np.zeros((len(theta), len(owners)))
    for letter, w in enumerate(theta):
        moved, slopes = displacement.value_and_jacobian(w, toward[letter])
        normals[letter, :, letter] = (slopes + np.eye(count))[owners]
        gaps[letter] = np.concatenate(kinks) - (w + moved)[owners]
    return Planes(energy.by_unknowns(normals.reshape(-1, theta.size)), gaps.ravel())


def snapped(energy: Energy, x: Array, reach: float) -> tuple[Array, BoolArray]:
    """A point moved onto the kinks of the displacement within reach, and its unknowns on one.

    It stays within the bounds, and a locked axis stays where it is.
    """
    theta = energy.by_letter(x)
    new, on = theta.copy(), np.zeros_like(theta)
    for axis, kinks in enumerate(_displaced(energy).breakpoints):
        for kink in kinks:
            near = abs(theta[:, axis] - kink) < reach
            new[near, axis], on[near, axis] = kink, 1.0
    flat = energy.unknowns.flat
    moved = x + flat({AXES: new - theta})
    inside = np.clip(moved, energy.lower, energy.upper)
    return inside, (flat({AXES: on}) > 0) & (inside == moved)


def onto(energy: Energy, x: Array, side: Array, which: BoolArray) -> Array:
    """The point of planes that is next to x, within the bounds.

    ``which`` are the planes, (K,), of all those of the energy.
    """
    free = (energy.upper > energy.lower) & (side == 0)
    if not (which.any() and free.any()):
        return x
    for _ in range(CORRECTIONS):
        normals, gaps = planes_at(energy, x, side).some(which)
        step = np.zeros(len(x))
        step[free] = np.linalg.lstsq(normals[:, free], gaps, rcond=FLAT)[0]
        x = np.clip(x + step, energy.lower, energy.upper)
    return x


class PlaneModel:
    """The model of an energy for small steps from a point on planes.

    Parameters
    ----------
    energy : Energy
    x : (N,) array
    side : (N,) array
        -1 or 1 for an unknown on a kink of the displacement: the side to which it moves. 0 for
        the others.
    chance : Generator

    Attributes
    ----------
    planes : Planes
        All planes of the energy, K' of them.
    on : (K',) array of bool
        Which of these x lies on.
    normals : (K, N) array
        Those planes.
    low, high : (N,) arrays
        The range of a step.
    jumps : (K,) array
        By how much half the slope of the cost rises where a plane is crossed upwards.
    """

    def __init__(self, energy: Energy, x: Array, side: Array, chance: np.random.Generator) -> None:
        self.planes = planes = planes_at(energy, x, side)
        self.on = (abs(planes.gaps) < ON_PLANE) & (abs(planes.normals) > FLAT).any(1)
        self.normals = planes.normals[self.on]
        self.low = np.where(side > 0, 0.0, energy.lower - x)
        self.high = np.where(side < 0, 0.0, energy.upper - x)
        self.residual = energy.residual(x)
        weights, reference = energy.proximity
        self.weights, self.pull = weights, weights * (x - reference)
        self._fit(energy, x, chance)
        self.jumps = self.changes.dot(self.residual)

    def _fit(self, energy: Energy, x: Array, chance: np.random.Generator) -> None:
        """Find J and the jumps from Jacobians at points nearby."""
        count = 2 * len(self.normals) + MORE_POINTS
        steps = chance.uniform(0.2, 1, (count, len(x))) * chance.choice((-1, 1), (count, len(x)))
        steps = np.where(-self.low < RADIUS, abs(steps), steps)
        steps = np.where(self.high < RADIUS, -abs(steps), steps)
        steps *= RADIUS * (self.high > self.low)
        jacobians = np.array([energy.jacobian(x + step) for step in steps])
        above = np.array([planes_at(energy, x + step).gaps[self.on] < 0 for step in steps])
        above = above.astype(float).reshape(count, len(self.normals))
        mean, often = jacobians.mean(0), above.mean(0)
        crossings = (above - often)[:, :, None] * self.normals
        rows = crossings.transpose(0, 2, 1).reshape(count * len(x), len(self.normals))
        differences = (jacobians - mean).transpose(0, 2, 1).reshape(count * len(x), -1)
        self.changes: Array = np.linalg.lstsq(rows, differences, rcond=FLAT)[0]
        self.jacobian: Array = mean - (self.changes.T * often) @ self.normals

    @property
    def concave(self) -> BoolArray:
        """The planes from which the cost falls to either side, or falls more steeply, (K,)."""
        found: BoolArray = self.jumps < -RADIUS * abs(self.jumps).max(initial=0.0)
        return found

    @property
    def steepest(self) -> float:
        """The largest squared norm of a column of J on either side of the planes, or weight."""
        above = self.jacobian + self.changes.T @ self.normals
        sides = [(jacobian**2).sum(0).max() for jacobian in (self.jacobian, above)]
        return float(max(*sides, self.weights.max()))

    def decrease(self, d: Array) -> float:
        """The decrease of the cost that the model predicts for a step d."""
        crossed = self.normals.dot(d)
        # A step along a plane crosses it by rounding errors.
        crossed = np.where(abs(crossed) > FLAT * np.linalg.norm(d), crossed.clip(0), 0.0)
        rows = self.jacobian.dot(d) + crossed.dot(self.changes)
        slope = 2 * self.residual.dot(rows) + 2 * self.pull.dot(d)
        return -float(slope + rows.dot(rows) + d.dot(self.weights * d))

    def step(self, upper: Array, damping: float) -> Array:
        """The step that minimises the damped model.

        A plane from which the cost falls less steeply to one side bends the model upwards, and
        the step may go along it. The other planes bend it downwards. There the model of one side
        is above that of the other, so that a step which lowers it lowers both.

        Parameters
        ----------
        upper : (concave,) array
            0 or 1 for each concave plane: whether the model of its upper side is taken.
        damping : float
        """
        share = np.full(len(self.normals), 0.5)
        share[self.concave] = upper
        d = self._along(share, damping)
        # The second derivatives are those of the cells that the step goes through.
        return self._along(share, damping) if not self.concave.all() else d

    def _along(self, share: Array, damping: float) -> Array:
        """A step, found through its dual; ``share`` (K,) is changed to the upper sides' shares.

        The slope on a plane lies between those of both sides, ``share`` from the lower one. The
        multipliers of the bounds are the other unknowns of the dual problem.
        """
        free = self.high > self.low
        jacobian = (self.jacobian + (self.changes.T * share) @ self.normals)[:, free]
        matrix = jacobian.T.dot(jacobian)
        matrix.ravel()[:: len(matrix) + 1] += self.weights[free] + damping
        slope = self.residual.dot(self.jacobian) + self.pull
        bent = ~self.concave
        slope = (slope + (share * self.jumps)[~bent].dot(self.normals[~bent]))[free]
        unit = np.eye(len(matrix))
        ends = [(unit, self.high[free]), (-unit, -self.low[free])]
        bounds = [(rows[np.isfinite(room)], room[np.isfinite(room)]) for rows, room in ends]
        forces = np.concatenate(
            [(self.jumps[:, None] * self.normals)[bent][:, free], *(rows for rows, _ in bounds)]
        )
        room = np.concatenate([np.zeros(bent.sum()), *(room for _, room in bounds)])
        moves = np.linalg.solve(matrix, np.column_stack([forces.T, slope]))
        dual = forces.dot(moves)
        scale = np.sqrt(np.maximum(dual[:, :-1].diagonal(), np.finfo(float).tiny))
        square = dual[:, :-1] / scale / scale[:, None]
        square.ravel()[:: len(square) + 1] += FLAT
        most = np.where(np.arange(len(room)) < bent.sum(), scale, np.inf)
        found, _ = minimise_over_box(
            DenseQuadratic((square + square.T) / 2, (dual[:, -1] + room) / scale),
            np.zeros(len(room)),
            most,
        )
        share[bent] = (found / scale)[: bent.sum()]
        d = np.zeros(len(self.pull))
        d[free] = -moves.dot(np.append(found / scale, 1.0))
        return np.clip(d, self.low, self.high)


def _displaced(energy: Energy) -> Displaced:
    displaced = energy.text.font.displacement
    assert displaced is not None
    return displaced
