"""Minimise an energy from where a text stands, then from elsewhere if a goal is missed (Eq. 4)."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from ..arrays import Array
from ..errors import SolveError
from ..solver.least_squares import Iterate
from ..solver.problem import Tolerances, is_count, is_number, read_limit
from ..solver.status import CONVERGED, Outcome
from ..text import Text
from ..text.place import AXES, Place, Unknowns
from .boundaries import Boundary, at_ends, cross
from .descent import Descent, descend, held_axes
from .energy import Energy
from .handle_terms import Pin
from .oblique import along_planes
from .solution import UNREACHABLE, Solution
from .term import Term, TermResult
from .tied import Ties, energy_of

LEAST_GAIN = 1e-4
"""Squared font units: the solve ends when a step lowers the cost by less. Without this limit it
would take many small steps that only improve :class:`StayClose`."""
SOFT = 100.0
"""Weight of a pin while a restart searches for its way."""
COST_FLOOR = 1e-12
"""Squared font units: a cost below it is zero. No renderer shows a millionth of a unit."""
FAR = 0.02
"""Ems: a restart that moves some outline point by more must meet a goal that was missed."""


def solve(
    text: Text,
    terms: Term | Sequence[Term],
    *,
    free: Collection[str] = (AXES,),
    locks: Collection[str] = (),
    ties: Ties = (),
    max_iterations: int = 100,
    step_tolerance: float = 1e-9,
    restarts: int = 8,
    restart_seconds: float | None = None,
) -> Solution:
    """Find the axes that minimise the sum of the terms, from where the text is (Eq. 4).

    Parameters
    ----------
    text : Text
        It is not changed.
    terms : Term, or sequence of Term
        :class:`Target`, :class:`Pin`, :class:`StayClose`, :class:`Residual`, …
    free : collection of str
        The blocks of unknowns that may move: ``"axes"`` (the default), ``"offsets"``, the
        displacements of the letters, and ``"tracking"``, the space between them; for example
        ``["axes", "offsets"]``. Blocks that a term adds are always free.
    locks : collection of str
        Tags of axes that keep their values. Default: none.
    ties : sequence of sequences of int
        Groups of letters that share one axis vector, such as ``[(0, 1, 2)]``, in a text with one
        for each letter. A group starts from the axis values of its first letter, and the cost is
        that of all letters. Default: none.
    max_iterations : int
        Largest number of accepted steps. Default 100.
    step_tolerance : float
        Stop when a step is shorter than this, in normalized coordinates. Default 1e-9.
    restarts : int
        Number of additional starting points that are tried if a goal is missed, because the first
        descent may have ended in a local minimum. Default 8. Another result is taken only if it
        meets a goal that was missed, or if it misses goals by at least 0.5 font units less and
        moves no outline point by more than 2 % of the em. A better result farther away is left in
        ``solution.elsewhere``.
    restart_seconds : float, optional
        Restarts, and descents beyond locations at which glyphs change, end this many seconds
        after the call, and the best result so far is kept. If a goal is missed, or if there is
        none, and such a location was left untried, the status is ``"time_limit"``. Default: no
        limit, so that a solve can be repeated exactly.

    Returns
    -------
    Solution
        Its ``status`` is ``"converged"``, ``"unreachable"`` if a goal is missed and no step comes
        nearer, or the reason why the solve ended early. Where a descent ends at a location at which
        glyphs change, it goes on beyond if that costs less; ``solution.boundaries`` lists these
        locations.

    Raises
    ------
    SolveError
        There are no terms, a handle belongs to another text, a number is not finite or out of
        range, a term has no value at the start, a block of unknowns does not exist, a letter is
        in two groups of ``ties``, or the solve is too large for ``limits.step_products``.
    AxisError
        A lock is no axis of the font.

    Examples
    --------
    >>> import vfwidget as vf
    >>> text = vf.Text("recursive", "n", axes={"wght": 600})
    >>> foot = text.nearest(600, 0)
    >>> x, y = text.position(foot).tolist()
    >>> vf.solve(text, vf.Target(foot, (x - 20, y))).status
    'converged'
    """
    if not isinstance(text, Text):
        raise SolveError(f"solve(text, terms) needs a Text first; received {type(text).__name__}.")
    terms = [terms] if isinstance(terms, Term) else terms
    if type(terms) is not list and not isinstance(terms, Sequence):
        raise SolveError(
            f"terms must be a Term or a sequence of terms; received {type(terms).__name__}."
        )
    if not is_count(restarts):
        raise SolveError(f"restarts must be a whole number ≥ 0; received {restarts!r}.")
    until = _end_of(restart_seconds)
    energy = energy_of(text, terms, free, locks, ties)
    tolerances = _tolerances(step_tolerance, energy)

    def run(energy: Energy, x: Array, deadline: float = until) -> Descent:
        def down(energy: Energy, x: Array) -> Descent:
            return descend(energy, x, tolerances, max_iterations, deadline=deadline)

        return along_planes(energy, down(energy, x), down, deadline)

    def run_beyond(energy: Energy, x: Array) -> Descent | None:
        return None if time.perf_counter() > until else run(energy, x)

    first = run(energy, energy.unknowns.start, math.inf)
    energy, first, boundaries, cut = cross(energy, first, run_beyond)
    best, elsewhere = _restarted(energy, first, restarts, run, until)
    setting = energy
    if best is not first:
        # The result of a restart may have met other boundaries.
        energy, best, met, also = cross(energy, best, run_beyond)
        boundaries = [one for one in boundaries if one.crossed] + met
        cut = also or cut
    other = None
    if elsewhere is not None and elsewhere.shortfall <= best.shortfall - 1:
        other = setting.text.moved_to(setting.unknowns.place(elsewhere.state.x))
    return solution_of(energy, best, other, start=text, boundaries=boundaries, cut=cut)


def _restarted(
    energy: Energy,
    best: Descent,
    count: int,
    run: Callable[[Energy, Array], Descent],
    until: float,
) -> tuple[Descent, Descent | None]:
    """The best descent of those from other places, and a better one that is too far away."""
    elsewhere = None
    if count == 0 or not best.missed:
        return best, elsewhere
    # From far away stiff terms make narrow, curved valleys, so they are added near the end.
    soft = energy.at(energy.text, [_softened(term) for term in energy.terms])
    for x in _other_places(energy, count):
        if time.perf_counter() > until:
            break
        if not np.isfinite(soft.renew(x) if soft.moves else soft.residual(x)).all():
            # A term has no value there, which says nothing about the first result.
            continue
        near = run(soft, x)
        if near.state.cost >= best.state.cost:
            # Stiff terms only add to the cost.
            continue
        other = run(energy, near.state.x).after(near)
        if other.state.cost >= best.state.cost or other.shortfall > best.shortfall - 1:
            continue
        if other.meets_more_than(best) or not _is_far(energy, best, other):
            best, elsewhere = other, None
        elif elsewhere is None or other.state.cost < elsewhere.state.cost:
            elsewhere = other
    return best, elsewhere


def _end_of(seconds: float | None) -> float:
    """The value of ``time.perf_counter()`` at which the restarts end."""
    if seconds is None:
        return math.inf
    if not (is_number(seconds) and seconds >= 0):
        raise SolveError(
            f"restart_seconds must be None or a number of seconds ≥ 0; received {seconds!r}."
        )
    return time.perf_counter() + float(seconds)


def _tolerances(step: float, energy: Energy) -> Tolerances:
    """The limits of a solve, which scale with the goal whose tolerance costs least.

    Gains that are small for a usual goal decide whether a goal of small weight is met.
    """
    least = min(1.0, energy.least_goal)
    step = read_limit("step_tolerance", step)
    return Tolerances(step=step, absolute_cost=LEAST_GAIN * least, cost_floor=COST_FLOOR * least)


def _softened(term: Term) -> Term:
    return replace(term, weight=min(term.weight, SOFT)) if isinstance(term, Pin) else term


def _other_places(energy: Energy, count: int) -> Iterator[Array]:
    """Points to start from, the same ones at every call so that a solve can be repeated.

    Only axes that affect some term are varied.
    """
    start, varied = energy.unknowns.start, energy.varied
    if not varied.any():
        return
    chance = np.random.default_rng(0)
    lower, upper = energy.lower[varied], energy.upper[varied]
    for _ in range(count):
        x = start.copy()
        x[varied] = chance.uniform(lower, upper)
        yield x


def _is_far(energy: Energy, here: Descent, there: Descent) -> bool:
    """Whether some outline point moves by more than a small part of the em."""
    text, outline = energy.text, energy.text.point_set()
    points = [outline.positions(energy.unknowns.place(d.state.x)) for d in (here, there)]
    moved = np.hypot(*np.moveaxis(points[1] - points[0], -1, 0)).max(initial=0.0)
    return bool(moved > FAR * text.font.units_per_em)


def solution_of(
    energy: Energy,
    best: Descent,
    elsewhere: Text | None = None,
    *,
    start: Text | None = None,
    boundaries: Sequence[Boundary] = (),
    cut: Outcome | None = None,
) -> Solution:
    """A descent as a solution in terms of the text; ``start`` is by default that of the energy.

    ``cut`` says why boundaries were left untried, if some were.
    """
    text, state, unknowns = energy.text, best.state, energy.unknowns
    place = unknowns.place(state.x)
    active = partial(_held_ends, energy, best)
    assert state.outcome is not None
    status, message = state.outcome
    if status == CONVERGED:
        missed = best.missed
        status = UNREACHABLE if missed else CONVERGED
        goals = [result for result in best.results if result.miss is not None]
        message = "every goal is met" if goals else "no step lowers the cost; no term has a goal"
        if missed:
            message = _explain(text, active(), missed, boundaries)
        if cut is not None and (missed or not goals):
            status, message = cut
    return Solution(
        text=text.moved_to(place),
        start=start or text,
        place=Place(place),
        cost=sum([result.cost for result in best.results]),
        iterations=best.iterations,
        status=status,
        message=message,
        terms=best.results,
        _active=active,
        _history=partial(_iterates, unknowns, best),
        elsewhere=elsewhere,
        boundaries=list(boundaries),
        _axes_free=AXES in unknowns.slices,
    )


def _iterates(unknowns: Unknowns, best: Descent) -> list[Iterate]:
    """:attr:`Solution.history`, as copies: the texts at both ends have the first and last ones."""
    return [Iterate(unknowns.value(AXES, x).copy(), cost) for x, cost in best.history]


def _held_ends(energy: Energy, best: Descent) -> Array:
    """:attr:`Solution.active`: the axes that are held at an end of their range in the font."""
    theta = energy.unknowns.value(AXES, best.state.x)
    active = np.zeros(theta.shape, dtype=int)
    if best.at_bounds is not None:
        ends = at_ends(energy.text, theta)
        active[ends] = held_axes(energy, best)[ends]
    return active


def _explain(
    text: Text, active: Array, missed: Sequence[TermResult], boundaries: Sequence[Boundary]
) -> str:
    """In words: how near the result comes to the missed goals, and which bounds limit it."""
    worst = max(missed, key=lambda result: result.shortfall)
    held = ends_reached(text, active)
    held += [str(met) for met in boundaries if not met.crossed]
    return f"{worst.missed}; {', '.join(held)}" if held else worst.missed


def ends_reached(text: Text, active: Array) -> list[str]:
    """In words: the axes that are held at an end, where ``active`` is as in :class:`Solution`."""
    letters: dict[tuple[str, str], list[str]] = {}
    for letter, axis in zip(*np.nonzero(active), strict=True):
        end = "maximum" if active[letter, axis] > 0 else "minimum"
        letters.setdefault((text.font.axes[axis].tag, end), []).append(str(letter + 1))
    return [
        f"{tag}{'' if text.shared else _of_letters(numbers, len(active))} is at its {end}"
        for (tag, end), numbers in letters.items()
    ]


def _of_letters(numbers: Sequence[str], count: int) -> str:
    """Some of ``count`` letters by their numbers, counted from 1: " of letters 1, 2 and 4"."""
    *first, last = numbers
    if not first:
        return f" of letter {last}"
    return (
        " of all letters" if len(numbers) == count else f" of letters {', '.join(first)} and {last}"
    )
