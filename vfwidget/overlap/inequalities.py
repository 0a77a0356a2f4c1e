r"""An energy under linear inequalities that keep shapes apart.

At a state where two shapes overlap, the common area A is linearised: a step d resolves the overlap
if :math:`A + ∇A^T d \le 0`. Divided by the length L of the boundary inside the other shape this is
an inequality for a depth, A / L, in font units. The energy is linearised as well.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..arrays import Array, BoolArray, IntArray, between
from ..solver.quadratic import LowRankQuadratic, minimise_over_box

WALL = 1e4
"""Weight of the inequalities against terms of weight 1, such as a target."""
CLEAR = 0.01, 0.05
"""Font units that stay between two shapes that have met, at least and at most."""
SHALLOWER = 0.5
"""Bulges are measured where less than this part of the former depth is left."""
LATEST = 3
"""Looks at a pair whose inequalities hold together. Older ones were taken too far away."""
STEPS = 40
"""Most steps towards the minimum under one set of inequalities; they evaluate no outlines."""
STILL = 1e-7
"""Steps that are shorter, in normalized coordinates, are not shortened further."""
LEAST_WEIGHT = 1e-6
"""Least weight of the squared length of a step towards the minimum, so that it is unique."""


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
    depths, lengths : (c,) arrays
        The common area over the length of the boundary of one shape in the other one, and that
        length, in font units.
    bulges : (c,) array
        The overlap is deeper than ``depths`` by this part of it: by 0 between parallel edges, by 1
        at a corner, by 0.5 in a lens of two curves. The length grows by this power of the depth.
    """

    pair: IntArray
    slopes: Array
    offsets: Array
    depths: Array
    lengths: Array
    bulges: Array

    @property
    def clearances(self) -> Array:
        """The distance that stays between two shapes that have met, (c,), in font units."""
        return np.asarray(between(self.depths, *CLEAR))

    @property
    def margins(self) -> Array:
        """Font units that are added to the offsets, (c,): shapes are curved and stay apart."""
        return self.bulges * self.depths + self.clearances

    def some(self, which: BoolArray) -> Walls:
        """Some of the inequalities."""
        pair, slopes, *columns = self
        return Walls(pair[which], slopes[which], *(column[which] for column in columns))

    def since(self, before: Walls) -> Walls:
        """These inequalities with bulges that are measured, from a look at deeper overlaps.

        Only pairs that have one overlap at either look are compared.
        """
        bulges = self.bulges.copy()
        for i, pair in enumerate(self.pair.tolist()):
            here, there = np.flatnonzero(self.pair == pair), np.flatnonzero(before.pair == pair)
            if len(here) == len(there) == 1:
                j = there[0]
                shallower = self.depths[i] / before.depths[j]
                if shallower < SHALLOWER:
                    power = math.log(self.lengths[i] / before.lengths[j]) / math.log(shallower)
                    bulges[i] = min(max(power, 0.0), 1.0)
        return self._replace(bulges=bulges)

    def beyond(self, x: Array) -> Array:
        """By how much each is broken at x, (c,); 0 if it is met."""
        return np.maximum(self.slopes @ x + self.offsets + self.margins, 0.0)


def latest(looks: Sequence[Walls]) -> Walls:
    """The inequalities of each pair from the last few looks at which it overlapped."""
    kept, seen = list[Walls](), dict[int, int]()
    for walls in reversed(looks):
        pairs = walls.pair.tolist()
        fresh = [seen.get(pair, 0) < LATEST for pair in pairs]
        for pair in set(pairs):
            seen[pair] = seen.get(pair, 0) + 1
        kept.append(walls if all(fresh) else walls.some(np.array(fresh)))
    return Walls(*(np.concatenate(values) for values in zip(*kept, strict=True)))


class Model(NamedTuple):
    """The squares of linear residuals and of distances, within bounds and under inequalities.

    Attributes
    ----------
    x : (N,) array
        Where the search for the minimum starts.
    lower, upper : (N,) arrays
        The sides of the cell between two kinks of each unknown.
    least, most : (N,) arrays
        The bounds of the unknowns.
    constant, jacobian : (r,) and (r, N) arrays
        The residuals at 0 and their derivative.
    weights, reference : (N,) arrays
        Of the distances.
    walls : Walls
        Those of the last few looks.
    own : Walls
        Those of the last look.
    """

    x: Array
    lower: Array
    upper: Array
    least: Array
    most: Array
    constant: Array
    jacobian: Array
    weights: Array
    reference: Array
    walls: Walls
    own: Walls

    def bound(self, near: Array) -> Array:
        """The minimum (N,) under the inequalities of the last look, without cell and clearances.

        It is searched from a state (N,) near it.
        """
        walls = self.own._replace(offsets=self.own.offsets - self.own.clearances)
        return self._replace(lower=self.least, upper=self.most, walls=walls).minimum(near)

    def minimum(self, near: Array | None = None) -> Array:
        """The minimum (N,).

        It is found by Newton's method, on a convex function that is quadratic as long as no
        inequality changes from met to broken. A state ``near`` it saves most of the first step.
        """
        offsets = self.walls.offsets + self.walls.margins
        # Those that an earlier step has just met count as met.
        x, broken = self.x, self.walls.slopes @ self.x + offsets > CLEAR[0]
        root = math.sqrt(WALL)
        slopes, offsets = root * self.walls.slopes, root * offsets
        held = np.maximum(self.weights, LEAST_WEIGHT)

        def cost(x: Array) -> float:
            rows = self.constant + self.jacobian @ x
            beyond = np.maximum(slopes @ x + offsets, 0.0)
            away = self.weights @ (x - self.reference) ** 2
            return float(rows @ rows + beyond @ beyond + away)

        for _ in range(STEPS):
            quadratic = LowRankQuadratic(
                np.concatenate([self.jacobian, slopes[broken]]),
                np.concatenate([self.constant + self.jacobian @ x, (slopes @ x + offsets)[broken]]),
                held,
                self.weights * (x - self.reference),
                # Only the rows of the energy differ from the inequalities by orders of magnitude.
                graded=len(self.jacobian) > 0,
            )
            low, high = self.lower - x, self.upper - x
            start = None if near is None else between(near - x, low, high)
            end = x + minimise_over_box(quadratic, low, high, start)[0]
            if (broken == (slopes @ end + offsets > 0)).all():
                x = end
                break
            before, known = cost(x), broken
            while (after := cost(end)) > before and abs(end - x).max() > STILL:
                end = (x + end) / 2
            if after < before:
                x, broken = end, slopes @ end + offsets > 0
                continue
            # Inequalities that even a short step breaks stand in the way.
            broken = known | (slopes @ end + offsets > 0)
            if (broken == known).all():
                break
        return between(x, self.lower, self.upper)
