"""A simulated user study: reach a given shape by dragging and by sliders (Appendix A).

The task is to bring a letter from the default to a random instance of its font. It is done when the
root mean square distance of the outlines is at most 1 % of the em. The first simulated user drags
the outline point that is farthest from its goal to its goal, as the editor allows. The second moves
sliders, always the one that helps most and to its best value, which is better than a person could
do. The study counts drags and slider moves. The policies differ in the points dragged before:

pins
    A point that has reached its goal is pinned. If a point does not reach it, all are unpinned.
no pins
    No point is pinned.
kept targets
    Every earlier point keeps its target, like the dragged point. The editor does not offer this.
shaky pins
    Like pins, but every drag ends 0.2 % of the em beside its goal, or one pixel for a letter of
    500 pixels. The pins are then slightly wrong and may conflict. Only some goals are tried.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

import vfwidget as vf
from vfwidget.view.drag import CALM, RELEASE_ITERATIONS, RESTARTS

from .table import Row
from .timing import Array, Spread

GLYPHS = "aRg&8"
GOALS = 20
"""Goals for each glyph of each font."""
PER_SEGMENT = 4
NEAR = 0.01
"""Root mean square distance, in em, at which the goal counts as reached."""
VISIBLE = 0.002
"""Smallest distance, in em, that a person can see and aim at."""
DRAGS, MOVES = 2, 10
"""Drags and slider moves per axis of the font, before the user gives up."""


class Outline:
    """Dense points of the outline of a letter, for comparison with another outline."""

    def __init__(self, text: vf.Text) -> None:
        self.text = text
        self.em = text.font.units_per_em
        self.handles = [
            text.handle(0, contour, segment, i / PER_SEGMENT)
            for contour, segments in enumerate(text.glyphs[0].contours)
            for segment in range(segments)
            for i in range(PER_SEGMENT)
        ]
        self._points = text.point_set(self.handles)
        # The outline is affine in its scalars, so their difference determines the distance.
        deltas = self._points.deltas.reshape(2 * len(self.handles), -1)
        _, triangle = np.linalg.qr(deltas)
        self._root = triangle.T / (self.em * np.sqrt(len(self.handles)))

    def places(self, theta: Array) -> Array:
        """Positions of the points at Θ (1, n), (p, 2)."""
        return self.text.positions(self._points, theta)

    def difference(self, theta: Array, goal: Array) -> Array:
        """Vectors (..., r) whose length is the root mean square distance of two outlines, in em."""
        scalars = self.text.word.regions.scalars
        return (scalars(theta) - scalars(goal))[..., 0, :] @ self._root

    def is_near(self, theta: Array, goal: Array) -> bool:
        """Whether the outline at Θ is near enough to the goal."""
        return bool(np.linalg.norm(self.difference(theta, goal)) <= NEAR)


@dataclass(frozen=True)
class Policy:
    """How a simulated user treats the points dragged before.

    ``hold`` makes a term from a handle and its goal. With ``unpins``, only points that reached
    their goal are held, and all are released if one does not. Drags miss their goal by ``shakes``
    em. Of every ``every`` goals, one is tried.
    """

    name: str
    hold: Callable[[vf.Handle, Array], vf.Term] | None = None
    unpins: bool = False
    shakes: float = 0.0
    every: int = 1


def _pin(handle: vf.Handle, place: Array) -> vf.Term:
    """Pin a point at its current position, as the editor does."""
    return vf.Pin(handle)


POLICIES = (
    Policy("pins", _pin, unpins=True),
    Policy("no pins"),
    Policy("kept targets", vf.Target),
    Policy("shaky pins", _pin, unpins=True, shakes=VISIBLE, every=4),
)


def drags(outline: Outline, goal: Array, policy: Policy, hand: np.random.Generator) -> float:
    """Count the drags to the goal; infinite if the user gives up."""
    text, em, wanted = outline.text, outline.em, outline.places(goal)
    held: dict[int, vf.Term] = {}
    for count in range(DRAGS * len(text.font.axes) + 1):
        theta = text.theta.numpy()
        if outline.is_near(theta, goal):
            return count
        worst = int(np.hypot(*(wanted - outline.places(theta)).T).argmax())
        aim = wanted[worst] + hand.normal(0, policy.shakes * em, 2)
        others = [term for i, term in held.items() if i != worst]
        text, miss = _release(text, vf.Target(outline.handles[worst], aim), others)
        if policy.unpins and miss > VISIBLE * em:
            held.clear()
        elif policy.hold:
            held[worst] = policy.hold(outline.handles[worst], aim)
    return np.inf


def _release(text: vf.Text, target: vf.Target, others: list[vf.Term]) -> tuple[vf.Text, float]:
    """Solve as the editor does on release; return the text and the distance to the pointer."""
    calm = vf.StayClose((CALM * text.font.units_per_em) ** 2)
    solution = vf.solve(
        text, [target, calm, *others], max_iterations=RELEASE_ITERATIONS, restarts=RESTARTS
    )
    return solution.text, solution.misses[0]


def slider_moves(outline: Outline, goal: Array) -> float:
    """Count the moves of single sliders to the goal; infinite if the user gives up.

    Between two kinks the outline is affine in an axis, so the best value of the axis is exact.
    """
    theta = outline.text.theta.numpy()
    for count in range(MOVES * theta.size + 1):
        if outline.is_near(theta, goal):
            return count
        low, high = _pieces(outline.text, theta)
        start, end = outline.difference(low, goal), outline.difference(high, goal)
        along = end - start
        length = (along**2).sum(-1)
        part = np.clip(-(start * along).sum(-1) / np.where(length > 0, length, 1.0), 0, 1)[:, None]
        best = np.linalg.norm(start + part * along, axis=-1).argmin()
        theta = low[best] + part[best] * (high[best] - low[best])
    return np.inf


def _pieces(text: vf.Text, theta: Array) -> tuple[Array, Array]:
    """Both ends (c, 1, n) of every interval between kinks along every axis through Θ."""
    lows, highs = [], []
    for axis, (lower, upper) in enumerate(zip(*text.font.bounds, strict=True)):
        kinks = text.breakpoints[axis]
        stops = [lower, *kinks[(kinks > lower) & (kinks < upper)], upper]
        places = np.repeat(theta[None], len(stops), 0)
        places[:, 0, axis] = stops
        lows.append(places[:-1])
        highs.append(places[1:])
    return np.concatenate(lows), np.concatenate(highs)


def run(quick: bool) -> Iterator[Row]:
    """Compare pins with sliders and with the other policies, for each font and for all."""
    counts = []
    for name in vf.bundled_fonts():
        counts.append(study(name, GLYPHS, 2 if quick else GOALS))
        yield from _rows(name, counts[-1])
    yield from _rows("all fonts", np.concatenate(counts, axis=1))


def study(font: str, glyphs: str, goals: int) -> Array:
    """Count drags for each policy, then slider moves, to the same goals: (contestants, goals).

    A count is NaN if a policy was not tried, and infinite if the user gave up.
    """
    counts = []
    for glyph in glyphs:
        outline, rng = Outline(vf.Text(font, glyph)), np.random.default_rng(ord(glyph))
        places = rng.uniform(*outline.text.font.bounds, (goals, *outline.text.theta.shape))
        for number, goal in enumerate(places):
            by_drags = [
                drags(outline, goal, policy, rng) if number % policy.every == 0 else np.nan
                for policy in POLICIES
            ]
            counts.append([*by_drags, slider_moves(outline, goal)])
    return np.array(counts).T


def _rows(case: str, counts: Array) -> Iterator[Row]:
    pins, *others, sliders = counts
    rivals = ["sliders", *(policy.name for policy in POLICIES[1:])]
    for name, theirs in zip(rivals, [sliders, *others], strict=True):
        tried = ~np.isnan(theirs)
        yield _row(case, pins[tried], name, theirs[tried])


def _row(case: str, ours: Array, name: str, theirs: Array) -> Row:
    reached = np.isfinite(ours) & np.isfinite(theirs)
    ratios = theirs[reached] / np.maximum(ours[reached], 1)
    return Row(
        benchmark="study",
        case=f"{case}, {len(ours)} goals",
        ours=_typical(ours),
        baseline=f"{name} {_typical(theirs)}",
        ratio=str(Spread(*_quantiles(ratios, [25, 50, 75]))),
        notes=f"reached {_share(ours)} | {_share(theirs)}",
    )


def _typical(counts: Array) -> str:
    """Format the median and (95th percentile); ∞ if that many users give up."""
    return "{:.0f} ({:.0f})".format(*_quantiles(counts, [50, 95])).replace("inf", "∞")


def _quantiles(values: Array, percent: list[float]) -> Array:
    return np.percentile(values, percent, method="inverted_cdf")


def _share(counts: Array) -> str:
    return f"{np.isfinite(counts).mean():.1%}".replace("%", " %")
