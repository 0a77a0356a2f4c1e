"""The collision planes of Sec. 5.2 of the paper in eager PyTorch; they are part of the baseline.

Outlines and obstacles are sampled densely. For each point inside another shape, the closest sample
there and its normal define a plane, which is kept until the planes are found again.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import torch
from torch import Tensor

import vfwidget as vf

from .recipe import Letter

SAMPLES = 8
"""Points on each segment."""


class Plane(NamedTuple):
    """Points of one shape that are inside another one, with the closest points of that one.

    A shape is a letter, or -1 for an obstacle, which does not move. ``points`` and ``bases`` are
    indices of a letter's samples, or positions on an obstacle.
    """

    shape: int
    points: Tensor
    other: int
    bases: Tensor
    normals: Tensor


class Sampled:
    """A word whose letters have axes and origins, and polygons in its way.

    Parameters
    ----------
    text : Text
    obstacles : sequence of (m, 2) arrays
        Corners of polygons.
    """

    def __init__(self, text: vf.Text, obstacles: Sequence) -> None:
        self.letters = [Letter.of(glyph) for glyph in text.glyphs]
        self.segments = [torch.from_numpy(np.concatenate(g.contours.indices)) for g in text.glyphs]
        self.lower, self.upper = (torch.from_numpy(bound) for bound in text.font.bounds)
        corners = [torch.as_tensor(np.asarray(o), dtype=torch.float64) for o in obstacles]
        self.obstacles = [(_along(sides), sides) for sides in corners]
        t = (torch.arange(SAMPLES, dtype=torch.float64) + 0.5) / SAMPLES
        s = 1 - t
        self.blend = torch.stack([s**3, 3 * s * s * t, 3 * s * t * t, t**3], 1)
        self.slope = torch.stack(
            [-3 * s * s, 3 * s * s - 6 * s * t, 6 * s * t - 3 * t * t, 3 * t * t], 1
        )

    def controls(self, theta: Tensor, origins: Tensor, line: bool = False) -> list[Tensor]:
        """The segments (s, 4, 2) of each letter.

        ``origins`` (l, 2) are the letters' origins, or displacements from those of a line (Eq. 3).
        """
        theta = theta.clamp(self.lower, self.upper).expand(len(self.letters), -1)
        pen, controls = origins.new_zeros(2), []
        for letter, w, origin, segments in zip(
            self.letters, theta, origins, self.segments, strict=True
        ):
            points = letter.at(w)
            controls.append((points[:-1] + origin + pen)[segments])
            pen = pen + points[-1] if line else pen
        return controls

    def points(self, controls: Sequence[Tensor]) -> list[Tensor]:
        """The samples of each letter."""
        return [torch.einsum("tk,skc->stc", self.blend, c).reshape(-1, 2) for c in controls]

    def planes(self, controls: Sequence[Tensor]) -> list[Plane]:
        """The planes of all points that collide."""
        samples = self.points(controls)
        slopes = [torch.einsum("tk,skc->stc", self.slope, c).reshape(-1, 2) for c in controls]
        found = []
        for j, (others, along) in enumerate(zip(samples, slopes, strict=True)):
            for i, points in enumerate(samples):
                inside = _inside(points, others) if i != j else points.new_zeros(0).long()
                if len(inside):
                    found.append(Plane(i, inside, j, *_nearest(points[inside], others, along)))
            for obstacle, corners in self.obstacles:
                inside = _inside(obstacle, others)
                if len(inside):
                    points = obstacle[inside]
                    found.append(Plane(-1, points, j, *_nearest(points, others, along)))
                inside = _inside(others, corners)
                if len(inside):
                    base = _nearest_on(corners, others[inside])
                    way = base - others[inside]
                    normal = way / way.norm(dim=1, keepdim=True).clamp_min(1e-9)
                    found.append(Plane(j, inside, -1, base, normal))
        return found

    def depths(self, controls: Sequence[Tensor], planes: Sequence[Plane]) -> list[Tensor]:
        """How far points are beyond their planes, as in the paper's energy of collisions."""
        samples = self.points(controls)

        def positions(shape: int, which: Tensor) -> Tensor:
            return which if shape < 0 else samples[shape][which]

        return [
            ((positions(p.other, p.bases) - positions(p.shape, p.points)) * p.normals)
            .sum(1)
            .clamp_min(0)
            for p in planes
        ]


def _inside(points: Tensor, outline: Tensor) -> Tensor:
    """Indices of the points that are inside a sampled outline."""
    box = (points >= outline.min(0).values) & (points <= outline.max(0).values)
    near = box.all(1).nonzero()[:, 0]
    return near[_winding(points[near], outline) != 0] if len(near) else near


def _nearest(points: Tensor, others: Tensor, along: Tensor) -> tuple[Tensor, Tensor]:
    """The samples of a shape that are closest to points inside it, and unit normals there."""
    nearest = torch.cdist(points, others).argmin(1)
    normal = others[nearest] - points
    length = normal.norm(dim=1, keepdim=True)
    turned = torch.stack([along[nearest, 1], -along[nearest, 0]], 1)
    turned = turned / turned.norm(dim=1, keepdim=True).clamp_min(1e-9)
    return nearest, torch.where(length > 1e-9, normal / length, turned)


def _along(corners: Tensor) -> Tensor:
    """Samples on the sides of a polygon."""
    part = ((torch.arange(SAMPLES, dtype=torch.float64) + 0.5) / SAMPLES)[:, None, None]
    return (corners + part * (corners.roll(-1, 0) - corners)).reshape(-1, 2)


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
