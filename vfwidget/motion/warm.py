r"""Where the search for a place without contacts starts: a quadratic model with one-sided springs.

Contacts are one-sided. A step of the solver treats those that are active as equations, so on a
round corner it pulls points that touch less towards the obstacle, and it cannot see the contacts
that the step runs into. In the model

    |r + J d|² + w Σ max(0, −(g + N d))²,

which is linear in the unknowns between the contacts, the least d is found exactly: contacts that
pull leave the active set, and those that are entered join it, until none does (block principal
pivoting, Júdice and Pires 1994). Bounds are walls of the same kind, and so are kinks, which a step
reaches but does not cross. Some such steps lead to the least place.
"""

from __future__ import annotations

import numpy as np

from ..arrays import Array
from ..energy.energy import Energy
from ..solver.drivers import answer
from ..solver.linearize import cell, one_sided
from ..solver.problem import Kind, Problem, Proximity, State, Tolerances
from .terms import Contact

MOST_STEPS, MOST_HALVINGS = 12, 3
"""Of the model, and of each step if it does not lower the energy."""
TOLERANCES = Tolerances(step=1e-10, absolute_cost=1e-8, relative_cost=1e-13)
NEARLY = 100.0
"""A search has settled if no step gains more, or after a step that gains up to so many times more
and much less than the step before."""
WALL = 1e6
"""Weight of bounds and kinks in the model, times the largest weight of a contact on an unknown."""
MOST_EXCHANGES, PATIENCE = 200, 5
"""Exchanges of contacts; those without progress before contacts are exchanged one by one."""
LEAST = 1e-10
"""Share of its own diagonal entry that every unknown gets, so that the model has one minimum."""


def approach(energy: Energy, contact: Contact | None, x: Array) -> tuple[Array, bool]:
    """Unknowns (N,) near the least sum of an energy and a contact, from x (N,).

    Parameters
    ----------
    energy : Energy
        All terms but for the contact.
    contact : Contact or None
    x : (N,) array

    Returns
    -------
    x : (N,) array
    settled : bool
        Whether no step of the model lowers the energy noticeably. Then x needs no other search.
    """
    here, before = _Point(energy, contact, x), 0.0
    for _ in range(MOST_STEPS):
        enough = TOLERANCES.least_decrease(here.cost)
        if here.cost <= enough:
            return here.x, True
        step, promised = here.step()
        if promised <= enough:
            return here.x, True
        if promised <= NEARLY * enough and promised * promised <= enough * before:
            # At this rate the step after this one would gain less.
            return np.clip(here.x + step, energy.lower, energy.upper), True
        for _ in range(MOST_HALVINGS):
            x = np.clip(here.x + step, energy.lower, energy.upper)
            there = _Point(energy, contact, x)
            if there.cost < here.cost:
                break
            step = step / 2
        else:
            break
        here, before = there, promised
    return here.x, False


def predicted(energy: Energy, contact: Contact | None, x: Array) -> Array:
    """Unknowns (N,) to which one step of the model leads from x (N,)."""
    return np.clip(x + _Point(energy, contact, x).step()[0], energy.lower, energy.upper)


class _Point:
    """The model of an energy and a contact at x (N,).

    Attributes
    ----------
    cost : float
    """

    def __init__(self, energy: Energy, contact: Contact | None, x: Array) -> None:
        self.energy, self.contact, self.x = energy, contact, x
        self.problem = Problem(
            energy.lower, energy.upper, energy.kinks, proximity=Proximity(*energy.proximity)
        )
        residual = energy.residual(x)
        self._own, self._gaps = slice(0, len(residual)), np.zeros(0)
        if contact is not None:
            self._gaps = np.sqrt(contact.weight) * contact.gaps_at(energy.unknowns.place(x))
        self._residual = np.concatenate([residual, np.minimum(self._gaps, 0.0)])
        self.cost = self.problem.cost(self._residual, x)

    def _slopes(self, x: Array) -> Array:
        """The derivative of the residual and of the gaps, (r + C, N)."""
        jacobian, contact = self.energy.jacobian(x), self.contact
        if contact is None:
            return jacobian
        unknowns = self.energy.unknowns
        normals = contact.touches.apart.moves(unknowns.place(x), unknowns.slices)
        return np.concatenate([jacobian, np.sqrt(contact.weight) * normals])

    def step(self) -> tuple[Array, float]:
        """The least d of the model up to the next kinks, and by how much it lowers the energy."""
        state = State(self.x, self._residual, self.cost)
        weights, reference = self.energy.proximity
        slopes, low, high = answer(one_sided(self.problem, state), {Kind.JACOBIAN: self._slopes})
        assert self.problem.kinks is not None
        below, above = cell(self.problem.kinks, self.x)
        low, high = np.maximum(low, below), np.minimum(high, above)
        jacobian, normals = slopes[self._own], slopes[self._own.stop :]
        curvature = jacobian.T.dot(jacobian)
        diagonal = curvature.ravel()[:: len(curvature) + 1]
        diagonal += weights
        slope = self._residual[self._own].dot(jacobian) + weights * (self.x - reference)
        size = np.sqrt(WALL * (diagonal + (normals * normals).max(0, initial=0.0)))
        walls, room = [normals], [self._gaps]
        for side, end in ((1.0, -low), (-1.0, high)):
            near = np.isfinite(end)
            walls.append(side * np.diag(size)[near])
            room.append((size * end)[near])
        d = np.clip(least(curvature, slope, np.concatenate(walls), np.concatenate(room)), low, high)
        before, after = self._residual[self._own.stop :], np.minimum(self._gaps + normals @ d, 0.0)
        return d, float(before @ before - after @ after - d @ (curvature @ d + 2 * slope))


def least(curvature: Array, slope: Array, normals: Array, gaps: Array) -> Array:
    """The minimum (N,) of ½ d·H d + f·d + ½ Σ max(0, −(g + N d))².

    Parameters
    ----------
    curvature : (N, N) array
        H, positive semidefinite.
    slope : (N,) array
        f.
    normals : (C, N) array
    gaps : (C,) array
    """
    diagonal = np.diag(curvature)
    extra = LEAST * (diagonal + 1e-3 * diagonal.max())
    regular = curvature + np.diag(extra)
    active = gaps < 0
    fewest, patience = len(gaps) + 1, PATIENCE
    for _ in range(MOST_EXCHANGES):
        rows = normals[active]
        matrix = regular + rows.T @ rows
        found = -np.linalg.solve(matrix, slope + rows.T @ gaps[active])
        wrong = np.flatnonzero((gaps + normals @ found < 0) != active)
        if not len(wrong):
            break
        if len(wrong) < fewest:
            fewest, patience = len(wrong), PATIENCE
        elif patience:
            patience -= 1
        else:
            wrong = wrong[-1:]
        active[wrong] = ~active[wrong]
    # One refinement removes the effect of the entries that were added.
    return found + np.linalg.solve(matrix, extra * found)
