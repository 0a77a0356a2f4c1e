"""The editor's picture in light and dark, compared with kept pictures.

Only the picture is compared: the word and the marks on it are drawn from outlines, so they look the
same on every machine. The panel below is set in the fonts of the machine; what it says, its
contrast and its width are tested elsewhere. Edges are smoothed differently by versions of Chromium,
so a pixel counts only if it differs much, and a few may.

``python -m tests.browser.test_appearance`` draws the kept pictures again.
"""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import vfwidget as vf
from tests.browser.conftest import CHROMIUM

pytestmark = [pytest.mark.browser, pytest.mark.slow, pytest.mark.timeout(120)]

KEPT = Path(__file__).with_name("kept")
WIDTH = 500
MUCH = 96
"""Levels of 255 by which a pixel must differ in some channel to count."""
FEW = 40
"""Pixels that may differ; the smallest mark, a pin, has more than 80."""


def draw(browser: Any, folder: Path, theme: str, pinned: bool = True) -> np.ndarray:
    """A screenshot of a picture with all kinds of marks, (h, w, 3)."""
    axes = [{"wght": 400 + 150 * i} for i in range(4)]
    text = vf.Text("recursive", "hand", axes=axes, shared=False)
    bar = [(2100, -100), (2160, -100), (2160, 800), (2100, 800)]
    editor = vf.Editor(text, theme=theme, height=230, obstacles=[bar])
    feet = [text.nearest(x, 0) for x in (60, 1500)]
    editor.constraints = [vf.SharedY(feet)]
    editor.pins = [text.nearest(100, 700)] if pinned else []
    editor.to_html(folder / "page.html")
    context = browser.new_context(viewport={"width": WIDTH, "height": 700}, offline=True)
    page = context.new_page()
    page.goto((folder / "page.html").as_uri())
    root = page.locator(".vfwidget-editor")
    root.locator(".vfw-chip").nth(1).click()
    root.locator(".vfw-chip").nth(2).click(modifiers=["Shift"])
    # Text is in the fonts of the machine.
    page.add_style_tag(content=".vfw-family, .vfw-window { visibility: hidden }")
    x, y = text.position(text.nearest(900, 300)).tolist()
    place = root.evaluate("(root, p) => root.__vfw.toClient(...p)", [x, y])
    page.mouse.move(place["x"], place["y"])
    page.wait_for_timeout(800)
    data = root.locator("svg.vfw-svg").screenshot()
    context.close()
    return np.asarray(Image.open(io.BytesIO(data)).convert("RGB"), dtype=int)


def different(one: np.ndarray, other: np.ndarray) -> int:
    """How many pixels differ much."""
    assert one.shape == other.shape
    return int((np.abs(one - other).max(-1) > MUCH).sum())


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_the_picture_looks_as_it_did(browser: Any, tmp_path: Path, theme: str) -> None:
    kept = np.asarray(Image.open(KEPT / f"{theme}.png").convert("RGB"), dtype=int)
    assert different(draw(browser, tmp_path, theme), kept) <= FEW
    if theme == "light":
        # The comparison would notice that a pin is not drawn.
        assert different(draw(browser, tmp_path, theme, pinned=False), kept) > FEW


if __name__ == "__main__":
    from tempfile import TemporaryDirectory

    from playwright.sync_api import sync_playwright

    KEPT.mkdir(exist_ok=True)
    with sync_playwright() as playwright, TemporaryDirectory() as folder:
        chromium = playwright.chromium.launch(
            executable_path=CHROMIUM, args=["--no-sandbox", "--disable-gpu"]
        )
        for name in ("light", "dark"):
            picture = draw(chromium, Path(folder), name).astype(np.uint8)
            Image.fromarray(picture).quantize(64).save(KEPT / f"{name}.png", optimize=True)
        chromium.close()
