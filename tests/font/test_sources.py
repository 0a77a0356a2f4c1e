"""What is no variable font, in a file or on the network, raises one clear error."""

from __future__ import annotations

import http.server
import os
import socket
import struct
import threading
from collections.abc import Iterator
from pathlib import Path

import fonts
import pytest
from fontTools.fontBuilder import FontBuilder
from fontTools.pens.t2CharStringPen import T2CharStringPen
from fontTools.ttLib import TTFont
from formats import saved

import vfwidget as vf


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
    return saved(font.font)


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
    "a number": (3.14, "received float"),
    "nothing": (
        None,
        "bundled name, a path, a URL, bytes or a fontTools TTFont; received NoneType",
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


def test_a_font_made_from_a_name_says_how_to_load_it():
    with pytest.raises(vf.FontError, match=r"not str; vf\.load_font"):
        vf.Font("recursive")


class Handler(http.server.BaseHTTPRequestHandler):
    def do_GET(self) -> None:
        sizes = {
            "/font.woff2": len(fonts.bundled_file("dynapuff")),
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
            self.wfile.write(fonts.bundled_file("dynapuff"))
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
