"""Terms over the whole word: its axes, its width, its ink, or any function of its points."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from ..arrays import Array, ArrayLike, to_array, to_tensor
from ..errors import SolveError
from ..outline.cubics import AREA
from ..text import Text
from ..text.word import Handle, PointSet
from .term import Derivative, Term

if TYPE_CHECKING:
    import torch


@dataclass(frozen=True)
class StayClose(Term):
    """Stay near a place of the design space: λ ‖Θ − Θ₀‖² (Sec. 5.1).

    Among the many places that meet the other terms it picks the nearest.

    Parameters
    ----------
    weight : float
        λ, in squared font units per squared normalized unit. 1e-3 settles ties and moves a
        target by far less than a unit.
    theta : (1, n) or (l, n) array, optional
        Θ₀, by default where the solve starts.
    """

    weight: float = 1e-3
    affine: ClassVar[bool] = True
    theta: ArrayLike | None = None

    def bind(self, text: Text) -> Term:
        super().bind(text)
        here = text.coordinates if self.theta is None else to_array(self.theta)
        return StayClose(self.weight, here)

    def residual(self, points: Array, theta: Array) -> Array:
        return math.sqrt(self.weight) * (theta - to_array(self.theta)).ravel()

    def derivative(self, points: Array, theta: Array) -> Derivative:
        identity = np.zeros((theta.size, theta.size))
        identity.flat[:: theta.size + 1] = math.sqrt(self.weight)
        return Derivative(theta=identity.reshape(theta.size, *theta.shape))


@dataclass(frozen=True)
class AxisTarget(Term):
    """Pull axes to values of their own, beside what the points ask for.

    Parameters
    ----------
    axes : mapping of tag to user value
    letter : int, optional
        Which letter's axes, where each has its own; by default all.
    weight : float
        In squared font units per squared normalized unit: by default an axis's whole way from
        default to end counts as much as 100 font units.
    """

    axes: Mapping[str, float]
    letter: int | None = None
    weight: float = 1e4
    affine: ClassVar[bool] = True
    _goal: Any = field(default=None, repr=False)
    _rows: Any = field(default=None, repr=False)

    def bind(self, text: Text) -> Term:
        super().bind(text)
        letters, n = text.coordinates.shape
        tags = [axis.tag for axis in text.font.axes]
        goal = to_array(text.font.normalize(self.axes))
        wanted = [i for i in range(n) if tags[i] in self.axes]
        if self.letter is not None and not 0 <= self.letter < letters:
            raise SolveError(f"There is no letter {self.letter}; {text.string!r} has {letters}.")
        rows = range(letters) if self.letter is None else [self.letter]
        index = np.array([[row, i] for row in rows for i in wanted], dtype=np.intp).reshape(-1, 2)
        return replace(self, _goal=goal[index[:, 1]], _rows=index)

    def key(self) -> Hashable:
        return super().key(), self._rows.tobytes()

    def residual(self, points: Array, theta: Array) -> Array:
        return math.sqrt(self.weight) * (theta[self._rows[:, 0], self._rows[:, 1]] - self._goal)

    def derivative(self, points: Array, theta: Array) -> Derivative:
        by = np.zeros((len(self._rows), *theta.shape))
        by[np.arange(len(self._rows)), self._rows[:, 0], self._rows[:, 1]] = 1
        return Derivative(theta=math.sqrt(self.weight) * by)


@dataclass(frozen=True)
class Width(Term):
    """Fit the line to a measure: its advance widths add up to ``measure``.

    Parameters
    ----------
    measure : float
        In font units.
    weight : float
    """

    measure: float
    weight: float = 1.0
    affine: ClassVar[bool] = True

    def bind(self, text: Text) -> Term:
        if not math.isfinite(self.measure):
            raise SolveError(f"A measure is a finite number, not {self.measure!r}.")
        return super().bind(text)

    def points(self, text: Text) -> PointSet:
        return text.word.end()

    def residual(self, points: Array, theta: Array) -> Array:
        return math.sqrt(self.weight) * (points[:, 0] - self.measure)

    def derivative(self, points: Array, theta: Array) -> Derivative:
        return Derivative(points=math.sqrt(self.weight) * np.array([[[1.0, 0.0]]]))

    def miss(self, residual: Array) -> float:
        return abs(float(residual[0])) / math.sqrt(self.weight)


@dataclass(frozen=True)
class Area(Term):
    """Keep, or come to, an area of ink: optical weight.

    Parameters
    ----------
    area : float, optional
        In squared font units; by default what it is when the solve starts.
    weight : float

    Notes
    -----
    The area is the integral of the winding number, ∮ x dy over every contour in closed form;
    where contours of one letter overlap it counts twice. The residual is its excess over the
    square root of the goal, which is in font units, as other terms' residuals are.
    """

    area: float | None = None
    weight: float = 1.0
    _contours: Any = field(default=None, repr=False)
    _sign: float = field(default=1.0, repr=False)

    def bind(self, text: Text) -> Term:
        super().bind(text)
        if not text.word.contours:
            raise SolveError(f"{text.string!r} has no outline, and so no area.")
        bound = replace(self, _contours=text.word.contours.segments)
        here = bound._measure(to_array(text.points()))
        # Outer contours run one way or the other, as the font's designer had it.
        bound = replace(bound, _sign=math.copysign(1.0, here))
        if self.area is None:
            return replace(bound, area=abs(here))
        if not (math.isfinite(self.area) and self.area > 0):
            raise SolveError(f"An area is a finite number > 0, not {self.area!r}.")
        return bound

    def points(self, text: Text) -> PointSet:
        return text.point_set()

    def residual(self, points: Array, theta: Array) -> Array:
        goal = self.area or 1.0
        return math.sqrt(self.weight / goal) * np.array([self._measure(points) - goal])

    def derivative(self, points: Array, theta: Array) -> Derivative:
        x, y = (points[self._contours, i] for i in range(2))
        by = np.zeros_like(points)
        np.add.at(by, self._contours, np.stack([y @ AREA.T, x @ AREA], -1))
        scale = self._sign * math.sqrt(self.weight / (self.area or 1.0))
        return Derivative(points=scale * by[None])

    def miss(self, residual: Array) -> float:
        return abs(float(residual[0])) / math.sqrt(self.weight)

    def _measure(self, points: Array) -> float:
        x, y = (points[self._contours, i] for i in range(2))
        return self._sign * float((x * (y @ AREA.T)).sum())


@dataclass(frozen=True)
class Residual(Term):
    """Any differentiable function of the text's points.

    Parameters
    ----------
    function : callable
        A (p, 2) tensor of positions in font units to a tensor of residuals. torch differentiates
        it.
    on : sequence of Handle, optional
        The points it is given; by default all control points of the text, in order.
    weight : float

    Examples
    --------
    Keep the second letter's top at the height of the first's::

        vf.Residual(lambda p: p[:1, 1] - p[1:, 1], on=[first, second])
    """

    function: Callable[[torch.Tensor], torch.Tensor]
    on: Sequence[Handle] | None = None
    weight: float = 1.0

    @property
    def handles(self) -> tuple[Handle, ...]:  # type: ignore[override]
        return tuple(self.on or ())

    def points(self, text: Text) -> PointSet:
        return text.point_set(None if self.on is None else self.handles)

    def residual(self, points: Array, theta: Array) -> Array:
        return math.sqrt(self.weight) * to_array(self._call(to_tensor(points)))

    def derivative(self, points: Array, theta: Array) -> Derivative:
        import torch

        # Jupyter may run this on a thread whose grad mode was never set.
        with torch.enable_grad():
            jacobian = torch.autograd.functional.jacobian(self._call, to_tensor(points))
        return Derivative(points=math.sqrt(self.weight) * to_array(jacobian))

    def _call(self, points: torch.Tensor) -> torch.Tensor:
        value = self.function(points)
        if not hasattr(value, "reshape") or not hasattr(value, "requires_grad"):
            raise SolveError(f"A Residual's function must give a tensor, not {type(value)}.")
        return value.reshape(-1)
