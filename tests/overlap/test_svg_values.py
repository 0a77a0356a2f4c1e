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
        ('style="stroke-width:4;stroke-width:wide"', 4 * 100),
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
    ],
)  # fmt: skip
def test_transforms_of_style_sheets(transform, box):
    shape = f'<rect x="10" y="10" {transform} width="10" height="10"/>'
    found = artwork(shape, 'viewBox="0 0 100 50"').box
    np.testing.assert_allclose(found, box, atol=1e-12)


@pytest.mark.parametrize(
    ("body", "said"),
    [
        (
            "<style>rect + rect{fill:none}</style>",
            r"selectors are not read: 'rect \+ rect'; ",
        ),
        ('<rect width="1" height="1" clip-path="circle(3px)"/>', "the clip-path of a <rect>"),
        ('<rect width="1" height="1" style="rotate:9deg"/>', "the rotate of a <rect>"),
    ],
)
def test_what_is_not_read_is_said(body, said):
    with pytest.warns(vf.OverlapWarning, match=said):
        assert area(ONE + body) == pytest.approx(1)
