"""Parts that all figures use: Axes, colours, captions, and glyphs as filled paths."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil
from typing import Any, TypeAlias

import matplotlib.pyplot as plt
import numpy as np
import numpy.typing as npt
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.figure import SubFigure
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from matplotlib.quiver import Quiver

from ..arrays import Array, to_array
from ..errors import VFWidgetError

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
"""The colours of Okabe and Ito, which colour-blind readers can distinguish."""
BLUE, VERMILLION, GREEN, _, ORANGE, SKY = COLOURS
GREY = "#999999"
PALE = {"facecolor": GREY, "alpha": 0.35, "linewidth": 0}
"""Style of an outline in the background."""
MARGIN = 0.05
"""Margin around a drawing, as a share of its size."""
PANEL, SMALL_PANEL = (4.2, 3.5), (2.0, 2.4)
MIN_WIDTH = 6.5
"""Sizes in inches; a narrower figure would leave no room for its title."""

Panels: TypeAlias = npt.NDArray[Any]
"""A (count,) array of Axes."""


def ink() -> str:
    """The text colour of the current style, so that glyphs are visible on dark backgrounds."""
    return str(rcParams["text.color"])


def single(ax: Axes | None, size: tuple[float, float]) -> Axes:
    """Return the given Axes, or the Axes of a new figure of this size in inches."""
    if ax is None:
        return plt.subplots(figsize=size, layout="constrained")[1]
    if not isinstance(ax, Axes):
        raise VFWidgetError(f"ax must be one matplotlib Axes; received {type(ax).__name__}.")
    return ax


def around(ax: Axes | None, points: Array, beside: float = 0, most: Any = (12, 4.3)) -> Axes:
    """Return Axes without ticks that show all points (…, 2) to scale.

    A new figure has the size that the points need, at most ``most`` inches wide or high, and
    ``beside`` more inches for a legend.
    """
    width, height = np.maximum(np.ptp(points.reshape(-1, 2), axis=0), 1)
    inch = min(most[0] / width, most[1] / height)
    ax = single(ax, (max(inch * width, 4) + beside + 0.5, inch * height + 1.2))
    bare(ax)
    fit(ax, points)
    return ax


def panels(
    ax: Axes | None, count: int, columns: int | None = None, **subplot: Any
) -> tuple[SubFigure, Panels]:
    """Return panels in a new figure or in place of an Axes, and the subfigure that holds them.

    Parameters
    ----------
    ax : Axes or None
        The panels are drawn in place of this Axes; a new figure if None.
    count : int
        Number of panels.
    columns : int, optional
        Number of panels in a row; they are smaller then. Default: 2 or 3.
    **subplot
        Arguments of ``Figure.add_subplot``.

    Raises
    ------
    VFWidgetError
        The Axes is not part of a grid made by ``plt.subplots``.
    """
    width, height = PANEL if columns is None else SMALL_PANEL
    columns = columns or (2 if count == 4 else min(count, 3))
    rows = ceil(count / columns)
    # The panels also replace the empty Axes of a new figure.
    ax = single(ax, (max(width * columns, MIN_WIDTH), height * rows + 1))
    spec = ax.get_subplotspec()
    if spec is None:
        raise VFWidgetError(
            "The figure has several panels, so ax must be part of a plt.subplots grid."
        )
    host = ax.figure.add_subfigure(spec)
    if not host.get_layout_engine():
        # Without a layout engine, titles and labels would overlap.
        host.subplots_adjust(top=0.75, bottom=0.28, wspace=0.4, hspace=0.8)
    ax.remove()
    made = np.empty(count, dtype=object)
    for i in range(count):
        made[i] = host.add_subplot(rows, columns, i + 1, **subplot)
    return host, made


def caption(where: Axes | SubFigure, title: str, *notes: str) -> None:
    """Write a title above a figure, and below it one line for each note that is not empty."""
    above, beneath = (
        (where.set_title, where.set_xlabel)
        if isinstance(where, Axes)
        else (where.suptitle, where.supxlabel)
    )
    above(title, fontsize="x-large", wrap=True)
    beneath("\n".join(filter(None, notes)), fontsize="large", wrap=True)


def showable(text: str) -> bool:
    """Whether all characters are visible and Latin, so that matplotlib's own font has them."""
    return all(c.isprintable() and c < "\u0250" for c in text)


def plain(text: str) -> str:
    """Return text that matplotlib can show and does not read as mathematics."""
    return "".join(c if showable(c) else "?" for c in text).replace("$", r"\$")


def bare(ax: Axes) -> None:
    """Remove the frame and the ticks; the title and the label keep their room."""
    ax.set_frame_on(False)
    ax.set_xticks([])
    ax.set_yticks([])


def fit(ax: Axes, *points: Array) -> None:
    """Set an equal aspect, and limits that contain all points (…, 2) and all artists."""
    ax.update_datalim(np.concatenate([p.reshape(-1, 2) for p in points]))
    ax.margins(MARGIN)
    # Only the limits may change, because the layout has placed the labels around the box.
    ax.set_aspect("equal", adjustable="datalim")
    ax.autoscale_view()


def glyph_path(contours: Sequence[Array]) -> Path:
    """Return closed contours of cubics (s, 4, 2) as one path, which is filled as a whole."""
    vertices, codes = [np.zeros((0, 2))], [np.zeros(0, dtype=Path.code_type)]
    for cubics in contours:
        start = cubics[0, :1]
        vertices += [start, cubics[:, 1:].reshape(-1, 2), start]
        curves = [Path.CURVE4] * (3 * len(cubics))
        codes.append(np.array([Path.MOVETO, *curves, Path.CLOSEPOLY], dtype=Path.code_type))
    return Path(np.concatenate(vertices), np.concatenate(codes))


def draw_glyph(ax: Axes, contours: Sequence[Any], shift: Any = (0, 0), **style: Any) -> PathPatch:
    """Fill contours (s, 4, 2) after moving them by ``shift``."""
    path = glyph_path([to_array(cubics) + shift for cubics in contours])
    patch = PathPatch(path, **({"facecolor": ink(), "linewidth": 0} | style))
    ax.add_patch(patch)
    return patch


def arrows(
    ax: Axes, points: Array, vectors: Array, colour: str, scale: float = 1, **style: Any
) -> Quiver:
    """Draw vectors (p, 2) at points (p, 2), at ``scale`` times their length in data units."""
    style = {
        "zorder": 3,
        "width": 0.022,
        "headwidth": 4,
        "headlength": 4.5,
        "headaxislength": 4,
    } | style
    return ax.quiver(
        *points.T,
        *vectors.T,
        color=colour,
        angles="xy",
        scale_units="xy",
        scale=1 / scale,
        units="inches",
        # A zero vector draws no dot.
        minlength=0,
        **style,
    )


def number(length: float) -> str:
    """Format a length in font units with two significant digits, or as an integer from 10 on."""
    return f"{length:.0f}" if abs(length) >= 10 else f"{length:.2g}"
