"""An exported page in Firefox, driven by WebDriver BiDi.

Playwright drives only a Firefox of its own. Debian's listens to the standard protocol.
"""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import closing
from itertools import count
from pathlib import Path
from typing import Any

import pytest
import websocket

import vfwidget as vf
from tests.browser.conftest import REQUIRED

OPTIONS = {"timeout": 60, "suppress_origin": True}
"""Firefox refuses connections that pages make."""
FIREFOX = shutil.which("firefox-esr") or shutil.which("firefox")

pytestmark = [pytest.mark.browser, pytest.mark.slow]


class Page:
    """A page in Firefox."""

    def __init__(self, socket: Any, url: str) -> None:
        self._socket = socket
        self._ids = count(1)
        self.call("session.new", capabilities={})
        self._context = self.call("browsingContext.getTree")["contexts"][0]["context"]
        self.call("browsingContext.navigate", context=self._context, url=url, wait="complete")

    def call(self, method: str, **params: Any) -> Any:
        """Send a command, and return its result."""
        number = next(self._ids)
        self._socket.send(json.dumps({"id": number, "method": method, "params": params}))
        while True:
            answer = json.loads(self._socket.recv())
            if answer.get("id") == number:
                assert answer["type"] == "success", answer
                return answer["result"]

    def evaluate(self, expression: str) -> Any:
        """The value of an expression that gives a JSON string."""
        target = {"context": self._context}
        arguments = {"expression": expression, "target": target, "awaitPromise": True}
        return json.loads(self.call("script.evaluate", **arguments)["result"]["value"])

    def drag(self, x: float, y: float, way: int) -> None:
        """Press at (x, y), move to the right, and release."""
        moves = [{"x": round(x + step), "y": round(y)} for step in (0, *range(1, way + 1, 4))]
        steps = [{"type": "pointerMove", "duration": 20, **move} for move in moves]
        press, release = {"type": "pointerDown", "button": 0}, {"type": "pointerUp", "button": 0}
        actions = [steps[0], steps[1], press, *steps[2:], release]
        pointer = {"type": "pointer", "id": "mouse", "parameters": {"pointerType": "mouse"}}
        self.call(
            "input.performActions", context=self._context, actions=[{**pointer, "actions": actions}]
        )

    @property
    def axes(self) -> list[float]:
        """The values of the sliders."""
        found: list[float] = self.evaluate(
            """(async () => {
              await new Promise(done => setTimeout(done, 500));
              const sliders = [...document.querySelectorAll('input[type=range]')];
              return JSON.stringify(sliders.map(slider => Number(slider.value)));
            })()"""
        )
        return found


@pytest.fixture
def page(tmp_path: Path) -> Iterator[Page]:
    if FIREFOX is None:
        if REQUIRED:
            pytest.fail("VFWIDGET_REQUIRE_BROWSER is set and there is no Firefox.")
        pytest.skip("needs Firefox")
    file = tmp_path / "page.html"
    above = [(0, 1200), (300, 1200), (300, 1400)]
    vf.Editor("recursive", "hand", axes={"wght": 600}, obstacles=[above]).to_html(file)
    with tempfile.TemporaryDirectory() as profile:
        options = ["--headless", "--no-remote", "--profile", profile, "--remote-debugging-port=0"]
        process = subprocess.Popen([FIREFOX, *options], stderr=subprocess.PIPE, text=True)
        assert process.stderr is not None
        try:
            told = (re.search(r"BiDi listening on (ws://\S+)", line) for line in process.stderr)
            address = next(found[1] for found in told if found)
            with closing(websocket.create_connection(f"{address}/session", **OPTIONS)) as socket:
                yield Page(socket, file.as_uri())
        finally:
            process.terminate()
            process.wait(30)
            process.stderr.close()


def test_an_obstacle_above_the_word_is_in_the_picture(page: Page) -> None:
    page.evaluate("new Promise(done => setTimeout(() => done('0'), 1200))")
    picture, obstacle = page.evaluate(
        """JSON.stringify(['.vfw-svg', '.vfw-obstacles'].map(name => {
          const box = document.querySelector(name).getBoundingClientRect();
          return [box.top, box.bottom];
        }))"""
    )
    assert picture[0] < obstacle[0] < obstacle[1] < picture[1]


def test_a_letter_is_dragged_and_the_drag_undone(page: Page) -> None:
    before = page.axes
    left, top, width, height = page.evaluate(
        """(() => {
          const path = document.querySelector('.vfw-letter');
          const box = path.getBoundingClientRect();
          return JSON.stringify([box.x, box.y, box.width, box.height]);
        })()"""
    )
    assert width > 50 and height > 100
    # The top of the h, which leans then.
    page.drag(left + 0.1 * width, top + 1, 24)
    after = page.axes
    assert after != before
    page.evaluate("(document.querySelector('.vfw-undo').click(), '0')")
    assert page.axes == before
