"""Attacks on animations, exports and artwork: junk as arguments, hostile names, dense outlines."""

from __future__ import annotations

import io
import json
import math
import random
import re
import tempfile
from collections.abc import Callable, Iterator
from functools import partial
from html.parser import HTMLParser
from pathlib import Path
from typing import Any
from unittest import mock
from xml.etree import ElementTree

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import torch
from comm.base_comm import BaseComm
from fontTools.ttLib import TTFont

import vfwidget as vf
from tests.outcome import Outcome


class Quiet(BaseComm):
    """A front end that is not there."""

    def publish_msg(self, *_: Any, **__: Any) -> None:
        pass


JUNK: list[Any] = [
    *(math.nan, math.inf, -math.inf, 1e300, 5e-324, -1, 0, 10**6, 10**9, 10**400, 0.5, True, 1j),
    *("x", "12", b"ab", "red;}</style><script>", '"><script>', "a" * 10**5, "-f", "http://x/y"),
    *([], [[]], {}, [1, 2, 3], [math.nan, 0], [1e300, 0], [[1, 2], [3]], [None], None, object()),
    *({"wght": math.nan}, {"zzzz": 1}, {"wght": "x"}, {1: 2}, (lambda *_: 1), (lambda *_: "x")),
    *(np.zeros((2, 2, 2)), np.array(["a", "b"]), torch.tensor([1 + 1j]), torch.zeros(2).bool()),
]
"""Values that are wrong for nearly every argument."""


def _calls(folder: str) -> list[tuple[Callable[..., Any], list[str]]]:
    """Functions of motion, called with correct arguments but for one, and the names of those."""
    text = vf.Text("dynapuff", "ab")
    bold = text.at(axes={"wght": 700})
    animation = vf.Animation.from_keyframes([(0, text), (0.1, bold)], fps=20)
    still = partial(vf.simulate, text=text, steps=2, progress=False)
    names = ["text", "steps", "dt", "rest", "stiffness", "mass", "damping", "forces", "obstacles"]
    names += ["positions", "restitution", "friction", "substeps", "rotations"]
    made = partial(vf.Animation, text=text, times=animation.times, theta=animation.theta)
    keyframes = partial(vf.Animation.from_keyframes, keyframes=[(0, text), (0.1, bold)])
    path = [*([Path(folder, name)] for name in ("a.css", "a.svg", "a.html", "a.json", "a.gif"))]
    to = {"css": path[0][0], "svg": path[1][0], "html": path[2][0], "json": path[3][0]}
    player = partial(vf.Player, animation=animation)
    return [
        (still, names),
        (made, ["text", "times", "theta", "offsets", "rotations", "penetration", "scenery"]),
        (keyframes, ["keyframes", "easing", "delay", "fps"]),
        (lambda x: vf.Animation.from_keyframes([(x, text), (1, bold)]), ["x"]),
        (lambda x: vf.Animation.from_keyframes([(0, text), (1, x)]), ["x"]),
        *((getattr(animation, name), [""]) for name in ("at", "loop", "chain", "overlay")),
        (animation.__getitem__, [""]),
        (animation.retime, ["duration", "fps", "easing"]),
        (partial(animation.to_css, path=to["css"]), ["name", "loop", "tolerance"]),
        (partial(animation.to_svg, path=to["svg"]), ["loop", "tolerance", "height", "background"]),
        (partial(animation.to_html, path=to["html"]), ["loop", "tolerance"]),
        (partial(animation.to_lottie, path=to["json"]), ["tolerance", "ink"]),
        (partial(animation.to_gif, path=path[4][0], progress=False), ["height", "fps", "loop"]),
        (player, ["animation", "playing", "loop", "speed", "onion", "height"]),
        (vf.plot.frames, [""]),
        (lambda x: vf.plot.frames(animation, x), ["x"]),
        (lambda x: animation.plot(x), ["x"]),
        (partial(vf.overlaps, text), ["obstacles"]),
        (partial(vf.resolve_overlaps, text, restarts=0), ["obstacles", "gap"]),
    ]


def junk_for_motion(count: int) -> Outcome:
    """Junk for simulations, animations, their exports, players and obstacles; a million steps."""
    rng = random.Random(6)
    mpl.use("agg")
    with tempfile.TemporaryDirectory() as folder, mock.patch("comm.create_comm", Quiet):
        calls = _calls(folder)

        def act(call: tuple[Callable[..., Any], str, Any]) -> None:
            function, name, value = call
            try:
                function(**{name: value}) if name and name != "x" else function(value)
                plt.close("all")
            except OSError as error:
                # A file that cannot be written.
                raise vf.VFWidgetError(str(error)) from error

        def inputs() -> Iterator[Any]:
            for _ in range(count):
                function, names = rng.choice(calls)
                yield function, rng.choice(names), rng.choice(JUNK)

        return Outcome("junk for simulations, animations, players, obstacles").try_all(
            inputs(), act
        )


class Tags(HTMLParser):
    """The elements of a page, and the names of their attributes."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.found: list[Any] = []
        self.feed(page)

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.found.append((tag, [name for name, _ in attributes]))


def _renamed(data: bytes, name: str) -> bytes:
    font = TTFont(io.BytesIO(data))
    font.flavor = None
    for record in font["name"].names:
        record.string = name.encode(record.getEncoding(), "replace")
    file = io.BytesIO()
    font.save(file)
    return file.getvalue()


def _structure(file: bytes) -> list[Any]:
    """Everything of the exports of a font that its names must not change."""
    font = vf.load_font(file)
    text = vf.Text(font, "a")
    animation = vf.Animation.from_keyframes([(0, text), (0.1, text.at(axes={"wght": 700}))])
    editor, player = vf.Editor(font, "a"), vf.Player(animation)
    pages = [animation.to_html(), editor.to_html(), player.to_html(), font.describe()._repr_html_()]
    # A bundle is data, or a pair of data and metadata.
    bundles = [widget._repr_mimebundle_() for widget in (editor, player)]
    data = [bundle[0] if isinstance(bundle, tuple) else bundle or {} for bundle in bundles]
    pages += [bundle[kind] for bundle in data for kind in sorted(bundle) if "html" in kind]
    drawings = [text.to_svg(), animation.to_svg()]
    sheets = [text.to_css(), animation.to_css()]
    bare = [re.sub(r'/\*.*?\*/|"(\\.|[^"\\\n])*"', "", sheet, flags=re.S) for sheet in sheets]
    json.loads(animation.to_lottie()), json.loads(animation.to_json())
    return [
        *(Tags(page).found for page in pages),
        *([element.tag for element in ElementTree.fromstring(svg).iter()] for svg in drawings),
        *(re.findall("[{};]", sheet) for sheet in bare),
    ]


PIECES = [
    *("</script>", "</style>", "<img src=x onerror=alert(1)>", "<!--", "-->", "]]>", "*/", "/*"),
    *(
        "\\",
        '"',
        "'",
        "\n",
        "\r",
        "\x0c",
        "\u2028",
        "\u2029",
        "&lt;",
        "&#x27;",
        "}",
        "{",
        ";",
        "\\22 ",
    ),
    *(
        "</title>",
        "<svg onload=alert(1)>",
        "url(http://localhost/x)",
        "@import",
        "${x}",
        "`",
        "%3C",
    ),
]


def hostile_names(count: int) -> Outcome:
    """Names that hold markup, by which pages, drawings and style sheets must not change."""
    rng = random.Random(7)
    data = (Path(vf.__file__).parent / "fonts" / "dynapuff.woff2").read_bytes()
    with mock.patch("comm.create_comm", Quiet):
        harmless = _structure(_renamed(data, "Plain"))

        def act(name: str) -> None:
            for got, want in zip(_structure(_renamed(data, name)), harmless, strict=True):
                assert got == want, name

        names = ("".join(rng.choices(PIECES, k=rng.randint(1, 6))) for _ in range(count))
        return Outcome("hostile names in pages, SVG, CSS, Lottie and bundles").try_all(names, act)


def dense_artwork(count: int) -> Outcome:
    """SVG of a few kilobytes whose shapes lie over each other, up to the limit of curves."""
    rng = random.Random(8)
    place: Callable[[], str] = lambda: f"{rng.random() * 1000:.1f} {rng.random() * 1000:.1f}"  # noqa: E731
    line = 'fill="none" stroke="red" stroke-width="9"'

    def drawn(kind: int, size: int) -> str:
        if kind == 0:
            return '<rect width="5" height="5"/>' * size
        if kind == 1:
            return "".join(f'<rect x="{i}" y="{i}" width="500" height="9"/>' for i in range(size))
        if kind == 2:
            return f'<path d="M0 0{"".join(f"L{place()}" for _ in range(size))}"/>'
        if kind == 3:
            return f'<path {line} d="M0 0{"".join(f"L{place()}" for _ in range(size))}"/>'
        if kind == 4:
            curves = "".join(f"C{place()} {place()} {place()}" for _ in range(size))
            return f'<path d="M0 0{curves}"/>'
        bars = (f'<path d="M{4 * i} {-i / 4}v100h.1v-100z"/>' for i in range(size))
        return "".join(bars) + '<path d="M1000000 0h1v1z"/>'

    def inputs() -> Iterator[str]:
        for i in range(count):
            size = rng.choice([30, 300, 1_000, 3_000])
            yield f'<svg xmlns="http://www.w3.org/2000/svg">{drawn(i % 6, size)}</svg>'

    return Outcome("dense SVG artwork").try_all(inputs(), vf.Artwork)
