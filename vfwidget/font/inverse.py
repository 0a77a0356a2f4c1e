"""The way back through avar 2: which coordinates lead to given final ones.

Each coordinate is displaced by an affine function of scalars, so the map is continuous and smooth
between its kinks, but need not be one-to-one. Several starts find the solutions that there are.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..outline.composed import Displaced

STARTS, ITERATIONS = 16, 60
CLOSE = 0.5 / 16384
"""Files hold coordinates in units of 1/16384: what rounds to the same one is met."""
APART = 1e-3
"""Two solutions count as different from this distance on."""
FLAT = 1e-9
"""A slope below this share of the greatest one counts as none."""
FIRST_DAMPING, LEAST_DAMPING, LAST_DAMPING = 1e-3, 1e-15, 1e9


class Preimage(NamedTuple):
    """What leads to given final coordinates.

    Attributes
    ----------
    w : (n,) array
        The solution nearest to the default; where there is none, the nearest that was found.
    distance : float
        The greatest difference that remains in a coordinate.
    unique : bool
        False if other coordinates were found that lead there, too.
    """

    w: Array
    distance: float
    unique: bool

    @property
    def exists(self) -> bool:
        """Whether the final coordinates are reached."""
        return self.distance <= CLOSE


def preimage(displaced: Displaced, final: Array, bounds: tuple[Array, Array]) -> Preimage:
    """Solve ``displaced.value(w) = final`` within bounds of w."""
    lower, upper = bounds
    rng = np.random.default_rng(0)
    starts = [final, np.zeros_like(final), *rng.uniform(lower, upper, (STARTS, len(final)))]
    found = [_descend(displaced, final, bounds, start.clip(lower, upper)) for start in starts]
    distances = [abs(_miss(displaced, final, w)).max(initial=0.0) for w in found]
    met = [w for w, distance in zip(found, distances, strict=True) if distance <= CLOSE]
    if not met:
        best = int(np.argmin(distances))
        return Preimage(found[best], float(distances[best]), False)
    best = int(np.argmin([np.linalg.norm(w) for w in met]))
    spread = max(float(abs(w - met[best]).max(initial=0.0)) for w in met)
    return Preimage(met[best], float(abs(_miss(displaced, final, met[best])).max(initial=0.0)),
                    spread < APART and not _is_flat(displaced, met[best], bounds))  # fmt: skip


def _miss(displaced: Displaced, final: Array, w: Array) -> Array:
    """What is missing, (n,); beyond -1 or 1 everything counts as the end itself."""
    miss = w + displaced.displacement.value(w) - final
    beyond = ((final >= 1) & (miss > 0)) | ((final <= -1) & (miss < 0))
    return np.where(beyond, 0.0, miss)


def _descend(displaced: Displaced, final: Array, bounds: tuple[Array, Array], w: Array) -> Array:
    """Damped Gauss-Newton steps, clipped to the bounds, with slopes towards where w has to go."""
    damping, miss = FIRST_DAMPING, _miss(displaced, final, w)
    for _ in range(ITERATIONS):
        if abs(miss).max(initial=0.0) < CLOSE / 1000 or damping > LAST_DAMPING:
            break
        _, slopes = displaced.displacement.value_and_jacobian(w, -miss)
        jacobian = (slopes + np.eye(len(w))) * (miss != 0)[:, None]
        gradient = jacobian.T @ miss
        # An axis that pushes against its bound stays there.
        free = ~(((w <= bounds[0]) & (gradient > 0)) | ((w >= bounds[1]) & (gradient < 0)))
        columns = jacobian[:, free]
        matrix = columns.T @ columns
        matrix += damping * np.eye(len(matrix))
        moved = w.copy()
        moved[free] -= np.linalg.solve(matrix, gradient[free])
        moved = moved.clip(*bounds)
        ahead = _miss(displaced, final, moved)
        if ahead @ ahead < miss @ miss:
            w, miss, damping = moved, ahead, max(damping / 10, LEAST_DAMPING)
        else:
            damping *= 10
    return w


def _is_flat(displaced: Displaced, w: Array, bounds: tuple[Array, Array]) -> bool:
    """Whether w can move in some direction without any change of the final coordinates."""
    _, jacobian = displaced.value_and_jacobian(w)
    free = (w > bounds[0]) & (w < bounds[1])
    sizes = np.linalg.svd(jacobian[:, free], compute_uv=False)
    return bool(free.any() and sizes[-1] <= FLAT * max(float(sizes[0]), 1.0))
