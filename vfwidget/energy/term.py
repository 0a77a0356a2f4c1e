r"""The terms of an energy: :math:`E = \sum_i w_i \|F_i\|^2` over the unknowns (Eq. 4).

Most terms are functions of a few outline points. Such a term names its handles and gives its
residual, and where it can the derivative of that residual. The chain rule through the text
(Eq. 3) is applied by the package, so the cost of a term depends on its few points and not on the
size of the outline.

There are two steps. :meth:`Term.bind` runs once, before a solve, and takes from the text what the
term holds on to, for example the position of a pin. :meth:`Term.locate` finds the quantities that
the residual depends on, for example the planes between letters that touch. It runs once for a term
that always acts on the same points. If the points change (``moving``), it runs again between the
steps of the solver.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, NamedTuple

from ..arrays import Array
from ..errors import SolveError
from ..solver.problem import is_number
from ..text import Handle, Text
from ..text.place import Block
from ..text.points import PointSet
from .autodiff import derivative_of
from .rows import Derivative, PointRows, Rows

MET = 0.5
"""Font units: a goal that is missed by no more than this counts as met."""
LARGEST = 1e12
"""Font units beyond this have no meaning, in goals and in tolerances."""
LEAST_WEIGHT, MOST_WEIGHT = 1e-200, 1e200
"""Beyond these weights the squares of a solve leave the range of floating-point numbers."""


class Term:
    """One sum of squares in an energy; subclass it to write a new one.

    A subclass sets ``handles`` and defines :meth:`residual`. It may define :meth:`derivative`,
    which is faster than the automatic one.

    Attributes
    ----------
    handles : tuple of Handle
        The outline points whose positions :meth:`residual` receives, in this order. Default: no
        point. None stands for all control points of the text.
    weight : float
        Factor of the term's squares, greater than 0. Default 1. The package applies it; a
        residual leaves it out.
    tolerance : float or None
        The goal counts as met when :meth:`miss` is at most this, in the unit of the residual.
        Default 0.5, which suits font units. None marks a preference that has no goal, such as
        :class:`StayClose`.
    affine : bool
        Set it to True where the residual is affine in the positions and in Θ. Such terms are
        evaluated faster. :func:`check_derivative` finds a term that is not.
    moving : bool
        Set it to True where :meth:`points` or :meth:`locate` may find other points, or another
        number of residuals, at another location. Both are then called again after every step of
        the solver.

    Examples
    --------
    The tops of two letters at one height:

    >>> import vfwidget as vf
    >>> class SameHeight(vf.Term):
    ...     def __init__(self, first, second):
    ...         self.handles = (first, second)
    ...
    ...     def residual(self, points, theta):
    ...         return points[:1, 1] - points[1:, 1]
    >>> text = vf.Text("roboto-flex", "nb", shared=False)
    >>> tops = text.nearest(600, 1080), text.nearest(1600, 1080)
    >>> vf.solve(text, [SameHeight(*tops), vf.StayClose()]).status
    'converged'

    The higher one of two points, which may be the other one after a step, with a derivative:

    >>> class Height(vf.Term):
    ...     moving = True
    ...
    ...     def __init__(self, some, y):
    ...         self.some, self.y = some, y
    ...
    ...     def points(self, text):
    ...         return text.point_set([max(self.some, key=lambda h: text.position(h)[1])])
    ...
    ...     def residual(self, points, theta):
    ...         return points[:, 1] - self.y
    ...
    ...     def derivative(self, points, theta):
    ...         return vf.Derivative(points=[[[0.0, 1.0]]])
    >>> height = Height(tops, 1150)
    >>> vf.check_derivative(height, text) < 1e-5
    True
    >>> solution = vf.solve(text, [height, vf.StayClose()])
    >>> round(max(solution.text.position(top)[1].item() for top in tops))
    1150
    """

    handles: tuple[Handle, ...] = ()
    weight: float = 1.0
    tolerance: float | None = MET
    affine: ClassVar[bool] = False
    moving: ClassVar[bool] = False

    def bind(self, text: Text) -> Term:
        """The term with everything it takes from the text at the start of a solve.

        Raises
        ------
        SolveError
            The weight is not a finite number greater than 0, the tolerance is neither None nor a
            finite number of at least 0, or a handle belongs to another text.
        """
        _check_numbers(self.weight, self.tolerance)
        handles = () if self.handles is None else self.handles
        if type(handles) is not tuple and not isinstance(handles, Sequence):
            raise SolveError(
                f"handles of {self.kind} must be a sequence of handles; received {handles!r:.80}."
            )
        for handle in handles:
            if not isinstance(handle, Handle) or not text.owns(handle):
                raise SolveError(
                    f"{handle!r} is not a handle of the text {text.string!r}, which has shared="
                    f"{text.shared}. Take one from its handle() or nearest()."
                )
        return self

    def rebound(self, known: Term, text: Text) -> Term | None:
        """As :meth:`bind`, for a term that differs from one bound before only in its goal.

        A drag gives a term another goal at every event, and nothing else has to be read again.

        Parameters
        ----------
        known : Term
            A bound term of a text with the same glyphs.
        text : Text

        Returns
        -------
        Term or None
            None if the terms may differ in more than their goals, as by default. Terms that
            differ in nothing else have the same points, derivatives and weights of proximity.
        """
        return None

    def blocks(self, text: Text) -> Mapping[str, Block]:
        """Unknowns that the term adds to those of the text, by name; none by default.

        Their values reach only a term whose :meth:`locate` returns rows of its own, and not
        :meth:`residual`. A block is a ``vfwidget.text.place.Block``.
        """
        return {}

    def points(self, text: Text) -> PointSet:
        """The points that :meth:`residual` receives; by default those of ``handles``.

        A term that selects them itself returns ``text.point_set(handles)``.
        """
        return text.point_set(self.handles)

    def locate(self, text: Text) -> Rows | None:
        """The term's residual as a function of the unknowns, with the points it has at ``text``.

        By default this calls :meth:`residual` and :meth:`derivative`. A term that has no residual,
        but only a :meth:`proximity`, returns None.
        """
        automatic = type(self).derivative is Term.derivative
        return PointRows(self, self.points(text), automatic)

    def residual(self, points: Any, theta: Any) -> Any:
        """The residual (r,), in font units where it can be.

        Parameters
        ----------
        points : (p, 2) array or tensor
            Positions of the term's points, in font units.
        theta : (1, n) or (l, n) array or tensor
            Normalized coordinates.

        Returns
        -------
        (r,) array or tensor
            Zero where the goal is met. Where :meth:`derivative` is not defined, the arguments are
            tensors and the result has to be computed from them by torch operations.
        """
        raise SolveError(f"{type(self).__name__} defines no residual(points, theta).")

    def derivative(self, points: Any, theta: Any) -> Derivative:
        """The derivative of :meth:`residual`; by default automatic differentiation finds it.

        Raises
        ------
        SolveError
            The residual is not computed from its arguments by torch operations.
        """
        by_points, by_theta = derivative_of(self.residual, points, theta, self.kind)
        return Derivative(by_points, by_theta)

    def miss(self, residual: Array) -> float | None:
        """How far the goal is missed, in the unit of the residual; None for a preference.

        Parameters
        ----------
        residual : (r,) array
            The value of :meth:`residual`, without the weight.

        Returns
        -------
        float or None
            By default the largest absolute value.
        """
        if self.tolerance is None:
            return None
        return float(abs(residual).max(initial=0.0))

    def missed_by(self, miss: float) -> str:
        """A miss in words, for a report; by default in font units.

        A term whose residual has another unit, such as a ratio, defines its own words.
        """
        return f"{amount(miss)} font units"

    def proximity(self, text: Text) -> Mapping[str, tuple[Array, Array]]:
        """Squares of the unknowns themselves: Σ weights · (value − reference)².

        Returns
        -------
        mapping of block name to (weights, reference)
            Two arrays of the block's shape; the term's weight is included. None by default.
        """
        return {}

    @property
    def kind(self) -> str:
        """The name of the term's class."""
        return type(self).__name__

    def label(self) -> str:
        """The kind of the term and the letters that it acts on, for a report."""
        return " ".join([self.kind, *(handle.letter_name for handle in self.handles or ())])


def amount(miss: float) -> str:
    """A miss with one decimal; a smaller one, which would be 0.0, with two digits."""
    return f"{miss:.1f}" if miss == 0 or miss >= 0.1 else f"{miss:.2g}"


class TermResult(NamedTuple):
    """One term, evaluated where a solve ended.

    Attributes
    ----------
    term : Term
    miss : float or None
        How far its goal is missed, in the unit of :meth:`Term.miss`; None for a term without a
        goal.
    cost : float
        Its share of E, in squared font units.
    """

    term: Term
    miss: float | None
    cost: float

    @property
    def met(self) -> bool:
        """Whether the goal is met; True for a term without a goal."""
        tolerance = self.term.tolerance
        return self.miss is None or tolerance is None or self.miss <= tolerance

    @property
    def shortfall(self) -> float:
        """By how many times its tolerance the goal is missed."""
        return (self.miss or 0.0) / (self.term.tolerance or 1.0)

    @property
    def missed(self) -> str:
        """By how much its goal is missed, in words."""
        return f"{self.term.label()} is missed by {self.term.missed_by(self.miss or 0.0)}"


def _check_numbers(weight: Any, tolerance: Any) -> None:
    if not (is_number(weight) and 0 < weight < math.inf):
        raise SolveError(f"weight must be a finite number > 0; received {weight!r}.")
    if not LEAST_WEIGHT <= float(weight) <= MOST_WEIGHT:
        raise SolveError(
            f"weight must be between {LEAST_WEIGHT:g} and {MOST_WEIGHT:g}; received {weight!r}."
        )
    if tolerance is not None and not (is_number(tolerance) and 0 <= tolerance <= LARGEST):
        raise SolveError(
            f"tolerance must be None or a number from 0 to {LARGEST:g}; received "
            f"{tolerance!r:.200}."
        )
