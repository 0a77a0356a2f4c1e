"""A frame of a simulation: ours against the paper's recipe in eager PyTorch, on the same scenes.

The recipe follows Sec. 5.2 and 5.3 of the paper. A step minimises ‖Θ − Θ_m‖² (momentum),
‖Θ − Θ_rest‖² (elasticity) and the energy of collision planes by Levenberg–Marquardt, with a
Jacobian from autograd. Unknowns are the axes and the positions of the letters. Outlines are
sampled densely. For each point inside another shape, the closest point there and its normal define
a plane. Planes are found anew in every iteration of the solver, because frozen ones let letters
through. Reverse mode is PyTorch's default for a Jacobian; forward mode differentiates by the
unknowns.

The paper states neither the start nor the end of a solve, nor the mass of an axis. The solve of the
recipe starts from Θ_m, which is the solution in free flight. It keeps its damping from iteration to
iteration, and ends when an iteration lowers the energy by less than ours has to, or after 30
iterations. The axes have the masses that they have in our simulation. Both sides take one step a
frame; ours takes shorter ones if a letter might pass through another one unseen.

Both sides compute the same number of frames of the same scene, in turns: ours once as the recipe,
without friction, restitution and damping, and once with all three. The paper reports 5.3 ms and
26 ms a step, on another machine (M1 Pro).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from time import process_time

import numpy as np
import torch
from torch import Tensor
from torch.autograd.functional import jacobian

import vfwidget as vf
from vfwidget.motion.body import Body
from vfwidget.motion.warm import TOLERANCES

from .recipe import levenberg_marquardt
from .sampled import Plane, Sampled
from .table import Row, milliseconds

DT = 1 / 60
GRAVITY = -4000.0
STIFFNESS, COLLISION = 400.0, 1e4
"""Weights of elasticity, in 1/s², and of collisions; those of positions are 1."""
LIMIT = 30
SAME = {"restitution": 0.0, "friction": 0.0, "damping": 0.0}
"""The physics of the recipe, which has none of the three."""
FLOOR = [(-3000.0, -600.0), (5000.0, -600.0), (5000.0, 0.0), (-3000.0, 0.0)]


@dataclass(frozen=True)
class Fall:
    """Letters above a floor."""

    name: str
    text: vf.Text
    frames: int
    paper: str

    @staticmethod
    def of_o(frames: int) -> Fall:
        text = vf.Text("recursive", "O", offsets=[(0, 200)])
        return Fall('"O" on a floor', text, frames, "5.3 ms")

    @staticmethod
    def of_stack(letters: int, frames: int) -> Fall:
        text = vf.Text("recursive", "HEOHEO"[:letters], shared=False)
        places = [(-g.x + 40 * (-1) ** i, 60 + 760 * i) for i, g in enumerate(text.layout)]
        return Fall(f"a stack of {letters}", text.at(offsets=places), frames, "26 ms")

    def ours(self, **options: float) -> vf.Animation:
        """Our simulation."""
        return vf.simulate(
            self.text,
            self.frames,
            DT,
            forces=(0, GRAVITY),
            obstacles=[FLOOR],
            positions=True,
            progress=False,
            **options,
        )

    def seconds(self, **options: float) -> tuple[float, float]:
        """Processor time of a frame of ours, and the deepest contact of all frames."""
        begun = process_time()
        made = self.ours(**options)
        return (process_time() - begun) / self.frames, float(made.penetration.max())


class Recipe:
    """The paper's step."""

    def __init__(self, fall: Fall, forward: bool) -> None:
        text = fall.text
        self.word = Sampled(text, [FLOOR])
        self.axes, self.forward = text.theta.shape, forward
        # Axes are measured by the motion of the control points, so that both sides have one mass.
        self.unit = torch.from_numpy(Body(text, np.ones(len(text.glyphs))).inertia).sqrt().flatten()
        self.rest = text.theta.flatten() * self.unit
        offsets = [(g.x, g.y) for g in text.layout]
        self.start = torch.cat([self.rest, torch.tensor(offsets).flatten()])

    def parts(self, x: Tensor) -> tuple[Tensor, Tensor]:
        """Θ and the origins of the letters (l, 2)."""
        count = self.axes.numel()
        return (x[:count] / self.unit).reshape(self.axes), x[count:].reshape(-1, 2)

    def step(self, x: Tensor, before: Tensor) -> Tensor:
        """The unknowns after a step from x, where they were ``before`` one step ago."""
        count = self.axes.numel()
        moved = 2 * x - before
        moved[count + 1 :: 2] += GRAVITY * DT**2
        root = math.sqrt(STIFFNESS) * DT
        planes: list[Plane] = []

        def renew(x: Tensor) -> None:
            planes[:] = self.word.planes(self.word.controls(*self.parts(x)))

        def residual(x: Tensor) -> Tensor:
            depths = self.word.depths(self.word.controls(*self.parts(x)), planes)
            collisions = [math.sqrt(COLLISION) * depth for depth in depths]
            return torch.cat([x - moved, root * (x[:count] - self.rest), *collisions])

        def derivative(x: Tensor) -> Tensor:
            mode = "forward-mode" if self.forward else "reverse-mode"
            return jacobian(residual, x, strategy=mode, vectorize=self.forward)

        def project(x: Tensor) -> Tensor:
            theta = self.parts(x)[0].clamp(self.word.lower, self.word.upper)
            return torch.cat([theta.flatten() * self.unit, x[count:]])

        least = TOLERANCES.absolute_cost
        start = project(moved)
        return levenberg_marquardt(residual, derivative, project, start, LIMIT, renew, least)[0]

    def run(self, frames: int) -> Tensor:
        """The unknowns after so many frames."""
        before = x = self.start
        for _ in range(frames):
            before, x = x, self.step(x, before)
        return x


def run(quick: bool) -> Iterator[Row]:
    """Frames of falling letters, in turns with the recipe; then steps against letters."""
    rounds = 1 if quick else 3
    for fall in (Fall.of_o(60), Fall.of_stack(3, 12 if quick else 40)):
        recipes = [Recipe(fall, forward) for forward in (False, True)]
        # The first use of a derivative in forward mode takes seconds, so one round is not counted.
        seconds, depths = np.zeros((4, 1 + rounds)), np.zeros((2, 1 + rounds))
        for turn in range(1 + rounds):
            for who, options in enumerate((SAME, {})):
                seconds[who, turn], depths[who, turn] = fall.seconds(**options)
            for who, recipe in enumerate(recipes, start=2):
                begun = process_time()
                recipe.run(fall.frames)
                seconds[who, turn] = (process_time() - begun) / fall.frames
        same, whole, *theirs = seconds[:, 1:].min(1)
        for ours, physics, depth in (
            (same, "the same physics", depths[0].max()),
            (whole, "friction and bounces", depths[1].max()),
        ):
            for mode, least in zip(("reverse", "forward"), theirs, strict=True):
                yield Row(
                    benchmark="motion",
                    case=f"{fall.name}, {physics}",
                    ours=milliseconds(1e3 * ours),
                    baseline=f"recipe, {mode} {milliseconds(1e3 * least)}",
                    ratio=f"{least / ours:.1f}×",
                    notes=f"penetration {depth:.1g}; the paper's {fall.paper}, on an M1 Pro",
                )
    for letters in (1, 2, 4) if quick else (1, 2, 4, 6):
        seconds_each, _ = Fall.of_stack(letters, 20).seconds()
        yield Row(
            benchmark="motion",
            case=f"letters in a stack: {letters}",
            ours=milliseconds(1e3 * seconds_each),
            baseline="",
            ratio="",
            notes=f"{1 / seconds_each:.0f} frames a second",
        )
