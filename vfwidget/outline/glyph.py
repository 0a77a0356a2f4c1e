"""One glyph: its control points and its advance as functions of the axes (Eq. 1–2)."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from copy import copy
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arrays import Array, ArrayLike, to_tensor
from ..errors import GlyphError
from .composed import Composed, Coordinates
from .contours import Contours
from .coordinates import check_coordinates
from .cubics import x_extent
from .paint import Paint
from .varying import Affine, Varying, constant, owned

if TYPE_CHECKING:
    import torch


@dataclass(frozen=True)
class AffineGlyph:
    """The numbers of an affine glyph as numpy arrays.

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
    """A glyph of a variable font, from arrays; :meth:`vfwidget.Font.glyph` reads one from a file.

    A glyph has k control points, m delta sets and n axes. Lengths are in font units, y up. The
    origin is the left side bearing point. Coordinates ``w`` are normalized, (n,) or any batch
    (..., n). Results are float64 tensors, and autograd differentiates them. Coordinates outside
    -1 … 1 are clamped with a warning.

    Parameters
    ----------
    default : (k, 2) array or tensor
        Control points of the default outline, contour after contour.
    deltas : (k, 2, m) array or tensor
        Displacements of the control points in each delta set. If ``default``, ``deltas`` or a
        part of ``advance`` is a tensor that requires grad, the results carry its gradient.
    support : (m, n, 3) array
        Start, peak and end of each delta set on each axis, in normalized coordinates.
    contours : sequence of int
        How many cubic segments each closed contour has. A contour of s segments has 3 s control
        points: the start and the two inner points of each segment. The last segment ends at the
        start of the first one.
    advance : float, or (default, deltas, support)
        The advance width. A single number is the advance at every location. The triple is a
        number, (m',) deltas and their (m', n, 3) support.
    name : str
        Default empty.
    glyph_id : int
        Index of the glyph in its font. Default 0.

    Attributes
    ----------
    contours : Contours
    outline : Varying
        The control points as a function of w, for numpy arrays and tensors, without checks.
    advance_width : Varying
        The advance width in the same form. It may be negative; :meth:`advance` never is.
    advance_height : Varying or None
        The advance of vertical text in the same form; None where the font has no vertical metrics.
    layers : tuple of Layer
        What a colour glyph paints, from back to front; read when first used. Empty for other
        glyphs.

    Raises
    ------
    GlyphError
        The shapes do not fit together, or a number is not finite.

    Examples
    --------
    A square that grows to the right along one axis:

    >>> import numpy as np
    >>> corners = np.array([[0, 0], [0, 300], [300, 300], [300, 0]])
    >>> ends = np.roll(corners, -1, 0)
    >>> thirds = [corners, (2 * corners + ends) / 3, (corners + 2 * ends) / 3]
    >>> default = np.stack(thirds, 1).reshape(12, 2)
    >>> deltas = np.zeros((12, 2, 1))
    >>> deltas[:, 0, 0] = default[:, 0] / 3
    >>> glyph = Glyph(default, deltas, [[[0, 1, 1]]], [4], advance=(300, [100], [[[0, 1, 1]]]))
    >>> glyph.points([0.5]).max().item(), glyph.advance([0.5]).item()
    (350.0, 350.0)
    """

    outline: Varying
    advance_width: Varying
    advance_height: Varying | None = None
    read_layers: Callable[[], tuple[Layer, ...]] | None = None

    def __init__(
        self,
        default: ArrayLike,
        deltas: ArrayLike,
        support: ArrayLike,
        contours: Iterable[int],
        advance: Any = 0.0,
        name: str = "",
        glyph_id: int = 0,
    ) -> None:
        points, *rest = map(owned, (default, deltas, support))
        shape = tuple(np.shape(points))
        if len(shape) != 2 or shape[1] != 2:
            raise GlyphError(
                f"default must have the shape (k, 2), x and y of each control point; "
                f"received {shape}."
            )
        outline = Affine(points, *rest)
        advance_width = _read_advance(advance, outline.axis_count)
        self._assemble(outline, advance_width, contours, name, glyph_id)

    @classmethod
    def of(
        cls,
        outline: Varying,
        advance_width: Varying,
        contours: Iterable[int],
        name: str = "",
        glyph_id: int = 0,
    ) -> Glyph:
        """A glyph of any form, from its control points (k, 2) and its advance as functions of w.

        Raises
        ------
        GlyphError
            The shapes do not fit together.
        """
        glyph = cls.__new__(cls)
        glyph._assemble(outline, advance_width, contours, name, glyph_id)
        return glyph

    def _assemble(
        self,
        outline: Varying,
        advance: Varying,
        contours: Iterable[int],
        name: str,
        glyph_id: int,
    ) -> None:
        self.outline, self.advance_width = outline, advance
        self.contours = Contours(contours)
        self.name, self.glyph_id = name, glyph_id
        if outline.shape != (self.contours.point_count, 2):
            raise GlyphError(
                f"Contours of {list(self.contours)} segments have 3 control points for each "
                f"segment, ({self.contours.point_count}, 2) in all; received {outline.shape}."
            )
        if advance.shape or advance.axis_count != outline.axis_count:
            raise GlyphError(
                f"The advance must be one number over the {outline.axis_count} axes of the "
                f"outline; received the shape {advance.shape} over {advance.axis_count} axes."
            )

    def __repr__(self) -> str:
        count = len(self.support) if self.is_affine else 0
        sets = f", {count} delta set{'' if count == 1 else 's'}" if self.is_affine else ""
        return f"<Glyph {self.name!r}: {self.contours.point_count} control points{sets}>"

    @property
    def is_affine(self) -> bool:
        """Whether outline and advance are affine in scalars, so that :attr:`affine` exists."""
        return isinstance(self.outline, Affine) and isinstance(self.advance_width, Affine)

    @property
    def affine(self) -> AffineGlyph:
        """The numbers of an affine glyph as numpy arrays.

        Raises
        ------
        GlyphError
            The glyph is of another form; use :attr:`outline` and :attr:`advance_width`.
        """
        outline, advance = self._affine(self.outline), self._affine(self.advance_width)
        return AffineGlyph(
            outline.base,
            outline.deltas,
            outline.support,
            float(advance.base),
            advance.deltas,
            advance.support,
        )

    @property
    def nbytes(self) -> int:
        """Memory of the glyph's arrays, in bytes."""
        return self.outline.nbytes + self.advance_width.nbytes

    @cached_property
    def layers(self) -> tuple[Layer, ...]:
        """See the attributes of the class."""
        return self.read_layers() if self.read_layers else ()

    def __copy__(self) -> Glyph:
        twin = Glyph.__new__(Glyph)
        twin.__dict__.update(self.__dict__)
        return twin

    def __getstate__(self) -> dict[str, Any]:
        """A copy that is sent elsewhere takes its layers along."""
        return {**self.__dict__, "layers": self.layers, "read_layers": None}

    @property
    def default(self) -> torch.Tensor:
        """Control points of the default outline, (k, 2)."""
        return self._affine(self.outline).tensors[0]

    @property
    def deltas(self) -> torch.Tensor:
        """Displacements of the control points in each delta set, (k, 2, m)."""
        return self._affine(self.outline).tensors[1]

    @property
    def support(self) -> torch.Tensor:
        """Start, peak and end of each delta set on each axis, (m, n, 3)."""
        return to_tensor(self._affine(self.outline).support)

    def scalars(self, w: ArrayLike) -> torch.Tensor:
        """Scalars γ(w) of the delta sets, (..., m) (Eq. 2; the paper calls them scaling factors).

        Raises
        ------
        AxisError
            ``w`` has the wrong length or holds NaN; so for every method that takes ``w``.
        """
        return self._affine(self.outline).regions.scalars(self._check(w))

    def points(self, w: ArrayLike) -> torch.Tensor:
        """Control points at w, (..., k, 2) (Eq. 1)."""
        return self.outline.value(self._check(w))

    def jacobian(self, w: ArrayLike) -> torch.Tensor:
        """Derivative of the control points by the coordinates, (..., k, 2, n), in closed form.

        At a kink this method and autograd both return the derivative from the right; at w = 1
        they return the one from the left.
        """
        return self.outline.value_and_jacobian(self._check(w))[1]

    def segments(self, w: ArrayLike) -> list[torch.Tensor]:
        """The outline at w as closed contours of cubic segments, each (..., s, 4, 2)."""
        return self.contours.split(self.points(w))

    def advance(self, w: ArrayLike) -> torch.Tensor:
        """Advance width at w, (...), unrounded: HVAR where the font has it, else phantom points.

        It is never negative: renderers take 0 where the deltas add up to less.
        """
        return self.advance_width.value(self._check(w)).clip(0)

    def vertical_advance(self, w: ArrayLike) -> torch.Tensor:
        """Advance of vertical text at w, (...), downwards: VVAR, or else phantom points.

        Raises
        ------
        GlyphError
            The font has no vertical metrics (no vmtx table).
        """
        if self.advance_height is None:
            raise GlyphError(f"Glyph {self.name!r} has no vertical metrics (no vmtx table).")
        return self.advance_height.value(self._check(w))

    def side_bearings(self, w: ArrayLike) -> tuple[torch.Tensor, torch.Tensor]:
        """Left and right side bearing at w, each (...).

        The left one reaches from the origin to the left edge of the outline, the right one from
        its right edge to the advance. Without an outline both are zero.
        """
        advance = self.advance(w)
        if not self.contours:
            return advance * 0, advance * 0
        left, right = x_extent(self.segments(w))
        return left, advance - right

    def named(self, name: str, glyph_id: int) -> Glyph:
        """The same glyph with another name and glyph id."""
        twin = copy(self)
        twin.name, twin.glyph_id = name, glyph_id
        return twin

    def over(self, coordinates: Coordinates) -> Glyph:
        """The glyph over other coordinates, which ``coordinates`` converts to its own."""
        twin = copy(self)
        twin.outline = Composed(self.outline, coordinates)
        twin.advance_width = Composed(self.advance_width, coordinates)
        if self.advance_height is not None:
            twin.advance_height = Composed(self.advance_height, coordinates)
        if self.read_layers:
            twin.__dict__.pop("layers", None)
            twin.read_layers = lambda: tuple(layer.over(coordinates) for layer in self.layers)
        return twin

    def _check(self, w: ArrayLike) -> torch.Tensor:
        return check_coordinates(w, self.outline.axis_count)

    def _affine(self, quantity: Varying) -> Affine:
        if not isinstance(quantity, Affine):
            raise GlyphError(
                f"Glyph {self.name!r} is not affine in scalars, so it has no delta sets. "
                "Use points(w), jacobian(w) and advance(w)."
            )
        return quantity


@dataclass(frozen=True)
class Layer:
    """One layer of a colour glyph.

    Attributes
    ----------
    glyph : Glyph
        The outline that the paint fills; its advance is that of the glyph it is taken from.
    paint : Paint
    """

    glyph: Glyph
    paint: Paint

    def over(self, coordinates: Coordinates) -> Layer:
        """The layer over other coordinates, which ``coordinates`` converts to its own."""
        return Layer(self.glyph.over(coordinates), self.paint.over(coordinates))


def _read_advance(advance: Any, axis_count: int) -> Affine:
    if not isinstance(advance, tuple):
        return constant(owned(advance), axis_count)
    try:
        default, deltas, support = advance
    except ValueError:
        raise GlyphError(
            "advance must be a number or a triple (default, deltas, support); "
            f"received {len(advance)} parts."
        ) from None
    return Affine(*map(owned, (default, deltas, support)))
