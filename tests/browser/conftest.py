"""Real JupyterLab in a real Chromium: one server and one browser for each process of tests."""

from __future__ import annotations

import json
import os
import shutil
import socket
import subprocess
import sys
import time
import urllib.request
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import nbformat
import pytest

REQUIRED = bool(os.environ.get("VFWIDGET_REQUIRE_BROWSER"))
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
START_SECONDS = 90
RUN_MILLISECONDS = 120_000


@pytest.fixture(scope="session")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[str, Path]]:
    """A JupyterLab server: its address and its folder of notebooks."""
    folder = tmp_path_factory.mktemp("lab")
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    home = tmp_path_factory.mktemp("home")
    process = subprocess.Popen(
        [
            *(sys.executable, "-m", "jupyterlab", "--no-browser", "--allow-root"),
            *("--ServerApp.ip=127.0.0.1", f"--ServerApp.port={port}"),
            *("--IdentityProvider.token=", "--ServerApp.password="),
            *(f"--ServerApp.root_dir={folder}", "--LabApp.expose_app_in_browser=True"),
            "--JupyterNotebookApp.expose_app_in_browser=True",
            *("--LabApp.news_url=", "--ServerApp.disable_check_xsrf=True"),
            # A free port might be taken before the kernel has it.
            "--KernelManager.transport=ipc",
        ],
        env={
            **os.environ,
            "JUPYTER_CONFIG_DIR": str(home),
            "IPYTHONDIR": str(home),
            # The package is imported from wherever the tests found it.
            "PYTHONPATH": os.pathsep.join(p for p in sys.path if p),
        },
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    address = f"http://127.0.0.1:{port}"
    try:
        wait_for(f"{address}/api/status", process)
        yield address, folder
    finally:
        process.terminate()
        try:
            process.wait(60)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def wait_for(url: str, process: subprocess.Popen[bytes]) -> None:
    end = time.monotonic() + START_SECONDS
    while time.monotonic() < end and process.poll() is None:
        try:
            urllib.request.urlopen(url, timeout=2).close()
            return
        except OSError:
            time.sleep(0.2)
    pytest.fail(f"{url} did not answer within {START_SECONDS} s.")


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    if CHROMIUM is None:
        if REQUIRED:
            pytest.fail("VFWIDGET_REQUIRE_BROWSER is set and there is no Chromium.")
        pytest.skip("needs Chromium")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(
            executable_path=CHROMIUM,
            args=["--no-sandbox", "--disable-gpu", "--disable-background-networking"],
        )
        yield chromium
        chromium.close()


@pytest.fixture
def offline_page(browser: Any) -> Iterator[Callable[..., Any]]:
    """Open a file as a page; nothing may be requested, and nothing may go wrong on it."""
    troubles: list[str] = []
    contexts = []

    def open_page(file: Path, width: int, height: int, **options: Any) -> Any:
        size = {"width": width, "height": height}
        contexts.append(browser.new_context(viewport=size, offline=True, **options))
        page = contexts[-1].new_page()
        page.on("console", lambda message: troubles.append(message.text))
        page.on("pageerror", lambda error: troubles.append(str(error)))
        page.on("request", lambda r: r.is_navigation_request() or troubles.append(r.url))
        page.goto(file.as_uri())
        page.locator("path.vfw-letter[d]").first.wait_for(state="attached")
        return page

    yield open_page
    for context in contexts:
        context.close()
    assert troubles == []


class Notebook:
    """A notebook open in JupyterLab, all its cells run."""

    def __init__(self, page: Any, editors: int, widget: str) -> None:
        self.page = page
        self.editors = page.locator(widget)
        self.editors.nth(editors - 1).wait_for(state="visible", timeout=RUN_MILLISECONDS)

    def run_last_cell(self) -> str:
        """Run the last cell once more, and give what it prints."""
        self.page.evaluate(
            """async () => {
              const app = window.jupyterapp;
              const notebook = app.shell.currentWidget.content;
              notebook.activeCellIndex = notebook.widgets.length - 1;
              notebook.activeCell.model.sharedModel.setOutputs([]);
              await app.commands.execute('notebook:run-cell');
            }"""
        )
        return self.output(-1)

    def output(self, cell: int) -> str:
        """What a cell printed."""
        return str(
            self.page.evaluate(
                """cell => {
                  const cells = window.jupyterapp.shell.currentWidget.content.widgets;
                  const outputs = cells.at(cell).model.sharedModel.getOutputs();
                  return outputs.map(o => Array.isArray(o.text) ? o.text.join('') : o.text || '')
                    .join('');
                }""",
                cell,
            )
        )

    def errors(self) -> list[str]:
        """Errors that any cell's output holds."""
        found = self.page.evaluate(
            """() => window.jupyterapp.shell.currentWidget.content.widgets.flatMap(
              cell => cell.model.type === 'code' ? cell.model.sharedModel.getOutputs() : [])
              .filter(o => o.output_type === 'error').map(o => o.ename + ': ' + o.evalue)"""
        )
        return list(found)


@pytest.fixture
def lab(server: tuple[str, Path], browser: Any) -> Iterator[Any]:
    """Open cells, or a notebook file, in JupyterLab and run them all."""
    address, folder = server
    context = browser.new_context(viewport={"width": 1280, "height": 1000})
    page = context.new_page()
    troubles: list[str] = []
    page.on("pageerror", lambda error: troubles.append(str(error)))

    def open_notebook(
        source: Path | list[str], editors: int = 1, widget: str = ".vfwidget-editor"
    ) -> Notebook:
        if isinstance(source, Path):
            notebook = nbformat.read(source, as_version=4)
        else:
            notebook = nbformat.v4.new_notebook(
                cells=[nbformat.v4.new_code_cell(cell) for cell in source],
                metadata={"kernelspec": {"name": "python3", "display_name": "Python 3"}},
            )
        name = f"notebook-{time.monotonic_ns()}.ipynb"
        nbformat.write(notebook, folder / name)
        page.goto(f"{address}/lab/tree/{name}?reset")
        page.wait_for_selector(".jp-Notebook .jp-Cell", timeout=RUN_MILLISECONDS)
        page.evaluate(
            """async () => {
              const app = window.jupyterapp;
              await app.shell.currentWidget.context.sessionContext.ready;
              app.commands.execute('application:toggle-left-area');
              await app.commands.execute('notebook:run-all-cells');
            }"""
        )
        return Notebook(page, editors, widget)

    yield open_notebook
    _shut_kernels(address)
    context.close()
    # JupyterLab throws this itself for requests to a kernel that is restarted or shut down.
    troubles = [trouble for trouble in troubles if "Canceled future for" not in trouble]
    assert not troubles, f"The page threw: {troubles}"


def _shut_kernels(address: str) -> None:
    with urllib.request.urlopen(f"{address}/api/sessions") as response:
        sessions = json.load(response)
    for session in sessions:
        request = urllib.request.Request(f"{address}/api/sessions/{session['id']}", method="DELETE")
        urllib.request.urlopen(request).close()
