"""What an SVG document draws: definitions, references, viewports and clip paths."""

from __future__ import annotations

import time

import numpy as np
import pytest
from svgs import MANY, NAMESPACES, ONE, area, artwork

import vfwidget as vf
from vfwidget.overlap.shape import read_obstacles

MARKER = '<marker id="a" orient="auto"><rect x="-50" y="-50" width="99" height="99"/></marker>'
HALF = (
    '<clipPath id="h" clipPathUnits="objectBoundingBox"><rect width=".25" height="2" y="-1"/>'
    "</clipPath>"
)


@pytest.mark.parametrize(
    "name",
    ["defs", "symbol", "clipPath", "mask", "marker", "pattern", "metadata", "unknown", "text"],
)
def test_what_is_not_drawn_by_itself(name):
    assert area(f'{ONE}<{name}><rect width="9" height="9"/></{name}>') == pytest.approx(1)


@pytest.mark.parametrize(
    "hidden",
    [
        'opacity="0"',
        'opacity="0%"',
        'style="opacity:0"',
        'fill-opacity="0"',
        'fill="transparent"',
        'fill="rgba(0,0,0,0)"',
        'fill="none"',
        'display="none"',
        'visibility="hidden"',
        'visibility="collapse"',
        'style="fill: none"',
        'class="hidden"',
        'fill="red" style="fill:none !important"',
    ],
)
def test_what_is_not_visible(hidden):
    style = "<style>.hidden{fill:none}</style>"
    assert area(f'{style}{ONE}<rect {hidden} width="9" height="9"/>') == pytest.approx(1)
    assert area(f'{style}{ONE}<g {hidden}><rect width="9" height="9"/></g>') == pytest.approx(1)


def test_a_shape_in_a_hidden_group_may_be_visible():
    body = '<g visibility="hidden"><rect width="9" height="9"/><circle r="1" {}/></g>'
    assert area(ONE + body.format("")) == pytest.approx(1)
    shown = body.format('cx="20" visibility="visible"')
    assert area(ONE + shown) == pytest.approx(1 + np.pi, rel=1e-3)
    # Nothing shows again what is not displayed.
    assert area(f'{ONE}<g display="none"><circle r="9" display="inline"/></g>') == pytest.approx(1)


@pytest.mark.parametrize(
    "shape",
    [
        '<rect width="-9" height="2"/>',
        '<rect height="2"/>',
        '<rect width="9"/>',
        '<circle r="-9"/>',
        '<ellipse rx="3" ry="0"/>',
        '<path d=""/>',
        '<path d="none"/>',
        '<path d="L9 9V0Z"/>',
        "<path/>",
        "<polygon/>",
    ],
)
def test_shapes_without_a_size(shape):
    assert area(f"{ONE}{shape}", 'width="50" height="50"') == pytest.approx(1)


SYMBOL = '<symbol id="s" viewBox="0 0 10 10"{}><rect width="5" height="10"/></symbol>'


@pytest.mark.parametrize(
    "body, want",
    [
        (SYMBOL.format("") + '<use href="#s" width="20" height="20"/>', 200),
        (SYMBOL.format("") + '<use href="#s" width="20" height="40"/>', 200),
        (SYMBOL.format(' preserveAspectRatio="none"')
         + '<use href="#s" width="20" height="40"/>', 400),
        # Without a size, a symbol is as large as the viewport around it.
        (SYMBOL.format("") + '<use href="#s"/>', 5000),
        ('<symbol id="s"><rect width="5" height="10"/></symbol><use xlink:href="#s"/>', 50),
        # The content of a symbol ends at its viewport.
        (
            '<symbol id="s"><rect x="-9" width="99" height="99"/></symbol>'
            '<use href="#s" x="9" width="20" height="10"/>',
            200,
        ),
        (
            '<symbol id="s" overflow="visible"><rect width="30" height="30"/></symbol>'
            '<use href="#s" width="20" height="10"/>',
            900,
        ),
        ('<svg x="5" width="50" height="25" viewBox="0 0 10 10"><rect width="9" height="9"/></svg>',
         22.5**2),
        ('<svg width="50" height="50"><rect width="50%" height="10%"/></svg>', 125),
        ('<svg width="0" height="50"><rect width="5" height="5"/></svg>' + ONE, 1),
        ('<rect width="50%" height="10%"/>', 500),
        ('<line y1="9" x2="50%" y2="9" stroke="red" stroke-width="1%"/>', 50),
        ('<rect width="1em" height="1in"/>', 16 * 96),
        ('<ellipse cx="9" cy="9" rx="3"/>', 9 * np.pi),
        ('<ellipse cx="9" cy="9" rx="3" ry="-2"/>', 9 * np.pi),
        ('<rect width="9" height="20" rx="-1" ry="3"/>', 180 - (4 - np.pi) * 9),
        # What lies outside of the document is not seen.
        ('<rect x="-5" y="90" width="999" height="20"/>', 1000),
        ('<use href="#b c"/><use href="#b%20c" y="20"/><defs>'
         '<rect id="b c" width="2" height="2"/></defs>', 8),
        ('<defs><rect id="a" width="2" height="2"/><rect id="b" width="9" height="2"/></defs>'
         '<use xlink:href="#a" href="#b"/>', 18),
        ('<symbol id="s" transform="scale(2)"><rect width="5" height="4"/></symbol>'
         '<use href="#s"/>', 80),
        ('<g font-size="20"><rect width="2em" height="50%" font-size="50%"/></g>', 1000),
        ('<rect systemLanguage="de" width="9" height="9"/>' + ONE, 1),
        ('<svg viewBox="0 0 0 9"><rect width="5" height="5"/></svg>' + ONE, 1),
        ('<symbol id="s" viewBox="0 0 0 0"><rect width="5" height="5"/></symbol>'
         '<use href="#s"/>' + ONE, 1),
        ('<defs><rect id="a" width="2" height="2"/><rect id="a" width="9" height="9"/></defs>'
         '<use href="#a"/>', 4),
        (
            '<defs><rect id="a" width="2" height="2"/><use id="b" href="#a" x="2"/></defs>'
            '<use href="#b" y="3"/>',
            4,
        ),
        ('<g fill="none"><rect fill="inherit" width="9" height="9"/></g>' + ONE, 1),
        ('<use href="#nothing"/><use/>' + ONE, 1),
        (
            '<switch><foreignObject requiredExtensions="x"/><g>' + ONE + "</g>"
            '<rect width="9" height="9"/></switch>',
            1,
        ),
    ],
)  # fmt: skip
def test_references_and_viewports(body, want):
    assert area(body, 'width="100" height="100"') == pytest.approx(want, rel=1e-3)


@pytest.mark.parametrize(
    "attributes, scale",
    [
        ('viewBox="0 0 50 50"', 1),
        ('viewBox="0 0 50 50" width="100" height="100"', 2),
        ('viewBox="0 0 50 50" width="100"', 2),
        ('viewBox="0 0 50 50" height="100"', 2),
        ('viewBox="0 0 50 50" width="100%"', 1),
        ('viewBox="0 0 50 50" width="1in" height="1in"', 96 / 50),
        ('viewBox="0 0 50 50" x="9" y="9"', 1),
        ('viewBox="0 0 -50 9"', 1),
        ('viewBox="0,,0 50 90" width="60" height="90"', 1),
        ('viewBox="0 0 50% 50%" width="60" height="90"', 1),
        ('viewBox="0,0+50,25" width="100" height="50" preserveAspectRatio="none"', 2),
        ('viewBox="0 0 50 25" width="200" height="50" preserveAspectRatio="xMinYMax"', 2),
        ("", 1),
    ],
)
def test_the_size_of_the_document(attributes, scale):
    box = artwork('<rect x="10" y="20" width="30" height="5"/>', attributes).box
    np.testing.assert_allclose(box, np.array([[10, -25], [40, -20]]) * scale)


CLIP = '<clipPath id="c"{}><rect width="10" height="10"/></clipPath>'
WIDE = '<rect x="5" y="5" width="90" height="90" clip-path="url(#c)"/>'


@pytest.mark.parametrize(
    "body, want",
    [
        (CLIP.format("") + WIDE, 25),
        (CLIP.format(' transform="scale(2)"') + WIDE, 225),
        (CLIP.format("") + '<g transform="translate(50)" clip-path="url(#c)">' + ONE + "</g>", 1),
        ('<style>g{clip-path:url("#c")}</style>' + CLIP.format("") + f"<g>{WIDE}</g>", 25),
        # A clip path that is clipped, and one within another.
        (CLIP.format(' clip-path="url(#d)"') + '<clipPath id="d"><rect width="7" height="99"/>'
         "</clipPath>" + WIDE, 10),
        (CLIP.format("") + '<clipPath id="d"><rect width="7" height="99"/></clipPath>'
         '<g clip-path="url(#d)">' + WIDE + "</g>", 10),
        # What is painted in a clip path does not matter, but its rule does.
        ('<clipPath id="c"><path fill="none" clip-rule="evenodd" '
         'd="M0 0H20V20H0Z M10 10H15V15H10Z"/></clipPath>' + WIDE, 200),
        ('<clipPath id="c"><use href="#r"/></clipPath><defs><rect id="r" width="9" height="9"/>'
         "</defs>" + WIDE, 16),
        (CLIP.format("") + '<path d="M0 5H90" stroke="red" stroke-width="4" clip-path="url(#c)"/>',
         40),
        ('<clipPath id="c"/>' + WIDE + ONE, 1),
        # Nothing is known of these.
        (WIDE, 8100),
        (CLIP.format(' clipPathUnits="objectBoundingBox"') + WIDE, 8100),
    ],
)  # fmt: skip
def test_clip_paths(body, want):
    assert area(body) == pytest.approx(want, rel=1e-6)


@pytest.mark.parametrize(
    "source",
    [
        "<s:svg xmlns:s='http://www.w3.org/2000/svg'><s:rect width='2' height='1'/></s:svg>",
        "<svg><rect width='2' height='1'/></svg>",
        '<?xml version="1.0" encoding="ISO-8859-1"?><!DOCTYPE svg PUBLIC "a" "b"><!-- é -->'
        f"<svg {NAMESPACES}><title>é</title><rect width='2' height='1'/><?x y?></svg>",
        f"<svg {NAMESPACES} xmlns:x='urn:x'><x:rect width='9' height='9'/>"
        "<rect width='2' height='1'/></svg>",
    ],
)
def test_names_and_headers(source):
    assert read_obstacles([vf.Artwork(source)])[0].area() == pytest.approx(2)


LONG = "M0 0" + "h1" * 1_000_000


@pytest.mark.parametrize(
    "body, message",
    [
        ('<line x2="9"/>', "draws nothing"),
        (f'{WIDE}<clipPath id="c"/>', "draws nothing"),
        (f'<path id="p" d="{LONG}"/>{MANY}', "at least 1,000,000 curves"),
        (f'<polygon id="p" points="{"1 2 " * 500_000}"/>{MANY}', "at least 500,000 curves"),
        (f'<rect id="p" width="9" height="9" transform="{"scale(1)" * 99_999}"/>{MANY}',
         "transform has 799,992 characters"),
        ("<style>" + ".a{fill:red}" * 9_999 + f'</style><rect id="p"/>{MANY}', "9,999 rules"),
        ('<path d="M0 0H9e5" stroke="red" stroke-dasharray="1e-3"/>', "curves"),
        ('<path d="M0 0H9" stroke="red" stroke-dasharray="1" pathLength="1e9"/>', "curves"),
        ('<path d="M0 0H9" stroke="red" stroke-dasharray="1" pathLength="1e300"/>', "curves"),
        ('<rect width="9" height="9" transform="scale(1e200)"/>', r"coordinate of 9e\+200"),
        ('<clipPath id="c" clip-path="url(#c)"/><rect clip-path="url(#c)"/>', "uses itself"),
        (f'<path d="M0 0h9v9{"zL3 4" * 9_000}"/>', "pairs of curves"),
    ],
)  # fmt: skip
def test_documents_that_are_refused_at_once(body, message):
    start = time.perf_counter()
    with pytest.raises(vf.OverlapError, match=message):
        artwork(body)
    assert time.perf_counter() - start < 10


@pytest.mark.parametrize(
    ("body", "said"),
    [
        (
            '<mask id="m"/><rect id="box" width="4" height="3" mask="url(#m)"/>',
            "mask of <rect id='box'>",
        ),
        (
            '<filter id="f"/><g style="filter:url(#f)"><rect width="4" height="3"/></g>',
            "filter of a <g>",
        ),
        ('<rect width="4" height="3" filter="blur(2px)"/>', "the filter of a <rect>"),
    ],
)
def test_masks_and_filters_are_ignored_and_said_so(body, said):
    with pytest.warns(vf.OverlapWarning, match=said) as caught:
        assert area(body) == pytest.approx(12)
    assert len(caught) == 1


@pytest.mark.parametrize(
    ("body", "want"),
    [
        # Markers scale with the stroke, and are clipped to their own viewport.
        (MARKER + '<path d="M0 0H50" stroke-width="2" marker-end="url(#a)"/>', 4 * 9),
        (MARKER + '<path d="M0 0H50H99" marker-mid="url(#a)"/>', 9),
        (MARKER + '<g style="marker:url(#a)"><path d="M0 0H50H99"/></g>', 3 * 9),
        (MARKER + '<rect width="9" height="9" marker-end="url(#a)"/>', 81),
        # A reference to nothing draws nothing.
        (MARKER + '<path d="M0 0H50" marker-end="url(#none)"/><rect width="1" height="1"/>', 1),
        # The box of a group is that of its shapes, without strokes and markers.
        (
            HALF + MARKER + '<g clip-path="url(#h)"><path d="M0 0H40V20H0Z" stroke="#000" '
            'stroke-width="2" marker-end="url(#a)"/></g>',
            10 * 21 + (18**0.5 - 1) ** 2,
        ),
        (
            HALF
            + '<path d="M0 0H9" stroke="#000" clip-path="url(#h)"/><rect width="1" height="1"/>',
            1,
        ),
    ],
)
def test_markers_and_clips_in_units_of_the_box(body, want):
    assert area(body) == pytest.approx(want, abs=1.5)


def test_a_marker_that_draws_itself_is_refused():
    body = '<marker id="a"><path d="M0 0H1" marker-end="url(#a)"/></marker>'
    with pytest.raises(vf.OverlapError, match="uses itself"):
        artwork(body + '<path d="M0 0H9" stroke="#000" marker-end="url(#a)"/>')


@pytest.mark.parametrize(
    ("length", "pixels"),
    [
        ("2.54cm", 96),
        ("101.6Q", 96),
        ("1IN", 96),
        ("2rem", 32),
        ("4ch", 32),
        ("2Em", 32),
        ("6pc", 96),
    ],
)
def test_units_of_length(length, pixels):
    assert area(f'<rect width="{length}" height="1"/>') == pytest.approx(pixels)


@pytest.mark.parametrize("length", ["5vw", "calc(5px + 3cqmin)", "5DVH"])
def test_lengths_that_depend_on_the_window_are_refused(length):
    with pytest.raises(vf.OverlapError, match=r"width=.* depends on the window .* give a number"):
        artwork(f'{ONE}<rect width="{length}" height="5"/>')
    # They do not matter where nothing is drawn.
    assert area(f'{ONE}<text width="{length}" x="1 2 3">a</text>') == pytest.approx(1)


@pytest.mark.parametrize("length", ["5 px", "5furlong", "5.px", "5,5", "five", "rect(5)", "5px5"])
def test_lengths_that_cannot_be_read_are_ignored_and_said_so(length):
    with pytest.warns(vf.OverlapWarning, match="width='.*' of <rect id='a'>, height: .*;?"):
        assert area(
            f'{ONE}<rect id="a" width="{length}" style="height:{length}"/>'
            f'<rect x="{length}" y="9" width="2" height="2"/>'
        ) == pytest.approx(5)


def test_an_svg_as_wide_as_its_window():
    box = 'viewBox="0 0 200 100"'
    want = area('<rect width="20" height="9"/>', f'{box} width="100%" height="100%"')
    assert area('<rect width="20" height="9"/>', f'{box} width="100vw" height="100vh"') == want


def test_a_path_is_drawn_up_to_a_letter_without_numbers():
    assert area('<path d="M0 0H5V5z hello"/>') == pytest.approx(12.5)
