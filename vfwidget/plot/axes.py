"""Figures of the axes: their normalization, and the distance that each can move a glyph."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from matplotlib.axes import Axes

from ..arrays import Array, to_array
from ..errors import VFWidgetError
from ..font import Axis, Font, load_font
from ..text import AxisValues
from .canvas import (
    BLUE,
    GREY,
    VERMILLION,
    Panels,
    caption,
    number,
    panels,
    plain,
    single,
)
from .subject import (
    along,
    axis_index,
    axis_label,
    kinks,
    left_out,
    lengths,
    location,
    spaced,
    title,
)

MOST_AXES = 6
"""Number of panels, one for each axis, unless the caller names the axes."""
MOST_BARS = 24
"""Number of axes that a bar chart shows."""


def normalization(
    font: Font, tags: str | Iterable[str] | None = None, ax: Axes | None = None
) -> Panels:
    """Draw normalized over user coordinates, with and without the segment map (Fig. 4).

    Parameters
    ----------
    font : Font or what :func:`vfwidget.load_font` takes
    tags : str or sequence of str, optional
        The axes to show. By default up to six axes: first those whose segment map is not the
        identity, last the hidden ones.
    ax : matplotlib Axes, optional
        An Axes of a ``plt.subplots`` grid; the panels are drawn in its place. By default the
        function makes a new figure.

    Returns
    -------
    (count,) array of Axes
        One panel for each axis, in the order of the font. The horizontal axis shows user
        coordinates, the vertical axis normalized coordinates.

    Raises
    ------
    AxisError
        The font has no such axis.
    VFWidgetError
        ``tags`` is empty.
    """
    font = load_font(font)
    if tags is None:
        bent = [_corners(axis)[1:] for axis in font.axes]
        rank = [
            (axis.hidden, bool(np.allclose(*both)), i)
            for i, (axis, both) in enumerate(zip(font.axes, bent, strict=True))
        ]
        shown = sorted(i for *_, i in sorted(rank)[:MOST_AXES])
    else:
        tags = [tags] if isinstance(tags, str) else list(tags)
        wanted = {font.axes[axis_index(font, tag)].tag for tag in tags}
        shown = [i for i, axis in enumerate(font.axes) if axis.tag in wanted]
        if not shown:
            raise VFWidgetError("tags is empty; name at least one axis, or omit tags.")
    host, made = panels(ax, len(shown))
    for panel, axis in zip(made, [font.axes[i] for i in shown], strict=True):
        users, straight, mapped = _corners(axis)
        panel.plot(users, straight, "--", color=GREY, lw=2, label="without avar")
        panel.plot(users, mapped, "o-", color=BLUE, lw=2.5, ms=5, label="with avar")
        panel.plot([axis.default], [0], "o", color=VERMILLION, ms=9, label="default")
        panel.set_title(axis_label(axis), fontsize="large")
        panel.set_yticks(np.linspace(-1, 1, 5))
        panel.set_ylim(-1.1, 1.1)
        ends = [axis.minimum, axis.maximum, axis.default]
        panel.set_xticks(spaced(ends, 0.1 * (axis.maximum - axis.minimum)))
        panel.grid(alpha=0.3)
        if np.allclose(straight, mapped):
            panel.text(0.96, 0.08, "identity map", ha="right", transform=panel.transAxes)
    made[0].set_ylabel("normalized coordinate w", fontsize="large")
    made[0].legend(loc="best")
    rest = [plain(axis.tag) for i, axis in enumerate(font.axes) if i not in shown]
    caption(
        host,
        f"From user to normalized coordinates: {plain(font.family_name)}",
        "user coordinate s",
        left_out(rest, "hidden axes, or axes whose segment map is the identity")
        if tags is None
        else "",
    )
    return made


def _corners(axis: Axis) -> tuple[Array, Array, Array]:
    """User coordinates of the corners of a segment map, normalized without and with the map."""
    users, straight = [], []
    for source, _ in axis.segment_map:
        side = axis.minimum if source < 0 else axis.maximum
        if source == 0 or side != axis.default:
            users.append(axis.default + abs(source) * (side - axis.default))
            straight.append(source)
    return np.array(users), np.array(straight), np.array([axis.normalize(user) for user in users])


def axis_effect(
    font: Font,
    glyph: str | int,
    axes: AxisValues | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Draw the distance by which each single axis can move the control points of a glyph.

    Parameters
    ----------
    font : Font or what :func:`vfwidget.load_font` takes
    glyph : str or int
        A character, a glyph name or a glyph id.
    axes : axis values, as for :class:`vfwidget.Text`, optional
        User values of the axes that are held fixed while one axis runs through its range; the
        default instance if omitted.
    ax : matplotlib Axes, optional
        The Axes to draw in. By default the function makes a new figure.

    Returns
    -------
    Axes
        Two bars for each axis in font units; the axis with the largest displacement is at the
        top. The wide bar shows the largest displacement of any control point over the range of
        the axis. The narrow bar shows the mean of the largest displacements over all control
        points.

    Raises
    ------
    AxisError
        The font has no such axis.
    GlyphError
        The font has no such glyph.
    """
    font = load_font(font)
    shape = font.glyph(glyph)
    w = location(font, axes)
    here = to_array(shape.points(w))
    largest, mean = np.zeros(len(w)), np.zeros(len(w))
    for i in range(len(w)) if len(here) else ():
        # Along one axis a point moves on a polyline, so its distance is largest at a corner.
        values = kinks(font, shape, i).clip(font.bounds[0][i], font.bounds[1][i])
        farthest = lengths(to_array(shape.points(along(w, i, values))) - here).max(0)
        # Rounding removes the floating-point error of the sums.
        largest[i], mean[i] = farthest.max().round(6), farthest.mean().round(6)
    order = np.argsort(-largest, kind="stable")
    shown, rest = order[:MOST_BARS], order[MOST_BARS:]

    ax = single(ax, (9, 1.8 + 0.45 * len(shown)))
    rows = np.arange(len(shown))
    ax.barh(
        rows, largest[shown], 0.7, color=BLUE, alpha=0.35, label="largest of all control points"
    )
    ax.barh(rows, mean[shown], 0.35, color=BLUE, label="mean over control points")
    for row, i in enumerate(shown):
        ax.annotate(
            number(largest[i]) if largest[i] else "no displacement",
            (largest[i], row),
            (5, 0),
            textcoords="offset points",
            va="center",
        )
    ax.set_yticks(rows, [axis_label(font.axes[i]) for i in shown], fontsize="large")
    ax.invert_yaxis()
    ax.set_xlim(0, max(1.15 * largest.max(initial=0), 1))
    ax.spines[["top", "right"]].set_visible(False)
    ax.legend(loc="lower right", frameon=False)
    caption(
        ax,
        f"Displacement by each axis: {title(font, glyph, shape, axes)}",
        f"displacement in font units (1 em = {font.units_per_em})",
        "" if shape.contours else "This glyph has no outline.",
        left_out([plain(font.axes[i].tag) for i in rest], "axes with a smaller displacement"),
    )
    return ax
