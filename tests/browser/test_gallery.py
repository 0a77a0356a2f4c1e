"""The gallery's pages in Chromium, from a file and without a network."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import nbformat
import pytest
from nbformat.v4 import new_code_cell, new_markdown_cell, new_notebook

ROOT = Path(__file__).parents[2]
GALLERY = ROOT / "docs" / "gallery.py"

pytestmark = [pytest.mark.browser, pytest.mark.slow, pytest.mark.timeout(240)]

CELLS = [
    new_markdown_cell("# A *small* one\n\nLetters $\\mathbf p < \\gamma_j$ move."),
    new_code_cell("import vfwidget as vf\neditor = vf.Editor('dynapuff', 'hi')\neditor"),
    new_code_cell("vf.Editor('dynapuff', 'ho', axes=[{'wght': 700}, {}], shared=False)"),
    new_code_cell(
        "import ipywidgets\n\n"
        "@ipywidgets.interact(size=(0, 10))\n"
        "def show(size=3):\n"
        "    print('size', size)"
    ),
    new_code_cell(
        "import io\n\nfrom PIL import Image\n\n"
        "Image.new('L', (40, 30)).save(file := io.BytesIO(), 'PNG')\n"
        "ipywidgets.VBox([ipywidgets.Label('<a label>'), ipywidgets.Image(value=file.getvalue())])"
    ),
    new_code_cell(
        "vf.Player(vf.Animation(vf.Text('dynapuff', 'ha'), [0, 9], [[[0, 0]], [[1, 0]]]))"
    ),
    new_code_cell("editor.axes = {'wght': 500}"),
    new_markdown_cell("On to [the next](next.ipynb)."),
]


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What the command writes for one notebook."""
    folder = tmp_path_factory.mktemp("gallery")
    notebook = new_notebook(
        cells=CELLS, metadata={"kernelspec": {"name": "python3", "display_name": "Python 3"}}
    )
    nbformat.write(notebook, folder / "small.ipynb")
    command = [sys.executable, str(GALLERY), str(folder / "site"), str(folder / "small.ipynb")]
    # The package is imported from wherever the tests found it.
    paths = os.pathsep.join(path for path in sys.path if path)
    subprocess.run(command, check=True, env=os.environ | {"PYTHONPATH": paths})
    return folder / "site"


@pytest.fixture
def page(browser: Any) -> Iterator[Any]:
    """A page without a network, on which nothing is asked for and nothing goes wrong."""
    context = browser.new_context(viewport={"width": 1000, "height": 900}, offline=True)
    opened = context.new_page()
    troubles: list[str] = []
    opened.on("console", lambda message: troubles.append(message.text))
    opened.on("pageerror", lambda error: troubles.append(str(error)))
    opened.on(
        "request", lambda request: request.is_navigation_request() or troubles.append(request.url)
    )
    yield opened
    context.close()
    assert troubles == []


def outline(editor: Any, letter: int = 0) -> str:
    return str(editor.locator(f"path.vfw-letter[data-letter='{letter}']").get_attribute("d"))


def raise_weight(editor: Any) -> None:
    slider = editor.locator("input[type=range][data-tag=wght]")
    slider.focus()
    slider.press("PageUp")
    editor.page.wait_for_timeout(100)


def test_sliders_move_the_letters(site: Path, page: Any) -> None:
    page.goto((site / "small.html").as_uri())
    editor = page.locator(".vfwidget-editor").first
    # The picture for saved notebooks has no place where the view is alive.
    assert page.locator(".vfw-snapshot").count() == 0
    # The last state of the notebook.
    assert editor.locator("input[type=number][data-tag=wght]").input_value() == "500"
    before = outline(editor)
    raise_weight(editor)
    moved = outline(editor)
    assert moved != before
    # The view's own memory is all there is, and it does not forget.
    page.wait_for_timeout(500)
    assert outline(editor) == moved
    editor.locator(".vfw-reset-all").click()
    page.wait_for_timeout(100)
    assert outline(editor) != moved


def test_letters_set_apart_move_by_themselves(site: Path, page: Any) -> None:
    page.goto((site / "small.html").as_uri())
    editor = page.locator(".vfwidget-editor").nth(1)
    first, second = outline(editor), outline(editor, 1)
    editor.locator(".vfw-chip").nth(1).click()
    raise_weight(editor)
    assert outline(editor) == first
    assert outline(editor, 1) != second


def test_the_outline_can_be_dragged_and_pinned(site: Path, page: Any) -> None:
    page.goto((site / "small.html").as_uri())
    editor = page.locator(".vfwidget-editor").first
    before = outline(editor)
    box = editor.locator("path.vfw-letter").first.bounding_box()
    page.mouse.move(box["x"], box["y"] + box["height"] / 2)
    page.mouse.down()
    page.mouse.move(box["x"] - 12, box["y"] + box["height"] / 2, steps=5)
    page.mouse.up()
    page.wait_for_timeout(600)
    assert outline(editor) != before
    status = editor.locator(".vfw-status").get_attribute("data-status")
    assert status in ("converged", "unreachable")
    handle = editor.locator("circle.vfw-handle").bounding_box()
    page.mouse.click(handle["x"] + handle["width"] / 2, handle["y"] + handle["height"] / 2)
    page.wait_for_timeout(100)
    assert editor.locator(".vfw-pin").count() == 1


def test_an_animation_plays(site: Path, page: Any) -> None:
    page.goto((site / "small.html").as_uri())
    player = page.locator(".vfwidget-player")
    first = player.locator("path.vfw-letter").first
    before = first.get_attribute("d")
    player.get_by_role("slider", name="Time").press("End")
    assert first.get_attribute("d") != before


def test_controls_of_a_kernel_are_placeholders_and_equations_are_set(site: Path, page: Any) -> None:
    page.goto((site / "small.html").as_uri())
    assert "needs a kernel" in page.locator(".control").first.inner_text()
    shown = page.locator("main").inner_text()
    # The slider, what it had printed, and a label's text.
    assert "size 3 needs a kernel" in shown and "\nsize 3\n" in shown and "<a label>" in shown
    assert page.locator("main img").evaluate("image => image.naturalWidth") == 40
    assert page.locator("math").count() == 1
    assert page.locator("math").bounding_box()["width"] > 20
    assert page.get_by_role("link", name="the next").get_attribute("href") == "next.html"


def test_the_index_leads_to_the_notebook(site: Path, page: Any) -> None:
    page.goto((site / "index.html").as_uri())
    page.get_by_role("link", name="A small one").click()
    assert page.locator("h1").inner_text().startswith("A small one")
    assert (site / "small.ipynb").exists()
