"""HarfBuzz as referee: outlines and advances at normalized coordinates."""

from __future__ import annotations

import io

import numpy as np
import torch
import uharfbuzz as hb
from fontTools.ttLib import TTFont

import vfwidget as vf

OUTLINE_TOLERANCE = 0.002
FLOAT32 = 2**-22
"""HarfBuzz holds outlines in float32: far from the origin its own grid is coarser than that."""
F2DOT14 = 16384
INVISIBLE = 0x7FFFFFF0
"""A glyph id that no font has."""


class HarfBuzz:
    """One font in HarfBuzz, set to whatever location is asked for."""

    def __init__(self, ttfont: TTFont) -> None:
        # HarfBuzz reads no WOFF2; untouched tables are copied as they are.
        ttfont.flavor, ttfont.recalcBBoxes = None, False
        sfnt = io.BytesIO()
        ttfont.save(sfnt)
        face = hb.Face(sfnt.getvalue())
        self.font = hb.Font(face)
        self.font.scale = (face.upem, face.upem)
        self._contours: list[list[np.ndarray]] = []
        self._draw = hb.DrawFuncs()
        self._draw.set_move_to_func(self._move)
        self._draw.set_line_to_func(self._line)
        self._draw.set_quadratic_to_func(self._quadratic)
        self._draw.set_cubic_to_func(self._cubic)
        self._draw.set_close_path_func(lambda _: None)

    def locate(self, w: np.ndarray) -> None:
        self.font.set_var_coords_normalized([float(x) for x in w])

    def advance(self, glyph_id: int) -> float:
        return self.font.get_glyph_h_advance(glyph_id)

    def glyph_ids(self, string: str) -> list[int]:
        """The glyphs of a string at the present location, without kerning."""
        buffer = hb.Buffer()
        buffer.add_str(string)
        buffer.flags = hb.BufferFlags.REMOVE_DEFAULT_IGNORABLES
        buffer.guess_segment_properties()
        hb.shape(self.font, buffer, {"kern": False})
        return [info.codepoint for info in buffer.glyph_infos]

    def contours(self, glyph_id: int) -> list[np.ndarray]:
        """Cubic segments (s, 4, 2) of each contour; a closing line of no length is left out."""
        self._contours = []
        self.font.draw_glyph(glyph_id, self._draw)
        return [np.array(c) if c else np.zeros((0, 4, 2)) for c in self._contours]

    def _move(self, x: float, y: float, _: object) -> None:
        self._here = (x, y)
        self._contours.append([])

    def _line(self, x: float, y: float, _: object) -> None:
        (a, b) = self._here
        inner = [((2 * a + x) / 3, (2 * b + y) / 3), ((a + 2 * x) / 3, (b + 2 * y) / 3)]
        self._contours[-1].append([self._here, *inner, (x, y)])
        self._here = (x, y)

    def _quadratic(self, cx: float, cy: float, x: float, y: float, _: object) -> None:
        (a, b) = self._here
        inner = [((a + 2 * cx) / 3, (b + 2 * cy) / 3), ((x + 2 * cx) / 3, (y + 2 * cy) / 3)]
        self._contours[-1].append([self._here, *inner, (x, y)])
        self._here = (x, y)

    def _cubic(self, *numbers: float) -> None:
        points = np.reshape(numbers[:6], (3, 2))
        self._contours[-1].append([self._here, *map(tuple, points)])
        self._here = tuple(points[-1])


def locations(font: vf.Font, count: int, rng: np.random.Generator) -> np.ndarray:
    """Random places on the F2Dot14 grid, which is all HarfBuzz can be told."""
    lower, upper = font.bounds
    n = len(font.axes)
    uniform = rng.uniform(lower, upper, (count, n))
    # A third of the coordinates go to where mistakes live: the ends and the default.
    special = rng.choice([-1.0, 0.0, 1.0], (count, n)).clip(lower, upper)
    mixed = np.where(rng.random((count, n)) < 1 / 3, special, uniform)
    fixed = np.stack([lower, upper, np.zeros(n)])
    return np.round(np.concatenate([fixed, mixed]) * F2DOT14) / F2DOT14


def outline_error(ours: list[np.ndarray], theirs: list[np.ndarray]) -> float:
    worst = 0.0
    # HarfBuzz may draw a contour of a single point, as a curve of no length.
    theirs = [contour for contour in theirs if len(contour) and np.ptp(contour, axis=(0, 1)).any()]
    assert len(ours) == len(theirs)
    for mine, other in zip(ours, theirs, strict=True):
        if len(other) == len(mine) - 1:
            # Our closing line has no length here, and HarfBuzz draws none.
            assert np.ptp(mine[-1], axis=0).max() < OUTLINE_TOLERANCE
            mine = mine[:-1]
        assert mine.shape == other.shape
        excess = np.abs(mine - other) - FLOAT32 * np.abs(other)
        worst = max(worst, float(excess.max()))
    return worst


def check(font: vf.Font, referee: HarfBuzz, name: str, places: np.ndarray) -> None:
    glyph = font.glyph(name)
    w = torch.tensor(places)
    contours = [contour.numpy() for contour in glyph.segments(w)]
    advances = glyph.advance(w).numpy()
    for index, place in enumerate(places):
        referee.locate(place)
        error = outline_error([c[index] for c in contours], referee.contours(glyph.glyph_id))
        assert error < OUTLINE_TOLERANCE, f"{name} at {place}: outline off by {error}"
        off = abs(advances[index] - referee.advance(glyph.glyph_id))
        assert off <= 0.5 + 1e-3, f"{name} at {place}: advance off by {off}"


class Typesetter:
    """HarfBuzz as a whole: glyphs and origins of a line at a location, with its default features.

    HarfBuzz rounds advance widths to font units. Here fontTools gives them unrounded. HarfBuzz also
    rounds the extents of outlines by which it places marks, unless ``exact_extents`` is set.
    """

    SCALE = 1024

    def __init__(self, ttfont: TTFont, exact_extents: bool = False) -> None:
        self._ttfont = ttfont
        # fontTools would read tables in another way once HarfBuzz's copy is written.
        self._axes = [axis.axisTag for axis in ttfont["fvar"].axes]
        self._plain = HarfBuzz(ttfont).font
        # HarfBuzz does not round the extents of slanted outlines; this slant moves none.
        self._plain.synthetic_slant = 1e-9 if exact_extents else 0.0
        self._font = hb.Font(self._plain)
        functions = hb.FontFuncs()
        functions.set_glyph_h_advance_func(lambda _f, glyph_id, _d: self._advance(glyph_id))
        self._font.funcs = functions

    def _advance(self, glyph_id: int) -> int:
        name = self._ttfont.getGlyphName(glyph_id)
        return round(self.SCALE * max(self._glyphs[name].width, 0))

    def line(
        self,
        string: str,
        w: np.ndarray,
        features: dict[str, bool] | None = None,
        rounded: bool = False,
    ) -> list[tuple[int, int, float, float, float]]:
        """Glyph id, cluster, x, y and advance of each glyph, as ``hb-shape`` has them."""
        location = dict(zip(self._axes, map(float, w), strict=True))
        self._glyphs = self._ttfont.getGlyphSet(location=location, normalized=True)
        upem = self._plain.face.upem
        for font in (self._plain, self._font):
            font.scale = (self.SCALE * upem, self.SCALE * upem)
            font.set_var_coords_normalized([float(x) for x in w])
        buffer = hb.Buffer()
        buffer.cluster_level = hb.BufferClusterLevel.MONOTONE_CHARACTERS
        buffer.add_str(string)
        # Hidden, as by default: a mark after a removed glyph would stand away from its letter.
        buffer.invisible_glyph = INVISIBLE
        buffer.guess_segment_properties()
        buffer.language = "und"
        hb.shape(self._plain if rounded else self._font, buffer, features or {})
        pen, found = 0, []
        for info, p in zip(buffer.glyph_infos, buffer.glyph_positions, strict=True):
            if info.codepoint == INVISIBLE:
                continue
            origin = (pen + p.x_offset) / self.SCALE, p.y_offset / self.SCALE
            found.append((info.codepoint, info.cluster, *origin, p.x_advance / self.SCALE))
            pen += p.x_advance
        return found
