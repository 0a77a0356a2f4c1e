r"""The terms of an energy over points of a text: :math:`E(\Theta) = \sum \|F_i\|^2` (Eq. 4).

A term names the handles it touches, its residual as a function of their positions (and of Θ),
and that residual's derivative. The chain rule through the text (Eq. 3) is the solver's, so a
term costs what its few handles cost, not what the outline does.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from .arrays import Array, ArrayLike, to_array, to_tensor
from .errors import SolveError
from .text import Text
from .word import Handle, PointSet

if TYPE_CHECKING:
    import torch

PIN_WEIGHT = 1e5
"""Pins outweigh targets: a target that is out of reach must not drag the pins along."""


@dataclass(frozen=True)
class Derivative:
    """What a term's residual (r,) depends on.

    Attributes
    ----------
    points : (r, p, 2) array, optional
        By the positions of the term's points.
    theta : (r, parameters, n) array, optional
        By Θ directly.
    """

    points: Array | None = None
    theta: Array | None = None


class Term:
    """One sum of squares in the energy; subclass it for new ones.

    Attributes
    ----------
    weight : float
        Multiplies the term's squares.
    handles : tuple of Handle
    """

    weight: float
    handles: tuple[Handle, ...] = ()

    def bind(self, text: Text) -> Term:
        """The term with whatever it takes from the text a solve starts from.

        Raises
        ------
        SolveError
            A handle of another text, or numbers that are not finite.
        """
        if not (math.isfinite(self.weight) and self.weight >= 0):
            raise SolveError(f"A weight is a finite number ≥ 0, not {self.weight!r}.")
        for handle in self.handles:
            if not isinstance(handle, Handle) or not text.owns(handle):
                raise SolveError(f"{handle!r} is not a handle of the text {text.string!r}.")
        return self

    def points(self, text: Text) -> PointSet:
        """The points of the text that :meth:`residual` is given."""
        return text.point_set(self.handles)

    def residual(self, points: Array, theta: Array) -> Array:
        """Residual (r,) at positions (p, 2) and Θ (parameters, n)."""
        raise NotImplementedError

    def derivative(self, points: Array, theta: Array) -> Derivative:
        """Derivative of :meth:`residual`."""
        raise NotImplementedError

    def miss(self, points: Array) -> float:
        """How far, in font units, the term is from being met; 0 for one that has no such goal."""
        return 0.0


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

    @property
    def handles(self) -> tuple[Handle, ...]:  # type: ignore[override]
        return (self.handle,)

    def bind(self, text: Text) -> Term:
        super().bind(text)
        position = to_array(self.position)
        if position.shape != (2,) or not np.isfinite(position).all():
            raise SolveError(f"A target is a place (x, y), not {self.position!r}.")
        return replace(self, position=position)

    def residual(self, points: Array, theta: Array) -> Array:
        return math.sqrt(self.weight) * (points[0] - self.position)

    def derivative(self, points: Array, theta: Array) -> Derivative:
        return Derivative(points=math.sqrt(self.weight) * np.eye(2)[:, None, :])

    def miss(self, points: Array) -> float:
        return float(np.hypot(*(points[0] - self.position)))


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
    theta: ArrayLike | None = None

    def bind(self, text: Text) -> Term:
        super().bind(text)
        return replace(self, theta=to_array(text.theta if self.theta is None else self.theta))

    def residual(self, points: Array, theta: Array) -> Array:
        return math.sqrt(self.weight) * (theta - to_array(self.theta)).ravel()

    def derivative(self, points: Array, theta: Array) -> Derivative:
        identity = np.eye(theta.size).reshape(theta.size, *theta.shape)
        return Derivative(theta=math.sqrt(self.weight) * identity)


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
