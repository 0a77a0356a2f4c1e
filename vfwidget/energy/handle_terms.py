"""Terms over a few outline points: pull, hold, align, measure (Sec. 5.1)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from ..arrays import Array, to_array
from ..deprecation import renamed
from ..errors import SolveError
from ..solver.problem import is_number
from ..text import Handle, Text
from .rows import Derivative
from .term import LARGEST, Term

PIN_WEIGHT = 1e5
"""Pins outweigh targets, so that a target out of reach does not move the pinned points."""


BY_POSITION = Derivative(points=np.eye(2)[:, None, :])
"""The derivative of a point by its own position."""


@dataclass(frozen=True)
class Target(Term):
    """Pull a handle to a position: ‖p(Θ, t) − x*‖² (Sec. 5.1).

    Parameters
    ----------
    handle : Handle
    position : (x, y)
        x*, in font units.
    weight : float
        Factor of the square. Default 1.
    """

    handle: Handle
    position: Any
    weight: float = 1.0
    affine: ClassVar[bool] = True

    @property
    def handles(self) -> tuple[Handle, ...]:  # type: ignore[override]
        """The handle, as a tuple."""
        return (self.handle,)

    def bind(self, text: Text) -> Term:
        super().bind(text)
        return self._toward(self._goal_at(text))

    def rebound(self, known: Term, text: Text) -> Term | None:
        return self._toward(self._goal_at(text)) if self._has_form_of(known) else None

    def _has_form_of(self, known: Term) -> bool:
        """Whether two targets or two pins differ at most in the position."""
        # A class derived from these may depend on more. bind() refuses wrong values.
        if type(self) not in (Target, Pin) or not isinstance(known, Target):
            return False
        same = type(self) is type(known) and type(self.handle) is Handle and is_number(self.weight)
        return same and (self.handle, self.weight) == (known.handle, known.weight)

    def _goal_at(self, text: Text) -> Any:
        """The position, which a term may take from the text."""
        return self.position

    def _toward(self, position: Any) -> Term:
        """The term with this position."""
        try:
            # A copy does not change with the array that was given, nor keep a larger one alive.
            goal = to_array(position).copy()
        except (TypeError, ValueError):
            goal = np.zeros(0)
        x, y = goal.tolist() if goal.shape == (2,) else (math.nan, math.nan)
        if not (-LARGEST <= x <= LARGEST and -LARGEST <= y <= LARGEST):
            raise SolveError(
                f"position must be two finite numbers (x, y), none of them beyond {LARGEST:g} font "
                f"units; received {position!r:.200}."
            )
        # dataclasses.replace takes several times as long, and a drag binds a goal at every event.
        bound = object.__new__(type(self))
        bound.__dict__.update(self.__dict__, position=goal)
        return bound

    def residual(self, points: Array, theta: Array) -> Array:
        offset: Array = points[0] - self.position
        return offset

    def derivative(self, points: Array, theta: Array) -> Derivative:
        return BY_POSITION

    def miss(self, residual: Array) -> float:
        """The distance from the position, in font units."""
        return math.hypot(*residual.tolist())


@dataclass(frozen=True)
class Pin(Target):
    """Hold a handle at its position at the start of the solve, or at a given one.

    Parameters
    ----------
    handle : Handle
    position : (x, y), optional
        In font units. Default: where the text has the handle.
    weight : float
        Factor of the square. Default 1e5, so that pins take precedence over targets.
    """

    position: Any = None
    weight: float = PIN_WEIGHT

    def _goal_at(self, text: Text) -> Any:
        return text.position(self.handle) if self.position is None else self.position


@renamed(on="handles")
@dataclass(frozen=True)
class SharedX(Term):
    """Put handles on one vertical line, whose position is free (Sec. 5.1).

    Parameters
    ----------
    handles : sequence of Handle
        Two or more outline points that the term acts on.
    weight : float
        Factor of the squares. Default 1.
    """

    handles: Sequence[Handle]  # type: ignore[assignment]
    weight: float = 1.0
    affine: ClassVar[bool] = True
    coordinate: ClassVar[int] = 0

    def bind(self, text: Text) -> Term:
        super().bind(text)
        _at_least(2, self)
        return self

    def residual(self, points: Array, theta: Array) -> Array:
        along = points[:, self.coordinate]
        return np.asarray(along - along.mean())

    def derivative(self, points: Array, theta: Array) -> Derivative:
        p = len(points)
        by = np.zeros((p, p, 2))
        by[:, :, self.coordinate] = np.eye(p) - 1 / p
        return Derivative(points=by)

    def miss(self, residual: Array) -> float:
        """The distance between the two outermost handles across the line, in font units."""
        return float(np.ptp(residual))


@renamed(on="handles")
@dataclass(frozen=True)
class SharedY(SharedX):
    """Put handles on one horizontal line, whose position is free (Sec. 5.1).

    Parameters
    ----------
    handles : sequence of Handle
        Two or more outline points that the term acts on.
    weight : float
        Factor of the squares. Default 1.
    """

    coordinate: ClassVar[int] = 1


@renamed(on="handles")
@dataclass(frozen=True)
class Collinear(Term):
    """Put handles on the straight line through the first and the last of them (Sec. 5.1).

    Parameters
    ----------
    handles : sequence of Handle
        Three or more outline points that the term acts on.
    weight : float
        Factor of the squares. Default 1.
    """

    handles: Sequence[Handle]  # type: ignore[assignment]
    weight: float = 1.0

    def bind(self, text: Text) -> Term:
        super().bind(text)
        _at_least(3, self)
        return self

    def residual(self, points: Array, theta: Array) -> Array:
        normal, _ = self._line(points)
        return np.asarray((points[1:-1] - points[0]) @ normal)

    def derivative(self, points: Array, theta: Array) -> Derivative:
        normal, length = self._line(points)
        direction = np.array([normal[1], -normal[0]])
        offset = points[1:-1] - points[0]
        # If the last point moves across the line, the line turns about its start.
        turn = (offset @ direction / length)[:, None] * normal
        inner = len(offset)
        by = np.zeros((inner, len(points), 2))
        by[np.arange(inner), np.arange(1, inner + 1)] = normal
        by[:, -1] = -turn
        by[:, 0] = turn - normal
        return Derivative(points=by)

    def _line(self, points: Array) -> tuple[Array, float]:
        """The line's unit normal and the distance between its two ends."""
        along = points[-1] - points[0]
        length = float(np.hypot(*along))
        if length == 0:
            return np.array([0.0, 1.0]), 1.0
        return np.array([-along[1], along[0]]) / length, length


@dataclass(frozen=True)
class Distance(Term):
    """Keep the distance between two handles, or set it: stem width, x-height.

    Parameters
    ----------
    first, second : Handle
    length : float, optional
        In font units. Default: the distance at the start of the solve.
    along : {None, "x", "y"}
        None (the default) measures the straight distance, "x" and "y" its horizontal and its
        vertical part.
    weight : float
        Factor of the square. Default 1.
    """

    first: Handle
    second: Handle
    length: float | None = None
    along: str | None = None
    weight: float = 1.0

    @property
    def handles(self) -> tuple[Handle, ...]:  # type: ignore[override]
        """Both handles."""
        return (self.first, self.second)

    def bind(self, text: Text) -> Term:
        super().bind(text)
        if self.along not in (None, "x", "y"):
            raise SolveError(f"along must be None, 'x' or 'y'; received {self.along!r}.")
        if self.length is None:
            here = np.stack([to_array(text.position(h)) for h in self.handles])
            return replace(self, length=self._measure(here)[0])
        if not (is_number(self.length) and 0 <= self.length <= LARGEST):
            raise SolveError(
                f"length must be a finite number from 0 to {LARGEST:g} font units; received "
                f"{self.length!r:.200}."
            )
        return self

    def residual(self, points: Array, theta: Array) -> Array:
        return np.array([self._measure(points)[0] - (self.length or 0.0)])

    def derivative(self, points: Array, theta: Array) -> Derivative:
        _, direction = self._measure(points)
        return Derivative(points=np.stack([-direction, direction])[None])

    def _measure(self, points: Array) -> tuple[float, Array]:
        """The distance, and the unit vector from the first to the second handle."""
        across = points[1] - points[0]
        if self.along is not None:
            across = across * ([1.0, 0.0] if self.along == "x" else [0.0, 1.0])
        size = float(np.hypot(*across))
        # Points that coincide have no direction; this one lets them separate, sideways if they may.
        apart = [0.0, 1.0] if self.along == "y" else [1.0, 0.0]
        return size, across / size if size > 0 else np.array(apart)


def _at_least(count: int, term: Term) -> None:
    if len(term.handles or ()) < count:
        raise SolveError(f"{type(term).__name__} needs at least {count} handles.")
