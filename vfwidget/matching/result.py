"""The result of a match: axis values with their uncertainty, and a report in words."""

from __future__ import annotations

import html
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arrays import Array, to_tensor
from ..deprecation import warn_renamed
from ..font.axes import shown
from ..solver.loss import robust_cost
from ..text import Text
from .images import shrink
from .match import Outcome
from .scene import Scene, State

if TYPE_CHECKING:
    import torch

GOOD = 0.95
"""The least share of the ink that a match explains."""
UNDETERMINED = 0.1
"""A standard deviation, in normalized coordinates, at which an axis is undetermined."""


@dataclass(frozen=True, eq=False, repr=False)
class Match:
    """The result of :func:`vfwidget.match`.

    Attributes
    ----------
    text : Text
        The text, at the axes found.
    target : (H, W) array
        The picture, as grey levels, 1 white.
    outcome : Outcome
        The fitted state as numbers.
    ranking : tuple of Match
        One match for each fitted font, the best first; with a single font, only this match.
    left_out : dict of str to str
        Fonts that were not fitted, and the reason: they could not be fitted, or the coarse search
        ranked them too low.
    """

    text: Text
    target: Array
    outcome: Outcome
    ranking: tuple[Match, ...] = field(default=(), repr=False)
    left_out: dict[str, str] = field(default_factory=dict, repr=False)

    def __repr__(self) -> str:
        return f"<Match: {self.report().splitlines()[0]}\n axes {shown(self.axes)}>"

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(self.report())}</pre>"

    @property
    def axes(self) -> Any:
        """User coordinates found, in the form of :attr:`Text.axes`."""
        return self.text.axes

    @property
    def loss(self) -> float:
        """Mean cost of a pixel."""
        return self.outcome.loss

    @property
    def score(self) -> float:
        """Coefficient of determination of the ink; 1 is a perfect fit.

        1 − residual / ink, both sums of squares with the noise subtracted.
        """
        return self.outcome.score

    @property
    def status(self) -> str:
        """``"matched"``, or ``"poor"`` where less than 95 % of the ink is explained."""
        return "matched" if self.score >= GOOD else "poor"

    @property
    def converged(self) -> bool:
        """Whether the fit ended by itself.

        It is False if the fit ended at ``max_iterations``, as Adam always does, if no step achieved
        the gain that the derivative promises, or if letters that have axes of their own stand at
        so many boundaries at which glyphs change that the other side of some was not tried.
        """
        return self.outcome.converged

    @cached_property
    def history(self) -> list[tuple[Array, float]]:
        """(Θ, loss) at the start and after each step, coarse ones included.

        All losses are those of the last resolution.
        """
        factor, loss, scale = self.outcome.measure
        height, width = self.target.shape
        scene, target = Scene(self.text, (height, width), factor), shrink(self.target, factor)

        def mean_cost(state: State) -> float:
            residual = (scene.image(state) - target).ravel()
            return float(robust_cost(residual, loss, scale)) / len(residual)

        return [(state.theta, mean_cost(state)) for state in self.outcome.path]

    @property
    def placement(self) -> torch.Tensor:
        """The affine map (2, 3) from the text's font units to the picture's pixels."""
        return to_tensor(self._scene.matrix(self.outcome.state.placement))

    @property
    def blur(self) -> float:
        """Standard deviation of the picture's blur, in pixels."""
        return float(np.sqrt(self.outcome.state.blur))

    @cached_property
    def image(self) -> torch.Tensor:
        """The fitted picture (H, W), with its brightness and blur."""
        return to_tensor(self._scene.image(self.outcome.state))

    @property
    def residual(self) -> torch.Tensor:
        """The fitted picture minus the given one, (H, W)."""
        return self.image - to_tensor(self.target)

    @property
    def _scene(self) -> Scene:
        height, width = self.target.shape
        return Scene(self.text, (height, width))

    @property
    def uncertainty(self) -> Any:
        """Standard deviation of each axis in user coordinates, by tag.

        From the Jacobian of the picture and the noise that the residual shows; infinite for an
        undetermined axis. A dict when axes are shared, else a list with one for each letter.
        """
        rows = [
            self._spread(w, d) for w, d in zip(self._theta, self.outcome.deviation, strict=True)
        ]
        return rows[0] if self.text.shared else rows

    def _spread(self, w: Array, deviation: Array) -> dict[str, float]:
        font = self.text.font
        lower, upper = font.bounds
        spread = {}
        for i, axis in enumerate(font.axes):
            if not deviation[i] < UNDETERMINED:
                spread[axis.tag] = float("inf")
                continue
            ends = []
            for side in (-1, 1):
                moved = w.copy()
                moved[i] = np.clip(w[i] + side * deviation[i], lower[i], upper[i])
                ends.append((font.denormalize(moved)[axis.tag], moved[i]))
            (low, a), (high, b) = ends
            spread[axis.tag] = float((high - low) / (b - a) * deviation[i]) if b > a else 0.0
        return spread

    @property
    def _theta(self) -> Array:
        return self.text.coordinates

    @property
    def undetermined(self) -> Any:
        """Tags of axes that this picture does not determine; a list of tuples when not shared."""
        rows = [
            tuple(
                a.tag for a, d in zip(self.text.font.axes, row, strict=True) if not d < UNDETERMINED
            )
            for row in self.outcome.deviation
        ]
        return rows[0] if self.text.shared else rows

    @property
    def unseen(self) -> Any:
        """The former name of :attr:`undetermined`."""
        warn_renamed("unseen", "undetermined")
        return self.undetermined

    def report(self) -> str:
        """How good the match is, and every axis with its uncertainty, as a table to print."""
        font = self.text.font
        lines = [
            f"{self.status}: {font.family_name} explains {100 * self.score:.1f} % of the ink of "
            f"{self.text.string!r}"
        ]
        if self.status == "poor":
            lines.append(
                "The picture does not show an instance of this font; at best, the axis values are "
                "those of the most similar instance."
            )
        if not self.converged:
            lines.append("The fit ended before it converged; a larger max_iterations may help.")
        axes = [self.axes] if self.text.shared else self.axes
        spread = [self.uncertainty] if self.text.shared else self.uncertainty
        names = [""] if self.text.shared else self.text.word.distinct_names
        width = max(len(name) for name in names) + (not self.text.shared)
        for name, values, about in zip(names, axes, spread, strict=True):
            of = f"{name:{width}}"
            for tag, value in values.items():
                if np.isfinite(about[tag]):
                    lines.append(f"{of}{tag:>6} {value:10.4g} ± {about[tag]:.2g}")
                else:
                    lines.append(f"{of}{tag:>6} {value:10.4g}   not determined by this picture")
        if self.text.tracking:
            lines.append(f"tracking {self.text.tracking:10.4g}")
        return "\n".join(lines)

    def plot(self, axes: Any = None) -> Any:
        """The picture, the fit, the residual and the loss, side by side.

        Parameters
        ----------
        axes : array of 4 matplotlib Axes, optional

        Returns
        -------
        array of 4 Axes
        """
        from .figure import draw_match

        return draw_match(self, axes)
