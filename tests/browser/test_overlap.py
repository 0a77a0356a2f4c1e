"""Dragging with overlaps avoided, in a real JupyterLab: obstacles, contacts, and the switch."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from test_editor import Screen

pytestmark = [pytest.mark.browser, pytest.mark.timeout(240)]

SHOW = """
import vfwidget as vf
word = vf.Text('roboto-flex', 'lo', shared=False)
right = float(word.segments()[0][..., 0].max())
bar = [(right + 60, 100), (right + 70, 100), (right + 70, 900), (right + 60, 900)]
editor = vf.Editor(word, obstacles=[bar], avoid_overlaps=True)
editor
"""
REPORT = """
import json
import re
print(json.dumps({"overlaps": len(vf.overlaps(editor.text, [bar])), "right": right,
                  "now": float(editor.text.segments()[0][..., 0].max()), "axes": editor.axes,
                  "avoid": editor.avoid_overlaps}))
"""
TOPS = """
tops = [editor.text.position(editor.text.nearest(x, 1600)).tolist() for x in (200, 1100)]
print(json.dumps(tops))
"""


@pytest.mark.slow
def test_a_thin_bar_stops_a_drag(lab: Callable[..., Any], tmp_path: Path) -> None:
    notebook = lab([SHOW, REPORT])
    screen = Screen(notebook)
    start = json.loads(notebook.output(1))
    assert start["overlaps"] == 0 and start["avoid"]
    edge = [start["right"], 500]
    page, root = screen.page, screen.root
    obstacle = root.locator(".vfw-obstacles")
    assert "M" in obstacle.get_attribute("d")
    page.mouse.move(*screen.client(edge))
    page.mouse.down()
    # One event jumps over the bar, which is 10 units wide.
    page.mouse.move(*screen.client([edge[0] + 260, 500]), steps=2)
    page.wait_for_function(
        "root => root.querySelector('.vfw-contacts').getAttribute('d').includes('M')",
        arg=root.element_handle(),
    )
    page.screenshot(path=str(tmp_path / "contact.png"))
    page.mouse.up()
    screen.settle()
    assert root.locator(".vfw-contacts").get_attribute("d") == ""
    end = json.loads(notebook.run_last_cell())
    assert end["overlaps"] == 0
    # The stem has reached the bar, and is not behind it.
    assert start["right"] + 40 < end["now"] <= start["right"] + 60.1
    assert notebook.errors() == []


def test_the_switch_lets_letters_make_room(lab: Callable[..., Any]) -> None:
    notebook = lab([SHOW.replace(", avoid_overlaps=True", ""), REPORT])
    screen = Screen(notebook)
    edge = json.loads(notebook.output(1))["right"]
    screen.drag([edge, 500], [edge + 200, 500])
    assert json.loads(notebook.run_last_cell())["overlaps"] == 1
    switch = screen.root.get_by_label("Avoid overlaps")
    switch.check()
    for _ in range(40):
        screen.page.wait_for_timeout(500)
        end = json.loads(notebook.run_last_cell())
        if end["overlaps"] == 0:
            break
    assert end["avoid"] and end["overlaps"] == 0
    screen.page.wait_for_timeout(1000)
    # The view shows the axes to which the letters have moved.
    shown = screen.root.locator(".vfw-letter").first.evaluate("path => path.getBBox().width")
    assert shown < end["right"] + 61


def test_the_status_is_that_of_the_present_drag(lab: Callable[..., Any]) -> None:
    notebook = lab([SHOW, REPORT + TOPS])
    screen = Screen(notebook)
    status = screen.root.locator(".vfw-status")
    tops = json.loads(notebook.output(1).splitlines()[1])
    for at, name in zip(tops, "lo", strict=True):
        screen.page.mouse.move(*screen.client(at))
        screen.page.mouse.down()
        said = []
        for up in (2000, 2400, 2800):
            screen.page.mouse.move(*screen.client([at[0], at[1] + up]))
            screen.settle()
            said += re.findall(f"Target {name} is missed by ([0-9.]+)", status.inner_text())
        screen.page.mouse.up()
        screen.settle()
        missed = [float(distance) for distance in said]
        assert np.diff(missed) == pytest.approx([400, 400], abs=60)
