"""TrueType outlines (glyf + gvar) unpacked into cubic control points and dense delta sets.

Everything between the file and a cubic outline is affine in the file's points: inferred deltas
(IUP), component transforms and offsets, implied on-curve points, quadratic to cubic. So each
glyph is carried as one array whose layers are the default outline and its delta sets, and each
step is applied to all layers at once.

OpenType, "glyf" (composite glyph description, phantom points) and "gvar" (inferred deltas).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count
from typing import Any

import numpy as np
from fontTools.ttLib import TTFont
from fontTools.ttLib.tables import _g_l_y_f as glyf_flags
from fontTools.varLib.iup import iup_delta

from ..arrays import Array, BoolArray, IntArray
from ..errors import FontError
from ..outline.variation import merge_regions, selection
from .axes import axis_keys

PHANTOMS = 4
MAX_COMPONENT_DEPTH = 16
MAX_COMPONENTS = 1024
"""Of one glyph, nested ones counted each time; a few bytes could ask for billions."""


@dataclass(frozen=True)
class RawOutline:
    """A glyph's points as the file orders them, phantom points last.

    Attributes
    ----------
    points : (1 + m, k, 2) array
        Layer 0 is the default outline, layers 1… its delta sets.
    support : (m, n, 3) array
    on_curve : (k - 4,) bool array
    ends : tuple of int
        Index of the last point of each contour.
    """

    points: Array
    support: Array
    on_curve: BoolArray
    ends: tuple[int, ...]


def read_outline(
    font: TTFont, name: str, depth: int = 0, counter: Iterator[int] | None = None
) -> RawOutline:
    """Unpack one glyph, its components included.

    Raises
    ------
    FontError
        Components nest without end, or are anchored to a point that is not there.
    """
    counter = counter or count()
    if depth > MAX_COMPONENT_DEPTH or next(counter) > MAX_COMPONENTS:
        raise FontError(f"The components of glyph {name!r} nest too deeply or are too many.")
    glyph = font["glyf"][name]
    if glyph.isComposite():
        return _read_composite(font, name, depth, counter)
    if glyph.numberOfContours > 0:
        coordinates, ends, flags = glyph.getCoordinates(font["glyf"])
        points = np.array(coordinates, dtype=np.float64)
        on_curve = np.array([bool(flag & glyf_flags.flagOnCurve) for flag in flags])
    else:
        points, ends, on_curve = np.zeros((0, 2)), [], np.zeros(0, dtype=bool)
    default = np.concatenate([points, _phantom_points(font, name)])
    deltas, support = _read_deltas(font, name, default, list(ends))
    layers = np.concatenate([default[None], deltas])
    return RawOutline(layers, support, on_curve, tuple(int(end) for end in ends))


def _phantom_points(font: TTFont, name: str) -> Array:
    """Left and right side bearing points, then the two vertical ones, which go unused here."""
    advance, bearing = font["hmtx"][name]
    left = getattr(font["glyf"][name], "xMin", 0) - bearing
    return np.array([[left, 0], [left + advance, 0], [0, 0], [0, 0]], dtype=np.float64)


def _read_deltas(font: TTFont, name: str, default: Array, ends: list[int]) -> tuple[Array, Array]:
    """The delta sets of one glyph, (m, k, 2), left-out deltas inferred, and their support."""
    keys = axis_keys(font)
    variations = font["gvar"].variations.get(name, []) if "gvar" in font else []
    deltas = np.zeros((len(variations), *default.shape))
    support = np.zeros((len(variations), len(keys), 3))
    for j, variation in enumerate(variations):
        support[j] = [variation.axes.get(key, (0, 0, 0)) for key in keys]
        if None in variation.coordinates:
            # Each phantom point counts as a contour of its own: nothing is inferred for it.
            deltas[j] = iup_delta(variation.coordinates, default.tolist(), ends)
        else:
            deltas[j] = variation.coordinates
    return deltas, support


def _read_composite(font: TTFont, name: str, depth: int, counter: Iterator[int]) -> RawOutline:
    """Place each component; a composite's own deltas move the components' offsets."""
    components = font["glyf"][name].components
    # In gvar a composite has one "point" for each component, its offset, then the phantoms.
    offsets = [[getattr(c, "x", 0), getattr(c, "y", 0)] for c in components]
    default = np.concatenate([np.reshape(offsets, (-1, 2)), _phantom_points(font, name)])
    deltas, own_support = _read_deltas(font, name, default, list(range(len(components))))
    children = [read_outline(font, c.glyphName, depth + 1, counter) for c in components]
    support, indices = merge_regions([own_support, *(child.support for child in children)])

    def spread(default_and_deltas: Array, where: IntArray) -> Array:
        """Lay layers out over the merged regions; repeated regions add up."""
        deltas = np.tensordot(selection(where, len(support)).T, default_and_deltas[1:], 1)
        return np.concatenate([default_and_deltas[:1], deltas])

    own = spread(np.concatenate([default[None], deltas]), indices[0])
    phantoms = own[:, -PHANTOMS:]
    placed = np.zeros((1 + len(support), 0, 2))
    on_curve: list[BoolArray] = []
    ends: list[int] = []
    for number, (component, child) in enumerate(zip(components, children, strict=True)):
        layers = spread(child.points, indices[1 + number])
        if component.flags & glyf_flags.USE_MY_METRICS:
            phantoms = layers[:, -PHANTOMS:]
        moved = _place(component, layers[:, :-PHANTOMS], own[:, number], placed, name)
        ends += [placed.shape[1] + end for end in child.ends]
        placed = np.concatenate([placed, moved], axis=1)
        on_curve.append(child.on_curve)
    return RawOutline(
        np.concatenate([placed, phantoms], axis=1), support, np.concatenate(on_curve), tuple(ends)
    )


def _place(component: Any, layers: Array, offset: Array, placed: Array, name: str) -> Array:
    """Scale and shift a component's layers; deltas scale and shift just as points do."""
    matrix = np.array(getattr(component, "transform", ((1.0, 0.0), (0.0, 1.0))))
    flags = component.flags
    if hasattr(component, "firstPt"):
        layers = layers @ matrix
        try:
            offset = placed[:, component.firstPt] - layers[:, component.secondPt]
        except IndexError:
            raise FontError(f"A component of {name!r} is anchored to a missing point.") from None
        return layers + offset[:, None]
    both = glyf_flags.SCALED_COMPONENT_OFFSET | glyf_flags.UNSCALED_COMPONENT_OFFSET
    if flags & both == glyf_flags.SCALED_COMPONENT_OFFSET:
        offset = offset @ matrix
    return layers @ matrix + offset[:, None]


def to_cubics(raw: RawOutline) -> tuple[Array, tuple[int, ...]]:
    """Rewrite the contours as closed chains of cubic segments.

    Returns
    -------
    layers : (1 + m, k, 2) array
        Control points; a contour of s segments has 3 s of them, its end being its start.
    contours : tuple of int
        s of each contour. Contours of a single point (anchors) are dropped.
    """
    layers, contours = [], []
    start = 0
    for end in raw.ends:
        on_curve = raw.on_curve[start : end + 1]
        if len(on_curve) > 1:
            points = np.moveaxis(raw.points[:, start : end + 1], 0, 1)
            cubics = _cubics(points, on_curve)
            layers.append(np.moveaxis(cubics, 0, 1))
            contours.append(len(cubics) // 3)
        start = end + 1
    if not layers:
        return np.zeros((len(raw.points), 0, 2)), ()
    return np.concatenate(layers, axis=1), tuple(contours)


def _cubics(points: Array, on_curve: BoolArray) -> Array:
    """A quadratic contour's k points, (k, 1 + m, 2), as cubic control points, (3 s, 1 + m, 2)."""
    k = len(points)
    # The contour starts on its first point, else on its last, else midway between them.
    if on_curve[0]:
        order = range(1, k + 1)
        start = points[0]
    elif on_curve[-1]:
        order = range(k)
        start = points[-1]
    else:
        order = range(k + 1)
        start = (points[0] + points[-1]) / 2
    rows: list[Array] = []
    here, control = start, None

    def segment(end: Array) -> None:
        # A line's control points lie at its thirds, so that t is even along it; raising a
        # quadratic's degree puts them two thirds of the way to its off-curve point.
        inner = [(2 * here + end) / 3, (here + 2 * end) / 3]
        if control is not None:
            inner = [(here + 2 * control) / 3, (2 * control + end) / 3]
        rows.extend([here, *inner])

    last = len(order) - 1
    for step, index in enumerate(order):
        point = start if step == last else points[index % k]
        if step == last or on_curve[index % k]:
            segment(point)
            here, control = point, None
        else:
            if control is not None:
                middle = (control + point) / 2
                segment(middle)
                here = middle
            control = point
    return np.array(rows)
