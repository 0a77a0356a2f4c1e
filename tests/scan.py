"""An independent rasteriser by scanlines: nonzero fill, exact along x, many lines per pixel.

It shares nothing with :mod:`vfwidget.raster`: cubics are flattened to many chords, and every
scanline's crossings are sorted and counted.
"""

from __future__ import annotations

import numpy as np

CHORDS = 64


def scan(contours, height: int, width: int, lines: int = 64):
    """Coverage (H, W) of closed contours (s, 4, 2) in pixels, y down."""
    t = np.linspace(0, 1, CHORDS + 1)[:, None]
    weights = np.concatenate([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3], 1)
    chords = [np.asarray(c, float).reshape(-1, 4, 2) for c in contours]
    points = np.concatenate([np.einsum("tj,sjd->std", weights, c) for c in chords])
    a, b = points[:, :-1].reshape(-1, 2), points[:, 1:].reshape(-1, 2)
    # Scanline i lies at (i + ½) / lines.
    low, high = (
        np.minimum(a[:, 1], b[:, 1]) * lines - 0.5,
        np.maximum(a[:, 1], b[:, 1]) * lines - 0.5,
    )
    first = np.clip(np.ceil(low), 0, None).astype(int)
    last = np.clip(np.ceil(high), None, height * lines).astype(int)
    count = np.clip(last - first, 0, None)
    chord = np.repeat(np.arange(len(a)), count)
    line = first[chord] + np.arange(count.sum()) - (count.cumsum() - count)[chord]
    y = (line + 0.5) / lines
    part = (y - a[chord, 1]) / (b[chord, 1] - a[chord, 1])
    x = a[chord, 0] + part * (b[chord, 0] - a[chord, 0])
    turn = np.sign(b[chord, 1] - a[chord, 1])
    order = np.lexsort((x, line))
    line, x, turn = line[order], np.clip(x[order], 0, width), turn[order]
    # Every line's turns come to nothing, so one sum serves all lines.
    winding = np.round(turn.cumsum()).astype(int)
    before = np.concatenate([[0], winding[:-1]])
    change = (winding != 0).astype(float) - (before != 0)
    column = np.minimum(np.floor(x), width - 1).astype(int)
    image = np.zeros((height, width + 1))
    np.add.at(image, (line // lines, column), change * (column + 1 - x))
    np.add.at(image, (line // lines, column + 1), change * (x - column))
    return image.cumsum(1)[:, :-1] / lines
