"""A frame of a simulation: ours against the paper's recipe in eager PyTorch, on the same scenes.

The recipe follows Sec. 5.2 and 5.3 of the paper. A step minimises ‖Θ − Θ_m‖² (momentum),
‖Θ − Θ_rest‖² (elasticity) and the energy of collision planes by Levenberg–Marquardt, with a
Jacobian from autograd. Unknowns are the axes and the positions of the letters. Outlines are
sampled densely. For each point inside another shape, the closest point there and its normal define
a plane. Planes are found anew in every iteration of the solver, because frozen ones let letters
through. Reverse mode is PyTorch's default for a Jacobian; forward mode differentiates by the
unknowns.

Both sides compute the same number of frames of the same scene, in turns. The paper reports 5.3 ms
and 26 ms a step, on another machine (M1 Pro).
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

from .recipe import Letter, levenberg_marquardt
from .table import Row, milliseconds

SAMPLES = 8
"""Points on each segment."""
DT = 1 / 60
GRAVITY = -4000.0
STIFFNESS, COLLISION = 400.0, 1e4
"""Weights of elasticity, in 1/s², and of collisions; those of positions are 1."""
UNIT = 100.0
"""Font units that count as much as the whole range of an axis."""
LIMIT = 30
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

    def ours(self) -> vf.Animation:
        """Our simulation."""
        return vf.simulate(
            self.text,
            self.frames,
            DT,
            forces=(0, GRAVITY),
            obstacles=[FLOOR],
            positions=True,
            progress=False,
        )


class Recipe:
    """The paper's step."""

    def __init__(self, fall: Fall, forward: bool) -> None:
        text = fall.text
        self.letters = [Letter.of(glyph) for glyph in text.glyphs]
        self.segments = [torch.from_numpy(np.concatenate(g.contours.indices)) for g in text.glyphs]
        self.lower, self.upper = (torch.from_numpy(bound) for bound in text.font.bounds)
        self.axes = text.theta.shape
        offsets = [(g.x, g.y) for g in text.layout]
        self.start = torch.cat([text.theta.flatten() * UNIT, torch.tensor(offsets).flatten()])
        self.floor = torch.tensor(FLOOR, dtype=torch.float64)
        self.rest, self.forward = text.theta.flatten() * UNIT, forward
        t = (torch.arange(SAMPLES, dtype=torch.float64) + 0.5) / SAMPLES
        s = 1 - t
        self.blend = torch.stack([s**3, 3 * s * s * t, 3 * s * t * t, t**3], 1)
        self.slope = torch.stack(
            [-3 * s * s, 3 * s * s - 6 * s * t, 6 * s * t - 3 * t * t, 3 * t * t], 1
        )

    def parts(self, x: Tensor) -> tuple[Tensor, Tensor]:
        """Θ (l, n) and the origins of the letters (l, 2)."""
        count = self.axes.numel()
        theta = (x[:count] / UNIT).reshape(self.axes).clamp(self.lower, self.upper)
        return theta.expand(len(self.letters), -1), x[count:].reshape(-1, 2)

    def controls(self, x: Tensor) -> list[Tensor]:
        """The segments (s, 4, 2) of each letter."""
        theta, origins = self.parts(x)
        return [
            (letter.at(w)[:-1] + origin)[segments]
            for letter, w, origin, segments in zip(
                self.letters, theta, origins, self.segments, strict=True
            )
        ]

    def planes(self, x: Tensor) -> list[tuple[int, Tensor, int, Tensor, Tensor]]:
        """Colliding points: letter, indices, other letter or -1 for the floor, bases, normals."""
        controls = self.controls(x)
        samples = [torch.einsum("tk,skc->stc", self.blend, c).reshape(-1, 2) for c in controls]
        slopes = [torch.einsum("tk,skc->stc", self.slope, c).reshape(-1, 2) for c in controls]
        found = []
        for i, points in enumerate(samples):
            inside = (_winding(points, self.floor) != 0).nonzero()[:, 0]
            if len(inside):
                base = _nearest_on(self.floor, points[inside])
                way = base - points[inside]
                normal = way / way.norm(dim=1, keepdim=True).clamp_min(1e-9)
                found.append((i, inside, -1, base, normal))
            for j, others in enumerate(samples):
                box = (points >= others.min(0).values) & (points <= others.max(0).values)
                near = box.all(1).nonzero()[:, 0]
                if i == j or not len(near):
                    continue
                inside = near[_winding(points[near], others) != 0]
                if not len(inside):
                    continue
                nearest = torch.cdist(points[inside], others).argmin(1)
                normal = others[nearest] - points[inside]
                length = normal.norm(dim=1, keepdim=True)
                along = slopes[j][nearest]
                turned = torch.stack([along[:, 1], -along[:, 0]], 1)
                turned = turned / turned.norm(dim=1, keepdim=True).clamp_min(1e-9)
                found.append(
                    (i, inside, j, nearest, torch.where(length > 1e-9, normal / length, turned))
                )
        return found

    def step(self, x: Tensor, before: Tensor) -> Tensor:
        """The unknowns after a step from x, where they were ``before`` one step ago."""
        count = self.axes.numel()
        moved = 2 * x - before
        moved[count + 1 :: 2] += GRAVITY * DT**2
        root = math.sqrt(STIFFNESS) * DT

        def residual_for(planes: list[tuple[int, Tensor, int, Tensor, Tensor]]):
            def residual(x: Tensor) -> Tensor:
                controls = self.controls(x)
                points = [
                    torch.einsum("tk,skc->stc", self.blend, c).reshape(-1, 2) for c in controls
                ]
                parts = [x - moved, root * (x[:count] - self.rest)]
                for i, inside, j, base, normal in planes:
                    b = base if j < 0 else points[j][base]
                    depth = ((b - points[i][inside]) * normal).sum(1).clamp_min(0)
                    parts.append(math.sqrt(COLLISION) * depth)
                return torch.cat(parts)

            return residual

        def project(x: Tensor) -> Tensor:
            theta = (x[:count] / UNIT).reshape(self.axes).clamp(self.lower, self.upper)
            return torch.cat([theta.flatten() * UNIT, x[count:]])

        mode = "forward-mode" if self.forward else "reverse-mode"
        for _ in range(LIMIT):
            residual = residual_for(self.planes(x))

            def derivative(x: Tensor, residual=residual) -> Tensor:
                return jacobian(residual, x, strategy=mode, vectorize=self.forward)

            new, steps = levenberg_marquardt(residual, derivative, project, x, 1)
            done = float((new - x).abs().max()) < 1e-3
            x = new
            if done or not steps:
                break
        return x

    def run(self, frames: int) -> Tensor:
        """The unknowns after so many frames."""
        before = x = self.start
        for _ in range(frames):
            before, x = x, self.step(x, before)
        return x


def _nearest_on(corners: Tensor, points: Tensor) -> Tensor:
    """The nearest point on a polygon to each point."""
    along = corners.roll(-1, 0) - corners
    away = points[:, None] - corners
    part = ((away * along).sum(-1) / (along * along).sum(-1)).clamp(0, 1)
    there = corners + part[..., None] * along
    best = (there - points[:, None]).norm(dim=-1).argmin(1)
    return there[torch.arange(len(points)), best]


def _winding(points: Tensor, outline: Tensor) -> Tensor:
    """Whether points are inside a sampled outline: the winding number, rounded."""
    away = outline - points[:, None]
    following = away.roll(-1, 1)
    cross = away[..., 0] * following[..., 1] - away[..., 1] * following[..., 0]
    turn = torch.atan2(cross, (away * following).sum(-1)).sum(1)
    return (turn / (2 * math.pi)).round()


def run(quick: bool) -> Iterator[Row]:
    """Frames of falling letters, in turns with the recipe; then steps against letters."""
    rounds = 1 if quick else 3
    for fall in (Fall.of_o(20 if quick else 60), Fall.of_stack(3, 12 if quick else 40)):
        recipes = [Recipe(fall, forward) for forward in (False, True)]
        seconds = np.zeros((3, rounds))
        for turn in range(rounds):
            for who in range(3):
                begun = process_time()
                deepest = fall.ours() if who == 0 else recipes[who - 1].run(fall.frames)
                seconds[who, turn] = (process_time() - begun) / fall.frames
                if who == 0:
                    depth = float(deepest.penetration.max())
        least = seconds.min(1)
        for who, mode in ((1, "reverse"), (2, "forward")):
            yield Row(
                benchmark="motion",
                case=f"{fall.name}, {fall.frames} frames",
                ours=milliseconds(1e3 * least[0]),
                baseline=f"recipe, {mode} {milliseconds(1e3 * least[who])}",
                ratio=f"{least[who] / least[0]:.1f}×",
                notes=f"penetration {depth:.1g}; the paper's {fall.paper}, on an M1 Pro",
            )
    for letters in (1, 2, 4) if quick else (1, 2, 4, 6):
        fall = Fall.of_stack(letters, 20)
        begun = process_time()
        fall.ours()
        seconds = (process_time() - begun) / fall.frames
        yield Row(
            benchmark="motion",
            case=f"letters in a stack: {letters}",
            ours=milliseconds(1e3 * seconds),
            baseline="",
            ratio="",
            notes=f"{1 / seconds:.0f} frames a second",
        )
