"""The two optimisers of a fit: damped Gauss–Newton on the picture's residual, and Adam."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Array
from ..energy.boundaries import cross
from ..energy.descent import Descent, descend
from ..energy.energy import Energy
from ..errors import ImageError
from ..solver.loss import LOSSES, signed_root
from ..solver.problem import Tolerances
from ..solver.status import CONVERGED, Outcome
from ..text.place import AXES, TRACKING
from .looks import Looks, View
from .scene import State

OPTIMIZERS = ("gauss-newton", "adam")
LEARNING_RATE = 0.03
"""Of Adam, in normalized coordinates; other variables move by their own ranges' share."""
FAINT = 3e-5
"""A change of a pixel, relative to the scale of the loss, that is too small to go on for."""
LEAST_NOISE = 0.5 / 255
"""A pixel's standard deviation: levels are written in steps of 1 / 255."""
TRIAL_STEPS = 3
"""First steps of a fit with other glyphs. It goes on only if they have lowered its cost by more
than the amount by which the cost still exceeds the best one."""
UNPROMISING = Outcome(CONVERGED, "The first steps of a fit with other glyphs have gained little.")
MOST_BEYOND = 5
"""All fits with other glyphs together take at most this many times ``max_iterations`` steps."""
NUDGE = 1e-6
NULL, TAKES_PART = 1e-10, 1e-3
"""An eigenvalue, relative to the largest, that is zero; and a share in its vector that counts."""

Watch = Callable[[State, float], None]


@dataclass(frozen=True)
class Options:
    """How to fit.

    Attributes
    ----------
    fitted : tuple of str
        Of :data:`.looks.MATCHED`.
    optimizer : {"gauss-newton", "adam"}
    loss : str
        Of :data:`..solver.loss.LOSSES`.
    """

    fitted: tuple[str, ...]
    optimizer: str = "gauss-newton"
    loss: str = "soft_l1"

    def __post_init__(self) -> None:
        if self.optimizer not in OPTIMIZERS:
            names = ", ".join(OPTIMIZERS)
            raise ImageError(f"There is no optimizer {self.optimizer!r}: choose one of {names}.")
        if self.loss not in LOSSES:
            raise ImageError(f"There is no loss {self.loss!r}: choose one of {', '.join(LOSSES)}.")


@dataclass(frozen=True)
class Fit:
    """Where a fit ended.

    Attributes
    ----------
    view : View
        The picture at the resolution of the fit.
    state : State
    loss : float
        The mean cost of a pixel.
    iterations : int
    converged : bool
    path : list of State
        The start, and the state after every step.
    """

    view: View
    state: State
    loss: float
    iterations: int
    converged: bool
    path: list[State]


def fit(
    view: View,
    options: Options,
    max_iterations: int,
    watch: Watch | None = None,
    *,
    crosses: bool = False,
) -> Fit:
    """Fit a text to a picture with the optimiser that the options name.

    ``crosses`` says whether Gauss–Newton goes on beyond boundaries at which glyphs change. With
    letters that have axes of their own, this takes a descent for each letter at a boundary, so
    only the last fit of a search does it. If it ends before every boundary has been tried, the fit
    has not converged.
    """
    energy = _energy(view, options.loss)
    if options.optimizer == "adam":
        return _adam(energy, view, max_iterations, watch)
    return _gauss_newton(energy, view, max_iterations, watch, crosses)


def _energy(view: View, loss: str) -> Energy:
    """The energy of the picture alone, from the start of its view."""
    looks = Looks(view.target, weight=1.0, loss=loss, view=view)
    free = [AXES, TRACKING] if TRACKING in view.fitted else [AXES]
    return Energy(view.scene.text.moved_to(view.start.place), [looks], free)


def _gauss_newton(
    energy: Energy, view: View, max_iterations: int, watch: Watch | None, crosses: bool
) -> Fit:
    best, count = np.inf, view.target.size

    def watched(x: Array, cost: float) -> None:
        nonlocal best
        if watch is not None and cost < best:
            best = cost
            watch(_state(energy, view, x), cost / count)

    faint = FAINT**2 * count * view.scale**2
    tolerances = Tolerances(relative_cost=1e-5, absolute_cost=faint, step=1e-7, gradient=1e-7)

    def descent(energy: Energy, start: Array, most: int = max_iterations) -> Descent:
        return descend(energy, start, tolerances, most, True, watched)

    found = descent(energy, energy.unknowns.start)
    tried_all = True
    if crosses:
        beyond = _Beyond(descent, found, max_iterations)
        energy, found, _, cut = cross(energy, found, beyond)
        tried_all = cut is None and not beyond.used_up
    state = found.state
    return Fit(
        view,
        _state(energy, view, state.x),
        state.cost / count,
        found.iterations,
        tried_all and state.outcome is not None and state.outcome.status == CONVERGED,
        [_state(energy, view, x) for x, _ in found.history],
    )


class _Beyond:
    """Runs the descents beyond boundaries: a short trial first, and the rest if it is promising.

    Parameters
    ----------
    descent : callable of (energy, start, most)
        Runs a descent of at most ``most`` steps.
    found : Descent
        The one that met the boundaries.
    max_iterations : int
        Largest number of steps of one descent.

    Attributes
    ----------
    used_up : bool
        Whether the steps of all descents together did not suffice.
    """

    def __init__(
        self, descent: Callable[[Energy, Array, int], Descent], found: Descent, max_iterations: int
    ) -> None:
        self._descent, self._least, self._most = descent, found.state.cost, max_iterations
        self._left, self.used_up = MOST_BEYOND * max_iterations, False

    def __call__(self, energy: Energy, start: Array) -> Descent | None:
        """See :data:`~.energy.boundaries.Descend`."""
        if self._left == 0:
            self.used_up = True
            return None
        found = self._take(energy, start, min(TRIAL_STEPS, self._most))
        gained = found.history[0][1] - found.state.cost
        promising = found.state.cost - self._least < gained
        if not promising:
            found = found._replace(state=replace(found.state, outcome=UNPROMISING))
        if promising and self._most > TRIAL_STEPS and found.cut and not self.used_up:
            rest = self._take(energy, found.state.x, self._most - TRIAL_STEPS)
            found = rest.after(found)
        self._least = min(self._least, found.state.cost)
        return found

    def _take(self, energy: Energy, start: Array, most: int) -> Descent:
        allowed = min(most, self._left)
        found = self._descent(energy, start, allowed)
        self._left -= found.state.iterations
        self.used_up |= allowed < most and found.cut is not None
        return found


def _state(energy: Energy, view: View, x: Array) -> State:
    prefix = f"{energy.terms[0].name}."  # type: ignore[attr-defined]
    place = energy.unknowns.place(x)
    return view.state({name.removeprefix(prefix): value for name, value in place.items()})


def _adam(energy: Energy, view: View, max_iterations: int, watch: Watch | None) -> Fit:
    """Adam (Kingma and Ba 2015) as the paper uses it, Θ projected onto its bounds."""
    import torch

    lower, upper = energy.lower, energy.upper
    unit = np.minimum((upper - lower) / 2, 1e3)
    x = torch.tensor(energy.unknowns.start / unit)
    optimizer = torch.optim.Adam([x], lr=LEARNING_RATE)
    best, best_loss = energy.unknowns.start, np.inf
    path = []
    for _ in range(max_iterations + 1):
        here = x.numpy() * unit
        values = energy.residual(here)
        loss = float(values @ values) / len(values)
        path.append(_state(energy, view, here))
        if watch is not None:
            watch(path[-1], loss)
        if loss < best_loss:
            best, best_loss = here.copy(), loss
        # An axis that only falls has no slope at its default, where it starts, but beside it.
        beside = np.clip(here, lower + NUDGE, upper - NUDGE)
        gradient = energy.residual(beside) @ energy.jacobian(beside)
        x.grad = torch.from_numpy(2 * gradient * unit / len(values))
        optimizer.step()
        np.clip(x.numpy(), lower / unit, upper / unit, out=x.numpy())
    return Fit(view, _state(energy, view, best), best_loss, max_iterations, False, path)


def deviations(view: View, state: State, loss: str) -> Array:
    """Standard deviation of every axis, (parameters, n), from the Jacobian; infinite if unseen.

    Notes
    -----
    The square root of the diagonal of σ² (JᵀJ)⁻¹. What no pixel shows, alone or along with
    others, lies in the null space of J and is infinite. σ is that of the pixels that tell
    anything, by how much they do: on blank paper noise may be cut off at white.
    """
    energy = _energy(replace(view, start=state), "linear")
    x = energy.unknowns.start
    residual, rows = energy.residual(x), energy.jacobian(x).T
    normal = rows @ rows.T
    size = np.sqrt(normal.diagonal())
    seen = size > 0
    costs = signed_root(residual, loss, view.scale)[0] ** 2
    size, told = size[seen], np.einsum("km,km,m->k", rows, rows, costs)[seen]
    noise = max(float(np.sqrt((told / size**2).sum() / max(len(told), 1))), LEAST_NOISE)
    values, vectors = np.linalg.eigh(normal[np.ix_(seen, seen)] / np.outer(size, size))
    # Directions that no pixel sees but for rounding: whatever takes part in one is undetermined.
    null = values < NULL * values[-1:]
    hidden = (abs(vectors[:, null]) > TAKES_PART).any(1)
    variance = (vectors[:, ~null] ** 2 / values[~null]).sum(1)
    deviation = np.full(len(seen), np.inf)
    deviation[seen] = np.where(hidden, np.inf, noise * np.sqrt(variance) / size)
    return deviation[: state.theta.size].reshape(state.theta.shape)
