r"""Support functions and scaling factors: from normalized coordinates to delta-set scalars.

A region gives each axis a *support* ``(start, peak, end)``. The support function
:math:`\varphi` is 1 at the peak, falls linearly to 0 at start and end, and is constantly 1
where the axis takes no part. The scalar of a delta set is the product over axes,
:math:`\gamma(w) = \prod_i \varphi_i(w_i)` (paper, Eq. 2), and everything a variable font
moves is affine in those scalars (Eq. 1):

    p(w) = default + deltas · γ(w).

Definitions follow OpenType ("OpenType Font Variations Common Table Formats", algorithm for
interpolation of instance values), which differs from the paper's printed :math:`\varphi` at
``w = peak = end``: there OpenType says 1.

The map has *kinks* at every start, peak and end. Derivatives are taken from the right,
except at the upper end of the axis, where only the left exists. That is w = 1, or w = 0 for an axis
whose default is its maximum. The solver obtains the other one-sided derivative by evaluating at an
offset of 1e-8 to the left.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ..arrays import (
    Array,
    ArrayLike,
    BoolArray,
    IntArray,
    holds_anywhere,
    like,
    namespace,
    to_array,
)

ON_KINK = 1e-9
"""How close, in normalized units, a coordinate counts as standing on a breakpoint."""

MOST_CELLS = 4
"""So many cells are kept for the next calls."""


def inward(w: Any, upper: Any = 1.0) -> Any:
    """1, and -1 at the upper end of a coordinate: the side to which derivatives are taken."""
    return namespace(w).where(w >= upper, -1.0, 1.0)


class Cell(NamedTuple):
    """A box between kinks, and the lines that hold within it.

    Attributes
    ----------
    lower, upper : (n,) arrays
        The box, without its sides.
    height, slope : (m, q) arrays
        Each slot's line: its height at 0 and its slope.
    """

    lower: Array
    upper: Array
    height: Array
    slope: Array


class Slots:
    """Support functions of m regions, ready for evaluation.

    A region takes part in few axes, so each is kept as q *slots*, one for each axis it depends
    on, q being the most that any has. A slot's support function is two lines, ``a + b·w``: one
    that rises on ``(start, peak)`` and one that falls on ``(peak, end)``. An idle slot is a rising
    line of height 1 and slope 0 that never ends, so it needs no case of its own.

    Parameters
    ----------
    axis : (m, q) int array
        The coordinate that each slot reads.
    used : (m, q) bool array
        False for idle slots.
    sides : (m, q, 3) array
        Start, peak and end of each slot.
    upper : (n,) array, optional
        The upper end of each coordinate, where only the derivative from the left exists.
        Default: 1 for all.
    """

    def __init__(
        self, axis: IntArray, used: BoolArray, sides: Array, upper: Array | None = None
    ) -> None:
        self.axis, self.used, self.sides = axis, used, sides
        start, peak, end = np.moveaxis(sides, -1, 0)
        rise = np.where(peak > start, peak - start, 1.0)
        fall = np.where(end > peak, end - peak, 1.0)
        ends_at_peak, starts_at_peak = used & (peak == end), used & (peak == start)
        flat = ~used | (ends_at_peak & starts_at_peak)
        self._rising = np.stack([np.where(flat, 1.0, -start / rise), np.where(flat, 0.0, 1 / rise)])
        self._falling = np.stack([end / fall, -1 / fall])
        # Where a line begins to hold. On a kink it is the one to the right; at the upper end of
        # the axis and beyond it, where nothing has to follow to the right, the one to the left.
        top = 1.0 if upper is None else upper[axis]
        before, peak_begins, after = (
            side + np.where(side >= top, ON_KINK, -ON_KINK) for side in (start, peak, end)
        )
        # A support that ends (or starts) at its peak drops from 1 to 0 there, but is 1 at the
        # peak itself: its line holds until just beyond it.
        before = np.where(starts_at_peak, start - ON_KINK, before)
        after = np.where(ends_at_peak, end + ON_KINK, after)
        peak_begins = np.where(starts_at_peak, -np.inf, peak_begins)
        self._start = np.where(used, before, -np.inf)
        self._peak = np.where(used & ~ends_at_peak, peak_begins, np.inf)
        self._end = np.where(used, after, np.inf)
        q = axis.shape[1]
        # The other slots of each slot, (q, q - 1).
        self._others = np.nonzero(~np.eye(q, dtype=bool))[1].reshape(q, q - 1)
        self._cells: list[Cell] = []

    def kinks(self, n: int) -> list[Array]:
        """Sorted values at which each of n coordinates has a kink."""
        values = [np.zeros(0)] * n
        axis, sides = self.axis[self.used], self.sides[self.used]
        for i in np.unique(axis):
            values[i] = np.unique(sides[axis == i])
        return values

    def _pieces(self, w: Any, toward: Any = None) -> tuple[Any, Any]:
        """φ and its slope for every slot: two (..., m, q) arrays."""
        w = _at(w, self.axis)
        height, slope = self._lines(
            w if toward is None else w - 2 * ON_KINK * (_at(toward, self.axis) < 0)
        )
        return height + slope * w, slope

    def _lines(self, w: Any) -> tuple[Any, Any]:
        """Height at 0 and slope of the line that holds at w for every slot: two (..., m, q)."""
        inside = (w > like(self._start, w)) & (w < like(self._end, w))
        before = (w < like(self._peak, w))[..., None, :, :]
        lines = namespace(w).where(before, like(self._rising, w), like(self._falling, w))
        lines = lines * inside[..., None, :, :]
        return lines[..., 0, :, :], lines[..., 1, :, :]

    def scalars(self, w: Any) -> Any:
        """γ(w) of Eq. 2, (..., m), at normalized coordinates w (..., n); autograd passes."""
        return _product(self._pieces(w)[0])

    def limits(self, lower: Array, upper: Array) -> tuple[Array, Array]:
        """Limits of γ, (m,) each, over a box between lower and upper, (n,) each."""
        ends = np.sort([self._pieces(side)[0] for side in (lower, upper)], axis=0)
        peak = self.sides[..., 1]
        passed = (lower[self.axis] <= peak) & (peak <= upper[self.axis]) & self.used
        # φ rises to its peak and falls after it.
        return ends[0].prod(-1), np.where(passed, 1.0, ends[1]).prod(-1)

    def scalars_and_slopes(self, w: Any, toward: Any = None) -> tuple[Any, Any]:
        """γ(w), (..., m), and its derivative by the axis of each slot, (..., m, q).

        By the product rule each is one slot's slope times the other slots' factors. On a kink it
        is the derivative to the right, or to the left where ``toward`` (..., n) is negative.
        """
        return self._products(*self._pieces(w, toward))

    def along(self, w: Array) -> tuple[Array, Array]:
        """As :meth:`scalars_and_slopes` at one w, (n,), for calls at one place after another.

        The lines of the latest cells between kinks are kept, because a drag seldom leaves them:
        an axis that rests on a kink is evaluated on both sides of it.
        """
        for cell in self._cells:
            if not holds_anywhere((w <= cell.lower) | (w >= cell.upper)):
                break
        else:
            cell = self._cell_at(w)
            self._cells = [cell, *self._cells[: MOST_CELLS - 1]]
        return self._products(cell.height + cell.slope * w.take(self.axis), cell.slope)

    def _cell_at(self, w: Array) -> Cell:
        lower, upper = np.full(len(w), -np.inf), np.full(len(w), np.inf)
        axes, starts, edges, owners = self._edges
        if len(axes):
            here = w.take(owners)
            lower[axes] = np.maximum.reduceat(np.where(edges <= here, edges, -np.inf), starts)
            upper[axes] = np.minimum.reduceat(np.where(edges >= here, edges, np.inf), starts)
        return Cell(lower, upper, *self._lines(w.take(self.axis)))

    @cached_property
    def _edges(self) -> tuple[IntArray, IntArray, Array, IntArray]:
        """The coordinates in use; where the edges of each begin; all edges, and their owners."""
        owners = np.tile(self.axis.ravel(), 3)
        order = owners.argsort(kind="stable")
        owners = owners[order]
        axes, starts = np.unique(owners, return_index=True)
        edges = np.concatenate([self._start, self._peak, self._end], axis=None)
        return axes, starts, edges[order], owners

    def _products(self, phi: Any, slope: Any) -> tuple[Any, Any]:
        """γ and its derivative by the axis of each slot, from φ and its slope."""
        if phi.shape[-1] == 1:
            return phi[..., 0], slope
        others = _product(_at(phi, self._others))
        # These are the multiplications of _product(phi), in the same order.
        return phi[..., 0] * others[..., 0], slope * others


class Regions(Slots):
    """The supports of m delta sets over n axes.

    Parameters
    ----------
    support : (m, n, 3) array or tensor
        start, peak, end of each delta set on each axis, in normalized coordinates.
    upper : (n,) array, optional
        As for :class:`Slots`.
    """

    def __init__(self, support: ArrayLike, upper: Array | None = None) -> None:
        self.support = to_array(support)
        n = self.support.shape[1]
        start, peak, end = np.moveaxis(self.support, -1, 0)
        takes_part = ~((peak == 0) | (start > peak) | (peak > end) | ((start < 0) & (end > 0)))
        q = max(1, int(takes_part.sum(1).max(initial=0)))
        # Axes that take part come first; a slot beyond them is idle, whichever axis it names.
        axis = np.argsort(~takes_part, axis=1, kind="stable")[:, :q]
        axis = np.pad(axis, ((0, 0), (0, q - axis.shape[1])))
        used = np.arange(q) < takes_part.sum(1)[:, None]
        sides = [np.take_along_axis(side, axis, 1) for side in (start, peak, end)]
        super().__init__(axis, used, np.stack(sides, -1), upper)
        self.one_hot = (used[..., None] & (axis[..., None] == np.arange(n))).astype(float)
        """1 where a slot belongs to an axis, (m, q, n)."""
        self.breakpoints = self.kinks(n)
        """Sorted coordinates at which each axis has a kink, n arrays."""

    def scalars_and_jacobian(self, w: Any, toward: Any = None) -> tuple[Any, Any]:
        """γ(w), (..., m), and its closed-form derivative ∂γ/∂w, (..., m, n)."""
        gamma, slopes = self.scalars_and_slopes(w, toward)
        return gamma, (slopes[..., None, :] @ like(self.one_hot, w))[..., 0, :]

    def of_letters(self, letters: IntArray, regions: IntArray, upper: Array) -> Slots:
        """Regions of letters with coordinates of their own, as functions of flat Θ.

        Parameters
        ----------
        letters, regions : (m',) int arrays
            The i-th result is region ``regions[i]`` at the coordinates of letter ``letters[i]``.
        upper : (size of Θ,) array
            As for :class:`Slots`.
        """
        used = self.used[regions]
        q = max(1, int(used.sum(1).max(initial=0)))
        axis = self.axis[regions, :q] + (self.support.shape[1] * letters)[:, None]
        return Slots(axis, used[:, :q], self.sides[regions, :q], upper)


def _at(values: Any, index: IntArray) -> Any:
    """``values[..., index]``; quicker than numpy's own."""
    return values.take(index, -1) if type(values) is np.ndarray else values[..., index]


def _product(factors: Any) -> Any:
    """The product over the last dimension, which is short; quicker than numpy's own."""
    product = factors[..., -1]
    for i in range(factors.shape[-1] - 2, -1, -1):
        product = factors[..., i] * product
    return product


def merge_regions(supports: list[Array]) -> tuple[Array, list[IntArray]]:
    """Join several (m, n, 3) supports into one without repeats.

    Returns
    -------
    support : (M, n, 3) array
        The distinct regions, in order of first appearance.
    indices : list of (m,) int arrays
        Where each input region is found in ``support``.
    """
    position: dict[bytes, int] = {}
    kept: list[Array] = []
    indices = []
    for support in supports:
        found = []
        for region in support:
            key = region.tobytes()
            if key not in position:
                position[key] = len(kept)
                kept.append(region)
            found.append(position[key])
        indices.append(np.asarray(found, dtype=np.intp))
    n = supports[0].shape[1] if supports else 0
    return np.asarray(kept, dtype=np.float64).reshape(len(kept), n, 3), indices


def selection(indices: IntArray, count: int) -> Array:
    """The (m, count) matrix that spreads m delta sets over merged regions; repeats add up."""
    matrix = np.zeros((len(indices), count))
    matrix[np.arange(len(indices)), indices] = 1
    return matrix
