"""Which letters overlap each other or an obstacle, by how much, and where."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import Array
from ..errors import OverlapError
from ..text import Text
from ..text.colours import as_drawn
from .collisions import collisions
from .common_area import Common
from .contacts import Points, farthest, nearest, sampled
from .shape import Shape, letters, read_obstacles

TOUCH = 1e-6
"""Square font units: a common area below this is a touch, not an overlap."""


@dataclass(frozen=True, eq=False)
class Overlap:
    """A letter that overlaps another letter, or an obstacle.

    Attributes
    ----------
    pair : (int, int)
        The two letters; or the letter and the obstacle, if :attr:`obstacle` is true.
    obstacle : bool
        Whether the second of the pair is an obstacle.
    area : float
        The area that both have in common, in square font units.
    depth : float
        The largest distance of a contact from the other outline, in font units, up to 1 %.
    points : (p, 2) array
        Contacts: points of either outline that lie in the other shape.
    normals : (p, 2) array
        For each contact, the unit vector along which the first of the pair leaves the second
        on the shortest way.
    """

    pair: tuple[int, int]
    obstacle: bool
    area: float
    depth: float
    points: Array
    normals: Array

    def __repr__(self) -> str:
        second = f"obstacle {self.pair[1]}" if self.obstacle else f"letter {self.pair[1]}"
        return (
            f"<Overlap of letter {self.pair[0]} and {second}: area {self.area:.4g}, "
            f"depth {self.depth:.4g}>"
        )


def overlaps(text: Text, obstacles: Any = ()) -> list[Overlap]:
    """The overlaps between the letters of a text, and between its letters and obstacles.

    Contours of one letter may overlap each other; that is no overlap. A colour glyph is what its
    layers cover, whatever their colours.

    Parameters
    ----------
    text : Text
    obstacles : obstacle, or sequence of obstacles
        Polygons (m, 2), lists of closed cubic contours (s, 4, 2), a :class:`Text`, or a
        :class:`~.artwork.Artwork`; in font units, y up. They are filled nonzero.

    Returns
    -------
    list of Overlap
        Letters with letters first, in the order of the text; then letters with obstacles.

    Raises
    ------
    OverlapError
        ``text`` is not a Text; or an obstacle cannot be read, has no area, or is not finite.

    Examples
    --------
    >>> import vfwidget as vf
    >>> text = vf.Text("recursive", "NT")
    >>> vf.overlaps(text)
    []
    >>> [found] = vf.overlaps(text, [[(0, 0), (100, 0), (100, 100), (0, 100)]])
    >>> found.pair, found.obstacle
    ((0, 0), True)
    """
    if not isinstance(text, Text):
        raise OverlapError(f"overlaps needs a Text first; received {type(text).__name__}.")
    own, others = letters(as_drawn(text)), read_obstacles(obstacles)
    found = collisions(own, others)
    return [
        _overlap(found.common, p, own[i], others[j] if obstacle else own[j], (i, j), obstacle)
        for p, ((i, j), obstacle) in enumerate(
            zip(found.pairs.tolist(), found.obstacle.tolist(), strict=True)
        )
        if found.common.area[p] > TOUCH
    ]


def _overlap(
    common: Common, p: int, first: Shape, second: Shape, pair: tuple[int, int], obstacle: bool
) -> Overlap:
    points, normals, depths = [], [], []
    for layer, (shape, other, sign) in enumerate(((first, second, 1), (second, first, -1))):
        spans = common.spans_of(p, layer)
        inside = sampled(shape, spans).position
        if not len(inside):
            continue
        boundary = other.union()
        out = nearest(inside, other, boundary)
        distance = np.hypot(*(out.position - inside).T)
        # The deepest point is seldom one of the samples.
        deep, end = farthest(shape, spans, other, boundary, distance)
        inside = np.concatenate([inside, deep.position])
        out = Points(*(np.concatenate(both) for both in zip(out, end, strict=True)))
        way = out.position - inside
        distance = np.hypot(*way.T)
        clear = distance > 0
        unit = way / np.where(clear, distance, 1.0)[:, None]
        points.append(inside)
        normals.append(sign * np.where(clear[:, None], unit, out.outward))
        depths.append(distance)
    return Overlap(
        pair=pair,
        obstacle=obstacle,
        area=float(common.area[p]),
        depth=float(np.concatenate(depths).max()),
        points=np.concatenate(points),
        normals=np.concatenate(normals),
    )
