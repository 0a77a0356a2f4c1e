"""A picture of a widget that a saved, converted or hosted notebook shows in its place.

The picture is an output of its own below the widget, so that updating it does not touch the live
view. The view hides it while it is alive (the class and the name below are part of its contract).
"""

from __future__ import annotations

import base64
import re
import threading
import uuid
import weakref
from collections.abc import Callable
from html import escape
from typing import Any

SNAPSHOT = "vfw-snapshot"
"""The class of the picture on a page."""
DELAY = 0.5
"""Seconds without a change until the picture is drawn again."""


class Snapshot:
    """A picture in the output of a cell, kept up to date.

    Parameters
    ----------
    draw : callable
        Draws the present state as an SVG document with a title.
    purpose : str
        What a reader can do after running the cell.

    Attributes
    ----------
    name : str
        Names the picture on the page.
    """

    def __init__(self, draw: Callable[[], str], purpose: str = "edit it") -> None:
        self.name = uuid.uuid4().hex
        self._draw, self._purpose = draw, purpose
        self._handle: Any = None
        self._timer: threading.Timer | None = None

    def bundle(self) -> dict[str, str]:
        """The picture as MIME data: HTML for a page, SVG, and a line of text."""
        svg = self._draw()
        found = re.search("<title>(.*?)</title>", svg, re.DOTALL)
        title = found[1] if found else ""
        data = base64.b64encode(svg.encode()).decode("ascii")
        html = (
            f'<div class="{SNAPSHOT} {SNAPSHOT}-{self.name}">'
            f'<img src="data:image/svg+xml;base64,{data}" alt="{title}">'
            f"<p>{title}. Run the cell to {self._purpose}.</p></div>"
        )
        return {"text/html": html, "image/svg+xml": svg, "text/plain": escape(title, quote=False)}

    def show(self) -> None:
        """Put the picture into the output of the running cell."""
        from IPython.core.getipython import get_ipython
        from IPython.display import display

        shell = get_ipython()
        if self._handle is None and shell is not None:
            # A cell that changes the widget leaves the picture as of its end. The shell must not
            # keep a widget alive that nobody else refers to.
            update = weakref.WeakMethod(self.update)
            shell.events.register("post_run_cell", lambda _: (update() or _nothing)())
        self._handle = display(self.bundle(), raw=True, display_id=True)

    def expire(self) -> None:
        """Note that the picture is out of date; it is drawn again soon."""
        if self._handle is None:
            return
        if self._timer is not None:
            # Each new picture makes the page work, which a drag has no time for.
            self._timer.cancel()
        self._timer = threading.Timer(DELAY, self.update)
        self._timer.daemon = True
        self._timer.start()

    def update(self) -> None:
        """Draw the picture again if it is out of date."""
        timer, self._timer = self._timer, None
        if timer is not None:
            timer.cancel()
            self._handle.update(self.bundle(), raw=True)


def _nothing() -> None:
    """Stand in for a picture that is gone."""
