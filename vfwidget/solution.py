"""Solve for the axes: terms over a text in, the text moved out (Eq. 4)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from .arrays import Array, to_array
from .energy import Term
from .errors import SolveError
from .least_squares import Iterate, Result, least_squares
from .text import Text
from .word import PointSet

if TYPE_CHECKING:
    import torch

MET = 0.5
"""A target or pin nearer than this, in font units, counts as met."""
GAIN = 1e-4
"""Squared font units: a step that gains less ends the solve, for the curved valleys along which
:class:`StayClose` still falls a little are long."""
ZERO_COST = 1e-12
"""Squared font units: a millionth of a unit is below what any renderer shows."""


@dataclass(frozen=True)
class Solution:
    """What :func:`solve` found.

    Attributes
    ----------
    text : Text
        The text, moved.
    cost : float
        E there, in squared font units.
    iterations : int
    status : {"converged", "unreachable", "running"}
        ``"unreachable"``: it has converged, on the closest place the axes can reach, and a
        target or pin is still missed. ``"running"``: the iteration limit came first.
    message : str
        The same in words, with the axis bounds that stand in the way.
    misses : list of float
        How far each term's goal is missed, in font units, in the order of the terms.
    history : list of Iterate
        (Θ, cost) of every accepted step, the start included.
    """

    text: Text
    cost: float
    iterations: int
    status: str
    message: str
    misses: list[float]
    history: list[Iterate]

    @property
    def theta(self) -> torch.Tensor:
        """Normalized coordinates found, (1, n) or (l, n)."""
        return self.text.theta

    @property
    def axes(self) -> Any:
        """User coordinates found; as :attr:`Text.axes`."""
        return self.text.axes

    @property
    def converged(self) -> bool:
        """Whether the solver stopped by itself, at a place no step improves."""
        return self.status != "running"


def solve(
    text: Text,
    terms: Sequence[Term],
    *,
    max_iterations: int = 100,
    step_tolerance: float = 1e-9,
    restarts: int = 8,
) -> Solution:
    """Find the axes that minimise the sum of the terms, from where the text is (Eq. 4).

    Parameters
    ----------
    text : Text
        Left as it is.
    terms : sequence of Term
        :class:`Target`, :class:`Pin`, :class:`StayClose`, :class:`Residual`, …
    max_iterations : int
    step_tolerance : float
        In normalized coordinates.
    restarts : int
        Where a goal is missed, how many other places to set out from, lest the way from here
        ended in a local minimum. Another result is taken only if it misses by less.

    Returns
    -------
    Solution

    Raises
    ------
    SolveError
        No terms, a handle of another text, or numbers that are not finite.

    Examples
    --------
    >>> import vfwidget as vf
    >>> text = vf.Text("recursive", "n")
    >>> top = text.nearest(250, 500)
    >>> x, y = text.position(top).tolist()
    >>> vf.solve(text, [vf.Target(top, (x, y + 10))]).status
    'converged'
    """
    energy = Energy(text, terms)
    start = to_array(text.theta)
    lower, upper = (np.tile(bound, len(start)) for bound in text.font.bounds)

    def run(x0: Array) -> tuple[Result, list[float]]:
        result = least_squares(
            lambda x: energy.residual(x.reshape(start.shape)),
            x0,
            lambda x: energy.jacobian(x.reshape(start.shape)),
            (lower, upper),
            kinks=list(text.breakpoints) * len(start),
            scale="none",
            max_iterations=max_iterations,
            step_tolerance=step_tolerance,
            gain_tolerance=GAIN,
            zero=ZERO_COST,
        )
        return result, energy.misses(result.x.reshape(start.shape))

    result, misses = run(start.ravel())
    # The same places at every call, so that a solve can be repeated.
    places = np.random.default_rng(0).uniform(lower, upper, (restarts, start.size))
    for place in places:
        if max(misses) <= MET:
            break
        other, other_misses = run(place)
        if other.cost < result.cost and max(other_misses) < max(misses) - MET:
            result, misses = other, other_misses

    theta = result.x.reshape(start.shape)
    status = "running"
    if result.converged:
        status = "unreachable" if max(misses) > MET else "converged"
    return Solution(
        text=text.at(theta=theta),
        cost=result.cost,
        iterations=result.iterations,
        status=status,
        message=_explain(text, result, status, max(misses)),
        misses=misses,
        history=[Iterate(x.reshape(start.shape), cost) for x, cost in result.history],
    )


def _explain(text: Text, result: Result, status: str, miss: float) -> str:
    if status == "running":
        return result.status
    if status == "converged":
        return "every target is met"
    held = []
    for index in np.flatnonzero(result.active):
        letter, axis = divmod(int(index), len(text.font.axes))
        where = "" if text.shared else f" of letter {letter + 1}"
        end = "maximum" if result.active[index] > 0 else "minimum"
        held.append(f"{text.font.axes[axis].tag}{where} at its {end}")
    return f"the closest the axes come is {miss:.1f} units away" + (
        f"; {', '.join(held)}" if held else ""
    )


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
        """All residuals (r,) at Θ (parameters, n)."""
        points = self._text.positions(self._points, theta)
        return np.concatenate(
            [t.residual(points[s], theta) for t, s in zip(self._terms, self._slices, strict=True)]
        )

    def jacobian(self, theta: Array) -> Array:
        """Derivative of the residuals by the flattened Θ, (r, parameters · n)."""
        points, moves = self._text.positions_and_jacobian(self._points, theta)
        moves = moves.reshape(len(points), 2, theta.size)
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

    def misses(self, theta: Array) -> list[float]:
        """How far each term's goal is missed at Θ, in font units."""
        points = self._text.positions(self._points, theta)
        return [t.miss(points[s]) for t, s in zip(self._terms, self._slices, strict=True)]
