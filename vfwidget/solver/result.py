"""The result of :func:`vfwidget.least_squares`."""

from __future__ import annotations

import html
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array, to_array

SHOWN = 6
"""At most this many numbers of x are shown in a ``repr``."""


class Iterate(NamedTuple):
    """A point of a solve and its cost."""

    x: Any
    cost: Any


@dataclass(frozen=True, repr=False)
class Result:
    """The result of :func:`vfwidget.least_squares`.

    Attributes have a leading dimension B if the start has one; ``status`` and ``message`` are
    then lists.

    Attributes
    ----------
    x : (n,) array or tensor
        The best point; of the same kind as ``x0``.
    cost : float
        The sum of the squared residuals at x (scipy reports half of it), or of the loss.
    residual : (m,) array or tensor
    iterations : int
        The number of accepted steps.
    status : str
        How the solve has ended: ``"converged"``, ``"stalled"`` or ``"iteration_limit"``; see
        :mod:`vfwidget.solver.status`.
    message : str
        The reason, in a sentence.
    converged : bool
        Whether the status is ``"converged"``.
    history : list of Iterate
        The start and the best point after each accepted step.
    """

    x: Any
    cost: Any
    residual: Any
    iterations: Any
    status: Any
    message: Any
    converged: Any
    history: list[Iterate]
    _active: Callable[[], Array] = field(compare=False)

    @cached_property
    def active(self) -> Array:
        """-1 or 1, (n,), for a variable held at its lower or upper bound, else 0.

        The cost would fall if the variable could pass the bound. The first use may evaluate a
        Jacobian.
        """
        return self._active()

    def _lines(self) -> list[str]:
        x = to_array(self.x)
        if x.ndim == 2:
            done = int(np.count_nonzero(self.converged))
            costs = to_array(self.cost)
            return [
                f"{len(x)} problems of {x.shape[1]} variables: {done} converged",
                f"cost {costs.min():.4g} to {costs.max():.4g}",
            ]
        numbers = ", ".join(f"{value:.4g}" for value in x[:SHOWN])
        more = f", … ({len(x)} variables)" if len(x) > SHOWN else ""
        return [
            f"{self.status} after {self.iterations} iterations: {self.message}",
            f"cost {self.cost:.4g}",
            f"x [{numbers}{more}]",
        ]

    def __repr__(self) -> str:
        return "<Result: " + "\n ".join(self._lines()) + ">"

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(chr(10).join(self._lines()))}</pre>"
