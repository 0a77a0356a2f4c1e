"""Instances of a font as font files: axes pinned or narrowed, and only the glyphs of a text.

fontTools' instancer and subsetter do the work.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from numbers import Real
from typing import Any
from unicodedata import normalize

from fontTools import subset
from fontTools.fontBuilder import FontBuilder
from fontTools.ttLib import TTFont
from fontTools.ttLib.tables._g_l_y_f import USE_MY_METRICS
from fontTools.varLib import instancer

from ..arrays import Array
from ..errors import AxisError, FontError
from .alternates import add_alternates
from .axes import Axis
from .metrics import Advances
from .names import family_name
from .source import damage, saved

AxisLimits = dict[str, float | tuple[float, ...]]
FAMILY, STYLE, UNIQUE, FULL, POSTSCRIPT = 1, 2, 3, 4, 6
OTHER_NAMES = (16, 17, 21, 22, 25)
"""Names that would group the instance with its parent (typographic family and style, and such)."""

LONGEST_NAME = 255
"""Characters of a family name: file systems and font menus end there."""


def check_limits(axes: Sequence[Axis], values: Mapping[str, Any]) -> AxisLimits:
    """What is asked of each axis: a number, or a range.

    Raises
    ------
    AxisError
        The font has no axes, the values are no mapping, an axis is unknown, or a value is not a
        number or an ascending range within the axis.
    """
    if not isinstance(values, Mapping):
        raise AxisError(
            "An instance needs axis values by tag, such as {'wght': 700}; "
            f"received {values!r:.200}."
        )
    if not axes:
        raise AxisError("This font has no axes that could be pinned or narrowed: it is static.")
    known = {axis.tag: axis for axis in axes}
    limits: AxisLimits = {}
    for tag, value in values.items():
        if tag not in known:
            raise AxisError(f"Unknown axis {tag!r}. This font has: {', '.join(known)}.")
        axis = known[tag]
        sides = _sides(value)
        ends = [axis.minimum, *sides, axis.maximum]
        # Written so that NaN is refused, too.
        if len(sides) not in (1, 2, 3) or not all(a <= b for a, b in pairwise(ends)):
            raise AxisError(
                f"Axis {tag!r} needs a number, or a range (least, greatest) or (least, default, "
                f"greatest), within {axis.minimum:g} … {axis.maximum:g}; received {value!r}."
            )
        limits[tag] = sides[0] if len(sides) == 1 else sides
    return limits


def _sides(value: Any) -> tuple[Any, ...]:
    """A number or a range as a tuple of numbers; empty if it is neither."""
    sides = tuple(value) if isinstance(value, tuple | list) else (value,)
    return tuple(map(float, sides)) if all(isinstance(s, Real) for s in sides) else ()


def new_defaults(axes: Sequence[Axis], limits: AxisLimits) -> dict[str, float]:
    """The user values by tag at which an instance has its default."""
    found = {axis.tag: axis.default for axis in axes if axis.tag in limits}
    for tag, limit in limits.items():
        sides = _sides(limit)
        found[tag] = min(max(found[tag], sides[0]), sides[-1]) if len(sides) < 3 else sides[1]
    return found


def instantiate(
    font: TTFont, limits: AxisLimits, w: Array, name: str | None, string: str | None
) -> bytes:
    """A font file with axes pinned or narrowed.

    Parameters
    ----------
    font : TTFont
        Read from the file for this purpose; it is changed.
    limits : mapping of tag to number or range
        Axes that are not in the mapping stay as they are.
    w : (n,) array
        The coordinates of the new default at which the font's regions apply.
    name : str, optional
        Family name of the instance; by default the parent's, followed by the pinned values.
    string : str, optional
        Keep only the glyphs that this text may need.

    Raises
    ------
    FontError
        The name is no name or the text is empty, or fontTools cannot make the instance; the message
        gives its reason.
    """
    if name is None:
        name = " ".join([family_name(font), *map(_label, limits.items())])
    elif not _is_name(name):
        raise FontError(
            f"name must be a string of 1 to {LONGEST_NAME} printable characters; "
            f"received {name!r:.200}."
        )
    with damage("No instance can be made of this font"):
        if string is not None:
            _keep_glyphs(font, string)
        widths = Advances(font, len(w)).at(w, font.getGlyphOrder())
        font = instancer.instantiateVariableFont(font, limits, inplace=True)
        _set_widths(font, widths or _lent_widths(font))
        if "name" in font:
            _rename(font, name)
        return saved(font)


def web_font(font: TTFont, string: str, alternates: Mapping[str, Sequence[str]]) -> bytes:
    """A WOFF2 file with every axis, and only the glyphs that a text may need.

    Parameters
    ----------
    font : TTFont
        Read from the file for this purpose; it is changed.
    string : str
    alternates : mapping of glyph name to glyph names
        See :func:`~vfwidget.font.alternates.add_alternates`.

    Raises
    ------
    FontError
        The text is empty, or fontTools cannot make the file; the message gives its reason.
    """
    with damage("No web font can be made of this font"):
        _keep_glyphs(font, string)
        if alternates:
            add_alternates(font, alternates)
        _complete(font)
        font.recalcTimestamp = False  # the same text gives the same file
        return saved(font, "woff2")


def _complete(font: TTFont) -> None:
    """Add the tables without which browsers refuse a font, where the file lacks them."""
    builder = FontBuilder(font=font)
    if "name" not in font:
        builder.setupNameTable({"familyName": family_name(font), "styleName": "Regular"})
    if "post" not in font:
        builder.setupPost(keepGlyphNames=False)
    if "OS/2" not in font:
        builder.setupOS2()


def _is_name(name: Any) -> bool:
    return isinstance(name, str) and name.isprintable() and 1 <= len(name.strip()) <= LONGEST_NAME


def _keep_glyphs(font: TTFont, string: str) -> None:
    if not isinstance(string, str) or not string:
        raise FontError(
            f"string must be a text of at least one character; received {string!r:.200}."
        )
    options = subset.Options(layout_features=["*"], name_IDs=["*"], notdef_outline=True)
    subsetter = subset.Subsetter(options)
    subsetter.populate(text=string + _alike(font, string))
    subsetter.subset(font)


def _alike(font: TTFont, string: str) -> str:
    """The characters of a font that are made of the same letters and marks as those of a text.

    HarfBuzz may set a letter and its mark as one character, or the other way round.
    """
    parts = set(normalize("NFD", string))
    characters = map(chr, font.getBestCmap() or {})
    return "".join(c for c in characters if parts.issuperset(normalize("NFD", c)))


def _set_widths(font: TTFont, widths: Mapping[str, float]) -> None:
    """Give glyphs their advance widths at the default.

    The instancer takes them from the phantom points of the glyphs themselves. HVAR, which is used
    where a font has it, may differ from these by many units, and so may those of a component.
    """
    metrics = font["HMTX" if "HMTX" in font else "hmtx"].metrics if widths else {}
    for name, width in widths.items():
        metrics[name] = (round(width), metrics[name][1])


def _lent_widths(font: TTFont) -> dict[str, int]:
    """The widths of the glyphs that take their metrics from a component."""
    tag, hmtx = ("GLYF", "HMTX") if "GLYF" in font else ("glyf", "hmtx")
    found = {}
    for name in font.getGlyphOrder() if tag in font else ():
        lender, parts = name, font[tag][name]
        while parts.isComposite():
            mine = [c.glyphName for c in parts.components if c.flags & USE_MY_METRICS]
            if not mine:
                break
            lender, parts = mine[-1], font[tag][mine[-1]]
        if lender != name:
            found[name] = font[hmtx].metrics[lender][0]
    return found


def _label(limit: tuple[str, Any]) -> str:
    tag, value = limit
    return f"{tag} {':'.join(f'{side:g}' for side in _sides(value))}"


def _rename(font: TTFont, family: str) -> None:
    """Names by which an operating system installs the instance beside its parent."""
    table = font["name"]
    postscript = "".join(c if c.isascii() and c.isalnum() else "-" for c in family)[:63]
    table.names = [record for record in table.names if record.nameID not in OTHER_NAMES]
    for name_id, value in {
        FAMILY: family,
        STYLE: "Regular",
        UNIQUE: f"{postscript}; vfwidget",
        FULL: family,
        POSTSCRIPT: postscript,
    }.items():
        table.removeNames(nameID=name_id)
        table.setName(value, name_id, 3, 1, 0x409)
