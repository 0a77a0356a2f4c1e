"""Where a fit may begin: a coarse search of the design space on a small picture."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arrays import Array, ArrayLike, BoolArray, IntArray
from ..font.settings import Box
from ..text import Text
from .images import basis
from .scene import Scene, State, by_glyphs

LOCATIONS = 160
"""Locations of the design space that are tried."""
IN_BOX, MOST_BOXES = 16, 10
"""Locations that are tried in each box with other glyphs than at the default, in so many boxes."""
MOST_AROUND = 16
"""Boxes with other glyphs that a match is continued in."""
APART = 0.2
"""How far apart two starts are, in normalized coordinates, so that the second is worth a try."""
MOST_COMPONENTS, SPECK = 6, 0.02
"""Of the ink: how many are looked at, and the share of a speck that moves no start."""


def candidates(text: Text) -> Array:
    """Locations spread over the design space, (B, parameters, n), the same for all letters.

    There are ``LOCATIONS`` of them, and more in each box in which the text has other glyphs.
    """
    lower, upper = text.font.bounds
    named = [text.font.normalize(dict(i.axes)).numpy() for i in text.font.instances]
    first = np.stack([np.zeros_like(lower), *named])[: LOCATIONS // 3]
    spread = lower + (upper - lower) * _spread(LOCATIONS - len(first), len(lower))
    settings = text.composition.settings
    boxes = [box for row in range(1, len(settings.rows)) for box in settings.boxes(row)]
    within = [low + (high - low) * _spread(IN_BOX, len(low)) for low, high in boxes[:MOST_BOXES]]
    thetas = np.repeat(
        np.concatenate([first, spread, *within])[:, None], text.composition.parameters, axis=1
    )
    for found, at in by_glyphs(text, thetas):
        thetas[at] = without_idle(found, thetas[at])
    return thetas


def without_idle(text: Text, thetas: Array) -> Array:
    """Θ (B, parameters, n) with axes that move nothing as near to their default as they can be.

    Such an axis may still choose the glyphs, so it stays in the box in which they are these.
    """
    boxes = np.array([text.composition.bounds_at(theta) for theta in thetas])
    return np.where(moving_axes(text), thetas, np.clip(0.0, boxes[:, 0], boxes[:, 1]))


def boxes_around(text: Text) -> list[tuple[int, Box]]:
    """For each letter the boxes of the design space that it is not in, the nearest ones first."""
    found = []
    for letter, w in enumerate(text.coordinates):
        for low, high in text.composition.settings.all_boxes:
            distance = float(np.linalg.norm(w.clip(low, high) - w))
            if distance > 0:
                found.append((distance, letter, (low, high)))
    found.sort(key=lambda one: one[0])
    return [(letter, box) for _, letter, box in found[:MOST_AROUND]]


def moving_axes(text: Text) -> BoolArray:
    """Which axes move a point, (parameters, n)."""
    by_letter = np.array(
        [
            [len(a) + len(b) > 0 for a, b in zip(outline, advance, strict=True)]
            for outline, advance in (
                (glyph.outline.breakpoints, glyph.advance_width.breakpoints)
                for glyph in text.word.glyphs
            )
        ]
    )
    return np.asarray(by_letter.any(0, keepdims=True) if text.shared else by_letter)


def settled(text: Text, theta: Array) -> Array:
    """Θ with the axes that move nothing where the text has them, if that changes no glyph.

    A fit may come from elsewhere, and would leave such an axis at any value.
    """
    here = text.moved(theta)
    there = text.moved(np.where(moving_axes(here), theta, text.coordinates))
    points = [one.point_set().positions(one.place) for one in (here, there)]
    return there.coordinates if np.array_equal(*points) else theta


def _spread(count: int, dimensions: int) -> Array:
    """Points that fill the unit cube evenly, the same at every call (Sobol's sequence)."""
    import torch

    engine = torch.quasirandom.SobolEngine(dimensions, scramble=True, seed=0)
    return engine.draw(count, dtype=torch.float64).numpy()


def readings(ink: Array) -> list[Array]:
    """What else of an image's ink (H, W) may be the text, if not all of it.

    Stains, and what else stands beside a text, are mostly not connected with it: so the ink
    without any one of its large components, without those that touch the border, or only the
    largest.
    """
    labels = _components(ink > 0)
    amounts = np.bincount(labels.ravel(), ink.ravel())
    large = np.argsort(-amounts)[:MOST_COMPONENTS]
    large = large[amounts[large] > SPECK * ink.sum()]
    border = np.concatenate([labels[0], labels[-1], labels[:, 0], labels[:, -1]])
    without = [*large[:, None], np.unique(border), np.delete(np.arange(len(amounts)), large[0])]
    kept = (np.where(np.isin(labels, left_out), 0.0, ink) for left_out in without)
    found = {one.tobytes(): one for one in kept if one.any()}
    found.pop(ink.tobytes(), None)
    return list(found.values())


def _components(mask: BoolArray) -> IntArray:
    """A number for each connected component, corners included, and 0 where nothing is, (H, W)."""
    labels = np.where(mask, np.arange(1, mask.size + 1).reshape(mask.shape), 0)
    while True:
        around = np.pad(labels, 1)
        rows = np.maximum(np.maximum(around[:-2], around[1:-1]), around[2:])
        grown = np.maximum(np.maximum(rows[:, :-2], rows[:, 1:-1]), rows[:, 2:]) * mask
        if np.array_equal(grown, labels):
            return np.unique(labels, return_inverse=True)[1].reshape(mask.shape)
        labels = grown


def rank(scene: Scene, thetas: Array, places: Array, image: Array, terms: int) -> Array:
    """The share of the picture that each candidate leaves at the best levels, (B,) in 0 … 1."""
    covered = scene.coverage(thetas, places)
    over = basis(*scene.shape, terms).reshape(-1, terms)
    directions = np.linalg.qr(over)[0]

    def beside_light(values: Array) -> Array:
        values = values.reshape(len(values), -1)
        return values - values @ directions @ directions.T

    own, goal = beside_light(covered), beside_light(image[None])[0]
    along = (own @ goal) ** 2 / np.maximum((own * own).sum(1), 1e-12)
    return 1 - along / max(float(goal @ goal), 1e-12)


def best_apart(text: Text, states: Sequence[State], losses: ArrayLike, count: int) -> list[int]:
    """The indices of the best states, none of which is near a better one with the same glyphs."""
    words = [text.composition.word_at(state.theta) for state in states]
    chosen: list[int] = []
    for i in np.argsort(losses, kind="stable").tolist():
        alike = (states[j].theta for j in chosen if words[j] is words[i])
        if all(np.abs(states[i].theta - theta).max() >= APART for theta in alike):
            chosen.append(i)
        if len(chosen) == count:
            break
    return chosen
