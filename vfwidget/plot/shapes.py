"""Figures of outlines: their points, the motion by each axis, and the layout of a word."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgba
from matplotlib.lines import Line2D

from ..arrays import Array, to_array
from ..errors import GlyphError, TextError
from ..font import Font, Glyph, load_font
from ..outline.cubics import AREA
from ..text import AxisValues, Text
from .canvas import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PALE,
    SKY,
    VERMILLION,
    Panels,
    around,
    arrows,
    bare,
    caption,
    draw_glyph,
    fit,
    number,
    panels,
    plain,
)
from .subject import (
    OFFSET,
    axis_label,
    check_count,
    left_out,
    lengths,
    location,
    text_title,
    title,
)

MOST_AXES = 6
MOST_SAMPLES = 1000
MOST_LETTERS = 12
"""A longer word is drawn without numbers, because they would overlap."""
NORMAL, DIRECTION = 0.05, 0.08
"""Lengths of the drawn normals and direction arrows, in em."""
ARROW = 0.25
"""Length of the longest arrow of a panel, as a share of the larger side of the outline."""


def outline(
    font_or_text: Font | Text,
    glyph: str | int | None = None,
    axes: Any = None,
    samples: int = 1,
    ax: Axes | None = None,
) -> Axes:
    """Draw the control points, handles, direction, points and normals of an outline.

    Parameters
    ----------
    font_or_text : Font, Text or what :func:`vfwidget.load_font` takes
    glyph : str or int, optional
        A character, a glyph name or a glyph id. For a text it selects a letter by its index (as
        in :meth:`vfwidget.Text.handle`), character or glyph name; all letters if omitted.
    axes : axis values, as for :class:`vfwidget.Text`, optional
        The instance. If omitted, the default instance of a font, or the axes of a text. For a
        text, anything that :meth:`vfwidget.Text.at` accepts.
    samples : int
        Number of points with a normal on each segment, at equal steps of its parameter, 0 to 1,000.
        Default 1.
    ax : matplotlib Axes, optional
        The Axes to draw in. By default the function makes a new figure.

    Returns
    -------
    Axes
        The Axes in font units. The normals are unit vectors that point out of the ink.

    Raises
    ------
    AxisError
        The font has no such axis.
    GlyphError
        The font has no such glyph, or the text no such letter.
    VFWidgetError
        ``samples`` is not a whole number from 0 to 1,000.
    """
    check_count("samples", samples, 0, MOST_SAMPLES)
    if isinstance(font_or_text, Text):
        font, contours, name = _letters(font_or_text, glyph, axes)
    else:
        font = load_font(font_or_text)
        shape = font.glyph(glyph)  # type: ignore[arg-type] # glyph() reports None
        contours = [to_array(cubics) for cubics in shape.segments(location(font, axes))]
        name = title(font, glyph, shape, axes)
    em = font.units_per_em
    cubics = np.concatenate([np.zeros((0, 4, 2)), *contours])

    points, tangents = _sample(cubics, (np.arange(samples) + 0.5) / max(samples, 1))
    normals = tangents[:, ::-1] * [-1, 1] * _outside(cubics)
    tips = points + NORMAL * em * normals

    ax = around(ax, np.concatenate([cubics.reshape(-1, 2), tips, *_blank(font, cubics)]), 3)
    draw_glyph(ax, contours, **PALE)
    draw_glyph(ax, contours, facecolor="none", edgecolor=GREY, linewidth=1.5)
    ax.add_collection(LineCollection(list(cubics.reshape(-1, 2, 2)), colors=SKY, linewidths=1.5))
    ax.plot(*cubics[:, 0].T, "s", color=BLUE, ms=5)
    ax.plot(*cubics[:, 1:3].reshape(-1, 2).T, "o", color=SKY, mfc="white", ms=4)
    ax.plot(*points.T, ".", color=GREEN, ms=5)
    bare_shaft = {"headwidth": 0, "headlength": 0, "headaxislength": 0}
    arrows(ax, points, normals, GREEN, NORMAL * em, **bare_shaft)
    # One arrow for each quarter of a contour.
    starts = [contour[:: max(len(contour) // 4, 1)][:4] for contour in contours]
    for quarters in starts:
        points, tangents = _sample(quarters, np.array([0.5]))
        length = DIRECTION * em
        arrows(ax, points, tangents, VERMILLION, length, width=0.045, headwidth=3, headlength=3)
    if len(cubics):
        _key(ax)
    caption(ax, name, "" if len(cubics) else "This glyph has no outline.")
    return ax


def _letters(text: Text, letter: str | int | None, axes: Any) -> tuple[Font, list[Array], str]:
    """Return the font, the contours of one letter or of all letters, and a title."""
    text = text if axes is None else text.at(axes=axes)
    owners = [i for i, glyph in enumerate(text.glyphs) for _ in glyph.contours]
    contours = [to_array(cubics) for cubics in text.segments()]
    name = text_title(text)
    if letter is None:
        return text.font, contours, name
    if isinstance(letter, str):
        names = [glyph.name for glyph in text.glyphs]
        wanted = text.font.glyph(letter).name
        letter = names.index(wanted) if wanted in names else len(names)
    if not 0 <= letter < len(text.glyphs):
        raise GlyphError(
            f"{text.string!r} has {len(text.glyphs)} letters; the requested one is not among them."
        )
    own = [cubics for owner, cubics in zip(owners, contours, strict=True) if owner == letter]
    return text.font, own, f"letter {letter} of {name}"


def _sample(cubics: Array, t: Array) -> tuple[Array, Array]:
    """Points of cubics (s, 4, 2) at parameters (j,), and unit tangents there, each (p, 2).

    Parameters at which the tangent is zero, as on a segment of length 0, give no sample.
    """
    u = 1 - t
    weights = np.stack([u**3, 3 * u * u * t, 3 * u * t * t, t**3], -1)
    slopes = np.stack([u * u, 2 * u * t, t * t], -1)
    points = (weights @ cubics).reshape(-1, 2)
    tangents = (slopes @ np.diff(cubics, axis=1)).reshape(-1, 2)
    length = lengths(tangents)
    sound = length > 0
    return points[sound], tangents[sound] / length[sound, None]


def _outside(cubics: Array) -> int:
    """1 if the outside is to the left of the direction of an outline, -1 if to the right."""
    area = np.einsum("si,ij,sj", cubics[..., 0], AREA, cubics[..., 1])
    return 1 if area <= 0 else -1


def _key(ax: Axes) -> None:
    """Draw the legend of :func:`outline`; matplotlib makes no legend entries for arrows."""
    signs = {
        "on-curve point": {"marker": "s", "color": BLUE, "ls": ""},
        "off-curve point, handle": {"marker": "o", "color": SKY, "mfc": "white"},
        "direction of the contour": {"marker": ">", "color": VERMILLION},
        "point on the outline, normal": {"marker": ".", "color": GREEN, "lw": 2},
    }
    lines = [Line2D([], [], label=label, **sign) for label, sign in signs.items()]  # type: ignore
    ax.legend(handles=lines, loc="upper left", bbox_to_anchor=(1, 1), frameon=False)


def _blank(font: Font, points: Array) -> list[Array]:
    """Return points that give an empty figure a size."""
    return [] if len(points) else [np.array([[0, 0], [1, 0.3]]) * font.units_per_em]


def jacobian(
    font: Font,
    glyph: str | int,
    axes: AxisValues | None = None,
    ax: Axes | None = None,
) -> Panels:
    """Draw the motion of each point by each axis: the columns of ∂p/∂w as arrows.

    Parameters
    ----------
    font : Font or what :func:`vfwidget.load_font` takes
    glyph : str or int
        A character, a glyph name or a glyph id.
    axes : axis values, as for :class:`vfwidget.Text`, optional
        The instance; the default instance if omitted.
    ax : matplotlib Axes, optional
        An Axes of a ``plt.subplots`` grid; the panels are drawn in its place. By default the
        function makes a new figure.

    Returns
    -------
    (count,) array of Axes
        One panel for each of up to six axes that move the outline here, in the order of their
        effect, with arrows at the on-curve points. Blue arrows show the motion when the axis value
        increases. Orange arrows show the motion when it decreases; they are drawn at a kink and at
        the upper end of the axis, where the two motions are not opposite. The data of the arrows
        are font units per normalized unit. Each panel has its own scale and names the length of
        its longest arrow.

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
    points = to_array(shape.points(w))[::3]
    rising, falling = _pulls(font, shape, w)
    pull = np.maximum(lengths(rising), lengths(falling)).max(0, initial=0)
    order = np.argsort(-pull, kind="stable")
    shown = [int(i) for i in order[:MOST_AXES] if pull[i] > 0]
    still = [plain(font.axes[i].tag) for i in order if pull[i] == 0]
    weaker = [plain(font.axes[i].tag) for i in order[MOST_AXES:] if pull[i] > 0]

    host, made = panels(ax, max(len(shown), 1))
    side = np.ptp(points, axis=0).max() if len(points) else 1
    tips = [points, *_blank(font, points)]
    for panel, i in zip(made, shown, strict=False):
        scale = ARROW * side / pull[i]
        for vectors, colour in (falling[:, i], ORANGE), (rising[:, i], BLUE):
            if lengths(vectors).any():
                arrows(panel, points, vectors, colour, scale)
                tips.append(points + scale * vectors)
        panel.set_title(
            f"{axis_label(font.axes[i])}\nlongest arrow: {number(pull[i])}", fontsize="large"
        )
    for panel in made:
        bare(panel)
        draw_glyph(panel, shape.segments(w), **PALE)
        fit(panel, *tips)
    caption(
        host,
        f"Motion by each axis: {title(font, glyph, shape, axes)}",
        "blue: motion when the axis value increases\n"
        "orange: motion when it decreases, drawn only if it is not the opposite of blue\n"
        "lengths: font units per unit of the normalized coordinate"
        if shown
        else "No axis moves the outline of this glyph here.",
        left_out(weaker, "axes with a smaller effect"),
        left_out(still, "axes without an effect here") if shown else "",
    )
    return made


def _pulls(font: Font, glyph: Glyph, w: Array) -> tuple[Array, Array]:
    """Motion of the on-curve points when each axis increases and decreases, two (p, n, 2) arrays.

    A motion is zero if the axis is at its bound. The decrease is also zero if it is the opposite of
    the increase.
    """
    n = len(w)
    below = (w - OFFSET * np.eye(n)).clip(-1)
    right = to_array(glyph.jacobian(w))[::3].swapaxes(1, 2)
    left = to_array(glyph.jacobian(below))[np.arange(n), ::3, :, np.arange(n)].swapaxes(0, 1)
    low, high = font.bounds
    at_top, at_bottom = w >= high, w <= low
    same = np.isclose(left, right, atol=1e-6 * (1 + abs(right).max(initial=0))).all((0, 2))
    rising = np.where(at_top[:, None], 0, right)
    falling = np.where((at_bottom | (same & ~at_top))[:, None], 0, -left)
    return rising, falling


def layout(text: Text, ax: Axes | None = None) -> Axes:
    """Draw the side bearings and advances of a word (Fig. 8, Eq. 3).

    Parameters
    ----------
    text : Text
    ax : matplotlib Axes, optional
        The Axes to draw in. By default the function makes a new figure.

    Returns
    -------
    Axes
        The Axes in font units; the origin of the word is at 0. Vertical lines mark the origins of
        the letters, arrows below the baseline their advances, and bands their left and right side
        bearings. A negative side bearing is hatched and has a frame. A word of more than twelve
        letters has no numbers.

    Raises
    ------
    TextError
        ``text`` is no Text.
    """
    if not isinstance(text, Text):
        raise TextError(
            f'text must be a Text, such as vf.Text(font, "hand"); received {type(text).__name__}.'
        )
    theta = to_array(text.theta)
    font = text.font
    origins = [placed.x for placed in text.layout]
    rows = list(np.broadcast_to(theta, (len(text.glyphs), theta.shape[1])))
    widths = [float(g.advance(w)) for g, w in zip(text.glyphs, rows, strict=True)]
    # A mark may have a width in the font; HarfBuzz sets it without one.
    advances = [width * own for width, own in zip(widths, text.word.origins.is_base, strict=True)]
    bearings = [
        [float(side) for side in g.side_bearings(w)] for g, w in zip(text.glyphs, rows, strict=True)
    ]
    for sides, width, advance in zip(bearings, widths, advances, strict=True):
        sides[1] += advance - width
    numbers = len(text.glyphs) <= MOST_LETTERS
    em, end = font.units_per_em, text.advance()
    points = to_array(text.points())
    low, high = (
        (points[:, 1].min(), points[:, 1].max()) if len(points) else (font.descender, font.ascender)
    )
    top, bottom = max(high, 0) + 0.1 * em, min(low, 0) - 0.05 * em
    foot = bottom - 0.1 * em

    corners = np.array([[0, foot - 0.15 * em], [end, top + 0.2 * em]])
    ax = around(ax, np.concatenate([corners, points]), 2.5, (11, 5))
    draw_glyph(ax, text.segments(), facecolor=GREY)
    ax.axhline(0, color=GREY, lw=1, zorder=0)
    for glyph, x, advance, sides in zip(text.glyphs, origins, advances, bearings, strict=True):
        ax.plot([x, x], [foot, top], color=BLUE, lw=1.5)
        if advance:
            style = {"arrowstyle": "<->", "color": BLUE, "lw": 1.5, "shrinkA": 0, "shrinkB": 0}
            ax.annotate("", (x + advance, foot), (x, foot), arrowprops=style)
        edges = [(x, x + sides[0]), (x + advance - sides[1], x + advance)]
        for (a, b), colour, side in zip(edges, (VERMILLION, GREEN), sides, strict=True):
            band = ax.fill_betweenx([bottom, top], a, b, fc=to_rgba(colour, 0.4), lw=0, zorder=2)
            if side < 0:
                # The frame is visible even if the band is too thin for the hatching.
                band.set(hatch="////", edgecolor=colour, linewidth=1.5)
        labels = [(x + advance / 2, foot, (0, -16), "center", BLUE, advance)]
        if glyph.contours:
            # Two levels, because a right side bearing touches the next left side bearing.
            labels.append((x, top, (3, 2), "left", VERMILLION, sides[0]))
            labels.append((x + advance, top, (-3, 17), "right", GREEN, sides[1]))
        for where, height, offset, side_of, colour, length in labels if numbers else ():
            ax.annotate(
                number(length),
                (where, height),
                offset,
                textcoords="offset points",
                ha=side_of,
                color=colour,
                fontsize="large",
            )
    ax.plot([end, end], [foot, top], color=BLUE, lw=1.5)
    signs = [
        Line2D([], [], color=BLUE, label="origin and advance"),
        Line2D([], [], color=VERMILLION, lw=8, alpha=0.4, label="left side bearing"),
        Line2D([], [], color=GREEN, lw=8, alpha=0.4, label="right side bearing"),
    ]
    ax.legend(handles=signs, loc="upper left", bbox_to_anchor=(1, 1), frameon=False)
    caption(
        ax,
        text_title(text),
        f"font units (1 em = {em})",
        "hatched with a frame: negative side bearing" if np.min(bearings) < 0 else "",
        "" if numbers else f"A line of more than {MOST_LETTERS} letters has no numbers.",
    )
    return ax
