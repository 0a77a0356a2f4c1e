"""Letters with layers of colour are what their layers cover, in every computation of overlaps."""

from __future__ import annotations

from functools import cache
from typing import Any

import colour_fonts
import numpy as np
import pytest
from fontTools.colorLib import builder as colorLib
from fontTools.fontBuilder import FontBuilder
from fontTools.ttLib.tables import otTables
from shapely.geometry import Polygon
from shapely.ops import unary_union

import vfwidget as vf
from tests.overlap.polygons import filled, simple
from vfwidget.overlap.shape import Shape, letters
from vfwidget.text.colours import as_drawn, shapes

F = otTables.PaintFormat
FLOOR = [(-9000, -900), (9000, -900), (9000, -500), (-9000, -500)]


def _paints(builder: FontBuilder) -> None:
    solid = {"Format": F.PaintSolid, "PaletteIndex": 0, "Alpha": 1.0}
    inside = {"Format": F.PaintGlyph, "Glyph": "a", "Paint": solid}
    moved = {"Format": F.PaintTranslate, "dx": 150, "dy": 40, "Paint": inside}
    # It covers a part of the others.
    mirrored = {"Format": F.PaintScale, "scaleX": -1.0, "scaleY": 1.0, "Paint": moved}
    mirrored = {"Format": F.PaintTranslate, "dx": 500, "dy": 20, "Paint": mirrored}
    layers = {"Format": F.PaintColrLayers, "Layers": [inside, moved, mirrored]}
    order = builder.font.getReverseGlyphMap()
    glyphs = {"a": layers, "d": {**layers, "Layers": [inside, moved]}}
    builder.font["COLR"] = colorLib.buildCOLR(glyphs, version=1, glyphMap=order)
    # The letter has layers only.
    builder.font["glyf"]["d"].numberOfContours = 0


@cache
def font() -> vf.Font:
    """The layers of "a" overlap, and one of them is mirrored; "d" has no outline."""
    return vf.load_font(colour_fonts.coloured(_paints))


def painted(text: vf.Text) -> Polygon:
    """What a text paints."""
    parts = []
    for shape in shapes(text):
        contours = [np.asarray(contour) for contour in shape.contours]
        sizes = [len(contour) for contour in contours]
        parts.append(filled(simple(Shape(np.concatenate(contours), sizes))))
    return unary_union(parts)


@pytest.mark.parametrize("letter", ["a", "d"])
@pytest.mark.parametrize("weight", [100, 400, 650])
def test_a_letter_covers_what_its_layers_cover(letter: str, weight: float):
    text = vf.Text(font(), letter, axes={"wght": weight})
    want = painted(text)
    assert letters(as_drawn(text))[0].area() == pytest.approx(want.area, rel=1e-4)
    bar = [(100, -50), (350, -50), (350, 260), (100, 260)]
    [found] = vf.overlaps(text, [bar])
    assert found.area == pytest.approx(want.intersection(Polygon(bar)).area, rel=1e-4)
    # As an obstacle, the text is the same shape.
    other = vf.Text("roboto-flex", "H")
    [turned] = vf.overlaps(other, text)
    (own,) = letters(other)
    assert turned.area == pytest.approx(filled(simple(own)).intersection(want).area, rel=1e-4)


def test_layers_whose_paints_vary():
    font = vf.load_font(colour_fonts.coloured())
    for axes in ({}, {"wght": 820}, {"wght": 250}):
        text = vf.Text(font, "a", axes=axes)
        assert letters(as_drawn(text))[0].area() == pytest.approx(painted(text).area, rel=1e-4)


def test_the_term_and_its_derivative():
    # Sides of letters that lie on each other would have no derivative.
    where = {"axes": {"wght": 650, "wdth": 130}, "offsets": [(0, 0), (-347, 17)]}
    text = vf.Text(font(), "ad", shared=False, **where)
    term = vf.NoOverlap([[(100, -50), (350, -50), (350, 260), (100, 260)]])
    assert sum(found.area for found in vf.overlaps(text)) > 1000
    assert vf.check_derivative(term, text) < 1e-6


@pytest.mark.parametrize("free", [{}, {"gap": 5.0}])
def test_letters_make_room(free: dict[str, Any]):
    text = vf.Text(font(), "dd", axes={"wght": 700}, tracking=-150)
    alone = painted(vf.Text(font(), "d", axes={"wght": 700}))
    assert painted(text).area < 2 * alone.area - 1000
    solution = vf.resolve_overlaps(text, **free)
    alone = painted(vf.Text(font(), "d", axes=solution.axes))
    left = 2 * alone.area - painted(solution.text).area
    assert solution.area == pytest.approx(left, rel=1e-3, abs=2)
    assert solution.free == (solution.area < 1e-3)
    assert solution.text.composition is text.composition


def test_letters_fall_on_their_layers():
    text = vf.Text(font(), "d", offsets=[(0, 0)])
    fall = vf.simulate(
        text, 60, forces=(0, -4000), obstacles=[FLOOR], positions=True, progress=False
    )
    assert fall[-1].composition is text.composition
    assert painted(fall[-1]).bounds[1] == pytest.approx(-500, abs=1)


def test_the_inked_area_is_that_of_the_layers():
    font = vf.load_font(colour_fonts.flat_colours())
    text = vf.Text(font, "ab", axes={"wght": 650}, shared=False)
    huge = [(-9e3, -9e3), (9e3, -9e3), (9e3, 9e3), (-9e3, 9e3)]

    def ink(text):
        return sum(found.area for found in vf.overlaps(text, huge) if found.obstacle)

    term = vf.Area().bind(text)
    assert term.area == pytest.approx(ink(text))
    assert vf.check_derivative(term, text) < 1e-5
    goal = ink(text.at({"wght": 800}))
    heavier = vf.solve(text, vf.Area(goal))
    assert heavier.status == "converged"
    assert ink(heavier.text) == pytest.approx(goal, rel=2e-3) != pytest.approx(term.area, rel=2e-2)
