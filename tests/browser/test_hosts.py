"""The same tour of an editor in JupyterLab, in Notebook 7, in marimo and on an exported page."""

from __future__ import annotations

import json
import os
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import nbformat
import pytest

import vfwidget as vf
from tests.browser.conftest import wait_for
from tests.browser.screen import Screen, tour

pytestmark = [pytest.mark.browser, pytest.mark.slow, pytest.mark.timeout(300)]

AXES = {"wght": 600}
SHOW = f"import vfwidget as vf\neditor = vf.Editor('recursive', 'hand', axes={AXES})\neditor"
MARIMO = f"""
import marimo

app = marimo.App()


@app.cell
def _():
    import json
    import marimo as mo
    import vfwidget as vf
    editor = mo.ui.anywidget(vf.Editor("recursive", "hand", axes={AXES}))
    editor
    return editor, json, mo


@app.cell
def _(editor, json, mo):
    mo.Html(f"<pre id='report'>{{json.dumps([editor.value['axes'], editor.widget.axes])}}</pre>")
    return
"""


@pytest.fixture
def text() -> vf.Text:
    return vf.Text("recursive", "hand", axes=AXES)


@pytest.fixture
def page(browser: Any) -> Iterator[Any]:
    """A page on which nothing is thrown."""
    context = browser.new_context(viewport={"width": 1100, "height": 1000})
    opened = context.new_page()
    troubles: list[str] = []
    opened.on("pageerror", lambda error: troubles.append(str(error)))
    yield opened
    context.close()
    # Notebook 7 throws the last two while it starts.
    hosts_own = "Canceled future for", "reading 'schema'", "'filebrowser:open-path' not registered"
    assert [t for t in troubles if not any(known in t for known in hosts_own)] == []


def editor_on(page: Any) -> Screen:
    root = page.locator(".vfwidget-editor").first
    root.wait_for(state="visible", timeout=120_000)
    root.scroll_into_view_if_needed()
    return Screen(page, root)


def test_the_editor_works_in_jupyterlab(lab: Any, text: vf.Text) -> None:
    notebook = lab([SHOW, "print(editor.axes)"])
    screen = Screen(notebook.page, notebook.editors.first)
    screen.root.scroll_into_view_if_needed()
    tour(screen, text)


def test_notebook_7_and_a_notebook_saved_there(
    server: tuple[str, Path], page: Any, text: vf.Text
) -> None:
    address, folder = server
    name = f"seven-{time.monotonic_ns()}.ipynb"
    cell = nbformat.v4.new_code_cell(SHOW)
    kernel = {"kernelspec": {"name": "python3", "display_name": "Python 3"}}
    nbformat.write(nbformat.v4.new_notebook(cells=[cell], metadata=kernel), folder / name)
    page.goto(f"{address}/notebooks/{name}")
    page.wait_for_selector(".jp-Notebook .jp-Cell", timeout=120_000)
    page.evaluate(
        """async () => {
          const app = window.jupyterapp;
          await app.shell.currentWidget.context.sessionContext.ready;
          await app.commands.execute('notebook:run-all-cells');
        }"""
    )
    tour(editor_on(page), text)
    page.wait_for_timeout(1000)
    page.evaluate("() => window.jupyterapp.shell.currentWidget.context.save()")
    saved = nbformat.read(folder / name, as_version=4)
    assert any("image/svg+xml" in output.get("data", {}) for output in saved.cells[0].outputs)


def test_marimo_and_its_value_after_a_drag(browser: Any, page: Any, tmp_path: Path) -> None:
    file = tmp_path / "app.py"
    file.write_text(MARIMO, encoding="utf-8")
    text = vf.Text("recursive", "hand", axes=AXES)
    with marimo(file) as address:
        page.goto(address)
        screen = editor_on(page)
        tour(screen, text)
        report = page.locator("#report")
        page.wait_for_function(
            """axes => {
              const [value, own] = JSON.parse(document.querySelector('#report').innerText);
              return Object.keys(own).every(
                tag => Math.abs(own[tag] - axes[tag]) < 0.01 && value[tag] === own[tag]);
            }""",
            arg=screen.axes,
            timeout=20_000,
        )
        value, own = json.loads(report.inner_text())
    assert value == own != text.axes


def test_an_exported_page_without_a_network(browser: Any, tmp_path: Path, text: vf.Text) -> None:
    vf.Editor(text).to_html(tmp_path / "page.html")
    for width in (400, 1000):
        context = browser.new_context(viewport={"width": width, "height": 900}, offline=True)
        page = context.new_page()
        page.goto((tmp_path / "page.html").as_uri())
        tour(editor_on(page), text)
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        context.close()


@contextmanager
def marimo(file: Path) -> Iterator[str]:
    """The address of a marimo app."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    process = subprocess.Popen(
        [
            *(sys.executable, "-m", "marimo", "--quiet", "run", str(file), "--headless"),
            *("--no-token", "--host", "127.0.0.1", "--port", str(port)),
        ],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(p for p in sys.path if p)},
        cwd=file.parent,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        wait_for(f"http://127.0.0.1:{port}/health", process)
        yield f"http://127.0.0.1:{port}"
    finally:
        process.terminate()
        process.wait(30)
