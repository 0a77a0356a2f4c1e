"""Tiny fonts with layers of colour: COLR of both versions, and CPAL."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import fonts
from fontTools.colorLib import builder as colorLib
from fontTools.fontBuilder import FontBuilder
from fontTools.ttLib.tables import otTables
from variation_tables import REGIONS, row_store

PALETTES = [[(1, 0, 0, 1), (0, 0, 1, 0.5)], [(0, 1, 0, 1), (1, 1, 1, 1)]]
CLIP_BOXES = {"a": (-2000, -2000, 3000, 3000, 0), "e": (150, -500, 1000, 1500, 8)}
"""xMin, yMin, xMax and yMax, and the first row of their deltas."""


def coloured(edit: Callable[[FontBuilder], None] = lambda _: None) -> bytes:
    """Glyph "a" has one layer for each kind of paint, and numbers that vary.

    "c" is a composition that is not drawn as the font asks, "d" paints itself without end, and a
    clip box cuts "e".
    """
    first = iter(range(0, 1000, 8))

    def varying(form: int, **fields: Any) -> dict[str, Any]:
        return {"Format": form, "VarIndexBase": next(first), **fields}

    def line(extend: str) -> dict[str, Any]:
        stops = [(0.25, 0, 1.0), (0.75, 1, 0.5)]
        return {
            "Extend": extend,
            "ColorStop": [
                {"StopOffset": o, "PaletteIndex": i, "Alpha": a, "VarIndexBase": next(first)}
                for o, i, a in stops
            ],
        }

    def inside(paint: dict[str, Any]) -> dict[str, Any]:
        return {"Format": F.PaintGlyph, "Glyph": "a", "Paint": paint}

    F = otTables.PaintFormat
    solid = {"Format": F.PaintSolid, "PaletteIndex": 0xFFFF, "Alpha": 1.0}
    linear = dict(x0=0, y0=0, x1=300, y1=0, x2=30, y2=300)
    radial = dict(x0=0, y0=0, r0=20, x1=100, y1=50, r1=300)
    sweep = dict(centerX=100, centerY=100, startAngle=30, endAngle=200)
    matrix = dict(xx=1.0, yx=0.25, xy=-0.5, yy=1.0, dx=10.0, dy=0.0)
    layers = [
        inside(solid),
        varying(F.PaintVarTranslate, dx=50, dy=0, Paint=inside(solid)),
        inside(varying(F.PaintVarLinearGradient, ColorLine=line("pad"), **linear)),
        {
            "Format": F.PaintVarTransform,
            "Transform": {"VarIndexBase": next(first), **matrix},
            "Paint": inside(varying(F.PaintVarRadialGradient, ColorLine=line("reflect"), **radial)),
        },
        varying(
            F.PaintVarRotateAroundCenter,
            angle=30.0,
            centerX=100,
            centerY=100,
            Paint=inside(varying(F.PaintVarSweepGradient, ColorLine=line("repeat"), **sweep)),
        ),
    ]
    composite = {
        "Format": F.PaintComposite,
        "CompositeMode": "xor",
        "SourcePaint": inside(solid),
        "BackdropPaint": inside(solid),
    }
    glyphs: dict[str, Any] = {
        "a": {"Format": F.PaintColrLayers, "Layers": layers},
        "c": composite,
        "d": {"Format": F.PaintColrGlyph, "Glyph": "d"},
        "e": inside(solid),
    }

    def add(builder: FontBuilder) -> None:
        rows = [
            [(7 * i + 3 * j) % 41 - 20 for j in range(len(REGIONS))] for i in range(next(first))
        ]
        store = row_store([[40 * delta for delta in row] for row in rows])
        order = builder.font.getReverseGlyphMap()
        builder.font["COLR"] = colorLib.buildCOLR(
            glyphs, version=1, glyphMap=order, varStore=store, clipBoxes=CLIP_BOXES
        )
        builder.font["CPAL"] = colorLib.buildCPAL(PALETTES)
        edit(builder)

    shapes, deltas = fonts.base_glyphs()
    shapes |= {name: fonts.outline([(0, 0), (0, 90), (90, 90)]) for name in "cde"}
    return fonts.build(shapes, deltas, edit=add)


def flat_colours() -> bytes:
    """COLR version 0: glyph "b" has two layers of one colour each."""

    def add(builder: FontBuilder) -> None:
        builder.setupCOLR({"b": [("a", 1), ("b", 0xFFFF)]}, version=0)
        builder.setupCPAL(PALETTES)

    return fonts.build(*fonts.base_glyphs(), edit=add)


def gathered_stops(extend: str) -> bytes:
    """COLR version 1 in a font without axes: gradients whose stops, or ends, are at one place."""
    F = otTables.PaintFormat
    apart, together = (
        {"Extend": extend, "ColorStop": [(first, 0, 1.0), (last, 1, 0.5)]}
        for first, last in ((0.0, 1.0), (0.5, 0.5))
    )
    sweep = {"Format": F.PaintSweepGradient, "centerX": 300, "centerY": 300}
    linear = dict(x0=0, y0=0, x1=300, y1=0, x2=0, y2=300)
    fills = [
        {**sweep, "ColorLine": apart, "startAngle": 90, "endAngle": 90},
        {**sweep, "ColorLine": together, "startAngle": 30, "endAngle": 200},
        {"Format": F.PaintLinearGradient, "ColorLine": together, **linear},
    ]
    layers = [{"Format": F.PaintGlyph, "Glyph": "a", "Paint": fill} for fill in fills]
    return _static(layers)


def static_colours() -> bytes:
    """COLR version 1 in a font without axes: a colour, a gradient and a turn."""
    F = otTables.PaintFormat
    line = {"Extend": "pad", "ColorStop": [(0.0, 0), (1.0, 1)]}
    linear = dict(ColorLine=line, x0=0, y0=0, x1=300, y1=0, x2=30, y2=300)
    fills = [
        {"Format": F.PaintSolid, "PaletteIndex": 1, "Alpha": 0.5},
        {"Format": F.PaintLinearGradient, **linear},
    ]
    layers = [{"Format": F.PaintGlyph, "Glyph": "a", "Paint": fill} for fill in fills]
    layers.append({"Format": F.PaintRotate, "angle": 30.0, "Paint": layers[1]})
    return _static(layers)


def _static(layers: list[dict[str, Any]]) -> bytes:
    """A font without axes whose glyph "a" has these layers."""

    def add(builder: FontBuilder) -> None:
        del builder.font["fvar"], builder.font["gvar"]
        order = builder.font.getReverseGlyphMap()
        glyphs = {"a": {"Format": otTables.PaintFormat.PaintColrLayers, "Layers": layers}}
        builder.font["COLR"] = colorLib.buildCOLR(glyphs, version=1, glyphMap=order)
        builder.font["CPAL"] = colorLib.buildCPAL(PALETTES)

    return fonts.build(*fonts.base_glyphs(), edit=add)
