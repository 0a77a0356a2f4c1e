r"""Quantities that vary with the axes: control points, advance widths, a font's metrics.

The common case is affine in the scalars of some regions (paper, Eq. 1):

    q(w) = base + deltas · γ(w).

A quantity of another form, such as the outline of a glyph whose components have axes of their
own, implements the same few methods and can stand in every place where an affine one can.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np

from ..arrays import Array, ArrayLike, is_tensor, like, to_array, to_tensor
from ..errors import GlyphError
from .variation import Regions, merge_regions, selection


class Varying(ABC):
    """A differentiable function of n normalized coordinates.

    The coordinates ``w`` are (..., n), numpy arrays or tensors. The results are of the same
    kind. Tensors carry gradients.

    Attributes
    ----------
    shape : tuple of int
        The shape of the quantity: (k, 2) for the control points of an outline, () for a number.
    """

    shape: tuple[int, ...]

    @property
    @abstractmethod
    def breakpoints(self) -> list[Array]:
        """For each of n axes, the sorted coordinates at which the derivative may jump."""

    @property
    def axis_count(self) -> int:
        """The number n of coordinates."""
        return len(self.breakpoints)

    @property
    def nbytes(self) -> int:
        """Memory of the quantity's arrays, in bytes."""
        return 0

    @abstractmethod
    def value(self, w: Any) -> Any:
        """The quantity at w, (..., *shape)."""

    @abstractmethod
    def value_and_jacobian(self, w: Any, toward: Any = None) -> tuple[Any, Any]:
        """The quantity at w, and its derivative by the coordinates, (..., *shape, n).

        At a breakpoint it is the derivative to the right, or to the left for the coordinates
        whose entry of ``toward`` (..., n) is negative; at w = 1 it is the one to the left.
        """


class Affine(Varying):
    """A quantity that is affine in the scalars of m regions (Eq. 1).

    Parameters
    ----------
    base : array or tensor of any shape
        The quantity at the default, where every scalar is 0.
    deltas : (*shape, m) array or tensor
        What each region adds where its scalar is 1.
    support : (m, n, 3) array or tensor
        Start, peak and end of each region on each axis, in normalized coordinates.

    Attributes
    ----------
    base, deltas, support : float64 arrays
        The numbers without the autograd graph they may have come with. If ``base`` or ``deltas``
        is a tensor that requires grad, results computed from a tensor w carry that gradient.

    Raises
    ------
    GlyphError
        The shapes do not fit together, or a number is not finite.
    """

    def __init__(self, base: ArrayLike, deltas: ArrayLike, support: ArrayLike) -> None:
        self.base, self.deltas, self.support = map(_numbers, (base, deltas, support))
        self.shape = self.base.shape
        if self.deltas.shape[:-1] != self.shape or self.deltas.ndim != self.base.ndim + 1:
            raise GlyphError(
                f"The deltas must have the shape of the default and one dimension more, "
                f"{_spelled(self.shape, 'm')}; received {self.deltas.shape}."
            )
        m = self.deltas.shape[-1]
        if self.support.ndim != 3 or self.support.shape[::2] != (m, 3):
            raise GlyphError(
                f"The support of {m} delta sets must have the shape ({m}, n, 3), "
                f"start, peak and end on each of n axes; received {self.support.shape}."
            )
        graph = [to_tensor(part).double() for part in (base, deltas) if _requires_grad(part)]
        self._graph = (to_tensor(base).double(), to_tensor(deltas).double()) if graph else None

    def some(self, which: Any) -> Affine:
        """The entries of the first dimension that an index names."""
        return Affine(self.base[which], self.deltas[which], self.support)

    @cached_property
    def regions(self) -> Regions:
        """The support, made ready for evaluation."""
        return Regions(self.support)

    @property
    def breakpoints(self) -> list[Array]:
        """See :attr:`Varying.breakpoints`."""
        return self.regions.breakpoints

    @property
    def axis_count(self) -> int:
        """The number n of coordinates."""
        return self.support.shape[1]

    @property
    def nbytes(self) -> int:
        """Memory of the quantity's arrays, in bytes."""
        return self.base.nbytes + self.deltas.nbytes + self.support.nbytes

    @cached_property
    def tensors(self) -> tuple[Any, Any]:
        """Base and deltas as float64 tensors, with their gradient where they came with one."""
        return self._graph or (to_tensor(self.base), to_tensor(self.deltas))

    def value(self, w: Any) -> Any:
        """See :meth:`Varying.value`."""
        base, deltas = self._parts(w)
        return base + _contract(deltas, self.regions.scalars(w))

    def value_and_jacobian(self, w: Any, toward: Any = None) -> tuple[Any, Any]:
        """See :meth:`Varying.value_and_jacobian`."""
        base, deltas = self._parts(w)
        gamma, slopes = self.regions.scalars_and_jacobian(w, toward)
        flat = _rows(deltas) @ slopes
        jacobian = flat.reshape((*flat.shape[:-2], *self.shape, flat.shape[-1]))
        return base + _contract(deltas, gamma), jacobian

    def _parts(self, w: Any) -> tuple[Any, Any]:
        parts = self._graph if self._graph and is_tensor(w) else (self.base, self.deltas)
        return like(parts[0], w), like(parts[1], w)


def one_after_another(parts: Sequence[Affine]) -> Affine:
    """Affine quantities along their first dimension, over their merged regions."""
    support, places = merge_regions([part.support for part in parts])
    deltas = [
        part.deltas @ selection(where, len(support))
        for part, where in zip(parts, places, strict=True)
    ]
    return Affine(np.concatenate([part.base for part in parts]), np.concatenate(deltas), support)


def constant(value: ArrayLike, axis_count: int) -> Affine:
    """A quantity that no axis changes."""
    shape = _numbers(value).shape
    return Affine(value, np.zeros((*shape, 0)), np.zeros((0, axis_count, 3)))


def owned(part: ArrayLike) -> ArrayLike:
    """A copy of an array, which its owner may change later; a tensor that requires grad itself."""
    # The order in memory stays, so that sums are added up in the same order.
    return part if _requires_grad(part) else _numbers(part).copy(order="K")


def _numbers(part: ArrayLike) -> Array:
    try:
        numbers = to_array(part)
    except (TypeError, ValueError, RuntimeError):
        raise GlyphError(f"A glyph is made of arrays of numbers; received {part!r:.80}.") from None
    if np.count_nonzero(np.isfinite(numbers)) < numbers.size:
        raise GlyphError("The numbers of a glyph must be finite; received NaN or infinity.")
    return numbers


def _requires_grad(part: Any) -> bool:
    return is_tensor(part) and part.requires_grad


def _spelled(shape: tuple[int, ...], last: str) -> str:
    return f"({', '.join([*map(str, shape), last])}{'' if shape else ','})"


def _contract(deltas: Any, gamma: Any) -> Any:
    """Δ·γ over the delta sets: (*shape, m) with (..., m) to (..., *shape)."""
    moved = gamma @ _rows(deltas).T
    return moved.reshape((*gamma.shape[:-1], *deltas.shape[:-1]))


def _rows(deltas: Any) -> Any:
    """Deltas (*shape, m) as a matrix with one row for each number of the quantity."""
    *shape, m = deltas.shape
    return deltas.reshape(math.prod(shape), m)
