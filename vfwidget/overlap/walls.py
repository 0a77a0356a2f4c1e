r"""Linear inequalities that keep shapes apart, and steps that obey them.

At a state where two shapes overlap, the common area A is linearised: a step d resolves the overlap
if :math:`A + ∇A^T d \le 0`. Divided by the length L of the boundary inside the other shape this is
an inequality for a depth, A / L, in font units. The same is done with the planes of a gap. An
energy is then minimised, linearised as well, under the inequalities of the last few states.
"""

from __future__ import annotations

import copy
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..arrays import Array, IntArray
from ..energy.energy import Energy
from ..solver.drivers import minimise
from ..solver.linearize import OFFSET
from ..solver.problem import Problem, Proximity, Tolerances
from ..text.memo import Memo
from .collisions import Collisions, areas
from .no_overlap import NoOverlap
from .overlaps import TOUCH
from .planes import Planes, find_planes
from .shape import letters
from .swept import Contact, first_contact

WALL = 1e4
"""Weight of the inequalities against terms of weight 1, such as a target."""
CLEAR = 0.1
"""Font units that stay between two shapes that have met."""
DEPTH = 1.5
"""Depth of an overlap over the quotient of its area and its length: 1 between parallel edges, 2 at
a corner, 1.5 in a lens of two curves."""
LATEST = 3
"""Looks at a pair whose inequalities hold together. Older ones were taken too far away."""
STEPS = 40
"""Most steps of the solver under one set of inequalities; they evaluate no outlines."""
TOLERANCES = Tolerances(step=1e-7, absolute_cost=1e-10)
"""In normalized coordinates, and in square font units."""
KEPT = 8
"""States whose control points are kept, because they are needed again."""
PLANES = -1
"""Stands for a pair in the inequalities of planes."""


class Look(NamedTuple):
    """What overlaps at one state.

    Attributes
    ----------
    x : (N,) array
    points : (K, 2) array
        All control points.
    found : Collisions
    planes : Planes, optional
        Those of a gap, or of ``method="planes"``.
    area : float
        The common area, in square font units.
    excess : float
        The cost of :class:`NoOverlap` with weight 1: the area, and the squares of planes' depths.
    """

    x: Array
    points: Array
    found: Collisions
    planes: Planes | None
    area: float
    excess: float


class Walls(NamedTuple):
    """Inequalities slopes · x + offsets ≤ 0, each of a pair of shapes.

    Attributes
    ----------
    pair : (c,) int array
        A number for each pair of shapes.
    slopes : (c, N) array
        Font units per unit of x.
    offsets : (c,) array
        Font units.
    """

    pair: IntArray
    slopes: Array
    offsets: Array


class Room:
    """What must not overlap, as a function of the free unknowns x (N,) of an energy.

    Parameters
    ----------
    energy : Energy
    keep : NoOverlap
        Bound to the text of the energy.
    """

    def __init__(self, energy: Energy, keep: NoOverlap) -> None:
        self.energy, self.text, self.keep = energy, energy.text, keep
        self.points = self.text.point_set()
        self._positions: Memo[Array] = Memo(KEPT)
        counts = [sum(glyph.contours) for glyph in self.text.glyphs]
        self.starts = np.cumsum([0, *counts[:-1]])

    def under(self, energy: Energy) -> Room:
        """The same room for another energy of the same unknowns."""
        room = copy.copy(self)
        room.energy = energy
        return room

    def positions(self, x: Array) -> Array:
        """All control points at a state, (K, 2)."""
        place = self.energy.unknowns.place
        return self._positions.get(x.tobytes(), lambda: np.asarray(self.points.positions(place(x))))

    def areas(self, *states: Array) -> Array:
        """The common area at each of several states (N,), in square font units."""
        letters_at = [letters(self.text, self.positions(x)) for x in states]
        return areas(letters_at, self.keep.shapes, self.keep.between_glyphs)

    def contact(self, x: Array, end: Array) -> Contact:
        """Where the way between two states is blocked."""
        index = self.text.word.contours.segments
        return first_contact(
            lambda t: self.positions(x + t * (end - x))[index],
            [glyph.contours for glyph in self.text.glyphs],
            self.keep.shapes,
            self.keep.between_glyphs,
        )

    def look(self, x: Array) -> Look:
        """What overlaps at a state."""
        keep, others = self.keep, list(self.keep.shapes)
        points = self.positions(x)
        found = keep.found(points)
        area = float(found.common.area.sum())
        excess, planes = area if keep.method == "area" else 0.0, None
        if keep.moving:
            own = letters(self.text, points)
            planes = find_planes(own, others, found, self.text.word.contours, keep.gap)
            excess += float((planes.residual(points) ** 2).sum())
        return Look(x, points, found, planes, area, excess)

    def step(self, look: Look, earlier: Sequence[Walls]) -> tuple[Array, Walls]:
        """Where the energy is least under inequalities, and those of the state that is looked at.

        No axis passes a kink, beyond which outlines move in other directions. An axis that is at
        a kink leaves it to the side on which the energy falls faster.
        """
        x, energy = look.x, self.energy
        kinks = energy.all_kinks
        below = np.where(kinks < x[:, None], kinks, -np.inf).max(1, initial=-np.inf)
        above = np.where(kinks > x[:, None], kinks, np.inf).min(1, initial=np.inf)
        lower, upper = np.maximum(energy.lower, below), np.minimum(energy.upper, above)
        contacts = self.contacts(look)
        side, walls = x, self.walls(look, x, *contacts)
        at_kink = (kinks == x[:, None]).any(1) & (lower < x)
        if at_kink.any():
            left = np.where(at_kink, x - OFFSET, x)
            others = self.walls(look, left, *contacts)
            up, down = self.slope(x, walls), self.slope(left, others)
            falls = at_kink & (np.maximum(-up, 0.0) < down)
            side = np.where(falls, left, x)
            walls = walls._replace(slopes=np.where(falls, others.slopes, walls.slopes))
            walls = walls._replace(offsets=contacts[1] + CLEAR - walls.slopes @ x)
            lower, upper = np.where(at_kink & ~falls, x, lower), np.where(falls, x, upper)
        return self.minimum(x, side, lower, upper, latest([*earlier, walls])), walls

    def slope(self, x: Array, walls: Walls) -> Array:
        """Half the derivative of the energy and of the inequalities' penalties at x, (N,)."""
        energy = self.energy
        weights, reference = energy.proximity
        beyond = np.maximum(walls.slopes @ x + walls.offsets, 0.0)
        own = energy.residual(x) @ energy.jacobian(x) + weights * (x - reference)
        return np.asarray(own + WALL * beyond @ walls.slopes)

    def contacts(self, look: Look) -> tuple[IntArray, Array, Array]:
        """Everything that overlaps: pair (c,), depth (c,), and its derivative (c, K, 2)."""
        pairs, depths, gradients = [], [], []
        if self.keep.method == "area":
            found = look.found
            pair, area, gradient = found.by_piece(self.text.word.contours, self.starts)
            # The boundary of the first shape in the second one.
            own = self.points.letter == found.pairs[pair, :1]
            length = np.hypot(*np.moveaxis(gradient * own[..., None], -1, 0)).sum(1)
            deep = np.flatnonzero((area > TOUCH) & (length > 0))
            numbers = found.pairs @ np.array([len(self.starts) + len(self.keep.shapes), 1])
            pairs.append((numbers + found.obstacle * len(self.starts))[pair[deep]])
            depths.append(DEPTH * area[deep] / length[deep])
            gradients.append(gradient[deep] / length[deep, None, None])
        if look.planes is not None:
            beyond = look.planes.residual(look.points)
            deep = np.flatnonzero(beyond > 0)
            pairs.append(np.full(len(deep), PLANES))
            depths.append(beyond[deep])
            gradients.append(look.planes.derivative(look.points)[deep])
        return np.concatenate(pairs), np.concatenate(depths), np.concatenate(gradients)

    def walls(
        self, look: Look, side: Array, pair: IntArray, depths: Array, gradients: Array
    ) -> Walls:
        """The inequalities of contacts, with derivatives by the unknowns at ``side`` (N,)."""
        unknowns = self.energy.unknowns
        moves = self.points.positions_and_jacobian(unknowns.place(side))[1]
        size = 2 * len(look.points)
        slopes = gradients.reshape(len(pair), size) @ moves.reshape(size, -1)
        slopes = self.energy.by_unknowns(slopes)
        return Walls(pair, slopes, depths + CLEAR - slopes @ look.x)

    def minimum(self, x: Array, side: Array, lower: Array, upper: Array, walls: Walls) -> Array:
        """The minimum of the energy, linearised at ``side``, within bounds and inequalities."""
        energy, root = self.energy, np.sqrt(WALL)
        residual, jacobian = energy.residual(side), energy.jacobian(side)
        slopes, offsets = root * walls.slopes, root * walls.offsets

        def rows(y: Array) -> Array:
            beyond = np.maximum(slopes @ y + offsets, 0.0)
            return np.concatenate([residual + jacobian @ (y - side), beyond])

        def derivative(y: Array) -> Array:
            beyond = slopes @ y + offsets > 0
            return np.concatenate([jacobian, beyond[:, None] * slopes])

        problem = Problem(
            lower,
            upper,
            scale_by_columns=False,
            tolerances=TOLERANCES,
            proximity=Proximity(*energy.proximity),
        )
        return minimise(problem, x, rows, derivative, max_iterations=STEPS).x


def latest(looks: Sequence[Walls]) -> Walls:
    """The inequalities of each pair from the last few looks at which it overlapped."""
    kept, seen = list[Walls](), dict[int, int]()
    for walls in reversed(looks):
        fresh = {pair for pair in walls.pair.tolist() if seen.get(pair, 0) < LATEST}
        for pair in fresh:
            seen[pair] = seen.get(pair, 0) + 1
        mask = np.isin(walls.pair, list(fresh))
        kept.append(Walls(walls.pair[mask], walls.slopes[mask], walls.offsets[mask]))
    return Walls(
        np.concatenate([walls.pair for walls in kept]),
        np.concatenate([walls.slopes for walls in kept]),
        np.concatenate([walls.offsets for walls in kept]),
    )
