"""Files that unpack to more than they say, and servers that answer slowly or not in full."""

from __future__ import annotations

import http.server
import struct
import threading
import time
import zlib
from collections.abc import Iterator
from functools import cache
from io import BytesIO

import brotli
import pytest
from fontTools.ttLib import TTFont

import vfwidget as vf

# tests/attacks.py, which is run as a module, imports this file.
from tests.fonts import bundled_file
from vfwidget.font.unpack import check_unpacked_size

BOMB_BYTES = 270 * 2**20
"""A little more than the limit."""
ZEROS = bytes(2**20)


def base_128(number: int) -> bytes:
    """A number as WOFF2 writes it: seven bits in each byte, the highest first."""
    groups = [number & 0x7F]
    while number := number >> 7:
        groups.insert(0, number & 0x7F | 0x80)
    return bytes(groups)


@cache
def brotli_zeros(size: int) -> bytes:
    compressor = brotli.Compressor(quality=1)
    pieces = [compressor.process(ZEROS) for _ in range(size // len(ZEROS))]
    return b"".join(pieces) + compressor.finish()


@cache
def zlib_zeros(size: int) -> bytes:
    compressor = zlib.compressobj(1)
    pieces = [compressor.compress(ZEROS) for _ in range(size // len(ZEROS))]
    return b"".join(pieces) + compressor.flush()


def woff2_bomb(stated: int, unpacked: int = BOMB_BYTES) -> bytes:
    """A WOFF2 file of one table, which states one size and unpacks to another."""
    block = brotli_zeros(unpacked)
    directory = b"\0" + base_128(stated)  # "cmap", without a transform
    length = 48 + len(directory) + len(block)
    header = struct.pack(
        ">4sLLHHLLHHLLLLL", b"wOF2", 0x10000, length, 1, 0, stated, len(block), *[0] * 7
    )
    return header + directory + block


def woff_bomb(stated: int, unpacked: int = BOMB_BYTES) -> bytes:
    """A WOFF file of one table, which states one size and unpacks to another."""
    block = zlib_zeros(unpacked)
    entry = struct.pack(">4sLLLL", b"cmap", 64, len(block), stated, 0)
    length = 64 + len(block)
    header = struct.pack(">4sLLHHLHHLLLLL", b"wOFF", 0x10000, length, 1, 0, stated, *[0] * 7)
    return header + entry + block


@pytest.mark.parametrize("stated", [1000, BOMB_BYTES, 2**31])
@pytest.mark.parametrize("bomb", [woff_bomb, woff2_bomb])
def test_a_bomb_is_refused_whatever_size_it_states(bomb, stated):
    data = bomb(stated)
    assert len(data) < BOMB_BYTES / 200
    with pytest.raises(vf.FontError, match="unpacks to more than 268435456 bytes"):
        vf.load_font(data)


@pytest.mark.parametrize("flavor", [None, "woff", "woff2"])
def test_good_fonts_of_every_container_pass(flavor):
    font, file = TTFont(BytesIO(bundled_file())), BytesIO()
    font.flavor = flavor
    font.save(file)
    assert vf.load_font(file.getvalue()).family_name == "DynaPuff"


@pytest.mark.parametrize("flavor", ["woff", "woff2"])
def test_the_limit_counts_what_is_unpacked(flavor, monkeypatch):
    font, plain, packed = TTFont(BytesIO(bundled_file())), BytesIO(), BytesIO()
    for font.flavor, file in ((None, plain), (flavor, packed)):
        font.save(file)
    size = len(plain.getvalue())
    assert len(packed.getvalue()) < 0.7 * size
    monkeypatch.setattr(vf.limits, "font_unpacked_bytes", round(1.1 * size))
    check_unpacked_size(packed.getvalue())
    monkeypatch.setattr(vf.limits, "font_unpacked_bytes", round(0.7 * size))
    with pytest.raises(vf.FontError, match=r"raise vfwidget\.limits\.font_unpacked_bytes"):
        check_unpacked_size(packed.getvalue())


@pytest.mark.parametrize("cut", [4, 20, 47, 60, 1000])
@pytest.mark.parametrize("bomb", [woff_bomb, woff2_bomb])
def test_a_file_that_is_cut_is_not_a_font(bomb, cut):
    data = bomb(BOMB_BYTES, 2**24)[:cut]
    with pytest.raises(vf.FontError, match=r"Not a font file|truncated"):
        vf.load_font(data)


# Servers


class Handler(http.server.BaseHTTPRequestHandler):
    def do_GET(self) -> None:
        getattr(self, f"answer_{self.path[1:]}")()

    def answer_redirect(self) -> None:
        self._head(302, Location="ftp://127.0.0.1/font.ttf")

    def answer_again(self) -> None:
        self._head(302, Location="/font")

    def answer_font(self) -> None:
        self._head(200, Content_Length=str(len(bundled_file())))
        self.wfile.write(bundled_file())

    def answer_unannounced(self) -> None:
        self._head(200)
        self.wfile.write(bundled_file())

    def answer_short(self) -> None:
        self._head(200, Content_Length=str(len(bundled_file())))
        self.wfile.write(bundled_file()[:-100])

    def answer_dripping_body(self) -> None:
        self._head(200, Content_Length=str(len(bundled_file())))
        self._drip(bundled_file())

    def answer_dripping_head(self) -> None:
        self._drip(b"HTTP/1.0 200 OK\r\n" + b"X-Padding: padding\r\n" * 100)

    def _head(self, status: int, **fields: str) -> None:
        self.send_response(status)
        for name, value in fields.items():
            self.send_header(name.replace("_", "-"), value)
        self.end_headers()

    def _drip(self, data: bytes) -> None:
        try:
            for byte in data:
                self.wfile.write(bytes([byte]))
                time.sleep(0.02)
        except ConnectionError:
            pass  # The client has left.

    def log_message(self, *args: object) -> None:
        pass


@pytest.fixture(scope="module")
def server() -> Iterator[str]:
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler) as running:
        running.daemon_threads = True
        running.block_on_close = False
        threading.Thread(target=running.serve_forever, daemon=True).start()
        with pytest.MonkeyPatch.context() as patch:
            patch.setenv("no_proxy", "127.0.0.1")
            yield f"http://127.0.0.1:{running.server_port}"
        running.shutdown()


@pytest.mark.parametrize("path", ["font", "again", "unannounced"])
def test_a_whole_answer_is_a_font(server, path):
    assert vf.load_font(f"{server}/{path}").family_name == "DynaPuff"


def test_a_redirect_to_another_scheme_is_not_followed(server):
    with pytest.raises(vf.FontError, match=r"a redirect to ftp://127\.0\.0\.1/font.ttf is not"):
        vf.load_font(f"{server}/redirect")


def test_a_body_shorter_than_announced_is_refused(server):
    size = len(bundled_file())
    with pytest.raises(vf.FontError, match=f"announced {size} bytes and sent {size - 100}"):
        vf.load_font(f"{server}/short")


@pytest.mark.parametrize("part", ["head", "body"])
def test_a_server_that_drips_meets_the_deadline(server, part, monkeypatch):
    monkeypatch.setattr(vf.limits, "download_seconds", 0.5)
    with pytest.raises(vf.FontError, match=r"longer than 0\.5 s"):
        vf.load_font(f"{server}/dripping_{part}")
