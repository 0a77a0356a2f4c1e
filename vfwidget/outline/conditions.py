"""Conditions on coordinates: whether a part of an outline is shown at some location."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import like, namespace
from .composed import Coordinates
from .varying import Varying


class Condition(ABC):
    """A function of coordinates (..., n) that is 1 where it holds and else 0."""

    @abstractmethod
    def value(self, w: Any) -> Any:
        """1 or 0 at w, (...)."""


@dataclass(frozen=True)
class InRange(Condition):
    """Coordinate ``axis`` lies between ``low`` and ``high``, both included."""

    axis: int
    low: float
    high: float

    def value(self, w: Any) -> Any:
        """See :meth:`Condition.value`."""
        x = w[..., self.axis]
        return _number((x >= self.low) & (x <= self.high), w)


@dataclass(frozen=True)
class Positive(Condition):
    """A quantity of shape () is above 0."""

    quantity: Varying

    def value(self, w: Any) -> Any:
        """See :meth:`Condition.value`."""
        return _number(self.quantity.value(w) > 0, w)


@dataclass(frozen=True)
class AllOf(Condition):
    """All of several conditions hold."""

    parts: Sequence[Condition]

    def value(self, w: Any) -> Any:
        """See :meth:`Condition.value`."""
        return namespace(w).stack([part.value(w) for part in self.parts], -1).prod(-1)


@dataclass(frozen=True)
class Not(Condition):
    """A condition does not hold."""

    part: Condition

    def value(self, w: Any) -> Any:
        """See :meth:`Condition.value`."""
        return 1 - self.part.value(w)


@dataclass(frozen=True)
class At(Condition):
    """A condition on coordinates that follow from others."""

    part: Condition
    inner: Coordinates

    def value(self, w: Any) -> Any:
        """See :meth:`Condition.value`."""
        return self.part.value(self.inner.value(w))


def _number(holds: Any, w: Any) -> Any:
    return like(np.ones(()), w) * holds
