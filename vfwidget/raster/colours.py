"""Colour glyphs as an image: one coverage for each layer, painted one over the other."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import torch
from torch import Tensor

from ..arrays import Array
from ..outline.paint import BLACK, LINEAR, SOLID, SWEEP, Colour, Fill, Palette, Shape
from .autograd import Coverage

SINGULAR = 1e-12
"""A paint that is placed by a matrix of a smaller determinant has no area."""


def paint(
    shapes: Sequence[Shape],
    palette: Palette,
    size: tuple[int, int],
    transform: Array,
    foreground: Colour = BLACK,
) -> Tensor:
    """Draw shapes with their colours.

    Parameters
    ----------
    shapes : sequence of Shape
        From back to front.
    palette : palette
    size : (H, W)
    transform : (2, 3) array
        From the units of the shapes to pixels.
    foreground : (red, green, blue, alpha)
        Colour of the text. Default black.

    Returns
    -------
    (H, W, 4) tensor
        Red, green, blue and alpha from 0 to 1, not premultiplied.
    """
    height, width = size
    y, x = np.mgrid[:height, :width] + 0.5
    image = np.zeros((height, width, 4))
    for shape in shapes:
        placed = [c @ transform[:, :2].T + transform[:, 2] for c in shape.contours]
        if not placed:
            continue
        points = torch.from_numpy(np.concatenate(placed))[None]
        covered = Coverage.apply(points, [len(c) for c in placed], height, width)[0][0].numpy()
        colour = np.broadcast_to(foreground, image.shape)
        if shape.fill is not None:
            colour = _colours(shape.fill, shape.fill.colours(palette, foreground), x, y, transform)
        # Premultiplied, and each layer over those before it.
        alpha = (colour[..., 3] * covered)[..., None]
        image = np.concatenate([colour[..., :3] * alpha, alpha], -1) + image * (1 - alpha)
    alpha = image[..., 3:]
    # What is transparent has the colour of the text, so that video codecs blur no other into it.
    straight = np.where(alpha > 0, image[..., :3] / np.where(alpha > 0, alpha, 1), foreground[:3])
    return torch.from_numpy(np.concatenate([straight, alpha], -1))


def _colours(fill: Fill, colours: Array, x: Array, y: Array, transform: Array) -> Array:
    """The colour of a paint with stops (s, 4) at the middle of every pixel, (H, W, 4)."""
    if fill.kind == SOLID:
        return np.broadcast_to(colours[0], (*x.shape, 4))
    linear = transform[:, :2] @ fill.matrix[:, :2]
    shift = transform[:, :2] @ fill.matrix[:, 2] + transform[:, 2]
    if abs(np.linalg.det(linear)) < SINGULAR:
        return np.zeros((*x.shape, 4))
    px, py = np.tensordot(np.linalg.inv(linear), [x - shift[0], y - shift[1]], 1)
    if fill.kind == LINEAR:
        start, end = fill.geometry.reshape(2, 2)
        along = end - start
        length = along @ along
        t = ((px - start[0]) * along[0] + (py - start[1]) * along[1]) / (length or np.inf)
    elif fill.kind == SWEEP:
        angles = np.degrees(np.arctan2(py - fill.geometry[1], px - fill.geometry[0])) % 360
        t = fill.sweep(angles)
    else:
        t = radial(fill.geometry, px, py)
    drawn = np.isfinite(t)[..., None]
    return fill.between_stops(np.where(drawn[..., 0], t, 0), colours) * drawn


def radial(geometry: Array, x: Array, y: Array) -> Array:
    """Where points lie on a gradient between two circles; NaN outside the cone that they span.

    It is the greatest t whose circle, between or beyond the two, passes through the point.
    """
    x0, y0, r0, x1, y1, r1 = geometry
    dx, dy, dr = x1 - x0, y1 - y0, r1 - r0
    px, py = x - x0, y - y0
    a = dx * dx + dy * dy - dr * dr
    b = px * dx + py * dy + r0 * dr
    c = px * px + py * py - r0 * r0
    with np.errstate(divide="ignore", invalid="ignore"):
        if abs(a) < SINGULAR:
            roots = [c / (2 * b)]
        else:
            root = np.sqrt(b * b - a * c)
            roots = [(b + root) / a, (b - root) / a]
        valid = [np.where(r0 + t * dr >= 0, t, -np.inf) for t in roots]
        # A root of a negative number is NaN, and stays so.
        t = np.maximum.reduce(valid)
    return np.where(np.isfinite(t), t, np.nan)
