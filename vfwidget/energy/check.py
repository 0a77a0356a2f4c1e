"""A check of the derivative that a term gives, for those who write one."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..arrays import Array
from ..errors import SolveError
from ..text import Text
from .energy import Energy
from .rows import wrong_rows
from .term import Term

STEP, BESIDE = 1e-6, 1e-5


def check_derivative(term: Term, text: Text) -> float:
    """Compare the derivative of a term with differences of its residual.

    Parameters
    ----------
    term : Term
    text : Text
        The derivative is evaluated at a distance of 1e-5 from it in every unknown.

    Returns
    -------
    float
        The largest difference by any axis value or letter offset, relative to the largest entry
        of the derivative. A correct derivative gives about 1e-6 or less.

    Raises
    ------
    SolveError
        The derivative has the wrong shape or is not finite, or the term is not valid for this
        text.

    Examples
    --------
    >>> import vfwidget as vf
    >>> text = vf.Text("recursive", "n", axes={"wght": 537})
    >>> vf.check_derivative(vf.Distance(text.nearest(0, 0), text.nearest(500, 0), 300), text) < 1e-5
    True
    """
    if not isinstance(term, Term):
        raise SolveError(f"check_derivative(term, text) needs a Term; received {term!r:.80}.")
    if not isinstance(text, Text):
        raise SolveError(f"check_derivative(term, text) needs a Text; received {text!r:.80}.")
    energy = Energy(text, [term], free=tuple(text.blocks))
    rows = energy.terms[0].locate(text)
    if rows is None:
        return 0.0

    def residual(x: Array) -> Array:
        return rows.residual(energy.unknowns.place(x))

    start = energy.unknowns.start
    # Near the text, towards the inside: many axes have a kink right at their default.
    x = start + np.where(start + BESIDE > energy.upper, -BESIDE, BESIDE)
    # As the solver has it: a term that is affine in name only fails here, too.
    jacobian = energy.jacobian(x)
    expected = np.stack([_central_difference(residual, x, i) for i in range(len(x))], -1)
    if jacobian.shape != expected.shape:
        raise wrong_rows(term.kind, len(jacobian), len(expected))
    if not (np.isfinite(jacobian).all() and np.isfinite(expected).all()):
        raise SolveError(
            f"The derivative of {term.kind} or its residual near the axis values of the text holds "
            "NaN or infinity, so they cannot be compared; correct the term or pass another text."
        )
    scale = max(float(abs(expected).max(initial=0.0)), 1e-12)
    return float(abs(jacobian - expected).max(initial=0.0)) / scale


def _central_difference(residual: Callable[[Array], Array], x: Array, index: int) -> Array:
    """The derivative by one unknown, (r,)."""
    step = np.zeros(len(x))
    step[index] = STEP
    return (residual(x + step) - residual(x - step)) / (2 * STEP)
