"""How smoothly a drag is drawn: frames, a busy kernel, the kernel's last word, and memory.

*busy*: the time from a pointer move to the next painted change, in JupyterLab, while the kernel is
busy for 2 s in the middle of the drag. A cell that sleeps would not do, because JupyterLab sends
the messages of widgets to another thread, which answers them while the cell sleeps. The cell calls
a C function that keeps the interpreter's lock. The notes give the longest time without an answer.
The baseline is an SVG on the same page in which each move sets one path: the time that the browser
takes without an editor. *rest*: how far the kernel's answer to the release moves any point from
where the view had drawn it, in pixels. *frames*: frames per second while the pointer moves in
every frame, on an exported page. *memory*: the heap after 10,000 moves compared with that after
2,000, each after a garbage collection.
"""

from __future__ import annotations

import re
import shutil
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import nbformat
import numpy as np

import vfwidget as vf

from .latency import PROBE, browser_page, jupyterlab, notebook_of, open_notebook, painted, settle
from .table import Row, milliseconds
from .timing import Array

PERIOD = 1 / 60
BUSY = 2.0
KEEP_BUSY = f"import ctypes; ctypes.PyDLL(None).usleep({BUSY * 1e6:.0f})"
"""A call by PyDLL keeps the interpreter's lock, so no thread of the kernel runs."""
MOVES, MORE = 2_000, 8_000
WORDS = {8: "variable", 40: "handgloves handgloves handgloves handglo"}

CIRCLE = """async ([root, place, moves, every]) => {
  const svg = root.querySelector('svg.vfw-svg');
  const at = i => ({
    clientX: place.x + 30 * Math.sin(i / 20), clientY: place.y + 8 * Math.sin(i / 13),
    pointerId: 1, isPrimary: true, buttons: 1, button: 0, bubbles: true,
  });
  svg.dispatchEvent(new PointerEvent('pointerdown', at(0)));
  const began = performance.now();
  for (let i = 1; i <= moves; i++) {
    svg.dispatchEvent(new PointerEvent('pointermove', at(i)));
    if (i % every === 0) await new Promise(requestAnimationFrame);
  }
  const seconds = (performance.now() - began) / 1000;
  svg.dispatchEvent(new PointerEvent('pointerup', at(moves)));
  return moves / every / seconds;
}"""
"""Presses, moves along a closed curve, releases; gives frames per second."""


BARE = """root => {
  root.insertAdjacentHTML('beforebegin', '<svg id="bare" width="300" height="100"><path/></svg>');
  const bare = document.getElementById('bare'), path = bare.firstChild;
  bare.__vfw = {stats: {}};
  bare.onpointermove = e => path.setAttribute('d', `M0 0L${e.offsetX} ${e.offsetY}V100Z`);
}"""
"""Puts the baseline of the latency before an editor."""


def run(quick: bool) -> Iterator[Row]:
    """Measure frames and memory on pages, then a drag with a kernel."""
    chromium = shutil.which("chromium")
    if chromium is None:
        yield Row("smooth", "skipped: requires Chromium", "", "", "")
        return
    with browser_page(chromium) as page, tempfile.TemporaryDirectory() as folder:
        for letters, string in WORDS.items():
            root, place = _page(page, Path(folder), string)
            page.evaluate(CIRCLE, [root, place, 30, 1])
            frames = page.evaluate(CIRCLE, [root, place, 60 if quick else 240, 1])
            yield Row("smooth", f"{letters} letters", f"{frames:.1f} frames/s", "of 60", "")
        root, place = _page(page, Path(folder), WORDS[8])
        sizes = []
        for moves in (MOVES, MORE // 8 if quick else MORE):
            page.evaluate(CIRCLE, [root, place, moves, 20])
            sizes.append(_heap(page) / 2**20)
        ours, before = (f"{size:.2f} MiB" for size in sizes[::-1])
        yield Row("smooth", "memory", ours, before, f"{sizes[1] / sizes[0]:.2f}×")
    with jupyterlab() as (address, folder_of_lab), browser_page(chromium) as page:
        yield from _with_kernel(page, address, folder_of_lab)


def _page(page: Any, folder: Path, string: str) -> tuple[Any, dict[str, float]]:
    """An exported editor, and where on the page its last letter can be dragged."""
    text = vf.Text("recursive", string, axes={"wght": 500})
    vf.Editor(text).to_html(folder / "page.html")
    page.goto((folder / "page.html").as_uri())
    return _grip(page, text)


def _grip(page: Any, text: vf.Text) -> tuple[Any, dict[str, float]]:
    root = page.locator(".vfwidget-editor").first
    x, y = text.position(text.handle(len(text.glyphs) - 1, 0, 1, 0.5)).tolist()
    place = root.evaluate("(root, p) => root.__vfw.toClient(...p)", [x, y])
    page.mouse.move(place["x"], place["y"])
    return root.element_handle(), place


def _heap(page: Any) -> float:
    """Bytes of the heap after a garbage collection."""
    session = page.context.new_cdp_session(page)
    session.send("HeapProfiler.collectGarbage")
    return float(session.send("Runtime.getHeapUsage")["usedSize"])


def _with_kernel(page: Any, address: str, folder: Path) -> Iterator[Row]:
    text = vf.Text("recursive", WORDS[8], axes={"wght": 500})
    notebook = notebook_of(text)
    notebook.cells.append(nbformat.v4.new_code_cell(KEEP_BUSY))
    nbformat.write(notebook, folder / "busy.ipynb")
    root = open_notebook(page, f"{address}/lab/tree/busy.ipynb?reset")
    page.wait_for_timeout(1000 * BUSY)
    root.evaluate(PROBE)
    _, place = _grip(page, text)
    half, most = _latency(page, place)
    gap = np.diff(page.evaluate("probe.answered")).max() / 1000
    settle(page)
    page.mouse.up()
    page.wait_for_timeout(20)
    before = _outlines(root)
    settle(page)
    unit = root.evaluate("root => root.__vfw.toClient(1, 0).x - root.__vfw.toClient(0, 0).x")
    moved = float(np.abs(_outlines(root) - before).max()) * unit
    root.evaluate(BARE)
    bare = page.locator("#bare")
    bare.evaluate(PROBE)
    box = bare.bounding_box()
    place = {"x": box["x"] + box["width"] / 2, "y": box["y"] + box["height"] / 2}
    page.mouse.move(**place)
    bare_half, bare_most = _latency(page, place)
    page.mouse.up()
    yield Row(
        "smooth",
        f"kernel busy for {BUSY:g} s",
        milliseconds(half),
        f"one path {milliseconds(bare_half)}",
        f"{half / bare_half:.1f}×",
        f"95 %: {most:.1f} | {bare_most:.1f} ms, {gap:.1f} s without an answer",
    )
    yield Row("smooth", "the kernel's answer at rest", f"{moved:.2f} px", "", "")


def _latency(page: Any, place: dict[str, float]) -> Array:
    """Press and move while the kernel is busy; the median and 95 % of move to paint, in ms."""
    page.mouse.down()
    due = time.perf_counter()
    for i in range(1, 241):
        if i == 60:
            # The last cell keeps the kernel busy.
            page.evaluate(
                """() => { const { content } = jupyterapp.shell.currentWidget;
                           content.activeCellIndex = content.widgets.length - 1;
                           jupyterapp.commands.execute('notebook:run-cell'); }"""
            )
        page.mouse.move(place["x"] + 25 * np.sin(i / 20), place["y"] + 6 * np.sin(i / 13))
        due += PERIOD
        time.sleep(max(0.0, due - time.perf_counter()))
    log = page.evaluate("probe")
    moves = np.array(log["moves"][2:-1])
    return np.percentile(painted(log, moves) - moves, [50, 95])


def _outlines(root: Any) -> Any:
    """The numbers of all outlines and of their origins."""
    texts = root.locator("path.vfw-letter").evaluate_all(
        "paths => paths.flatMap(p => [p.getAttribute('d'), p.getAttribute('transform')])"
    )
    return np.array([float(n) for text in texts for n in re.findall(r"-?[\d.]+", text)])
