"""The design space of a font: its axes, its named instances, and coordinates in it."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any

from ..arrays import Array, ArrayLike, is_tensor, like, to_array
from ..errors import AxisError, AxisWarning, warn_caller
from ..outline.composed import Composed, Displaced
from ..outline.coordinates import check_coordinates
from ..outline.varying import Varying
from . import axes as axis_maths
from .axes import Axis, NamedInstance
from .inverse import preimage

if TYPE_CHECKING:
    import torch


class DesignSpace:
    """Axes and named instances, with the maps between user and normalized coordinates.

    Attributes
    ----------
    axes : tuple of Axis
    instances : tuple of NamedInstance
    """

    axes: tuple[Axis, ...]
    instances: tuple[NamedInstance, ...]
    _displacement: Displaced | None

    def normalize(self, values: Mapping[str, Any] | NamedInstance) -> torch.Tensor:
        """User coordinates to normalized coordinates.

        Parameters
        ----------
        values : mapping of tag to number, or NamedInstance
            An axis that is not in the mapping takes its default value. A number may be a tensor;
            its gradient is kept. An instance must be one of :attr:`instances`.

        Returns
        -------
        (n,) float64 tensor

        Raises
        ------
        AxisError
            An unknown tag, a value that is not a finite number, or an instance of another font.

        Warns
        -----
        AxisWarning
            A value outside its axis's range; it is clamped, as CSS does.

        Notes
        -----
        OpenType, "Coordinate scales and normalization", with the segment maps of ``avar`` 1
        (paper, Fig. 4). Nothing is rounded to F2Dot14, so that the map stays differentiable.
        """
        import torch

        if isinstance(values, NamedInstance):
            values = self._instance_axes(values)
        parts = axis_maths.normalize(self.axes, values)
        graph = [part for part in parts if is_tensor(part)]
        if not graph:
            return torch.tensor(parts, dtype=torch.float64)
        return torch.stack([like(part, graph[0]).reshape(()) for part in parts])

    def _instance_axes(self, instance: NamedInstance) -> Mapping[str, float]:
        if instance not in self.instances:
            names = ", ".join(each.name for each in self.instances)
            raise AxisError(
                f"{instance.name!r} is an instance of another font; this font has the "
                f"instances: {names or 'none'}."
            )
        return instance.axes

    def denormalize(self, w: ArrayLike, *, final: bool = False) -> dict[str, float]:
        """Normalized coordinates (n,) to user coordinates by tag.

        Where a segment map is flat and so has no inverse, the user coordinate nearest the
        default is given.

        Parameters
        ----------
        w : (n,) array
        final : bool
            Whether ``w`` are final coordinates, as in :meth:`final_coordinates`, which are those
            that HarfBuzz reports. Default false. The two differ with ``avar`` version 2 only.

        Raises
        ------
        AxisError
            ``w`` has the wrong length or holds NaN, or no user coordinates lead to the final
            coordinates; the message states how near the axes come to them.

        Warns
        -----
        AxisWarning
            Several user coordinates lead to the final coordinates; those nearest to the default
            are given.
        """
        w = check_coordinates(w, len(self.axes))
        if w.ndim != 1:
            raise AxisError(f"One set of coordinates at a time, not {tuple(w.shape)}.")
        found = to_array(w)
        if final and self._displacement is not None:
            found = self._before_displacement(self._displacement, found)
        return axis_maths.denormalize(self.axes, found)

    def _before_displacement(self, displacement: Displaced, final: Array) -> Array:
        found = preimage(displacement, final, self.bounds)
        if not found.exists:
            nearest = axis_maths.denormalize(self.axes, found.w)
            raise AxisError(
                f"No axis values lead to the final coordinates {final.tolist()}. The nearest that "
                f"were found, {nearest}, miss one of them by {found.distance:.4g}."
            )
        if not found.unique:
            warn_caller(
                "Several axis values lead to these final coordinates; those nearest to the "
                "default are given.",
                AxisWarning,
            )
        return found.w

    @cached_property
    def bounds(self) -> tuple[Array, Array]:
        """Least and greatest normalized coordinates that the axes reach, two (n,) arrays."""
        return axis_maths.bounds(self.axes)

    def final_coordinates(self, w: ArrayLike) -> torch.Tensor:
        """The coordinates (..., n) at which the font's regions apply; autograd passes.

        They are ``w`` itself, except in a font whose ``avar`` table is of version 2, where an axis
        may move others. Everything else in this package takes and gives ``w``, the coordinates
        before that, because there each axis has its own bounds (OpenType, "avar" version 2).

        Raises
        ------
        AxisError
            ``w`` has the wrong length or holds NaN.
        """
        w = check_coordinates(w, len(self.axes))
        return self._displacement.value(w) if self._displacement else w

    @property
    def displacement(self) -> Displaced | None:
        """:meth:`final_coordinates` as a quantity over ``w``; None where it is ``w`` itself."""
        return self._displacement

    @property
    def moves_axes(self) -> bool:
        """Whether an axis moves others, so that :meth:`final_coordinates` differ from ``w``."""
        return self._displacement is not None

    def over_axes(self, quantity: Varying) -> Varying:
        """A quantity over :meth:`final_coordinates` as one over ``w``."""
        return Composed(quantity, self._displacement) if self._displacement else quantity
