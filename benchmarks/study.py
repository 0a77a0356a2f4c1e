"""A simulated user study: a letter brought to a wanted form by dragging and by sliders (App. A).

From the default a letter is to look like a random instance of its font, to within 1 % of the em
(root mean square over dense points of its outline). One simulated person drags, as the editor
lets them, the outline point that is farthest from where it belongs to where it belongs. The other
moves sliders, always the one that helps most and to its best value, which is more than a person
can see. Counted are drags and slider moves. What is done about the points dragged before:

pins
    A point that has arrived is pinned. When a point does not arrive all are unpinned.
no pins
    Nothing is.
kept targets
    Each goes on pulling to its place as the dragged one does. The editor has no such thing.
shaky pins
    As pins, by a hand that misses its aim by 0.2 % of the em: a pixel, on a letter of 500. Pins
    are then not quite where they belong, and may keep others from it; tried on some of the goals.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

import vfwidget as vf
from vfwidget.view.editor import CALM, RELEASE_ITERATIONS, RESTARTS

from .table import Row
from .timing import Array, Spread

GLYPHS = "aRg&8"
GOALS = 20
"""For each glyph of each font."""
PER_SEGMENT = 4
NEAR = 0.01
"""Ems, root mean square: as good as the goal."""
VISIBLE = 0.002
"""Ems: what a person can aim at and see."""
DRAGS, MOVES = 2, 10
"""For each axis of the font, before a person gives up."""


class Outline:
    """Dense points of a letter's outline, by which a person compares it with another."""

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
        # The outline is affine in its scaling factors: what these differ by has all there is.
        deltas = self._points.deltas.reshape(2 * len(self.handles), -1)
        _, triangle = np.linalg.qr(deltas)
        self._root = triangle.T / (self.em * np.sqrt(len(self.handles)))

    def places(self, theta: Array) -> Array:
        """Where the points are at Θ (1, n), (p, 2)."""
        return self.text.positions(self._points, theta)

    def difference(self, theta: Array, goal: Array) -> Array:
        """Vectors (..., r) as long as two outlines are apart: root mean square, in ems."""
        scalars = self.text.word.regions.scalars
        return (scalars(theta) - scalars(goal))[..., 0, :] @ self._root

    def is_near(self, theta: Array, goal: Array) -> bool:
        """Whether the outline at Θ passes for the goal."""
        return bool(np.linalg.norm(self.difference(theta, goal)) <= NEAR)


@dataclass(frozen=True)
class Policy:
    """What a person does about the points dragged before.

    ``hold`` makes a term of a handle and the place it was dragged to. With ``unpins`` only points
    that arrived are held, and all are let go when one does not. The hand misses by ``shakes`` ems.
    One goal of ``every`` so many is tried.
    """

    name: str
    hold: Callable[[vf.Handle, Array], vf.Term] | None = None
    unpins: bool = False
    shakes: float = 0.0
    every: int = 1


def _pin(handle: vf.Handle, place: Array) -> vf.Term:
    """The editor pins a point where it is."""
    return vf.Pin(handle)


POLICIES = (
    Policy("pins", _pin, unpins=True),
    Policy("no pins"),
    Policy("kept targets", vf.Target),
    Policy("shaky pins", _pin, unpins=True, shakes=VISIBLE, every=4),
)


def drags(outline: Outline, goal: Array, policy: Policy, hand: np.random.Generator) -> float:
    """How many drags bring the outline to the goal; infinite where the person gives up."""
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
    """What the editor does when the pointer lets go, and how far from the pointer the point is."""
    calm = vf.StayClose((CALM * text.font.units_per_em) ** 2)
    solution = vf.solve(
        text, [target, calm, *others], max_iterations=RELEASE_ITERATIONS, restarts=RESTARTS
    )
    return solution.text, solution.misses[0]


def slider_moves(outline: Outline, goal: Array) -> float:
    """How many moves of one slider at a time do it; infinite where the person gives up.

    Between two kinks of an axis the outline is affine in it, and so its best value is exact.
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
    """Both ends (c, 1, n) of every straight piece of every axis on which one may move from Θ."""
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
    """Each font, and all of them: pins against sliders and against the other policies."""
    counts = []
    for name in vf.bundled_fonts():
        counts.append(study(name, GLYPHS, 2 if quick else GOALS))
        yield from _rows(name, counts[-1])
    yield from _rows("all fonts", np.concatenate(counts, axis=1))


def study(font: str, glyphs: str, goals: int) -> Array:
    """Drags by each policy, then slider moves, to the same goals: (contestants, goals).

    NaN where a policy was not tried, infinity where the person gave up.
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
    """Median and, in brackets, 95th percentile; ∞ where as many give up."""
    return "{:.0f} ({:.0f})".format(*_quantiles(counts, [50, 95])).replace("inf", "∞")


def _quantiles(values: Array, percent: list[float]) -> Array:
    return np.percentile(values, percent, method="inverted_cdf")


def _share(counts: Array) -> str:
    return f"{np.isfinite(counts).mean():.1%}".replace("%", " %")
