"""Energies over a text, and the solve that minimises their sum (Eq. 4, Sec. 5.1)."""

from .check import check_derivative
from .handle_terms import Collinear, Distance, Pin, SharedX, SharedY, Target
from .rows import Derivative
from .solution import Solution
from .solve import solve
from .term import Term, TermResult
from .word_terms import Area, AxisTarget, Residual, StayClose, Width

__all__ = [
    "Area",
    "AxisTarget",
    "Collinear",
    "Derivative",
    "Distance",
    "Pin",
    "Residual",
    "SharedX",
    "SharedY",
    "Solution",
    "StayClose",
    "Target",
    "Term",
    "TermResult",
    "Width",
    "check_derivative",
    "solve",
]
