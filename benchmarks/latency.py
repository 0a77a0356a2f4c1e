"""Time from a pointer event to the painted frame, in JupyterLab in headless Chromium.

A drag follows reachable positions and returns, with one pointer move every 1/60 s. The latency of
a pointer event ends with the first painted frame that shows the answer to it or to a later event,
because the view keeps only the latest event while the kernel solves. The editor sends moves as
soon as it can (``throttle=0``); what the view draws by itself is measured by *smooth*. The baseline
is the time from an input event of a slider to the painted frame, which needs no kernel.
"""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
import sys
import tempfile
import time
import urllib.request
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import nbformat
import numpy as np

import vfwidget as vf

from .drag import WORD, Drag
from .table import Row, milliseconds
from .timing import Array, Spread

MOVES = 60
PERIOD = 1 / 60
PATIENCE = 120
"""Seconds that JupyterLab may take to start, and a notebook to run."""

PROBE = """root => {
  const log = window.probe = {moves: [], sent: [], answered: [], paints: []};
  const { stats } = root.__vfw;
  for (const name of ['sent', 'answered']) {
    let count = stats[name];
    Object.defineProperty(stats, name, {
      get: () => count,
      set: value => { count = value; log[name].push(performance.now()); },
    });
  }
  addEventListener('pointermove', e => e.buttons && log.moves.push(performance.now()), true);
  // A message that is posted when a frame changes arrives after the frame has been painted.
  const { port1, port2 } = new MessageChannel();
  port1.onmessage = ({ data }) => log.paints.push([data, performance.now()]);
  new MutationObserver(() => port2.postMessage(performance.now()))
    .observe(root, {subtree: true, attributeFilter: ['d']});
}"""
"""Records the times of pointer moves, messages, answers, and (change, paint) pairs."""

SLIDE = """async ([root, count]) => {
  const slider = root.querySelector('input[type=range]');
  const low = Number(slider.min), high = Number(slider.max), times = [];
  for (let i = 0; i < count; i++) {
    await new Promise(done => setTimeout(done, 1000 / 60));
    slider.value = low + (high - low) * (0.2 + 0.6 * (1 - Math.abs(1 - 2 * i / count)));
    times.push(performance.now());
    slider.dispatchEvent(new Event('input', {bubbles: true}));
  }
  return times;
}"""


def run(quick: bool) -> Iterator[Row]:
    """Measure a single glyph, then a word with one axis vector per letter."""
    chromium = shutil.which("chromium")
    if chromium is None:
        yield Row("latency", "skipped: requires Chromium", "", "", "")
        return
    with jupyterlab() as (address, folder), browser_page(chromium) as page:
        for string, shared in (("a", True), (WORD, False)):
            drag = Drag.reachable(vf.Text("recursive", string, shared=shared))
            name = f"{string}-{shared}.ipynb"
            nbformat.write(notebook_of(drag.text, "throttle=0"), folder / name)
            root = open_notebook(page, f"{address}/lab/tree/{name}?reset")
            yield from _measure(page, root, drag, rounds=2 if quick else 6)


def _measure(page: Any, root: Any, drag: Drag, rounds: int) -> Iterator[Row]:
    root.evaluate(PROBE)
    drags, slides, trips = [], [], []
    for turn in range(rounds + 1):
        if turn % 2:
            slides.append(_slide(page, root))
        latencies, round_trips = _drag(page, root, drag)
        drags.append(latencies)
        trips.append(round_trips)
        if not turn % 2:
            slides.append(_slide(page, root))
    del drags[0], slides[0], trips[0]  # warm-up
    ratios = [np.median(a) / np.median(b) for a, b in zip(drags, slides, strict=True)]
    case = f"recursive {drag.text.string}" + ("" if drag.text.shared else ", per letter")
    pointer, slider, trip = map(np.concatenate, (drags, slides, trips))
    yield Row(
        benchmark="latency",
        case=case,
        ours=milliseconds(np.median(pointer)),
        baseline=f"slider {milliseconds(np.median(slider))}",
        ratio=str(Spread(*np.percentile(ratios, [25, 50, 75]))),
        notes=f"95 %: {np.percentile(pointer, 95):.1f} | {np.percentile(slider, 95):.1f} ms",
    )
    yield Row(
        benchmark="latency",
        case=f"{case}, kernel",
        ours=milliseconds(np.median(trip)),
        baseline=f"of {milliseconds(np.median(pointer))}",
        ratio="",
        notes=f"95 %: {np.percentile(trip, 95):.1f} ms, "
        f"{len(trip) / rounds:.0f} messages for {len(pointer) / rounds:.0f} moves",
    )


def _drag(page: Any, root: Any, drag: Drag) -> tuple[Array, Array]:
    """Drag to the last target and back; return latencies of moves and of messages."""
    ahead = [drag.text.position(drag.handle).tolist(), *(t.tolist() for t in drag.targets)]
    way = np.array((ahead + ahead[::-1])[: MOVES + 1])
    places = root.evaluate("(root, way) => way.map(p => root.__vfw.toClient(...p))", way.tolist())
    page.mouse.move(**places[0])
    page.mouse.down()
    _clear(page)
    due = time.perf_counter()
    for place in places[1:]:
        page.mouse.move(**place)
        due += PERIOD
        time.sleep(max(0.0, due - time.perf_counter()))
    settle(page)
    log = page.evaluate("probe")
    page.mouse.up()
    settle(page)
    moves, sent, answered = (np.array(log[name]) for name in ("moves", "sent", "answered"))
    # The first pixels of a drag only decide that it is not a click.
    moves = moves[moves >= sent[0] - 1]
    answering = answered[np.searchsorted(sent, moves)]
    return painted(log, answering) - moves, answered - sent


def _slide(page: Any, root: Any) -> Array:
    """Return the latencies of a slider that moves up and down."""
    _clear(page)
    inputs = np.array(page.evaluate(SLIDE, [root.element_handle(), MOVES]))
    settle(page)
    return painted(page.evaluate("probe"), inputs) - inputs


def painted(log: dict[str, Any], since: Array) -> Array:
    """Return the time at which the first change after each moment was painted."""
    changed, painted = np.array(log["paints"]).T
    return painted[np.searchsorted(changed, since)]


def _clear(page: Any) -> None:
    page.evaluate("() => { for (const name in probe) probe[name].length = 0 }")


def settle(page: Any) -> None:
    """Wait until every message is answered and the view has stopped moving."""
    page.wait_for_function(
        "() => { const s = document.querySelector('.vfwidget-editor').__vfw.stats;"
        " return s.answered + s.timedOut >= s.sent }"
    )
    page.wait_for_timeout(1000)


def notebook_of(text: vf.Text, arguments: str = "") -> Any:
    code = (
        "import vfwidget as vf\n"
        f"vf.Editor('recursive', {text.string!r}, axes={text.axes!r}, shared={text.shared},"
        f" {arguments})"
    )
    return nbformat.v4.new_notebook(
        cells=[nbformat.v4.new_code_cell(code)],
        metadata={"kernelspec": {"name": "python3", "display_name": "Python 3"}},
    )


def open_notebook(page: Any, url: str) -> Any:
    """Open a notebook, run all cells and return its editor."""
    page.goto(url)
    page.wait_for_selector(".jp-Notebook .jp-Cell", timeout=1e3 * PATIENCE)
    page.evaluate(
        """async () => {
          await jupyterapp.shell.currentWidget.context.sessionContext.ready;
          await jupyterapp.commands.execute('notebook:run-all-cells');
        }"""
    )
    root = page.locator(".vfwidget-editor").first
    root.wait_for(state="visible", timeout=1e3 * PATIENCE)
    root.scroll_into_view_if_needed()
    page.wait_for_timeout(1000)
    return root


@contextmanager
def browser_page(chromium: str) -> Iterator[Any]:
    """Yield a page of a headless browser."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        yield browser.new_page(viewport={"width": 1280, "height": 1000})
        browser.close()


@contextmanager
def jupyterlab() -> Iterator[tuple[str, Path]]:
    """Start a JupyterLab server and yield its address and its folder."""
    with ExitStack() as stack:
        folder, home = (
            stack.enter_context(tempfile.TemporaryDirectory(ignore_cleanup_errors=True))
            for _ in range(2)
        )
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            port = probe.getsockname()[1]
        server = subprocess.Popen(
            [
                *(sys.executable, "-m", "jupyterlab", "--no-browser", "--allow-root"),
                *("--ServerApp.ip=127.0.0.1", f"--ServerApp.port={port}"),
                *("--IdentityProvider.token=", f"--ServerApp.root_dir={folder}"),
                *("--LabApp.expose_app_in_browser=True", "--LabApp.news_url="),
            ],
            env={
                **os.environ,
                "JUPYTER_CONFIG_DIR": home,
                "IPYTHONDIR": home,
                "PYTHONPATH": str(Path(vf.__file__).parents[1]),
            },
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        try:
            address = f"http://127.0.0.1:{port}"
            _wait_for(f"{address}/api/status")
            yield address, Path(folder)
        finally:
            server.terminate()
            server.wait()


def _wait_for(url: str) -> None:
    end = time.monotonic() + PATIENCE
    while True:
        try:
            urllib.request.urlopen(url, timeout=2).close()
            return
        except OSError:
            if time.monotonic() > end:
                raise
            time.sleep(0.2)
