"""The two optimisers of a fit: damped Gauss–Newton on the residual picture, and Adam."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..arrays import Array, BoolArray
from ..errors import ImageError
from ..solver import least_squares
from ..solver.loss import LOSSES, rescale, rho, robust_cost
from .scene import PLACEMENT, Scene, State

FITTED = (*PLACEMENT, "blur", "light")
"""What can be fitted beside the axes."""
OPTIMIZERS = ("gauss-newton", "adam")
LEARNING_RATE = 0.03
"""Of Adam, in normalized coordinates; other variables move by their own ranges' share."""
LOSS_SCALE = 0.1
"""Residuals from this share of the contrast on count as outliers."""
MOST_TURN, MOST_BLUR = 0.6, 0.05
"""Radians; and a standard deviation, as a share of the picture's longer side."""
FAINT = 3e-5
"""The change of a pixel, relative to the loss's scale, that is not worth a step."""
LEAST_NOISE = 0.5 / 255
"""A pixel's standard deviation: levels are written in steps of 1 / 255."""
NUDGE = 1e-6
NULL, TAKES_PART = 1e-10, 1e-3
"""Relative to the greatest, an eigenvalue that is none; and a share in its vector that counts."""

Watch = Callable[[Array, float], None]


@dataclass(frozen=True)
class Options:
    """How to fit.

    Attributes
    ----------
    fitted : tuple of str
        Of :data:`FITTED`.
    optimizer : {"gauss-newton", "adam"}
    loss : str
        Of :data:`..loss.LOSSES`.
    """

    fitted: tuple[str, ...]
    optimizer: str = "gauss-newton"
    loss: str = "soft_l1"

    def __post_init__(self) -> None:
        unknown = [name for name in self.fitted if name not in FITTED]
        if unknown:
            raise ImageError(f"{unknown[0]!r} cannot be fitted: choose of {', '.join(FITTED)}.")
        if self.optimizer not in OPTIMIZERS:
            names = ", ".join(OPTIMIZERS)
            raise ImageError(f"There is no optimizer {self.optimizer!r}: choose one of {names}.")
        if self.loss not in LOSSES:
            raise ImageError(f"There is no loss {self.loss!r}: choose one of {', '.join(LOSSES)}.")


class Problem:
    """A picture to be matched by a scene of the same resolution: what is free, and its range."""

    def __init__(self, scene: Scene, image: Array, start: State, options: Options) -> None:
        self.scene, self.target, self.start, self.options = scene, image, start, options
        self.scale = LOSS_SCALE * max(abs(start.ink - start.light[0]), 0.05)
        self.free = self._free()
        lower, upper = self._bounds()
        self.lower, self.upper = lower[self.free], upper[self.free]
        breakpoints = scene.text.breakpoints * scene.text.word.parameters
        kinks = [*breakpoints, *([np.zeros(0)] * (len(self.free) - start.theta.size))]
        self.kinks = [values for values, free in zip(kinks, self.free, strict=True) if free]

    def _free(self) -> BoolArray:
        fitted = self.options.fitted
        other = [name in fitted for name in (*PLACEMENT, "blur")]
        light = ["light" in fitted] * (len(self.start.light) + 1)
        return np.array([True] * self.start.theta.size + other + light)

    def _bounds(self) -> tuple[Array, Array]:
        start, scene = self.start, self.scene
        lower, upper = scene.text.word.bounds
        height, width = (side * scene.factor for side in scene.shape)
        x, y, size, turn = start.placement
        reach = np.array([width / 4, height / 4, 0.7, MOST_TURN])
        place = np.array([x, y, size, turn])
        most = (MOST_BLUR * max(height, width)) ** 2
        light = np.full(len(start.light) + 1, 2.0)
        light[-1] = 1.5
        return (
            np.concatenate([lower, place - reach, [0.0], -light]),
            np.concatenate([upper, place + reach, [max(most, start.blur)], light]),
        )

    def state(self, x: Array) -> State:
        """The state at the free variables' values."""
        flat = self.start.flat()
        flat[self.free] = x
        return self.start.like(flat)

    @property
    def x0(self) -> Array:
        """Where the free variables start."""
        return np.clip(self.start.flat()[self.free], self.lower, self.upper)

    def residual(self, x: Array) -> Array:
        """The residual picture, flat."""
        return (self.scene.image(self.state(x)) - self.target).ravel()

    def jacobian(self, x: Array) -> Array:
        """Its derivative by the free variables."""
        jacobian = self.scene.jacobian(self.state(x), self.free)
        return jacobian.reshape(len(jacobian), -1).T

    def loss(self, residual: Array) -> float:
        """The mean cost of a pixel."""
        return float(robust_cost(residual, self.options.loss, self.scale)) / len(residual)


@dataclass(frozen=True)
class Fit:
    """Where a fit ended.

    Attributes
    ----------
    problem : Problem
    state : State
    loss : float
        The mean cost of a pixel.
    iterations : int
    converged : bool
    path : list of State
        After every step, the start included.
    """

    problem: Problem
    state: State
    loss: float
    iterations: int
    converged: bool
    path: list[State]


def fit(problem: Problem, max_iterations: int, watch: Watch | None = None) -> Fit:
    """Fit with the optimiser that the options name."""
    if problem.options.optimizer == "adam":
        return _adam(problem, max_iterations, watch)
    return _gauss_newton(problem, max_iterations, watch)


def _gauss_newton(problem: Problem, max_iterations: int, watch: Watch | None) -> Fit:
    best = np.inf

    def watched(x: Array) -> Array:
        nonlocal best
        values = problem.residual(x)
        loss = problem.loss(values)
        if watch is not None and loss < best:
            best = loss
            watch(problem.state(x).theta, loss)
        return values

    found = least_squares(
        problem.residual if watch is None else watched,
        problem.x0,
        problem.jacobian,
        (problem.lower, problem.upper),
        kinks=problem.kinks,
        loss=problem.options.loss,
        loss_scale=problem.scale,
        max_iterations=max_iterations,
        cost_tolerance=1e-5,
        step_tolerance=1e-7,
        gain_tolerance=FAINT**2 * problem.target.size * problem.scale**2,
        gradient_tolerance=1e-7,
    )
    path = [problem.state(x) for x, _ in found.history]
    loss = float(found.cost) / problem.target.size
    return Fit(problem, problem.state(found.x), loss, found.iterations, found.converged, path)


def _adam(problem: Problem, max_iterations: int, watch: Watch | None) -> Fit:
    """Adam (Kingma and Ba 2015) as the paper uses it, Θ projected onto its bounds."""
    import torch

    unit = np.minimum((problem.upper - problem.lower) / 2, 1e3)
    x = torch.tensor(problem.x0 / unit)
    optimizer = torch.optim.Adam([x], lr=LEARNING_RATE)
    best, best_loss = problem.x0, np.inf
    path = []
    for _ in range(max_iterations + 1):
        here = x.numpy() * unit
        values = problem.residual(here)
        loss = problem.loss(values)
        path.append(problem.state(here))
        if watch is not None:
            watch(path[-1].theta, loss)
        if loss < best_loss:
            best, best_loss = here.copy(), loss
        # An axis that only falls has no slope on its default, where it starts: one beside it.
        beside = np.clip(here, problem.lower + NUDGE, problem.upper - NUDGE)
        jacobian = problem.jacobian(beside)
        values, jacobian = rescale(values, jacobian, problem.options.loss, problem.scale)
        x.grad = torch.from_numpy(2 * (values @ jacobian) * unit / len(values))
        optimizer.step()
        np.clip(x.numpy(), problem.lower / unit, problem.upper / unit, out=x.numpy())
    return Fit(problem, problem.state(best), best_loss, max_iterations, True, path)


def deviations(problem: Problem, state: State) -> Array:
    """Standard deviation of every free variable, (f,), from the Jacobian; infinite if unseen.

    Notes
    -----
    The square root of the diagonal of σ² (JᵀJ)⁻¹. What no pixel shows, alone or along with
    others, lies in the null space of J and is infinite. σ is that of the pixels that tell
    anything, by how much they do: on blank paper noise may be cut off at white.
    """
    x = state.flat()[problem.free]
    residual, rows = problem.residual(x), problem.jacobian(x).T
    normal = rows @ rows.T
    size = np.sqrt(normal.diagonal())
    seen = size > 0
    costs = problem.scale**2 * rho((residual / problem.scale) ** 2, problem.options.loss)[0]
    size, told = size[seen], np.einsum("km,km,m->k", rows, rows, costs)[seen]
    noise = max(float(np.sqrt((told / size**2).sum() / max(len(told), 1))), LEAST_NOISE)
    values, vectors = np.linalg.eigh(normal[np.ix_(seen, seen)] / np.outer(size, size))
    # Directions that no pixel sees but for rounding: whatever takes part in one is not to be told.
    null = values < NULL * values[-1:]
    hidden = (abs(vectors[:, null]) > TAKES_PART).any(1)
    variance = (vectors[:, ~null] ** 2 / values[~null]).sum(1)
    deviation = np.full(len(seen), np.inf)
    deviation[seen] = np.where(hidden, np.inf, noise * np.sqrt(variance) / size)
    return deviation
