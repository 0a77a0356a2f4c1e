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

from ..arrays import Array, BoolArray
from ..energy.energy import Energy
from ..solver.drivers import answer
from ..solver.linearize import cell, one_sided
from ..solver.problem import Kind, Problem, State, Tolerances
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
    model = _Model(energy, contact)
    here, before = _Point(model, x), 0.0
    for _ in range(MOST_STEPS):
        enough = TOLERANCES.least_decrease(here.cost)
        if here.cost <= enough:
            return here.x, True
        step, promised, _ = here.step()
        if promised <= enough:
            return here.x, True
        if promised <= NEARLY * enough and promised * promised <= enough * before:
            # At this rate the step after this one would gain less.
            return model.within(here.x + step), True
        for _ in range(MOST_HALVINGS):
            there = _Point(model, model.within(here.x + step))
            if there.cost < here.cost:
                break
            step = step / 2
        else:
            break
        here, before = there, promised
    return here.x, False


def pressed(energy: Energy, contact: Contact, x: Array) -> Array:
    """How strongly each contact presses after one step of the model from x (N,), (C,)."""
    model = _Model(energy, contact)
    return model.root * _Point(model, x).step()[2]


class _Model:
    """The data that all points of one search share: energy, contact and walls.

    Attributes
    ----------
    root : float
        Root of the weight of the contact.
    active : (C + B,) bool array or None
        The contacts and walls that were active in the latest step.
    """

    def __init__(self, energy: Energy, contact: Contact | None) -> None:
        self.energy, self.contact = energy, contact
        self.root = 0.0 if contact is None else float(np.sqrt(contact.weight))
        lower, upper = energy.lower, energy.upper
        # At a kink the derivative is that to the right, and a lower bound has no other side.
        self.kinks = np.where(energy.kinks > lower[:, None], energy.kinks, np.inf)
        self.problem = Problem(lower, upper, self.kinks, proximity=energy.proximity)
        self._bounded = np.flatnonzero(np.isfinite(lower) | np.isfinite(upper))
        sides = np.eye(len(lower))[self._bounded]
        self._sides = np.concatenate([sides, -sides])
        self.active: BoolArray | None = None

    def within(self, x: Array) -> Array:
        """The nearest unknowns (N,) within the bounds."""
        return np.minimum(np.maximum(x, self.energy.lower), self.energy.upper)

    def gaps(self, x: Array) -> Array:
        """The gaps of the contact at x, weighted, (C,)."""
        if self.contact is None:
            return np.zeros(0)
        return self.root * self.contact.gaps_at(self.energy.unknowns.place(x))

    def slopes(self, x: Array) -> Array:
        """The derivative of the residual and of the gaps at x, (r + C, N)."""
        jacobian = self.energy.jacobian(x)
        if self.contact is None:
            return jacobian
        unknowns = self.energy.unknowns
        normals = self.contact.touches.apart.moves(unknowns.place(x), unknowns.slices)
        return np.concatenate([jacobian, self.root * normals])

    def walls(self, low: Array, high: Array, size: Array) -> tuple[Array, Array]:
        """Rows (B, N) and room (B,) for steps between low and high, weighted by size (N,)."""
        bounded = self._bounded
        room = np.concatenate([-low[bounded] * size[bounded], high[bounded] * size[bounded]])
        return self._sides * size, room


class _Point:
    """The model at x (N,).

    Attributes
    ----------
    cost : float
    """

    def __init__(self, model: _Model, x: Array) -> None:
        self.model, self.x = model, x
        self._own, self._gaps = model.energy.residual(x), model.gaps(x)
        self._residual = np.concatenate([self._own, np.minimum(self._gaps, 0.0)])
        self.cost = model.problem.cost(self._residual, x)

    def _slopes(self) -> tuple[Array, Array, Array]:
        """The derivative, and how far a step may go before it crosses a bound or a kink."""
        model, x = self.model, self.x
        state = State(x, self._residual, self.cost)
        slopes, low, high = answer(one_sided(model.problem, state), {Kind.JACOBIAN: model.slopes})
        below, above = cell(model.kinks, x)
        return slopes, np.maximum(low, below), np.minimum(high, above)

    def step(self) -> tuple[Array, float, Array]:
        """The step of the model up to the next kinks.

        Returns
        -------
        d : (N,) array
        gain : float
            By how much the step lowers the energy of the model.
        pressure : (C,) array
            How deep each contact is after the step, weighted.
        """
        model = self.model
        weights, reference = model.energy.proximity
        slopes, low, high = self._slopes()
        jacobian, normals = slopes[: len(self._own)], slopes[len(self._own) :]
        curvature = jacobian.T.dot(jacobian)
        diagonal = curvature.ravel()[:: len(curvature) + 1]
        diagonal += weights
        slope = self._own.dot(jacobian) + weights * (self.x - reference)
        size = np.sqrt(WALL * (diagonal + (normals * normals).max(0, initial=0.0)))
        walls, room = model.walls(low, high, size)
        rows, gaps = np.concatenate([normals, walls]), np.concatenate([self._gaps, room])
        d, model.active = least(curvature, slope, rows, gaps, model.active)
        d = np.minimum(np.maximum(d, low), high)
        before = self._residual[len(self._own) :]
        after = np.maximum(-(self._gaps + normals.dot(d)), 0.0)
        gain = before.dot(before) - after.dot(after) - d.dot(curvature.dot(d) + 2 * slope)
        return d, float(gain), after


def least(
    curvature: Array, slope: Array, normals: Array, gaps: Array, active: BoolArray | None = None
) -> tuple[Array, BoolArray]:
    """The minimum (N,) of ½ d·H d + f·d + ½ Σ max(0, −(g + N d))², and the active rows (C,).

    If the exchanges of active rows do not settle, d is the minimum under the assumption that
    exactly the returned rows are active.

    Parameters
    ----------
    curvature : (N, N) array
        H, positive semidefinite.
    slope : (N,) array
        f.
    normals : (C, N) array
    gaps : (C,) array
    active : (C,) bool array, optional
        A guess of the rows that are active at the minimum.
    """
    diagonal = curvature.diagonal()
    extra = LEAST * (diagonal + 1e-3 * diagonal.max())
    regular = curvature.copy()
    regular.ravel()[:: len(regular) + 1] += extra
    if active is None:
        active = (gaps < 0) | ((gaps == 0) & (normals.dot(slope) > 0))
    fewest, patience = len(gaps) + 1, PATIENCE
    for _ in range(MOST_EXCHANGES):
        solved = active
        rows = normals[solved]
        matrix = regular + rows.T.dot(rows)
        found = -np.linalg.solve(matrix, slope + gaps[solved].dot(rows))
        wrong = ((gaps + normals.dot(found) < 0) != solved).nonzero()[0]
        if not len(wrong):
            break
        if len(wrong) < fewest:
            fewest, patience = len(wrong), PATIENCE
        elif patience:
            patience -= 1
        else:
            wrong = wrong[-1:]
        active = solved.copy()
        active[wrong] = ~solved[wrong]
    # One refinement removes the effect of the entries that were added.
    return found + np.linalg.solve(matrix, extra * found), solved
