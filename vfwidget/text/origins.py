r"""Origins of the letters of a word as functions of Θ, where letters may have axes of their own.

Where all letters share one axis vector, an origin is what its :class:`Layout` says. Where each
has its own, a kern or an anchor between two letters has two locations to be evaluated at. It is
defined as the mean of its values at both: with step_k for the displacement of letter k from the
letter next to which it is placed,

    step_k(Θ) = ½ step_k(θ_k) + ½ step_k(θ_anchor(k)),

each half in the setting of its own location. Advance widths are those of each letter at its own
axes. An origin is the sum of the steps that lead to it and of the advances before it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array, IntArray, like, namespace
from ..outline.variation import selection
from .layout import Layout, lines_of

RIGHT = np.array([1.0, 0.0])
"""The direction in which advances move the pen."""


class Halves(NamedTuple):
    """Parts of r steps that depend on the scalars of one letter each.

    Attributes
    ----------
    base : (r, 2) array
    deltas : (r, 2, M) array
    """

    base: Array
    deltas: Array


class Origins:
    """Origins of l letters and the r - l ends of their lines, without tracking and offsets.

    Parameters
    ----------
    layouts : sequence of l Layouts
        That of each letter.
    regions : sequence of int arrays
        The indices of the regions of each layout among the M regions of the word.
    count : int
        M.
    shared : bool
        Whether the letters share one axis vector.
    line_height : float
        Distance between the baselines of two lines.

    Attributes
    ----------
    pushed : (r, l) array
        How much of each letter's advance width lies before each origin.
    gaps : (r,) array
        How many graphemes stand before that of each origin on its line.
    ends_grapheme : (l,) array
        1 for a letter that has the space of tracking after it, else 0.
    is_base : (l,) array
        1 for a letter, 0 for a mark.
    anchor : (r,) int array
        The letter next to which each letter is placed, or -1; a line ends at its last letter.
    own, anchored : Halves
        Each step as a function of the letter's own scalars, plus one of those of its anchor.
    base : (r, 2) array
        The part of the origins that nothing changes.
    """

    def __init__(
        self,
        layouts: Sequence[Layout],
        regions: Sequence[IntArray],
        count: int,
        shared: bool,
        line_height: float,
    ) -> None:
        rows, letters = layouts[0].pushed.shape
        # The end of a line goes with the last letter of the line.
        owner = np.where(np.arange(rows) < letters, np.arange(rows), layouts[0].anchor)
        of_row = [layouts[i] for i in owner]
        self.pushed = np.array([layout.pushed[k] for k, layout in enumerate(of_row)])
        self.gaps = np.array([layout.gaps[k] for k, layout in enumerate(of_row)], dtype=np.float64)
        self.anchor = np.array([layout.anchor[k] for k, layout in enumerate(of_row)])
        ends = [of_row[k].ends_grapheme[k] for k in range(letters)]
        self.ends_grapheme = np.array(ends, dtype=np.float64)
        self.is_base = np.array([1.0 - of_row[k].is_mark[k] for k in range(letters)])
        self.parameters = 1 if shared else letters
        self._step(layouts, of_row, regions, count)
        self.own.base[:, 1] -= np.where(
            self.anchor < 0, line_height * lines_of(layouts[0].row), 0.0
        )
        reach = self._chains()
        self.base = reach @ (self.own.base + self.anchored.base)
        if shared:
            parts = np.tensordot(reach, self.own.deltas + self.anchored.deltas, 1)
            self._collect(np.eye(rows), parts, np.zeros(rows, dtype=np.intp))
        else:
            parts = np.concatenate([self.own.deltas, self.anchored.deltas])
            self._collect(np.tile(reach, 2), parts, np.concatenate([owner, self.anchor]))

    def _step(
        self,
        layouts: Sequence[Layout],
        of_row: Sequence[Layout],
        regions: Sequence[IntArray],
        count: int,
    ) -> None:
        """The steps, half from the setting of the letter and half from that of its anchor."""
        known: dict[int, Array] = {}
        for layout, at in zip(layouts, regions, strict=True):
            if id(layout) not in known:
                known[id(layout)] = layout.deltas @ selection(at, count)
        rows, letters = self.pushed.shape
        self.own, self.anchored = (
            Halves(np.zeros((rows, 2)), np.zeros((rows, 2, count))) for _ in range(2)
        )
        for k, anchor in enumerate(self.anchor):
            half = 0.0 if k >= letters else 0.5
            own = 1.0 if anchor < 0 else half
            for layout, share, part in (
                (of_row[k], own, self.own),
                (layouts[anchor], 1 - own, self.anchored),
            ):
                if share:
                    base, deltas = layout.base, known[id(layout)]
                    before = (0.0, 0.0) if anchor < 0 else (base[anchor], deltas[anchor])
                    part.base[k] = share * (base[k] - before[0])
                    part.deltas[k] = share * (deltas[k] - before[1])

    def _chains(self) -> Array:
        """1 where a step is one of those that lead to an origin, (r, r)."""
        reach = np.eye(len(self.anchor))
        known = self.anchor < 0
        for k in range(len(reach)):
            steps = []
            while not known[k]:
                steps.append(k)
                k = int(self.anchor[k])
            for step in reversed(steps):
                reach[step] += reach[self.anchor[step]]
                known[step] = True
        return reach

    def _collect(self, reach: Array, parts: Array, letters: IntArray) -> None:
        """Keep the displacements that an axis changes, and the share of each in every origin."""
        moves = parts.any((1, 2))
        self._reach, self._parts, self._letters = reach[:, moves], parts[moves], letters[moves]

    def value(self, gamma: Any, advances: Any) -> Any:
        """The origins, (..., r, 2).

        Parameters
        ----------
        gamma : (..., parameters, M) array or tensor
            Scalars of the word's regions.
        advances : (..., l) array or tensor
            Advance widths of the letters.
        """
        pen = (like(self.pushed, advances) @ advances[..., None])[..., 0]
        origins = like(self.base, advances) + pen[..., None] * like(RIGHT, advances)
        if not len(self._parts):
            return origins
        moved = (like(self._parts, gamma) @ gamma[..., self._letters, :, None])[..., 0]
        return origins + like(self._reach, gamma) @ moved

    def jacobian(self, slopes: Any, advance_slopes: Any) -> Any:
        """Their derivative by Θ, (..., r, 2, parameters, n).

        Parameters
        ----------
        slopes : (..., parameters, M, n) array or tensor
            Derivative of the scalars.
        advance_slopes : (..., l, parameters, n) array or tensor
            Derivative of the advance widths.
        """
        xp = namespace(slopes)
        *batch, l, parameters, n = advance_slopes.shape
        pens = like(self.pushed, slopes) @ advance_slopes.reshape(*batch, l, parameters * n)
        jacobian = like(np.zeros((*batch, len(self.pushed), 2, parameters, n)), slopes)
        jacobian[..., 0, :, :] = pens.reshape(*batch, len(self.pushed), parameters, n)
        q = len(self._parts)
        if not q:
            return jacobian
        moved = like(self._parts, slopes) @ slopes[..., self._letters, :, :]
        by = like(np.zeros((*batch, q, 2, parameters, n)), slopes)
        by[..., xp.arange(q), :, self._letters, :] = xp.moveaxis(moved, -3, 0)
        turned = like(self._reach, slopes) @ by.reshape(*batch, q, 2 * parameters * n)
        return jacobian + turned.reshape(jacobian.shape)

    def gain(self, parameter: int) -> Array:
        """The displacements of the origins by the scalars of one axis vector, (r, 2, M).

        Advances are not counted.
        """
        mine = np.flatnonzero(self._letters == parameter)
        return np.tensordot(self._reach[:, mine], self._parts[mine], 1)
