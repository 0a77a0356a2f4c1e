"""Fit a letter to a picture: ours against the paper's recipe, 100 steps of Adam with diffvg.

Both start at the default and know the position of the letter. Only a few steps of the recipe are
timed, because all its steps take the same time.
"""

from __future__ import annotations

from collections.abc import Iterator
from importlib.util import find_spec
from time import perf_counter

import numpy as np
import torch

import vfwidget as vf
from vfwidget.raster import frame

from .table import Row, milliseconds

CASES = (("afacad-flux", "A", {"wght": 700}), ("recursive", "R", {"wght": 700, "CASL": 0.7}))
SIZES = ((256, 256), (512, 576), (640, 640))
STEPS, TIMED = 100, 4
LEARNING_RATE = 0.03
SEEN = 0.01
"""Standard deviation below which the picture determines an axis."""


class Recipe:
    """Minimises the squared difference of two pictures over Θ with Adam (Sec. 5.4)."""

    def __init__(self, text: vf.Text, goal: torch.Tensor, backend: str) -> None:
        self.text, self.goal, self.backend = text, goal, backend
        self.size = (goal.shape[0], goal.shape[1])
        self.placement = frame(text, self.size)
        self.lower, self.upper = (torch.from_numpy(side) for side in text.font.bounds)
        self.theta = text.theta.clone().requires_grad_()
        self.optimizer = torch.optim.Adam([self.theta], lr=LEARNING_RATE)

    def step(self) -> None:
        """Take one step of Adam and project Θ onto its bounds."""
        segments = self.text.segments(self.theta)
        image = vf.rasterize(segments, self.size, self.placement, backend=self.backend)
        self.optimizer.zero_grad()
        ((image - self.goal) ** 2).mean().backward()
        self.optimizer.step()
        with torch.no_grad():
            self.theta.clamp_(self.lower, self.upper)


def run(quick: bool) -> Iterator[Row]:
    """Yield a line for each letter and size."""
    for name, letter, axes in CASES:
        for size in SIZES[:1] if quick else SIZES:
            yield _row(vf.Text(name, letter), axes, size, rounds=2 if quick else 5)


def _row(text: vf.Text, axes: dict[str, float], size: tuple[int, int], rounds: int) -> Row:
    goal = vf.rasterize(text.at(axes=axes), size, frame(text, size))
    picture, want = 1 - goal.numpy(), text.at(axes=axes).coordinates
    placement = frame(text, size)
    backend = "diffvg" if find_spec("pydiffvg") else "exact"
    recipe = Recipe(text, goal, backend)
    ours, theirs = [], []
    for turn in range(rounds + 1):
        times = []
        for _ in range(TIMED if turn else 1):
            begun = perf_counter()
            recipe.step()
            times.append(perf_counter() - begun)
        for _ in range(3):
            begun = perf_counter()
            found = vf.match(
                picture,
                text.string,
                text.font,
                axes={},
                placement=placement,
                fit=("background",),
                background="even",
                loss="linear",
                resolution=max(size),
                progress=False,
            )
            if turn:
                ours.append(perf_counter() - begun)
        if turn:
            theirs.append(float(np.median(times)) * STEPS)
    seen = found.outcome.deviation < SEEN
    miss = abs(found.text.coordinates - want)[seen].max()
    ratios = np.array(theirs) / np.median(ours)
    return Row(
        benchmark="fit",
        case=f"{text.font.family_name} {text.string}, {size[0]} × {size[1]}",
        ours=milliseconds(1e3 * float(np.median(ours))),
        baseline=f"{backend} + Adam {np.median(theirs):.1f} s",
        ratio=f"{np.median(ratios):.0f}× ({ratios.min():.0f}–{ratios.max():.0f})",
        notes=f"{len(found.history)} steps, off by {miss:.1g} where seen; Adam {STEPS} steps",
    )
