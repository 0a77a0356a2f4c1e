"""What an animation tells about itself: a report to print, and its values over time."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..arrays import Array, to_array
from ..text import Text

STILL = 0.01
"""Font units in a frame: a text whose control points move by less is at rest."""


class Diagnostics:
    """Methods of :class:`Animation` that describe it."""

    text: Text
    times: Array
    theta: Array
    positions: Any
    penetration: Array
    energy: Array | None
    duration: Any
    fps: Any

    def report(self) -> str:
        """The length, the range of each axis, the deepest contact and the energy, to print."""
        font = self.text.font
        lines = [
            f"{self.text.string!r} in {font.family_name}: {len(self.times)} frames, "
            f"{self.duration:.4g} s, {self.fps:.4g} frames per second"
        ]
        low, high = (
            [font.denormalize(row) for row in ends]
            for ends in (self.theta.min(0), self.theta.max(0))
        )
        for axis in font.axes:
            least, most = min(a[axis.tag] for a in low), max(a[axis.tag] for a in high)
            if most > least:
                lines.append(f"{axis.tag:>6} {least:10.4g} to {most:.4g}")
        way = float(np.hypot(*np.moveaxis(self.positions - self.positions[0], -1, 0)).max())
        lines.append(f"letters move by at most {way:.4g} font units")
        if self.energy is not None or self.penetration.any():
            # Nothing has looked for contacts in frames that were interpolated.
            lines.append(f"deepest contact {self.penetration.max():.2g} font units")
        if self.energy is not None and len(self.energy) > 1:
            gain = float(np.diff(self.energy).max())
            change = float(self.energy[-1] - self.energy[0])
            lines.append(f"energy changes by {change:.4g}; largest gain in a frame {gain:.2g}")
        still = self._rest()
        if still is not None:
            lines.append(f"at rest from {still:.4g} s on")
        return "\n".join(lines)

    def _rest(self) -> float | None:
        """The time from which the text moves by less than STILL in each frame, if any."""
        frames = list(self)  # type: ignore[call-overload]
        drawn = np.array([to_array(frame.points()) for frame in frames])
        if len(drawn) < 2 or not drawn.shape[1]:
            return None
        moved = np.linalg.norm(np.diff(drawn, axis=0), axis=-1).max(1)
        moving = np.flatnonzero(moved >= STILL)
        last = moving[-1] + 1 if len(moving) else 0
        return None if last >= len(moved) else float(self.times[last])

    def plot(self, axes: Any = None) -> Any:
        """Draw the axes, the heights of the letters, the energy and the penetration over time.

        Axes are drawn in parts of their range: 0 is the default, 1 and −1 are the ends. Each
        colour is an axis; letters with axes of their own have a line each.

        Parameters
        ----------
        axes : array of 4 matplotlib Axes, optional
            Default: those of a new figure.

        Returns
        -------
        array of 4 Axes

        Raises
        ------
        MotionError
            ``axes`` are not four matplotlib Axes.
        """
        from .figure import draw_animation

        return draw_animation(self, axes)
