r"""A text as a mechanical system: masses at its control points, and springs on its axes.

The kinetic energy is that of the control points, ½ Σ mₖ |ṗₖ|². The axes have inertia because
they move these points. The mass of a letter is spread along its outline: each segment passes an
equal share of it to its control points, in proportion to its length.

Within a letter the points move in few ways only: they are affine in the scalars γ. The *reduced
coordinates* q of a letter are its points in an orthonormal basis of these ways, scaled by the roots
of the masses. They keep all distances, so the kinetic energy is ½ |q̇|², with far fewer numbers.

If letters can rotate, the basis contains every way together with the same one rotated by 90°. So a
rotation by φ maps reduced coordinates to cos φ q + sin φ B (I ⊗ J) Bᵀ q, where B is the basis and J
the quarter turn of the plane.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from ..arrays import Array, IntArray
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
QUARTER = np.array([[0.0, -1.0], [1.0, 0.0]])
"""The rotation of the plane by 90°, counterclockwise."""


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
        self.points = self.word.outline
        if self._turned:
            self.points = RotatedPoints.of(self.points, text.rotations)
        self.free = (AXES, OFFSETS) if positions else (AXES,)
        self.controls = self.word.contours.segments
        self._positions: Memo[Array] = Memo()
        self._reduced: Memo[Array] = Memo()
        self._moves: Memo[Array] = Memo(8)
        ends = self.word.first_point
        self.slices = [slice(a, b) for a, b in pairwise(ends)]
        self._roots = np.sqrt(self._masses(mass))
        self._bases = [self._basis(own) for own in self.slices]
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
        shares = np.zeros(len(self.points.letter))
        np.add.at(shares, self.controls, np.repeat(length[:, None] / 4, 4, axis=1))
        letter = self.points.letter
        total = np.bincount(letter, shares, len(mass))
        return shares * (mass / np.where(total > 0, total, 1.0))[letter]

    def _basis(self, own: slice) -> Array:
        """An orthonormal basis (r, 2 k) of the ways in which a letter's points move."""
        roots = self._roots[own]
        size = 2 * len(roots)
        points = self.word.outline
        if not isinstance(points, AffinePoints) or not size:
            return np.eye(size)
        ways = points.deltas[own]
        if self._turned:
            ways = np.concatenate([ways, points.base[own, :, None]], axis=2)
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
        turned = basis.reshape(size, -1, 2) @ QUARTER.T
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

    def positions(self, place: Mapping[str, Array]) -> Array:
        """All control points at a place, (K, 2)."""
        return self._positions.get(_key(place), lambda: _at(self.points, place).positions(place))

    def some(self, index: IntArray) -> Some:
        """Some of the control points, to be evaluated by themselves."""
        return Some(self.points, index)

    def reduced(self, positions: Array) -> Array:
        """The reduced coordinates (r,) of control points (K, 2)."""
        weighted = self._roots[:, None] * positions
        parts = [b @ weighted[own].ravel() for b, own in zip(self._bases, self.slices, strict=True)]
        return np.concatenate(parts)

    def velocities(self, values: Array) -> Array:
        """The velocities of all control points (K, 2), from those of reduced coordinates (r,)."""
        parts = [values[rows] @ b for b, rows in zip(self._bases, self.rows, strict=True)]
        roots = np.where(self._roots > 0, self._roots, np.inf)
        return np.asarray(np.concatenate(parts).reshape(-1, 2) / roots[:, None])

    def reduced_at(self, place: Mapping[str, Array]) -> Array:
        """The reduced coordinates (r,) at a place."""
        return self._reduced.get(_key(place), lambda: self._reduced_at(place))

    def _reduced_at(self, place: Mapping[str, Array]) -> Array:
        if self._deltas is None:
            return self.reduced(self.positions(place))
        gamma = self.word.regions.scalars(place[AXES])
        own = self._fixed + (self._deltas * gamma[self._vector]).sum(1)
        if self._turned:
            own = self.rotated(own, place.get(ROTATIONS, self.text.rotations))
        return own + self.force(self._origins.positions(place))

    def reduced_moves(self, place: Mapping[str, Array], slices: Mapping[str, slice]) -> Array:
        """Derivative (r, N) of the reduced coordinates by the free unknowns; read only."""
        key = _key(place), tuple(slices)
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
            moves = _at(self.points, place).positions_and_jacobian(place)[1]
            weighted = np.repeat(self._roots, 2)[:, None] * moves.reshape(2 * len(moves), -1)
            parts = [
                b @ weighted[2 * own.start : 2 * own.stop]
                for b, own in zip(self._bases, self.slices, strict=True)
            ]
            return np.concatenate(parts)
        _, slopes = self.word.regions.scalars_and_jacobian(place[AXES])
        origins = self._origins.positions_and_jacobian(place)[1]
        moves = (self.lift[:, :, None, None] * origins[self.letter]).sum(1)
        within = (self._deltas[:, None] @ slopes[self._vector])[:, 0]
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

    def translation(self, values: Array) -> Array:
        """The part of a vector (r,) that moves letters as a whole, (r,)."""
        x, y = self.lift.T
        masses = np.where(self.masses > 0, self.masses, 1.0)
        means = np.stack([self.dot(x, values), self.dot(y, values)], 1) / masses[:, None]
        return self.force(means)

    def by_letter(self, values: Array) -> Array:
        """Largest length of vectors at the control points (K, 2) in each letter, (l,)."""
        lengths = np.hypot(*values.T)
        return np.array([lengths[own].max(initial=0.0) for own in self.slices])


class Some:
    """Some control points of a text: their positions and moves at a place."""

    def __init__(self, points: PointSet, index: IntArray) -> None:
        self._points, self._index = points, index
        self._latest: Memo[Array] = Memo()
        self._moves: Memo[Array] = Memo()
        upright = points.points if isinstance(points, RotatedPoints) else points
        if isinstance(upright, AffinePoints):
            names = ("letter", "origin", "base", "deltas")
            self._points = replace(upright, **{n: getattr(upright, n)[index] for n in names})
            self._index = np.arange(len(index))
            if isinstance(points, RotatedPoints):
                self._points = RotatedPoints.of(self._points, points.angles)

    def positions(self, place: Mapping[str, Array]) -> Array:
        """Positions (p, 2)."""
        return self._latest.get(_key(place), lambda: self._at(place).positions(place)[self._index])

    def moves(self, place: Mapping[str, Array]) -> Array:
        """Derivative by the axes, (p, 2, p · n)."""
        return self._moves.get(_key(place), lambda: self._moves_at(place))

    def spins(self, place: Mapping[str, Array]) -> Array:
        """Derivative by the angle of each point's letter, (p, 2)."""
        points = self._at(place)
        assert isinstance(points, RotatedPoints)
        return points.spins(place[AXES])[self._index]

    def _at(self, place: Mapping[str, Array]) -> PointSet:
        return _at(self._points, place)

    def _moves_at(self, place: Mapping[str, Array]) -> Array:
        moves = self._at(place).positions_and_jacobian(place)[1][self._index]
        return np.asarray(moves.reshape(len(moves), 2, place[AXES].size))


def _at(points: PointSet, place: Mapping[str, Array]) -> PointSet:
    """Points whose letters have the angles of a place."""
    if isinstance(points, RotatedPoints) and ROTATIONS in place:
        return replace(points, angles=place[ROTATIONS])
    return points


def _key(place: Mapping[str, Any]) -> bytes:
    blocks = (place[name] for name in (AXES, OFFSETS, ROTATIONS) if name in place)
    return b"".join(block.tobytes() for block in blocks)
