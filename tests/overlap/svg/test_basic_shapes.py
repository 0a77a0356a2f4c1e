"""Clip paths that are shapes of CSS."""

from __future__ import annotations

import time

import numpy as np
import pytest
from svgs import ONE, area, artwork

import vfwidget as vf

BOX = '<rect x="20" y="10" width="80" height="60" {} style="clip-path:{}"/>'
PEN = 'stroke="#000" stroke-width="20"'


@pytest.mark.parametrize(
    ("shape", "want"),
    [
        ("circle()", 900 * np.pi),
        ("circle(10px)", 100 * np.pi),
        ("circle(20%)", 0.04 * 5000 * np.pi),
        ("circle(20px at 0 0)", 100 * np.pi),
        ("circle(20px at left top)", 100 * np.pi),
        ("circle(20px at bottom)", 200 * np.pi),
        ("Circle(closest-side AT 10px 50%)", 100 * np.pi),
        ("circle(calc(5px + 5px))", 100 * np.pi),
        ("ellipse()", 1200 * np.pi),
        ("ellipse(10px 50%)", 300 * np.pi),
        ("ellipse(closest-side 10px at 20px 50%)", 200 * np.pi),
        ("inset(10px)", 60 * 40),
        ("inset(10px 25%)", 40 * 40),
        ("inset(5px 10px 15px 20px)", 50 * 40),
        ("inset(0 round 10px)", 4800 - 400 + 100 * np.pi),
        ("inset(0 round 50%)", 1200 * np.pi),
        ("inset(0 round 10px 0 / 20px)", 4800 - 400 + 100 * np.pi),
        ("inset(0 round 90px)", 4800 - 3600 + 900 * np.pi),
        ("xywh(10px 10% 50% 20px)", 40 * 20),
        ("rect(10px 60px auto 5px)", 55 * 50),
        ("polygon(0 0, 100% 0, 50% 100%)", 2400),
        ("polygon(evenodd, 0 0, 40px 0, 40px 40px, 0 40px, 0 0, 9px 9px, 19px 9px, 19px 19px, "
         "9px 19px, 9px 9px)", 1500),
        ("path(&quot;M10 10h30v30z&quot;)", 450),
        ("path(evenodd, 'M0 0h30v30h-30zM10 10v10h10v-10z')", 800),
        # The box is around the stroke, if no other one is stated.
        ("circle(20px) fill-box", 400 * np.pi),
        ("view-box inset(0 50px 0 0)", 30 * 60),
        ("fill-box", 4800),
        ("none", 4800),
    ],
)  # fmt: skip
def test_areas(shape, want):
    assert area(BOX.format("", shape), 'viewBox="0 0 100 100"') == pytest.approx(want, rel=1e-3)


@pytest.mark.parametrize(
    ("shape", "want"),
    [
        ("inset(0)", 8000),
        ("inset(0) content-box", 4800),
        ("inset(25%) border-box", 2000),
        ("circle()", 1600 * np.pi - 2 * 331.6),
        ("ellipse() padding-box", 1200 * np.pi),
    ],
)
def test_boxes_of_strokes(shape, want):
    rect = BOX.format(PEN, shape)
    if shape == "circle()":  # As wide as the box is high, and cut by nothing.
        want = 1600 * np.pi
    assert area(rect) == pytest.approx(want, rel=1e-3)


def test_a_group_is_measured_as_a_whole():
    shapes = '<rect x="10" width="10" height="10"/><rect x="40" y="30" width="10" height="10"/>'
    found = artwork(f'<g transform="scale(2)" style="clip-path:inset(5px)">{shapes}</g>')
    np.testing.assert_allclose(found.box, [(30, -70), (90, -10)])


def test_a_shape_of_a_clip_path_is_in_the_box_of_what_is_clipped():
    clip = (
        '<clipPath id="k" style="clip-path:circle(9px at 10px 10px)"><rect width="40" height="40"/>'
    )
    body = f'{clip}</clipPath><rect x="5" y="5" width="30" height="30" clip-path="url(#k)"/>'
    np.testing.assert_allclose(artwork(body).box, [(6, -24), (24, -6)])


@pytest.mark.parametrize(
    "clip", ['clip-path="url(#k)"', 'style="clip-path:xywh(10px 10px 20px 20px) view-box"']
)
def test_the_clip_path_of_an_inner_viewport_is_within_it(clip):
    inner = f'<svg x="20" y="30" width="80" height="80" viewBox="0 0 40 40" {clip}>'
    body = f'<clipPath id="k"><rect x="10" y="10" width="20" height="20"/></clipPath>{inner}'
    found = artwork(f'{body}<rect width="90" height="90"/></svg>')
    np.testing.assert_allclose(found.box, [(40, -90), (80, -50)])


@pytest.mark.parametrize(
    "shape",
    [
        *("circle(30)", "circle(-5px)", "circle(5px at)", "circle(5px 5px)", "circle(5px at 9)"),
        *("ellipse(5px)", "inset()", "inset(10)", "inset(0 round)", "inset(0 round -5px)"),
        *("inset(1px 1px 1px 1px 1px)", "polygon(0 0 100% 0)", "polygon(0 0, 9px)", "polygon()"),
        *("path(M0 0)", "path()", "foo(3px)", "circle(5px) circle(5px)", "circle(5px) foo"),
        *("circle(5px", "fill-box view-box", "circle(5px at right 1px bottom 1px)", "xywh(1px)"),
        "rect(1px 2px 3px)",
    ],
)
def test_shapes_that_cannot_be_read_are_ignored_and_said_so(shape):
    with pytest.warns(vf.OverlapWarning, match=r"clip-path: .* of a <rect>"):
        assert area(BOX.format("", shape)) == pytest.approx(4800)


def test_the_outermost_element_is_not_clipped_and_it_is_said():
    with pytest.warns(vf.OverlapWarning, match="clip-path: circle.* of the outermost <svg>"):
        assert area(ONE, 'clip-path="circle(.1px)"') == pytest.approx(1)


PATH = "M0 0" + "l9 9l-9 1" * 5_000


@pytest.mark.parametrize(
    "body",
    [
        f'<path id="p" d="{PATH}" style="clip-path:circle(9px)"/>' + '<use href="#p"/>' * 2_000,
        '<g style="clip-path:inset(1px)">' * 90 + f'<path d="{PATH}"/>' + "</g>" * 90,
        '<g style="rotate:1deg;transform-box:fill-box">' * 90 + f'<path d="{PATH}"/>' + "</g>" * 90,
        '<clipPath id="k" clipPathUnits="objectBoundingBox"/>'
        + f'<path id="p" d="{PATH}" clip-path="url(#k)"/>' + '<use href="#p"/>' * 2_000,
    ],
    ids=["uses", "groups", "transforms", "clip paths"],
)  # fmt: skip
def test_boxes_of_many_curves_are_refused(body):
    start = time.perf_counter()
    with pytest.raises(vf.OverlapError, match="boxes of more than 100,000 curves"):
        artwork(body)
    assert time.perf_counter() - start < 20
