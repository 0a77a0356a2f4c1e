"""A text as SVG and as CSS, checked by parsers that know nothing of this package."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
from fontTools.pens.areaPen import AreaPen
from fontTools.svgLib.path import parse_path

import vfwidget as vf
from vfwidget.export.css import declarations
from vfwidget.export.svg import plain

SVG = "{http://www.w3.org/2000/svg}"


@pytest.mark.parametrize("shared", [True, False])
def test_the_path_of_the_svg_has_the_ink_of_the_text(shared: bool) -> None:
    text = vf.Text("dynapuff", "hi", axes={"wght": 650}, shared=shared)
    root = ET.fromstring(text.to_svg())
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
    root = ET.fromstring(text.to_svg(background='"><script/>', height=100))
    assert root.find(f"{SVG}title").text == "<&> in DynaPuff"  # type: ignore[union-attr]
    assert [child.tag for child in root] == [f"{SVG}title", f"{SVG}rect", f"{SVG}path"]


def test_a_text_without_ink_is_an_empty_picture() -> None:
    root = ET.fromstring(vf.Text("dynapuff", " ").to_svg())
    assert root.find(f"{SVG}path").get("d") == ""  # type: ignore[union-attr]


def test_css_sets_every_axis() -> None:
    assert vf.Text("dynapuff", "hi", axes={"wght": 612.34567}).to_css() == (
        'font-family: "DynaPuff";\nfont-variation-settings: "wght" 612.34567, "wdth" 100;'
    )
    css = vf.Text("dynapuff", "hi", axes=[{"wght": 700}, {}], shared=False).to_css()
    assert '.letter-1 { font-variation-settings: "wght" 700, "wdth" 100; }' in css
    assert '.letter-2 { font-variation-settings: "wght" 400, "wdth" 100; }' in css


def test_css_sets_features_and_tracking() -> None:
    text = vf.Text("dynapuff", "hi", tracking=50, features={"kern": False, "liga": True})
    assert text.to_css().splitlines()[1:3] == [
        'font-feature-settings: "kern" 0, "liga" 1;',
        f"letter-spacing: {50 / text.font.units_per_em:g}em;",
    ]


@pytest.mark.parametrize("height", [0, -1, float("nan"), float("inf"), "tall"])
def test_a_picture_has_a_positive_height(height: object) -> None:
    text = vf.Text("dynapuff", "hi")
    with pytest.raises(vf.TextError, match="height must be a number of pixels > 0"):
        text.to_svg(height=height)  # type: ignore[call-overload]


def test_hostile_names_cannot_leave_the_string_that_they_are_in() -> None:
    css = declarations('"; } </style><script>\\', {'" ;}': 1.0})
    assert css == (
        'font-family: "\\22 ; } \\3c /style\\3e \\3c script\\3e \\5c ";\n'
        'font-variation-settings: "\\22  ;}" 1;'
    )


@pytest.mark.parametrize("character", ["\0", "\x0c", "\ud800", "\uffff"])
def test_characters_that_xml_does_not_allow_are_replaced(character: str) -> None:
    text = plain(f"a{character}<é😀\n")
    assert ET.fromstring(f"<title>{text}</title>").text == "a\ufffd<é😀\n"


def test_a_path_is_written(tmp_path: Path) -> None:
    text = vf.Text("dynapuff", "hi")
    for name, write in (("svg", text.to_svg), ("css", text.to_css)):
        assert write(tmp_path / name) is None
        assert (tmp_path / name).read_text(encoding="utf-8") == write()


def test_the_union_has_the_same_ink_without_overlaps() -> None:
    text = vf.Text("recursive", "N")
    root = ET.fromstring(text.to_svg(union=True))
    pen = AreaPen()
    parse_path(root.find(f"{SVG}path").get("d"), pen)  # type: ignore[union-attr]
    ink = _ink(text)
    assert abs(pen.value) == pytest.approx(ink, rel=1e-3)
    # Counted contour by contour, the N overlaps itself.
    twice = AreaPen()
    plain = ET.fromstring(text.to_svg()).find(f"{SVG}path")
    parse_path(plain.get("d"), twice)  # type: ignore[union-attr]
    assert abs(twice.value) > 1.01 * ink


def _ink(text: vf.Text) -> float:
    from vfwidget.overlap.shape import letters

    return sum(letter.area() for letter in letters(text))
