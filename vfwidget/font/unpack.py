"""Checks that a WOFF or WOFF2 file unpacks to a bounded size, before anything else unpacks it.

The sizes in the directory of a file can be wrong, and a compressed kilobyte can hold a gigabyte.
So the check decompresses the data piece by piece and stops at the limit. It keeps no data.
"""

from __future__ import annotations

import io
import struct
import zlib
from collections.abc import Iterator

import brotli
from fontTools.ttLib.woff2 import WOFF2DirectoryEntry, woff2DirectorySize

from ..errors import FontError
from ..limits import limits

PIECE_BYTES = 2**20
WOFF_HEADER = struct.Struct(">4sLLHHL")
"""Signature, flavor, length, number of tables, reserved, size after unpacking (WOFF 1.0, 3)."""
WOFF_HEADER_BYTES = 44
WOFF_ENTRY = struct.Struct(">4sLLLL")
"""Tag, offset, compressed length, length after unpacking, checksum (WOFF 1.0, 4)."""
WOFF2_COMPRESSED_SIZE = slice(20, 24)
"""Where the header of WOFF2 states the length of its compressed block (WOFF2, 4.1)."""


def check_unpacked_size(data: bytes) -> None:
    """Raise if a font file unpacks to more than the limit; do nothing for other formats.

    Damaged data pass this check, because the reader that unpacks them reports the damage.

    Parameters
    ----------
    data : bytes
        A font file of any format.

    Raises
    ------
    FontError
        The file unpacks to more than ``limits.font_unpacked_bytes``.
    """
    sizes = {b"wOFF": _woff_sizes, b"wOF2": _woff2_sizes}.get(data[:4])
    total = 0
    try:
        for size in sizes(data) if sizes else ():
            total += size
            if total > limits.font_unpacked_bytes:
                break
    except Exception:
        # A damaged file can fail anywhere in the parser, with any exception.
        return
    if total > limits.font_unpacked_bytes:
        raise FontError(
            f"The font file unpacks to more than {limits.font_unpacked_bytes} bytes. "
            "If you trust the file, raise vfwidget.limits.font_unpacked_bytes."
        )


def _woff_sizes(data: bytes) -> Iterator[int]:
    """Sizes of the pieces that the tables of a WOFF file unpack to."""
    count = WOFF_HEADER.unpack_from(data)[3]
    for i in range(count):
        entry = WOFF_ENTRY.unpack_from(data, WOFF_HEADER_BYTES + i * WOFF_ENTRY.size)
        _, offset, packed, unpacked, _ = entry
        table = data[offset : offset + packed]
        if packed == unpacked:
            yield packed
            continue
        stream = zlib.decompressobj()
        while table and not stream.eof:
            yield len(stream.decompress(table, PIECE_BYTES))
            table = stream.unconsumed_tail


def _woff2_sizes(data: bytes) -> Iterator[int]:
    """Sizes of the pieces that the one compressed block of a WOFF2 file unpacks to."""
    count = WOFF_HEADER.unpack_from(data)[3]
    file = io.BytesIO(data)
    file.seek(woff2DirectorySize)
    for _ in range(count):
        WOFF2DirectoryEntry().fromFile(file)
    block = file.read(int.from_bytes(data[WOFF2_COMPRESSED_SIZE], "big"))
    stream = brotli.Decompressor()
    yield len(stream.process(block, output_buffer_limit=PIECE_BYTES))
    while not stream.can_accept_more_data():
        yield len(stream.process(b"", output_buffer_limit=PIECE_BYTES))
