"""A variable font: its axes, its instances and its glyphs as tensors."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property
from threading import RLock
from typing import TYPE_CHECKING, Any

import numpy as np
from fontTools.ttLib import TTFont

from ..arrays import Array, ArrayLike, IntArray, to_array
from ..errors import FontError, GlyphError
from ..files import write
from ..outline.coordinates import check_coordinates
from ..outline.glyph import Glyph
from ..outline.varying import Varying
from . import axes as axis_maths
from . import names
from .avar import read_displacement
from .axes import NamedInstance
from .cache import GlyphCache
from .colour import read_palettes
from .describe import Description, describe
from .design_space import DesignSpace
from .drawings import Drawings
from .font_metrics import read_metrics
from .instance import check_limits, instantiate, new_defaults, web_font
from .metrics import read_positioning_regions
from .reader import GlyphReader, layers_later
from .settings import Settings, read_conditions
from .shaping import ShapedRow, Shaper
from .shaping_options import ShapingOptions, check_options
from .source import FontSource, damage, font_bytes, open_font, opened

if TYPE_CHECKING:
    import torch

PROGRESS_SECONDS = 3
"""Time after which a walk over all glyphs shows a progress bar."""


def load_font(source: FontSource | Font, index: int = 0, static: bool = False) -> Font:
    """Load a variable font.

    Its outlines may be TrueType (glyf, GLYF) or PostScript (CFF2).

    Parameters
    ----------
    source : str, path, bytes, fontTools.ttLib.TTFont or Font
        A bundled name (see :func:`bundled_fonts`), a path, an ``http(s)`` URL, the bytes of a
        TTF, OTF, TTC, WOFF or WOFF2 file, or a font already open.
    index : int
        Which font of a collection, from 0. Default 0.
    static : bool
        Whether a font without axes is accepted, for example as the model that another font has
        to match. Default False.

    Returns
    -------
    Font

    Raises
    ------
    FontError
        The source is not a font, is truncated or oversized, is static (unless ``static`` is
        True), has no outlines or an unknown name, or the collection has no such index.

    Examples
    --------
    >>> import vfwidget as vf
    >>> font = vf.load_font("recursive")
    >>> [axis.tag for axis in font.axes]
    ['MONO', 'CASL', 'wght', 'slnt', 'CRSV']
    """
    if isinstance(source, Font):
        return source
    return Font(open_font(source, index), index, static)


def _load(data: bytes, index: int, static: bool, drawings: Drawings) -> Font:
    return load_font(data, index, static).with_glyphs(drawings)


class Font(DesignSpace):
    """A variable font; :func:`load_font` makes it.

    Attributes
    ----------
    family_name : str
    units_per_em : int
    ascender, descender : int
        Of ``hhea``, in font units.
    glyph_names : tuple of str
        In order of glyph id.
    palettes : tuple of palettes
        Each is a tuple of colours: red, green, blue and alpha from 0 to 1. Empty if the font has
        no colour glyphs.
    """

    def __init__(self, ttfont: TTFont, index: int = 0, static: bool = False) -> None:
        self._ttfont = opened(ttfont)
        self._index, self._static = index, static
        # fontTools reads a table when it is first asked for: in one thread at a time.
        self._reading = RLock()
        with damage("The font file is damaged or truncated"):
            self._read(ttfont, static)
        self._glyphs: GlyphCache[Glyph] = GlyphCache()
        self._drawings = Drawings()

    def _read(self, ttfont: TTFont, static: bool) -> None:
        # First, while the tables are as the file has them: fontTools would write anew those it has
        # read.
        self._shaper = Shaper(ttfont, self._reading)
        self.axes = axis_maths.read_axes(ttfont)
        self.instances = axis_maths.read_instances(ttfont)
        if not (self.axes or static):
            raise FontError(
                "This font is static: it has no variation axes (no fvar table). "
                "Load a variable font instead, or pass static=True."
            )
        self._displacement = read_displacement(ttfont, len(self.axes))
        self._reader = GlyphReader(ttfont, len(self.axes))
        self.family_name: str = names.family_name(ttfont)
        self.units_per_em: int = ttfont["head"].unitsPerEm
        if not 16 <= self.units_per_em <= 16384:
            raise FontError(
                f"The head table states {self.units_per_em} units per em; 16 to 16384 are allowed."
            )
        header = ttfont["HHEA" if "HHEA" in ttfont else "hhea"]
        self.ascender: int = header.ascent
        self.descender: int = header.descent
        self.glyph_names = tuple(ttfont.getGlyphOrder())
        with damage("The CPAL table is damaged"):
            self.palettes = read_palettes(ttfont)
        self._cmap: dict[int, str] = (ttfont.getBestCmap() if "cmap" in ttfont else None) or {}

    def __reduce__(self) -> tuple[Any, ...]:
        """A pickle holds the font file, from which glyphs are read again, and other drawings."""
        return _load, (font_bytes(self._ttfont), self._index, self._static, self._drawings)

    def __copy__(self) -> Font:
        return self

    def __deepcopy__(self, _memo: dict[int, Any]) -> Font:
        # A font never changes, so that one serves all texts, copied or not.
        return self

    def __repr__(self) -> str:
        return f"<Font {self.family_name!r}: {', '.join(axis.tag for axis in self.axes)}>"

    @cached_property
    def _metrics(self) -> dict[str, Varying]:
        with self._reading, damage("The tables of the font's metrics are damaged"):
            found = read_metrics(self._ttfont, len(self.axes))
        return {name: self.over_axes(metric) for name, metric in found.items()}

    def metrics(self, w: ArrayLike) -> dict[str, torch.Tensor]:
        """Metrics of the font at w in font units, each (...); autograd passes (MVAR).

        The names are ``ascender``, ``x_height``, ``underline_position`` and so on; those that the
        font does not state are left out. Ascender, descender and line gap are those of OS/2 if the
        font asks for it, else of hhea, as in HarfBuzz.

        Raises
        ------
        AxisError
            ``w`` has the wrong length or holds NaN.
        """
        w = check_coordinates(w, len(self.axes))
        return {name: metric.value(w) for name, metric in self._metrics.items()}

    def with_glyphs(self, glyphs: Mapping[Any, Glyph]) -> Font:
        """The font with other drawings of some glyphs, which a :class:`Text` then sets.

        Characters, kerning and anchors stay those of the file.

        Parameters
        ----------
        glyphs : mapping of character, glyph name or glyph id to Glyph
            Over the axes of this font; they may be made from arrays.

        Raises
        ------
        GlyphError
            The font has no such glyph, a drawing is no Glyph, or it has another number of axes.
        """
        drawings = self._drawings.and_these(glyphs, self.glyph, len(self.axes))
        twin = object.__new__(Font)
        twin.__dict__.update(self.__dict__, _drawings=drawings)
        # Layouts hold the advances of the former glyphs.
        twin.__dict__.pop("_layouts", None)
        return twin

    def instance(
        self,
        axes: Mapping[str, Any] | NamedInstance,
        name: str | None = None,
        string: str | None = None,
    ) -> Font:
        """A font of its own, with axes pinned or narrowed; :meth:`save` writes it to a file.

        fontTools rounds its outlines to whole units. In PostScript outlines it also joins lines
        that follow one another in one direction, so the instance may have fewer points.

        Parameters
        ----------
        axes : mapping of tag to number or range, or NamedInstance
            A number pins an axis; (least, greatest) or (least, default, greatest) narrows it. An
            axis that is not in the mapping stays as it is. User coordinates.
        name : str, optional
            Family name; by default the parent's, followed by the pinned values.
        string : str, optional
            Keep only the glyphs that this text may need. By default all.

        Raises
        ------
        AxisError
            The axis is unknown, or a value lies outside its range.
        FontError
            The name or string is not valid, fontTools fails, or glyphs are not those of the file.
        """
        self._drawings.check_none()
        if isinstance(axes, NamedInstance):
            axes = self._instance_axes(axes)
        limits = check_limits(self.axes, axes)
        w = to_array(self.final_coordinates(self.normalize(new_defaults(self.axes, limits))))
        source = open_font(font_bytes(self._ttfont), self._index)
        return load_font(instantiate(source, limits, w, name, string), static=True)

    def web_font(self, string: str, alternates: Mapping[str, Sequence[str]] | None = None) -> bytes:
        """A WOFF2 file with every axis, and only the glyphs that a text may need.

        Parameters
        ----------
        string : str
        alternates : mapping of glyph name to glyph names, optional
            The value k of the feature ``"vfwd"``, which the file then has in addition to those of
            the font, replaces a glyph by the k-th of its alternates.

        Raises
        ------
        FontError
            fontTools cannot make the file.
        """
        font = open_font(font_bytes(self._ttfont), self._index)
        return web_font(font, string, alternates or {})

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the font file as it was read, or as :meth:`instance` made it.

        Raises
        ------
        FontError, OSError, VFWidgetError
            Some glyphs are not those of the file, it cannot be written, or the path is not valid.
        """
        self._drawings.check_none()
        write(path, font_bytes(self._ttfont))

    def describe(self) -> Description:
        """What the file holds: axes, instances, tables read and tables left aside, as one table.

        It prints as text, and a notebook shows it as HTML.
        """
        with self._reading, damage("The font file is damaged"):
            return describe(self, self._ttfont)

    def axis_effect(self, key: str | int) -> dict[str, float]:
        """How far each axis by itself moves a glyph's outline, by tag, in font units.

        It is the greatest distance of any control point from its position at the default, while the
        axis runs through its range and the others stay at their defaults.
        """
        glyph, (lower, upper) = self.glyph(key), self.bounds
        effect: dict[str, float] = {}
        for i, axis in enumerate(self.axes):
            inner = glyph.outline.breakpoints[i]
            stops = [lower[i], upper[i], *inner[(inner > lower[i]) & (inner < upper[i])]]
            w = np.zeros((len(stops), len(self.axes)))
            w[:, i] = stops
            moved = glyph.outline.value(w) - glyph.outline.value(np.zeros(len(self.axes)))
            farthest = float(np.linalg.norm(moved, axis=-1).max(initial=0.0))
            effect[axis.tag] = max(farthest, effect.get(axis.tag, 0.0))
        return effect

    def glyph(self, key: str | int) -> Glyph:
        """A glyph as tensors, unpacked at the first call and then kept.

        The glyphs used least recently are forgotten when those that are kept exceed
        ``vfwidget.limits.glyph_cache_bytes``.

        Parameters
        ----------
        key : str or int
            A character, a glyph name or a glyph id.

        Raises
        ------
        GlyphError
            The font has no such glyph.
        FontError
            The glyph's data are damaged.
        """
        name = self._glyph_name(key)
        if name in self._drawings:
            return self._drawings[name]
        with self._reading:
            glyph = self._glyphs.get(name)
            if glyph is None:
                glyph = self._read_glyph(name)
                self._glyphs.add(name, glyph)
        return glyph

    def _read_glyph(self, name: str) -> Glyph:
        with damage(f"The data of glyph {name!r} are damaged"):
            glyph = self._reader.read(name)
            if self._reader.has_layers(name):
                glyph.read_layers = layers_later(self._reader, self._reading, name)
            return glyph.over(self._displacement) if self._displacement else glyph

    def __len__(self) -> int:
        """The number of glyphs."""
        return len(self.glyph_names)

    def __contains__(self, key: object) -> bool:
        """Whether the font has a glyph of this character, name or id."""
        return self._find(key) is not None

    def __iter__(self) -> Iterator[Glyph]:
        """All glyphs in order of glyph id, one at a time; none of them is kept.

        A bar shows the progress if it takes more than a few seconds.
        """
        from tqdm.auto import tqdm

        for name in tqdm(self.glyph_names, desc="glyphs", leave=False, delay=PROGRESS_SECONDS):
            with self._reading:
                glyph = self._drawings.get(name) or self._glyphs.get(name) or self._read_glyph(name)
            yield glyph

    def _glyph_name(self, key: str | int) -> str:
        name = self._find(key)
        if name is None:
            raise GlyphError(
                f"{self.family_name} has no glyph {key!r}: give a character, a glyph name "
                f"or a glyph id below {len(self)}."
            )
        return name

    def _find(self, key: object) -> str | None:
        if isinstance(key, str):
            if len(key) == 1 and ord(key) in self._cmap:
                return self._cmap[ord(key)]
            if key in self._ttfont.getReverseGlyphMap():
                return key
        elif isinstance(key, int | np.integer) and not isinstance(key, bool):
            if 0 <= key < len(self.glyph_names):
                return self.glyph_names[int(key)]
        return None

    @cached_property
    def positioning_support(self) -> Array:
        """Regions over which anchors and kerning may vary: start, peak and end, (m, n, 3)."""
        with self._reading, damage("The GDEF table is damaged"):
            return read_positioning_regions(self._ttfont, len(self.axes))

    @cached_property
    def _conditions(self) -> tuple[IntArray, IntArray]:
        with self._reading, damage("The GSUB or GPOS table is damaged"):
            return read_conditions(self._ttfont)

    def shaping_options(self, *options: Any, **named: Any) -> ShapingOptions:
        """Check features, language, script and direction; see :func:`check_options`."""
        return check_options(self._shaper.features, *options, **named)

    def shape_at(
        self,
        string: str,
        w: Array,
        options: ShapingOptions,
        advance: Callable[[int], float],
        **how: bool,
    ) -> ShapedRow:
        """The glyphs of a string at w (n,), with their positions; see :meth:`Shaper.shape`."""
        final = self._displacement.value(w) if self._displacement else w
        return self._shaper.shape(string, final, options, advance, **how)

    def settings(self, string: str, options: ShapingOptions) -> Settings:
        """The rows of glyphs that a string has over the design space; see :class:`Settings`.

        Where axes move others, the boxes are in :meth:`final_coordinates`.
        """
        n = len(self.axes)
        return Settings(
            self._conditions,
            (-np.ones(n), np.ones(n)) if self.moves_axes else self.bounds,
            lambda final: self._shaper.shape(string, final, options, lambda _: 0.0),
        )
