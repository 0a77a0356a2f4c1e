"""Outlines put together from parts that are placed, shown and varied each in its own way."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np

from ..arrays import Array, BoolArray, IntArray, like, namespace
from .composed import Coordinates
from .conditions import Condition
from .varying import Affine, Varying

PARAMETERS = (
    *("translate_x", "translate_y", "rotation", "scale_x", "scale_y", "skew_x", "skew_y"),
    *("center_x", "center_y"),
)
"""Of a transformation, in order; angles are in radians."""


class Replaced(Coordinates):
    """Coordinates of which some are replaced by values that vary.

    Parameters
    ----------
    base : Coordinates
        Of shape (n',) over n axes.
    axes : (a,) int array
        Which coordinates are replaced.
    values : Varying
        Of shape (a,) over the same n axes. Values beyond -1 … 1 are clamped, so that outlines stay
        continuous. HarfBuzz drops all regions there, which no font can intend.
    """

    def __init__(self, base: Coordinates, axes: IntArray, values: Varying) -> None:
        self.base, self.axes, self.values = base, axes, values
        self.shape = base.shape

    @cached_property
    def _spread(self) -> Array:
        """A matrix (n', a) that puts each value in its place."""
        return (np.arange(self.shape[0])[:, None] == self.axes).astype(float)

    @cached_property
    def _kept(self) -> Array:
        """1 where a coordinate is not replaced, else 0, (n',)."""
        return 1 - self._spread.any(1).astype(float)

    @property
    def axis_count(self) -> int:
        """See :attr:`Varying.axis_count`."""
        return self.base.axis_count

    @property
    def breakpoints(self) -> list[Array]:
        """See :attr:`Varying.breakpoints`."""
        return _union([self.base, self.values])

    @property
    def unchanged(self) -> BoolArray:
        """See :attr:`Coordinates.unchanged`."""
        return self.base.unchanged & (self._kept > 0)

    def value(self, w: Any) -> Any:
        """See :meth:`Varying.value`."""
        spread, kept = like(self._spread, w), like(self._kept, w)
        return self.base.value(w) * kept + self.values.value(w).clip(-1, 1) @ spread.T

    def value_and_jacobian(self, w: Any, toward: Any = None) -> tuple[Any, Any]:
        """See :meth:`Varying.value_and_jacobian`."""
        spread, kept = like(self._spread, w), like(self._kept, w)
        base, slopes = self.base.value_and_jacobian(w, toward)
        values, own = self.values.value_and_jacobian(w, toward)
        own = own * ((values >= -1) & (values <= 1))[..., None]
        value = base * kept + values.clip(-1, 1) @ spread.T
        return value, slopes * kept[..., None] + spread @ own


class Combined(Varying):
    """A quantity that is computed from others.

    Parameters
    ----------
    parts : Varying
        At least one.
    """

    def __init__(self, *parts: Varying) -> None:
        self.parts = parts

    @property
    def axis_count(self) -> int:
        """See :attr:`Varying.axis_count`."""
        return self.parts[0].axis_count

    @property
    def breakpoints(self) -> list[Array]:
        """See :attr:`Varying.breakpoints`."""
        return _union(self.parts)

    @property
    def nbytes(self) -> int:
        """Memory of the quantity's arrays, in bytes."""
        return sum(part.nbytes for part in self.parts)


class Transformation(Combined):
    """An affine map p ↦ A (p - c) + c + t as the matrix [A | b], (2, 3).

    Parameters
    ----------
    parameters : Varying
        Of shape (9,), see :data:`PARAMETERS`. A = rotation · scale · skew.
    """

    shape = (2, 3)

    def __init__(self, parameters: Varying) -> None:
        super().__init__(parameters)
        self.parameters = parameters

    def value(self, w: Any) -> Any:
        """See :meth:`Varying.value`."""
        t = self.parameters.value(w)
        (matrix,) = _matrices(t)[:1]
        return _beside(matrix, t[..., 7:9] + t[..., 0:2] - _apply(matrix, t[..., 7:9]))

    def value_and_jacobian(self, w: Any, toward: Any = None) -> tuple[Any, Any]:
        """See :meth:`Varying.value_and_jacobian`."""
        xp = namespace(w)
        t, slopes = self.parameters.value_and_jacobian(w, toward)
        center = t[..., 7:9]
        matrix, *derivatives = _matrices(t)
        value = _beside(matrix, center + t[..., 0:2] - _apply(matrix, center))
        # By each of the nine parameters, (..., 2, 3, 9).
        none, eye = xp.zeros_like(matrix), like(np.eye(2), w)
        columns = [_beside(none, none[..., 0] + eye[i]) for i in range(2)]
        columns += [_beside(part, -_apply(part, center)) for part in derivatives]
        columns += [_beside(none, (eye - matrix)[..., i]) for i in range(2)]
        return value, xp.stack(columns, -1) @ slopes[..., None, :, :]


class Placed(Combined):
    """An outline under an affine map that varies.

    Parameters
    ----------
    outline : Varying
        Of shape (k, 2).
    matrix : Varying
        [A | b], of shape (2, 3): a point p goes to A p + b.
    """

    def __init__(self, outline: Varying, matrix: Varying) -> None:
        super().__init__(outline, matrix)
        self.outline, self.matrix = outline, matrix
        self.shape = outline.shape

    def value(self, w: Any) -> Any:
        """See :meth:`Varying.value`."""
        return _moved(self.outline.value(w), self.matrix.value(w))

    def value_and_jacobian(self, w: Any, toward: Any = None) -> tuple[Any, Any]:
        """See :meth:`Varying.value_and_jacobian`."""
        points, slopes = self.outline.value_and_jacobian(w, toward)
        matrix, turns = self.matrix.value_and_jacobian(w, toward)
        # The map moves a point as much as the point, extended by 1, says: (..., k, 2, n).
        extended = namespace(w).concatenate([points, 0 * points[..., :1] + 1], -1)
        own = matrix[..., None, :, :2] @ slopes
        return _moved(points, matrix), own + (
            extended[..., None, :, None] * turns[..., None, :, :, :]
        ).sum(-2)


def place(outline: Varying, matrix: Varying) -> Varying:
    """An outline (k, 2) under a map (2, 3); it stays affine where the map does not vary."""
    if not (isinstance(matrix, Affine) and isinstance(outline, Affine)) or matrix.deltas.any():
        return Placed(outline, matrix)
    linear, shift = matrix.base[:, :2], matrix.base[:, 2]
    deltas = np.einsum("ij,kjm->kim", linear, outline.deltas)
    return Affine(outline.base @ linear.T + shift, deltas, outline.support)


class Shown(Combined):
    """An outline that shrinks to a point, and so draws nothing, where a condition fails.

    Parameters
    ----------
    outline : Varying
    condition : Condition
    """

    def __init__(self, outline: Varying, condition: Condition) -> None:
        super().__init__(outline)
        self.outline, self.condition = outline, condition
        self.shape = outline.shape

    def value(self, w: Any) -> Any:
        """See :meth:`Varying.value`."""
        return self.outline.value(w) * self.condition.value(w)[..., None, None]

    def value_and_jacobian(self, w: Any, toward: Any = None) -> tuple[Any, Any]:
        """See :meth:`Varying.value_and_jacobian`."""
        value, jacobian = self.outline.value_and_jacobian(w, toward)
        shown = self.condition.value(w)[..., None, None]
        return value * shown, jacobian * shown[..., None]


class Joined(Combined):
    """Outlines one after another.

    Parameters
    ----------
    parts : sequence of Varying
        At least one, each of shape (k, 2) with a k of its own.
    """

    def __init__(self, parts: Sequence[Varying]) -> None:
        super().__init__(*parts)
        self.shape = (sum(part.shape[0] for part in parts), 2)

    def value(self, w: Any) -> Any:
        """See :meth:`Varying.value`."""
        return namespace(w).concatenate([part.value(w) for part in self.parts], -2)

    def value_and_jacobian(self, w: Any, toward: Any = None) -> tuple[Any, Any]:
        """See :meth:`Varying.value_and_jacobian`."""
        values, jacobians = zip(
            *(part.value_and_jacobian(w, toward) for part in self.parts), strict=True
        )
        xp = namespace(w)
        return xp.concatenate(values, -2), xp.concatenate(jacobians, -3)


class Reordered(Combined):
    """An outline whose points are in another order.

    Parameters
    ----------
    outline : Varying
        Of shape (k, 2).
    order : (k,) int array
        The point of ``outline`` that stands at each place.
    """

    def __init__(self, outline: Varying, order: IntArray) -> None:
        super().__init__(outline)
        self.outline, self.order = outline, order
        self.shape = outline.shape

    def value(self, w: Any) -> Any:
        """See :meth:`Varying.value`."""
        return self.outline.value(w)[..., self.order, :]

    def value_and_jacobian(self, w: Any, toward: Any = None) -> tuple[Any, Any]:
        """See :meth:`Varying.value_and_jacobian`."""
        value, jacobian = self.outline.value_and_jacobian(w, toward)
        return value[..., self.order, :], jacobian[..., self.order, :, :]


def _matrices(t: Any) -> list[Any]:
    """A = R S K, and its derivatives by rotation, scales and skews, each (..., 2, 2)."""
    xp = namespace(t)
    _, _, angle, sx, sy, kx, ky, _, _ = (t[..., i] for i in range(9))
    c, s, zero, one = xp.cos(angle), xp.sin(angle), xp.zeros_like(angle), xp.ones_like(angle)
    tx, ty = xp.tan(kx), xp.tan(ky)

    def matrix(a: Any, b: Any, c: Any, d: Any) -> Any:
        return xp.stack([xp.stack([a, b], -1), xp.stack([c, d], -1)], -2)

    turn, scale, skew = matrix(c, -s, s, c), matrix(sx, zero, zero, sy), matrix(one, tx, ty, one)
    return [
        turn @ scale @ skew,
        matrix(-s, -c, c, -s) @ scale @ skew,
        turn @ matrix(one, zero, zero, zero) @ skew,
        turn @ matrix(zero, zero, zero, one) @ skew,
        turn @ scale @ matrix(zero, 1 + tx * tx, zero, zero),
        turn @ scale @ matrix(zero, zero, 1 + ty * ty, zero),
    ]


def _beside(matrix: Any, shift: Any) -> Any:
    """[A | b], (..., 2, 3)."""
    return namespace(matrix).concatenate([matrix, shift[..., None]], -1)


def _apply(matrix: Any, vector: Any) -> Any:
    """A v, (..., 2)."""
    return (matrix @ vector[..., None])[..., 0]


def _moved(points: Any, matrix: Any) -> Any:
    """Points (..., k, 2) under [A | b]."""
    linear = namespace(matrix).swapaxes(matrix[..., :2], -1, -2)
    return points @ linear + matrix[..., None, :, 2]


def _union(parts: Sequence[Varying]) -> list[Array]:
    rows = zip(*(part.breakpoints for part in parts), strict=True)
    return [np.unique(np.concatenate(row)) for row in rows]
