"""Quantities that depend on coordinates which themselves vary (avar 2, components with axes)."""

from __future__ import annotations

from abc import abstractmethod
from functools import cached_property
from typing import Any

import numpy as np

from ..arrays import Array, BoolArray, like, namespace, padded_table
from .variation import ON_KINK, inward
from .varying import Affine, Varying

ROUNDING = 1e-12
"""How close a coordinate counts as having reached -1 or 1."""


class Coordinates(Varying):
    """Coordinates (n',) that follow from others (n,)."""

    @property
    @abstractmethod
    def unchanged(self) -> BoolArray:
        """Which coordinates are always those that were given, (n',)."""


class Displaced(Coordinates):
    """Coordinates plus an affine displacement, kept within -1 … 1.

    Parameters
    ----------
    displacement : Affine
        Of shape (n,) over n axes.
    """

    def __init__(self, displacement: Affine) -> None:
        self.displacement = displacement
        self.shape = displacement.shape

    @property
    def axis_count(self) -> int:
        """See :attr:`Varying.axis_count`."""
        return self.displacement.axis_count

    @property
    def breakpoints(self) -> list[Array]:
        """Those of the displacement; where the limits are reached depends on several axes."""
        return self.displacement.breakpoints

    @cached_property
    def unchanged(self) -> BoolArray:
        """See :attr:`Coordinates.unchanged`."""
        return ~(self.displacement.deltas.any(-1) | (self.displacement.base != 0))

    def limits(self, lower: Array, upper: Array) -> tuple[Array, Array]:
        """Limits of the coordinates, (n,) each, over a box of the given ones (interval sums)."""
        least, most = self.displacement.regions.limits(lower, upper)
        rise, fall = self.displacement.deltas.clip(0), self.displacement.deltas.clip(None, 0)
        low = lower + self.displacement.base + rise @ least + fall @ most
        high = upper + self.displacement.base + rise @ most + fall @ least
        return low.clip(-1, 1), high.clip(-1, 1)

    def value(self, w: Any) -> Any:
        """See :meth:`Varying.value`."""
        return (w + self.displacement.value(w)).clip(-1, 1)

    def value_and_jacobian(self, w: Any, toward: Any = None) -> tuple[Any, Any]:
        """See :meth:`Varying.value_and_jacobian`."""
        displacement, slopes = self.displacement.value_and_jacobian(w, toward)
        free = w + displacement
        jacobian = slopes + like(np.eye(self.axis_count), w)
        # At a limit, coordinates stay where they are if an axis moves them outwards.
        moves = jacobian * _sides(w, toward)[..., None, :]
        below, above = (free < 1 - ROUNDING)[..., None], (free > ROUNDING - 1)[..., None]
        within = (abs(free) < 1 + ROUNDING)[..., None]
        follows = within & (below | (moves < 0)) & (above | (moves > 0))
        return free.clip(-1, 1), jacobian * follows


class Composed(Varying):
    """A quantity as a function of coordinates that another quantity gives.

    Parameters
    ----------
    outer : Varying
        Over n' coordinates.
    inner : Coordinates
        Of shape (n',) over n axes.

    Notes
    -----
    By the chain rule the Jacobian is that of ``outer`` times that of ``inner``. Where the
    coordinates of ``outer`` stand on a kink, as they all do at the default, its derivative
    depends on the side that they go to: each axis has a side of its own. Autograd always takes
    the derivative of ``outer`` to the right.
    """

    def __init__(self, outer: Varying, inner: Coordinates) -> None:
        self.outer, self.inner = outer, inner
        self.shape = outer.shape

    @property
    def axis_count(self) -> int:
        """See :attr:`Varying.axis_count`."""
        return self.inner.axis_count

    @property
    def breakpoints(self) -> list[Array]:
        """Those of ``inner``, and those of ``outer`` on axes that ``inner`` leaves as they are."""
        return [
            np.union1d(own, other) if unchanged else own
            for own, other, unchanged in zip(
                self.inner.breakpoints, self.outer.breakpoints, self.inner.unchanged, strict=True
            )
        ]

    @property
    def nbytes(self) -> int:
        """Memory of the quantity's arrays, in bytes; what ``inner`` has is shared."""
        return self.outer.nbytes

    def value(self, w: Any) -> Any:
        """See :meth:`Varying.value`."""
        return self.outer.value(self.inner.value(w))

    def value_and_jacobian(self, w: Any, toward: Any = None) -> tuple[Any, Any]:
        """See :meth:`Varying.value_and_jacobian`."""
        v, inner = self.inner.value_and_jacobian(w, toward)
        # Each column is one way to move; a negative toward means the opposite way.
        moves = inner * _sides(w, toward)[..., None, :]
        value, outer = self.outer.value_and_jacobian(v)
        if _surely_none((moves < 0) & self._on_kink(v)[..., None]):
            columns = outer.reshape((*outer.shape[: v.ndim - 1], -1, v.shape[-1])) @ inner
            return value, columns.reshape((*outer.shape[:-1], inner.shape[-1]))
        columns = [
            _times(self.outer.value_and_jacobian(v, moves[..., axis])[1], inner[..., axis])
            for axis in range(inner.shape[-1])
        ]
        return value, namespace(w).stack(columns, -1)

    def _on_kink(self, v: Any) -> Any:
        """Which coordinates of ``outer`` stand on a kink, (..., n')."""
        return (abs(v[..., None] - like(self._kinks, v)) < 2 * ON_KINK).any(-1)

    @cached_property
    def _kinks(self) -> Array:
        return padded_table(self.outer.breakpoints)


def _sides(w: Any, toward: Any) -> Any:
    """1 or -1 for each coordinate (..., n), the side to which the derivative is taken."""
    return inward(w) if toward is None else namespace(w).sign(like(toward, w))


def _surely_none(mask: Any) -> bool:
    try:
        return not bool(mask.any())
    except RuntimeError:
        # Under vmap the values cannot be looked at.
        return False


def _times(slopes: Any, column: Any) -> Any:
    """A Jacobian (..., *shape, n') times a column (..., n') of another: (..., *shape)."""
    batch = column.ndim - 1
    ones = (1,) * (slopes.ndim - column.ndim)
    return (slopes * column.reshape((*column.shape[:batch], *ones, column.shape[-1]))).sum(-1)
