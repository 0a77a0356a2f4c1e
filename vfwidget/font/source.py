"""Where a font comes from: a bundled name, a path, a URL, bytes or an open TTFont."""

from __future__ import annotations

import io
import os
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import resources
from pathlib import Path
from typing import TypeAlias

from fontTools.ttLib import TTFont

from ..errors import FontError, VFWidgetError
from ..limits import limits
from .download import SCHEMES, download
from .unpack import check_unpacked_size

FontSource: TypeAlias = "str | os.PathLike[str] | bytes | bytearray | memoryview | TTFont"


def bundled_fonts() -> tuple[str, ...]:
    """Names of the fonts that ship with the package, sorted; :func:`load_font` takes them.

    Returns
    -------
    tuple of str
    """
    folder = resources.files("vfwidget") / "fonts"
    if not folder.is_dir():
        return ()
    names = (Path(entry.name) for entry in folder.iterdir())
    return tuple(sorted(name.stem for name in names if name.suffix == ".woff2"))


def open_font(source: FontSource, index: int = 0) -> TTFont:
    """Open a font file, in full and within limits, on a reader of its own.

    Parameters
    ----------
    source : str, path, bytes or fontTools.ttLib.TTFont
        A bundled name, a path, an ``http(s)`` URL, the bytes of a font file (TTF, OTF, WOFF,
        WOFF2, or a collection), or a font already open.
    index : int
        Which font of a collection, from 0.

    Raises
    ------
    FontError
        Unknown name, missing or oversized file, failed download, or not a font.
    """
    if isinstance(source, TTFont):
        # A table that was edited or is damaged can fail to compile with any exception.
        with damage("The open font cannot be saved, so it cannot be read"):
            source = saved(source)
    data = bytes(source) if isinstance(source, bytes | bytearray | memoryview) else _read(source)
    if len(data) > limits.font_file_bytes:
        raise FontError(
            f"The font file is larger than the limit of {limits.font_file_bytes} bytes. "
            "If you trust the file, raise vfwidget.limits.font_file_bytes."
        )
    check_unpacked_size(data)
    count = _font_count(data)
    if not isinstance(index, int) or not 0 <= index < count:
        raise FontError(f"This file has no font of index {index!r}; it holds {count} font(s).")
    try:
        # A damaged file can fail anywhere in the parser, with any exception.
        font = TTFont(io.BytesIO(data), fontNumber=index, lazy=True)
    except Exception as error:
        raise FontError(f"Not a font file that can be read ({reason(error)}).") from error
    # A WOFF2 file has been unpacked in full by now; of the others only the directory was read.
    tables = font.reader.tables.values() if font.reader.flavor != "woff2" else ()
    if any(table.offset + table.length > len(data) for table in tables):
        raise FontError("The font file is truncated: it ends before its tables do.")
    with damage("The MAXP table is damaged"):
        _check_glyph_count(font)
    return font


def opened(font: object) -> TTFont:
    """The font, if it is one that fontTools has opened.

    Raises
    ------
    FontError
    """
    if not isinstance(font, TTFont):
        raise FontError(
            f"Font(…) takes an open fontTools TTFont, not {type(font).__name__}; "
            "vf.load_font(…) loads a font by its name or path, or from its bytes."
        )
    return font


def _check_glyph_count(font: TTFont) -> None:
    """A table of the longer format can state 16 million glyphs, which take GiBs to be named."""
    if "MAXP" not in font:
        return
    count = int.from_bytes(font.reader["MAXP"][4:7], "big")
    # Each glyph takes at least two bytes in one of these tables.
    room = (
        max(len(font.reader[tag]) for tag in ("LOCA", "HMTX", "CFF2", "MAXP") if tag in font) // 2
    )
    if count > room:
        raise FontError(
            f"The MAXP table is damaged: it states {count} glyphs, and the file has room for "
            f"{room} at most."
        )


def _font_count(data: bytes) -> int:
    """How many fonts a file holds: 1, except for a collection (OpenType, "TTC header")."""
    return int.from_bytes(data[8:12], "big") if data[:4] == b"ttcf" else 1


def font_bytes(font: TTFont) -> bytes:
    """The file that :func:`open_font` opened."""
    return bytes(font.reader.file.getvalue())


def saved(font: TTFont, flavor: str | None = None) -> bytes:
    """An open font as a file, by default without compression; the font itself is left as it is."""
    file, own = io.BytesIO(), font.flavor
    try:
        font.flavor = flavor
        font.save(file, reorderTables=None)
    finally:
        font.flavor = own
    return file.getvalue()


def _read(source: str | os.PathLike[str]) -> bytes:
    try:
        name = os.fsdecode(source)
    except TypeError:
        raise FontError(
            "A font source must be a bundled name, a path, a URL, bytes or a fontTools TTFont; "
            f"received {type(source).__name__}."
        ) from None
    if name in bundled_fonts():
        return (resources.files("vfwidget") / "fonts" / f"{name}.woff2").read_bytes()
    if name.startswith(SCHEMES):
        return download(name)
    try:
        path = Path(name).expanduser()
        # A pipe or a device could go on for ever.
        if not path.is_file():
            raise FileNotFoundError(name)
        with path.open("rb") as file:
            return file.read(limits.font_file_bytes + 1)
    except (OSError, ValueError, RuntimeError) as error:
        raise FontError(
            f"No bundled font and no readable file is called {name!r}. "
            f"Bundled fonts: {', '.join(bundled_fonts()) or 'none'}."
        ) from error


def reason(error: Exception) -> str:
    """An exception in words: its class, and its message if it has one."""
    return f"{type(error).__name__}: {error}" if str(error) else type(error).__name__


@contextmanager
def damage(problem: str) -> Iterator[None]:
    """Turn any exception of a parser into a :class:`FontError` that states the problem.

    fontTools meets damaged tables with any exception at all.
    """
    try:
        yield
    except VFWidgetError:
        raise
    except Exception as error:
        raise FontError(f"{problem} ({reason(error)}).") from error
