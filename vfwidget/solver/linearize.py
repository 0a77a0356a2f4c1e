"""The linear model of the residual at an iterate, with one-sided slopes at kinks.

The residual may have kinks on planes ``x_i = c``; the caller gives the numbers ``c``. They divide
the box into cells, and the residual is smooth in each of them. An iterate on a kink has one slope
on either side. The kinks are parallel to the axes, so the slope in any direction is the sum of the
one-sided partial slopes. Each coordinate on a kink therefore takes the side on which the cost
falls (the steeper one, if it falls on both), and does not move if it falls on neither. If no
coordinate can move, no direction lowers the cost, and the point is stationary.
"""

from __future__ import annotations

import math
from collections.abc import Generator

import numpy as np

from ..arrays import Array, BoolArray, between, holds_anywhere
from ..errors import SolveError
from .model import Model
from .problem import Kind, Problem, Request, State

OFFSET = 1e-8
"""The distance from a kink at which its one-sided derivative is evaluated."""


def linearize(problem: Problem, state: State) -> Generator[Request, Array, Model]:
    """The linear model at the iterate, and the range in which a step may lie.

    Raises
    ------
    SolveError
        The Jacobian has the wrong shape, or is not finite.
    """
    jacobian, low, high = yield from one_sided(problem, state)
    if jacobian.shape != (len(state.residual), len(state.x)):
        raise SolveError(
            f"The Jacobian has shape {jacobian.shape}; {len(state.residual)} residuals of "
            f"{len(state.x)} variables require {(len(state.residual), len(state.x))}."
        )
    model = problem.model(state.residual, jacobian, state.x, low, high)
    if not model.is_finite:
        raise SolveError("The Jacobian holds NaN or infinity.")
    return model


def one_sided(
    problem: Problem, state: State
) -> Generator[Request, Array, tuple[Array, Array, Array]]:
    """The Jacobian on the sides on which the cost falls, and the range of a step, low and high."""
    x = state.x
    low, high = problem.lower - x, problem.upper - x
    near = near_kinks(problem, x)
    if near is None:
        jacobian = yield Kind.JACOBIAN, x
        return jacobian, low, high
    on_kink = near.any(1)
    right, left = on_kink & (high > 0), on_kink & (low < 0)
    beyond = x + OFFSET * right - OFFSET * (on_kink & ~right)
    jacobian = yield Kind.JACOBIAN, between(beyond, problem.lower, problem.upper)
    both = left & right
    if not holds_anywhere(both):
        return jacobian, low, high
    before = x - OFFSET * left + OFFSET * (on_kink & ~left)
    other = yield Kind.JACOBIAN, between(before, problem.lower, problem.upper)
    descent_right = -problem.half_gradient(state.residual, jacobian, x)
    descent_left = problem.half_gradient(state.residual, other, x)
    take_left = both & (descent_left > 0) & (descent_left > descent_right)
    take_right = both & (descent_right > 0) & ~take_left
    jacobian = np.where(take_left, other, jacobian)
    low = np.where(both & ~take_left, 0.0, low)
    high = np.where(both & ~take_right, 0.0, high)
    return jacobian, low, high


def linearize_closely(problem: Problem, state: State) -> Generator[Request, Array, Model]:
    """As :func:`linearize`, with the limits of the one-sided slopes at kinks.

    A slope that vanishes towards the kink of another variable does not vanish beside it. The model
    then predicts a decrease that no step finds. Two points beside the kink give the limit.
    """
    requests = linearize(problem, state)
    kind, beside = next(requests)
    while True:
        near = yield kind, beside
        far = yield kind, between(2 * beside - state.x, problem.lower, problem.upper)
        limit = 2 * near - far
        limit = np.where(abs(limit) <= abs(far - near), 0.0, limit)
        try:
            kind, beside = requests.send(limit)
        except StopIteration as end:
            model: Model = end.value
            return model


def near_kinks(problem: Problem, x: Array) -> BoolArray | None:
    """On which kinks (n, q) each variable is; None if none is on any."""
    if problem.kinks is None:
        return None
    near: BoolArray = abs(problem.kinks - x[:, None]) < OFFSET
    return near if holds_anywhere(near) else None


def cell(kinks: Array, x: Array) -> tuple[Array, Array]:
    """The distances, (n,) each, from x to the next kinks: below (negative) and above."""
    gaps = kinks - x[:, None]
    below = np.where(gaps < -OFFSET, gaps, -math.inf).max(1)
    above = np.where(gaps > OFFSET, gaps, math.inf).min(1)
    return below, above
