"""The linear model of a residual at an iterate, and the damped quadratic that a step minimises."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import Array
from .quadratic import ROUNDING, DenseQuadratic, LowRankQuadratic, Quadratic

EPSILON = float(np.finfo(float).eps)
HEAVY = 1e5
"""JᵀJ is avoided if rows differ in norm by more than this factor."""
FARTHEST = 1e100
"""A step that is longer is as good as one without bounds."""
SMALL = 24
"""With at most this many variables, the matrix JᵀJ is the quickest form of the model."""
LEAST_DAMPING, LEAST_GRADED_DAMPING = 1e-14, 1e-28
"""The least damping relative to the squared column norms. It must exceed the rounding errors of
JᵀJ, so that a rank-deficient matrix becomes regular. Without JᵀJ these errors are squared."""


@dataclass
class Model:
    """The model ‖r + J d‖² + Σ wᵢ (xᵢ + dᵢ − refᵢ)² of the cost after a step d.

    Attributes
    ----------
    jacobian : (m, n) array
        J. At a kink, each column belongs to the side to which the model applies.
    residual : (m,) array
        r.
    weights, pull : (n,) arrays
        The weights w of the proximity, and w (x − ref); zeros if there is none.
    low, high : (n,) arrays
        The range of a step: low ≤ 0 ≤ high.
    gradient : (n,) array
        Half the gradient of the cost at d = 0.
    columns : (n,) array
        The squared column norms of J, plus w.
    steepest : float
        The largest of them.
    is_finite : bool
        Whether J has neither NaN nor infinity.
    spread : float
        The ratio of the squared norms of a light row and the heaviest one, ≤ 1. The n heaviest
        rows count; a lighter row has little influence, because others decide in its place. A row
        that is lighter than the proximity counts as much as the proximity. One that no step within
        the range changes, apart from rounding errors, does not count.
    graded : bool
        Whether the spread is so small that JᵀJ would lose the light rows.
    latest : (n,) array, optional
        The latest step that was proposed within the whole range. Others with more or less damping
        mostly end at the same bounds.
    holds_limits : bool
        Whether slopes at kinks are limits, and not those at a small distance.
    """

    jacobian: Array
    residual: Array
    weights: Array
    pull: Array
    low: Array
    high: Array

    holds_limits = False

    def __post_init__(self) -> None:
        jacobian = self.jacobian
        m, n = jacobian.shape
        # On small arrays, calling dot takes half the time of the @ operator.
        self.gradient: Array = self.residual.dot(jacobian) + self.pull
        if m <= n:
            sizes = jacobian.dot(jacobian.T).diagonal()
        else:
            sizes = np.einsum("ij,ij->i", jacobian, jacobian)
        self.spread = _spread(sizes, n)
        if self.spread < HEAVY**-2:
            self.spread = _spread(self._relevant(sizes), n)
        self.graded = self.spread < HEAVY**-2
        self._matrix: Array | None = None
        self.latest: Array | None = None
        if self.graded or (n > SMALL and 2 * m <= n):
            squares = np.einsum("ij,ij->j", jacobian, jacobian)
            self.columns: Array = squares + self.weights
            self._moving = squares > 0
        else:
            self._matrix = jacobian.T.dot(jacobian)
            self._matrix.ravel()[:: n + 1] += self.weights
            self.columns = self._matrix.diagonal()
        # On short arrays, functions of Python are faster than reductions of NumPy.
        columns = self.columns.tolist()
        self.steepest: float = max(columns)
        self.is_finite = math.isfinite(sum(columns))
        self._rows = jacobian, self.residual
        if self.graded and m > n:
            self._rows = _compressed(jacobian, self.residual, sizes)

    def _relevant(self, sizes: Array) -> Array:
        """The squared row norms as far as they matter to a step, (m,); see Model.spread."""
        reach = np.minimum(np.maximum(-self.low, self.high), FARTHEST)
        change = abs(self.jacobian).dot(reach)
        matters = (sizes > 0) & (change > ROUNDING * abs(self.residual))
        return np.where(matters, np.maximum(sizes, self.weights.min()), 0.0)

    @property
    def least_damping(self) -> float:
        """The least damping relative to the squared column norms."""
        return LEAST_GRADED_DAMPING if self.graded else LEAST_DAMPING

    def damped(self, damping: Any) -> Quadratic:
        """Half the model plus ½ Σ dampingᵢ dᵢ², up to a constant.

        ``damping`` is a number > 0 or an array (n,).
        """
        if self._matrix is not None:
            return DenseQuadratic(_with_diagonal(self._matrix, damping), self.gradient)
        diagonal = self.weights + damping
        return LowRankQuadratic(*self._rows, diagonal, self.pull, self.graded, self._moving)

    def decrease(self, d: Array) -> float:
        """The decrease of the cost that the model predicts for a step d."""
        if self._matrix is not None:
            return -float(2 * self.gradient.dot(d) + d.dot(self._matrix.dot(d)))
        rows = self.jacobian.dot(d)
        return -float(2 * self.gradient.dot(d) + rows.dot(rows) + d.dot(self.weights * d))

    def rounding(self, x: Array) -> float:
        """The change of the cost that the rounding errors of x may cause."""
        errors = EPSILON * abs(self.jacobian).dot(abs(x))
        return float(errors.dot(errors + 2 * abs(self.residual)))


def _with_diagonal(matrix: Array, more: Any) -> Array:
    system = matrix.copy()
    system.ravel()[:: len(system) + 1] += more
    return system


def _spread(sizes: Array, n: int) -> float:
    """The ratio of the least and largest of the n largest squared row norms; see Model.spread."""
    if len(sizes) > n:
        sizes = np.partition(sizes, len(sizes) - n)[len(sizes) - n :]
    nonzero = [size for size in sizes.tolist() if size > 0]
    return min(nonzero) / max(nonzero) if nonzero else 1.0


def _compressed(jacobian: Array, residual: Array, sizes: Array) -> tuple[Array, Array]:
    """The sum of squares ‖r + J d‖² as n rows, up to a constant.

    Rounding errors of the heavy rows do not reach the light ones if the heavy rows come first.
    """
    order = np.argsort(-sizes)
    n = jacobian.shape[1]
    triangle = np.linalg.qr(np.column_stack([jacobian, residual])[order]).R
    return triangle[:n, :n], triangle[:n, n]
