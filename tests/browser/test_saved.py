"""What is left of an editor when its kernel is gone: a saved, a converted, a restarted notebook."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import nbformat
import pytest
from nbclient import NotebookClient
from nbconvert import HTMLExporter

import vfwidget as vf

pytestmark = [pytest.mark.browser, pytest.mark.timeout(240)]

CELLS = [
    "import vfwidget as vf\neditor = vf.Editor('dynapuff', 'hi')\neditor",
    "editor.axes = {'wght': 700}",
]


@pytest.mark.slow
def test_a_converted_notebook_shows_the_word_without_a_network(
    browser: Any, tmp_path: Path
) -> None:
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(c) for c in CELLS])
    NotebookClient(notebook, timeout=120).execute()
    _, picture = notebook.cells[0].outputs
    # The picture is as of the end of the last cell.
    bold = vf.Editor("dynapuff", "hi", {"wght": 700}).to_svg()
    assert re.findall(' d="(.*?)"', picture.data["image/svg+xml"]) == re.findall(' d="(.*?)"', bold)
    assert picture.data["text/plain"] == "hi in DynaPuff"
    html, _ = HTMLExporter().from_notebook_node(notebook)
    (tmp_path / "saved.html").write_text(html, encoding="utf-8")
    context = browser.new_context(offline=True)
    page = context.new_page()
    page.goto((tmp_path / "saved.html").as_uri(), wait_until="domcontentloaded")
    image = page.locator(".vfw-snapshot img")
    image.wait_for(state="visible")
    assert image.evaluate("image => image.decode().then(() => image.naturalHeight)") == 180
    assert "Run the cell" in page.locator(".vfw-snapshot p").inner_text()
    context.close()


@pytest.mark.slow
def test_a_restarted_kernel_is_said_plainly_and_running_the_cell_recovers(lab: Any) -> None:
    notebook = lab(CELLS[:1])
    page, editor = notebook.page, notebook.editors.first
    assert page.locator(".vfw-snapshot").count() == 1
    assert not page.locator(".vfw-snapshot").is_visible()
    page.evaluate(
        """async () => { const s = window.jupyterapp.shell.currentWidget.context.sessionContext;
                        await s.session.kernel.restart(); await s.ready }"""
    )
    page.wait_for_timeout(1000)
    before = editor.locator("path.vfw-letter").first.get_attribute("d")
    box = editor.locator("path.vfw-letter").first.bounding_box()
    page.mouse.move(box["x"], box["y"] + box["height"] / 2)
    page.mouse.down()
    page.mouse.move(box["x"] - 12, box["y"] + box["height"] / 2, steps=5)
    page.mouse.up()
    page.wait_for_timeout(4000)
    status = editor.locator(".vfw-status")
    assert "Run its cell again" in status.inner_text()
    assert editor.locator("path.vfw-letter").first.get_attribute("d") != before
    notebook.run_last_cell()
    page.wait_for_timeout(500)
    fresh = page.locator(".vfwidget-editor").first
    fresh.wait_for(state="visible")
    assert "Drag the outline" in fresh.locator(".vfw-status").inner_text()


def test_a_reopened_notebook_shows_the_word(lab: Any) -> None:
    notebook = lab(CELLS)
    page = notebook.page
    page.wait_for_timeout(1000)
    page.evaluate(
        """async () => {
          const app = window.jupyterapp, panel = app.shell.currentWidget;
          await panel.context.save();
          await panel.context.sessionContext.shutdown();
        }"""
    )
    page.reload()
    image = page.locator(".vfw-snapshot img")
    image.wait_for(state="visible", timeout=60_000)
    assert image.evaluate("image => image.decode().then(() => image.naturalHeight)") == 180
