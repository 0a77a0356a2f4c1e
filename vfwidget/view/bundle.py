"""The script and the style sheet of the views, which are built from ``js/``."""

from __future__ import annotations

from importlib import resources

PAGE_STYLE = """
:root { color-scheme: light dark; }
body { max-width: 1000px; margin: 24px auto; padding: 0 16px; --vfw-height: 60vh; }
"""
"""Style of a page that holds one view."""


def built(name: str) -> str:
    """Read a file of ``vfwidget/static``.

    Raises
    ------
    ImportError
        The file has not been built.
    """
    file = resources.files("vfwidget") / "static" / name
    if not file.is_file():
        raise ImportError(
            f"vfwidget/static/{name} is missing: the view is bundled when the package is "
            "installed. Run `pip install .` (or `npm ci && npm run build` in js/)."
        )
    return file.read_text(encoding="utf-8")
