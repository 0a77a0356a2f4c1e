"""The terms of a time step: inertia, springs, contact and friction (Sec. 5.3).

All are sums of squares in units of mass times squared font units, which is energy times 2 h² for a
step of h seconds. Their sum is minimised over the text's place by the solver of the package.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..arrays import Array
from ..energy import Term
from ..energy.rows import Rows
from ..outline.cubics import bernstein
from ..overlap.gaps import Gaps
from ..text import Text
from ..text.place import AXES, ROTATIONS, Block
from .body import QUARTER, Body

STIFFNESS = 1e3
"""Weight of a squared penetration for a mass of 1."""
SLIP = 0.02
"""Font units: friction resists a smaller displacement like a spring, and holds it."""


@dataclass(frozen=True, eq=False)
class Inertia(Term):
    """Keep the momentum: ‖q(x) − q̂‖² in reduced coordinates, with q̂ where the motion leads.

    The angles of letters that rotate are unknowns of this term.
    """

    body: Body
    goal: Array
    tolerance = None

    def blocks(self, text: Text) -> Mapping[str, Block]:
        return {ROTATIONS: Block(text.rotations)} if self.body.rotates else {}

    def locate(self, text: Text) -> Rows | None:
        return _Rows(self)

    def residual_at(self, place: Mapping[str, Array]) -> Array:
        """The residual (r,)."""
        return self.body.reduced_at(place) - self.goal

    def jacobian_at(self, place: Mapping[str, Array], slices: Mapping[str, slice]) -> Array:
        """Its derivative (r, N)."""
        return self.body.reduced_moves(place, slices)


@dataclass(frozen=True, eq=False)
class Springs(Term):
    """Pull the axes to their rest state and slow them down: Σ weights · (Θ − reference)²."""

    weights: Array
    reference: Array
    tolerance = None

    def locate(self, text: Text) -> Rows | None:
        return None

    def proximity(self, text: Text) -> Mapping[str, tuple[Array, Array]]:
        return {AXES: (self.weights, self.reference)}


class Touches:
    """C pairs of points of two shapes, carried by control points or by an obstacle.

    Parameters
    ----------
    body : Body
    gaps : Gaps
    obstacles : (S', 4, 2) array
        Segments of the obstacles, which follow those of the letters.
    """

    def __init__(self, body: Body, gaps: Gaps, obstacles: Array) -> None:
        self.gaps, self._body = gaps, body
        count = len(body.controls)
        moving = gaps.segment < count
        weights = np.moveaxis(bernstein(gaps.t), 0, -1) * [[1.0], [-1.0]]
        self._points = body.controls[np.where(moving, gaps.segment, 0)].reshape(-1, 8)
        self._weights = (weights * moving[..., None]).reshape(-1, 8)
        self._fixed = np.zeros((len(moving), 2))
        if not moving.all():
            fixed = obstacles[np.where(moving, 0, gaps.segment - count)]
            self._fixed = np.einsum("csk,cskd->cd", weights * ~moving[..., None], fixed)

    @cached_property
    def apart(self) -> Along:
        """How far the first points are from the second ones, along the normals."""
        return self._along(self.gaps.normal)

    @cached_property
    def aside(self) -> Along:
        """How far the first points are from the second ones, along the outlines."""
        return self._along(self.gaps.normal @ QUARTER.T)

    def _along(self, directions: Array) -> Along:
        vectors = self._weights[..., None] * directions[:, None]
        rows = self._body.rows_of(self._points, vectors)
        return Along(self._body, rows, (self._fixed * directions).sum(1), directions)


@dataclass(frozen=True, eq=False)
class Along:
    """The relative positions of C pairs of points along a direction each.

    Attributes
    ----------
    rows : (C, r) array
        Their derivative by the reduced coordinates.
    fixed : (C,) array
        The parts of points that are carried by an obstacle.
    directions : (C, 2) array
    """

    body: Body
    rows: Array
    fixed: Array
    directions: Array

    def at(self, place: Mapping[str, Array]) -> Array:
        """Their values at a place, (C,)."""
        return self.value(self.body.reduced_at(place))

    def value(self, reduced: Array) -> Array:
        """Their values at reduced coordinates (r,), (C,)."""
        return np.asarray(self.rows.dot(reduced) + self.fixed)

    def moves(self, place: Mapping[str, Array], slices: Mapping[str, slice]) -> Array:
        """Their derivative by the free unknowns, (C, N)."""
        return np.asarray(self.rows @ self.body.reduced_moves(place, slices))


@dataclass(frozen=True, eq=False)
class Contact(Term):
    """Keep outlines apart: Σ max(0, least − N·(a − b))² over contacts (Eq. 5).

    Attributes
    ----------
    touches : Touches
    least : (C,) array or float
        The gaps that are kept, in font units. Default 0.
    """

    touches: Touches
    weight: float = STIFFNESS
    least: Any = 0.0
    tolerance = None

    def locate(self, text: Text) -> Rows | None:
        return _Rows(self)

    def residual_at(self, place: Mapping[str, Array]) -> Array:
        """The residual (C,), weighted."""
        return np.sqrt(self.weight) * np.maximum(-self.gaps_at(place), 0.0)

    def gaps_at(self, place: Mapping[str, Array]) -> Array:
        """The gaps minus those that are kept, (C,)."""
        return np.asarray(self.touches.apart.at(place) - self.least)

    def force_at(self, place: Mapping[str, Array]) -> Array:
        """How strongly each contact presses, (C,)."""
        return np.sqrt(self.weight) * self.residual_at(place)

    def jacobian_at(self, place: Mapping[str, Array], slices: Mapping[str, slice]) -> Array:
        """Its derivative (C, N)."""
        beyond = self.residual_at(place) > 0
        moves = self.touches.apart.moves(place, slices)
        return -np.sqrt(self.weight) * beyond[:, None] * moves


@dataclass(frozen=True, eq=False)
class Friction(Term):
    """Dry friction: 2 Σ limit (√(u² + s²) − s) for displacements u during the time step.

    Attributes
    ----------
    limit : (F,) array
        The largest friction that resists each displacement.
    """

    limit: Array
    tolerance = None

    def locate(self, text: Text) -> Rows | None:
        return _Rows(self)

    @abstractmethod
    def moved(self, place: Mapping[str, Array]) -> Array:
        """The displacements u (F,)."""

    @abstractmethod
    def moves(self, place: Mapping[str, Array], slices: Mapping[str, slice]) -> Array:
        """Their derivative (F, N)."""

    def residual_at(self, place: Mapping[str, Array]) -> Array:
        """The residual (F,): the root of each share, with the sign of u."""
        u = self.moved(place)
        # With √(u² + s²) − s = u² / (√(u² + s²) + s), nothing is divided by zero.
        share = u * u / (np.sqrt(u * u + SLIP * SLIP) + SLIP)
        return np.asarray(np.sign(u) * np.sqrt(2 * self.limit * share))

    def jacobian_at(self, place: Mapping[str, Array], slices: Mapping[str, slice]) -> Array:
        """Its derivative (F, N)."""
        u = self.moved(place)
        root = np.sqrt(u * u + SLIP * SLIP)
        slope = np.sqrt(self.limit * (root + SLIP) / 2) / root
        return np.asarray(slope[:, None] * self.moves(place, slices))


@dataclass(frozen=True, eq=False)
class Sliding(Friction):
    """Coulomb friction of C contacts, which resists displacements along the outlines.

    Attributes
    ----------
    touches : Touches
    start : (C, 2) array
        The first points as seen from the second ones at the start of the time step.
    """

    touches: Touches
    start: Array

    def moved(self, place: Mapping[str, Array]) -> Array:
        aside = self.touches.aside
        return aside.at(place) - (self.start * aside.directions).sum(1)

    def moves(self, place: Mapping[str, Array], slices: Mapping[str, slice]) -> Array:
        return self.touches.aside.moves(place, slices)


@dataclass(frozen=True, eq=False)
class Rolling(Friction):
    """Rolling resistance of the letters, which brings those that roll or rock to rest.

    Attributes
    ----------
    arm : float
        Font units: a rotation counts as the displacement of a point at this distance.
    start : (l,) array
        The angles at the start of the time step.
    """

    arm: float
    start: Array

    def moved(self, place: Mapping[str, Array]) -> Array:
        return np.asarray(self.arm * (place[ROTATIONS] - self.start))

    def moves(self, place: Mapping[str, Array], slices: Mapping[str, slice]) -> Array:
        moves = np.zeros((len(self.start), max(part.stop for part in slices.values())))
        moves[:, slices[ROTATIONS]] = self.arm * np.eye(len(self.start))
        return moves


class _Rows:
    """The rows of a term that evaluates the place itself."""

    def __init__(self, term: Any) -> None:
        self.term = term

    def residual(self, place: Mapping[str, Array]) -> Array:
        found: Array = self.term.residual_at(place)
        return found

    def own_residual(self, place: Mapping[str, Array]) -> Array:
        return self.residual(place)

    def jacobian(self, place: Mapping[str, Array], slices: Mapping[str, slice]) -> Array:
        found: Array = self.term.jacobian_at(place, slices)
        return found
