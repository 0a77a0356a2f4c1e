"""A text as SVG and as CSS, checked by parsers that know nothing of this package."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import pytest
from fontTools.pens.areaPen import AreaPen
from fontTools.svgLib.path import parse_path

import vfwidget as vf
from vfwidget.export.css import to_css
from vfwidget.export.svg import to_svg

SVG = "{http://www.w3.org/2000/svg}"


@pytest.mark.parametrize("shared", [True, False])
def test_the_path_of_the_svg_has_the_ink_of_the_text(shared: bool) -> None:
    text = vf.Text("dynapuff", "hi", axes={"wght": 650}, shared=shared)
    root = ET.fromstring(to_svg(text))
    pen = AreaPen()
    parse_path(root.find(f"{SVG}path").get("d"), pen)  # type: ignore[union-attr]
    x, y = (text.points().numpy()[text.word.contours.segments][..., i] for i in range(2))
    from vfwidget.outline.cubics import AREA

    assert abs(pen.value) == pytest.approx(abs((x * (y @ AREA.T)).sum()), rel=1e-3)
    left, top, width, height = map(float, root.get("viewBox", "").split())
    assert left < x.min() and x.max() < left + width
    assert top < -y.max() and -y.min() < top + height


def test_names_are_text_and_colours_are_escaped() -> None:
    text = vf.Text("dynapuff", "<&>")
    root = ET.fromstring(to_svg(text, background='"><script/>', height=100))
    assert root.find(f"{SVG}title").text == "<&> in DynaPuff"  # type: ignore[union-attr]
    assert [child.tag for child in root] == [f"{SVG}title", f"{SVG}rect", f"{SVG}path"]


def test_a_text_without_ink_is_an_empty_picture() -> None:
    root = ET.fromstring(to_svg(vf.Text("dynapuff", " ")))
    assert root.find(f"{SVG}path").get("d") == ""  # type: ignore[union-attr]


def test_css_sets_every_axis() -> None:
    assert to_css(vf.Text("dynapuff", "hi", axes={"wght": 612.34567})) == (
        'font-family: "DynaPuff";\nfont-variation-settings: "wght" 612.346, "wdth" 100;'
    )
    css = to_css(vf.Text("dynapuff", "hi", axes=[{"wght": 700}, {}], shared=False))
    assert '.letter-1 { font-variation-settings: "wght" 700, "wdth" 100; }' in css
    assert '.letter-2 { font-variation-settings: "wght" 400, "wdth" 100; }' in css
