"""The energy of an image: a text looks like a picture (Sec. 5.4)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ..arrays import Array, ArrayLike
from ..deprecation import warn_renamed
from ..energy.term import Term
from ..errors import ImageError
from ..solver.loss import LOSSES, signed_root
from ..text import Text
from ..text.place import AXES, OFFSETS, TRACKING, Block
from .images import ImageSource, part, read_image
from .placement import place_on_ink, read_placement
from .scene import BESIDE, PLACEMENT, Scene, State

FITTED = (*PLACEMENT, "blur", "background")
"""What can be fitted in addition to the axes."""
MATCHED = (*FITTED, TRACKING)
"""The same for a match, which has no list of free blocks."""
FORMER = {"turn": "rotation", "light": "background"}
"""Names of version 0.1.0."""
LOSS_SCALE = 0.1
"""Residuals above this share of the contrast count as outliers."""
MOST_ROTATION, MOST_BLUR = 0.6, 0.05
"""Radians; and a standard deviation, as a share of the picture's longer side."""
UNEXPLAINED = 0.05
"""Share of the ink: a picture counts as met where no more of it is left unexplained."""


@dataclass(frozen=True, eq=False)
class Looks(Term):
    """Make the text look like a picture; its squares are those of pixels (Sec. 5.4).

    The placement of the text in the picture, the blur and the brightness of paper and ink are
    unknowns too. They begin at an estimate from the ink.

    Parameters
    ----------
    image : (H, W) array or tensor, PIL image, or path
        As for :func:`vfwidget.match`.
    placement : (2, 3) array, optional
        The affine map from the text's font units, y up, to pixels, y down: a similarity. By
        default it is estimated at the start of the solve, and fitted.
    fit : sequence of {"x", "y", "size", "rotation", "blur", "background"}, optional
        The quantities that are fitted in addition to the axes. Default: all of them; with
        ``placement`` only ``"blur"`` and ``"background"``.
    weight : float
        Factor of the squares. Default 1e4: a pixel that is wrong from black to white counts as
        much as a point that is 100 font units from its target.
    loss : {"soft_l1", "linear", "huber", "cauchy", "arctan"}
        How much large residuals count. Default "soft_l1".
    name : str
        Prefix of the names of the unknowns, ``"picture.x"`` and so on. Two pictures in one solve
        need different names.

    Raises
    ------
    ImageError
        When a solve begins: the image cannot be read or is uniform, the text has no outline, or
        an option is unknown.

    Examples
    --------
    A picture and a pin:

    >>> import vfwidget as vf
    >>> text = vf.Text("recursive", "n")
    >>> bold = text.at({"wght": 800})
    >>> foot = text.nearest(60, 0)
    >>> image = 1 - vf.rasterize(bold, (48, 48))
    >>> round(vf.solve(text, [vf.Looks(image), vf.Pin(foot, bold.position(foot))]).axes["wght"])
    800
    """

    image: ImageSource
    placement: ArrayLike | None = None
    fit: Sequence[str] | None = None
    weight: float = 1e4
    loss: str = "soft_l1"
    name: str = "picture"
    tolerance: float | None = UNEXPLAINED
    view: View | None = field(default=None, repr=False)

    def bind(self, text: Text) -> Term:
        """Read the picture, and estimate from its ink where the text stands."""
        super().bind(text)
        if isinstance(self.view, View):
            return self
        if self.view is not None:
            raise ImageError(
                "The view of a Looks is made from its image when a solve begins; leave it out. "
                f"Received view={self.view!r:.100}."
            )
        if self.loss not in LOSSES:
            raise ImageError(f"There is no loss {self.loss!r}: choose one of {', '.join(LOSSES)}.")
        fitted = check_fitted(self.fit, self.placement is not None)
        target = read_image(self.image)
        scene = Scene(text, target.shape)
        levels, ink = part(target, terms=1, dark=None)
        placement = read_placement(self.placement, text)
        if placement is None:
            theta = text.coordinates[None]
            placement = place_on_ink(text, theta, ink, scene.factor, "rotation" in fitted)[0]
        place = text.place
        own = place[OFFSETS], place[TRACKING]
        start = State(place[AXES], placement, 0.0, levels.light, levels.ink, *own)
        return replace(self, view=View(scene, target, start, fitted))

    def blocks(self, text: Text) -> Mapping[str, Block]:
        """Placement, blur and brightness, as far as they are fitted."""
        assert self.view is not None
        return {f"{self.name}.{part}": block for part, block in self.view.blocks().items()}

    def locate(self, text: Text) -> PictureRows:
        """The residual of every pixel."""
        assert self.view is not None
        return PictureRows(self, self.view)

    def miss(self, residual: Array) -> float:
        """The share of the ink's squares that is left unexplained, 0 … 1."""
        assert self.view is not None
        return min(1.0, float(residual @ residual) / max(self.view.ink_squares, 1e-12))

    def missed_by(self, miss: float) -> str:
        """The unexplained share in words."""
        return f"{100 * miss:.1f} % of the ink"


def check_fitted(
    fit: Sequence[str] | None, placed: bool, known: Sequence[str] = FITTED
) -> tuple[str, ...]:
    """The names of fitted quantities, checked; by default those that fit the placement.

    Raises
    ------
    ImageError
        A name is unknown.
    """
    if fit is None:
        return ("blur", "background") if placed else FITTED
    listed = isinstance(fit, Sequence) and not isinstance(fit, str)
    if not (listed and all(isinstance(name, str) for name in fit)):
        raise ImageError(f"fit must be a sequence of some of {', '.join(known)}; received {fit!r}.")
    for old in FORMER.keys() & set(fit):
        warn_renamed(f"fit={old!r}", repr(FORMER[old]))
    names = tuple(FORMER.get(name, name) for name in fit)
    unknown = [name for name in names if name not in known]
    if unknown:
        hint = f" In a solve, use free=[{TRACKING!r}]." if unknown[0] == TRACKING else ""
        raise ImageError(f"{unknown[0]!r} cannot be fitted: choose from {', '.join(known)}.{hint}")
    return names


@dataclass(frozen=True)
class View:
    """A picture at one resolution, and the state that its fit starts from.

    Attributes
    ----------
    scene : Scene
    target : (H, W) array
        The picture, at the scene's resolution.
    start : State
    fitted : tuple of str
        Of :data:`MATCHED`.
    """

    scene: Scene
    target: Array
    start: State
    fitted: tuple[str, ...]

    @property
    def scale(self) -> float:
        """The residual above which a robust loss takes a pixel for an outlier."""
        return LOSS_SCALE * max(abs(self.start.ink - self.start.light[0]), 0.05)

    @property
    def ink_squares(self) -> float:
        """Sum of the squares of what the picture has in addition to its paper."""
        return float(((self.scene.paper(self.start) - self.target) ** 2).sum())

    def blocks(self) -> dict[str, Block]:
        """The unknowns of the fit, by name."""
        start, scene = self.start, self.scene
        height, width = (side * scene.factor for side in scene.shape)
        reach = np.array([width / 4, height / 4, 0.7, MOST_ROTATION])
        low, high = start.placement - reach, start.placement + reach
        found = {
            name: Block(*(side[i : i + 1] for side in (start.placement, low, high)))
            for i, name in enumerate(PLACEMENT)
        }
        most = max((MOST_BLUR * max(height, width)) ** 2, start.blur)
        found["blur"] = Block(np.array([start.blur]), np.zeros(1), np.array([most]))
        reach = np.full(len(start.light), 2.0)
        found["background"] = Block(np.clip(start.light, -reach, reach), -reach, reach)
        ink = np.clip(np.array([start.ink]), -2.0, 1.5)
        found["ink"] = Block(ink, np.array([-2.0]), np.array([1.5]))
        free = {*self.fitted, *(["ink"] if "background" in self.fitted else [])}
        return {name: block for name, block in found.items() if name in free}

    def state(self, values: Mapping[str, Array]) -> State:
        """The state with these values of its own blocks and of those of the text."""
        start = self.start
        placement = start.placement.copy()
        for i, name in enumerate(PLACEMENT):
            if name in values:
                placement[i] = values[name][0]
        return State(
            theta=values[AXES],
            placement=placement,
            blur=float(values["blur"][0]) if "blur" in values else start.blur,
            light=values.get("background", start.light),
            ink=float(values["ink"][0]) if "ink" in values else start.ink,
            offsets=values[OFFSETS],
            tracking=values[TRACKING],
        )


class PictureRows:
    """The weighted residual of a picture, pixel by pixel, as a function of the unknowns."""

    def __init__(self, term: Looks, view: View) -> None:
        self.term, self.view, self.prefix = term, view, f"{term.name}."
        self.root = math.sqrt(term.weight)

    def _state(self, place: Mapping[str, Array]) -> State:
        return self.view.state({name.removeprefix(self.prefix): v for name, v in place.items()})

    def own_residual(self, place: Mapping[str, Array]) -> Array:
        """The text's picture minus the given one, flat."""
        return self._difference(self._state(place))

    def _difference(self, state: State, slack: float = 0.0) -> Array:
        return (self.view.scene.image(state, slack) - self.view.target).ravel()

    def residual(self, place: Mapping[str, Array]) -> Array:
        """See :class:`vfwidget.energy.rows.Rows`."""
        root: Array = signed_root(self.own_residual(place), self.term.loss, self.view.scale)[0]
        return root if self.root == 1 else self.root * root

    def jacobian(self, place: Mapping[str, Array], slices: Mapping[str, slice]) -> Array:
        """See :class:`vfwidget.energy.rows.Rows`."""
        state = self._state(place)
        slope = signed_root(self._difference(state, BESIDE), self.term.loss, self.view.scale)[1]
        mine = {AXES, OFFSETS, TRACKING, *(self.prefix + part for part in self.view.blocks())}
        own = [name for name in slices if name in mine]
        parts = [name.removeprefix(self.prefix) for name in own]
        rows = self.view.scene.jacobian(state, parts)
        flat: Array = rows.reshape(len(rows), -1)
        flat *= self.root * slope
        if len(own) == len(slices):
            return flat.T
        whole = np.zeros((max(part.stop for part in slices.values()), flat.shape[1]))
        columns = np.concatenate([np.arange(slices[n].start, slices[n].stop) for n in own])
        whole[columns] = flat
        return whole.T
