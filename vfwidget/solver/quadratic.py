r"""Convex quadratics over boxes: the step of a bounded solver.

One algorithm, :func:`minimise_over_box`, works on two kinds of quadratic. :class:`DenseQuadratic`
holds its matrix. :class:`LowRankQuadratic` is a sum of few squares plus a diagonal; it solves an
(r, r) system and forms no (n, n) matrix (the Woodbury identity).
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple, Protocol, cast

import numpy as np

from ..arrays import Array, BoolArray, between, holds_anywhere, holds_everywhere

MANY = 24
"""With more equations than this, it takes less time to look for variables at their bounds than to
solve a system that ignores the bounds, even if there are none."""
ROUNDING = 1e-13
"""A slope counts as zero if it is smaller than this share of the terms that add up to it."""


class Quadratic(Protocol):
    """A strictly convex quadratic of d, (n,)."""

    @property
    def equations(self) -> int:
        """The number of equations of a system that gives a minimiser, at most."""

    def minimiser(self) -> Array:
        """The unconstrained minimiser, (n,)."""

    def slope(self, d: Array) -> Array:
        """The gradient at d, (n,). Entries that hold only rounding errors are 0."""

    def newton(self, d: Array, free: BoolArray) -> tuple[Array, Array]:
        """The step from d to the minimiser over the free variables, and the slope after it."""

    def value(self, d: Array) -> float:
        """The value at d."""

    def with_linear(self, linear: Array) -> Quadratic:
        """The quadratic with the same second derivatives and this gradient, (n,), at d = 0."""


class DenseQuadratic(NamedTuple):
    """½ dᵀ A d + gᵀ d.

    Attributes
    ----------
    matrix : (n, n) array
        A, symmetric and positive definite.
    gradient : (n,) array
        g.
    """

    matrix: Array
    gradient: Array

    @property
    def equations(self) -> int:
        """The number of equations of a system that gives a minimiser, at most."""
        return len(self.gradient)

    def minimiser(self) -> Array:
        """The unconstrained minimiser, (n,)."""
        return _solve(self.matrix, -self.gradient)

    def slope(self, d: Array) -> Array:
        """The gradient at d, (n,). Entries that hold only rounding errors are 0."""
        return _without_noise(self.gradient + self.matrix.dot(d), self._size)

    @property
    def _size(self) -> float:
        """The size of the terms that add up to a slope."""
        return max(map(abs, self.gradient.tolist()))

    def newton(self, d: Array, free: BoolArray) -> tuple[Array, Array]:
        """The step from d to the minimiser over the free variables, and the slope after it."""
        at = free.nonzero()[0]
        slope = self.gradient + self.matrix.dot(d)
        step = np.zeros(len(d))
        step[at] = _solve(self.matrix[at[:, None], at], -slope[at])
        slope = _without_noise(slope + self.matrix.dot(step), self._size)
        slope[at] = 0.0
        return step, slope

    def value(self, d: Array) -> float:
        """The value at d."""
        return float(d.dot(self.matrix.dot(d)) / 2 + self.gradient.dot(d))

    def with_linear(self, linear: Array) -> Quadratic:
        """The quadratic with the same second derivatives and this gradient, (n,), at d = 0."""
        return self._replace(gradient=linear)


class LowRankQuadratic(NamedTuple):
    """½ ‖J d + r‖² + ½ Σ Dᵢ dᵢ² + bᵀ d, with few rows in J.

    Attributes
    ----------
    jacobian : (r, n) array
        J. Its rows may differ in size by many orders of magnitude.
    residual : (r,) array
    diagonal : (n,) array
        D > 0.
    linear : (n,) array
        b.
    graded : bool
        Whether the rows of J differ in size by orders of magnitude.
    moving : (n,) array of bool, or True
        Which columns of J may be nonzero. In a text whose letters have axes of their own, many
        axes move no point that counts. Default: all.

    Notes
    -----
    The step over the free variables is −D⁻¹ (s + Jᵀ y), where s = b + D d, and y solves
    (I + J D⁻¹ Jᵀ) y = r + J d − J D⁻¹ s. The vector y is also the residual after the step. Fewer
    free variables than rows take the smaller system of :class:`DenseQuadratic`. Both systems
    square the sizes of the rows, and light rows disappear behind heavy ones if those are many
    orders of magnitude larger. The singular values of J D^(−1/2) avoid that.
    """

    jacobian: Array
    residual: Array
    diagonal: Array
    linear: Array
    graded: bool = False
    moving: BoolArray | bool = True

    @property
    def equations(self) -> int:
        """The number of equations of a system that gives a minimiser, at most."""
        return len(self.residual)

    def minimiser(self) -> Array:
        """The unconstrained minimiser, (n,)."""
        return self._solve(self.residual, self.linear)[0]

    def slope(self, d: Array) -> Array:
        """The gradient at d, (n,). Entries that hold only rounding errors are 0."""
        rows = self.residual + self.jacobian.dot(d)
        size = abs(self.residual) + abs(self.jacobian).dot(abs(d))
        return self._gradient(rows, size, self.linear + self.diagonal * d)

    def newton(self, d: Array, free: BoolArray) -> tuple[Array, Array]:
        """The step from d to the minimiser over the free variables, and the slope after it."""
        at = (free & self.moving).nonzero()[0]
        rows, rest = self.residual + self.jacobian.dot(d), self.linear + self.diagonal * d
        own, diagonal = self.jacobian.take(at, 1), self.diagonal.take(at)
        of_free = LowRankQuadratic(own, self.residual, diagonal, self.linear, self.graded)
        step = np.where(free, -rest / self.diagonal, 0.0)
        step[at], rows = of_free._solve(rows, rest.take(at))
        after = self._gradient(rows, abs(rows), rest + self.diagonal * step)
        return step, np.where(free, 0.0, after)

    def value(self, d: Array) -> float:
        """The value at d."""
        rows = self.residual + self.jacobian.dot(d)
        return float(rows.dot(rows) / 2 + d.dot(self.diagonal * d / 2 + self.linear))

    def with_linear(self, linear: Array) -> Quadratic:
        """The quadratic with the same second derivatives and this gradient, (n,), at d = 0."""
        return self._replace(residual=np.zeros_like(self.residual), linear=linear)

    def _solve(self, rows: Array, rest: Array) -> tuple[Array, Array]:
        """The step, (n,), from where J d + r and b + D d have these values; J d + r after it."""
        if self.graded:
            root = 1 / np.sqrt(self.diagonal)
            # With fewer variables than rows, u is square and holds the rows that no step changes.
            u, sizes, v = np.linalg.svd(self.jacobian * root, len(rest) < len(rows))
            after, moved = rows.dot(u), slice(len(sizes))
            after[moved] -= sizes * v.dot(root * rest)
            after[moved] /= 1 + sizes**2
            return -root * (root * rest + (sizes * after[moved]).dot(v)), u.dot(after)
        if len(rest) < len(rows):
            matrix = self.jacobian.T.dot(self.jacobian)
            matrix.ravel()[:: len(matrix) + 1] += self.diagonal
            step = _solve(matrix, -(rows.dot(self.jacobian) + rest))
            return step, rows + self.jacobian.dot(step)
        # BLAS forms half of the product of a matrix with its own transpose.
        root = 1 / np.sqrt(self.diagonal)
        scaled = self.jacobian * root
        small = scaled.dot(scaled.T)
        small.ravel()[:: len(small) + 1] += 1.0
        y = _solve(small, rows - scaled.dot(root * rest))
        return -root * (root * rest + y.dot(scaled)), y

    def _gradient(self, rows: Array, size: Array, rest: Array) -> Array:
        """Jᵀ rows + rest, where the rows are sums of terms of this size."""
        terms = size.dot(abs(self.jacobian)) + abs(rest)
        return _without_noise(rows.dot(self.jacobian) + rest, terms)


def _solve(matrix: Array, vector: Array) -> Array:
    """The solution (n,) of a system with a symmetric positive definite matrix.

    Systems of one and two equations are solved here, because NumPy's function takes several times
    as long to start.
    """
    if len(vector) == 1:
        return vector / matrix[0]
    if len(vector) == 2:
        (a, b), (_, d) = matrix.tolist()
        first, second = vector.tolist()
        pivot = d - b * b / a if a > 0 else 0.0
        # Rounding errors may spoil a pivot.
        if pivot > 0:
            second = (second - b / a * first) / pivot
            return np.array([(first - b * second) / a, second])
    return cast(Array, np.linalg.solve(matrix, vector))


def _without_noise(slope: Array, terms: Any) -> Array:
    kept: Array = np.where(abs(slope) > ROUNDING * terms, slope, 0.0)
    return kept


def minimise_over_box(
    quadratic: Quadratic, low: Array, high: Array, start: Array | None = None
) -> tuple[Array, bool]:
    """Minimise a quadratic over low ≤ d ≤ high, where low ≤ 0 ≤ high.

    Parameters
    ----------
    quadratic : Quadratic
    low, high : (n,) arrays
    start : (n,) array, optional
        A point of the box from which the search begins, with the variables at bounds fixed. The
        minimiser of a similar quadratic saves most of the work. Default: 0.

    Returns
    -------
    (n,) array
        The minimiser.
    bool
        False if this is known to be the unconstrained minimiser.

    Notes
    -----
    Projected Newton (Bertsekas 1982) on an active set. If the Newton step of the free variables
    leaves the box, the variables that reach their bounds on the way are fixed, as many at once as
    lower the quadratic, and the others take the Newton step of their own system. At the minimiser
    of the free variables, those that the slope does not hold at their bounds are released.
    """
    d, free, lowest = np.zeros(len(low)), None, math.inf
    if start is not None:
        d, free = start, (start > low) & (start < high)
    elif quadratic.equations > MANY or 0.0 in low.tolist() or 0.0 in high.tolist():
        free = ~_held(d, quadratic.slope(d), low, high)
    if free is None or holds_everywhere(free):
        new = quadratic.minimiser()
        leaves = (new < low) | (new > high)
        if not holds_anywhere(leaves):
            return new, False
        d, reached = _toward(quadratic, d, new - d, leaves, low, high)
        free = ~reached
    for _ in range(10 + 4 * len(d)):
        step, slope = quadratic.newton(d, free)
        new = d + step
        leaves = (new < low) | (new > high)
        if not holds_anywhere(leaves):
            released = ~free & ~_held(new, slope, low, high)
            last = not holds_anywhere(released)
            if last and lowest == math.inf:
                return new, True
            value = quadratic.value(new)
            if value >= lowest:
                # Releasing variables did not help: their slopes were only rounding errors.
                break
            d, lowest = new, value
            if last:
                break
            free |= released
            continue
        d, reached = _toward(quadratic, d, step, leaves, low, high)
        free &= ~reached
    return d, True


def _held(d: Array, slope: Array, low: Array, high: Array) -> BoolArray:
    """Which variables, (n,), are at a bound, and would pass it to lower the quadratic."""
    held: BoolArray = ((d <= low) & (slope >= 0)) | ((d >= high) & (slope <= 0))
    return held


def _toward(
    quadratic: Quadratic, d: Array, step: Array, leaves: BoolArray, low: Array, high: Array
) -> tuple[Array, BoolArray]:
    """Where a step that leaves the box ends, and which variables reach their bound on the way.

    Those of the variables that leave the box stay at the bounds that they reach. The step is taken
    as a whole if that lowers the quadratic. Otherwise it ends where half as many variables have
    reached their bounds, and so on; as far as the first bound it surely lowers the quadratic.
    """
    value, clipped = quadratic.value(d), between(d + step, low, high)
    if quadratic.value(clipped) < value:
        return clipped, leaves
    at = leaves.nonzero()[0]
    # Rounding may put a bound that the step passes just beyond its end.
    shares = np.minimum((clipped - d)[at] / step[at], 1.0)
    passed, count = np.sort(shares), len(at)
    while True:
        count //= 2
        share = passed[max(count, 1) - 1]
        reached = np.zeros_like(leaves)
        reached[at] = shares <= share
        new = np.where(reached, clipped, d + share * step)
        if count == 0 or quadratic.value(new) < value:
            return new, reached
