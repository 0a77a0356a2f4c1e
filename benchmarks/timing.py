"""Contestants timed drag by drag, in turns, so that a busy machine slows them all alike.

The time is this process's own processor time: what others do on the machine counts as little as
can be. All contestants compute in one thread, where on a quiet machine it is the time that passes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from time import process_time
from typing import NamedTuple, Protocol, TypeAlias

import numpy as np
import numpy.typing as npt

Array: TypeAlias = npt.NDArray[np.float64]


class Contestant(Protocol):
    """Something that goes through the same events as its rivals."""

    def start(self) -> None:
        """Go back to before the first event; not timed."""

    def update(self, event: int) -> None:
        """Answer one event."""


class Spread(NamedTuple):
    """The middle half of a sample."""

    low: float
    median: float
    high: float

    def __str__(self) -> str:
        digits = 1 if self.median >= 1.95 else 2
        return f"{self.median:.{digits}f}× ({self.low:.{digits}f}–{self.high:.{digits}f})"


@dataclass(frozen=True)
class Times:
    """Seconds an event took each contestant in each round, (contestants, rounds)."""

    seconds: Array

    def median(self, contestant: int) -> float:
        """Milliseconds of a typical event."""
        return float(1e3 * np.median(self.seconds[contestant]))

    def ratio(self, slow: int, fast: int) -> Spread:
        """How many times longer one took than another in the same round."""
        return Spread(*np.percentile(self.seconds[slow] / self.seconds[fast], [25, 50, 75]))


def interleave(contestants: Sequence[Contestant], events: int, rounds: int) -> Times:
    """Time whole drags of every contestant, in turns, a different one first each time.

    One untimed round comes before the others. A drag is timed as a whole, for its events follow
    one another: a rival in between would find and leave the processor's caches full of its own.
    """
    count = len(contestants)
    seconds = np.zeros((count, rounds + 1))
    for turn in range(rounds + 1):
        for place in range(count):
            who = (place + turn) % count
            contestants[who].start()
            begun = process_time()
            for event in range(events):
                contestants[who].update(event)
            seconds[who, turn] = (process_time() - begun) / events
    return Times(seconds[:, 1:])
