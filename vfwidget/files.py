"""Files that are written: every export and every font ends here."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path
from typing import TypeVar

from .errors import VFWidgetError

Content = TypeVar("Content", str, bytes)


def written(content: Content, path: str | os.PathLike[str] | None) -> Content | None:
    """Write content to a file, which is replaced if it exists; without a path, return it.

    Raises
    ------
    VFWidgetError, OSError
        The path is not valid, or the file cannot be written.
    """
    if path is None:
        return content
    write(path, content.encode() if isinstance(content, str) else content)
    return None


def write(path: str | os.PathLike[str], data: bytes) -> None:
    """Write a file, which is replaced if it exists.

    Raises
    ------
    VFWidgetError, OSError
        The path is not valid, or the file cannot be written.
    """
    _path(path).write_bytes(data)


def write_numbered(folder: str | os.PathLike[str], contents: Iterable[bytes], suffix: str) -> None:
    """Write ``frame-0001.suffix`` and so on into a folder, which is made if it does not exist.

    Files of these names are replaced.

    Raises
    ------
    VFWidgetError, OSError
        The path is not valid, or the files cannot be written.
    """
    place = _path(folder)
    place.mkdir(parents=True, exist_ok=True)
    for number, content in enumerate(contents, start=1):
        (place / f"frame-{number:04d}.{suffix}").write_bytes(content)


def _path(path: str | os.PathLike[str]) -> Path:
    if not isinstance(path, str | os.PathLike) or not str(path) or "\0" in str(path):
        raise VFWidgetError(
            f"A file to write is named by a string or a pathlib.Path; received {path!r:.200}."
        )
    return Path(path)
