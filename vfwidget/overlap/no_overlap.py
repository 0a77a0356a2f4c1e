r"""The term that keeps letters apart from each other and from obstacles (Sec. 5.2).

Its residual is the square root of the area that each letter has in common with the letters after it
and with the obstacles, so its square is the area itself. The derivative is exact.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, cast

import numpy as np

from ..arrays import Array
from ..energy import Derivative, Term
from ..energy.rows import Rows
from ..errors import OverlapError
from ..solver.problem import is_number
from ..text import Text
from ..text.colours import as_drawn
from ..text.memo import Memo
from ..text.points import PointSet, RememberedPoints
from .collisions import Collisions, collisions
from .overlaps import TOUCH
from .planes import Planes, find_planes
from .shape import LARGEST, Shape, letters, read_obstacles

METHODS = ("area", "planes")
KEPT = 8
"""States whose overlaps are kept."""


@dataclass(frozen=True)
class NoOverlap(Term):
    """Keep letters apart from each other and from obstacles (Sec. 5.2).

    Parameters
    ----------
    obstacles : obstacle, or sequence of obstacles
        As for :func:`~vfwidget.overlaps`.
    between_glyphs : bool
        Whether letters must not overlap each other. Default True.
    gap : float
        Smallest distance between letters, and to obstacles, in font units. Default 0.
    weight : float
        Factor of the common area, which is in square font units. Default 1.
    method : {"area", "planes"}
        "area": the exact common area. "planes": the paper's planes at sampled points, for
        comparison. A gap is kept by planes in both cases.

    Raises
    ------
    OverlapError
        An obstacle cannot be read, has no area, or is not finite; there is nothing to keep apart;
        the gap is negative or not finite; or the method is unknown.
    """

    obstacles: Any = ()
    between_glyphs: bool = True
    gap: float = 0.0
    weight: float = 1.0
    method: str = "area"
    tolerance: float = 0.1
    _shapes: tuple[Shape, ...] = field(default=(), repr=False)
    _text: Any = field(default=None, repr=False)
    _planes: Planes | None = field(default=None, repr=False)
    _points: Any = field(default=None, repr=False, compare=False)
    _latest: Memo[Collisions] = field(default_factory=lambda: Memo(KEPT), repr=False, compare=False)

    @property
    def moving(self) -> bool:  # type: ignore[override]
        """Whether there are planes, which have to be found again after every step."""
        return self.gap > 0 or self.method == "planes"

    def bind(self, text: Text) -> NoOverlap:
        """The term with its obstacles as shapes."""
        super().bind(text)
        if not isinstance(self.between_glyphs, bool | np.bool_):
            raise OverlapError(
                f"between_glyphs must be True or False; received {self.between_glyphs!r:.200}."
            )
        if not (isinstance(self.method, str) and self.method in METHODS):
            raise OverlapError(f"method must be one of {METHODS}; received {self.method!r}.")
        if not (is_number(self.gap) and 0 <= self.gap <= LARGEST):
            raise OverlapError(
                f"gap must be a number of font units, 0 to {LARGEST:g}; received {self.gap!r:.200}."
            )
        shapes = tuple(read_obstacles(self.obstacles))
        if not (shapes or self.between_glyphs):
            raise OverlapError("NoOverlap needs obstacles, or between_glyphs=True.")
        drawn = as_drawn(text)
        points = RememberedPoints(drawn.point_set(), KEPT)
        return replace(self, _shapes=shapes, _text=drawn, _points=points, _latest=Memo(KEPT))

    @property
    def shapes(self) -> tuple[Shape, ...]:
        """The obstacles, once the term is bound to a text."""
        return self._shapes

    @property
    def text(self) -> Text:
        """The text with the outlines that are visible, once the term is bound to it."""
        text: Text = self._text
        return text

    def points(self, text: Text) -> PointSet:
        """All control points of the outlines that are visible."""
        drawn, kept = as_drawn(text), self._points
        known = kept is not None and drawn.word is kept.word
        if known and np.array_equal(drawn.rotations, self._text.rotations):
            return cast(PointSet, kept)
        return drawn.point_set()

    def locate(self, text: Text) -> Rows | None:
        """The residual with the planes that are found at ``text``."""
        return self.with_planes(text) if self.moving else super().locate(text)

    def with_planes(self, text: Text) -> Rows | None:
        """The residual with the planes at ``text``, which are kept."""
        drawn, others = as_drawn(text), list(self._shapes)
        own = letters(drawn)
        nearby = collisions(own, others, self.between_glyphs, self.gap)
        planes = find_planes(own, others, nearby, drawn.word.contours, self.gap)
        return Term.locate(replace(self, _planes=planes), text)

    def residual(self, points: Array, theta: Array) -> Array:
        """The square root of each letter's common area, (l,), and the planes' residuals."""
        parts = [] if self._planes is None else [self._planes.residual(points)]
        if self.method == "area":
            count = len(self._text.glyphs)
            parts.insert(0, np.sqrt(self.found(points).by_letter(count)))
        return np.concatenate(parts)

    def derivative(self, points: Array, theta: Array) -> Derivative:
        """The derivative of :meth:`residual`: that of the area is over twice the residual."""
        parts = [] if self._planes is None else [self._planes.derivative(points)]
        if self.method == "area":
            parts.insert(0, self._area_derivative(points))
        return Derivative(points=np.concatenate(parts))

    def _area_derivative(self, points: Array) -> Array:
        found, text = self.found(points), self._text
        area = found.by_letter(len(text.glyphs))
        counts = [sum(glyph.contours) for glyph in text.glyphs]
        gradient = found.gradient(text.word.contours, np.cumsum(counts) - counts)
        # Letters that only touch are free. The derivative of the root has no limit there.
        scale = np.where(area > TOUCH, 0.5 / np.sqrt(np.maximum(area, TOUCH)), 0.0)
        return scale[:, None, None] * gradient

    def found(self, points: Array) -> Collisions:
        """What overlaps, or is nearer than the gap, at control points (K, 2) of the bound text.

        The last few results are kept, because the derivative is evaluated where the residual was.
        """

        def make() -> Collisions:
            own = letters(self._text, points)
            return collisions(own, self._shapes, self.between_glyphs, self.gap)

        return self._latest.get(points.tobytes(), make)

    def miss(self, residual: Array) -> float:
        """The square root of the common area, or how far a point is beyond its plane."""
        count = len(self._text.glyphs) if self.method == "area" else 0
        area, planes = residual[:count], residual[count:]
        return max(float(np.sqrt(area @ area)), float(planes.max(initial=0.0)))

    def missed_by(self, miss: float) -> str:
        """The miss in words."""
        return f"{miss:.1f} font units (the root of the common area, or a gap)"
