r"""Where the search for a place without contacts starts: a quadratic model with one-sided springs.

Contacts are one-sided. A step of the solver treats those that are active as equations, so on a
round corner it pulls points that touch less towards the obstacle, and it cannot see the contacts
that the step runs into. In the model

    |r + J d|² + w Σ max(0, −(g + N d))²,

which is linear in the unknowns between the contacts, the least d is found exactly: contacts that
pull leave the active set, and those that are entered join it, until none does (block principal
pivoting, Júdice and Pires 1994). Some such steps lead close to the least place.
"""

from __future__ import annotations

import numpy as np

from ..arrays import Array
from ..energy.energy import Energy
from .terms import Contact

MOST_STEPS, MOST_HALVINGS = 6, 3
"""Of the model, and of each step if it does not lower the energy."""
SETTLED = 1e-4
"""Share of the energy: the search ends with a step that gains less."""
WALL = 1e3
"""Weight of the bounds in the model, times the largest weight of a contact on an unknown."""
MOST_EXCHANGES, PATIENCE = 200, 5
"""Exchanges of contacts; those without progress before contacts are exchanged one by one."""
LEAST = 1e-10
"""Share of its own diagonal entry that every unknown gets, so that the model has one minimum."""


def start_of(energy: Energy, contact: Contact, x: Array) -> Array:
    """Unknowns (N,) near the least sum of an energy and a contact, from x (N,).

    Parameters
    ----------
    energy : Energy
        All terms but for the contact.
    contact : Contact
    x : (N,) array
    """
    weights, reference = energy.proximity

    def cost(x: Array) -> float:
        residual, depth = energy.residual(x), contact.residual_at(energy.unknowns.place(x))
        return float(residual @ residual + depth @ depth + weights @ (x - reference) ** 2)

    before = cost(x)
    for _ in range(MOST_STEPS):
        step = _step(energy, contact, x)
        for _ in range(MOST_HALVINGS):
            trial = np.clip(x + step, energy.lower, energy.upper)
            after = cost(trial)
            if after < before:
                break
            step = step / 2
        else:
            return x
        x, gained, before = trial, before - after, after
        if gained < SETTLED * before:
            return x
    return x


def _step(energy: Energy, contact: Contact, x: Array) -> Array:
    """The least d of the model at x, within the bounds."""
    place, slices = energy.unknowns.place(x), energy.unknowns.slices
    residual, jacobian = energy.residual(x), energy.jacobian(x)
    weights, reference = energy.proximity
    curvature = jacobian.T @ jacobian + np.diag(weights)
    slope = jacobian.T @ residual + weights * (x - reference)
    normals = np.sqrt(contact.weight) * contact.touches.jacobian(
        contact.touches.normals, place, slices
    )
    gaps = np.sqrt(contact.weight) * contact.gaps_at(place)
    # Bounds are walls as well.
    bounded = np.isfinite(energy.lower)
    size = np.sqrt(WALL * (np.diag(curvature) + (normals**2).max(0, initial=0.0)))[bounded]
    walls = size[:, None] * np.eye(len(x))[bounded]
    normals = np.concatenate([normals, walls, -walls])
    gaps = np.concatenate(
        [
            gaps,
            size * (x - energy.lower)[bounded],
            size * (energy.upper - x)[bounded],
        ]
    )
    return least(curvature, slope, normals, gaps)


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
    curvature = curvature + np.diag(LEAST * (diagonal + 1e-3 * diagonal.max()))
    active = gaps < 0
    fewest, patience = len(gaps) + 1, PATIENCE
    for _ in range(MOST_EXCHANGES):
        rows = normals[active]
        found = -np.linalg.solve(curvature + rows.T @ rows, slope + rows.T @ gaps[active])
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
    return found
