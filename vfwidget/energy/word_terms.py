"""Terms over the whole word: its axes, width and inked area, or any function of its points."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from ..arrays import Array, ArrayLike, to_array
from ..deprecation import renamed
from ..errors import SolveError
from ..outline.area import areas, swept, weighted_powers
from ..outline.arrangement import Spans, boundary
from ..outline.monotone import coefficients
from ..solver.problem import is_number
from ..text import AxisValues, Handle, Text
from ..text.colours import as_drawn
from ..text.inputs import user_values
from ..text.place import AXES
from ..text.points import PointSet
from .rows import Derivative, Rows
from .term import LARGEST, MET, Term

if TYPE_CHECKING:
    import torch


@dataclass(frozen=True)
class StayClose(Term):
    """Stay near a location of the design space: λ ‖Θ − Θ₀‖² (Sec. 5.1).

    If many locations meet the other terms equally well, it selects the nearest. It acts on the
    axes only, and not on the offsets of letters.

    Parameters
    ----------
    weight : float
        λ, in squared font units per squared normalized unit. The default 1e-3 only decides
        between solutions that meet the other terms equally well; it moves a target by far less
        than one font unit.
    theta : (1, n) or (l, n) array, optional
        Θ₀. Default: Θ at the start of the solve.
    """

    weight: float = 1e-3
    theta: ArrayLike | None = None
    tolerance = None

    def bind(self, text: Text) -> Term:
        super().bind(text)
        return self._at_goal(text)

    def rebound(self, known: Term, text: Text) -> Term | None:
        # A class derived from this one may depend on more.
        both = type(self) is type(known) is StayClose
        same = both and is_number(self.weight) and self.weight == known.weight
        return self._at_goal(text) if same else None

    def _at_goal(self, text: Text) -> StayClose:
        """The term with Θ₀ as an array in the shape of Θ."""
        if self.theta is None:
            return StayClose(self.weight, text.coordinates)
        try:
            reference, shape = to_array(self.theta), text.coordinates.shape
            if reference.shape != shape:
                fits = reference.shape[-1:] == shape[-1:]
                reference = np.broadcast_to(reference, shape) if fits else np.full(1, np.nan)
        except (TypeError, ValueError, RuntimeError):
            reference = np.full(1, np.nan)
        if not np.isfinite(reference).all():
            raise SolveError(
                f"theta must be finite numbers of shape {text.coordinates.shape}; "
                f"received {self.theta!r:.200}."
            )
        # A copy does not change with the array that was given, nor keep a larger one alive.
        return StayClose(self.weight, reference.copy())

    def locate(self, text: Text) -> Rows | None:
        return None

    def proximity(self, text: Text) -> Mapping[str, tuple[Array, Array]]:
        reference = to_array(self.theta)
        # np.full takes several times as long, and a drag asks for this at every event.
        weights = np.empty(reference.shape)
        weights.fill(self.weight)
        return {AXES: (weights, reference)}


@dataclass(frozen=True)
class AxisTarget(Term):
    """Pull axes to given values, as a preference in addition to the other terms.

    Parameters
    ----------
    axes : axis values, as for :class:`vfwidget.Text`
        Axes that are not in it are not pulled. A named instance pulls all of them.
    letter : int, optional
        Index of the letter whose axes are pulled, in a text with axes for each letter. Default:
        all letters.
    weight : float
        In squared font units per squared normalized unit. By default the way from the default to
        the end of an axis counts as much as 100 font units.
    """

    axes: AxisValues
    letter: int | None = None
    weight: float = 1e4
    tolerance = None

    def bind(self, text: Text) -> Term:
        super().bind(text)
        user_values(text.font, self.axes)
        letters = len(text.coordinates)
        if self.letter is not None:
            whole = isinstance(self.letter, int | np.integer) and not isinstance(self.letter, bool)
            if not whole or not 0 <= self.letter < letters:
                raise SolveError(
                    f"There is no letter {self.letter!r}; {text.string!r} has {letters} axis "
                    f"vectors, counted from 0."
                )
        return self

    def locate(self, text: Text) -> Rows | None:
        return None

    def proximity(self, text: Text) -> Mapping[str, tuple[Array, Array]]:
        weights, reference = np.zeros_like(text.coordinates), np.zeros_like(text.coordinates)
        values = user_values(text.font, self.axes)
        named = [axis.tag in values for axis in text.font.axes]
        rows = slice(None) if self.letter is None else self.letter
        weights[rows] = np.where(named, self.weight, 0.0)
        reference[:] = to_array(text.font.normalize(values))
        return {AXES: (weights, reference)}


@renamed(measure="width")
@dataclass(frozen=True)
class Width(Term):
    """Make each line a given width: the sum of its advance widths, kerning and tracking.

    Parameters
    ----------
    width : float
        In font units.
    weight : float
        Factor of the square. Default 1.
    """

    width: float
    weight: float = 1.0
    affine: ClassVar[bool] = True

    def bind(self, text: Text) -> Term:
        if not (_is_finite(self.width) and abs(self.width) <= LARGEST):
            raise SolveError(
                f"width must be a finite number of font units, at most {LARGEST:g}; received "
                f"{self.width!r:.200}."
            )
        return super().bind(text)

    def points(self, text: Text) -> PointSet:
        return text.word.ends

    def residual(self, points: Array, theta: Array) -> Array:
        return np.asarray(points[:, 0] - self.width)

    def derivative(self, points: Array, theta: Array) -> Derivative:
        return Derivative(points=np.eye(len(points))[..., None] * [1.0, 0.0])


@dataclass(frozen=True)
class Area(Term):
    """Keep the inked area, or set it: it measures how dark the text looks.

    Parameters
    ----------
    area : float, optional
        In squared font units. Default: the area at the start of the solve.
    weight : float
        Factor of the square. Default 1.

    Notes
    -----
    The area is that of the ink, so an area that several contours or letters cover counts once. The
    area of a colour glyph is that of its layers, and their colours do not matter. The area is exact
    (:mod:`vfwidget.outline.area`). The residual is the excess of the area, divided by the square
    root of the goal; it is in font units as those of other terms.
    """

    area: float | None = None
    weight: float = 1.0
    _contours: Any = field(default=None, repr=False)

    def bind(self, text: Text) -> Term:
        super().bind(text)
        drawn = as_drawn(text)
        if not drawn.word.contours:
            raise SolveError(f"{text.string!r} has no outline, and so no area.")
        bound = replace(self, _contours=drawn.word.contours)
        if self.area is None:
            curves, spans = bound._ink(to_array(drawn.points()))
            return replace(bound, area=float(areas(curves, spans).sum()))
        if not (_is_finite(self.area) and 0 < self.area <= LARGEST**2):
            raise SolveError(
                f"area must be a finite number > 0, at most {LARGEST**2:g} square font units; "
                f"received {self.area!r:.200}."
            )
        return bound

    def points(self, text: Text) -> PointSet:
        return as_drawn(text).point_set()

    def residual(self, points: Array, theta: Array) -> Array:
        goal = self.area or 1.0
        return np.array([areas(*self._ink(points)).sum() - goal]) / math.sqrt(goal)

    def derivative(self, points: Array, theta: Array) -> Derivative:
        curves, spans = self._ink(points)
        powers = weighted_powers(spans.start, spans.end, spans.weight)
        by = np.zeros_like(points)
        np.add.at(by, self._contours.segments, swept(curves, spans.cubic, powers))
        return Derivative(points=by[None] / math.sqrt(self.area or 1.0))

    def _ink(self, points: Array) -> tuple[Array, Spans]:
        """The curves, and the parts of them that bound the ink."""
        curves = coefficients(points[self._contours.segments])
        return curves, boundary(curves, self._contours)


@renamed(on="handles")
@dataclass(frozen=True)
class Residual(Term):
    """Any differentiable function of the text's points.

    Parameters
    ----------
    function : callable
        Maps a (p, 2) tensor of positions, in font units, to a tensor of residuals, which are zero
        where the goal is met. torch differentiates it.
    handles : sequence of Handle, optional
        The points it receives. Default: all control points of the text, in order.
    weight : float
        Factor of the squares. Default 1.
    tolerance : float or None
        The goal counts as met where no residual is larger than this. Default 0.5. None if the
        function is a preference that has no goal.

    Examples
    --------
    Keep the top of the second letter at the height of the first::

        vf.Residual(lambda p: p[:1, 1] - p[1:, 1], handles=[first, second])
    """

    function: Callable[[torch.Tensor], torch.Tensor]
    handles: Sequence[Handle] | None = None  # type: ignore[assignment]
    weight: float = 1.0
    tolerance: float | None = MET

    def bind(self, text: Text) -> Term:
        if not callable(self.function):
            raise SolveError(f"function must be callable; received {self.function!r}.")
        return super().bind(text)

    def points(self, text: Text) -> PointSet:
        return text.point_set(self.handles)

    def residual(self, points: torch.Tensor, theta: torch.Tensor) -> torch.Tensor:
        try:
            return self.function(points)
        except TypeError as error:
            raise SolveError(
                f"The function of a Residual has raised a TypeError ({error}). It receives one "
                f"tensor: points of the shape {tuple(points.shape)}."
            ) from error


def _is_finite(value: Any) -> bool:
    """Whether a value is a finite number."""
    number = isinstance(value, int | float | np.number) and not isinstance(value, bool)
    return number and math.isfinite(value)
