"""Every invalid input raises one clear error of this package, and no other exception."""

from __future__ import annotations

import http.server
import logging
import os
import random
import socket
import struct
import threading
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path

import fonts
import formats
import numpy as np
import pytest
import torch
from fontTools.fontBuilder import FontBuilder
from fontTools.pens.t2CharStringPen import T2CharStringPen
from fontTools.ttLib import TTFont

import vfwidget as vf
from vfwidget.font.source import open_font

FONTS = vf.bundled_fonts()
NAN, INF = float("nan"), float("inf")


@pytest.fixture(scope="module")
def font() -> vf.Font:
    return vf.load_font("recursive")


@pytest.fixture(scope="module")
def text(font: vf.Font) -> vf.Text:
    return vf.Text(font, "ab")


def bundled_file(name: str) -> bytes:
    return (Path(vf.__file__).parent / "fonts" / f"{name}.woff2").read_bytes()


def unpacked(font: TTFont) -> bytes:
    font.flavor = None
    data = BytesIO()
    font.save(data)
    return data.getvalue()


# What is no font to be read


def static_font() -> bytes:
    def drop(font: FontBuilder) -> None:
        del font.font["fvar"], font.font["gvar"]

    return fonts.build(*fonts.base_glyphs(), edit=drop)


def postscript_font() -> bytes:
    font = FontBuilder(1000, isTTF=False)
    font.setupGlyphOrder([".notdef"])
    font.setupCharacterMap({})
    font.setupNameTable({"familyName": "Tiny", "styleName": "Regular"})
    font.setupFvar([fonts.WEIGHT], [])
    font.setupCFF2({".notdef": T2CharStringPen(None, None, CFF2=True).getCharString()})
    font.setupHorizontalMetrics({".notdef": (600, 0)})
    font.setupHorizontalHeader(ascent=800, descent=-200)
    font.setupPost()
    return unpacked(font.font)


def patched(tag: str, at: int, value: bytes) -> bytes:
    """A good font, but for a few bytes of one table."""
    data = bytearray(fonts.hvar_by_glyph_id())
    start = fonts.open_font(bytes(data)).reader.tables[tag].offset + at
    data[start : start + len(value)] = value
    return bytes(data)


def huge_file(folder: Path) -> Path:
    with (folder / "huge.ttf").open("wb") as file:
        file.truncate(vf.limits.font_file_bytes + 1)
    return folder / "huge.ttf"


def pipe(folder: Path) -> Path:
    os.mkfifo(folder / "pipe.ttf")
    return folder / "pipe.ttf"


FVAR_FIRST_AXIS = 16
UNKNOWN = r"^No bundled font and no readable file is called .*Bundled fonts: afacad-flux, dynapuff"
SOURCES = {
    "no bytes": (b"", "Not a font file"),
    "some bytes": (b"\0\1\0\0 but no font", "Not a font file"),
    "text": (b"<!doctype html>", "Not a font file"),
    "a static font": (static_font, "This font is static.*Load a variable font instead"),
    "an axis out of order": (
        lambda: patched("fvar", FVAR_FIRST_AXIS + 4, struct.pack(">i", 500 << 16)),
        "Axis 'wght' has its default outside its range",
    ),
    "an axis tag that is no text": (
        lambda: patched("fvar", FVAR_FIRST_AXIS, b"w\xffht"),
        "not ASCII text",
    ),
    "an unknown name": ("recursiv", UNKNOWN),
    "no name": ("", UNKNOWN),
    "a missing path": (Path("nowhere") / "font.ttf", UNKNOWN),
    "an unknown home": ("~no-such-person/font.ttf", UNKNOWN),
    "a path that cannot be": ("font\0.ttf", UNKNOWN),
    "another scheme": ("ftp://127.0.0.1/font.ttf", UNKNOWN),
    "a directory": (Path(__file__).parent, UNKNOWN),
    "a pipe": (pipe, UNKNOWN),
    "a huge file": (huge_file, f"larger than the limit of {vf.limits.font_file_bytes} bytes"),
    "a number": (3.14, "not from float"),
    "nothing": (
        None,
        "bundled name, a path, a URL, bytes or a fontTools TTFont; not from NoneType",
    ),
    "an empty TTFont": (TTFont, "This font is static"),
    "a bad URL": ("http://a b/", "Could not download http://a b/"),
    "an empty URL": ("http://", "Could not download"),
}


@pytest.mark.parametrize("source, message", SOURCES.values(), ids=SOURCES)
def test_what_is_no_variable_font_is_refused(source, message, tmp_path):
    if callable(source):
        source = source(tmp_path) if source in (pipe, huge_file) else source()
    with pytest.raises(vf.FontError, match=message):
        vf.load_font(source)


# Over the network


class Handler(http.server.BaseHTTPRequestHandler):
    def do_GET(self) -> None:
        sizes = {
            "/font.woff2": len(bundled_file("dynapuff")),
            "/huge.ttf": 2 * vf.limits.font_file_bytes,
        }
        if self.path == "/rubbish":
            self.wfile.write(b"this is no HTTP\r\n\r\n")
            return
        if self.path not in sizes:
            self.send_error(404)
            return
        self.send_response(200)
        self.send_header("Content-Length", str(sizes[self.path]))
        self.end_headers()
        if self.path == "/font.woff2":
            self.wfile.write(bundled_file("dynapuff"))
            return
        try:
            for _ in range(2 * vf.limits.font_file_bytes >> 20):
                self.wfile.write(bytes(1 << 20))
        except ConnectionError:
            pass  # The client has had enough.

    def log_message(self, *args: object) -> None:
        pass


@pytest.fixture(scope="module")
def server() -> Iterator[str]:
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler) as running:
        thread = threading.Thread(target=running.serve_forever)
        thread.start()
        with pytest.MonkeyPatch.context() as patch:
            patch.setenv("no_proxy", "127.0.0.1")
            yield f"http://127.0.0.1:{running.server_port}"
        running.shutdown()
        thread.join()


def test_a_font_from_a_url(server):
    assert vf.load_font(f"{server}/font.woff2").family_name == "DynaPuff"


@pytest.mark.parametrize(
    "path, message",
    [
        ("/nowhere", "Could not download http://127.0.0.1:.*404"),
        ("/rubbish", "Could not download"),
        ("/huge.ttf", "larger than the limit"),
    ],
)
def test_what_a_url_may_answer_instead(server, path, message):
    with pytest.raises(vf.FontError, match=message):
        vf.load_font(server + path)


def test_a_url_that_nobody_answers(server):
    with socket.socket() as closed:
        closed.bind(("127.0.0.1", 0))
        port = closed.getsockname()[1]
    with pytest.raises(vf.FontError, match="Could not download"):
        vf.load_font(f"http://127.0.0.1:{port}/font.ttf")


# Damaged fonts


@pytest.mark.parametrize("name", FONTS)
@pytest.mark.parametrize(
    "pack", [bundled_file, lambda name: unpacked(open_font(name))], ids=["woff2", "ttf"]
)
def test_a_font_cut_anywhere_is_refused(name, pack):
    data = pack(name)
    cuts = [*range(1, 400, 57), *np.linspace(400, len(data) - 5, 20).astype(int), len(data) - 5]
    for cut in cuts:
        with pytest.raises(vf.FontError, match=r"truncated|Not a font file"):
            vf.load_font(data[:cut])


def use_everything(data: bytes, rng: random.Random) -> None:
    font = vf.load_font(data)
    w = np.full(len(font.axes), 0.5)
    font.metrics(w), font.describe()
    for name in rng.sample(font.glyph_names, min(len(font.glyph_names), 8)):
        glyph = font.glyph(name)
        glyph.points(w), glyph.jacobian(w), glyph.side_bearings(w)
    text = vf.Text(font, "aa")
    text.points(), text.jacobian(), repr((font, text, font.instances, font.bounds))


BUILDERS = fonts.CASES | formats.VARIABLE
BUILDERS |= {b.__name__: b for b in (formats.varc, formats.avar_2, formats.with_mvar)}


@pytest.mark.parametrize("case", BUILDERS)
@pytest.mark.filterwarnings("ignore::vfwidget.FontWarning")
def test_damaged_bytes_raise_no_other_error(case, caplog):
    caplog.set_level(logging.CRITICAL, "fontTools")
    good = BUILDERS[case]()
    rng = random.Random(case)
    refused = 0
    for _ in range(25):
        data = bytearray(good)
        for _ in range(rng.choice([1, 1, 4, 16])):
            at = rng.randrange(len(data))
            data[at] = rng.choice([0, 255, data[at] ^ 1 << rng.randrange(8)])
        try:
            use_everything(bytes(data), rng)
        except vf.VFWidgetError:
            refused += 1
    assert 0 < refused < 25


def with_part(data: bytes, glyph: int, part: int, at: int, value: int) -> bytes:
    """A font with one byte of one component of a glyph changed, as no library would write it.

    A component is two bytes each of flags and of glyph id, then its two arguments.
    """
    font = fonts.open_font(data)
    start = font.reader.tables["glyf"].offset + font["loca"][glyph] + 10 + 6 * part + at
    return data[:start] + bytes([value]) + data[start + 1 :]


def test_a_glyph_made_of_itself_is_refused():
    data = fonts.build({"a": fonts.outline(), "b": fonts.composite(fonts.component("a"))}, {})
    with pytest.raises(vf.FontError, match="components of glyph 'b' nest too deeply"):
        vf.load_font(with_part(data, 2, 0, 3, 2)).glyph("b")


def test_components_that_multiply_are_refused():
    # Each glyph is four of the one before: sixteen million squares in a small file.
    names = "bcdefghijklm"
    glyphs = {name: fonts.composite(*[fonts.component("a", x) for x in range(4)]) for name in names}
    data = fonts.build({"a": fonts.outline(fonts.SQUARE), **glyphs}, {})
    for glyph in range(3, 2 + len(names)):
        for part in range(4):
            data = with_part(data, glyph, part, 3, glyph - 1)
    font = vf.load_font(data)
    assert len(font.glyph("e").contours) == 4**4
    with pytest.raises(vf.FontError, match="are too many"):
        font.glyph("m")


def test_a_glyph_whose_advance_cannot_be_read_has_no_text():
    data = bytearray(fonts.build(*fonts.base_glyphs()))
    table = fonts.open_font(bytes(data)).reader.tables["gvar"]
    # The headers of all delta sets, after the header and the offsets of the table.
    start, end = table.offset + 40, table.offset + table.length
    data[start:end] = b"\xff" * (end - start)
    font = vf.load_font(bytes(data))
    for _ in range(2):
        with pytest.raises(vf.FontError, match="The data of glyph 'a' are damaged"):
            vf.Text(font, "aa")


def test_a_component_anchored_to_a_missing_point_is_refused():
    glyphs, deltas = fonts.base_glyphs()
    glyphs["c"] = fonts.composite(fonts.component("a"), fonts.component("b", anchor=(3, 0)))
    data = fonts.build(glyphs, deltas)
    vf.load_font(data).glyph("c")
    with pytest.raises(vf.FontError, match="'c' is anchored to a missing point"):
        vf.load_font(with_part(data, 3, 1, 4, 4)).glyph("c")


# Glyphs, axes and coordinates


@pytest.mark.parametrize(
    "key", ["あ", "no-such-glyph", "", -1, 10**6, True, 1.0, None, ["a"], b"a"], ids=repr
)
def test_a_missing_glyph(font, key):
    with pytest.raises(
        vf.GlyphError, match=r"no glyph .*give a character, a glyph name or a glyph id"
    ):
        font.glyph(key)


def test_an_unknown_axis(font):
    message = "Unknown axis 'WGHT'. This font has: MONO, CASL, wght, slnt, CRSV"
    for call in font.normalize, lambda axes: vf.Text(font, "a", axes=axes):
        with pytest.raises(vf.AxisError, match=message):
            call({"WGHT": 400})


@pytest.mark.parametrize(
    "value", [NAN, INF, -INF, None, "bold", 10**400, [1, 2], torch.ones(2)], ids=str
)
def test_an_axis_value_that_is_no_finite_number(font, value):
    with pytest.raises(vf.AxisError, match="Axis 'wght' needs a finite number, not"):
        font.normalize({"wght": value})


@pytest.mark.parametrize("axes", [[650], "wght", 650, None, [("wght", 650)]], ids=repr)
def test_axes_that_are_no_mapping(font, axes):
    with pytest.raises(vf.AxisError, match="Axis values are a mapping of tag to number, not"):
        font.normalize(axes)


COORDINATES = {
    "not a number": ([0, NAN, 0, 0, 0], "must be finite"),
    "infinite": (torch.tensor([0, INF, 0, 0, 0]), "must be finite"),
    "too few": ([0] * 4, r"This font has 5 axes; got coordinates of shape \(4,\)"),
    "one number": (0.5, r"got coordinates of shape \(\)"),
    "transposed": (np.zeros((5, 2)), r"got coordinates of shape \(5, 2\)"),
    "text": ("bold", "are 5 numbers, not 'bold'"),
    "a mapping": ({"wght": 1}, "are 5 numbers, not"),
    "ragged": ([[0] * 5, [0]], "are 5 numbers, not"),
}


@pytest.mark.parametrize("w, message", COORDINATES.values(), ids=COORDINATES)
def test_coordinates_that_are_none(font, text, w, message):
    glyph = font.glyph("a")
    calls = [glyph.scalars, glyph.points, glyph.jacobian, glyph.segments, glyph.advance]
    calls += [glyph.side_bearings, font.denormalize, text.points, text.jacobian]
    for call in [*calls, lambda w: text.at(theta=w)]:
        with pytest.raises(vf.AxisError, match=message):
            call(w)


def test_coordinates_outside_are_clamped_with_a_warning(font, text):
    w = font.bounds[1]
    for method in font.glyph("a").points, font.glyph("a").jacobian, text.points:
        with pytest.warns(vf.AxisWarning, match="outside -1 … 1 were clamped"):
            clamped = method(w * 3)
        assert torch.equal(clamped, method(w))
    with pytest.warns(vf.AxisWarning, match="wght=9999 lies outside 300 … 1000"):
        assert vf.Text(font, "a", axes={"wght": 9999}).axes["wght"] == 1000


def test_warnings_point_at_the_line_that_called(font, text):
    calls = [lambda: font.normalize({"wght": 0}), lambda: vf.Text(font, "a", axes={"wght": 0})]
    calls += [lambda: font.glyph("a").segments([2] * 5), lambda: text.at(theta=[2] * 5)]
    for call in calls:
        with pytest.warns(vf.AxisWarning) as caught:
            call()
        assert caught[0].filename == __file__


def test_only_one_set_of_coordinates_is_denormalized_at_a_time(font):
    with pytest.raises(vf.AxisError, match=r"One set of coordinates at a time, not \(2, 5\)"):
        font.denormalize(np.zeros((2, 5)))


# Texts


@pytest.mark.parametrize("string", ["", "\u200b", "\u200d\u2060"], ids=ascii)
def test_a_text_of_nothing(font, string):
    with pytest.raises(vf.TextError, match="is empty: it has no visible character"):
        vf.Text(font, string)


@pytest.mark.parametrize("string", [b"ab", None, 3, ["a", "b"]], ids=repr)
def test_a_text_that_is_no_string(font, string):
    with pytest.raises(
        vf.TextError, match=f"A text has to be a string; received {type(string).__name__}"
    ):
        vf.Text(font, string)


@pytest.mark.parametrize(
    "axes, shared, message",
    [
        ([{}, {}], True, "are one mapping or instance, or 1 for this text"),
        ([{}], False, "are one mapping or instance, or 2 for this text"),
        ("ab", False, "has no instance 'ab'"),
        ([{}, None], False, "are a mapping of tag to number, not None"),
        (700, True, "are one mapping or instance, or 1 for this text"),
    ],
)
def test_axes_that_fit_no_text(font, axes, shared, message):
    with pytest.raises(vf.AxisError, match=message):
        vf.Text(font, "ab", axes=axes, shared=shared)


@pytest.mark.parametrize(
    "shared, shape", [(True, (2, 5)), (False, (1, 5)), (False, (5,)), (True, (1, 1, 5))]
)
def test_a_theta_that_fits_no_text(font, shared, shape):
    text = vf.Text(font, "ab", shared=shared)
    for call in text.points, text.jacobian, text.segments, lambda theta: text.at(theta=theta):
        with pytest.raises(vf.AxisError, match=rf"this text needs \({1 if shared else 2}, 5\)"):
            call(np.zeros(shape))


def test_a_text_is_moved_by_axes_or_by_theta(text):
    for both_or_neither in {}, {"axes": {}, "theta": text.theta}:
        with pytest.raises(vf.AxisError, match=r"^Give (either|at least one of) axes="):
            text.at(**both_or_neither)


@pytest.mark.parametrize(
    "where",
    [
        *[{"glyph": 2}, {"glyph": -1}, {"contour": 9}, {"contour": -1}, {"segment": 99}],
        *[{"segment": -1}, {"segment": 0.5}, {"glyph": None}, {"contour": "0"}],
        *[{"t": 1.001}, {"t": -0.001}, {"t": NAN}, {"t": "half"}, {"t": None}],
    ],
    ids=str,
)
def test_a_point_that_is_not_on_the_outline(text, where):
    with pytest.raises(vf.GlyphError, match="'ab' has no outline point at glyph="):
        text.handle(**where)


@pytest.mark.parametrize(
    "x, y", [(NAN, 0), (0, INF), ("a", 0), (None, 0), (0, [1, 2]), (10**400, 0)]
)
def test_nearest_to_what_is_no_point(text, x, y):
    with pytest.raises(vf.GlyphError, match=r"x and y must be finite numbers; received"):
        text.nearest(x, y)
