"""The words that say how a solve has ended; every solver of the package uses them."""

from __future__ import annotations

from typing import NamedTuple

CONVERGED = "converged"
"""No step lowers the cost by more than the tolerances."""
STALLED = "stalled"
"""The model predicts a decrease of the cost that no step achieves. The derivative may be wrong,
the residual may jump, or it may have a kink that the solver does not know."""
ITERATION_LIMIT = "iteration_limit"
"""The solve took the largest number of steps that it was allowed."""
TIME_LIMIT = "time_limit"
"""The time that the solve was allowed has passed."""


class Outcome(NamedTuple):
    """How a solve has ended.

    Attributes
    ----------
    status : str
        One of the words of this module.
    message : str
        The reason, in a sentence.
    """

    status: str
    message: str


COST_FLOOR = Outcome(CONVERGED, "The cost is at or below its floor.")
STATIONARY = Outcome(CONVERGED, "No direction lowers the cost.")
SMALL_DECREASE = Outcome(CONVERGED, "No step lowers the cost by more than the tolerance.")
SMALL_STEP = Outcome(CONVERGED, "Steps are shorter than the tolerance.")
NO_DECREASE = Outcome(
    STALLED,
    "The derivative predicts a lower cost, but no step finds it. Check the Jacobian, and whether "
    "the residual has kinks or jumps that are not listed.",
)
NOT_FALLING = Outcome(
    STALLED, "The cost does not fall any more when the residual is renewed between steps."
)
OUT_OF_TIME = Outcome(TIME_LIMIT, "The time limit was reached before the solve converged.")


def out_of_iterations(limit: int) -> Outcome:
    """The outcome of a solve that has reached its iteration limit."""
    return Outcome(
        ITERATION_LIMIT, f"The iteration limit, {limit}, was reached before the solve converged."
    )
