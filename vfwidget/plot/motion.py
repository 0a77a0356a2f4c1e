"""A figure of an animation: some of its frames side by side."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ..arrays import to_array
from ..errors import VFWidgetError
from ..motion.animation import Animation
from .canvas import GREY, bare, caption, draw_glyph, panels
from .subject import check_count, text_title

ROW = 6
"""Frames in a row."""
MOST = 200
"""Frames of a contact sheet; matplotlib takes seconds to draw more."""


def frames(animation: Animation, count: int = 12, ax: Axes | None = None) -> Any:
    """Draw frames of an animation at equal distances in time, as a contact sheet (Fig. 10, 12).

    All frames have the same scale. Obstacles are grey, and are cut off where no letter goes.

    Parameters
    ----------
    animation : Animation
    count : int
        Number of frames, 2 to 200. Default 12.
    ax : matplotlib Axes, optional
        The frames are drawn in its place.

    Returns
    -------
    (count,) array of Axes

    Raises
    ------
    VFWidgetError
        ``animation`` is not an Animation, or ``count`` is not a whole number from 2 to 200.
    """
    if not isinstance(animation, Animation):
        raise VFWidgetError(f"frames draws an Animation; received {type(animation).__name__}.")
    check_count("count", count, 2, MOST)
    indices = np.linspace(0, len(animation) - 1, count).round().astype(int)
    shown = [[to_array(s) for s in animation[i].segments()] for i in indices.tolist()]
    points = np.concatenate([s.reshape(-1, 2) for contours in shown for s in contours])
    low, high = points.min(0), points.max(0)
    margin = 0.06 * float((high - low).max())
    host, drawn = panels(ax, count, columns=min(count, ROW))
    for panel, index, contours in zip(drawn, indices, shown, strict=True):
        for obstacle in animation.scenery[index]:
            draw_glyph(panel, [obstacle], facecolor=GREY)
        draw_glyph(panel, contours)
        bare(panel)
        panel.set_xlim(low[0] - margin, high[0] + margin)
        panel.set_ylim(low[1] - margin, high[1] + margin)
        panel.set_aspect("equal")
        panel.set_title(f"{animation.times[index]:.2f} s", fontsize="medium")
    caption(host, text_title(animation.text.moved(np.zeros_like(animation.text.coordinates))))
    return drawn
