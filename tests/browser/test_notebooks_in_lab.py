"""Notebooks in a real JupyterLab: their sliders move letters and redraw figures."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

pytestmark = [pytest.mark.browser, pytest.mark.slow, pytest.mark.timeout(240)]

NOTEBOOKS = Path(__file__).parents[2] / "notebooks"
MILLISECONDS = 30_000


class Drawing:
    """Something drawn, of which an attribute tells one drawing from the next."""

    def __init__(self, page: Any, selector: str, attribute: str) -> None:
        self.page = page
        self.place = [selector, attribute]
        self.shown = page.locator(selector).get_attribute(attribute)

    def changes(self) -> None:
        """Wait until it is another than it was the last time."""
        self.page.wait_for_function(
            """([selector, attribute, before]) => {
              const now = document.querySelector(selector)?.getAttribute(attribute);
              return now && now !== before;
            }""",
            arg=[*self.place, self.shown],
            timeout=MILLISECONDS,
        )
        selector, attribute = self.place
        self.shown = self.page.locator(selector).get_attribute(attribute)


def drag(handle: Any, dx: float) -> None:
    """Take hold of the middle of something, move by dx pixels, and let go."""
    handle.hover()
    box, mouse = handle.bounding_box(), handle.page.mouse
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    mouse.down()
    mouse.move(x + dx, y, steps=5)
    mouse.up()


def test_the_editor_of_notebook_03_moves_the_letter_and_its_picture(lab: Any) -> None:
    notebook = lab(NOTEBOOKS / "03-support-functions-and-delta-sets.ipynb")
    letter = Drawing(notebook.page, ".vfwidget-editor path.vfw-letter", "d")
    picture = Drawing(notebook.page, "img.widget-image", "src")

    notebook.editors.locator("input[type=range][data-tag=slnt]").press("PageUp")
    letter.changes()
    picture.changes()

    weight = notebook.editors.locator("input[type=range][data-tag=wght]")
    drag(weight, -40)  # the slider goes to where it is pressed, and on
    assert float(weight.input_value()) < 800
    letter.changes()
    picture.changes()

    image = notebook.page.locator(picture.place[0])
    assert image.evaluate("image => image.decode().then(() => image.naturalWidth)") > 400
    assert notebook.errors() == []


def test_the_sliders_of_notebook_04_redraw_its_figure(lab: Any) -> None:
    notebook = lab(NOTEBOOKS / "04-from-delta-sets-to-outlines.ipynb")
    figure = Drawing(notebook.page, ".widget-output img", "src")
    letter = Drawing(notebook.page, ".vfwidget-editor path[data-letter='0']", "d")
    weight, width = notebook.page.locator(".widget-slider .noUi-handle").all()

    width.press("ArrowLeft")
    figure.changes()

    drag(weight, -40)
    figure.changes()
    assert float(weight.get_attribute("aria-valuenow")) < 0.8

    notebook.editors.locator("input[type=range][data-tag=wght]").press("PageDown")
    letter.changes()
    assert notebook.errors() == []
