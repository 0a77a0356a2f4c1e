"""The paint of a colour glyph as SVG: an attribute of its path, and the gradient it refers to."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arrays import Array
from ..outline.paint import LINEAR, SOLID, SWEEP, Fill, Palette

WEDGES = 120
"""SVG has no sweep gradient; one is drawn as so many wedges of one colour each."""


def filled(
    data: str,
    contours: Sequence[Array],
    fill: Fill,
    palette: Palette,
    name: str,
    animation: str = "",
) -> str:
    """One layer as SVG elements.

    Parameters
    ----------
    data : str
        Path data of the contours, with y downwards.
    contours : sequence of (s, 4, 2) arrays
        The same with y upwards.
    fill : Fill
    palette : palette
    name : str
        Names the gradient in its document.
    animation : str
        Elements that animate the path. The contours then include those of all keyframes.
    """
    colours = fill.colours(palette)
    stops = [
        ("currentColor" if entry is None else _hex(colour), float(colour[3]))
        for entry, colour in zip(fill.entries, colours, strict=True)
    ]
    path = f'd="{data}">{animation}</path>' if animation else f'd="{data}"/>'
    if fill.kind == SOLID:
        [(colour, alpha)] = stops
        return f'<path fill="{colour}" fill-opacity="{alpha:.3g}" {path}'
    if fill.kind == SWEEP:
        wedges = "".join(_wedges(fill, colours, contours))
        return (
            f'<clipPath id="{name}"><path {path}</clipPath>'
            f'<g clip-path="url(#{name})" shape-rendering="crispEdges">{wedges}</g>'
        )
    return f'<defs>{_gradient(fill, stops, name)}</defs><path fill="url(#{name})" {path}'


def _gradient(fill: Fill, stops: Sequence[tuple[str, float]], name: str) -> str:
    a, b, c, d, e, f = (fill.matrix * [[1], [-1]]).T.ravel()
    x0, y0, *rest = fill.geometry
    offsets = fill.offsets
    if fill.kind == LINEAR:
        kind, places = "linearGradient", dict(x1=x0, y1=y0, x2=rest[0], y2=rest[1])
    else:
        r0, x1, y1, r1 = rest
        kind = "radialGradient"
        # In SVG the gradient runs outwards, and no radius is negative.
        inner, outer = (x0, y0, max(r0, 0.0)), (x1, y1, max(r1, 0.0))
        if r0 > r1:
            inner, outer, offsets, stops = outer, inner, 1 - offsets[::-1], stops[::-1]
        places = dict(zip(("fx", "fy", "fr", "cx", "cy", "r"), (*inner, *outer), strict=True))
    where = " ".join(f'{key}="{value:.6g}"' for key, value in places.items())
    marks = "".join(
        f'<stop offset="{offset:.4g}" stop-color="{colour}" stop-opacity="{alpha:.3g}"/>'
        for offset, (colour, alpha) in zip(offsets, stops, strict=True)
    )
    return (
        f'<{kind} id="{name}" gradientUnits="userSpaceOnUse" spreadMethod="{fill.extend}" '
        f'gradientTransform="matrix({a:.6g} {b:.6g} {c:.6g} {d:.6g} {e:.6g} {f:.6g})" {where}>'
        f"{marks}</{kind}>"
    )


def _wedges(fill: Fill, colours: Array, contours: Sequence[Array]) -> list[str]:
    """Wedges around the centre of a sweep gradient that cover the contours."""
    linear, origin = fill.matrix[:, :2], fill.matrix[:, 2]
    if not contours or abs(np.linalg.det(linear)) < 1e-12:
        return []
    points = np.concatenate([contour.reshape(-1, 2) for contour in contours])
    inside = np.linalg.solve(linear, (points - origin).T).T
    centre = fill.geometry[:2]
    # A wedge is a triangle, whose far side lies nearer in its middle.
    reach = 1.01 * np.linalg.norm(inside - centre, axis=1).max() / np.cos(np.pi / WEDGES)
    angles = np.linspace(0, 360, WEDGES + 1)
    rays = np.stack([np.cos(np.radians(angles)), np.sin(np.radians(angles))], -1)
    rim = (centre + reach * rays) @ linear.T + origin
    (x, y), middle = linear @ centre + origin, (angles[:-1] + angles[1:]) / 2
    painted = fill.between_stops(fill.sweep(middle), colours)
    return [
        f'<path fill="{_hex(colour)}" fill-opacity="{colour[3]:.3g}" '
        f'd="M{x:.1f} {-y:.1f}L{a:.1f} {-b:.1f} {c:.1f} {-d:.1f}Z"/>'
        for colour, (a, b), (c, d) in zip(painted, rim[:-1], rim[1:], strict=True)
    ]


def _hex(colour: Array) -> str:
    return "#" + "".join(f"{round(255 * min(max(part, 0), 1)):02x}" for part in colour[:3])
