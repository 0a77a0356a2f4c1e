"""Terms over a handful of outline points: pull, hold, align, measure (Sec. 5.1)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from ..arrays import Array, to_array
from ..errors import SolveError
from ..text import Text
from ..text.word import Handle
from .term import Derivative, Term

PIN_WEIGHT = 1e5
"""Pins outweigh targets: a target that is out of reach must not drag the pins along."""


@dataclass(frozen=True)
class Target(Term):
    """Pull a handle to a place: ‖p(Θ, t) − x*‖² (Sec. 5.1).

    Parameters
    ----------
    handle : Handle
    position : (x, y)
        In the text's font units.
    weight : float
    """

    handle: Handle
    position: Any
    weight: float = 1.0
    affine: ClassVar[bool] = True

    @property
    def handles(self) -> tuple[Handle, ...]:  # type: ignore[override]
        return (self.handle,)

    def bind(self, text: Text) -> Term:
        super().bind(text)
        position = to_array(self.position)
        if position.shape != (2,) or not np.isfinite(position).all():
            raise SolveError(f"A target is a place (x, y), not {self.position!r}.")
        return self if position is self.position else replace(self, position=position)

    def residual(self, points: Array, theta: Array) -> Array:
        return math.sqrt(self.weight) * (points[0] - self.position)

    def derivative(self, points: Array, theta: Array) -> Derivative:
        return Derivative(points=math.sqrt(self.weight) * np.eye(2)[:, None, :])

    def miss(self, residual: Array) -> float:
        return math.hypot(*residual) / math.sqrt(self.weight)


@dataclass(frozen=True)
class Pin(Target):
    """Hold a handle where it is when the solve starts, or at a given place.

    Parameters
    ----------
    handle : Handle
    position : (x, y), optional
        By default where the text has the handle.
    weight : float
        By default large, so that pins hold in preference to targets.
    """

    position: Any = None
    weight: float = PIN_WEIGHT

    def bind(self, text: Text) -> Term:
        Term.bind(self, text)
        here = text.position(self.handle) if self.position is None else self.position
        return Target.bind(replace(self, position=here), text)


@dataclass(frozen=True)
class SharedX(Term):
    """Handles that lie on one vertical line, wherever it is (Sec. 5.1).

    Parameters
    ----------
    on : sequence of Handle
        Two or more.
    weight : float
    """

    on: Sequence[Handle]
    weight: float = 1.0
    affine: ClassVar[bool] = True
    coordinate: ClassVar[int] = 0

    @property
    def handles(self) -> tuple[Handle, ...]:  # type: ignore[override]
        return tuple(self.on)

    def bind(self, text: Text) -> Term:
        _at_least(2, self)
        return super().bind(text)

    def residual(self, points: Array, theta: Array) -> Array:
        along = points[:, self.coordinate]
        return math.sqrt(self.weight) * (along - along.mean())

    def derivative(self, points: Array, theta: Array) -> Derivative:
        p = len(points)
        by = np.zeros((p, p, 2))
        by[:, :, self.coordinate] = math.sqrt(self.weight) * (np.eye(p) - 1 / p)
        return Derivative(points=by)

    def miss(self, residual: Array) -> float:
        return float(np.ptp(residual)) / math.sqrt(self.weight)


@dataclass(frozen=True)
class SharedY(SharedX):
    """Handles that lie on one horizontal line, wherever it is (Sec. 5.1).

    Parameters
    ----------
    on : sequence of Handle
        Two or more.
    weight : float
    """

    coordinate: ClassVar[int] = 1


@dataclass(frozen=True)
class Collinear(Term):
    """Handles that lie on the straight line through the first and the last (Sec. 5.1).

    Parameters
    ----------
    on : sequence of Handle
        Three or more.
    weight : float
    """

    on: Sequence[Handle]
    weight: float = 1.0

    @property
    def handles(self) -> tuple[Handle, ...]:  # type: ignore[override]
        return tuple(self.on)

    def bind(self, text: Text) -> Term:
        _at_least(3, self)
        return super().bind(text)

    def residual(self, points: Array, theta: Array) -> Array:
        normal, _ = self._line(points)
        return math.sqrt(self.weight) * ((points[1:-1] - points[0]) @ normal)

    def derivative(self, points: Array, theta: Array) -> Derivative:
        normal, length = self._line(points)
        direction = np.array([normal[1], -normal[0]])
        offset = points[1:-1] - points[0]
        # Turning the line about its start by the last point's move across it.
        turn = (offset @ direction / length)[:, None] * normal
        inner = len(offset)
        by = np.zeros((inner, len(points), 2))
        by[np.arange(inner), np.arange(1, inner + 1)] = normal
        by[:, -1] = -turn
        by[:, 0] = turn - normal
        return Derivative(points=math.sqrt(self.weight) * by)

    def miss(self, residual: Array) -> float:
        return float(np.abs(residual).max()) / math.sqrt(self.weight)

    def _line(self, points: Array) -> tuple[Array, float]:
        """The line's unit normal and the distance between its two ends."""
        along = points[-1] - points[0]
        length = float(np.hypot(*along))
        if length == 0:
            return np.array([0.0, 1.0]), 1.0
        return np.array([-along[1], along[0]]) / length, length


@dataclass(frozen=True)
class Distance(Term):
    """Two handles that keep, or come to, a distance: stem width, x-height.

    Parameters
    ----------
    first, second : Handle
    length : float, optional
        In font units; by default what it is when the solve starts.
    along : {None, "x", "y"}
        Measure straight, or only across or only up.
    weight : float
    """

    first: Handle
    second: Handle
    length: float | None = None
    along: str | None = None
    weight: float = 1.0

    @property
    def handles(self) -> tuple[Handle, ...]:  # type: ignore[override]
        return (self.first, self.second)

    def bind(self, text: Text) -> Term:
        super().bind(text)
        if self.along not in (None, "x", "y"):
            raise SolveError(f"A distance is measured along None, 'x' or 'y', not {self.along!r}.")
        if self.length is None:
            here = np.stack([to_array(text.position(h)) for h in self.handles])
            return replace(self, length=self._measure(here)[0])
        if not (math.isfinite(self.length) and self.length >= 0):
            raise SolveError(f"A distance is a finite number ≥ 0, not {self.length!r}.")
        return self

    def residual(self, points: Array, theta: Array) -> Array:
        return math.sqrt(self.weight) * np.array([self._measure(points)[0] - (self.length or 0.0)])

    def derivative(self, points: Array, theta: Array) -> Derivative:
        _, direction = self._measure(points)
        return Derivative(points=math.sqrt(self.weight) * np.stack([-direction, direction])[None])

    def miss(self, residual: Array) -> float:
        return abs(float(residual[0])) / math.sqrt(self.weight)

    def _measure(self, points: Array) -> tuple[float, Array]:
        """The distance and the unit vector along which it grows."""
        across = points[1] - points[0]
        if self.along is not None:
            across = across * ([1.0, 0.0] if self.along == "x" else [0.0, 1.0])
        size = float(np.hypot(*across))
        # Points that coincide part sideways, if at all.
        return size, across / size if size > 0 else np.array([1.0, 0.0])


def _at_least(count: int, term: Term) -> None:
    if len(term.handles) < count:
        raise SolveError(f"{type(term).__name__} needs at least {count} handles.")
