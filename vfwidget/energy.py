r"""The terms of an energy over points of a text: :math:`E(\Theta) = \sum \|F_i\|^2` (Eq. 4).

A term names the handles it touches, its residual as a function of their positions (and of Θ),
and that residual's derivative. The chain rule through the text (Eq. 3) is the solver's, so a
term costs what its few handles cost, not what the outline does.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .arrays import Array
from .errors import SolveError
from .text import Text
from .word import Handle, PointSet


@dataclass(frozen=True)
class Derivative:
    """What a term's residual (r,) depends on.

    Attributes
    ----------
    points : (r, p, 2) array, optional
        By the positions of the term's points.
    theta : (r, parameters, n) array, optional
        By Θ directly.
    """

    points: Array | None = None
    theta: Array | None = None


@dataclass(frozen=True)
class Account:
    """What a term comes to at some place.

    Attributes
    ----------
    label : str
    miss : float or None
        How far its goal is missed, in font units; None for a term that only leans one way.
    cost : float
        Its share of E, in squared font units.
    """

    label: str
    miss: float | None
    cost: float


class Term:
    """One sum of squares in the energy; subclass it for new ones.

    Attributes
    ----------
    weight : float
        Multiplies the term's squares.
    handles : tuple of Handle
    """

    weight: float
    handles: tuple[Handle, ...] = ()

    def bind(self, text: Text) -> Term:
        """The term with whatever it takes from the text a solve starts from.

        Raises
        ------
        SolveError
            A handle of another text, or numbers that are not finite.
        """
        if not (math.isfinite(self.weight) and self.weight >= 0):
            raise SolveError(f"A weight is a finite number ≥ 0, not {self.weight!r}.")
        for handle in self.handles:
            if not isinstance(handle, Handle) or not text.owns(handle):
                raise SolveError(f"{handle!r} is not a handle of the text {text.string!r}.")
        return self

    def label(self) -> str:
        """Its kind, and the letters it touches, for a report."""
        letters = [handle.word.glyphs[handle.glyph].name for handle in self.handles]
        return " ".join([type(self).__name__, *letters])

    def points(self, text: Text) -> PointSet:
        """The points of the text that :meth:`residual` is given."""
        return text.point_set(self.handles)

    def residual(self, points: Array, theta: Array) -> Array:
        """Residual (r,) at positions (p, 2) and Θ (parameters, n)."""
        raise NotImplementedError

    def derivative(self, points: Array, theta: Array) -> Derivative:
        """Derivative of :meth:`residual`."""
        raise NotImplementedError

    def miss(self, points: Array) -> float | None:
        """How far, in font units, the term is from being met; None where it has no such goal."""
        return None


class Energy:
    """Terms bound to a text: stacked residuals and their Jacobian by Θ."""

    def __init__(self, text: Text, terms: Sequence[Term]) -> None:
        if not terms or not all(isinstance(term, Term) for term in terms):
            raise SolveError("solve needs a list of terms, such as [vf.Target(handle, (x, y))].")
        self._text = text
        self._terms = [term.bind(text) for term in terms]
        sets = [term.points(text) for term in self._terms]
        self._points = PointSet.join(sets)
        ends = np.cumsum([len(points.letter) for points in sets])
        self._slices = [slice(end - len(s.letter), end) for end, s in zip(ends, sets, strict=True)]

    def residual(self, theta: Array) -> Array:
        """All residuals (B, r) at B places Θ (B, parameters, n)."""
        points = self._text.positions(self._points, theta)
        return np.stack(
            [np.concatenate(self._residuals(p, t)) for p, t in zip(points, theta, strict=True)]
        )

    def _residuals(self, points: Array, theta: Array) -> list[Array]:
        return [
            t.residual(points[s], theta) for t, s in zip(self._terms, self._slices, strict=True)
        ]

    def jacobian(self, theta: Array) -> Array:
        """Derivative of the residuals by the flattened Θ, (B, r, parameters · n)."""
        points, moves = self._text.positions_and_jacobian(self._points, theta)
        moves = moves.reshape(*points.shape, theta[0].size)
        return np.stack([self._chain(*place) for place in zip(points, moves, theta, strict=True)])

    def _chain(self, points: Array, moves: Array, theta: Array) -> Array:
        """The chain rule at one place: what a term's points do to it, times what Θ does to them."""
        blocks = []
        for term, s in zip(self._terms, self._slices, strict=True):
            by = term.derivative(points[s], theta)
            block = np.zeros(())
            if by.points is not None:
                block = by.points.reshape(len(by.points), -1) @ moves[s].reshape(-1, theta.size)
            if by.theta is not None:
                block = block + by.theta.reshape(len(by.theta), theta.size)
            blocks.append(block)
        return np.concatenate(blocks)

    def accounts(self, theta: Array) -> list[Account]:
        """What each term comes to at one place Θ (parameters, n)."""
        points = self._text.positions(self._points, theta)
        accounts = []
        for term, s, residual in zip(
            self._terms, self._slices, self._residuals(points, theta), strict=True
        ):
            cost = float(residual @ residual)
            accounts.append(Account(term.label(), term.miss(points[s]), cost))
        return accounts
