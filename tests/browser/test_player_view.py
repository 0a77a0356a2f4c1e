"""The player in Chromium: as a page without a network, and in JupyterLab."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import vfwidget as vf
from tests.motion.films import film

pytestmark = [pytest.mark.browser, pytest.mark.timeout(180)]

AXE = Path(__file__).parents[2] / "js" / "node_modules" / "axe-core" / "axe.min.js"
CORNERS = """root => [...root.querySelectorAll('path.vfw-letter')].map(path => {
  const { matrix } = path.parentNode.transform.baseVal.consolidate();
  const point = path.getPointAtLength(0).matrixTransform(matrix);
  return [point.x, -point.y];
})"""
"""Where the first contour of each letter starts, in font units."""


@pytest.fixture
def show(offline_page: Any, tmp_path: Path) -> Callable[..., Any]:
    """Open a player as a page."""

    def open_page(player: vf.Player, width: int = 900, **options: Any) -> Any:
        player.to_html(tmp_path / "page.html")
        page = offline_page(tmp_path / "page.html", width, 700, **options)
        return page.locator(".vfwidget-player")

    return open_page


def state(root: Any) -> dict[str, Any]:
    found: dict[str, Any] = root.evaluate("root => root.__vfw.state()")
    return found


def test_every_frame_is_drawn_where_it_is(show: Any) -> None:
    animation = film()
    root = show(vf.Player(animation))
    for number in (0, 7, 14, 16, 30):
        root.evaluate(
            "(root, time) => root.__vfw.seek(time)", animation.times[number] - animation.times[0]
        )
        frame = animation[number]
        first = [word[0] for word in np.split(frame.points().numpy(), frame.word.first_point[1:-1])]
        assert root.evaluate(CORNERS) == pytest.approx(np.array(first), abs=0.2)
    assert root.locator("path.vfw-obstacle").get_attribute("d")


def test_it_plays_to_the_end(show: Any) -> None:
    root = show(vf.Player(film("dynapuff", "hi", frames=16), loop=False, speed=4))
    assert state(root) == {"time": 0, "playing": False}
    root.get_by_role("button", name="Play").click()
    root.page.wait_for_function(
        "() => document.querySelector('.vfwidget-player').__vfw.state().time === 1.5"
    )
    root.get_by_role("button", name="Play").wait_for()
    assert state(root) == {"time": 1.5, "playing": False}


def test_keys_move_and_play_it(show: Any) -> None:
    # An animation in a loop does not stop by itself between two keys.
    root = show(vf.Player(film("dynapuff", "hi", frames=16), loop=True))
    slider = root.get_by_role("slider", name="Time")
    slider.press("Home")
    slider.press("ArrowRight")
    slider.press("ArrowRight")
    assert state(root)["time"] == pytest.approx(0.2)
    slider.press("ArrowLeft")
    assert state(root)["time"] == pytest.approx(0.1)
    slider.press(" ")
    assert state(root)["playing"]
    slider.press(" ")
    assert not state(root)["playing"]
    root.get_by_label("Onion skin").select_option("3")
    slider.press("End")
    assert root.locator(".vfw-ghosts > g").count() == 3
    box = root.locator(".vfw-chart").bounding_box()
    root.page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    assert state(root)["time"] == pytest.approx(0.75, abs=0.01)


def test_it_starts_by_itself_except_where_less_motion_is_preferred(show: Any) -> None:
    player = vf.Player(film("dynapuff", "hi", frames=7), playing=True)
    assert state(show(player))["playing"]
    root = show(player, reduced_motion="reduce")
    assert not state(root)["playing"]
    root.get_by_role("button", name="Play").click()
    assert state(root)["playing"]


@pytest.mark.parametrize(("theme", "width"), [("light", 900), ("dark", 360)])
def test_it_is_accessible(show: Any, theme: str, width: int) -> None:
    root = show(vf.Player(film("dynapuff", "hi", frames=7), theme=theme, onion=1), width=width)
    root.page.evaluate(AXE.read_text(encoding="utf-8"))
    found = root.page.evaluate("() => axe.run('.vfwidget-player').then(r => r.violations)")
    assert [(v["id"], [n["html"] for n in v["nodes"]]) for v in found] == []
    assert root.page.evaluate("() => document.documentElement.scrollWidth") <= width


@pytest.mark.slow
def test_it_plays_in_jupyterlab_and_leaves_a_poster(lab: Any) -> None:
    cells = [
        "import numpy as np, vfwidget as vf\n"
        "text = vf.Text('dynapuff', 'hi')\n"
        "theta = np.linspace(0, 1, 61)[:, None, None] * np.array([[1.0, 0.0]])\n"
        "player = vf.Player(vf.Animation(text, np.linspace(0, 60, 61), theta))\n"
        "player",
        "print(player.playing, 0 < player.time < 60)",
    ]
    notebook = lab(cells, widget=".vfwidget-player")
    page, root = notebook.page, notebook.editors
    assert not page.locator(".vfw-snapshot").is_visible()
    before = root.locator("path.vfw-letter").first.get_attribute("d")
    root.get_by_role("button", name="Play").click()
    page.wait_for_function(
        "d => document.querySelector('.vfwidget-player path.vfw-letter').getAttribute('d') !== d",
        arg=before,
    )
    root.get_by_role("button", name="Pause").click()
    # The kernel takes changes of a widget in a thread of their own, next to the cells.
    for _ in range(20):
        paused = notebook.run_last_cell()
        if paused == "False True\n":
            break
        page.wait_for_timeout(200)
    assert paused == "False True\n"
    assert notebook.errors() == []
