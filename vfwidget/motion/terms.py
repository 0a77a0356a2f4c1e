"""The terms of a time step: inertia, springs, contact and friction (Sec. 5.3).

All are sums of squares in units of mass times squared font units, which is energy times 2 h² for a
step of h seconds. Their sum is minimised over the text's place by the solver of the package.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import Array, IntArray
from ..energy import Term
from ..energy.rows import Rows
from ..overlap.gaps import Gaps
from ..text import Text
from ..text.place import AXES, OFFSETS, ROTATIONS, Block
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
        self.gaps, self.normals = gaps, gaps.normal
        count = len(body.controls)
        moving = gaps.segment < count
        s, t = 1 - gaps.t, gaps.t
        weights = np.stack([s**3, 3 * s * s * t, 3 * s * t * t, t**3], -1)
        weights[:, 1] *= -1
        points = np.where(moving[..., None], body.controls[np.where(moving, gaps.segment, 0)], 0)
        used, index = np.unique(points, return_inverse=True)
        self._index: IntArray = index.reshape(points.shape)
        self._points = body.some(used)
        self._weights = weights * moving[..., None]
        self._letter = np.where(moving, gaps.shape, -1)
        self._fixed = np.zeros(self.normals.shape)
        if not moving.all():
            fixed = obstacles[np.where(moving, 0, gaps.segment - count)]
            self._fixed = np.einsum("csk,cskd->cd", weights * ~moving[..., None], fixed)

    def relative(self, place: Mapping[str, Array]) -> Array:
        """The first points as seen from the second ones, (C, 2)."""
        points = self._points.positions(place)[self._index]
        return np.einsum("csk,cskd->cd", self._weights, points) + self._fixed

    def jacobian(
        self, directions: Array, place: Mapping[str, Array], slices: Mapping[str, slice]
    ) -> Array:
        """Derivative (C, N) of the relative positions along directions (C, 2)."""
        jacobian = np.zeros((len(directions), max(part.stop for part in slices.values())))
        used = np.flatnonzero(directions.any(1))
        if not len(used):
            return jacobian
        index, letter, along = self._index[used], self._letter[used], directions[used]
        each = self._weights[used, ..., None] * along[:, None, None]
        if AXES in slices:
            moves = self._points.moves(place)[index]
            flat = each.reshape(len(used), 1, -1) @ moves.reshape(len(used), -1, moves.shape[-1])
            jacobian[used, slices[AXES]] = flat[:, 0]
        if OFFSETS in slices:
            start = slices[OFFSETS].start
            for side, sign in ((0, 1.0), (1, -1.0)):
                row = np.flatnonzero(letter[:, side] >= 0)
                for axis in range(2):
                    column = start + 2 * letter[row, side] + axis
                    jacobian[used[row], column] += sign * along[row, axis]
        if ROTATIONS in slices:
            slopes = (each * self._points.spins(place)[index]).sum((2, 3))
            for side in range(2):
                row = np.flatnonzero(letter[:, side] >= 0)
                column = slices[ROTATIONS].start + letter[row, side]
                jacobian[used[row], column] += slopes[row, side]
        return jacobian


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
        gaps = (self.touches.relative(place) * self.touches.normals).sum(1)
        return np.asarray(gaps - self.least)

    def force_at(self, place: Mapping[str, Array]) -> Array:
        """How strongly each contact presses, (C,)."""
        return np.sqrt(self.weight) * self.residual_at(place)

    def jacobian_at(self, place: Mapping[str, Array], slices: Mapping[str, slice]) -> Array:
        """Its derivative (C, N)."""
        beyond = self.residual_at(place) > 0
        directions = -np.sqrt(self.weight) * beyond[:, None] * self.touches.normals
        return self.touches.jacobian(directions, place, slices)


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
    def moves(
        self, weights: Array, place: Mapping[str, Array], slices: Mapping[str, slice]
    ) -> Array:
        """Their derivative, times weights (F,): (F, N)."""

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
        return self.moves(np.sqrt(self.limit * (root + SLIP) / 2) / root, place, slices)


@dataclass(frozen=True, eq=False)
class Sliding(Friction):
    """Coulomb friction of C contacts, which resists displacements along the outlines.

    Attributes
    ----------
    touches : Touches
    start : (C, 2) array
        Their relative positions at the start of the time step.
    """

    touches: Touches
    start: Array

    @property
    def along(self) -> Array:
        """Tangents of the outlines, (C, 2)."""
        return self.touches.normals @ QUARTER.T

    def moved(self, place: Mapping[str, Array]) -> Array:
        return np.asarray(((self.touches.relative(place) - self.start) * self.along).sum(1))

    def moves(
        self, weights: Array, place: Mapping[str, Array], slices: Mapping[str, slice]
    ) -> Array:
        return self.touches.jacobian(weights[:, None] * self.along, place, slices)


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

    def moves(
        self, weights: Array, place: Mapping[str, Array], slices: Mapping[str, slice]
    ) -> Array:
        jacobian = np.zeros((len(weights), max(part.stop for part in slices.values())))
        jacobian[:, slices[ROTATIONS]] = np.diag(self.arm * weights)
        return jacobian


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
