"""A fit of one text to one picture, from the coarse search to the last iteration."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..arrays import Array, ArrayLike
from ..font import Font
from ..solver.problem import check_size
from ..text import Text
from ..text.place import OFFSETS, TRACKING
from .fit import Options, Watch, deviations, fit
from .images import Levels, noise_variance, part, shrink
from .looks import View
from .placement import place_on_ink, read_placement
from .scene import Scene, State
from .start import best_apart, boxes_around, candidates, moving_axes, rank, readings, settled

STAGES = ((48, 6), (96, 3))
"""Pixels of the longer side, and how many starts are fitted at them, before the last stage."""
COARSE_ITERATIONS = 12
UNLIKE, MUCH_LESS, SPARSE = 0.25, 0.75, 4
"""If the best candidate leaves more of the ink unexplained, not all of that may be the text; what
share of it a part of the ink has to leave to be believed; one candidate in so many can tell."""
MANY = 6
"""Axes from which on they replace each other so well that a fit may be caught between them."""
HOP_SIDE, HOPS, HOP_ITERATIONS = 64, 16, 20
BETTER, PERFECT = 0.8, 1e-9
"""What share of the loss a hop has to come below, and a loss that needs no hops."""

Progress = Callable[[str], None]


@dataclass(frozen=True)
class Settings:
    """The arguments of :func:`vfwidget.match` that do not depend on the font, checked.

    Attributes
    ----------
    options : Options
    theta : (parameters, n) array, optional
        Where to start; by default a coarse search finds several starts.
    placement : (4,) array, optional
        As in :class:`~.scene.State`, where it is known.
    terms : int
        Of the paper's brightness.
    dark : bool, optional
        Whether ink is darker than paper.
    resolution : int
        Pixels of the longer side at the last stage, at most.
    max_iterations : int
        Of the last stage.
    """

    options: Options
    theta: Array | None
    placement: Array | None
    terms: int
    dark: bool | None
    resolution: int
    max_iterations: int


@dataclass(frozen=True)
class Outcome:
    """The result of a fit. It holds arrays only, so that it can be sent to another process.

    Attributes
    ----------
    state : State
    loss : float
        Mean cost of a pixel at the last stage.
    score : float
        Share of the ink that the fitted picture explains, with the noise subtracted; 1 is all.
    deviation : (parameters, n) array
        Standard deviation of Θ; infinite where the picture does not show an axis.
    path : list of State
        From the start, after each step of every stage.
    measure : (factor, name, scale)
        Of the last stage: its pixels in full ones, and its robust loss.
    iterations : int
        Of the last stage.
    converged : bool
    """

    state: State
    loss: float
    score: float
    deviation: Array
    path: list[State]
    measure: tuple[int, str, float]
    iterations: int
    converged: bool


class Search:
    """The fit of one text to one picture, coarse to fine.

    Parameters
    ----------
    text : Text
    image : (H, W) array
    settings : Settings
    progress : callable, optional
        Told each stage as it begins.
    watch : callable, optional
        Shown the state and the loss at every step.
    """

    def __init__(
        self,
        text: Text,
        image: Array,
        settings: Settings,
        progress: Progress = lambda stage: None,
        watch: Watch | None = None,
    ) -> None:
        self.text, self.image, self.settings = text, image, settings
        self.progress, self.watch = progress, watch
        self._views: dict[int, tuple[Scene, Array]] = {}

    def unexplained(self) -> float:
        """The share of the ink's squares that the best candidate of the coarse search leaves."""
        return float(self._candidates()[1].min())

    def outcome(self) -> Outcome:
        """Run the fit."""
        if self.settings.options.optimizer == "gauss-newton":
            # Checked before any stage, because the stages take time.
            check_size(self._view(self.settings.resolution)[1].size, self._count_unknowns())
        self.progress("coarse search")
        starts = self._starts()
        path = starts[:1]
        if self.settings.options.optimizer == "gauss-newton":
            path = self._coarse(starts)
        self.progress("full size")
        options = self.settings.options
        view = self._picture(self.settings.resolution, path[-1])
        found = fit(view, options, self.settings.max_iterations, self.watch, crosses=True)
        state = replace(found.state, theta=settled(self.text, found.state.theta))
        return Outcome(
            state=state,
            loss=found.loss,
            score=self._score(state),
            deviation=deviations(view, state, options.loss),
            path=[*path[:-1], *found.path[:-1], state],
            measure=(view.scene.factor, options.loss, view.scale),
            iterations=found.iterations,
            converged=found.converged,
        )

    def _count_unknowns(self) -> int:
        """The number of unknowns of a fit: axes, placement, blur, and the brightness of both."""
        fitted = set(self.settings.options.fitted)
        brightness = self.settings.terms + 1 if "background" in fitted else 0
        return self.text.coordinates.size + len(fitted - {"background"}) + brightness

    def _score(self, state: State) -> float:
        """What share of the ink a state explains, seen from afar."""
        scene, small = self._view(STAGES[0][0])
        return _explained(scene, small, state, noise_variance(self.image) / scene.factor**2)

    def _view(self, side: int) -> tuple[Scene, Array]:
        """The scene and the picture with no more pixels at the longer side; each made once."""
        factor = max(1, math.ceil(max(self.image.shape) / side))
        if factor not in self._views:
            scene = Scene(self.text, self.image.shape, factor)
            self._views[factor] = scene, shrink(self.image, factor)
        return self._views[factor]

    def _picture(self, side: int, start: State) -> View:
        return View(*self._view(side), start, self.settings.options.fitted)

    def _candidates(self) -> tuple[list[State], Array]:
        """Locations of the design space, placed on the ink, and what each leaves unexplained."""
        settings, (scene, small) = self.settings, self._view(STAGES[0][0])
        levels, ink = part(small, settings.terms, settings.dark)
        thetas = candidates(self.text) if settings.theta is None else settings.theta[None]

        def put(thetas: Array, ink: Array) -> tuple[Array, Array]:
            if settings.placement is not None:
                places = np.broadcast_to(settings.placement, (len(thetas), 4))
            else:
                rotated = "rotation" in settings.options.fitted
                places = place_on_ink(self.text, thetas, ink, scene.factor, rotated)
            return places, rank(scene, thetas, places, small, settings.terms)

        places, shares = put(thetas, ink)
        if shares.min() > UNLIKE and settings.placement is None:
            # A few candidates tell which of the ink is the text.
            others = [(put(thetas[::SPARSE], other)[1].min(), other) for other in readings(ink)]
            least, other = min(others, key=lambda one: one[0], default=(1.0, ink))
            if least < MUCH_LESS * shares.min():
                places, shares = put(thetas, other)
        states = [
            self._state(theta, place, levels) for theta, place in zip(thetas, places, strict=True)
        ]
        return states, shares

    def _state(self, theta: Array, placement: Array, levels: Levels) -> State:
        own = self.text.place[OFFSETS], self.text.place[TRACKING]
        return State(theta, placement, 0.0, levels.light, levels.ink, *own)

    def _starts(self) -> list[State]:
        """States to fit from, the best first."""
        settings = self.settings
        if settings.theta is not None and settings.placement is not None:
            small = self._view(STAGES[0][0])[1]
            levels, _ = part(small, settings.terms, settings.dark)
            return [self._state(settings.theta, settings.placement, levels)]
        states, shares = self._candidates()
        return [states[i] for i in best_apart(self.text, states, shares, STAGES[0][1])]

    def _coarse(self, starts: list[State]) -> list[State]:
        """The path of the best of several starts, each fitted to smaller pictures first."""
        paths = [[start] for start in starts]
        settings = self.settings
        for side, count in STAGES if settings.theta is None else STAGES[:1]:
            self.progress(f"{side} pixels")
            side = min(side, settings.resolution)
            views = [self._picture(side, path[-1]) for path in paths[:count]]
            fits = [
                (path, fit(view, settings.options, COARSE_ITERATIONS, self.watch))
                for path, view in zip(paths, views, strict=False)
            ]
            ends, losses = [found.state for _, found in fits], [found.loss for _, found in fits]
            best = best_apart(self.text, ends, losses, len(fits))
            paths = [fits[i][0][:-1] + fits[i][1].path for i in best]
            if self._view(side) is self._view(settings.resolution):
                break
        path = paths[0]
        if self._view(HOP_SIDE)[1].size < path[-1].theta.size:
            # A picture with fewer pixels than axes cannot decide which of two fits is better.
            return path
        path = [*path, *self._other_glyphs(path[-1])]
        movable = moving_axes(self.text.moved(path[-1].theta)).any(0)
        if settings.theta is None and movable.sum() >= MANY:
            self.progress("hops")
            path.append(self._hop(path[-1]))
        return path

    def _other_glyphs(self, best: State) -> list[State]:
        """Better states with other glyphs: fits from the nearest location of each box around."""
        path: list[State] = []
        around = boxes_around(self.text.moved(best.theta))
        if not around:
            return path
        options = self.settings.options
        self.progress("other glyphs")
        loss = fit(self._picture(HOP_SIDE, best), options, HOP_ITERATIONS).loss
        for letter, box in around:
            if loss < PERFECT:
                break
            theta = best.theta.copy()
            theta[letter] = theta[letter].clip(*box)
            view = self._picture(HOP_SIDE, replace(best, theta=theta))
            other = fit(view, options, HOP_ITERATIONS)
            if other.loss < loss:
                loss, best = other.loss, other.state
                path.append(best)
        return path

    def _hop(self, best: State) -> State:
        """Out of a local minimum: fits from where half of the axes stand elsewhere.

        Many axes can all but replace each other, and a picture looks nearly right where several
        of them are wrong together (basin hopping, Wales and Doye 1997, without its temperature).
        """
        lower, upper = self.text.font.bounds
        options = self.settings.options
        chance, movable = np.random.default_rng(0), moving_axes(self.text.moved(best.theta))
        found = fit(self._picture(HOP_SIDE, best), options, HOP_ITERATIONS)
        for _ in range(HOPS):
            if found.loss < PERFECT:
                break
            theta = found.state.theta
            anew = movable & (chance.random(theta.shape) < 0.5)
            start = replace(found.state, theta=np.where(anew, chance.uniform(lower, upper), theta))
            other = fit(self._picture(HOP_SIDE, start), options, HOP_ITERATIONS)
            if other.loss < BETTER * found.loss:
                found = other
        return found.state


def _explained(scene: Scene, image: Array, state: State, noise: float) -> float:
    """1 minus the share of the ink's squares that is left, with those of the noise subtracted.

    The mean of that over the picture and of that around the text, so that a stain far off counts
    for half, and letters that the text leaves out still count.
    """
    left, ink = (scene.image(state) - image) ** 2, (scene.paper(state) - image) ** 2
    covered = scene.covered(state)
    covered = covered > covered.max() / 2
    near = np.zeros(image.shape, dtype=bool)
    if covered.any():
        rows, columns = (np.flatnonzero(covered.any(side)) for side in (1, 0))
        margin = 1 + (rows[-1] - rows[0]) // 8
        near[
            max(0, rows[0] - margin) : rows[-1] + margin + 1,
            max(0, columns[0] - margin) : columns[-1] + margin + 1,
        ] = True
    shares = []
    for here in (near, np.ones_like(near)):
        unexplained, all_ink = left[here].sum(), ink[here].sum()
        expected = noise * here.sum()
        # Where there is hardly more than noise, it cannot be told from ink.
        if expected < all_ink / 2:
            unexplained, all_ink = max(unexplained - expected, 0.0), all_ink - expected
        shares.append(unexplained / max(all_ink, 1e-12))
    return 1 - float(np.mean(shares))


@dataclass(frozen=True)
class Request:
    """The arguments of a match for any font; it can be sent to another process.

    Attributes
    ----------
    string : str
    shared : bool
    axes : mapping, or one per letter, optional
        Where to start.
    placement : (2, 3) array, optional
    settings : Settings
    manner : mapping
        How the text is set: keyword arguments of :class:`Text`.
    lengths : mapping
        More keyword arguments: lengths in ems.
    """

    string: str
    shared: bool
    axes: Any
    placement: ArrayLike | None
    settings: Settings
    manner: Mapping[str, Any]
    lengths: Mapping[str, Any]

    def text(self, font: Font) -> Text:
        """The text in a font."""
        lengths: dict[str, Any] = {
            name: em * font.units_per_em for name, em in self.lengths.items()
        }
        return Text(font, self.string, axes=self.axes, shared=self.shared, **self.manner, **lengths)

    def settings_for(self, text: Text) -> Settings:
        """Where to start, in this text's coordinates."""
        placement = read_placement(self.placement, text)
        theta = None if self.axes is None else text.coordinates
        return replace(self.settings, placement=placement, theta=theta)
