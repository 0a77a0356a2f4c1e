"""The residual of a located term as a function of the unknowns, and the chain rule (Eq. 3)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from ..arrays import Array, to_array
from ..errors import SolveError
from ..text.place import AXES
from ..text.points import PointSet
from .autodiff import value_of

NOISE = 1e-10
"""A derivative counts as zero below this share of the terms that add up to it."""


@dataclass(frozen=True)
class Derivative:
    """The derivative of a term's residual (r,).

    Attributes
    ----------
    points : (r, p, 2) array, optional
        By the positions of the term's points. None means that it is zero.
    theta : (r, 1 or l, n) array, optional
        By Θ directly. None means that it is zero.
    """

    points: Array | None = None
    theta: Array | None = None


class Rows(Protocol):
    """A weighted residual as a function of the unknowns, block by block."""

    def residual(self, place: Mapping[str, Array]) -> Array:
        """The residual (r,), times the square root of the term's weight."""

    def own_residual(self, place: Mapping[str, Array]) -> Array:
        """The residual that :meth:`Term.miss` judges: without weight and robust loss."""

    def jacobian(self, place: Mapping[str, Array], slices: Mapping[str, slice]) -> Array:
        """Its derivative (r, N) by the free unknowns.

        Parameters
        ----------
        place : mapping of str to array
        slices : mapping of str to slice
            The columns of each free block among the N.
        """


class PointRows:
    """The rows of a term over some points of a text.

    Parameters
    ----------
    term : Term
        Its ``residual`` and ``derivative`` are functions of the points' positions and of Θ.
    points : PointSet
    automatic : bool
        Whether the term leaves its derivative to torch, and so is called with tensors.
    """

    def __init__(self, term: Any, points: PointSet, automatic: bool) -> None:
        self.term, self.points, self.automatic = term, points, automatic
        self.root = math.sqrt(term.weight)

    def residual(self, place: Mapping[str, Array]) -> Array:
        """See :class:`Rows`."""
        return self.root * self.own_residual(place)

    def own_residual(self, place: Mapping[str, Array]) -> Array:
        """See :class:`Rows`."""
        # A term that writes to its arguments must not move the text.
        return self.value(self.points.positions(place), place[AXES].copy())

    def value(self, positions: Array, theta: Array) -> Array:
        """The term's residual (r,) without its weight.

        Raises
        ------
        SolveError
            It is not a vector of numbers, the term reads a point that it does not have, or it
            raises a TypeError.
        """
        try:
            if self.automatic:
                return value_of(self.term.residual, positions, theta, self.term.kind)
            value = self.term.residual(positions, theta)
        except IndexError as error:
            raise too_few_points("residual", self.term, len(positions), error) from error
        except TypeError as error:
            raise self._type_error("residual", positions, theta, error) from error
        if not isinstance(value, np.ndarray) or value.ndim != 1 or value.dtype != np.float64:
            raise SolveError(
                f"The residual of {self.term.kind} must return a float64 array (r,); "
                f"received {_shown(value)}."
            )
        return value

    def jacobian(self, place: Mapping[str, Array], slices: Mapping[str, slice]) -> Array:
        """See :class:`Rows`."""
        theta = place[AXES].copy()
        positions, moves = self.points.positions_and_jacobian(place)
        by = self.derivative(positions, theta)
        rows = by.points if by.points is not None else by.theta
        size = 0 if rows is None else len(rows)
        jacobian = np.zeros((size, max(part.stop for part in slices.values())))
        if by.points is not None:
            flat = by.points.reshape(size, positions.size)
            if AXES in slices:
                jacobian[:, slices[AXES]] = flat @ moves.reshape(positions.size, theta.size)
            for name, block in self.points.by_block.items():
                if name in slices:
                    moves_by = block.reshape(positions.size, block.shape[-1])
                    jacobian[:, slices[name]] = _summed(flat, moves_by)
        if by.theta is not None and AXES in slices:
            jacobian[:, slices[AXES]] += by.theta.reshape(size, theta.size)
        jacobian *= self.root
        return jacobian

    def derivative(self, positions: Array, theta: Array) -> Derivative:
        """The term's derivative without its weight.

        Raises
        ------
        SolveError
            It is no Derivative, has the wrong shape, the term reads a point that it does not
            have, or it raises a TypeError.
        """
        try:
            by = self.term.derivative(positions, theta)
        except IndexError as error:
            raise too_few_points("derivative", self.term, len(positions), error) from error
        except TypeError as error:
            raise self._type_error("derivative", positions, theta, error) from error
        if not isinstance(by, Derivative):
            raise SolveError(
                f"derivative() of {self.term.kind} must return a vf.Derivative; "
                f"received {_shown(by)}."
            )
        by_points = self._side("points", by.points, positions.shape)
        by_theta = self._side("theta", by.theta, theta.shape)
        if by_points is not None and by_theta is not None and len(by_points) != len(by_theta):
            raise SolveError(
                f"The derivative of {self.term.kind} has {len(by_points)} rows by points and "
                f"{len(by_theta)} by theta; both need one for each residual."
            )
        if by_points is by.points and by_theta is by.theta:
            return by
        return Derivative(by_points, by_theta)

    def _type_error(
        self, method: str, positions: Array, theta: Array, error: TypeError
    ) -> SolveError:
        """The error for a method that has raised a TypeError, often from the call itself."""
        what = "tensors" if self.automatic else "arrays"
        return SolveError(
            f"{method}() of {self.term.kind} has raised a TypeError ({error}). It receives two "
            f"{what}: points of the shape {positions.shape} and theta of the shape {theta.shape}."
        )

    def _side(self, what: str, values: Any, shape: tuple[int, ...]) -> Array | None:
        """One part of a derivative as an array of numbers, checked."""
        if values is None:
            return None
        try:
            array = to_array(values)
        except (TypeError, ValueError):
            array = np.zeros(())
        if array.shape[1:] != shape or array.ndim != len(shape) + 1:
            got = f"{array.shape}" if array.ndim else _shown(values)
            raise SolveError(
                f"The derivative of {self.term.kind} by {what} must have the shape "
                f"(r, {', '.join(map(str, shape))}); received {got}."
            )
        return array


def _summed(by_points: Array, moves: Array) -> Array:
    """Derivatives (r, u) by unknowns without bounds, by the chain rule; rounding errors are 0.

    A letter that is moved as a whole often changes nothing, the inked area for instance. The
    rounding errors that the sum leaves would send it away by billions of units.
    """
    found: Array = by_points @ moves
    found[abs(found) <= NOISE * (abs(by_points) @ abs(moves))] = 0.0
    return found


def joined(parts: Sequence[Array]) -> Array:
    """Rows of several parts, those without rows left out; a single part is not copied."""
    if len(parts) > 1:
        parts = [part for part in parts if len(part)] or parts[:1]
    return parts[0] if len(parts) == 1 else np.concatenate(parts)


def changed_rows(kind: str, size: int, before: int) -> SolveError:
    """The error for a residual that has another number of values than before."""
    return SolveError(
        f"The residual of {kind} had {before} values and now has {size}. Only a term with "
        "moving = True may change their number, and only in locate()."
    )


def wrong_rows(kind: str, rows: int, residuals: int) -> SolveError:
    """The error for a derivative whose length is not that of the residual."""
    return SolveError(
        f"The derivative of {kind} has {rows} rows, and its residual has {residuals} values; "
        "it needs one row for each of them."
    )


def too_few_points(method: str, term: Any, count: int, error: IndexError) -> SolveError:
    """The error for a term whose method reads beyond its points, or beyond another array."""
    handles = "None, for all control points" if term.handles is None else len(term.handles)
    return SolveError(
        f"{method}() of {term.kind} has read beyond the end of an array ({error}). The term has "
        f"{count} points (handles: {handles}). Set its handles to a tuple of outline points, such "
        f"as (text.nearest(x, y),), or to None for all control points."
    )


def _shown(value: Any) -> str:
    if isinstance(value, np.ndarray):
        return f"an array of shape {value.shape} and type {value.dtype}"
    return type(value).__name__
