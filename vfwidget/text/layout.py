r"""Where the letters of a line stand, as a function of the axes.

HarfBuzz places glyphs one after the other by their advance widths, and moves them by kerning,
anchors and cursive joins. Within one setting each origin is

    origin_i(w) = Σ_j pushed_ij · advance_j(w) x̂ + base_i + deltas_i · γ(w),

where the advances are those of the glyphs themselves, and γ are the scalars of the regions over
which the font varies its positioning (the item variation store of GDEF). Without kerning and
anchors only the first sum is left: the paper's Eq. 3.

No lookup table is read. HarfBuzz shapes the text with all advances 0 at as many locations as
there are independent scalars, which gives ``base`` and ``deltas`` by least squares. It shapes the
text with all advances 1 for ``pushed``. Then the positions are compared with HarfBuzz at further
locations with the true advances, so that text which this form does not describe is recognised.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from typing import NamedTuple

import numpy as np

from ..arrays import Array, BoolArray, IntArray, to_array
from ..errors import TextError
from ..font import Font
from ..font.settings import Settings
from ..font.shaping import SCALE, ShapedRow
from ..font.shaping_options import ShapingOptions
from ..limits import limits
from ..outline.glyph import Glyph
from ..outline.variation import Regions, merge_regions
from .locations import final, locations_in
from .memo import Memo

TOLERANCE = 1e-5
"""Greatest difference from HarfBuzz in ems, for each number of each glyph."""
BY_EXTENTS = 5e-4
"""The same where marks are placed by the extents of outlines, because at some locations another
point may be the extreme one."""
BY_ROUNDED_EXTENTS = 1e-3
"""The same against HarfBuzz by itself, which rounds these extents to font units. That moves a mark
by up to one unit, and each further mark of a stack by up to one again."""
WITHOUT_ANCHORS = (
    "The font has no anchors for this mark, so HarfBuzz places it by the extents of outlines. "
    "Write the letter with its mark as one character, remove the mark, or use a font with anchors."
)
REMEDY = (
    "Remove the combining marks, and spaces of the width of another character, or switch off "
    "features."
)
"""What to do about glyphs that cannot be placed."""
INDEPENDENT = 1e-6
"""A row of scalars that differs from all combinations of others by less adds nothing to them."""

WHOLE = 0.05
"""Coefficients that are this close to whole numbers are taken for them."""


@dataclass(frozen=True)
class Layout:
    """Origins of l glyphs, and the ends of their lines, as functions of the axes.

    The rows of the arrays are the l glyphs in drawing order, then one end for each line. Font
    units, y up; the first line starts at (0, 0).

    Attributes
    ----------
    row : ShapedRow
        The glyphs.
    pushed : (l + lines, l) array
        How much of each glyph's advance width lies before each origin, 0 … 1.
    base : (l + lines, 2) array
    deltas : (l + lines, 2, m) array
        Displacement by kerning and anchors.
    support : (m, n, 3) array
        The regions of the deltas.
    anchor : (l + lines,) int array
        For each row, the glyph next to which it is placed: for a mark its base, for another glyph
        the one before it; -1 at the start of a line.
    gaps : (l + lines,) int array
        How many graphemes stand before that of each row on its line. Tracking adds space after
        each of them.
    own : (l,) array
        How much of each glyph's advance width counts in its advance: 0 for a mark, else 1.
    is_mark : (l,) bool array
        Which glyphs have no advance and stand at a letter.
    ends_grapheme : (l,) bool array
        Which glyphs have the space of tracking after them.
    advance_base, advance_deltas : (l,) and (l, m) arrays
        What kerning adds to the advance of each glyph.
    """

    row: ShapedRow
    pushed: Array = field(repr=False)
    base: Array = field(repr=False)
    deltas: Array = field(repr=False)
    support: Array = field(repr=False)
    anchor: IntArray = field(repr=False)
    gaps: IntArray = field(repr=False)
    own: Array = field(repr=False)
    is_mark: BoolArray = field(repr=False)
    ends_grapheme: BoolArray = field(repr=False)
    advance_base: Array = field(repr=False)
    advance_deltas: Array = field(repr=False)


class PlacedGlyph(NamedTuple):
    """A glyph of a text with its position, as ``hb-shape`` prints it, but unrounded.

    Attributes
    ----------
    glyph_id : int
    glyph : Glyph
    cluster : int
        Index in the string of the first character that the glyph stands for.
    x, y : float
        Origin of the glyph, in font units.
    advance : float
        Distance to the pen position of the next glyph, in font units.
    """

    glyph_id: int
    glyph: Glyph
    cluster: int
    x: float
    y: float
    advance: float


class Layouts:
    """The layouts of a string, one for each setting; each is fitted when it is first used.

    Attributes
    ----------
    settings : Settings
    """

    def __init__(self, font: Font, string: str, options: ShapingOptions) -> None:
        self.settings: Settings = font.settings(string, options)
        self._string, self._options = string, options
        self._fitted: dict[int, Layout] = {}

    def of(self, font: Font, row: int) -> Layout:
        """The layout of one of the rows of ``settings``.

        Raises
        ------
        TextError
            See :func:`fit_layout`.
        """
        if row not in self._fitted:
            self._fitted[row] = fit_layout(font, self._string, self._options, self.settings, row)
        return self._fitted[row]


def layouts(font: Font, string: str, options: ShapingOptions) -> Layouts:
    """The layouts of a string, which are kept as long as the font.

    Raises
    ------
    TextError
        ``string`` is no string, or too long.
    """
    if not isinstance(string, str):
        raise TextError(f"A text must be a string; received {type(string).__name__}.")
    if len(string) > limits.text_characters:
        raise TextError(
            f"The text has {len(string):,} characters; the limit is {limits.text_characters:,}. "
            "Make several texts, or raise vf.limits.text_characters."
        )
    # An attribute of the font: a dictionary of its own would keep the font alive by the layouts.
    memo: Memo[Layouts] = vars(font).setdefault("_layouts", Memo())
    return memo.get((string, options), lambda: Layouts(font, string, options))


def fit_layout(
    font: Font, string: str, options: ShapingOptions, settings: Settings, index: int
) -> Layout:
    """The layout of a text in one setting.

    Parameters
    ----------
    settings : Settings
    index : int
        The index of the setting's row in ``settings.rows``.

    Raises
    ------
    TextError
        HarfBuzz places the glyphs in another way than the font's variation data say.
    """
    rng = np.random.default_rng(0)
    row = settings.rows[index]
    support = _positioning_support(font, row)
    locations, fresh = locations_in(font, settings, index, support, rng)
    scalars = np.insert(Regions(support).scalars(final(font, locations)), 0, 1.0, axis=1)
    # Where other points become the extreme ones, the error is spread over all locations.
    chosen = np.arange(len(locations)) if row.by_extents else _independent_rows(scalars)

    def shape(w: Array, advance: Callable[[int], float], rounded: bool = False) -> Array:
        shaped = font.shape_at(string, w, options, advance, rounded=rounded)
        if shaped != row:
            raise TextError(
                f"HarfBuzz chooses other glyphs for {string!r} at the normalized coordinates "
                f"{w.tolist()} for a reason that the font's condition sets do not state, and "
                "vfwidget cannot lay out such text. Remove the characters that cause it."
            )
        return shaped.positions

    apart = np.array([shape(w, lambda _: 0.0) for w in locations[chosen]])
    fitted = _fit(scalars[chosen], apart.reshape(len(chosen), -1)).reshape(-1, *apart.shape[1:])
    response = shape(locations[chosen[0]], lambda _: 1.0) - apart[0]
    w = locations[chosen[0]]
    # A feature over a part of a grapheme sets other glyphs here, but graphemes start where they do.
    starts = np.unique(font.shape_at(string, w, options, lambda _: 0.0, by_grapheme=True).clusters)
    graphemes = starts[np.searchsorted(starts[1:], row.clusters, side="right")]
    layout = _assemble(row, graphemes, fitted, response, support)
    gammas = Regions(layout.support).scalars(final(font, fresh))
    widths = _widths(font, fresh)
    tolerances = [(False, TOLERANCE)]
    if row.by_extents:
        tolerances = [(False, BY_EXTENTS), (True, BY_ROUNDED_EXTENTS)]

    def at(i: int) -> Callable[[int], float]:
        return lambda g: float(widths(g)[i])

    for i, w in enumerate(fresh):
        found = layout.base + layout.deltas @ gammas[i]
        found[:, 0] += layout.pushed @ np.array([widths(g)[i] for g in row.glyph_ids])
        for rounded, tolerance in tolerances:
            off = np.abs(found - _origins(row, shape(w, at(i), rounded))).max(1)
            if off.max() > tolerance * font.units_per_em + len(off) / (2 * SCALE):
                worst = min(int(off.argmax()), len(row.glyph_ids) - 1)
                raise TextError(
                    f"HarfBuzz places the glyph {font.glyph_names[row.glyph_ids[worst]]!r} of "
                    f"{string!r} (character {row.clusters[worst]}) in a way that the font's "
                    f"variation data do not state, {off.max():.3g} font units away at the "
                    f"normalized coordinates {w.tolist()}, and vfwidget cannot lay out such text. "
                    + (WITHOUT_ANCHORS if row.by_extents else REMEDY)
                )
    return layout


def _widths(font: Font, locations: Array) -> Callable[[int], Array]:
    """The advance widths of a glyph at locations (c, n), (c,), by glyph id."""
    return cache(lambda g: to_array(font.glyph(g).advance_width.value(locations)).clip(0.0, None))


def _assemble(
    row: ShapedRow, graphemes: IntArray, fitted: Array, response: Array, support: Array
) -> Layout:
    """A layout from the numbers of each glyph.

    Parameters
    ----------
    graphemes : (l,) int array
        The grapheme of each glyph, by its first character.
    fitted : (1 + m, l, 3) array
        Constant and deltas of advance, x offset and y offset where all advance widths are 0.
    response : (l, 3) array
        What is added to them where all advance widths are 1.
    """
    origins = np.array([_origins(row, numbers) for numbers in fitted])
    used = np.abs(origins[1:]).any((1, 2))
    is_mark = ~(np.abs(fitted[..., 0]).any(0) | (response[:, 0] != 0))
    lines = lines_of(row)
    reach, own = _origins(row, response)[:, 0], response[:, 0]
    before = _origins(row, own[:, None] * [1.0, 0.0, 0.0])[: len(own), 0]
    same_line = lines[:, None] == np.array(row.lines)
    # The widths that lie before an origin are those of the first glyphs of its line.
    pushed = np.where(same_line, (reach[:, None] - before).clip(0, own), 0.0)
    # Without GPOS, HarfBuzz draws a mark that has no base ahead of the pen, by its own width.
    np.fill_diagonal(pushed, pushed.diagonal() + reach[: len(own)].clip(None, 0.0))
    anchor, gaps, ends_grapheme = _neighbours(row, graphemes, is_mark)
    return Layout(
        row,
        pushed=pushed,
        base=origins[0],
        deltas=np.moveaxis(origins[1:][used], 0, -1),
        support=support[used],
        anchor=anchor,
        gaps=gaps,
        own=own,
        is_mark=is_mark,
        ends_grapheme=ends_grapheme,
        advance_base=fitted[0, :, 0],
        advance_deltas=fitted[1:][used, :, 0].T,
    )


def lines_of(row: ShapedRow) -> IntArray:
    """The line of each glyph, then of each end of a line, (l + lines,)."""
    return np.array([*row.lines, *range(max(row.lines) + 1)])


def _origins(row: ShapedRow, numbers: Array) -> Array:
    """Origins of the glyphs and ends of the lines, (l + lines, 2), from the numbers (l, 3)."""
    lines, glyph_lines = lines_of(row), np.array(row.lines)
    origins = np.zeros((len(lines), 2))
    origins[: len(numbers)] = numbers[:, 1:]
    for line in range(len(lines) - len(numbers)):
        pens = np.append(0.0, numbers[glyph_lines == line, 0].cumsum())
        origins[lines == line, 0] += pens
    return origins


def _neighbours(
    row: ShapedRow, graphemes: IntArray, is_mark: BoolArray
) -> tuple[IntArray, IntArray, BoolArray]:
    """``Layout.anchor``, ``Layout.gaps`` and ``Layout.ends_grapheme``."""
    lines, count = lines_of(row), len(row.lines)
    anchor, gaps = np.full(len(lines), -1), np.zeros(len(lines), dtype=np.intp)
    ends_grapheme = np.zeros(count, dtype=bool)
    marks, rtl = np.zeros((2, len(lines)), dtype=bool)
    marks[:count], rtl[:count] = is_mark, row.rtl
    for line in range(len(lines) - count):
        own = np.flatnonzero(lines == line)
        bases = own[~marks[own]][:-1]  # without the end of the line
        before, after = (np.searchsorted(bases, own, side) for side in ("left", "right"))
        nearest = np.where(marks[own] & rtl[own], after, before - 1)
        exists = (nearest >= 0) & (nearest < len(bases))
        anchor[own[exists]] = bases[nearest[exists]]
        begins = np.diff(graphemes[bases], prepend=-1) != 0
        ends_grapheme[bases] = np.append(begins, True)[1:]
        # A mark belongs to the grapheme of its base.
        holder = np.where(exists & marks[own], anchor[own], own)
        numbers = np.append(begins.cumsum() - 1, begins.sum())
        gaps[own] = numbers[np.searchsorted(bases, holder)]
    return anchor, gaps, ends_grapheme


def _positioning_support(font: Font, row: ShapedRow) -> Array:
    """The regions over which the displacements of glyphs may vary, (m, n, 3)."""
    if not row.by_extents:
        return font.positioning_support
    # HarfBuzz places marks by the extents of the outlines, which vary as the control points do.
    glyphs = [font.glyph(glyph_id) for glyph_id in row.glyph_ids]
    outlines = [g.affine.support for g in glyphs if g.is_affine]
    return merge_regions([font.positioning_support, *outlines])[0]


def _independent_rows(matrix: Array) -> IntArray:
    """Rows of a matrix, as few and as different as possible, that all others depend on."""
    rest, chosen = matrix.copy(), []
    for _ in range(matrix.shape[1]):
        lengths = np.linalg.norm(rest, axis=1)
        longest = int(lengths.argmax())
        if lengths[longest] <= INDEPENDENT:
            break
        chosen.append(longest)
        direction = rest[longest] / lengths[longest]
        rest -= np.outer(rest @ direction, direction)
    return np.array(chosen)


def _fit(scalars: Array, values: Array) -> Array:
    """Coefficients of values that are affine in the scalars."""
    found = np.asarray(np.linalg.lstsq(scalars, values, rcond=None)[0], dtype=np.float64)
    # Fonts hold whole numbers, which show unless some scalars depend on one another here.
    whole = np.round(found)
    return whole if np.abs(found - whole).max() < WHOLE else found
