"""The public calls: closed cubic contours, or a text, in; an image of its ink out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import torch
from torch import Tensor

from ..arrays import Array, ArrayLike, to_array, to_tensor
from ..errors import ImageError
from ..limits import limits
from ..text import Text
from ..text.colours import palette_of, shapes
from .autograd import Coverage, check_contours, inner, outer
from .colours import paint
from .coverage import fill

BACKENDS = ("exact", "diffvg")
MARGIN = 0.08
"""Share of the image that :func:`frame` leaves free at every side."""

Contours = Sequence[ArrayLike]


def rasterize(
    text_or_segments: Text | Contours,
    size: tuple[int, int],
    transform: ArrayLike | None = None,
    backend: str = "exact",
    palette: int | Sequence[ArrayLike] | None = None,
) -> Tensor:
    """Anti-aliased coverage of closed cubic contours, filled nonzero; autograd passes.

    Parameters
    ----------
    text_or_segments : Text, or sequence of (..., s, 4, 2) tensors or arrays
        Closed contours of s cubic segments each, in pixels, y down; the pixel of row 0 and
        column 0 covers [0, 1]². Leading dimensions, the same for all contours, are a batch. A
        Text is in font units, y up.
    size : (H, W)
    transform : (2, 3) array or tensor, optional
        Affine placement: p ↦ A p + b, [A | b]. By default none for contours, and :func:`frame`
        for a Text. It may have leading batch dimensions, and gradients.
    backend : {"exact", "diffvg"}
        Exact area, on the CPU or where the contours are; or diffvg's samples, where ``pydiffvg``
        is installed.
    palette : int or list of colours, optional
        Draw a Text with the colours of its glyphs: by the index of a palette of the font, or by
        colours of red, green, blue and alpha from 0 to 1. By default everything is ink.

    Returns
    -------
    (..., H, W) tensor
        Ink 1, paper 0, in the contours' floating-point type, or float64. With a palette: (H, W, 4),
        red, green, blue and alpha, without a gradient; rasterize the outlines of
        ``glyph.layers`` for one coverage each, with its gradient.

    Raises
    ------
    ImageError
        An image of no pixels or of too many, contours that are not closed or not finite, wrong
        shapes, an unknown backend, a diffvg that is not there, or a palette for contours.
    TextError
        The font has no such palette.
    OverlapError
        Too many curves cross or lie side by side, by ``limits.curve_pairs``.

    Notes
    -----
    "exact": the fraction of each pixel's square that lies inside, to rounding; no flattening, no
    samples. The gradient is the exact boundary integral, forwards (``torch.autograd.forward_ad``)
    and backwards, once. See :mod:`vfwidget.raster.coverage`.

    Examples
    --------
    >>> import vfwidget as vf
    >>> image = vf.rasterize(vf.Text("recursive", "a"), size=(64, 64))
    >>> tuple(image.shape)
    (64, 64)
    """
    if backend not in BACKENDS:
        raise ImageError(f"There is no backend {backend!r}: choose one of {', '.join(BACKENDS)}.")
    height, width = check_size(size)
    if palette is not None:
        if not isinstance(text_or_segments, Text) or backend != "exact":
            raise ImageError('A palette needs a Text, and the backend "exact".')
        placement = frame(text_or_segments, size) if transform is None else transform
        colours = palette_of(text_or_segments.font, palette)
        return paint(shapes(text_or_segments), colours, (height, width), _placement(placement))
    points, sizes = _gather(text_or_segments)
    if transform is None and isinstance(text_or_segments, Text):
        transform = frame(text_or_segments, size)
    if transform is not None:
        points = _place(points, transform)
    batch = points.shape[:-3]
    if not sizes:
        return points.new_zeros(*batch, height, width)
    points = points.reshape(-1, *points.shape[-3:])
    if backend == "diffvg":
        from .diffvg import render

        check_contours(points.detach(), sizes)
        image = render(points, sizes, height, width)
    else:
        image = Coverage.apply(points.double(), sizes, height, width)[0].to(points.dtype)
    return image.reshape(*batch, height, width)


def image_and_jacobian(
    segments: Contours, moves: Contours, size: tuple[int, int]
) -> tuple[Tensor, Tensor]:
    """Coverage, and its derivative along a few directions at once, such as a font's axes.

    Parameters
    ----------
    segments : sequence of (s, 4, 2) tensors or arrays
        As in :func:`rasterize`.
    moves : sequence of (s, 4, 2, a) tensors or arrays
        How the control points move in each of a directions.
    size : (H, W)

    Returns
    -------
    image : (H, W) tensor
    jacobian : (H, W, a) tensor

    Raises
    ------
    ImageError
        As :func:`rasterize`, and moves that are not those of the segments.
    """
    height, width = check_size(size)
    points, sizes = _gather(segments)
    tangents = [to_tensor(move) for move in moves]
    fitting = [tuple(m.shape[:-1]) for m in tangents] == [(s, 4, 2) for s in sizes]
    if not sizes or not fitting or len({m.shape[-1] for m in tangents}) > 1 or points.ndim != 3:
        raise ImageError(
            "Each contour (s, 4, 2) needs tangents (s, 4, 2, a), with one a for all contours."
        )
    check_contours(points[None], sizes)
    image, boundary = fill(inner(points[None].double()), sizes, height, width)
    jacobian = boundary.derivative(inner(torch.cat(tangents).double()))
    return outer(image)[0], outer(jacobian)[:, 0].movedim(0, -1)


def frame(text: Text, size: tuple[int, int]) -> Tensor:
    """The placement (2, 3) that shows a whole line in an image: centred, y down, with a margin.

    Parameters
    ----------
    text : Text
        Its advance widths, and its font's ascender and descender, are fitted.
    size : (H, W)
    """
    height, width = check_size(size)
    top, bottom, across = text.font.ascender, text.font.descender, text.advance()
    room = 1 - 2 * MARGIN
    scale = room * min(height / max(top - bottom, 1.0), width / max(across, 1.0))
    x = (width - scale * across) / 2
    y = (height + scale * (top + bottom)) / 2
    return torch.tensor([[scale, 0.0, x], [0.0, -scale, y]], dtype=torch.float64)


def check_size(size: tuple[int, int]) -> tuple[int, int]:
    """The height and width of an image.

    Raises
    ------
    ImageError
        They are no whole numbers, or the image has no pixels or too many.
    """
    try:
        height, width = (int(side) for side in size)
        whole = (height, width) == tuple(size)
    except (TypeError, ValueError, OverflowError):
        whole = False
    if not whole:
        raise ImageError(f"size must be (height, width) in whole pixels; received {size!r}.")
    if height < 1 or width < 1:
        raise ImageError(f"An image of {height} × {width} has no pixels.")
    if height * width > limits.raster_pixels:
        raise ImageError(
            f"An image of {height} × {width} has more than {limits.raster_pixels:,} pixels. "
            "Draw it in parts, or raise vfwidget.limits.raster_pixels."
        )
    return height, width


def _gather(text_or_segments: Text | Contours) -> tuple[Tensor, list[int]]:
    """All control points (..., S, 4, 2), contour after contour, and their segments' numbers."""
    if isinstance(text_or_segments, Text):
        text_or_segments = text_or_segments.segments()
    elif isinstance(text_or_segments, Tensor | np.ndarray):
        raise ImageError("Contours must be a list of (s, 4, 2) arrays; received one array.")
    try:
        contours = [to_tensor(contour) for contour in text_or_segments]
    except (TypeError, ValueError, RuntimeError) as error:
        raise ImageError(f"Contours must be (s, 4, 2) arrays of numbers ({error}).") from None
    contours = [contour for contour in contours if contour.numel()]
    for contour in contours:
        if contour.ndim < 3 or contour.shape[-2:] != (4, 2):
            raise ImageError(
                f"A contour must have the shape (s, 4, 2); received {tuple(contour.shape)}."
            )
        if contour.shape[:-3] != contours[0].shape[:-3]:
            raise ImageError("The contours' batch dimensions differ.")
        if contour.layout is not torch.strided or contour.is_meta:
            raise ImageError("A contour must be a dense tensor that holds its numbers.")
    if not contours:
        return torch.zeros(0, 4, 2, dtype=torch.float64), []
    return torch.cat(contours, -3), [contour.shape[-3] for contour in contours]


def _placement(transform: ArrayLike) -> Array:
    """One transform as a (2, 3) array."""
    eye = torch.eye(2, dtype=torch.float64)
    corners = torch.stack([0 * eye[0], *eye])[None, None]
    origin, x, y = to_array(_place(corners, transform)).reshape(3, 2)
    return np.stack([x - origin, y - origin, origin], -1)


def _place(points: Tensor, transform: ArrayLike) -> Tensor:
    try:
        placed = to_tensor(transform).to(points)
    except (TypeError, ValueError, RuntimeError) as error:
        raise ImageError(f"transform must be a (2, 3) array of numbers ({error}).") from None
    if placed.shape[-2:] != (2, 3):
        raise ImageError(f"transform must have the shape (2, 3); received {tuple(placed.shape)}.")
    if placed.ndim > 2:
        placed = placed[..., None, :, :]
    # One matrix for all points is much quicker than the same matrix for each cubic.
    linear, shift = placed[..., :2].mT, placed[..., None, :, 2]
    try:
        return points @ linear + shift
    except RuntimeError:
        raise ImageError(
            f"Transforms {tuple(placed.shape)} do not fit contours of batch "
            f"{tuple(points.shape[:-3])}."
        ) from None
