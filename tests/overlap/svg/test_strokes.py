"""Strokes as areas: joins, caps, dashes, curves and transforms."""

from __future__ import annotations

import numpy as np
import pytest

import vfwidget as vf
from vfwidget.overlap.shape import read_obstacles

NAMESPACE = 'xmlns="http://www.w3.org/2000/svg"'


def artwork(body, attributes=""):
    group = f"<g {attributes}>{body}</g>"
    pen = 'fill="none" stroke="black" stroke-width="2"'
    return vf.Artwork(f"<svg {NAMESPACE} {pen}>{group}</svg>")


def area(body, attributes=""):
    return read_obstacles([artwork(body, attributes)])[0].area()


LINE = '<path d="M0 0H10"/>'
CORNER = '<path d="M0 0H10V10"/>'
CIRCLE = '<circle r="10"/>'


@pytest.mark.parametrize(
    "body, attributes, want",
    [
        (LINE, "", 20),
        (LINE, 'stroke-linecap="round"', 20 + np.pi),
        (LINE, 'stroke-linecap="square"', 24),
        (CORNER, "", 40),
        (CORNER, 'stroke-linejoin="round"', 39 + np.pi / 4),
        (CORNER, 'stroke-linejoin="bevel"', 39.5),
        # The tip is longer than 1.4 times the width.
        (CORNER, 'stroke-miterlimit="1.4"', 39.5),
        (CORNER, 'stroke-miterlimit="1.5"', 40),
        ('<rect width="10" height="10"/>', "", 80),
        ('<rect width="10" height="10"/>', 'stroke-linejoin="bevel"', 78),
        ('<path d="M0 0H10V10H0Z"/>', 'stroke-linecap="square"', 80),
        ('<path d="M0 0H10V10H0V0"/>', "", 79),
        ('<path d="M0 0H10V10H0V0Z"/>', "", 80),
        # After the end of a closed subpath the next one begins there.
        ('<path d="M0 0H10V10H0ZH-10"/>', "", 80 + 18),
        # There and back.
        ('<path d="M0 0H10H0"/>', "", 20),
        ('<path d="M0 0H10H0"/>', 'stroke-linejoin="round"', 20 + np.pi / 2),
        # Paths without length.
        ('<path d="M0 0h0"/>', 'stroke-linecap="round"', np.pi),
        ('<path d="M0 0Z"/>', 'stroke-linecap="square"', 4),
        (CIRCLE, "", 40 * np.pi),
        (CIRCLE, 'stroke-width="20"', 400 * np.pi),
        # Wider than the curve is bent.
        (CIRCLE, 'stroke-width="30"', 625 * np.pi),
        # Dashes.
        (LINE, 'stroke-dasharray="2"', 12),
        (LINE, 'stroke-dasharray="2 1"', 14),
        (LINE, 'stroke-dasharray="3,1 2"', 12),
        (LINE, 'stroke-dasharray="2 3" stroke-dashoffset="1"', 8),
        (LINE, 'stroke-dasharray="2 3" stroke-dashoffset="-1"', 8),
        (LINE, 'stroke-dasharray="0 5" stroke-linecap="round"', 2 * np.pi),
        (LINE, 'stroke-dasharray="0"', 20),
        (LINE, 'stroke-dasharray="none"', 20),
        (LINE, 'stroke-dasharray="2 -1"', 20),
        (CORNER, 'stroke-dasharray="12 99"', 24),
        (CIRCLE, 'stroke-dasharray="5 5"', 2 * (20 * np.pi - 30)),
        # A pen is transformed with its path, unless it asks not to be.
        (LINE, 'transform="scale(1 3)"', 60),
        (LINE, 'transform="scale(3 1)"', 60),
        ('<path d="M0 0H10" vector-effect="non-scaling-stroke"/>', 'transform="scale(3 7)"', 60),
        (CIRCLE, 'transform="translate(9) scale(2 .5) skewX(20)"', 40 * np.pi),
        (CORNER, 'transform="scale(-1 1)"', 40),
        (LINE, 'stroke-opacity="0"', None),
        (LINE, 'stroke="transparent"', None),
        (LINE, 'stroke-width="0"', None),
    ],
)
def test_areas(body, attributes, want):
    if want is None:
        with pytest.raises(vf.OverlapError, match="draws nothing"):
            artwork(body, attributes)
    else:
        assert area(body, attributes) == pytest.approx(want, rel=3e-3)


@pytest.mark.parametrize(
    "body, attributes, count",
    [
        (LINE, "", 1),
        (LINE, 'stroke-linecap="square"', 1),
        (LINE, 'stroke-linecap="round"', 1),
        (CORNER, "", 1),
        (CORNER, 'stroke-linejoin="bevel"', 1),
        (CIRCLE, "", 2),
        ('<rect width="50" height="50" rx="9"/>', "", 2),
        ('<path d="M0 0C90 0 0 90 90 90S50 -50 0 0"/>', 'stroke-linejoin="round"', 2),
        ('<path d="M0 40C0 0 9 0 9 40"/>', 'stroke-width="20"', 1),
        (CIRCLE, 'stroke-dasharray="8 8"', 4),
    ],
)
def test_no_cracks(body, attributes, count):
    """The parts of a stroke are joined, so that no contour of rounding is left between them."""
    assert len(artwork(body, attributes).contours) == count


def test_the_edges_of_a_curve_are_half_a_width_away():
    art = artwork('<path d="M40 150C40 20 160 20 160 150"/>', 'stroke-width="24"')
    t = np.linspace(0, 1, 2001)[:, None]
    ends = np.array([[40, 150], [40, 20], [160, 20], [160, 150]], dtype=float)
    u = 1 - t
    curve = u**3 * ends[0] + 3 * u * u * t * ends[1] + 3 * u * t * t * ends[2] + t**3 * ends[3]
    t = np.linspace(0, 1, 50)[:, None, None]
    u = 1 - t
    for c in art.contours:
        edge = u**3 * c[:, 0] + 3 * u * u * t * c[:, 1] + 3 * u * t * t * c[:, 2] + t**3 * c[:, 3]
        edge = edge.reshape(-1, 2) * [1, -1]
        away = np.hypot(*(edge[:, None] - curve).transpose(2, 0, 1)).min(1)
        beside = edge[:, 1] < 149
        np.testing.assert_allclose(away[beside], 12, atol=0.05)


@pytest.mark.parametrize(
    "body",
    [
        f'<path d="M0 0{"c20 20 -10 20 10 0" * 2000}"/>',
        f'<path d="{"M0 0c20 20 -10 20 10 0" * 2000}"/>',
        '<path d="M0 0c20 20 -10 20 10 0"/>' * 2000,
    ],
    ids=["one path", "subpaths", "paths"],
)
def test_cusps_are_refused_when_the_limit_is_reached(body):
    # Each cusp takes a while and has about 40 curves; they are not all computed before.
    with pytest.raises(vf.OverlapError, match=r"at least 25,0\d\d curves"):
        artwork(body)
