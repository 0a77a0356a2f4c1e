"""Coverage as a function that PyTorch differentiates: autograd, forward mode and torch.func."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, TypeVar

import numpy as np
import torch
from torch import Tensor

from ..errors import ImageError
from .coverage import Boundary, fill

CLOSED = 1e-3
"""How far, in pixels, a contour's end may be from its beginning."""
FARTHEST = 1e9
"""Pixels from the origin; the cuts of a larger cubic are closer than rounding can tell apart."""

Dims = tuple[int | None, ...]
Function = TypeVar("Function", bound=Callable[..., Any])


class Kept:
    """A boundary that travels beside the images."""

    def __init__(self, boundary: Boundary) -> None:
        self.boundary = boundary


class Given(NamedTuple):
    """Arguments that are given in full, as PyTorch reads them from ``inspect.BoundArguments``."""

    args: tuple[Any, ...]
    kwargs: dict[str, Any]

    def apply_defaults(self) -> None:
        """There are none."""


class Positional(inspect.Signature):
    """The signature of a function whose arguments are always given in full and in order."""

    def bind(self, *args: Any, **kwargs: Any) -> Any:
        """The arguments as they are; a general signature takes twenty times as long."""
        return Given(args, kwargs)


def signed(function: Function) -> Function:
    """The function with its signature, which PyTorch would otherwise find anew at every call."""
    parameters = inspect.signature(function).parameters.values()
    function.__signature__ = Positional(list(parameters))  # type: ignore[attr-defined]
    return function


class Coverage(torch.autograd.Function):
    """Points (B, S, 4, 2) to images (B, H, W), and what their derivative needs.

    The numbers (B,) of the images come with them. Under vmap they have the batch dimensions of the
    points, so that a derivative can tell these dimensions from its own.
    """

    @staticmethod
    @signed
    def forward(
        points: Tensor, sizes: Sequence[int], height: int, width: int
    ) -> tuple[Tensor, Tensor, Kept]:
        """The images."""
        values = inner(points)
        check_contours(values, sizes)
        image, boundary = fill(values, sizes, height, width)
        return outer(image), torch.arange(len(image), device=points.device), Kept(boundary)

    @staticmethod
    def setup_context(
        ctx: Any, inputs: tuple[Any, ...], output: tuple[Tensor, Tensor, Kept]
    ) -> None:
        """Keep the boundary."""
        _, ctx.numbers, kept = output
        ctx.boundary = kept.boundary
        ctx.mark_non_differentiable(ctx.numbers)

    @staticmethod
    def backward(ctx: Any, slope: Tensor, *_: None) -> tuple[Tensor | None, ...]:
        """The slope by the points."""
        boundary = ctx.boundary

        def gradient(slopes: Any) -> Any:
            return boundary.gradient(slopes).reshape(len(slopes), -1, 4, 2)

        return Linear.apply(slope, ctx.numbers, gradient), None, None, None

    @staticmethod
    def jvp(ctx: Any, tangent: Tensor, *_: None) -> tuple[Tensor, None, None]:
        """How the images change as the points move."""
        boundary = ctx.boundary

        def derivative(tangents: Any) -> Any:
            return boundary.derivative(tangents.reshape(-1, 4, 2, 1))[0]

        return Linear.apply(tangent, ctx.numbers, derivative), None, None

    @staticmethod
    def vmap(
        info: Any, dims: Dims, points: Tensor, sizes: Sequence[int], height: int, width: int
    ) -> tuple[tuple[Tensor, Tensor, Kept], tuple[int, int, None]]:
        """One more batch dimension."""
        points = points.movedim(dims[0], 0)  # type: ignore[arg-type]
        images, numbers, kept = Coverage.apply(points.flatten(0, 1), sizes, height, width)
        batch = points.shape[:2]
        return (images.unflatten(0, batch), numbers.unflatten(0, batch), kept), (0, 0, None)


class Linear(torch.autograd.Function):
    """A linear map of arrays (B, …), one for each image; its own derivative is not offered."""

    @staticmethod
    @signed
    def forward(values: Tensor, numbers: Tensor, work: Callable[[Any], Any]) -> Tensor:
        """The map's value."""
        return outer(work(inner(values)))

    @staticmethod
    def setup_context(ctx: Any, inputs: tuple[Any, ...], output: Tensor) -> None:
        """Nothing is kept."""

    @staticmethod
    def vmap(
        info: Any, dims: Dims, values: Tensor, numbers: Tensor, work: Callable[[Any], Any]
    ) -> tuple[Tensor, int]:
        """The map of each, or of all where this dimension is one of the images."""
        if dims[0] is None:
            values = values.expand(info.batch_size, *values.shape)
        else:
            values = values.movedim(dims[0], 0)
        if dims[1] is None:
            return torch.stack([Linear.apply(one, numbers, work) for one in values]), 0
        numbers = numbers.movedim(dims[1], 0)
        mapped = Linear.apply(values.flatten(0, 1), numbers.flatten(), work)
        return mapped.unflatten(0, values.shape[:2]), 0


def inner(values: Tensor) -> Any:
    """On the CPU numpy's small operations cost a third of torch's."""
    values = values.detach().contiguous()
    return values.numpy() if values.device.type == "cpu" else values


def outer(values: Any) -> Tensor:
    """What :func:`inner` made, as a tensor."""
    return torch.from_numpy(values) if isinstance(values, np.ndarray) else values


def check_contours(points: Any, sizes: Sequence[int]) -> None:
    """See that contours, a (B, S, 4, 2) array or tensor, are finite and closed.

    Raises
    ------
    ImageError
    """
    # NaN makes the maximum NaN, so that the comparison fails.
    reach = float(abs(points).max())
    if not reach <= FARTHEST:
        found = f"reach {reach:.3g} pixels" if np.isfinite(reach) else "hold NaN or infinity"
        raise ImageError(f"The contours {found}; the largest coordinate is {FARTHEST:.0e} pixels.")
    counts = np.asarray(sizes)
    ends = counts.cumsum()
    follower = np.arange(1, ends[-1] + 1)
    follower[ends - 1] = ends - counts
    gap = float(abs(points[:, :, 3] - points[:, follower, 0]).max())
    if gap > CLOSED * max(1.0, 1e-3 * reach):
        raise ImageError(f"Each segment begins where the one before it ends; one is {gap:.3g} off.")
