"""A check of the derivative that a term gives, for those who write one."""

from __future__ import annotations

import numpy as np

from ..arrays import Array
from ..errors import SolveError
from ..text import Text
from .energy import Energy
from .term import Term

STEP = 1e-6


def check_derivative(term: Term, text: Text) -> float:
    """Compare the derivative of a term with central differences of its residual.

    Parameters
    ----------
    term : Term
    text : Text
        The place where the derivative is taken. Choose one away from kinks: at the default of
        an axis, for example, the two sides differ and no derivative exists.

    Returns
    -------
    float
        The largest difference by any axis value or letter offset, relative to the largest entry
        of the derivative. A correct derivative gives about 1e-6 or less.

    Raises
    ------
    SolveError
        The derivative has the wrong shape, or the term is not valid for this text.

    Examples
    --------
    >>> import vfwidget as vf
    >>> text = vf.Text("recursive", "n", axes={"wght": 537, "slnt": -4, "CASL": 0.4, "MONO": 0.3})
    >>> vf.check_derivative(vf.Distance(text.nearest(0, 0), text.nearest(500, 0), 300), text) < 1e-5
    True
    """
    if not isinstance(term, Term):
        raise SolveError(f"check_derivative(term, text) needs a Term; received {term!r:.80}.")
    energy = Energy(text, [term], free=tuple(text.blocks))
    x = energy.unknowns.start
    jacobian = energy.jacobian(x)
    expected = np.stack([_difference(energy, x, i) for i in range(len(x))], -1)
    if jacobian.shape != expected.shape:
        raise SolveError(
            f"The derivative of {term.kind} has {len(jacobian)} rows for {len(expected)} residuals."
        )
    scale = max(float(abs(expected).max(initial=0.0)), 1e-12)
    return float(abs(jacobian - expected).max(initial=0.0)) / scale


def _difference(energy: Energy, x: Array, index: int) -> Array:
    """The central difference by one unknown, (r,), one-sided at a bound."""
    low, high = x.copy(), x.copy()
    low[index] = max(x[index] - STEP, energy.lower[index])
    high[index] = min(x[index] + STEP, energy.upper[index])
    width = high[index] - low[index]
    if width == 0:
        return np.zeros(len(energy.residual(x)))
    return np.asarray((energy.residual(high) - energy.residual(low)) / width)
