"""What an editor can be written as: a page, an SVG picture, CSS."""

from __future__ import annotations

import os
from typing import Any, overload

from ..export.page import page, view
from ..files import written
from ..font import Font
from .bundle import PAGE_STYLE, built

PAGE_TRAITS = (
    *("_word", "axes", "shared", "_pins", "locks", "constraints", "_obstacles"),
    *("height", "theme", "teaching"),
)
"""The traits that a view needs on a page without a kernel."""


class Exports:
    """Methods of :class:`Editor` that write it, as it stands, in other formats."""

    text: Any
    get_state: Any
    _lock: Any
    _css: Any

    @overload
    def to_html(self) -> str: ...
    @overload
    def to_html(self, path: str | os.PathLike[str]) -> None: ...
    def to_html(self, path: str | os.PathLike[str] | None = None) -> str | None:
        """Write the editor as a page of its own, which needs neither a kernel nor a network.

        The page starts at the present axes. The outline can be dragged as in the notebook, because
        the page contains the solver for targets, pins and locks. Obstacles are drawn, but drags on
        the page do not avoid overlaps, because only the kernel computes these.

        Parameters
        ----------
        path : str or path, optional
            The file to write. Without it, the page is returned.

        Returns
        -------
        str or None
        """
        with self._lock:
            body = view(self.get_state(PAGE_TRAITS))
            title = self.text.title
        made = page(title, body, [built("page.js")], self._css + PAGE_STYLE)
        return written(made, path)

    def to_svg(self, path: str | os.PathLike[str] | None = None) -> str | None:
        """As :meth:`Text.to_svg`, for the word as it stands."""
        return self.text.to_svg(path)

    def to_css(self, path: str | os.PathLike[str] | None = None) -> str | None:
        """As :meth:`Text.to_css`, for the word at the present axes."""
        return self.text.to_css(path)

    def to_font(self, path: str | os.PathLike[str] | None = None, name: str | None = None) -> Font:
        """As :meth:`Text.to_font`: the word's glyphs at the present axes, as a static font."""
        return self.text.to_font(path, name)
