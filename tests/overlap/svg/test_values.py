"""Values, paths and transforms of SVG are read, or ignored, as browsers do it."""

from __future__ import annotations

import numpy as np
import pytest
from svgs import ONE, area, artwork

import vfwidget as vf


@pytest.mark.parametrize(
    ("attributes", "want"),
    [
        ('fill="nocolour"', 0),
        ('fill="url(#none)"', 0),
        ('fill="url(#none) red"', 1),
        ('fill="url(#g)"', 1),
        ('fill="url(#e)"', 0),
        ('fill="#00000000"', 0),
        ('fill="rgb(0 0 0 / 0%)"', 0),
        ('fill="HSL(0 0% 0%)"', 1),
        ('style="fill:red;fill:#ggg"', 1),
    ],
)
def test_paints_as_in_browsers(attributes, want):
    gradients = '<linearGradient id="g"><stop/></linearGradient><linearGradient id="e"/>'
    body = f'{gradients}{ONE}<g fill="none"><rect x="9" {attributes} width="10" height="10"/></g>'
    assert area(body) == pytest.approx(1 + 100 * want)


@pytest.mark.parametrize(
    ("stroke", "want"),
    [
        # Values that are no values leave those around, or the initial ones.
        ('stroke-width="-5"', 8 * 100),
        ('style="stroke-width:4;stroke-width:-2"', 4 * 100),
        ('stroke-linecap="ROUND"', 8 * 100 + 16 * np.pi),
        ('stroke-dasharray="10% 10%"', 400),
        ('stroke-dasharray="1in"', 8 * 96),
        ('stroke-dasharray="1em" font-size="50"', 400),
        ('stroke-dasharray="20 -1"', 800),
        ('stroke-dasharray="20,"', 800),
        ('stroke-dasharray="10" stroke-dashoffset="5%"', 8 * 50),
        ('stroke-dasharray="1 3" pathLength="8"', 8 * 25),
        ('stroke-dasharray="1 3" pathLength="0"', 800),
    ],
)
def test_strokes_as_in_browsers(stroke, want):
    body = f'<g stroke="red" stroke-width="8"><path d="M20 20H120" {stroke}/></g>'
    assert area(body, 'viewBox="0 0 100 100"') == pytest.approx(want, rel=1e-3)


def test_a_dash_goes_on_over_the_end_of_a_closed_path():
    def dashed(path):
        return area(f'<path d="{path}" fill="none" stroke="red" stroke-width="8" {dashes}/>')

    dashes = 'stroke-dasharray="90 20" stroke-dashoffset="45"'
    around, open_ends = dashed("M20 20h100v100h-100z"), dashed("M20 20h100v100h-100v-100")
    # The corner of the joined dash is whole: without the join one quarter of its square is missing.
    assert around == pytest.approx(open_ends + 16)


@pytest.mark.parametrize(
    ("path", "want"),
    [
        ("M0 0L10 0V10foo L99 99", 50),
        ("M0 0L10 0V10,,L99 99", 50),
        ("M0 0L10 0V10A5 5 0 2 1 99 99", 50),
        ("M0 0L10 0V10C1 1 2 2", 50),
        ("M0 0 10 0 10 10", 50),
        ("m5 5 10 0 0 10zm20 0h10v10", 100),
        (",M0 0H10V10", 0),
        ("M0. 0H10V10", 0),
        ("M0 0H10V10" + "z" * 20_000, 50),
        # Numbers have the range of single precision.
        ("M0 0H10V10A1e200 5 0 0 1 0 50", 50),
        ("M0 0H10V10L1e39 50", 50),
        ("M0 0H10V10A1e-200 5 0 0 1 0 50Z", 300),
        ("M0 0H10V10a5 5 0 0 1 1e-200 0V50L0 50Z", 500),
        ("M0 0H10V10A1e30 1e30 0 0 1 0 50Z", 300),
        ("M0 0H10V10A1e36 1e-3 90 0 1 10 50L0 50", 500),
    ],
)
def test_paths_as_in_browsers(path, want):
    assert area(f'{ONE}<path d="{path}" transform="translate(9)"/>') == pytest.approx(1 + want)


@pytest.mark.parametrize(
    ("smooth", "stated"),
    [
        # A smooth quadratic goes on from a quadratic only, and a smooth cubic from a cubic.
        ("M0 0S0 30 30 30T60 30V0Z", "M0 0C0 0 0 30 30 30Q30 30 60 30V0Z"),
        ("M0 0Q0 30 30 30S60 30 60 0Z", "M0 0Q0 30 30 30C30 30 60 30 60 0Z"),
        ("M0 0C0 9 9 30 30 30S60 30 60 0Z", "M0 0C0 9 9 30 30 30C51 30 60 30 60 0Z"),
        ("M0 0Q0 30 30 30t30 9V0Z", "M0 0Q0 30 30 30Q60 30 60 39V0Z"),
    ],
)
def test_smooth_curves(smooth, stated):
    assert area(f'<path d="{smooth}"/>') == pytest.approx(area(f'<path d="{stated}"/>'))


@pytest.mark.parametrize(
    ("transform", "box"),
    [
        ('transform="rotate(90)" transform-origin="20 10"', [(10, -10), (20, 0)]),
        ('style="transform:rotate(90deg);transform-origin:20px 10px"', [(10, -10), (20, 0)]),
        ('style="transform:rotate(.25turn);transform-origin:20% 20%"', [(10, -10), (20, 0)]),
        ('style="transform:translateX(10px) scaleY(.5)" transform="scale(9)"',
         [(20, -10), (30, -5)]),
        ('style="transform:translate(10%,10%)"', [(20, -25), (30, -15)]),
        ('style="transform:none" transform="scale(9)"', [(10, -20), (20, -10)]),
        ('style="transform:translate(calc(10% - 5px), max(10%, 1em))"', [(15, -36), (25, -26)]),
        ('style="transform:translate3d(1e1px, 2mm, 3px) scale(calc(1/2))" transform="scale(9)"',
         [(15, -10 - 192 / 25.4), (20, -5 - 192 / 25.4)]),
        ('style="transform:scale(2,50%) translateZ(3px)"', [(20, -10), (40, -5)]),
        ('style="translate:10% 10%"', [(20, -25), (30, -15)]),
        ('style="translate:none;rotate:90deg;transform-origin:20px 10px"', [(10, -10), (20, 0)]),
        ('style="rotate:z .25turn;transform-origin:20% 20%"', [(10, -10), (20, 0)]),
        ('style="scale:2 50%;transform:translateX(5px)"', [(30, -10), (50, -5)]),
        # Shift, turn, scale, and then the list of functions.
        ('style="transform:translateX(5px);scale:2 1;rotate:90deg;translate:40px"',
         [(20, -50), (30, -30)]),
        ('style="transform:scale(2);transform-box:fill-box"', [(10, -30), (30, -10)]),
        ('style="rotate:90deg;transform-box:fill-box;transform-origin:right 50%"',
         [(15, -15), (25, -5)]),
        ('style="translate:50% 20%;transform-box:fill-box"', [(15, -22), (25, -12)]),
        # Attributes of these names are none of SVG.
        ('translate="40" rotate="9" scale="3"', [(10, -20), (20, -10)]),
    ],
)  # fmt: skip
def test_transforms_of_style_sheets(transform, box):
    shape = f'<rect x="10" y="10" {transform} width="10" height="10"/>'
    found = artwork(shape, 'viewBox="0 0 100 50"').box
    np.testing.assert_allclose(found, box, atol=1e-12)


@pytest.mark.parametrize(
    "transform",
    [
        *("bad", "rotate(9deg)", "translate(9) foo(3)", "translate(9,)", "translate(9px)"),
        *("rotate(9 9)", "SCALE(2)", "skewx(9)", "translate(9", "translate(9),,scale(2)"),
        *(",scale(2)", "scale(2),", "translate3d(9,9,9)", "scale(calc(2))", "scale(1e999)"),
    ],
)
def test_a_transform_that_cannot_be_read_is_ignored(transform):
    with pytest.warns(vf.OverlapWarning, match=r"transform='.*' of a <g>"):
        box = artwork(f'<g transform="{transform}"><rect width="2" height="1"/></g>').box
    np.testing.assert_array_equal(box, [(0, -1), (2, 0)])


@pytest.mark.parametrize(
    "transform",
    [
        *("translate(9,9)", "translate(9px),scale(2)", "translate (9px)", "translate(9px 9px)"),
        *("rotate(9)", "rotate(9px)", "scale(1px)", "scale(2,2,2)", "scale(calc(2)", "rotateX(0)"),
        *("perspective(9px)", "none scale(2)", "translate(calc(9px + 9))", "translateZ(50%)"),
    ],
)
def test_a_transform_of_a_style_sheet_that_cannot_be_read_is_ignored(transform):
    shape = f'<rect width="2" height="1" transform="scale(3)" style="transform:{transform}"/>'
    with pytest.warns(vf.OverlapWarning, match=r"transform: .* of a <rect>"):
        box = artwork(shape).box
    np.testing.assert_array_equal(box, [(0, -3), (6, 0)])


@pytest.mark.parametrize(
    ("value", "want"),
    [
        ("calc(50px)", 50),
        ("calc(50)", 50),
        ("calc(50% + 10px)", 60),
        ("calc( 10px - 20px*-2 )", 50),
        ("calc((10px + 5px)*2)", 30),
        ("calc(2*(3 + 4)*2px/7)", 4),
        ("min(50px, 20%)", 20),
        ("max(50px, 70%, 1em)", 70),
        ("clamp(60px, 50px, 40px)", 60),
        ("Clamp(10px, 50%, 40px)", 40),
        ("CALC(10PX + calc(2EM))", 42),
        ("calc(10px - -5px)", 15),
        ("calc(1em + 1rem)", 32),
        ("calc(1e1px*2)", 20),
    ],
)
def test_lengths_that_are_computed(value, want):
    assert area(f'<rect width="{value}" height="1"/>', 'viewBox="0 0 100 9"') == pytest.approx(want)


@pytest.mark.parametrize(
    "value",
    [
        *("calc()", "calc(5 + 3px)", "calc(10px+5px)", "calc(10px +5px)", "calc(3px*3px)"),
        *("calc(9/3px)", "(10px)", "calc(1px, 2px)", "min()", "clamp(1px, 2px)", "calc(1px 2px)"),
        *("calc(10px/0)", "calc(10px + 5deg)", "calc(5px))", "calc(1px +)", "calc(* 2)", "calc"),
        *("calc(" * 150 + "1px" + ")" * 150, "(" * 900, "calc(" + "1*" * 480, "-(5px)"),
    ],
)
def test_expressions_that_are_none_are_ignored(value):
    with pytest.warns(vf.OverlapWarning, match=r"width='.*cannot be read|cannot be read.*width='"):
        assert area(f'{ONE}<rect width="{value}" height="9"/>') == pytest.approx(1)


@pytest.mark.parametrize(
    ("body", "said"),
    [
        (
            "<style>rect:has(a){fill:none}</style>",
            r"selectors are not read: 'rect:has\(a\)'; ",
        ),
        (
            '<rect width="1" height="1" clip-path="shape(from 0 0)"/>',
            r"ignored: clip-path='shape\(from 0 0\)' of a <rect>. State",
        ),
        (
            '<rect width="1" height="1" style="rotate:x 9deg"/>',
            "ignored: rotate: x 9deg of a <rect>. State",
        ),
        (
            '<rect width="1" height="1" transform="rotate(9deg)"/>',
            r"ignored: transform='rotate\(9deg\)' of a <rect>. State",
        ),
        (
            '<rect width="1" height="1" style="rotate:0deg;transform-box:stroke-box"/>',
            "the transform-box of a <rect>",
        ),
    ],
)
def test_what_is_not_read_is_said(body, said):
    with pytest.warns(vf.OverlapWarning, match=said):
        assert area(ONE + body) == pytest.approx(1)


def test_the_box_of_an_open_path_holds_its_end():
    clip = '<clipPath id="h" clipPathUnits="objectBoundingBox"><rect width=".5" height="1"/>'
    body = f'{clip}</clipPath><path d="M0 0H10V4" clip-path="url(#h)"/>'
    assert area(body) == pytest.approx(5)


def test_a_round_cap_is_half_a_disc():
    # The dash turns back at the corner, so a whole disc would stand out beyond it.
    stroke = 'stroke="red" stroke-width="20" stroke-linecap="round" fill="none"'
    box = artwork(f'<path d="M0 0L2 0L0 .5" {stroke}/>').box
    assert box[1, 0] < 6


def test_a_round_join_is_on_the_outer_side_only():
    stroke = 'stroke="red" stroke-width="8" stroke-linejoin="round" fill="none"'
    for path in ("M19 0H20V1", "M20 1V0H19"):
        assert area(f'<path d="{path}" {stroke}/>') == pytest.approx(15 + 4 * np.pi, rel=1e-3)


def test_a_handle_that_rounding_has_left_has_no_direction():
    stroke = 'stroke="red" stroke-width="4" fill="none"'
    bent = area(f'<path d="M0 .1C1e-15 .1 20 10 20 20" {stroke}/>')
    assert bent == pytest.approx(area(f'<path d="M0 .1C0 .1 20 10 20 20" {stroke}/>'))
    straight = area(f'<path d="M160.1 153.3T151 153.3T140 160" {stroke}/>')
    assert straight == pytest.approx(area(f'<path d="M160.1 153.3L151 153.3Q141.9 153.3 140 160" '
                                          f'{stroke}/>'), rel=1e-2)  # fmt: skip


def test_rules_look_no_farther_than_a_use():
    css = "<style>g rect{fill:none} rect{fill:red}</style>"
    body = f'{css}<g><rect id="a" width="9" height="9"/></g><use href="#a" y="20"/>'
    assert area(body) == pytest.approx(81)


def test_percentages_of_strokes_are_of_the_viewport_of_the_shape():
    inner = '<svg viewBox="0 0 20 20" width="20" height="20" y="50"><path d="M5 10H15"/></svg>'
    body = f'<g stroke="red" stroke-width="5%"><path d="M10 20H90"/>{inner}</g>'
    assert area(body, 'viewBox="0 0 100 100"') == pytest.approx(80 * 5 + 10)


def test_a_tight_turn_is_as_wide_as_the_stroke():
    body = '<path d="M0 0C8 80 1 80 6 10" fill="none" stroke="red" stroke-width="14"/>'
    steps = np.linspace(0, 1, 4001)[:, None]
    a, b, c, d = np.array([[0, 0], [8, 80], [1, 80], [6, 10]])
    u = 1 - steps
    curve = u**3 * a + 3 * u**2 * steps * b + 3 * u * steps**2 * c + steps**3 * d
    # The lowest point of the outline lies half a width below the lowest point of the curve.
    assert artwork(body).box[0, 1] == pytest.approx(-curve[:, 1].max() - 7, abs=0.05)
