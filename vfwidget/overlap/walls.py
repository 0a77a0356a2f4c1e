"""What overlaps at a state of an energy, and which inequalities resolve that."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..arrays import Array, IntArray
from ..energy.energy import Energy
from ..solver.linearize import OFFSET
from ..solver.problem import pooled
from ..text.memo import Memo
from ..text.place import AXES
from .collisions import Collisions, areas
from .inequalities import WALL, Model, Walls, latest
from .no_overlap import NoOverlap
from .overlaps import TOUCH
from .planes import Planes, find_planes
from .shape import letters
from .swept import Contact, first_contact

BULGE = 0.5
"""The bulge of a lens of two curves, which is taken for every overlap until it is measured."""
KEPT = 8
"""States whose overlaps are kept, because they are needed again."""
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


class Room:
    """What must not overlap, as a function of the free unknowns x (N,) of an energy.

    Parameters
    ----------
    energy : Energy
    keep : NoOverlap
        Bound to the text of the energy.
    """

    def __init__(self, energy: Energy, keep: NoOverlap) -> None:
        # Colour glyphs have other outlines here than in the energy.
        self.energy, self.text, self.keep = energy, keep.text, keep
        self.proximity = energy.proximity
        self.points = keep.points(self.text)
        self._looks: Memo[Look] = Memo(KEPT)
        counts = [sum(glyph.contours) for glyph in self.text.glyphs]
        self.starts = np.array([0, *counts[:-1]]).cumsum()

    def calmed(self, x: Array, weight: float) -> Room:
        """The same room with a further pull of all axes to a state, in square font units."""
        room, unknowns = copy.copy(self), self.energy.unknowns
        calm = unknowns.flat({AXES: np.full_like(unknowns.place(x)[AXES], weight)})
        own, reference = self.proximity
        squares = np.concatenate([own, calm]), np.concatenate([reference, x])
        room.proximity, _ = pooled(*squares, np.tile(np.arange(len(x)), 2), len(x))
        return room

    def positions(self, x: Array) -> Array:
        """All control points at a state, (K, 2)."""
        return np.asarray(self.points.positions(self.energy.unknowns.place(x)))

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
        return self._looks.get(x.tobytes(), lambda: self._look(x))

    def _look(self, x: Array) -> Look:
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

    def model(self, look: Look, earlier: Sequence[Walls] = (), x: Array | None = None) -> Model:
        """The energy, linearised at x, under the inequalities of this and of earlier looks.

        No axis passes a kink, beyond which outlines move in other directions. An axis that is at
        a kink leaves it to the side on which the energy falls faster. By default x is the state
        that is looked at.
        """
        x, energy = look.x if x is None else x, self.energy
        kinks = energy.all_kinks
        below = np.where(kinks < x[:, None], kinks, -np.inf).max(1, initial=-np.inf)
        above = np.where(kinks > x[:, None], kinks, np.inf).min(1, initial=np.inf)
        lower, upper = np.maximum(energy.lower, below), np.minimum(energy.upper, above)
        at_kink = (kinks == x[:, None]).any(1) & (lower < x)
        side = np.where(at_kink, x - OFFSET, x)
        walls, *others = self.walls(look, [x, side] if at_kink.any() else [x])
        if others:
            up, down = self.slope(x, walls), self.slope(side, others[0])
            falls = at_kink & (np.maximum(-up, 0.0) < down)
            side = np.where(falls, side, x)
            slopes = np.where(falls, others[0].slopes, walls.slopes)
            offsets = walls.offsets + (walls.slopes - slopes) @ look.x
            walls = walls._replace(slopes=slopes, offsets=offsets)
            lower, upper = np.where(at_kink & ~falls, x, lower), np.where(falls, x, upper)
        if earlier:
            walls = walls.since(earlier[-1])
        jacobian = energy.jacobian(side)
        constant = energy.residual(side) - jacobian @ side
        every = latest([*earlier, walls])
        return Model(
            x,
            lower,
            upper,
            energy.lower,
            energy.upper,
            constant,
            jacobian,
            *self.proximity,
            walls=every,
            own=walls,
        )

    def slope(self, x: Array, walls: Walls) -> Array:
        """Half the derivative of the energy and of the inequalities' penalties at x, (N,)."""
        energy = self.energy
        weights, reference = self.proximity
        own = weights * (x - reference) + WALL * walls.beyond(x) @ walls.slopes
        rows = energy.residual(x)
        return own + rows @ energy.jacobian(x) if len(rows) else own

    def walls(self, look: Look, sides: Sequence[Array]) -> list[Walls]:
        """The inequalities of everything that overlaps, with derivatives at each of ``sides``."""
        pair, depths, lengths, bulges, gradients = self.contacts(look)
        places = [self.energy.unknowns.place(x) for x in sides]
        place = {**places[0], AXES: np.array([place[AXES] for place in places])}
        # Only few of the points are next to an overlap.
        touched = np.flatnonzero(gradients.any((0, 2)))
        moves = self.points.some(touched).jacobian(place)
        size = 2 * len(touched)
        own = gradients[:, touched].reshape(len(pair), size)
        slopes = own @ moves.reshape(len(sides), size, places[0][AXES].size)
        return [
            Walls(pair, by, depths - by @ look.x, depths, lengths, bulges)
            for by in map(self.energy.by_unknowns, slopes)
        ]

    def contacts(self, look: Look) -> tuple[IntArray, Array, Array, Array, Array]:
        """Everything that overlaps: pair, depth, length, bulge (c,), and derivative (c, K, 2)."""
        pairs, depths, lengths, bulges, gradients = [], [], [], [], []
        if self.keep.method == "area":
            found = look.found
            pair, area, gradient = found.by_piece(self.text.word.contours, self.starts)
            # The boundary of the first shape in the second one.
            own = self.points.letter == found.pairs[pair, :1]
            length = (np.hypot(gradient[..., 0], gradient[..., 1]) * own).sum(1)
            deep = np.flatnonzero((area > TOUCH) & (length > 0))
            numbers = found.pairs @ np.array([len(self.starts) + len(self.keep.shapes), 1])
            pairs.append((numbers + found.obstacle * len(self.starts))[pair[deep]])
            depths.append(area[deep] / length[deep])
            lengths.append(length[deep])
            bulges.append(np.full(len(deep), BULGE))
            gradients.append(gradient[deep] / length[deep, None, None])
        if look.planes is not None:
            beyond = look.planes.residual(look.points)
            deep = np.flatnonzero(beyond > 0)
            pairs.append(np.full(len(deep), PLANES))
            depths.append(beyond[deep])
            lengths.append(np.ones(len(deep)))
            bulges.append(np.zeros(len(deep)))
            gradients.append(look.planes.derivative(look.points)[deep])
        columns = (pairs, depths, lengths, bulges, gradients)
        pair, depth, length, bulge, gradient = (np.concatenate(column) for column in columns)
        return pair, depth, length, bulge, gradient
