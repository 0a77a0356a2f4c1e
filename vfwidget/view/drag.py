"""One drag event as an energy: a target, pins and a weak pull to the press (Sec. 5.1)."""

from __future__ import annotations

from collections.abc import Sequence

from ..energy.handle_terms import Pin, Target
from ..energy.solution import Solution
from ..energy.solve import solve
from ..energy.term import Term
from ..energy.word_terms import StayClose
from ..text import Handle, Text

CALM = 0.001
"""√λ of Sec. 5.1, in ems: a drag moves an axis over its range only if it gains more than this."""
MOVE_ITERATIONS = 30
RELEASE_ITERATIONS = 200
RESTARTS = 8
RESTART_SECONDS = 0.15
"""The search for a better place ends after this time, so that the kernel stays ready."""


def solve_drag(
    start: Text,
    press: Text,
    target: Target,
    pins: Sequence[Handle] = (),
    locks: Sequence[str] = (),
    *,
    released: bool = False,
) -> Solution:
    """Solve for the place to which the outline is dragged.

    Everything is measured from the press, so that the path of the pointer does not matter.

    Parameters
    ----------
    start : Text
        Where the solver sets out.
    press : Text
        The text when the pointer was pressed. Pins hold their positions there.
    target : Target
    pins : sequence of Handle
    locks : sequence of str
        Tags of axes that keep their values.
    released : bool
        Whether the pointer was released. Only then does the solver also look for a better place
        away from this one, because while the pointer moves, the letter must not jump.

    Returns
    -------
    Solution
    """
    terms: list[Term] = [target]
    terms.append(StayClose((CALM * press.font.units_per_em) ** 2, press.theta))
    terms += [Pin(pin, press.position(pin)) for pin in pins if pin != target.handle]
    return solve(
        start,
        terms,
        locks=locks,
        max_iterations=RELEASE_ITERATIONS if released else MOVE_ITERATIONS,
        restarts=RESTARTS if released else 0,
        restart_seconds=RESTART_SECONDS,
    )
