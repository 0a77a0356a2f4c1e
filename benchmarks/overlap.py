"""Overlaps resolved: exact area, beside the paper's planes, on seeded cases with a free witness.

The paper's recipe (Sec. 5.2) detects planes at sampled points, minimises their energy with
Levenberg–Marquardt, and repeats that in an outer loop. Distances are of Θ from the user's state, in
normalized coordinates.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from time import process_time

import numpy as np

import vfwidget as vf

from . import overlap_drags, overlap_speed
from .overlap_cases import Case, cases
from .table import Row

RESOLVED = 1e-4
"""Part of a glyph: overlaps with a smaller area count as resolved."""
GRID, HALVES = 61, 41
"""States of the brute-force search along each axis, and on the way back from each free state."""
LOOPS = 12
"""Of the paper's recipe, at most."""

Method = Callable[[Case], vf.Text]


def run(quick: bool) -> Iterator[Row]:
    """Shares of cases that are resolved, distances from the user's state, and times."""
    yield from overlap_speed.run(quick)
    yield from overlap_drags.run(quick)
    found = list(cases(12 if quick else 300))
    yield _against_brute_force([case for case in found if case.text.theta.numel() == 2])
    planes = _outcome(found, planes_in_a_loop)
    for name, method in (
        ("exact area", lambda case: resolved(case, restarts=0)),
        ("exact area, five restarts", lambda case: resolved(case, restarts=5)),
    ):
        share, away, seconds, _ = _outcome(found, method)
        yield Row(
            benchmark="overlap",
            case=f"{len(found)} cases, {name}",
            ours=f"{100 * share:.0f} %",
            baseline=f"planes in a loop {100 * planes[0]:.0f} %",
            ratio="",
            notes=f"median distance {away:.2f} | {planes[1]:.2f}, "
            f"{seconds:.2f} | {planes[2]:.2f} s, the loop deepens {100 * planes[3]:.0f} %",
        )


def _against_brute_force(found: list[Case]) -> Row:
    """How much farther our states are than the nearest of a grid, where Θ has two axes."""
    ratios = []
    for case in found:
        nearest = brute_force(case)
        text = resolved(case, restarts=5)
        if np.isfinite(nearest) and not vf.overlaps(text, case.obstacles):
            ratios.append(float((text.theta - case.text.theta).norm()) / nearest)
    return Row(
        benchmark="overlap",
        case=f"{len(ratios)} cases with two axes",
        ours=f"{np.median(ratios):.3f}",
        baseline="brute force 1",
        ratio="",
        notes=f"median distance over that of the nearest grid state; largest {max(ratios):.2f}",
    )


def brute_force(case: Case) -> float:
    """The distance of the nearest free state on a grid, moved back while it stays free."""
    start = case.text.theta.numpy()
    lower, upper = case.text.font.bounds
    sides = [np.linspace(a, b, GRID) for a, b in zip(lower, upper, strict=True)]
    states = np.stack(np.meshgrid(*sides), -1).reshape(-1, *start.shape)
    away = np.linalg.norm(states - start, axis=(1, 2))
    spacing, best = np.hypot(*(upper - lower)) / (GRID - 1), np.inf
    for state, distance in sorted(zip(states, away, strict=True), key=lambda pair: pair[1]):
        if distance > best + spacing:
            break
        if is_free(case, state):
            parts = np.linspace(0, 1, HALVES)
            kept = next(p for p in parts[::-1] if is_free(case, state + p * (start - state)))
            best = min(best, (1 - kept) * distance)
    return best


def is_free(case: Case, theta: np.ndarray) -> bool:
    """Whether nothing overlaps at Θ."""
    return not vf.overlaps(case.text.at(theta=theta), case.obstacles)


def resolved(case: Case, restarts: int) -> vf.Text:
    """The text where :func:`vfwidget.resolve_overlaps` leaves it."""
    return vf.resolve_overlaps(case.text, case.obstacles, restarts=restarts).text


def planes_in_a_loop(case: Case) -> vf.Text:
    """The text after the paper's recipe: planes that are kept during each of several solves."""
    text = case.text
    for _ in range(LOOPS):
        if not vf.overlaps(text, case.obstacles):
            break
        term = FrozenPlanes(case.obstacles, method="planes")
        text = vf.solve(text, [term, vf.StayClose()], restarts=0).text
    return text


class FrozenPlanes(vf.NoOverlap):
    """Planes that are found once, at the start of a solve."""

    moving = False

    def locate(self, text: vf.Text):
        return self.with_planes(text)


def _outcome(found: list[Case], method: Method) -> tuple[float, float, float, float]:
    """Share resolved, median distance of those, median seconds, and share that is worse."""
    resolved, distances, seconds, deeper = [], [], [], []
    for case in found:
        begun = process_time()
        text = method(case)
        seconds.append(process_time() - begun)
        before, after = (
            sum(overlap.area for overlap in vf.overlaps(t, case.obstacles))
            for t in (case.text, text)
        )
        resolved.append(after <= RESOLVED * _glyph(case.text))
        deeper.append(after > before)
        if resolved[-1]:
            distances.append(float((text.theta - case.text.theta).norm()))
    return (
        float(np.mean(resolved)),
        float(np.median(distances)) if distances else np.nan,
        float(np.median(seconds)),
        float(np.mean(deeper)),
    )


def _glyph(text: vf.Text) -> float:
    """The area of a typical glyph, in square font units."""
    return 0.2 * text.font.units_per_em**2
