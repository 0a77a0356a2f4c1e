"""Which values of SVG's properties browsers accept, and which paints are visible.

A value that browsers do not accept is ignored, so that the one stated before it remains.
"""

from __future__ import annotations

import re

from .basic_shapes import is_shape
from .maths import NUMBER, listed
from .parts import LENGTHS, LONG, is_length
from .transforms import STYLED, matrix_of

HEX = re.compile(r"#(?:[0-9a-f]{3,4}|[0-9a-f]{6}|[0-9a-f]{8})")
FUNCTION = re.compile(
    r"(?:rgba?|hsla?|hwb|lab|lch|oklab|oklch|color|color-mix|light-dark)\((.*)\)", re.DOTALL
)
URL = re.compile(r"""url\(\s*(?:"[^"]*"|'[^']*'|[^"')]*)\s*\)""")
VALUE = re.compile(rf"({NUMBER})(%?)")
SYSTEM = frozenset(
    "accentcolor accentcolortext activetext buttonborder buttonface buttontext canvas canvastext "
    "field fieldtext graytext highlight highlighttext linktext mark marktext selecteditem "
    "selecteditemtext visitedtext".split()
)
WORDS = frozenset({"none", "transparent", "currentcolor", "context-fill", "context-stroke"})
WIDE = frozenset({"inherit", "initial", "unset", "revert", "revert-layer"})
"""Values of every property."""
KEYWORDS = {
    "fill-rule": frozenset({"nonzero", "evenodd"}),
    "clip-rule": frozenset({"nonzero", "evenodd"}),
    "stroke-linecap": frozenset({"butt", "round", "square"}),
    "stroke-linejoin": frozenset({"miter", "round", "bevel"}),
    "visibility": frozenset({"visible", "hidden", "collapse"}),
    "overflow": frozenset({"visible", "hidden", "scroll", "auto", "clip"}),
}
"""The values of properties that are words."""
SHARES = frozenset({"opacity", "fill-opacity", "stroke-opacity", "stroke-miterlimit"})
"""Properties that are numbers."""
NOT_BELOW_ZERO = frozenset({"stroke-width", "width", "height", "r", "rx", "ry"})
INITIAL = {
    "fill": "black",
    "stroke": "none",
    "color": "black",
    "stroke-width": "1",
    "stroke-dasharray": "none",
    "stroke-dashoffset": "0",
    "stroke-miterlimit": "4",
    "opacity": "1",
    "fill-opacity": "1",
    "stroke-opacity": "1",
    "fill-rule": "nonzero",
    "clip-rule": "nonzero",
    "stroke-linecap": "butt",
    "stroke-linejoin": "miter",
    "visibility": "visible",
    "display": "inline",
    "marker-start": "none",
    "marker-mid": "none",
    "marker-end": "none",
    "font-size": "medium",
}


def accepted(name: str, value: str) -> str | None:
    """The value of a property in the form in which it is read; None if it is to be ignored."""
    word = value.lower()
    if name.startswith("--"):
        return "inherit" if word in WIDE and word != "initial" else value
    if word in WIDE:
        initial = INITIAL.get(name, "auto" if name in LENGTHS else None)
        return initial if word == "initial" else "inherit"
    if "var(" in word or "env(" in word:
        return value  # It is replaced in each element.
    if name in KEYWORDS:
        return word if word in KEYWORDS[name] else None
    if name in SHARES:
        found = VALUE.fullmatch(word)
        wrong = found is None or (name == "stroke-miterlimit" and (found[2] or float(found[1]) < 0))
        return None if wrong else word
    if name in ("fill", "stroke"):
        url = URL.match(value)
        other = word[url.end() :].strip() if url else word
        return (value if url else word) if (url and not other) or is_paint(other) else None
    if name == "color":
        return word if is_paint(word) and word not in ("none", "currentcolor") else None
    if name in LENGTHS:
        below = name in NOT_BELOW_ZERO and word.startswith("-")
        wrong = below or not is_length(value) or (name == "stroke-width" and word == "auto")
        return None if wrong else value
    if name == "stroke-dasharray":
        wrong = any(dash[:1] in ("-", "a") or not is_length(dash) for dash in listed(word))
        return None if wrong and word != "none" else value
    if name == "transform" or name in STYLED.values():
        # One that is too long is refused where it is used.
        return None if len(value) <= LONG and matrix_of(name, value) is None else value
    if name == "clip-path":
        known = word == "none" or URL.match(value) or is_shape(value)
        return value if known else None
    if name == "display":
        return word
    return value


def is_paint(value: str) -> bool:
    """Whether a value in small letters is a colour, or stands for one."""
    from PIL import ImageColor

    return (
        value in WORDS
        or value in ImageColor.colormap
        or value in SYSTEM
        or HEX.fullmatch(value) is not None
        or FUNCTION.fullmatch(value) is not None
    )


def is_visible(paint: str) -> bool:
    """Whether a fill or a stroke of an accepted paint is seen."""
    if paint in ("none", "transparent"):
        return False
    if HEX.fullmatch(paint) and len(paint) in (5, 9):
        return set(paint[-1 if len(paint) == 5 else -2 :]) != {"0"}
    found = FUNCTION.fullmatch(paint)
    if not found or paint.startswith(("color-mix", "light-dark")):
        return True
    _, slash, alpha = found[1].rpartition("/")
    parts = found[1].split(",")
    if not slash:
        alpha = parts[3] if len(parts) == 4 else "1"
    number = VALUE.fullmatch(alpha.strip())
    return number is None or float(number[1]) > 0


def without_server(paint: str, known: bool) -> str:
    """A paint whose reference leads to a gradient or a pattern if ``known``; else its fallback."""
    url = URL.match(paint)
    if url is None or known:
        return paint
    return paint[url.end() :].strip().lower() or "none"
