"""How the control points of a text move in a picture, and how the picture changes with them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..arrays import Array, IntArray
from ..raster.coverage import Boundary
from ..text import Text
from ..text.place import AXES
from ..text.points import PointSet


class Displacements(NamedTuple):
    """The derivative of K control points, in pixels, by some of the unknowns of a picture.

    The unknowns of the text come first. Where each letter has axes of its own, they change the
    outline of this letter and displace the starts of letters. A displaced start moves all points of
    its letter equally. The derivative is therefore kept in two parts.

    Attributes
    ----------
    letter : (K,) int array
        The letter of each point.
    own : (K, 2, n) array
        By the axes of the letter of the point while the letter starts at the same point; n is 0
        where the axes are not among the unknowns.
    starts : (l, 2, a) array
        Of the starts of the letters by the unknowns of the text, where each letter has axes of
        its own; else a is 0.
    points : (K, 2, b) array
        Of the points by the other unknowns.
    """

    letter: IntArray
    own: Array
    starts: Array
    points: Array

    @property
    def size(self) -> int:
        """The number of unknowns."""
        return self.starts.shape[-1] + self.points.shape[-1]

    def add_to(self, out: Array, boundary: Boundary, segments: IntArray) -> None:
        """Add the derivative of the coverage by each unknown to ``out``, (size, H, W).

        Parameters
        ----------
        out : (size, H, W) array
        boundary : Boundary
            Of one image.
        segments : (C, 4) int array
            The control points of each cubic.
        """
        count = self.starts.shape[-1]
        if count:
            letters, n = len(self.starts), self.own.shape[-1]
            ahead = np.broadcast_to(np.eye(2), (len(self.own), 2, 2))
            tangents = np.concatenate([self.own, ahead], -1)
            apart = boundary.apart(self.letter[segments[:, 0]], letters)
            images = apart.derivative(tangents[segments])
            out[:count] = np.tensordot(self.starts, images[n:], ([1, 0], [0, 1]))
            by_axes = out[: letters * n].reshape(letters, n, *out.shape[1:])
            by_axes += np.swapaxes(images[:n], 0, 1)
        if self.points.shape[-1]:
            boundary.derivative(self.points[segments], out[count:, None])


def displacements(
    text: Text, by_axes: Array, linear: Array, by_placement: Array, wanted: Sequence[str]
) -> Displacements:
    """The derivative of the control points by some of the text's unknowns, and by its placement.

    Parameters
    ----------
    text : Text
    by_axes : (K, 2, parameters, n) array
        The derivative of the control points by Θ, in font units.
    linear : (2, 2) array
        From font units to pixels.
    by_placement : (K, 2, b) array
    wanted : sequence of str
        Names of the text's unknowns.
    """
    outline = text.point_set()
    letter = outline.letter
    if text.shared:
        points = np.concatenate([linear @ _by_place(outline, by_axes, wanted), by_placement], -1)
        return Displacements(letter, points[..., :0], np.zeros((0, 2, 0)), points)
    starts = text.word.starts(np.arange(len(text.glyphs)))
    of_starts = starts.positions_and_jacobian(text.place)[1]
    own = by_axes[np.arange(len(letter)), :, letter] - of_starts[letter, :, letter]
    return Displacements(
        letter=letter,
        own=linear @ own if AXES in wanted else own[..., :0],
        starts=linear @ _by_place(starts, of_starts, wanted),
        points=by_placement,
    )


def _by_place(points: PointSet, by_axes: Array, wanted: Sequence[str]) -> Array:
    """The derivative of points by some of the text's unknowns, (p, 2, size)."""
    found = {AXES: by_axes.reshape(len(by_axes), 2, -1), **points.by_block}
    parts = [by for name, by in found.items() if name in wanted]
    return np.concatenate([np.zeros((len(by_axes), 2, 0)), *parts], -1)
