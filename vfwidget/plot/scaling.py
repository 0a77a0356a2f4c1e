"""Figures of Eq. 1–2: support functions, their products γ, and the scaled delta sets."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ..arrays import Array, to_array
from ..font import Font, Glyph, load_font
from ..text import AxisValues
from .canvas import (
    BLUE,
    COLOURS,
    GREY,
    PALE,
    VERMILLION,
    Panels,
    arrows,
    bare,
    caption,
    draw_glyph,
    fit,
    panels,
    plain,
    single,
)
from .subject import (
    axis_index,
    axis_label,
    factors,
    kinks,
    location,
    numbered,
    reach,
    spaced,
    strength,
    takes_part,
    title,
    two_axes,
)

MOST_SUPPORTS = 6
MOST_SCALARS = 6
MOST_DELTA_SETS = 3
GRID = 61
"""Number of values along each axis of a surface, in addition to the kinks."""
LEVELS = np.linspace(0, 1, 11)


def support(font: Font, glyph: str | int, tag: str, ax: Axes | None = None) -> Axes:
    """Draw the support functions φ of the delta sets of a glyph along one axis (Fig. 5b).

    Parameters
    ----------
    font : Font or what :func:`vfwidget.load_font` takes
    glyph : str or int
        A character, a glyph name or a glyph id.
    tag : str
        The tag of the axis.
    ax : matplotlib Axes, optional
        The Axes to draw in. By default the function makes a new figure.

    Returns
    -------
    Axes
        φ over the normalized coordinate; the upper axis shows user coordinates. Delta sets with
        the same support share a line. The line is dashed if all of them also depend on another
        axis. If there are more than six supports, the figure shows those of the delta sets that
        move the outline farthest.

    Raises
    ------
    AxisError
        The font has no such axis.
    GlyphError
        The font has no such glyph.
    """
    font = load_font(font)
    shape = font.glyph(glyph)
    i = axis_index(font, tag)
    depends, effect = takes_part(shape), strength(shape)
    groups: dict[tuple[float, ...], list[int]] = {}
    for j in np.flatnonzero(depends[:, i]):
        groups.setdefault(tuple(shape.affine.support[j, i]), []).append(int(j))
    by_effect = sorted(groups, key=lambda row: -effect[groups[row]].max())
    shown = sorted(by_effect[:MOST_SUPPORTS], key=lambda row: (row[1], row))

    ax = single(ax, (10, 5))
    low, high = reach(font, i)
    w = kinks(font, shape, i)
    phi = factors(shape, i, w)
    for row, colour in zip(shown, COLOURS, strict=False):
        sets = groups[row]
        alone = any(depends[j].sum() == 1 for j in sets)
        label = numbered(sets) + ("" if alone else ", also other axes")
        ax.plot(w, phi[:, sets[0]], "-" if alone else "--", color=colour, lw=2.5, label=label)
        ax.fill_between(w, phi[:, sets[0]], color=colour, alpha=0.1, lw=0)
    if shown:
        ax.legend(title="delta sets", bbox_to_anchor=(1, 1), loc="upper left", frameon=False)
    else:
        ax.plot([low, high], [1, 1], "--", color=GREY, lw=2.5)
    ax.set_xlim(low, high)
    ax.set_ylim(-0.03, 1.08)
    ax.set_ylabel("support function φ(w)", fontsize="large")
    ax.spines[["top", "right"]].set_visible(False)
    _user_ticks(ax, font, i, [low, high, 0, *(row[1] for row in shown)])
    hidden = len(groups) - len(shown)
    caption(
        ax,
        f"Support functions along {axis_label(font.axes[i])}: {title(font, glyph, shape)}",
        f"normalized {plain(tag)}",
        "" if shape.contours else "This glyph has no outline.",
        "" if shown else f"No delta set of this glyph depends on {plain(tag)}: φ is 1 everywhere.",
        f"Not shown: {hidden} supports of delta sets with a smaller effect." if hidden else "",
    )
    return ax


def _user_ticks(ax: Axes, font: Font, i: int, places: list[float]) -> None:
    """Write user coordinates at the top; earlier places have priority where room is short."""
    low, high = reach(font, i)
    kept = spaced([w for w in places if low <= w <= high], 0.06 * (high - low))
    top = ax.secondary_xaxis("top")
    top.set_xticks(kept, [f"{font.axes[i].denormalize(w):.4g}" for w in kept])
    top.set_xlabel(f"user {plain(font.axes[i].tag)}")


def scalars(
    font: Font,
    glyph: str | int,
    tag: str,
    tag2: str,
    axes: AxisValues | None = None,
    surface: bool = False,
    ax: Axes | None = None,
) -> Panels:
    """Draw the scalars γ of delta sets over two axes (Fig. 7, top; as surfaces, Fig. 6).

    The paper calls a scalar a *scaling factor*.

    Parameters
    ----------
    font : Font or what :func:`vfwidget.load_font` takes
    glyph : str or int
        A character, a glyph name or a glyph id.
    tag, tag2 : str
        The horizontal axis and the vertical axis.
    axes : axis values, as for :class:`vfwidget.Text`, optional
        The instance that a dot marks; the default instance if omitted. It also fixes the axes
        that are not shown.
    surface : bool
        If True, draw surfaces in space, with the two support functions on the back planes. By
        default False: draw maps.
    ax : matplotlib Axes, optional
        An Axes of a ``plt.subplots`` grid; the panels are drawn in its place. By default the
        function makes a new figure.

    Returns
    -------
    (count,) array of Axes
        One panel in normalized coordinates for each of up to six delta sets, in the order of
        their effect on the outline. The delta sets depend on these axes and have a nonzero scalar
        somewhere on the slice. If there is no such delta set, the array holds one empty panel.

    Raises
    ------
    AxisError
        The font has no such axis, or both are the same.
    GlyphError
        The font has no such glyph.
    """
    font = load_font(font)
    shape = font.glyph(glyph)
    pair = two_axes(font, tag, tag2)
    w = location(font, axes)
    grids, walls = [], []
    for i in pair:
        grid = np.union1d(kinks(font, shape, i), np.linspace(*reach(font, i), GRID))
        grids.append(grid)
        walls.append(factors(shape, i, grid))
    # The factor of every γ that comes from the axes that are not shown.
    others = [factors(shape, i, w[i])[0] for i in range(len(w)) if i not in pair]
    rest = np.prod([np.ones(len(shape.affine.support)), *others], axis=0)
    height = walls[0].max(0) * walls[1].max(0) * rest
    effect = height * strength(shape) * takes_part(shape)[:, pair].any(1)
    order = np.argsort(-effect, kind="stable")[: np.count_nonzero(effect)]
    shown = [int(j) for j in order[:MOST_SCALARS]]

    host, made = panels(ax, max(len(shown), 1), projection="3d" if surface and shown else None)
    here = to_array(shape.scalars(w)) + 0.0  # turns a negative zero into 0
    for panel, j in zip(made, shown, strict=False):
        gamma = walls[1][:, None, j] * walls[0][None, :, j] * rest[j]
        if surface:
            _surface(panel, grids, gamma, [wall[:, j] for wall in walls])
            dot = {"color": "black", "edgecolor": "white", "linewidth": 1.5, "s": 90, "zorder": 4}
            panel.scatter(*w[list(pair)], here[j], depthshade=False, **dot)
        else:
            drawn = panel.contourf(*grids, gamma, LEVELS, cmap="viridis")
            dot = {"color": "black", "mec": "white", "mew": 2, "ms": 10, "clip_on": False}
            panel.plot(*w[list(pair)][:, None], "o", **dot)
        panel.set_title(f"set {j}: γ(w) = {here[j]:.3g}", fontsize="large")
        panel.set_xlabel(plain(tag))
        panel.set_ylabel(plain(tag2), labelpad=8 if surface else None)
    if not shown:
        bare(made[0])
    elif not surface:
        bar = host.colorbar(drawn, ax=list(made), ticks=LEVELS[::5], shrink=0.8)
        bar.ax.set_title("γ", fontsize="large")
    smaller, none = len(order) - len(shown), len(effect) - len(order)
    caption(
        host,
        f"Scalars γ of delta sets: {title(font, glyph, shape, axes)}",
        "normalized coordinates; the dot is the instance w"
        if shown
        else f"No delta set of this glyph varies with {plain(tag)} or {plain(tag2)} here.",
        "" if shape.contours else "This glyph has no outline.",
        f"back planes: support functions, orange along {plain(tag)}, blue along {plain(tag2)}"
        if surface and shown
        else "",
        f"Not shown: {smaller} delta sets with a smaller effect." if smaller else "",
        f"Not shown: {none} delta sets that are constant here." if none and shown else "",
    )
    return made


def _surface(panel: Any, grids: list[Array], gamma: Array, walls: list[Array]) -> None:
    """Draw γ as a surface, and its factors, the support functions, on the back planes."""
    # Set the drawing order here: back planes, surface, dot.
    panel.computed_zorder = False
    panel.plot(grids[0], walls[0], zs=grids[1][-1], zdir="y", color=VERMILLION, lw=2.5, zorder=1)
    panel.plot(grids[1], walls[1], zs=grids[0][0], zdir="x", color=BLUE, lw=2.5, zorder=1)
    x, y = np.meshgrid(*grids)
    style = {"cmap": "viridis", "vmin": 0, "vmax": 1, "rcount": 40, "ccount": 40}
    panel.plot_surface(x, y, gamma, alpha=0.85, zorder=2, **style)
    panel.set_zlim(0, 1)
    panel.locator_params(nbins=2)


def delta_sets(font: Font, glyph: str | int, axes: AxisValues, ax: Axes | None = None) -> Panels:
    """Draw Eq. 1 as a sum: default + scaled delta sets = outline (Figs. 5a and 7, bottom).

    Parameters
    ----------
    font : Font or what :func:`vfwidget.load_font` takes
    glyph : str or int
        A character, a glyph name or a glyph id.
    axes : axis values, as for :class:`vfwidget.Text`
        The instance.
    ax : matplotlib Axes, optional
        An Axes of a ``plt.subplots`` grid; the panels are drawn in its place. By default the
        function makes a new figure.

    Returns
    -------
    (count,) array of Axes
        The panels, all at one scale: the default outline; the delta sets with a nonzero scalar;
        the outline at ``axes``. A delta set is drawn as arrows γ Δ at the on-curve points. The
        three with the largest effect have a panel each, and one panel shows the sum of the others.

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
    default, end = shape.affine.base, to_array(shape.points(w))
    gamma = to_array(shape.scalars(w))
    effect = gamma * strength(shape)
    order = [int(j) for j in np.argsort(-effect, kind="stable")[: np.count_nonzero(effect)]]
    # If only one is left, it gets its own panel, because a sum of one needs the same room.
    most = MOST_DELTA_SETS + (len(order) == MOST_DELTA_SETS + 1)
    parts = [[j] for j in order[:most]] + ([order[most:]] if order[most:] else [])
    moved = [shape.affine.deltas[..., sets] @ gamma[sets] for sets in parts]

    host, made = panels(ax, len(parts) + 2)
    start = [to_array(cubics) for cubics in shape.segments(np.zeros(len(w)))]
    draw_glyph(made[0], start, facecolor=GREY)
    draw_glyph(made[-1], start, **PALE)
    draw_glyph(made[-1], shape.segments(w))
    made[0].set_title("default", fontsize="large")
    made[-1].set_title("outline at w", fontsize="large")
    for panel, sets, by in zip(made[1:-1], parts, moved, strict=True):
        draw_glyph(panel, start, **PALE)
        alone = shape.contours.split(default + by)
        draw_glyph(panel, alone, facecolor="none", edgecolor=VERMILLION, linewidth=0.8)
        arrows(panel, default[::3], by[::3], VERMILLION)
        heading = f"sum of {len(sets)}\nother sets"
        if len(sets) == 1:
            heading = f"set {sets[0]}\nγ = {gamma[sets[0]]:.3g}"
            panel.set_xlabel(_peaks(font, shape, sets[0]))
        panel.set_title(heading, fontsize="large")
    box = [default, end, *(default + by for by in moved)]
    box = box if len(default) else [np.array([[0, 0], [1, 0.3]]) * font.units_per_em]
    for panel, sign in zip(made, ["", *"+" * len(parts), "="], strict=True):
        bare(panel)
        fit(panel, *box)
        panel.text(-0.02, 0.5, sign, transform=panel.transAxes, ha="right", va="center", size=24)
    caption(
        host,
        title(font, glyph, shape, axes),
        "" if shape.contours else "This glyph has no outline.",
        "Every γ is 0 here, so no delta set has an effect." if shape.contours and not parts else "",
    )
    return made


def _peaks(font: Font, glyph: Glyph, j: int) -> str:
    """The peak of a delta set on the axes that it depends on."""
    support, depends = glyph.affine.support[j], takes_part(glyph)[j]
    parts = [
        f"{plain(axis.tag)} {peak:.3g}"
        for axis, (_, peak, _), own in zip(font.axes, support, depends, strict=True)
        if own
    ]
    return "γ = 1 at " + ", ".join(parts)
