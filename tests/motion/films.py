"""Animations for tests of exports."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import Any

import colour_fonts
import numpy as np
from fontTools.ttLib.tables.otTables import PaintFormat

import vfwidget as vf

BAR = np.array([[0.0, -40.0], [300.0, -40.0], [300.0, 0.0], [0.0, 0.0]])


loaded = functools.cache(vf.load_font)


def film(font: Any = "recursive", string: str = "AVog", frames: int = 31, **options: Any) -> Any:
    """Letters that change their weight one after the other, the second of which jumps and turns.

    A bar moves to the right below them.
    """
    options.setdefault("shared", False)
    text = vf.Text(loaded(font) if isinstance(font, str | Path) else font, string, **options)
    tags = [axis.tag for axis in text.font.axes]
    times = np.linspace(2, 3.5, frames)
    theta = np.repeat(text.theta.numpy()[None], frames, axis=0)
    phases = np.arange(theta.shape[1])
    theta[..., tags.index("wght")] = 0.5 - 0.5 * np.cos(4 * times[:, None] + phases)
    if "CRSV" in tags:  # glyphs of other shapes from the middle on
        theta[frames // 2 :, :, tags.index("CRSV")] = 1
    offsets = np.zeros((frames, len(text.glyphs), 2))
    rotations = np.zeros((frames, len(text.glyphs)))
    if len(text.glyphs) > 1:
        offsets[:, 1, 1] = 300 * np.abs(np.sin(3 * times))
        rotations[:, 1] = times - 2
    return vf.Animation(
        text,
        times,
        theta,
        offsets,
        rotations,
        scenery=[[_straight(BAR + np.array([200 * t, 0]))] for t in times],
    )


def _straight(corners: np.ndarray) -> np.ndarray:
    """A polygon as cubic segments (s, 4, 2)."""
    ends = np.roll(corners, -1, axis=0)
    return np.stack([corners + (ends - corners) * part for part in (0, 1 / 3, 2 / 3, 1)], 1)


def without_sweep(builder: Any) -> None:
    """Leave the sweep gradient, the reflected and the slanted one out, which Lottie lacks."""
    table = builder.font["COLR"].table
    del table.LayerList.Paint[3:]
    for record in table.BaseGlyphList.BaseGlyphPaintRecord:
        if record.Paint.Format == PaintFormat.PaintColrLayers:
            record.Paint.NumLayers = 3


def coloured(edit: Any = lambda builder: None) -> Any:
    """A plain letter, and one of several layers whose paint varies with the axes."""
    text = vf.Text(vf.load_font(colour_fonts.coloured(edit)), "ba", shared=False)
    theta = np.repeat(text.theta.numpy()[None], 5, axis=0)
    theta[:, :, 0] = np.linspace(0, 1, 5)[:, None]
    offsets = np.zeros((5, 2, 2))
    offsets[:, 1, 1] = np.linspace(0, 200, 5)
    rotations = np.linspace(0, 0.5, 5)[:, None] * [0, 1]
    return vf.Animation(text, np.linspace(0, 1, 5), theta, offsets, rotations)
