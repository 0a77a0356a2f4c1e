r"""A text as a mechanical system: masses at its control points, and springs on its axes.

The kinetic energy is that of the control points, ½ Σ mₖ |ṗₖ|². The axes have inertia because
they move these points. The mass of a letter is spread along its outline: each segment passes an
equal share of it to its control points, in proportion to its length.

Within a letter the points move in few ways only: they are affine in the scalars γ. The *reduced
coordinates* q of a letter are its points in an orthonormal basis of these ways, scaled by the roots
of the masses. They keep all distances, so the kinetic energy is ½ |q̇|², with far fewer numbers.
Every point of an outline is linear in them, so a contact costs a row.

If letters can rotate, the basis contains every way together with the same one rotated by 90°. So a
rotation by φ maps reduced coordinates to cos φ q + sin φ B (I ⊗ J) Bᵀ q, where B is the basis and J
the quarter turn of the plane.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..arrays import Array, IntArray
from ..energy import Term
from ..energy.energy import Energy
from ..energy.rows import Derivative
from ..text import Text
from ..text.memo import Memo
from ..text.place import AXES, OFFSETS, ROTATIONS, Place
from ..text.points import AffinePoints, PointSet, RotatedPoints

LEAST_WAY = 1e-9
"""Ways to move with a smaller share of the largest singular value are rounding."""
BESIDE = 1e-6
"""Inertia at a kink is measured at this distance from it, on both sides."""
LEAST_INERTIA = 1e-6
"""Share of the largest inertia that every axis has at least, so that none is undetermined."""
LEAST_MASS = 1e-6
"""Share of the mean mass that every control point has at least, so that it is determined."""
QUARTER = np.array([[0.0, -1.0], [1.0, 0.0]])
"""The rotation of the plane by 90°, counterclockwise."""


class _Upright(NamedTuple):
    """Letters at some Θ, where the layout sets them, and derivatives by Θ.

    Attributes
    ----------
    own : (r,) array
        Reduced coordinates of the letters as seen from their origins.
    moves : (r, n) array
        Their derivative by the axis vector of their letter.
    origins : (l, 2) array
    origin_moves : (l, 2, p, n) array
    """

    own: Array
    moves: Array
    origins: Array
    origin_moves: Array


class _Coordinates(Term):
    """The coordinates of some points as residuals, which an :class:`Energy` compiles."""

    affine = True

    def __init__(self, points: PointSet) -> None:
        self._points = points

    def points(self, text: Text) -> PointSet:
        return self._points

    def residual(self, points: Array, theta: Array) -> Array:
        return points.ravel()

    def derivative(self, points: Array, theta: Array) -> Derivative:
        return Derivative(np.eye(points.size).reshape(points.size, *points.shape))


class Body:
    """The masses and reduced coordinates of a text.

    Parameters
    ----------
    text : Text
        At its rest state.
    mass : (l,) array
        Mass of each letter.
    positions : bool
        Whether the letters move freely, by their offsets.
    rotations : bool
        Whether they rotate freely, too.

    Attributes
    ----------
    free : tuple of str
        The free blocks of the text's place. If letters rotate, :class:`Inertia` adds their angles.
    rotates : bool
        Whether letters rotate.
    rows : list of slice
        The reduced coordinates of each letter.
    lift : (r, 2) array
        Derivative of the reduced coordinates by a translation of their letter.
    masses : (l,) array
        Mass of each letter; 0 for one without outlines.
    inertia : (p, n) array
        Mass that each axis moves, times the mean square of the motion in font units per unit of
        the axis.
    """

    def __init__(
        self, text: Text, mass: Array, positions: bool = False, rotations: bool = False
    ) -> None:
        self.text, self.word = text, text.word
        self.rotates = rotations
        self._turned = rotations or bool(text.rotations.any())
        self.free = (AXES, OFFSETS) if positions else (AXES,)
        self.controls = self.word.contours.segments
        self._positions: Memo[Array] = Memo()
        self._reduced: Memo[Array] = Memo()
        self._moves: Memo[Array] = Memo(8)
        self._uprights: Memo[_Upright] = Memo(8)
        ends = self.word.first_point
        self.slices = [slice(a, b) for a, b in pairwise(ends)]
        self._roots = np.sqrt(self._masses(mass))
        self._bases = [self._basis(own) for own in self.slices]
        self._lifts = [
            (basis / np.repeat(self._roots[own], 2)).T
            for basis, own in zip(self._bases, self.slices, strict=True)
        ]
        stops = np.cumsum([0, *(len(basis) for basis in self._bases)])
        self.rows = [slice(a, b) for a, b in pairwise(stops)]
        self.lift = np.concatenate([self._translation(i) for i in range(len(self.rows))])
        self.letter = np.repeat(np.arange(len(self.rows)), np.diff(stops))
        self.masses = self.dot(self.lift[:, 0], self.lift[:, 0])
        if self._turned:
            self._quarters = [self._quarter(basis) for basis in self._bases]
        self._vector = np.zeros_like(self.letter) if self.word.shared else self.letter
        self._deltas: Array | None = None
        self._origins = self.word.starts(np.arange(len(self.rows)))
        if isinstance(self.word.outline, AffinePoints):
            self._reduce(self.word.outline)
        self.inertia = self._inertia()

    def _masses(self, mass: Array) -> Array:
        """The mass of every control point, (K,)."""
        points = self.word.outline.positions(self.text.place)[self.controls]
        length = np.hypot(*np.moveaxis(np.diff(points, axis=1), -1, 0)).sum(1)
        shares = np.zeros(len(self.word.outline.letter))
        np.add.at(shares, self.controls, np.repeat(length[:, None] / 4, 4, axis=1))
        letter = self.word.outline.letter
        count = np.bincount(letter, minlength=len(mass))
        mean = np.bincount(letter, shares, len(mass)) / np.maximum(count, 1)
        shares = np.maximum(shares, LEAST_MASS * np.maximum(mean, 1.0)[letter])
        return shares * mass[letter] / np.bincount(letter, shares, len(mass))[letter]

    def _basis(self, own: slice) -> Array:
        """An orthonormal basis (r, 2 k) of the ways in which a letter's points move."""
        roots = self._roots[own]
        size = 2 * len(roots)
        points = self.word.outline
        if not isinstance(points, AffinePoints) or not size:
            return np.eye(size)
        ways = np.concatenate([points.deltas[own], points.base[own, :, None]], axis=2)
        if self._turned:
            ways = np.concatenate([ways, QUARTER @ ways], axis=2)
        shifts = np.broadcast_to(np.eye(2), (len(roots), 2, 2))
        ways = np.concatenate([ways, shifts], axis=2)
        ways = (roots[:, None, None] * ways).reshape(size, -1)
        scale = np.linalg.norm(ways, axis=0)
        left, values, _ = np.linalg.svd(ways / np.where(scale > 0, scale, 1), full_matrices=False)
        return np.ascontiguousarray(left[:, values > LEAST_WAY * values[0]].T)

    @staticmethod
    def _quarter(basis: Array) -> Array:
        """B (I ⊗ J) Bᵀ, (r, r): a quarter turn of the letter in reduced coordinates."""
        size = len(basis)
        turned = basis.reshape(size, basis.shape[1] // 2, 2) @ QUARTER.T
        return basis @ turned.reshape(size, basis.shape[1]).T

    def _translation(self, letter: int) -> Array:
        roots = self._roots[self.slices[letter]]
        along = (roots[:, None, None] * np.eye(2)).reshape(-1, 2)
        return self._bases[letter] @ along

    def _reduce(self, points: AffinePoints) -> None:
        """The reduced coordinates as functions of the scalars and of the letters' origins."""
        regions = points.deltas.shape[2]
        deltas, fixed = np.zeros((len(self.lift), regions)), np.zeros(len(self.lift))
        for basis, own, rows in zip(self._bases, self.slices, self.rows, strict=True):
            weighted = self._roots[own, None, None] * points.deltas[own]
            deltas[rows] = basis @ weighted.reshape(-1, regions)
            fixed[rows] = basis @ (self._roots[own, None] * points.base[own]).ravel()
        self._deltas, self._fixed = deltas, fixed
        self._compiled = Energy(self.text, [_Coordinates(self._origins)])

    def _inertia(self) -> Array:
        """See the attributes of the class; the mean of both sides of a kink."""
        place, theta = self.text.place, self.text.coordinates
        lower, upper = self.text.font.bounds
        found = []
        for side in (-BESIDE, BESIDE):
            beside = np.clip(theta + side, lower, upper)
            found.append((self._reduced_by_axes({**place, AXES: beside}) ** 2).sum(0))
        inertia = np.maximum(*found).reshape(theta.shape)
        return np.maximum(inertia, LEAST_INERTIA * max(float(inertia.max()), 1.0))

    def start(self, text: Text) -> Place:
        """The place of a text with all unknowns of the body."""
        angles = {ROTATIONS: text.rotations} if self.rotates else {}
        return Place({**text.place, **angles})

    def _key(self, place: Mapping[str, Array]) -> bytes:
        """The blocks of a place that determine the control points, as bytes."""
        turned = self._turned and ROTATIONS in place
        blocks = (AXES, OFFSETS, ROTATIONS) if turned else (AXES, OFFSETS)
        return b"".join([place[name].tobytes() for name in blocks])

    def positions(self, place: Mapping[str, Array]) -> Array:
        """All control points at a place, (K, 2)."""
        return self._positions.get(self._key(place), lambda: self.points(self.reduced_at(place)))

    def reduced(self, positions: Array) -> Array:
        """The reduced coordinates (r,) of control points (K, 2)."""
        weighted = self._roots[:, None] * positions
        parts = [b @ weighted[own].ravel() for b, own in zip(self._bases, self.slices, strict=True)]
        return np.concatenate(parts)

    def points(self, values: Array) -> Array:
        """Vectors at all control points (K, 2), from reduced coordinates (r,)."""
        parts = [m @ values[rows] for m, rows in zip(self._lifts, self.rows, strict=True)]
        return np.concatenate(parts).reshape(-1, 2)

    def rows_of(self, points: IntArray, vectors: Array) -> Array:
        """Rows (C, r) whose product with reduced coordinates is Σ vectors · control points.

        Parameters
        ----------
        points : (C, q) int array
        vectors : (C, q, 2) array
        """
        found = np.zeros((len(points), len(self.lift)))
        # With so few points in a row, a product with the whole matrix would take longer.
        for own, rows, lift in zip(self.slices, self.rows, self._lifts, strict=True):
            inside = (points >= own.start) & (points < own.stop)
            at = inside.any(1).nonzero()[0]
            if not len(at):
                continue
            index = np.where(inside, points - own.start, 0)[at]
            weights = np.where(inside[..., None], vectors, 0.0)[at].reshape(len(at), 1, -1)
            ways = lift.reshape(-1, 2, lift.shape[1])[index]
            found[at, rows] = (weights @ ways.reshape(len(at), -1, lift.shape[1]))[:, 0]
        return found

    def reduced_at(self, place: Mapping[str, Array]) -> Array:
        """The reduced coordinates (r,) at a place."""
        return self._reduced.get(self._key(place), lambda: self._reduced_at(place))

    def _outline(self, place: Mapping[str, Array]) -> PointSet:
        """The control points of letters with the angles of a place."""
        points = self.word.outline
        if not self._turned:
            return points
        return RotatedPoints.of(points, place.get(ROTATIONS, self.text.rotations))

    def _reduced_at(self, place: Mapping[str, Array]) -> Array:
        if self._deltas is None:
            return self.reduced(self._outline(place).positions(place))
        upright = self._upright(place[AXES])
        own = upright.own
        if self._turned:
            own = self.rotated(own, place.get(ROTATIONS, self.text.rotations))
        return own + self.force(upright.origins + place[OFFSETS])

    def _upright(self, theta: Array) -> _Upright:
        """The letters at Θ (p, n), before they are displaced and rotated."""
        return self._uprights.get(theta.tobytes(), lambda: self._upright_at(theta))

    def _upright_at(self, theta: Array) -> _Upright:
        assert self._deltas is not None
        gamma, slopes = self.word.regions.scalars_and_jacobian(theta)
        own = self._fixed + (self._deltas * gamma[self._vector]).sum(1)
        moves = (self._deltas[:, None] @ slopes[self._vector])[:, 0]
        x = theta.ravel()
        origins = self._compiled.residual(x).reshape(-1, 2) - self.text.place[OFFSETS]
        by_theta = self._compiled.jacobian(x).reshape(*origins.shape, *theta.shape)
        return _Upright(own, moves, origins, by_theta)

    def reduced_moves(self, place: Mapping[str, Array], slices: Mapping[str, slice]) -> Array:
        """Derivative (r, N) of the reduced coordinates by the free unknowns; read only."""
        key = self._key(place), *slices
        return self._moves.get(key, lambda: self._reduced_moves(place, slices))

    def _reduced_moves(self, place: Mapping[str, Array], slices: Mapping[str, slice]) -> Array:
        jacobian = np.zeros((len(self.lift), max(part.stop for part in slices.values())))
        if AXES in slices:
            jacobian[:, slices[AXES]] = self._reduced_by_axes(place)
        if OFFSETS in slices:
            start = slices[OFFSETS].start
            row = np.arange(len(self.lift))
            for axis in range(2):
                jacobian[row, start + 2 * self.letter + axis] = self.lift[:, axis]
        if ROTATIONS in slices:
            own = self.reduced_at(place) - self.force(self._origins.positions(place))
            column = slices[ROTATIONS].start + self.letter
            jacobian[np.arange(len(own)), column] = self.quarter(own)
        jacobian.flags.writeable = False
        return jacobian

    def quarter(self, values: Array) -> Array:
        """Vectors of letters (r, ...) in reduced coordinates, rotated by 90°."""
        parts = [m @ values[own] for m, own in zip(self._quarters, self.rows, strict=True)]
        return np.concatenate(parts)

    def rotated(self, values: Array, angles: Array) -> Array:
        """Vectors of letters (r, ...) in reduced coordinates, rotated by the letters' angles."""
        shape = (-1,) + (1,) * (values.ndim - 1)
        cos, sin = (f(angles)[self.letter].reshape(shape) for f in (np.cos, np.sin))
        return np.asarray(cos * values + sin * self.quarter(values))

    def _reduced_by_axes(self, place: Mapping[str, Array]) -> Array:
        if self._deltas is None:
            moves = self._outline(place).positions_and_jacobian(place)[1]
            weighted = np.repeat(self._roots, 2)[:, None] * moves.reshape(2 * len(moves), -1)
            parts = [
                b @ weighted[2 * own.start : 2 * own.stop]
                for b, own in zip(self._bases, self.slices, strict=True)
            ]
            return np.concatenate(parts)
        upright = self._upright(place[AXES])
        moves = (self.lift[:, :, None, None] * upright.origin_moves[self.letter]).sum(1)
        within = upright.moves
        if self._turned:
            within = self.rotated(within, place.get(ROTATIONS, self.text.rotations))
        moves[np.arange(len(moves)), self._vector] += within
        return moves.reshape(len(moves), -1)

    def force(self, acceleration: Array) -> Array:
        """Accelerations of the letters (l, 2) in reduced coordinates, (r,)."""
        return (self.lift * acceleration[self.letter]).sum(1)

    def dot(self, first: Array, second: Array) -> Array:
        """The scalar product of vectors (r,) in the part of each letter, (l,)."""
        return np.asarray(np.bincount(self.letter, first * second, len(self.rows)), dtype=float)

    def means(self, values: Array) -> Array:
        """The mean displacement of each letter, (l, 2), by a vector (r,)."""
        x, y = self.lift.T
        masses = np.where(self.masses > 0, self.masses, 1.0)
        return np.stack([self.dot(x, values), self.dot(y, values)], 1) / masses[:, None]

    def translation(self, values: Array) -> Array:
        """The part of a vector (r,) that moves letters as a whole, (r,)."""
        return self.force(self.means(values))

    def by_letter(self, values: Array) -> Array:
        """Largest length of vectors at the control points (K, 2) in each letter, (l,)."""
        lengths = np.hypot(*values.T)
        return np.array([lengths[own].max(initial=0.0) for own in self.slices])
