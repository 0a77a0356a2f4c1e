"""What a person does with an editor in a browser, and sees of it; the same in every host."""

from __future__ import annotations

from typing import Any

import vfwidget as vf


class Screen:
    """An editor on a page.

    Parameters
    ----------
    page : playwright Page
    root : playwright Locator
        The editor's element.
    """

    def __init__(self, page: Any, root: Any) -> None:
        self.page, self.root = page, root

    def client(self, point: list[float]) -> list[float]:
        """Font units to pixels on the page."""
        found = self.root.evaluate(
            "(root, p) => { const c = root.__vfw.toClient(...p); return [c.x, c.y] }", point
        )
        return list(found)

    def wait(self, milliseconds: int = 100) -> None:
        self.page.wait_for_timeout(milliseconds)

    def settle(self) -> None:
        """Wait until every drag message has been answered, and the answer drawn."""
        self.wait()
        self.root.evaluate(
            """root => new Promise(resolve => {
              const { stats } = root.__vfw;
              const look = () => stats.answered + stats.timedOut >= stats.sent
                ? setTimeout(resolve, 400) : setTimeout(look, 50);
              look();
            })"""
        )

    def press(self, point: list[float]) -> list[float]:
        """Press at a place in font units; where that is on the page."""
        x, y = self.client(point)
        self.page.mouse.move(x, y)
        self.page.mouse.down()
        return [x, y]

    def click(self, point: list[float]) -> None:
        """Click at a place in font units."""
        self.press(point)
        self.page.mouse.up()
        self.wait()

    def pull(self, point: list[float], by: tuple[float, float]) -> None:
        """Drag from a place in font units, by pixels, and let go."""
        x, y = self.press(point)
        self.page.mouse.move(x + by[0], y + by[1], steps=8)
        self.wait()
        self.page.mouse.up()
        self.settle()

    @property
    def axes(self) -> dict[str, float]:
        """What the sliders say."""
        inputs = self.root.locator("input[type=range]")
        pairs = inputs.evaluate_all("all => all.map(i => [i.dataset.tag, i.valueAsNumber])")
        return dict(pairs)

    @property
    def scale(self) -> float:
        """Pixels that a font unit takes."""
        return self.client([1, 0])[0] - self.client([0, 0])[0]


def tour(screen: Screen, text: vf.Text) -> None:
    """Drag, undo, redo, pin, constrain, zoom, and move a point by keys alone."""
    page, root = screen.page, screen.root
    handle = text.nearest(100, 700)
    top = text.position(handle).tolist()
    start = screen.axes
    assert start == text.axes

    screen.pull(top, (24, 0))
    dragged = screen.axes
    assert dragged != start
    root.locator("svg.vfw-svg").focus()
    page.keyboard.press("Control+z")
    screen.settle()
    assert screen.axes == start
    page.keyboard.press("Control+Shift+z")
    screen.settle()
    assert screen.axes == dragged
    root.locator(".vfw-undo").click()
    screen.settle()

    foot = text.position(text.nearest(60, 0)).tolist()
    screen.click(foot)
    assert root.locator(".vfw-pin").count() == 1
    screen.pull(top, (24, 0))
    mark = root.locator(".vfw-pin").bounding_box()
    x, y = screen.client(foot)
    assert abs(mark["x"] + mark["width"] / 2 - x) < 2
    assert abs(mark["y"] + mark["height"] / 2 - y) < 2

    now = text.at(axes=screen.axes)
    screen.click(now.position(now.nearest(550, 0)).tolist())
    root.locator(".vfw-add-constraint").select_option(label="Align horizontally")
    screen.settle()
    assert root.locator(".vfw-constraint").count() == 1
    assert root.locator(".vfw-pin").count() == 0
    root.locator(".vfw-constraint button").click()
    screen.settle()
    assert root.locator(".vfw-constraint").count() == 0

    scale = screen.scale
    root.locator("svg.vfw-svg").focus()
    page.keyboard.press("+")
    screen.wait(300)
    assert screen.scale > 1.1 * scale
    page.keyboard.press("0")
    screen.wait(600)
    assert abs(screen.scale / scale - 1) < 0.2

    before = screen.axes
    page.keyboard.press("PageDown")
    for _ in range(3):
        page.keyboard.press("Shift+ArrowRight")
    screen.settle()
    assert screen.axes != before
    page.keyboard.press("Enter")
    screen.wait()
    assert root.locator(".vfw-pin").count() == 1
    assert root.locator(".vfw-status[data-status=error]").count() == 0
