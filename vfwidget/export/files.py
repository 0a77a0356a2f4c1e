"""The end of every export: a file, or its content."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TypeVar

Content = TypeVar("Content", str, bytes)


def written(content: Content, path: str | os.PathLike[str] | None) -> Content | None:
    """Write content to a file, which is replaced if it exists; without a path, return it."""
    if path is None:
        return content
    data = content.encode() if isinstance(content, str) else content
    Path(path).write_bytes(data)
    return None
