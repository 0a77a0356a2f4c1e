"""One glyph as dense tensors: control points, delta sets, supports, and Eq. 1–2 over them."""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from fontTools.ttLib import TTFont

from ..arrays import Array, ArrayLike, like, to_tensor
from ..outline.coordinates import check_coordinates
from ..outline.cubics import segment_indices, x_extent
from ..outline.variation import Regions
from .glyf import PHANTOMS, read_outline, to_cubics
from .metrics import read_advance

if TYPE_CHECKING:
    import torch


@dataclass(frozen=True)
class AffineGlyph:
    """A glyph's numbers as numpy arrays: what is affine in its scaling factors.

    Attributes
    ----------
    base : (k, 2) array
    deltas : (k, 2, m) array
    support : (m, n, 3) array
    advance_base : float
    advance_deltas : (m',) array
    advance_support : (m', n, 3) array
        An advance may vary over other regions than the outline.
    """

    base: Array
    deltas: Array
    support: Array
    advance_base: float
    advance_deltas: Array
    advance_support: Array


class Glyph:
    """A glyph of a variable font; :meth:`vfwidget.Font.glyph` makes it.

    k control points, m delta sets, n axes; font units, y up, the origin at the left side
    bearing point. Coordinates ``w`` are normalized, (n,) or any batch (..., n); whatever is
    computed from them is float64 and differentiable by autograd, and outside -1 … 1 they are
    clamped with a warning.

    Attributes
    ----------
    name : str
    glyph_id : int
    contours : tuple of int
        How many cubic segments each closed contour has. A contour of s segments has 3 s control
        points: the start and the two inner points of each segment, the last ending at the first.
    affine : AffineGlyph
        The same numbers for numpy.
    """

    def __init__(self, font: TTFont, name: str) -> None:
        raw = read_outline(font, name)
        layers, self.contours = to_cubics(raw)
        # Rasterisers put the left side bearing point at the origin, and so the outline's delta
        # sets carry that point's deltas too.
        layers = layers - raw.points[:, -PHANTOMS, None] * [1.0, 0.0]
        self.name = name
        self.glyph_id: int = font.getGlyphID(name)
        self.affine = AffineGlyph(
            layers[0],
            np.moveaxis(layers[1:], 0, -1),
            raw.support,
            *read_advance(font, name, raw),
        )
        self._regions = Regions(raw.support)
        self._advance_regions = Regions(self.affine.advance_support)

    def __repr__(self) -> str:
        k, _, m = self.affine.deltas.shape
        return f"<Glyph {self.name!r}: {k} control points, {m} delta sets>"

    @cached_property
    def default(self) -> torch.Tensor:
        """Control points of the default outline, (k, 2)."""
        return to_tensor(self.affine.base)

    @cached_property
    def deltas(self) -> torch.Tensor:
        """Displacements of the control points in each delta set, (k, 2, m)."""
        return to_tensor(self.affine.deltas)

    @cached_property
    def support(self) -> torch.Tensor:
        """Start, peak and end of each delta set on each axis, (m, n, 3)."""
        return to_tensor(self.affine.support)

    def scalars(self, w: ArrayLike) -> torch.Tensor:
        """Scaling factors γ(w) of the delta sets, (..., m) (Eq. 2).

        Raises
        ------
        AxisError
            ``w`` has the wrong length or holds NaN; so for every method that takes ``w``.
        """
        return self._regions.scalars(self._check(w))

    def points(self, w: ArrayLike) -> torch.Tensor:
        """Control points at w, (..., k, 2) (Eq. 1)."""
        gamma = self.scalars(w)
        return like(self.affine.base, gamma) + _contract(like(self.affine.deltas, gamma), gamma)

    def jacobian(self, w: ArrayLike) -> torch.Tensor:
        """Derivative of the control points by the coordinates, (..., k, 2, n), in closed form.

        At a kink it is the derivative from the right (at w = 1, from the left), as is the one
        that autograd finds.
        """
        _, slopes = self._regions.scalars_and_jacobian(self._check(w))
        k, _, m = self.affine.deltas.shape
        flat = like(self.affine.deltas, slopes).reshape(k * 2, m) @ slopes
        return flat.reshape(*flat.shape[:-2], k, 2, flat.shape[-1])

    def segments(self, w: ArrayLike) -> list[torch.Tensor]:
        """The outline at w as closed contours of cubic segments, each (..., s, 4, 2)."""
        points = self.points(w)
        return [points[..., indices, :] for indices in segment_indices(self.contours)]

    def advance(self, w: ArrayLike) -> torch.Tensor:
        """Advance width at w, (...), unrounded: HVAR where the font has it, else phantom points.

        It is never negative: where deltas add up to less than nothing, renderers take 0.
        """
        gamma = self._advance_regions.scalars(self._check(w))
        return (self.affine.advance_base + gamma @ like(self.affine.advance_deltas, gamma)).clip(0)

    def side_bearings(self, w: ArrayLike) -> tuple[torch.Tensor, torch.Tensor]:
        """Left and right side bearing at w, each (...).

        From the origin to the outline's left edge, and from its right edge to the advance;
        without an outline both are zero.
        """
        advance = self.advance(w)
        if not self.contours:
            return advance * 0, advance * 0
        left, right = x_extent(self.segments(w))
        return left, advance - right

    def without_advance(self) -> Glyph:
        """The same outline on an advance of zero: a mark, which takes no room in a line."""
        twin = copy(self)
        none = self.affine.advance_support[:0]
        twin.affine = replace(
            self.affine, advance_base=0.0, advance_deltas=np.zeros(0), advance_support=none
        )
        twin._advance_regions = Regions(none)
        return twin

    def _check(self, w: ArrayLike) -> torch.Tensor:
        return check_coordinates(w, self._regions.support.shape[1])


def _contract(deltas: Any, gamma: Any) -> Any:
    """Δ·γ over the delta sets: (k, 2, m) with (..., m) to (..., k, 2)."""
    k, _, m = deltas.shape
    moved = gamma @ deltas.reshape(k * 2, m).T
    return moved.reshape(*gamma.shape[:-1], k, 2)
