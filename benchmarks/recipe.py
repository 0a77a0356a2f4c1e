"""The paper's own recipe for a drag, as Sec. 3–5.1 describe it; it is the baseline.

The recipe evaluates Eq. 1–3 on all control points in eager PyTorch with float64. The dragged point
follows from the four control points of its segment. The energy is
E(Θ) = ‖p(Θ, t) − x*‖² + λ ‖Θ − Θ_prev‖², minimised by Levenberg–Marquardt with a Jacobian from
autograd. Values out of range are clamped before the interpolation, and Θ is projected onto its
bounds after each update. Glyphs are unpacked in advance, as in the paper.

Where the paper leaves a choice open, the recipe gets the better alternative. The support function
of a region that ends at its peak is 1 there (as printed, φ is 0 at the end of an axis). The damping
follows the gain ratio, and a solve stops by the same limits as ours. Two forms are timed. The plain
form differentiates all of F by autograd. The trimmed form does so for the two rows of the dragged
point only, because the derivative of the regulariser is √λ I. Both take the same steps.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import torch
from torch import Tensor
from torch.autograd.functional import jacobian

import vfwidget as vf
from vfwidget.energy.solve import COST_FLOOR, LEAST_GAIN
from vfwidget.outline.cubics import bernstein
from vfwidget.outline.variation import merge_regions, selection

STEP_TOLERANCE = 1e-9
INITIAL_DAMPING = 1e-4
MAX_REJECTIONS = 40

Function: TypeAlias = Callable[[Tensor], Tensor]


@dataclass(frozen=True)
class Letter:
    """The tensors of a glyph, with the right side bearing point as an additional last point.

    The left side bearing point is the origin. Supports (m, n) are split into their rising and
    falling parts. ``idle`` marks axes that do not affect a delta set.
    """

    points: Tensor
    deltas: Tensor
    start: Tensor
    peak: Tensor
    end: Tensor
    rise: Tensor
    fall: Tensor
    closed: Tensor
    idle: Tensor

    @staticmethod
    def of(glyph: vf.Glyph) -> Letter:
        affine = glyph.affine
        support, (own, bearing) = merge_regions([affine.support, affine.advance_support])
        right = torch.zeros(1, 2, len(support), dtype=torch.float64)
        spread = selection(bearing, len(support))
        right[0, 0] = torch.from_numpy(affine.advance_deltas @ spread)
        outline = glyph.deltas @ torch.from_numpy(selection(own, len(support)))
        start, peak, end = torch.from_numpy(support).unbind(-1)
        return Letter(
            points=torch.cat([glyph.default, glyph.default.new_tensor([[affine.advance_base, 0]])]),
            deltas=torch.cat([outline, right]),
            start=start,
            peak=peak,
            end=end,
            rise=torch.where(peak > start, peak - start, 1.0),
            fall=torch.where(end > peak, end - peak, 1.0),
            closed=peak == end,
            idle=(peak == 0) | (start > peak) | (peak > end) | ((start < 0) & (end > 0)),
        )

    def scalars(self, w: Tensor) -> Tensor:
        """γ(w), (m,) (Eq. 2)."""
        rising = (self.start <= w) & ((w < self.peak) | (self.closed & (w == self.peak)))
        falling = (self.peak <= w) & (w < self.end)
        fall = torch.where(falling, (self.end - w) / self.fall, 0.0)
        phi = torch.where(rising, (w - self.start) / self.rise, fall)
        return torch.where(self.idle, 1.0, phi).prod(-1)

    def at(self, w: Tensor) -> Tensor:
        """Control points and right side bearing point at w, (k + 1, 2) (Eq. 1)."""
        return self.points + self.deltas @ self.scalars(w)


class Recipe:
    """Drags one point of a word; Θ is (1, n) if shared, else (l, n)."""

    def __init__(self, text: vf.Text, handle: vf.Handle, stay_close: float, trimmed: bool) -> None:
        self.letters = [Letter.of(glyph) for glyph in text.glyphs]
        self.lower, self.upper = (torch.from_numpy(bound) for bound in text.font.bounds)
        self.stay_close, self.trimmed = stay_close, trimmed
        before = sum(len(glyph.contours) for glyph in text.glyphs[: handle.glyph])
        segment = text.word.contours.indices[before + handle.contour][handle.segment]
        self.segment = torch.from_numpy(segment)
        self.weights = torch.from_numpy(bernstein(handle.t))

    def layout(self, theta: Tensor) -> Tensor:
        """All control points of the word, (K, 2) (Eq. 3)."""
        theta = theta.clamp(self.lower, self.upper).expand(len(self.letters), -1)
        pen = theta.new_zeros(2)
        placed = []
        for letter, w in zip(self.letters, theta, strict=True):
            points = letter.at(w)
            placed.append(points[:-1] + pen)
            pen = pen + points[-1]
        return torch.cat(placed)

    def point(self, theta: Tensor) -> Tensor:
        """The dragged point p(Θ, t), (2,)."""
        return self.weights @ self.layout(theta)[self.segment]

    def update(self, previous: Tensor, target: Tensor, limit: int) -> tuple[Tensor, int]:
        """Run one update of a drag; return Θ and the number of steps."""
        root = math.sqrt(self.stay_close)

        def residual(theta: Tensor) -> Tensor:
            away = root * (theta - previous).reshape(-1)
            return torch.cat([self.point(theta) - target, away])

        def derivative(theta: Tensor) -> Tensor:
            if not self.trimmed:
                return jacobian(residual, theta).reshape(-1, theta.numel())
            moves = jacobian(self.point, theta).reshape(2, -1)
            return torch.cat([moves, root * torch.eye(theta.numel(), dtype=theta.dtype)])

        def project(theta: Tensor) -> Tensor:
            return theta.clamp(self.lower, self.upper)

        return levenberg_marquardt(residual, derivative, project, previous, limit)


def levenberg_marquardt(
    residual: Function,
    derivative: Function,
    project: Function,
    theta: Tensor,
    limit: int,
    renew: Callable[[Tensor], None] | None = None,
    least_gain: float = LEAST_GAIN,
) -> tuple[Tensor, int]:
    """Minimise by dense Levenberg–Marquardt; steps are projected before they are judged.

    The residual may depend on what ``renew`` finds at Θ before each step.
    """
    damping, growth = 0.0, 2.0
    for iteration in range(limit):
        if renew is not None:
            renew(theta)
        if renew is not None or iteration == 0:
            r = residual(theta)
            cost = float(r @ r)
        if cost <= COST_FLOOR:
            return theta, iteration
        j = derivative(theta)
        normal, gradient = j.T @ j, j.T @ r
        damping = damping or INITIAL_DAMPING * float(normal.diagonal().max())
        eye = torch.eye(len(normal), dtype=normal.dtype)
        for _ in range(MAX_REJECTIONS):
            step = -torch.linalg.solve(normal + damping * eye, gradient)
            trial = project(theta + step.reshape(theta.shape))
            moved = (trial - theta).reshape(-1)
            short = float(moved.abs().max()) <= STEP_TOLERANCE * (1 + float(theta.abs().max()))
            if short:
                return theta, iteration
            r_trial = residual(trial)
            trial_cost = float(r_trial @ r_trial)
            promised = -float(2 * gradient @ moved + moved @ normal @ moved)
            gain = (cost - trial_cost) / promised if promised > 0 else -math.inf
            if gain > 1e-3 and trial_cost < cost:
                break
            damping *= growth
            growth *= 2
        else:
            return theta, iteration
        gained = cost - trial_cost
        damping *= max(0.1, 1 - (2 * min(gain, 1.5) - 1) ** 3)
        growth = 2.0
        theta, r, cost = trial, r_trial, trial_cost
        if gained <= least_gain:
            return theta, iteration + 1
    return theta, limit
