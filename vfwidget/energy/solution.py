"""What a solve found, with a report in words."""

from __future__ import annotations

import html
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

from ..arrays import Array
from ..font.axes import shown
from ..solver.least_squares import Iterate
from ..solver.status import CONVERGED
from ..text import Text
from ..text.place import OFFSETS, Place
from .boundaries import Boundary
from .term import Term, TermResult, amount

if TYPE_CHECKING:
    import torch


UNREACHABLE = "unreachable"
"""No step lowers the cost any more, and a goal is still missed."""
DUST = 1e-6
"""Share of the range of an axis: a value nearer to 0 is shown as 0 in a report."""


@dataclass(frozen=True, repr=False, eq=False)
class Solution:
    """The result of :func:`solve`.

    Attributes
    ----------
    text : Text
        The text, moved.
    start : Text
        The text at the start.
    place : Place
        All unknowns by block: ``"axes"``, ``"offsets"`` and those that terms added.
    cost : float
        E at ``text``, in squared font units.
    iterations : int
        Accepted steps.
    status : str
        ``"converged"``: every goal is met, or no step improves a solve that has only preferences.
        ``"unreachable"``: no step improves it, and a goal is still missed. Otherwise the reason
        why the solver stopped early, such as ``"iteration_limit"`` or ``"time_limit"``.
    message : str
        The same in words, with the axis bounds that limit the result.
    terms : list of TermResult
        Each term at ``text``, in the order given.
    elsewhere : Text or None
        A text that misses the goals by less. The solver did not take it, because some outline
        point would move by more than 2 % of the em and no missed goal would be met.
    boundaries : list of Boundary
        Boundaries that the solve met at which glyphs change, and whether it crossed them.
    """

    text: Text
    start: Text
    place: Place
    cost: float
    iterations: int
    status: str
    message: str
    terms: list[TermResult]
    _active: Callable[[], Array] | None
    _history: Callable[[], list[Iterate]] | None
    elsewhere: Text | None = field(default=None)
    boundaries: list[Boundary] = field(default_factory=list)
    _axes_free: bool = True

    @cached_property
    def history(self) -> list[Iterate]:
        """(Θ, cost) of every accepted step, the start included.

        If a restart has found the result, these are its steps, from the point at which it began.
        At first they are those of an energy in which pins have less weight.
        """
        assert self._history is not None
        return self._history()

    @cached_property
    def active(self) -> Array:
        """-1 or 1 where an axis is held at an end of its range, else 0; (1, n) or (l, n).

        -1 stands for the lower end, 1 for the upper one. The first use may evaluate a derivative.
        """
        assert self._active is not None
        return self._active()

    def __getstate__(self) -> dict[str, Any]:
        # A pickle holds the numbers, and not the energy from which they are found.
        found = {"active": self.active, "history": self.history}
        return {**self.__dict__, **found, "_active": None, "_history": None}

    @property
    def misses(self) -> list[float]:
        """How far each term's goal is missed, in font units; 0 for a term that has no goal.

        Terms of another unit use that: :class:`Looks` gives a share of the ink.
        """
        return [result.miss or 0.0 for result in self.terms]

    @property
    def theta(self) -> torch.Tensor:
        """Normalized coordinates found, (1, n) or (l, n)."""
        return self.text.theta

    @property
    def axes(self) -> Any:
        """User coordinates found, in the form of :attr:`Text.axes`."""
        return self.text.axes

    @property
    def converged(self) -> bool:
        """Whether the solver stopped by itself, at a result that no step improves."""
        return self.status in (CONVERGED, UNREACHABLE)

    def report(self) -> str:
        """A table to print: which goals are met, by how much others are missed, and each free axis.

        Letters that have one name are counted, as in "2nd l". The table also lists letters that
        were moved, and the tracking if it has changed, and says whether there is a better result
        farther away.

        Returns
        -------
        str
        """
        lines = [f"{self.status} after {self._steps}: {self.message}", ""]
        labels = [result.term.label() for result in self.terms]
        letters = self.text.word.distinct_names
        axes = self._axis_rows() if self._axes_free else []
        width = max(map(len, [*labels, *letters, "tracking", *(name for name, *_ in axes)]))
        lines.append(f"{'term':{width}}  {'missed by':>11}  {'cost':>10}")
        for label, result in zip(labels, self.terms, strict=True):
            missed, words = _missed(result)
            lines.append(f"{label:{width}}  {missed:>11}  {result.cost:10.4g}{words}")
        spaces = self.start.tracking, self.text.tracking
        rows = [*axes, ("tracking", *spaces, "")] if spaces[0] != spaces[1] else axes
        if rows:
            lines += ["", f"{'axis' if axes else '':{width}}  {'from':>11}  {'to':>10}"]
        lines += [f"{name:{width}}  {old:11.4g}  {new:10.4g}{end}" for name, old, new, end in rows]
        ends = self.text.place[OFFSETS], self.start.place[OFFSETS]
        moves = ends[0] - ends[1] if len(ends[0]) == len(ends[1]) else ends[0]
        if moves.any():
            lines += ["", f"{'letter':{width}}  {'moved by x':>11}  {'y':>10}"]
            for name, (x, y) in zip(letters, moves, strict=True):
                lines.append(f"{name:{width}}  {x:11.1f}  {y:10.1f}")
        if self.elsewhere is not None:
            lines += ["", "A better result lies farther away: see solution.elsewhere."]
        if self.boundaries:
            lines += ["", "where glyphs change", *map(str, self.boundaries)]
        return "\n".join(lines)

    def _axis_rows(self) -> list[tuple[str, float, float, str]]:
        """For each axis of each letter: its name, its values before and after, and its end."""
        rows = []
        places = zip(_rows(self.start), _rows(self.text), self.active, strict=True)
        for letter, (before, after, active) in enumerate(places):
            of = "" if self.text.shared else f"{self.text.word.distinct_names[letter]} "
            values = zip(self.text.font.axes, before.values(), after.values(), active, strict=True)
            for axis, old, new, held in values:
                # A solver leaves values that differ from 0 only by what it tolerates.
                dust = DUST * (axis.maximum - axis.minimum)
                old, new = (0.0 if abs(value) < dust else value for value in (old, new))
                end = {-1: "  held at its minimum", 1: "  held at its maximum"}.get(int(held), "")
                rows.append((of + axis.tag, old, new, end))
        return rows

    @property
    def _steps(self) -> str:
        return f"{self.iterations} iteration{'' if self.iterations == 1 else 's'}"

    def __repr__(self) -> str:
        met = [result.met for result in self.terms if result.miss is not None]
        goals = f"{sum(met)} of {len(met)} goals met" if met else "no goals"
        return (
            f"<{type(self).__name__} for {self.text.string!r}: {self.status} after {self._steps}, "
            f"{goals}, cost {self.cost:.4g}\n"
            f" axes {shown(self.axes)}>"
        )

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(self.report())}</pre>"


def _missed(result: TermResult) -> tuple[str, str]:
    """By how much a goal is missed, in font units, or else what its term says of it."""
    if result.miss is None or result.met:
        return "" if result.miss is None else "met", ""
    if type(result.term).missed_by is Term.missed_by:
        return amount(result.miss), ""
    return "missed", f"  by {result.term.missed_by(result.miss)}"


def _rows(text: Text) -> list[dict[str, float]]:
    return [text.axes] if text.shared else text.axes
