"""The time in which overlaps are resolved: ours against the paper's recipe in eager PyTorch.

The recipe minimises the energy of collision planes and a small StayClose by Levenberg–Marquardt
with a Jacobian from autograd, and finds the planes anew after every step. Ours includes the search
for the nearest free state, which the recipe does not have.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import product
from time import process_time
from typing import NamedTuple

import numpy as np
import torch
from torch import Tensor
from torch.autograd.functional import jacobian

import vfwidget as vf

from .recipe import levenberg_marquardt
from .sampled import Plane, Sampled
from .table import Row, milliseconds
from .timing import TURN

LIMIT = 60
"""Steps of the recipe, at most."""
STAY_CLOSE = 1e-3
"""Weight of the distance from the user's state, in square font units."""


class Scene(NamedTuple):
    """A text whose letters overlap each other, or polygons."""

    name: str
    text: vf.Text
    obstacles: list


def scenes() -> list[Scene]:
    """Two words that are set too tightly, and one under a bar."""
    tight = vf.Text("recursive", "NT", shared=False, offsets=[(0, 0), (-150, 0)])
    tracked = [(-60.0 * i, 0) for i in range(4)]
    hello = vf.Text("recursive", "ello", axes={"wght": 1000}, shared=False, offsets=tracked)
    word = vf.Text("recursive", "word", axes={"wght": 900, "slnt": -12}, shared=False)
    bar = [np.array([(1700.0, 560), (2600, 620), (2600, 660), (1700, 600)])]
    return [
        Scene('"NT"', tight, []),
        Scene('"ello"', hello, []),
        Scene("a word under artwork", word, bar),
    ]


class Recipe:
    """The paper's way out of overlaps."""

    def __init__(self, scene: Scene, forward: bool) -> None:
        self.word, self.forward = Sampled(scene.text, scene.obstacles), forward
        self.start = scene.text.theta
        self.offsets = torch.tensor(scene.text.place["offsets"])

    def controls(self, theta: Tensor) -> list[Tensor]:
        """The segments of each letter."""
        return self.word.controls(theta, self.offsets, line=True)

    def run(self) -> Tensor:
        """Θ at which no sample collides, or at which the recipe gets no farther."""
        theta = self.start
        for _ in range(LIMIT):
            planes = self.word.planes(self.controls(theta))
            if not planes:
                break
            new = self.step(theta, planes)
            done = float((new - theta).abs().max()) < 1e-6
            theta = new
            if done:
                break
        return theta

    def step(self, theta: Tensor, planes: list[Plane]) -> Tensor:
        """Θ after one step with these planes."""

        def residual(theta: Tensor) -> Tensor:
            away = math.sqrt(STAY_CLOSE) * (theta - self.start).flatten()
            return torch.cat([*self.word.depths(self.controls(theta), planes), away])

        def derivative(theta: Tensor) -> Tensor:
            mode = "forward-mode" if self.forward else "reverse-mode"
            matrix = jacobian(residual, theta, strategy=mode, vectorize=self.forward)
            return matrix.reshape(len(matrix), -1)

        def project(theta: Tensor) -> Tensor:
            return theta.clamp(self.word.lower, self.word.upper)

        return levenberg_marquardt(residual, derivative, project, theta, 1)[0]


def run(quick: bool) -> Iterator[Row]:
    """Each scene by ours and by both forms of the recipe, in turns; the least time counts."""
    for scene in scenes():
        recipes = [Recipe(scene, forward) for forward in (False, True)]
        least = np.full(3, math.inf)
        for _, who in product(range(2 if quick else 5), range(3)):
            end = process_time() + TURN
            while (begun := process_time()) < end:
                if who == 0:
                    found = vf.resolve_overlaps(scene.text, scene.obstacles)
                else:
                    theta = recipes[who - 1].run()
                least[who] = min(least[who], 1e3 * (process_time() - begun))
        left, away = zip(
            *(
                (sum(o.area for o in vf.overlaps(text, scene.obstacles)), distance(text, scene))
                for text in (found.text, scene.text.at(theta=theta))
            ),
            strict=True,
        )
        for who, mode in ((1, "reverse"), (2, "forward")):
            yield Row(
                benchmark="overlap",
                case=f"{scene.name}, nearest free state",
                ours=milliseconds(least[0]),
                baseline=f"recipe, {mode} {milliseconds(least[who])}",
                ratio=f"{least[who] / least[0]:.1f}×",
                notes=f"area left {left[0]:.2g} | {left[1]:.2g}, "
                f"distance {away[0]:.2f} | {away[1]:.2f}",
            )


def distance(text: vf.Text, scene: Scene) -> float:
    """How far Θ is from the user's, in normalized coordinates."""
    return float((text.theta - scene.text.theta).norm())
