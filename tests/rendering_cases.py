"""The public text-rendering-tests that set variations, each compared by its outlines."""

from __future__ import annotations

import itertools
import json
import re
import warnings
from typing import Any

import fonts
import formats
import numpy as np
from referee import HarfBuzz

import vfwidget as vf

FILE = formats.CONFORMANCE / "text-rendering-tests.json"
CASES: list[dict[str, Any]] = json.loads(FILE.read_text("utf-8")) if FILE.is_file() else []
TOLERANCE = 2.0
"""Thousandths of an em; the cases are rounded to whole ones."""
SAMPLES = 9


def differences(case: dict[str, Any]) -> tuple[float, float]:
    """The greatest distance between the outlines, and the difference of the line's advance."""
    data = (formats.CONFORMANCE / "trt-fonts" / case["font"]).read_bytes()
    font = vf.load_font(data)
    tags = {axis.tag for axis in font.axes}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", vf.AxisWarning)
        w = font.normalize({tag: v for tag, v in case["variations"].items() if tag in tags})
    scale = 1000 / font.units_per_em
    referee = HarfBuzz(fonts.open_font(data))
    referee.font.set_variations(case["variations"])
    row = [font.glyph(glyph_id) for glyph_id in referee.glyph_ids(case["text"])]
    worst = 0.0
    for glyph, want in zip(row, case["glyphs"], strict=True):
        cubics = [s for contour in glyph.segments(w) for s in contour.numpy() * scale]
        points = np.concatenate([along(c) for c in cubics]) if cubics else np.zeros((0, 2))
        worst = max(worst, distance(points, shape_of_path(want["path"])))
    advance = sum(float(glyph.advance(w)) for glyph in row) * scale
    return worst, abs(advance - case["advance"])


def shape_of_path(path: str) -> np.ndarray:
    """Points along an SVG path of absolute M, L, Q and C, to compare outlines of other starts."""
    points: list[np.ndarray] = []
    here = start = np.zeros(2)
    for command, numbers in re.findall(r"([MLQCZ])([^MLQCZ]*)", path):
        values = np.array(re.findall(r"-?[\d.]+", numbers), dtype=float).reshape(-1, 2)
        if command == "M":
            here = start = values[0]
            continue
        controls = np.concatenate([[here], values if len(values) else [start]])
        points.append(along(controls))
        here = controls[-1]
    return np.concatenate(points) if points else np.zeros((0, 2))


def along(controls: np.ndarray) -> np.ndarray:
    """Points along a Bézier curve of any degree, by de Casteljau."""
    t = np.linspace(0, 1, SAMPLES)[:, None]
    layers = [np.broadcast_to(point, (SAMPLES, 2)) for point in controls]
    while len(layers) > 1:
        layers = [(1 - t) * a + t * b for a, b in itertools.pairwise(layers)]
    return layers[0]


def distance(one: np.ndarray, other: np.ndarray) -> float:
    """Hausdorff distance of two sets of points."""
    if not len(one) or not len(other):
        return 0.0 if len(one) == len(other) else np.inf
    apart = np.hypot(*(one[:, None] - other[None]).transpose(2, 0, 1))
    return float(max(apart.min(0).max(), apart.min(1).max()))
