"""Contours for the tests of the raster, their images, and the errors of these."""

from __future__ import annotations

import numpy as np
import scan as referee
from hypothesis import settings
from hypothesis import strategies as st
from scan import scan

import vfwidget as vf
from vfwidget.raster import frame

checked = settings(deadline=None, derandomize=True, max_examples=100)
few = settings(deadline=None, derandomize=True, max_examples=30)
SIZE = (12, 14)
NEAR = 0.05
"""The referee's own error where curves are steep: it has 64 lines a pixel and 64 chords a cubic."""


def lines(*corners):
    """A polygon's sides as cubics, (s, 4, 2)."""
    begin = np.array(corners, dtype=float)
    end = np.roll(begin, -1, 0)
    return np.stack([begin, begin + (end - begin) / 3, begin + (end - begin) * 2 / 3, end], 1)


def rectangle(x, y, width, height):
    return lines((x, y), (x + width, y), (x + width, y + height), (x, y + height))


def reverse(contour):
    return contour[::-1, ::-1].copy()


def shape(cubic, *corners):
    """What a cubic and the way back from its end by these corners enclose."""
    return np.concatenate([[cubic], lines(cubic[3], *corners, cubic[0])[:-1]])


def blob(x, y, radii, turn=0.0):
    """A smooth contour around (x, y) through a point at each of these distances."""
    count = len(radii)
    angle = turn + 2 * np.pi * np.arange(count) / count
    out = np.stack([np.cos(angle), np.sin(angle)], -1) * np.asarray(radii)[:, None]
    way = 4 / 3 * np.tan(np.pi / (2 * count)) * np.stack([-out[:, 1], out[:, 0]], -1)
    begin = out + np.array([x, y])
    end, back = np.roll(begin, -1, 0), np.roll(way, -1, 0)
    return np.stack([begin, begin + way, end - back, end], 1)


blobs = st.lists(
    st.builds(
        blob,
        st.floats(-2, 16),
        st.floats(-2, 14),
        st.lists(st.floats(2, 7), min_size=3, max_size=6),
        st.floats(0, 6),
    ),
    min_size=1,
    max_size=3,
)
"""Contours whose features are larger than a pixel."""


def image_of(segments, size=SIZE, **options):
    return vf.rasterize(segments, size, **options).numpy()


def placed(text, size):
    """A text's contours in pixels."""
    placement = frame(text, size).numpy()
    return [s.numpy() @ placement[:, :2].T + placement[:, 2] for s in text.segments()]


def somewhere(name, letter, seed=0):
    """A letter at a random place of its font's design space, and not on an axis' kink."""
    text = vf.Text(name, letter)
    rng = np.random.default_rng([seed, ord(letter)])
    return text.at(theta=rng.uniform(*text.font.bounds)[None])


def batch_of(count=3):
    """The same two contours, at several places: (count, s, 4, 2) each, and as a list of singles."""
    shifts = np.random.default_rng(0).uniform(-3, 3, (count, 1, 1, 2))
    whole = [blob(5.3, 6.1, [3, 4, 5]) + shifts, blob(8.7, 5.2, [4, 3, 3, 4]) - shifts]
    return whole, [[contour[i] for contour in whole] for i in range(count)]


TURNED = np.array([[0.8, -0.3, 1.3], [0.4, 0.7, -0.6]])
SQUARE = rectangle(1, 1, 2, 2)


def misses(segments, size=SIZE):
    """The largest error of a pixel, the referee looking closely where it is large."""
    image = image_of(segments, size)
    assert image.shape == tuple(size)
    error = abs(image - scan(segments, *size))
    if error.max() > 0.02:
        chords, referee.CHORDS = referee.CHORDS, 512
        try:
            error = abs(image - scan(segments, *size, lines=512))
        finally:
            referee.CHORDS = chords
    return error.max()
