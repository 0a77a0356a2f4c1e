"""Draw the picture in the README: ``python docs/picture.py`` (requires Chromium).

The script uses the fixtures of the browser tests to drag a point in a real JupyterLab.
"""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PICTURE = ROOT / "docs" / "drag-a-letter.png"
CELL = """import vfwidget as vf

editor = vf.Editor("recursive", "hand", axes={"wght": 560, "CASL": 0.4})
editor.pins = [editor.text.nearest(1250, 250)]
editor"""


def test_picture(lab) -> None:
    """Drag the top of the h to the right and take a screenshot of the editor."""
    import vfwidget as vf

    notebook = lab([CELL])
    page, editor = notebook.page, notebook.editors.first
    page.wait_for_timeout(1500)
    text = vf.Text("recursive", "hand", axes={"wght": 560, "CASL": 0.4})
    x, y = text.position(text.nearest(100, 700)).tolist()
    where = "(root, p) => { const c = root.__vfw.toClient(...p); return [c.x, c.y] }"
    left, top = editor.evaluate(where, [x, y])
    page.mouse.move(left, top)
    page.mouse.down()
    left, top = editor.evaluate(where, [x + 80, y])
    page.mouse.move(left, top, steps=20)
    page.wait_for_timeout(500)
    editor.screenshot(path=PICTURE)
    page.mouse.up()


if __name__ == "__main__":
    sys.path.insert(0, str(ROOT / "tests" / "browser"))
    sys.exit(pytest.main(["-q", "-c", str(ROOT / "pyproject.toml"), "-p", "conftest", __file__]))
