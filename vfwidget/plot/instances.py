"""A figure of a glyph at many locations of its design space."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from ..arrays import to_array
from ..font import Axis, Font, load_font
from ..text import AxisValues
from .canvas import BLUE, around, caption, draw_glyph, ink, plain
from .subject import (
    axis_index,
    axis_label,
    check_count,
    given,
    location,
    takes_part,
    title,
    two_axes,
)

MOST = 100
"""Values of an axis. With two axes, the square of their number is drawn."""
GAP = 0.12
"""Distance between glyphs, in em."""


def gallery(
    font: Font,
    glyph: str | int,
    tag: str,
    tag2: str | None = None,
    count: int = 5,
    axes: AxisValues | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Draw a glyph along one axis, or over two axes (Fig. 2, and the inset of Sec. 3).

    Parameters
    ----------
    font : Font or what :func:`vfwidget.load_font` takes
    glyph : str or int
        A character, a glyph name or a glyph id.
    tag, tag2 : str
        The horizontal axis and the vertical axis.
    count : int
        Number of values of each axis, 2 to 100. They have equal steps in user coordinates over
        the whole range; the inner value nearest to the default is replaced by the default.
    axes : axis values, as for :class:`vfwidget.Text`, optional
        User values of the other axes; the default instance if omitted.
    ax : matplotlib Axes, optional
        The Axes to draw in. By default the function makes a new figure.

    Returns
    -------
    Axes
        The Axes in font units. Each glyph is centred on its advance, the ticks are user
        coordinates, and the default of the axes shown is blue.

    Raises
    ------
    AxisError
        The font has no such axis, or both are the same.
    GlyphError
        The font has no such glyph.
    VFWidgetError
        ``count`` is not a whole number from 2 to 100.
    """
    font = load_font(font)
    shape = font.glyph(glyph)
    shown = [axis_index(font, tag)] if tag2 is None else [*two_axes(font, tag, tag2)]
    check_count("count", count, 2, MOST)
    across = [font.axes[i] for i in shown]
    stops = [_stops(axis, count) for axis in across]
    location(font, axes)  # raises AxisError if an axis is wrong
    values = given(font, axes).items()
    fixed = {other: value for other, value in values if other not in (tag, tag2)}
    instances = []
    for cell in np.ndindex(*map(len, stops)):
        users = {axis.tag: stop[k] for axis, stop, k in zip(across, stops, cell, strict=True)}
        w = location(font, fixed | users)
        middle = float(shape.advance(w)) / 2
        contours = [to_array(cubics) - [middle, 0] for cubics in shape.segments(w)]
        at_default = all(axis.default == users[axis.tag] for axis in across)
        instances.append(((*cell, 0)[:2], contours, at_default))

    # Every cell has the size of the largest glyph, and glyphs share a baseline in each row.
    every = np.concatenate(
        [np.zeros((0, 2)), *(c.reshape(-1, 2) for _, contours, _ in instances for c in contours)]
    )
    if not len(every):
        every = np.array([[0, 0], [0.3, 0.3]]) * font.units_per_em
    low, high = every[:, 1].min(), every[:, 1].max()
    size = np.array([2 * abs(every[:, 0]).max(), high - low]) + GAP * font.units_per_em
    grid = size * np.arange(count)[:, None]
    top = grid[-1, 1] if tag2 is not None else 0
    box = np.array([[-size[0] / 2, low], [grid[-1, 0] + size[0] / 2, top + high]])
    ax = around(ax, box, beside=0.6)
    for cell, contours, at_default in instances:
        draw_glyph(ax, contours, cell * size, facecolor=BLUE if at_default else ink())
    ax.set_xticks(grid[:, 0], [f"{user:.4g}" for user in stops[0]])
    if tag2 is not None:
        ax.set_yticks(grid[:, 1] + (low + high) / 2, [f"{user:.4g}" for user in stops[1]])
        ax.set_ylabel(axis_label(across[1]), fontsize="large")
    ax.tick_params(length=0, labelsize="large")
    still = [plain(font.axes[i].tag) for i in shown if not takes_part(shape)[:, i].any()]
    notes = ["" if shape.contours else "This glyph has no outline."]
    if still and shape.contours:
        notes.append(f"No delta set of this glyph depends on {' or '.join(still)}.")
    caption(ax, title(font, glyph, shape, fixed), axis_label(across[0]), *notes)
    return ax


def _stops(axis: Axis, count: int) -> list[float]:
    """User values over the whole range; one of the inner values is the default."""
    stops = np.linspace(axis.minimum, axis.maximum, count)
    if count > 2 and axis.minimum < axis.default < axis.maximum:
        stops[1 + abs(stops[1:-1] - axis.default).argmin()] = axis.default
    return [float(stop) for stop in stops]
