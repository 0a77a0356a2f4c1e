"""TrueType outlines (glyf + gvar, GLYF + GVAR) unpacked into cubic control points and delta sets.

Everything between the file and a cubic outline is affine in the file's points: inferred deltas
(IUP), component transforms and offsets, implied on-curve points, quadratic to cubic. So each
glyph is carried as one array whose layers are the default outline and its delta sets, and each
step is applied to all layers at once.

OpenType, "glyf" (composite glyph description, phantom points) and "gvar" (inferred deltas).
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass
from typing import Any

import numpy as np
from fontTools.ttLib import TTFont
from fontTools.ttLib.tables import _g_l_y_f as glyf_flags

from ..arrays import Array, IntArray
from ..errors import FontError
from ..outline.variation import merge_regions, selection
from .cache import GlyphCache
from .gvar import GlyphVariations, check_size
from .unpacked import Unpacked, chain

PHANTOMS = 4
MAX_COMPONENT_DEPTH = 16
MAX_COMPONENTS = 1024
"""Of one glyph, nested ones counted each time; a few bytes could ask for billions."""
COMPONENTS_KEPT = 1 / 8
"""The share of the cache's memory for outlines that were components; others may have them, too."""
ON_CURVE, CUBIC = glyf_flags.flagOnCurve, glyf_flags.flagCubic


@dataclass(frozen=True)
class RawOutline:
    """A glyph's points as the file orders them, phantom points last.

    Attributes
    ----------
    points : (1 + m, k, 2) array
        Layer 0 is the default outline, layers 1… its delta sets.
    support : (m, n, 3) array
    flags : list of k - 4 ints
        ``ON_CURVE`` and ``CUBIC`` of each point.
    ends : tuple of int
        Index of the last point of each contour.
    """

    points: Array
    support: Array
    flags: list[int]
    ends: tuple[int, ...]

    @property
    def nbytes(self) -> int:
        """Memory of the arrays, in bytes."""
        return self.points.nbytes + self.support.nbytes


@dataclass
class _Reading:
    """One glyph being read, and the number of components met so far."""

    name: str
    components: int = 0


class GlyfReader:
    """The TrueType outlines of a font.

    Parameters
    ----------
    font : TTFont
    axis_count : int
    """

    def __init__(self, font: TTFont, axis_count: int) -> None:
        tag, gvar, hmtx, vmtx = (
            ("GLYF", "GVAR", "HMTX", "VMTX") if "GLYF" in font else ("glyf", "gvar", "hmtx", "vmtx")
        )
        self._font, self._glyf = font, font[tag]
        self._widths = font[hmtx].metrics
        self._heights = font[vmtx].metrics if vmtx in font else {}
        self._variations = GlyphVariations(font, gvar, axis_count)
        self._components: GlyphCache[RawOutline] = GlyphCache(COMPONENTS_KEPT)

    def read(self, name: str) -> Unpacked:
        """Unpack one glyph, its components included.

        Raises
        ------
        FontError
            Components nest without end, or are anchored to a point that is not there.
        """
        raw = self._read(name, _Reading(name), 0)
        points, contours = to_cubics(raw)
        left, right, top, bottom = raw.points[:, -PHANTOMS:].transpose(1, 0, 2)
        # Rasterisers put the left side bearing point at the origin, and so the outline's delta
        # sets carry that point's deltas too.
        points[..., 0] -= left[:, :1]
        return Unpacked(points, raw.support, contours, (right - left)[:, 0], (top - bottom)[:, 1])

    def _read(self, name: str, reading: _Reading, depth: int) -> RawOutline:
        if depth > MAX_COMPONENT_DEPTH:
            raise FontError(f"The components of glyph {reading.name!r} nest too deeply.")
        known = self._components.get(name)
        if known is None:
            glyph = self._glyph(name)
            if glyph.isComposite():
                # Not remembered on the way down, so that a cycle ends at the depth limit.
                return self._read_composite(name, glyph, reading, depth)
            known = self._read_simple(name, glyph)
            if depth:
                self._components.add(name, known)
        return known

    def _glyph(self, name: str) -> Any:
        """One glyph of the table; what it unpacks is not kept in the table."""
        glyph = copy(self._glyf.glyphs[name])
        # The flag of cubic points counts in GLYF only, for fontTools and HarfBuzz alike.
        glyph.expand(self._glyf)
        return glyph

    def _read_simple(self, name: str, glyph: Any) -> RawOutline:
        points, ends, flags = np.zeros((0, 2)), [], []
        if glyph.numberOfContours > 0:
            points = np.array(list(glyph.coordinates), dtype=np.float64)
            ends, flags = list(glyph.endPtsOfContours), list(glyph.flags)
        default = np.concatenate([points, self._phantom_points(name, glyph)])
        deltas, support = self._deltas(name, default, ends)
        return RawOutline(np.concatenate([default[None], deltas]), support, flags, tuple(ends))

    def _deltas(self, name: str, default: Array, ends: list[int]) -> tuple[Array, Array]:
        return self._variations.read(name, self._font.getGlyphID(name), default, ends)

    def _phantom_points(self, name: str, glyph: Any) -> Array:
        """Left and right side bearing points, then top and bottom ones."""
        advance, bearing = self._widths[name]
        left = getattr(glyph, "xMin", 0) - bearing
        height, bearing = self._heights.get(name, (0, 0))
        top = getattr(glyph, "yMax", 0) + bearing
        return np.array([[left, 0], [left + advance, 0], [0, top], [0, top - height]], dtype=float)

    def _read_composite(self, name: str, glyph: Any, reading: _Reading, depth: int) -> RawOutline:
        """Place each component; a composite's own deltas move the components' offsets."""
        components = glyph.components
        reading.components += len(components)
        if reading.components > MAX_COMPONENTS:
            raise FontError(
                f"The components of glyph {reading.name!r} are too many: the limit is "
                f"{MAX_COMPONENTS}, nested ones counted each time."
            )
        # In gvar a composite has one "point" for each component, its offset, then the phantoms.
        offsets = [[getattr(c, "x", 0), getattr(c, "y", 0)] for c in components]
        default = np.concatenate([np.reshape(offsets, (-1, 2)), self._phantom_points(name, glyph)])
        deltas, own_support = self._deltas(name, default, list(range(len(components))))
        children = [self._read(c.glyphName, reading, depth + 1) for c in components]
        support, indices = merge_regions([own_support, *(child.support for child in children)])
        check_size(reading.name, sum(child.points.shape[1] for child in children), len(support))
        own = _spread(np.concatenate([default[None], deltas]), indices[0], len(support))
        phantoms = own[:, -PHANTOMS:]
        placed: list[Array] = []
        flags: list[int] = []
        ends: list[int] = []
        for number, (component, child) in enumerate(zip(components, children, strict=True)):
            layers = _spread(child.points, indices[1 + number], len(support))
            if component.flags & glyf_flags.USE_MY_METRICS:
                phantoms = layers[:, -PHANTOMS:]
            placed.append(_place(component, layers[:, :-PHANTOMS], own[:, number], placed, name))
            ends += [len(flags) + end for end in child.ends]
            flags += child.flags
        return RawOutline(np.concatenate([*placed, phantoms], axis=1), support, flags, tuple(ends))


def _spread(layers: Array, where: IntArray, count: int) -> Array:
    """Lay layers out over ``count`` merged regions; repeated regions add up."""
    deltas = np.tensordot(selection(where, count).T, layers[1:], 1)
    return np.concatenate([layers[:1], deltas])


def _place(component: Any, layers: Array, offset: Array, placed: list[Array], name: str) -> Array:
    """Scale and shift a component's layers; deltas scale and shift just as points do."""
    matrix = np.array(getattr(component, "transform", ((1.0, 0.0), (0.0, 1.0))))
    flags = component.flags
    if hasattr(component, "firstPt"):
        layers = layers @ matrix
        try:
            before = np.concatenate(placed, axis=1)
            offset = before[:, component.firstPt] - layers[:, component.secondPt]
        except (IndexError, ValueError):
            raise FontError(f"A component of {name!r} is anchored to a missing point.") from None
        return layers + offset[:, None]
    both = glyf_flags.SCALED_COMPONENT_OFFSET | glyf_flags.UNSCALED_COMPONENT_OFFSET
    if flags & both == glyf_flags.SCALED_COMPONENT_OFFSET:
        offset = offset @ matrix
    return layers @ matrix + offset[:, None]


def to_cubics(raw: RawOutline) -> tuple[Array, list[int]]:
    """Rewrite the contours as closed chains of cubic segments.

    Returns
    -------
    layers : (1 + m, 3 s, 2) array
        Control points; a contour of s segments has 3 s of them, its end being its start.
    contours : list of int
        s of each contour. Contours of a single point (anchors) are dropped.
    """
    trace = _Trace(raw.flags)
    contours = []
    start = 0
    for end in raw.ends:
        if end > start:
            before = len(trace.segments)
            trace.contour(start, end)
            contours.append(len(trace.segments) - before)
        start = end + 1
    points = raw.points[:, :-PHANTOMS]
    if trace.implied:
        one, other = np.array(trace.implied).T
        points = np.concatenate([points, (points[:, one] + points[:, other]) / 2], axis=1)
    return chain(points, trace.segments), contours


class _Trace:
    """Follows contours point by point, in indices only.

    Attributes
    ----------
    segments : list of (start, first control, second control, end, order)
        Indices of points, implied points after those of the file; see :func:`.unpacked.chain`.
    implied : list of (int, int)
        The points that each implied on-curve point lies midway between.
    """

    def __init__(self, flags: list[int]) -> None:
        self._flags = flags
        self.segments: list[tuple[int, int, int, int, int]] = []
        self.implied: list[tuple[int, int]] = []

    def contour(self, first: int, last: int) -> None:
        """Follow one closed contour."""
        flags, ring = self._flags, list(range(first, last + 1))
        # It starts on its first point, else on its last, else midway between them. A curve of
        # order 3 may begin in the middle of its controls, so there the first point on it is taken.
        if flags[first] & ON_CURVE:
            here, rest = first, [*ring[1:], first]
        elif flags[last] & ON_CURVE:
            here, rest = last, ring
        else:
            on = [i for i in ring if flags[i] & ON_CURVE and flags[first] & CUBIC]
            here = on[0] if on else self._between(last, first)
            cut = here + 1 - first if on else 0
            rest = [*ring[cut:], *ring[:cut]] if on else [*ring, here]
        controls: list[int] = []
        for i in rest:
            if i < len(flags) and not flags[i] & ON_CURVE:
                if controls and len(controls) == (2 if flags[controls[0]] & CUBIC else 1):
                    here = self._segment(here, controls, self._between(controls[-1], i))
                    controls = []
                controls.append(i)
            else:
                here = self._segment(here, controls, i)
                controls = []

    def _between(self, one: int, other: int) -> int:
        self.implied.append((one, other))
        return len(self._flags) + len(self.implied) - 1

    def _segment(self, here: int, controls: list[int], end: int) -> int:
        if not controls:
            self.segments.append((here, end, here, end, 1))
        elif len(controls) == 2:
            self.segments.append((here, controls[0], controls[1], end, 3))
        elif self._flags[controls[0]] & CUBIC:
            raise FontError("A cubic curve of the glyf table has one control point; it needs two.")
        else:
            self.segments.append((here, controls[0], controls[0], end, 2))
        return end
