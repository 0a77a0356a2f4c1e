"""The end of every export: a file, or its content."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path
from typing import TypeVar

Content = TypeVar("Content", str, bytes)


def written(content: Content, path: str | os.PathLike[str] | None) -> Content | None:
    """Write content to a file, which is replaced if it exists; without a path, return it.

    Raises
    ------
    OSError
        The file cannot be written.
    """
    if path is None:
        return content
    data = content.encode() if isinstance(content, str) else content
    Path(path).write_bytes(data)
    return None


def write_numbered(folder: str | os.PathLike[str], contents: Iterable[bytes], suffix: str) -> None:
    """Write ``frame-0001.suffix`` and so on into a folder, which is made if it does not exist.

    Files of these names are replaced.

    Raises
    ------
    OSError
        The file cannot be written.
    """
    place = Path(folder)
    place.mkdir(parents=True, exist_ok=True)
    for number, content in enumerate(contents, start=1):
        (place / f"frame-{number:04d}.{suffix}").write_bytes(content)
