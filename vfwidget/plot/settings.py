"""A figure of the settings of a text: the boxes of the design space in which it has one row."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise, product
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_hex, to_rgb
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle

from ..arrays import Array, to_array
from ..errors import TextError
from ..font import Axis, Font, load_font
from ..text import AxisValues, Text
from .canvas import COLOURS, GREY, Panels, caption, draw_glyph, ink, panels, plain
from .subject import axis_label, left_out, location, text_title

MOST_PANELS = 6
SLIVER = 0.02
"""Share of the range of an axis in user values: a narrower part of it is not drawn."""
MOST_NAMES = 5
"""Glyphs of a row that the legend names."""
ROOM = 0.66
"""Share of a cell that its glyphs fill."""
PALE = 0.75
"""How far the colour of a row is mixed with white."""


class Side(NamedTuple):
    """The parts into which the conditions of a font divide one axis.

    Attributes
    ----------
    axis : Axis
    number : int
        The index of the axis.
    parts : list of (int, float, float)
        For each part that is drawn: its index among the cells, and its ends.
    """

    axis: Axis
    number: int
    parts: list[tuple[int, float, float]]


def settings(
    font_or_text: Font | Text,
    string: str | None = None,
    axes: AxisValues | None = None,
    ax: Axes | None = None,
) -> Panels:
    """Draw the boxes of the design space in which a text has one row of glyphs.

    A panel shows the two axes with most boundaries, and there is one panel for each combination
    of parts of the others. All parts of an axis are drawn equally wide; the ticks are the user
    values at which a glyph changes. Equal colours mean equal rows of glyphs.

    Parameters
    ----------
    font_or_text : Font, Text or what :func:`vfwidget.load_font` takes
    string : str
        A character or a text. Omit it for a Text; a font needs it.
    axes : axis values, as for :class:`vfwidget.Text`, optional
        User values of the axes that choose no glyph; those of the Text, or the default, if
        omitted.
    ax : matplotlib Axes, optional
        An Axes of a ``plt.subplots`` grid, which the panels replace. By default the function makes
        a new figure.

    Returns
    -------
    array of Axes
        One for each panel.

    Raises
    ------
    AxisError
        The font has no such axis.
    TextError, GlyphError
        The string is missing or empty, or the font lacks a character.
    VFWidgetError
        ``ax`` is not part of a grid.
    """
    if isinstance(font_or_text, Text):
        text = font_or_text if string is None else Text(font_or_text.font, string)
    else:
        font = load_font(font_or_text)
        if string is None:
            raise TextError('A font needs a string, as in vf.plot.settings(font, "a").')
        text = Text(font, string)
    w = text.coordinates[0] if axes is None else location(text.font, axes)
    text = text.at(shared=True)
    sides = _sides(text)
    across, others = sides[:2], sides[2:]
    combinations = list(product(*(side.parts for side in others)))
    host, made = panels(ax, min(len(combinations), MOST_PANELS))
    for panel, chosen in zip(made, combinations, strict=False):
        fixed = {side.number: part for side, part in zip(others, chosen, strict=True)}
        _draw_panel(panel, text, w, across, fixed)
        named = (_range(text.font, side, part) for side, part in zip(others, chosen, strict=True))
        panel.set_title(plain(", ".join(named)), fontsize="large")
    words = [text.composition.word((row,)) for row in range(len(text.composition.settings.rows))]
    legend = [
        Patch(facecolor=_colour(row), edgecolor=GREY, label=plain(name))
        for row, name in enumerate(_row_names([[g.name for g in word.glyphs] for word in words]))
    ]
    default = Line2D([], [], color=ink(), marker="o", fillstyle="none", ls="", label="default")
    host.legend(handles=[*legend, default], loc="outside right center", fontsize="medium")
    notes = [
        "" if sides else "The font chooses these glyphs everywhere.",
        left_out([f"{len(combinations) - MOST_PANELS} more panels"], "for lack of room")
        if len(combinations) > MOST_PANELS
        else "",
        "The font moves its axes (avar 2); the ticks are the coordinates after that."
        if text.font.moves_axes and sides
        else "",
    ]
    caption(host, text_title(text.moved(np.zeros_like(text.coordinates))), *notes)
    return made


def _sides(text: Text) -> list[Side]:
    """The axes on which glyphs change, those with most parts first."""
    lower, upper = text.font.bounds
    sides = []
    for i, (axis, inner) in enumerate(
        zip(text.font.axes, text.composition.settings.edges, strict=True)
    ):
        ends = [lower[i], *inner, upper[i]]
        users = [axis.minimum, *map(axis.denormalize, inner), axis.maximum]
        least = SLIVER * (axis.maximum - axis.minimum)
        parts = [
            (k, low, high)
            for k, (low, high) in enumerate(pairwise(ends))
            if users[k + 1] - users[k] > least
        ]
        if len(inner) and parts:
            sides.append(Side(axis, i, parts))
    return sorted(sides, key=lambda side: -len(side.parts))


def _draw_panel(
    panel: Axes, text: Text, w: Array, across: list[Side], fixed: Mapping[int, Any]
) -> None:
    """Draw the cells of two axes, or of one; ``fixed`` holds the parts of the others."""
    font, found = text.font, text.composition.settings
    counts = [len(side.parts) for side in across] + [1] * (2 - len(across))
    rows = np.empty(counts, dtype=int)
    for cell in np.ndindex(counts[0], counts[1]):
        parts = dict(fixed)
        parts |= {side.number: side.parts[k] for side, k in zip(across, cell, strict=False)}
        index = [parts[i][0] if i in parts else 0 for i in range(len(font.axes))]
        rows[cell] = found.cells[tuple(index)] if font.axes else 0
        panel.add_patch(Rectangle(cell, 1, 1, facecolor=_colour(rows[cell]), linewidth=0))
        _draw_text(panel, _inside(text, w, parts, rows[cell]), np.array(cell))
    for x, y in np.ndindex(counts[0], counts[1]):
        if x and rows[x - 1, y] != rows[x, y]:
            panel.plot([x, x], [y, y + 1], color=ink(), lw=1.5)
        if y and rows[x, y - 1] != rows[x, y]:
            panel.plot([x, x + 1], [y, y], color=ink(), lw=1.5)
    at = [_place(0.0, side) for side in across] + [0.1] * (2 - len(across))
    if all(part[1] <= 0.0 <= part[2] for part in fixed.values()):
        panel.plot(*at, color=ink(), marker="o", fillstyle="none", ms=9, clip_on=False)
    panel.set(xlim=(0, counts[0]), ylim=(0, counts[1]), aspect="equal", xticks=[], yticks=[])
    for side, shown in zip(across, (panel.xaxis, panel.yaxis), strict=False):
        ends = [side.parts[0][1], *(high for _, _, high in side.parts)]
        names = [_tick(font, side, end) for end in ends]
        shown.set_ticks(range(len(ends)), labels=names, fontsize="medium")
        shown.set_label_text(axis_label(side.axis), fontsize="large")


def _inside(text: Text, w: Array, parts: Mapping[int, Any], row: int) -> Text | None:
    """The text in the middle of a cell; None if no location is found at which it has the row."""
    theta = w.copy()
    for i, (_, low, high) in parts.items():
        theta[i] = w[i] if low < w[i] < high else (low + high) / 2
    moved = text.moved(theta[None])
    if text.font.moves_axes and moved.word.rows != (row,):
        rng = np.random.default_rng(0)
        tried = (text.moved(rng.uniform(*text.font.bounds)[None]) for _ in range(200))
        return next((one for one in tried if one.word.rows == (row,)), None)
    return moved


def _draw_text(panel: Axes, text: Text | None, corner: Array) -> None:
    """Draw a text in the unit square at a corner."""
    contours = [] if text is None else [to_array(cubics) for cubics in text.segments()]
    if text is None or not contours:
        return
    points = np.concatenate([cubics.reshape(-1, 2) for cubics in contours])
    low, high = points.min(0), points.max(0)
    scale = ROOM / max(*(high - low), 0.8 * text.font.units_per_em)
    middle = (low + high) / 2
    draw_glyph(panel, [scale * (cubics - middle) for cubics in contours], corner + 0.5)


def _place(w: float, side: Side) -> float:
    """Where a coordinate lies on an axis whose parts are equally wide."""
    ends = [side.parts[0][1], *(high for _, _, high in side.parts)]
    return float(np.interp(w, ends, range(len(ends))))


def _tick(font: Font, side: Side, end: float) -> str:
    if font.moves_axes:
        return f"{end:.3g}"
    lower, upper = (float(bound[side.number]) for bound in font.bounds)
    # A flat end of the segment map has many user values.
    ends = {lower: side.axis.minimum, upper: side.axis.maximum}
    return f"{round(ends.get(end, side.axis.denormalize(end)), 2):.4g}"


def _range(font: Font, side: Side, part: tuple[int, float, float]) -> str:
    low, high = (_tick(font, side, end) for end in part[1:])
    return f"{side.axis.tag} {low} to {high}"


def _row_names(rows: list[list[str]]) -> list[str]:
    """For each row the names of the glyphs that other rows replace."""
    if len({len(names) for names in rows}) > 1:
        return [_some(names) for names in rows]
    changing = [i for i in range(len(rows[0])) if len({names[i] for names in rows}) > 1]
    return [_some([names[i] for i in changing] or names) for names in rows]


def _some(names: list[str]) -> str:
    more = len(names) - MOST_NAMES
    return " ".join(names[:MOST_NAMES]) + (f" and {more} more" if more > 0 else "")


def _colour(row: int) -> str:
    rgb = np.array(to_rgb(COLOURS[row % len(COLOURS)]))
    return to_hex(tuple(rgb + PALE * (1 - rgb)))
