"""Where a fit may begin: a cheap sweep of the design space over a small picture."""

from __future__ import annotations

import math

import numpy as np

from ..arrays import Array, BoolArray, IntArray
from ..errors import ImageError
from ..text import Text
from .images import basis
from .scene import Scene, State

SWEEP = 160
"""Places of the design space that are tried."""
APART = 0.2
"""How far apart two starts are, in normalized coordinates, so that the second is worth a try."""
CANVAS = 48
"""Pixels of the picture in which a candidate's ink is measured."""
MOST_TURN = math.radians(25)
MOST_COMPONENTS, SPECK = 6, 0.02
"""Of the ink: how many are looked at, and the share of a speck that moves no start."""
LONG = 1.5
"""How much longer than broad ink has to be for its direction to say how it is turned."""


def candidates(text: Text) -> Array:
    """Places spread over the design space, (SWEEP, parameters, n); all letters stand at one."""
    lower, upper = text.font.bounds
    named = [text.font.normalize(dict(i.axes)).numpy() for i in text.font.instances]
    first = np.stack([np.zeros_like(lower), *named])[: SWEEP // 3]
    spread = lower + (upper - lower) * _spread(SWEEP - len(first), len(lower))
    # An axis that moves nothing of a letter stays at its default there.
    return np.concatenate([first, spread])[:, None] * felt(text)


def felt(text: Text) -> BoolArray:
    """Which axes move anything, (parameters, n)."""
    word = text.word
    used = np.zeros((len(word.glyphs), len(word.regions.support)), dtype=bool)
    for letter, own in enumerate(zip(word.outline_regions, word.advance_regions, strict=True)):
        used[letter, np.concatenate(own)] = True
    by_letter = (used @ word.regions.one_hot.any(1)) > 0
    return by_letter.any(0, keepdims=True) if text.shared else by_letter


def _spread(count: int, dimensions: int) -> Array:
    """Points that fill the unit cube evenly, the same at every call (Sobol's sequence)."""
    import torch

    engine = torch.quasirandom.SobolEngine(dimensions, scramble=True, seed=0)
    return engine.draw(count, dtype=torch.float64).numpy()


def placements(text: Text, thetas: Array, ink: Array, factor: int, turn: bool) -> Array:
    """Where each candidate would have to stand to have its ink where the picture has, (B, 4).

    Middle, extent and, if asked for, direction of the ink are matched.

    Raises
    ------
    ImageError
        The text has no ink.
    """
    size = (CANVAS, CANVAS)
    scene = Scene(text, size)
    points = text.positions(text.point_set(), thetas)
    low, high = points.min((0, 1)), points.max((0, 1))
    scale = 0.9 * CANVAS / max(float((high - low).max()), 1.0)
    here = np.array([CANVAS / 2, CANVAS / 2, math.log(scale), 0.0])
    offset = (low + high) / 2 - scene.centre
    here[:2] -= scale * offset * [1, -1]
    own = scene.coverage(thetas, np.broadcast_to(here, (len(thetas), 4)))
    goal = _Moments(ink)
    found = []
    for image in own:
        moments = _Moments(image)
        ratio = goal.extent / moments.extent
        angle = 0.0
        if turn and min(goal.length, moments.length) > LONG:
            angle = (goal.direction - moments.direction + math.pi / 2) % math.pi - math.pi / 2
            angle = angle if abs(angle) < MOST_TURN else 0.0
        rotation = np.array(
            [[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]]
        )
        # From the text's middle to the middle of its ink, in the picture.
        arm = ratio * rotation @ (moments.centre - here[:2])
        place = (goal.centre - arm) * factor
        found.append([*place, math.log(scale * ratio * factor), angle])
    return np.array(found)


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


class _Moments:
    """Middle, extent and direction of an image's ink, in pixels."""

    def __init__(self, image: Array) -> None:
        total = float(image.sum())
        if total <= 0:
            raise ImageError("There is no ink to match: the text is blank, or far too small.")
        y, x = np.mgrid[: image.shape[0], : image.shape[1]] + 0.5
        self.centre = np.array([(image * x).sum(), (image * y).sum()]) / total
        dx, dy = x - self.centre[0], y - self.centre[1]
        xx, yy, xy = ((image * p).sum() / total for p in (dx * dx, dy * dy, dx * dy))
        self.extent = math.sqrt(xx + yy) or 1.0
        root = math.hypot((xx - yy) / 2, xy)
        large, small = (xx + yy) / 2 + root, (xx + yy) / 2 - root
        self.length = math.sqrt(large / max(small, 1e-9))
        self.direction = math.atan2(2 * xy, xx - yy) / 2


def rank(scene: Scene, thetas: Array, places: Array, image: Array, terms: int) -> Array:
    """How much of the picture each candidate leaves unexplained at best levels, (B,) in 0 … 1."""
    covered = scene.coverage(thetas, places)
    over = basis(*scene.shape, terms).reshape(-1, terms)
    directions = np.linalg.qr(over)[0]

    def beside_light(values: Array) -> Array:
        values = values.reshape(len(values), -1)
        return values - values @ directions @ directions.T

    own, goal = beside_light(covered), beside_light(image[None])[0]
    along = (own @ goal) ** 2 / np.maximum((own * own).sum(1), 1e-12)
    return 1 - along / max(float(goal @ goal), 1e-12)


def best_starts(states: list[State], unexplained: Array, count: int) -> list[State]:
    """The best states that are not near a better one."""
    chosen: list[State] = []
    for i in np.argsort(unexplained, kind="stable"):
        near = (np.abs(states[i].theta - other.theta).max() < APART for other in chosen)
        if not any(near):
            chosen.append(states[i])
        if len(chosen) == count:
            break
    return chosen
