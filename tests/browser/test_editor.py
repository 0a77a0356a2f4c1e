"""The editor in real JupyterLab: drags, pins, sliders, errors, a slow kernel."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

pytestmark = [pytest.mark.browser, pytest.mark.timeout(240)]

NOTEBOOKS = Path(__file__).parents[2] / "notebooks"
REPORT = "import json; print(json.dumps({'axes': editor.axes, 'pins': len(editor.pins)}))"


def test_first_light(lab: Any) -> None:
    notebook = lab(NOTEBOOKS / "01-drag-a-letter.ipynb", editors=2)
    notebook.page.wait_for_timeout(3000)
    notebook.page.screenshot(path="/tmp/first.png")
    print(notebook.errors())
