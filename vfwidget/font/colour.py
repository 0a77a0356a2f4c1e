"""The layers of colour glyphs and the palettes (COLR versions 0 and 1, CPAL).

OpenType, "COLR" and "CPAL" tables.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from fontTools.ttLib import TTFont
from fontTools.ttLib.tables.otTables import CompositeMode, ExtendMode, PaintFormat

from ..arrays import Array
from ..errors import FontError, FontWarning, warn_caller
from ..outline.glyph import Glyph, Layer
from ..outline.paint import LINEAR, RADIAL, SOLID, SWEEP, Colour, Paint
from ..outline.placed import Transformation, place
from ..outline.variation import merge_regions
from ..outline.varying import Affine, Varying, constant, one_after_another
from .clip import cuts
from .varstore import NO_VARIATION, VariationStore

FOREGROUND = 0xFFFF
"""The palette entry that stands for the colour of the text."""
MAX_DEPTH = 64
"""Paints inside one another; the deepest known have about ten, and a cycle has no end."""
MAX_PAINTS = 4096
"""Of one glyph, counted each time one is used; a few bytes could ask for billions."""
F2DOT14, FIXED = 1 / 16384, 1 / 65536
HALF_TURN = 180 * F2DOT14
"""Angles are stored in units of 180/16384 degrees."""
RADIANS = np.pi / 180
X_Y, X_Y_CENTER = ("dx", "dy"), ("centerX", "centerY")
GRADIENTS = {
    PaintFormat.PaintLinearGradient: (LINEAR, ("x0", "y0", "x1", "y1", "x2", "y2")),
    PaintFormat.PaintRadialGradient: (RADIAL, ("x0", "y0", "r0", "x1", "y1", "r1")),
    PaintFormat.PaintSweepGradient: (SWEEP, (*X_Y_CENTER, "startAngle", "endAngle")),
}
"""The kind of each gradient, and the fields that state where it lies, in the order of the file."""
TRANSFORMATIONS: dict[PaintFormat, tuple[tuple[str, ...], tuple[int, ...]]] = {
    PaintFormat.PaintTranslate: (X_Y, (0, 1)),
    PaintFormat.PaintScale: (("scaleX", "scaleY"), (3, 4)),
    PaintFormat.PaintScaleAroundCenter: (("scaleX", "scaleY", *X_Y_CENTER), (3, 4, 7, 8)),
    PaintFormat.PaintScaleUniform: (("scale",), (3,)),
    PaintFormat.PaintScaleUniformAroundCenter: (("scale", *X_Y_CENTER), (3, 7, 8)),
    PaintFormat.PaintRotate: (("angle",), (2,)),
    PaintFormat.PaintRotateAroundCenter: (("angle", *X_Y_CENTER), (2, 7, 8)),
    PaintFormat.PaintSkew: (("xSkewAngle", "ySkewAngle"), (5, 6)),
    PaintFormat.PaintSkewAroundCenter: (("xSkewAngle", "ySkewAngle", *X_Y_CENTER), (5, 6, 7, 8)),
}
"""The fields of each transformation, and which parameters of :class:`.placed.Transformation`."""
UNITS = {
    **dict.fromkeys(("scaleX", "scaleY", "scale", "Alpha", "StopOffset"), F2DOT14),
    **dict.fromkeys(("startAngle", "endAngle", "angle", "xSkewAngle", "ySkewAngle"), HALF_TURN),
    **dict.fromkeys(("xx", "yx", "xy", "yy", "dx", "dy"), FIXED),
}
"""What a delta of 1 adds to a field; lengths, which are not listed, are in font units."""
IN_ORDER = {
    CompositeMode.CLEAR: (),
    CompositeMode.SRC: ("SourcePaint",),
    CompositeMode.DEST: ("BackdropPaint",),
    CompositeMode.SRC_OVER: ("BackdropPaint", "SourcePaint"),
    CompositeMode.DEST_OVER: ("SourcePaint", "BackdropPaint"),
}
"""The modes that are drawn by painting one part over the other, and what is painted in turn."""


def read_palettes(font: TTFont) -> tuple[tuple[Colour, ...], ...]:
    """The palettes of CPAL; none if the font has no colours."""
    palettes = font["CPAL"].palettes if "CPAL" in font else []
    return tuple(
        tuple((c.red / 255, c.green / 255, c.blue / 255, c.alpha / 255) for c in palette)
        for palette in palettes
    )


class ColourReader:
    """The COLR table of a font.

    Parameters
    ----------
    font : TTFont
    axis_count : int
    read : function
        Unpacks a glyph by name.
    """

    def __init__(self, font: TTFont, axis_count: int, read: Callable[[str], Glyph]) -> None:
        colr = font["COLR"]
        self._axis_count, self._read = axis_count, read
        self._flat: dict[str, list[tuple[str, int]]] = {}
        self.paints: dict[str, Any] = {}
        if colr.version == 0:
            layers = colr.ColorLayers.items()
            self._flat = {name: [(one.name, one.colorID) for one in own] for name, own in layers}
            self._store, self._index = VariationStore(None, axis_count, "COLR"), None
            return
        self.table = table = colr.table
        if table.BaseGlyphRecordArray:
            records = table.LayerRecordArray.LayerRecord if table.LayerRecordArray else []
            for base in table.BaseGlyphRecordArray.BaseGlyphRecord:
                own = records[base.FirstLayerIndex : base.FirstLayerIndex + base.NumLayers]
                self._flat[base.BaseGlyph] = [(one.LayerGlyph, one.PaletteIndex) for one in own]
        if table.BaseGlyphList:
            self.paints = {
                record.BaseGlyph: record.Paint
                for record in table.BaseGlyphList.BaseGlyphPaintRecord
            }
        clips = getattr(table, "ClipList", None)
        self._clips: dict[str, Any] = clips.clips if clips else {}
        self._store = VariationStore(getattr(table, "VarStore", None), axis_count, "COLR")
        index = getattr(table, "VarIndexMap", None)
        self._index = index.mapping if index else None

    def __contains__(self, name: str) -> bool:
        return name in self.paints or name in self._flat

    def read(self, name: str) -> tuple[Layer, ...]:
        """The layers of one glyph, from back to front; none if it has no colours.

        Raises
        ------
        FontError
            Paints nest without end or are too many, or one of them is unknown.

        Warns
        -----
        FontWarning
            A part of the glyph is not drawn as the font asks.
        """
        if name in self.paints:
            drawing = _Drawing(self, name)
            drawing.add_glyph(name, (), None, 0)
            if drawing.left_aside:
                warn_caller(
                    f"Glyph {name!r} has colours that vfwidget does not draw as the font asks: "
                    f"{', '.join(sorted(drawing.left_aside))}.",
                    FontWarning,
                )
            return tuple(drawing.layers)
        return tuple(
            Layer(self._read(part), self.solid(entry)) for part, entry in self._flat.get(name, ())
        )

    def solid(self, entry: int) -> Paint:
        """A colour of the palette."""
        numbers = constant(np.array([0.0, 1.0]), self._axis_count)
        return Paint(SOLID, numbers, (_entry(entry),), "pad", self.frame(()))

    def glyph(self, name: str, around: Sequence[Varying]) -> Glyph:
        """A glyph under some maps, the innermost first."""
        glyph = self._read(name)
        outline = glyph.outline
        for matrix in around:
            outline = place(outline, matrix)
        return Glyph.of(outline, glyph.advance_width, glyph.contours, name, glyph.glyph_id)

    def frame(self, around: Sequence[Varying]) -> Varying:
        """Where (0, 0), (1, 0) and (0, 1) come to lie under some maps, the innermost first."""
        frame: Varying = constant(np.array([[0.0, 0.0], [1, 0], [0, 1]]), self._axis_count)
        for matrix in around:
            frame = place(frame, matrix)
        return frame

    def clip_box(self, name: str, around: Sequence[Varying]) -> Varying | None:
        """Three corners of the clip box of a glyph, (3, 2), under some maps; None without a box.

        They are the lower left, the lower right and the upper left one.
        """
        if name not in self._clips:
            return None
        box = self.numbers(self._clips[name], ("xMin", "yMin", "xMax", "yMax"))
        rows = np.array([[0, 1], [2, 1], [0, 3]])
        corners: Varying = Affine(box.base[rows], box.deltas[rows], box.support)
        for matrix in around:
            corners = place(corners, matrix)
        return corners

    def fill(self, paint: Any, around: Sequence[Varying]) -> Paint:
        """A solid colour or a gradient under some maps."""
        kind, extend = SOLID, "pad"
        fields: tuple[str, ...] = ()
        stops: list[Any] = [paint]
        if _form(paint) != PaintFormat.PaintSolid:
            kind, fields = GRADIENTS[_form(paint)]
            stops = list(paint.ColorLine.ColorStop)
            extend = ExtendMode(paint.ColorLine.Extend).name.lower()
            if not stops:
                raise FontError("The COLR table is damaged: a gradient has no colours.")
        parts = [self.numbers(paint, fields)]
        # A solid colour has no offset, and its alpha comes first.
        both = [
            self.numbers(s, ("Alpha",) if kind == SOLID else ("StopOffset", "Alpha")) for s in stops
        ]
        zero = constant(np.zeros(1), self._axis_count)
        parts += [zero if kind == SOLID else part.some([0]) for part in both]
        parts += [part.some([-1]) for part in both]
        entries = tuple(_entry(stop.PaletteIndex) for stop in stops)
        return Paint(kind, one_after_another(parts), entries, extend, self.frame(around))

    def matrix(self, paint: Any) -> Varying:
        """The map of a transformation, (2, 3)."""
        form = _form(paint)
        if form == PaintFormat.PaintTransform:
            found = self.numbers(paint.Transform, ("xx", "yx", "xy", "yy", "dx", "dy"))
            order = np.array([[0, 2, 4], [1, 3, 5]])
            return Affine(found.base[order], found.deltas[order], found.support)
        fields, places = TRANSFORMATIONS[form]
        found = self.numbers(paint, fields, dict.fromkeys(X_Y, 1.0))
        base, deltas = np.zeros(9), np.zeros((9, found.deltas.shape[-1]))
        base[3:5] = 1
        base[list(places)], deltas[list(places)] = found.base, found.deltas
        if "scale" in fields:
            base[4], deltas[4] = base[3], deltas[3]
        # Angles are in degrees in the file, and a skew in x goes the other way.
        turn = np.array([1, 1, RADIANS, 1, 1, -RADIANS, RADIANS, 1, 1])
        transformation = Transformation(Affine(base * turn, deltas * turn[:, None], found.support))
        if deltas.any():
            return transformation
        return constant(transformation.value(np.zeros(self._axis_count)), self._axis_count)

    def numbers(
        self, record: Any, fields: Sequence[str], units: dict[str, float] | None = None
    ) -> Affine:
        """Some fields of a record, whose deltas follow one another from its VarIndexBase."""
        base = np.array([float(getattr(record, field)) for field in fields])
        first = getattr(record, "VarIndexBase", NO_VARIATION)
        found = [self._row(first, i) for i in range(len(fields))]
        support, places = merge_regions([part for _, part in found])
        deltas = np.zeros((len(fields), len(support)))
        for i, (field, (row, _)) in enumerate(zip(fields, found, strict=True)):
            unit = (units or UNITS).get(field, UNITS.get(field, 1.0))
            np.add.at(deltas[i], places[i], row * unit)
        return Affine(base, deltas, support.reshape(len(support), self._axis_count, 3))

    def _row(self, first: int, offset: int) -> tuple[Array, Array]:
        if first == NO_VARIATION:
            return self._store.row(NO_VARIATION)
        index = first + offset
        if self._index is not None:
            # As in all such maps, the last entry serves those beyond the end.
            index = self._index[min(index, len(self._index) - 1)] if self._index else NO_VARIATION
        return self._store.row(index)


class _Drawing:
    """One glyph while its paints are followed."""

    def __init__(self, reader: ColourReader, name: str) -> None:
        self.reader, self.name = reader, name
        self.layers: list[Layer] = []
        self.left_aside: set[str] = set()
        self._paints = 0

    def add_glyph(
        self, name: str, around: tuple[Varying, ...], inside: Glyph | None, depth: int
    ) -> None:
        """Add what a colour glyph draws; the parameters are those of :meth:`add`."""
        first = len(self.layers)
        self.add(self.reader.paints[name], around, inside, depth)
        box = self.reader.clip_box(name, around)
        if box is not None and cuts(box, self.layers[first:]):
            self.left_aside.add("a clip box that cuts a part off")

    def add(
        self, paint: Any, around: tuple[Varying, ...], inside: Glyph | None, depth: int
    ) -> None:
        """Add what a paint draws.

        Parameters
        ----------
        around : tuple of Varying
            The maps around the paint, the innermost first.
        inside : Glyph, optional
            The outline that the paint fills.
        """
        self._paints += 1
        if depth > MAX_DEPTH or self._paints > MAX_PAINTS:
            raise FontError(
                f"The COLR table is damaged: the paints of glyph {self.name!r} nest too deeply "
                "or are too many."
            )
        reader, form = self.reader, _form(paint)
        if form == PaintFormat.PaintColrLayers:
            layers = reader.table.LayerList.Paint
            for part in layers[paint.FirstLayerIndex : paint.FirstLayerIndex + paint.NumLayers]:
                self.add(part, around, inside, depth + 1)
        elif form == PaintFormat.PaintGlyph:
            if inside is not None:
                self.left_aside.add("an outline that clips another")
            self.add(paint.Paint, around, reader.glyph(paint.Glyph, around), depth + 1)
        elif form == PaintFormat.PaintColrGlyph:
            if paint.Glyph in reader.paints:
                self.add_glyph(paint.Glyph, around, inside, depth + 1)
        elif form == PaintFormat.PaintComposite:
            mode = CompositeMode(paint.CompositeMode)
            if mode not in IN_ORDER:
                self.left_aside.add(f"the composite mode {mode.name}")
            for part in IN_ORDER.get(mode, IN_ORDER[CompositeMode.SRC_OVER]):
                self.add(getattr(paint, part), around, inside, depth + 1)
        elif form == PaintFormat.PaintTransform or form in TRANSFORMATIONS:
            self.add(paint.Paint, (reader.matrix(paint), *around), inside, depth + 1)
        elif inside is None:
            self.left_aside.add("a fill without an outline")
        else:
            self.layers.append(Layer(inside, reader.fill(paint, around)))


def _form(paint: Any) -> PaintFormat:
    """The format of a paint; one that varies counts as the one that does not."""
    form = PaintFormat(paint.Format)
    fixed = form.name.replace("PaintVar", "Paint")
    return PaintFormat[fixed]


def _entry(index: int) -> int | None:
    return None if index == FOREGROUND else index
