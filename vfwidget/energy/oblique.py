"""Kinks that are not parallel to the axes, which fonts have whose axes move others (avar 2).

There a region begins at a plane of *final* coordinates, and that plane is oblique in the unknowns.
The solver takes kinks to be parallel to the axes, so it may stop on such a plane although the cost
falls along it. Where a descent has ended with a goal missed, steps along the planes are tried, and
the descent goes on from the best of them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from ..arrays import Array
from ..solver.status import ITERATION_LIMIT, OUT_OF_TIME, Outcome
from ..text.place import AXES
from .descent import Descent
from .energy import Energy

REACHES = 0.3 * 10.0 ** -np.arange(0, 4, 0.5)
"""Lengths of the steps, in normalized units."""
ON_PLANE = 1e-6
"""Final coordinates this near to a kink count as lying on it."""
MOST_STEPS = 32
MANY_STEPS = Outcome(ITERATION_LIMIT, "The cost still falls along planes of kinks.")
LEAST_GAIN = 1e-6
"""A step counts if it lowers the cost by a larger share than this."""


def along_planes(
    energy: Energy, found: Descent, descend: Callable[[Energy, Array], Descent]
) -> Descent:
    """Go on from where a descent ended on planes of kinks, as long as the cost falls along them."""
    if not energy.text.font.moves_axes or AXES not in energy.unknowns.slices:
        return found
    for _ in range(MOST_STEPS):
        if not found.missed or found.state.outcome is OUT_OF_TIME:
            return found
        tried = [(_cost(energy, found, x), x) for x in _steps(energy, found.state.x)]
        cost, x = min(tried, key=lambda one: one[0], default=(np.inf, found.state.x))
        if not cost < found.state.cost * (1 - LEAST_GAIN):
            return found
        found = descend(energy, x).after(found)
    return found._replace(state=replace(found.state, outcome=MANY_STEPS))


def _cost(energy: Energy, found: Descent, x: Array) -> float:
    residual = energy.residual(x)
    return float(found.problem.cost(residual, x)) if np.isfinite(residual).all() else np.inf


def _steps(energy: Energy, x: Array) -> Iterator[Array]:
    """Points along the planes of kinks that x lies on, within the bounds.

    A step moves one axis, and with it the axis whose final coordinate then stays as it is.
    """
    text = energy.text
    displacement = text.font.displacement
    assert displacement is not None
    theta = energy.by_letter(x)
    for letter, w in enumerate(theta):
        final = displacement.value(w)
        both = {
            side: displacement.value_and_jacobian(w, np.full(len(w), side))[1]
            for side in (-1.0, 1.0)
        }
        for i, kinks in enumerate(text.word.final_breakpoints):
            if not (abs(kinks - final[i]) < ON_PLANE).any():
                continue
            for j in range(len(w)):
                for side in (-1.0, 1.0):
                    slopes = both[side]
                    if j == i or not (slopes[i, i] and slopes[i, j]):
                        continue
                    direction = np.zeros_like(theta)
                    direction[letter, j] = side
                    direction[letter, i] = -side * slopes[i, j] / slopes[i, i]
                    for reach in REACHES:
                        moved = x + reach * energy.unknowns.flat({AXES: direction})
                        if ((moved >= energy.lower) & (moved <= energy.upper)).all():
                            yield moved
