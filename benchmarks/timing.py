"""Contestants timed event by event, side by side, so that a busy machine slows them all alike.

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
        """Answer one event; this is what is timed."""


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
    """Seconds of each contestant at each event of each round, (contestants, rounds · events)."""

    seconds: Array

    def median(self, contestant: int) -> float:
        """Milliseconds of a typical event."""
        return float(1e3 * np.median(self.seconds[contestant]))

    def ratio(self, slow: int, fast: int) -> Spread:
        """How many times longer one took than another at the same event."""
        return Spread(*np.percentile(self.seconds[slow] / self.seconds[fast], [25, 50, 75]))


def interleave(contestants: Sequence[Contestant], events: int, rounds: int) -> Times:
    """Time every contestant at every event, in turns, a different one first each time.

    One untimed round comes before the others.
    """
    count = len(contestants)
    seconds = np.zeros((count, rounds + 1, events))
    for turn in range(rounds + 1):
        for contestant in contestants:
            contestant.start()
        for event in range(events):
            for place in range(count):
                who = (place + turn + event) % count
                begun = process_time()
                contestants[who].update(event)
                seconds[who, turn, event] = process_time() - begun
    return Times(seconds[:, 1:].reshape(count, -1))
