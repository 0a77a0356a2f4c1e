"""The locations at which a text is shaped to learn, and to check, where its letters stand."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arrays import Array, to_array
from ..errors import TextError
from ..font import Font
from ..font.settings import Box, Settings

MOST_TRIED = 2000
"""Random locations among which those in a setting are found where axes move others."""
CHECKS, CHECKS_BY_EXTENTS = 3, 200
"""Locations at which a fitted layout is compared with HarfBuzz."""
GRID = 16384
"""HarfBuzz rounds normalized coordinates to 1/16384, so text is shaped at multiples of that."""


def locations_in(
    font: Font, settings: Settings, index: int, support: Array, rng: np.random.Generator
) -> tuple[Array, Array]:
    """Locations in a setting: some to choose from for shaping, and a few more for comparison."""
    by_extents = settings.rows[index].by_extents
    checks = CHECKS_BY_EXTENTS if by_extents else CHECKS
    peaks, count = support[:, :, 1], len(support) + 8
    if not font.moves_axes:
        boxes = settings.boxes(index)
        within = [_on_grid(peaks.clip(*box), box) for box in boxes]
        random = _random_locations(boxes, count + checks, rng)
        fresh = random[:checks]
        if by_extents:
            # The extreme points differ most where axes are at their ends.
            fresh = np.concatenate([fresh, *within, _at_ends(boxes, checks, rng)])
        return np.concatenate([*within, random[checks:]]), fresh
    # The boxes are in other coordinates than the locations, so locations are tried.
    whole = font.bounds
    tried = _on_grid(rng.uniform(*whole, (MOST_TRIED, len(whole[0]))), whole)
    tried = np.concatenate(
        [tried, _on_grid(peaks.clip(*whole), whole), np.zeros((1, len(whole[0])))]
    )
    inside = settings.row_at(final(font, tried)) == index
    found = tried[inside][: 4 * count + checks]
    if not len(found):
        raise TextError("No location was found at which the text has some of its glyphs.")
    return found, found[:checks]


def final(font: Font, w: Array) -> Array:
    """The coordinates at which the font's regions apply, in the shape of w (..., n)."""
    return to_array(font.final_coordinates(w)) if font.moves_axes else w


def _random_locations(boxes: Sequence[Box], count: int, rng: np.random.Generator) -> Array:
    """Random locations in a setting, (count, n), each box in its turn."""
    turns = [boxes[i % len(boxes)] for i in range(count)]
    return np.array([_on_grid(rng.uniform(*box), box) for box in turns])


def _at_ends(boxes: Sequence[Box], count: int, rng: np.random.Generator) -> Array:
    """Random locations in a setting, (count, n), at which half of the axes are at an end."""
    turns = [boxes[i % len(boxes)] for i in range(count)]
    return np.array(
        [
            _on_grid(np.where(rng.random(len(low)) < 0.5, rng.uniform(low, high), end), (low, high))
            for low, high in turns
            for end in [np.where(rng.random(len(low)) < 0.5, low, high)]
        ]
    )


def _on_grid(w: Array, box: Box) -> Array:
    """The nearest coordinates inside a box that HarfBuzz does not round."""
    lower, upper = (np.ceil(box[0] * GRID), np.floor(box[1] * GRID))
    return np.round(w * GRID).clip(lower, upper) / GRID
