"""Solve for the axes: terms over a text in, the text moved out (Eq. 4)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arrays import Array
from ..solver.drivers import active_bounds, minimise
from ..solver.least_squares import Iterate
from ..solver.problem import Problem, State, Tolerances
from ..solver.status import ITERATION_LIMIT
from ..text import Text
from .handle_terms import Pin
from .term import Account, Energy, Term

if TYPE_CHECKING:
    import torch

MET = 0.5
"""A target or pin nearer than this, in font units, counts as met."""
GAIN = 1e-4
"""Squared font units: a step that gains less ends the solve, for the curved valleys along which
:class:`StayClose` still falls a little are long."""
SOFT = 100.0
"""Weight of a pin while a restart finds its way."""
ZERO_COST = 1e-12
"""Squared font units: a millionth of a unit is below what any renderer shows."""


@dataclass(frozen=True)
class Solution:
    """What :func:`solve` found.

    Attributes
    ----------
    text : Text
        The text, moved.
    start : Text
        The text as it was.
    cost : float
        E at ``text``, in squared font units.
    iterations : int
    status : {"converged", "unreachable", "running"}
        ``"unreachable"``: it has converged, on the closest place the axes can reach, and a
        target or pin is still missed. ``"running"``: the iteration limit came first.
    message : str
        The same in words, with the axis bounds that stand in the way.
    terms : list of Account
        What each term comes to, in the order given.
    active : (1, n) or (l, n) int array
        -1 or 1 where an axis is held at its lower or upper bound, else 0.
    history : list of Iterate
        (Θ, cost) of every accepted step, the start included.
    """

    text: Text
    start: Text
    cost: float
    iterations: int
    status: str
    message: str
    terms: list[Account]
    active: Array
    history: list[Iterate]

    @property
    def misses(self) -> list[float]:
        """How far each term's goal is missed, in font units; 0 for a term that has none."""
        return [account.miss or 0.0 for account in self.terms]

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

    def report(self) -> str:
        """Which terms are met, by how much the rest are missed, and what each axis did.

        Returns
        -------
        str
            A table to print.
        """
        lines = [f"{self.status} after {self.iterations} iterations: {self.message}", ""]
        labels = [account.term.label() for account in self.terms]
        width = max(len(label) for label in labels)
        lines.append(f"{'term':{width}}  {'missed by':>11}  {'cost':>10}")
        for label, account in zip(labels, self.terms, strict=True):
            miss = account.miss
            missed = "" if miss is None else "met" if miss <= MET else f"{miss:.1f}"
            lines.append(f"{label:{width}}  {missed:>11}  {account.cost:10.4g}")
        lines += ["", f"{'axis':{width}}  {'from':>11}  {'to':>10}"]
        places = zip(_rows(self.start), _rows(self.text), self.active, strict=True)
        for letter, (before, after, active) in enumerate(places):
            for (tag, old), new, held in zip(before.items(), after.values(), active, strict=True):
                name = tag if self.text.shared else f"{self.text.glyphs[letter].name} {tag}"
                end = {-1: "  held at its minimum", 1: "  held at its maximum"}.get(int(held), "")
                lines.append(f"{name:{width}}  {old:11.4g}  {new:10.4g}{end}")
        return "\n".join(lines)


def _softened(term: Term) -> Term:
    return replace(term, weight=min(term.weight, SOFT)) if isinstance(term, Pin) else term


def _rows(text: Text) -> list[dict[str, float]]:
    return [text.axes] if text.shared else text.axes


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
    start = text.coordinates
    lower, upper = text.word.bounds
    kinks = energy.kinks
    tolerances = Tolerances(step=step_tolerance, gain=GAIN, zero=ZERO_COST)
    problem = Problem(lower, upper, kinks, scale_by_columns=False, tolerances=tolerances)

    def descend(energy: Energy, x0: Array, history: list[Any]) -> State:
        return minimise(
            problem,
            x0,
            energy.residual,
            energy.jacobian,
            max_iterations=max_iterations,
            history=history,
        )

    def run(x0: Array) -> tuple[State, list[Any], list[Account], float]:
        history: list[Any] = []
        state = descend(energy, x0, history)
        accounts = energy.accounts(state.x, state.residual)
        return state, history, accounts, max(account.miss or 0.0 for account in accounts)

    best = run(start.ravel())
    if best[-1] > MET and restarts > 0:
        # The same places at every call, so that a solve can be repeated. An axis that moves none
        # of the points stays where it is.
        places = np.random.default_rng(0).uniform(lower, upper, (restarts, start.size))
        felt = np.isfinite(kinks).any(1)
        # From far away stiff terms make narrow, winding valleys: they come in once it is near.
        soft = Energy(text, [_softened(term) for term in terms])
        for place in np.where(felt, places, start.ravel()):
            near = descend(soft, place, [])
            if near.cost >= best[0].cost:
                # Stiff terms only add to the cost.
                continue
            other = run(near.x)
            if other[0].cost < best[0].cost and other[-1] < best[-1] - MET:
                best = other

    state, history, accounts, miss = best
    active = active_bounds(problem, state, energy.jacobian).reshape(start.shape)
    assert state.outcome is not None
    ended = state.outcome.status != ITERATION_LIMIT
    status = ("unreachable" if miss > MET else "converged") if ended else "running"
    return Solution(
        text=text.moved(state.x.reshape(start.shape)),
        start=text,
        cost=state.cost,
        iterations=state.iterations,
        status=status,
        message=_explain(text, active, miss) if ended else state.outcome.message,
        terms=accounts,
        active=active,
        history=[Iterate(x.reshape(start.shape), cost) for x, cost in history],
    )


def _explain(text: Text, active: Array, miss: float) -> str:
    """In words: met, or how near the axes come and which of them are at their ends."""
    if miss <= MET:
        return "every goal is met"
    held = []
    for letter, axis in zip(*np.nonzero(active), strict=True):
        where = "" if text.shared else f" of letter {letter + 1}"
        end = "maximum" if active[letter, axis] > 0 else "minimum"
        held.append(f"{text.font.axes[axis].tag}{where} at its {end}")
    nearest = f"the closest the axes come is {miss:.1f} units away"
    return f"{nearest}; {', '.join(held)}" if held else nearest
