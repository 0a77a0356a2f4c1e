"""Time contestants drag by drag, in turns, so that a busy machine slows all of them equally.

The time is the processor time of this process, which depends little on other programs. All
contestants use one thread, so on an idle machine it equals the elapsed time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from time import process_time
from typing import NamedTuple, Protocol, TypeAlias

import numpy as np
import numpy.typing as npt

Array: TypeAlias = npt.NDArray[np.float64]
TURN = 0.1
"""Seconds for which a contestant is called in a row in each turn, at least once. The first calls
find the caches of the processor full of the other contestant's data, which lengthens a call of a
few milliseconds by a fifth to a half."""


class Contestant(Protocol):
    """A method that handles the same events as the others."""

    def start(self) -> None:
        """Return to the state before the first event; this is not timed."""

    def update(self, event: int) -> None:
        """Handle one event."""


class Spread(NamedTuple):
    """Quartiles and median of a sample."""

    low: float
    median: float
    high: float

    def __str__(self) -> str:
        digits = 1 if self.median >= 1.95 else 2
        return f"{self.median:.{digits}f}× ({self.low:.{digits}f}–{self.high:.{digits}f})"


@dataclass(frozen=True)
class Times:
    """Seconds per event of each contestant in each round, (contestants, rounds)."""

    seconds: Array

    def median(self, contestant: int) -> float:
        """Median time of an event, in milliseconds."""
        return float(1e3 * np.median(self.seconds[contestant]))

    def ratio(self, slow: int, fast: int) -> Spread:
        """Ratio of the times of two contestants in the same round."""
        return Spread(*np.percentile(self.seconds[slow] / self.seconds[fast], [25, 50, 75]))


def interleave(contestants: Sequence[Contestant], events: int, rounds: int) -> Times:
    """Time whole drags of all contestants, which take turns; the first one alternates.

    In its turn a contestant repeats the drag for :data:`TURN` seconds, and the mean counts. One
    untimed round precedes the others.
    """
    count = len(contestants)
    seconds = np.zeros((count, rounds + 1))
    for turn in range(rounds + 1):
        for place in range(count):
            who = (place + turn) % count
            drags: list[float] = []
            while sum(drags) < TURN:
                contestants[who].start()
                begun = process_time()
                for event in range(events):
                    contestants[who].update(event)
                drags.append(process_time() - begun)
            seconds[who, turn] = np.mean(drags) / events
    return Times(seconds[:, 1:])
