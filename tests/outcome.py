"""What an attack came to: how many inputs were refused or read, and what they took."""

from __future__ import annotations

import resource
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Any

import vfwidget as vf

SECONDS, GIBIBYTES = 2.0, 1.0
"""What one input may take."""


@dataclass
class Outcome:
    """What an attack came to: inputs by result, and the most that one input took."""

    attack: str
    tried: int = 0
    refused: int = 0
    read: int = 0
    failures: list[str] = field(default_factory=list)
    seconds: float = 0.0
    gibibytes: float = 0.0

    def try_all(self, inputs: Iterable[Any], act: Callable[[Any], object]) -> Outcome:
        """Act on each input, and count which exceptions it raises."""
        started = _peak()
        for given in inputs:
            begun = time.process_time()
            self.tried += 1
            try:
                act(given)
                self.read += 1
            except vf.VFWidgetError:
                self.refused += 1
            except Exception as error:
                self.failures.append(repr(error)[:200])
            self.seconds = max(self.seconds, time.process_time() - begun)
        self.gibibytes = _peak() - started
        return self

    @property
    def holds(self) -> bool:
        """Whether every input was refused or read, in time and within the memory."""
        return not self.failures and self.seconds <= SECONDS and self.gibibytes <= GIBIBYTES


def _peak() -> float:
    """The most memory that this process has used, in GiB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
