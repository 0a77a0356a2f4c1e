"""An exported page in Chromium, without a kernel and without a network."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from fontTools.pens.areaPen import AreaPen
from fontTools.svgLib.path import parse_path
from PIL import Image

import vfwidget as vf
from tests.browser.screen import Screen
from vfwidget.outline.cubics import AREA

pytestmark = [pytest.mark.browser, pytest.mark.timeout(120)]

AXE = Path(__file__).parents[2] / "js" / "node_modules" / "axe-core" / "axe.min.js"


class Page(Screen):
    """An editor on an exported page."""

    def __init__(self, page: Any, editor: vf.Editor) -> None:
        super().__init__(page, page.locator(".vfwidget-editor"))
        self.text = editor.text

    def drag(self, start: list[float], by: tuple[float, float], *, up: bool = True) -> None:
        """Drag from a place in font units, by pixels."""
        x, y = self.client(start)
        self.page.mouse.move(x, y)
        self.page.mouse.down()
        self.page.mouse.move(x + by[0], y + by[1], steps=8)
        self.wait()
        if up:
            self.page.mouse.up()
            self.wait(600)

    def letters(self) -> list[dict[str, float]]:
        """The axes of every letter, which is selected to see them."""
        chips, found = self.root.locator(".vfw-chip"), []
        for i in range(chips.count()):
            chips.nth(i).click()
            # The chips and the sliders are drawn in the same frame.
            self.page.wait_for_function(
                "i => [...document.querySelectorAll('.vfw-chip')]"
                ".every((c, k) => c.ariaPressed === String(k === i))",
                arg=i,
            )
            found.append(self.axes)
        return found

    def middle(self, selector: str) -> list[float]:
        box = self.root.locator(selector).first.bounding_box()
        return [box["x"] + box["width"] / 2, box["y"] + box["height"] / 2]


@pytest.fixture
def show(offline_page: Any, tmp_path: Path) -> Callable[..., Page]:
    """Open an editor as a page."""

    def open_page(editor: vf.Editor, width: int = 900, **options: Any) -> Page:
        editor.to_html(tmp_path / "page.html")
        return Page(offline_page(tmp_path / "page.html", width, 800, **options), editor)

    return open_page


def hand(**options: Any) -> vf.Editor:
    return vf.Editor("recursive", "hand", axes={"wght": 600, "CASL": 0.5}, **options)


def shoulder(page: Page) -> list[float]:
    text = page.text
    return [float(v) for v in text.position(text.nearest(100, 700))]


def test_a_drag_ends_where_python_solves_it(show: Any) -> None:
    page = show(hand())
    start = shoulder(page)
    page.drag(start, (30, 0))
    pixel = page.client([1, 0])[0] - page.client([0, 0])[0]
    text = page.text
    handle = text.nearest(100, 700)
    # The view may have moved since, so the goal is computed from where the handle was drawn.
    reached = text.at(axes=page.axes).position(handle).tolist()
    goal = [start[0] + 30 / pixel, start[1]]
    assert reached == pytest.approx(goal, abs=2 / pixel)
    once = vf.solve(text, [vf.Target(handle, reached), vf.StayClose(1.0)], restarts=0).axes
    for axis in text.font.axes:
        assert abs(page.axes[axis.tag] - once[axis.tag]) < 0.01 * (axis.maximum - axis.minimum)


def test_undo_and_redo_take_one_step_for_each_gesture(show: Any) -> None:
    page = show(hand())
    start = page.axes
    page.drag(shoulder(page), (30, 0))
    dragged = page.axes
    slider = page.root.locator("input[type=range][data-tag=wght]")
    slider.focus()
    for _ in range(4):
        slider.press("ArrowRight")
    page.wait()
    moved = page.axes
    assert len({tuple(axes.values()) for axes in (start, dragged, moved)}) == 3
    page.page.keyboard.press("Control+z")
    page.wait()
    assert page.axes == dragged
    page.root.locator(".vfw-undo").click()
    page.wait()
    assert page.axes == start
    assert page.root.locator(".vfw-undo").is_disabled()
    page.page.keyboard.press("Control+Shift+Z")
    page.root.locator(".vfw-redo").click()
    page.wait()
    assert page.axes == moved
    page.root.locator(".vfw-restart").click()
    page.wait()
    assert page.axes == start
    page.root.locator(".vfw-undo").click()
    page.wait()
    assert page.axes == moved


def test_escape_takes_a_drag_back_and_leaves_no_step(show: Any) -> None:
    page = show(hand())
    start = page.axes
    page.drag(shoulder(page), (30, 0), up=False)
    assert page.axes != start
    page.page.keyboard.press("Escape")
    page.page.mouse.up()
    page.wait(400)
    assert page.axes == start
    assert page.root.locator(".vfw-undo").is_disabled()


def test_locked_axes_stay_in_a_drag(show: Any) -> None:
    page = show(hand(locks=["CASL"]))
    page.root.locator("[data-lock=wght]").click()
    start = page.axes
    page.drag(shoulder(page), (30, -4))
    found = page.axes
    assert found != start
    assert (found["wght"], found["CASL"]) == (start["wght"], start["CASL"])
    assert page.root.locator("[data-lock=CASL]").get_attribute("aria-pressed") == "true"


def test_shift_drags_slowly(show: Any) -> None:
    page = show(hand())
    start = shoulder(page)
    page.page.keyboard.down("Shift")
    x, y = page.client(start)
    page.drag(start, (50, 0), up=False)
    page.page.keyboard.up("Shift")
    handle = page.middle(".vfw-handle")
    assert handle == pytest.approx([x + 10, y], abs=1.5)


def test_zoom_keeps_what_is_under_the_pointer_and_fit_brings_the_word_back(show: Any) -> None:
    page = show(hand())
    place = shoulder(page)
    x, y = page.client(place)
    page.page.mouse.move(x, y)
    page.page.keyboard.down("Control")
    page.page.mouse.wheel(0, -120)
    page.page.keyboard.up("Control")
    page.wait(700)
    scale = page.client([1, 0])[0] - page.client([0, 0])[0]
    assert page.client(place) == pytest.approx([x, y], abs=0.5)
    page.root.locator(".vfw-fit").click()
    page.wait(500)
    assert page.client([1, 0])[0] - page.client([0, 0])[0] < scale
    # A wheel without Ctrl scrolls the page and leaves the picture alone.
    before = page.client(place)
    page.page.mouse.wheel(0, 40)
    page.wait()
    scrolled = page.page.evaluate("() => scrollY")
    assert page.client(place) == pytest.approx([before[0], before[1] - scrolled], abs=0.5)


def test_empty_picture_is_panned_and_the_word_is_not_changed(show: Any) -> None:
    page = show(hand())
    box = page.root.locator(".vfw-svg").bounding_box()
    start, before = page.axes, page.client([0, 0])
    page.page.mouse.move(box["x"] + 30, box["y"] + box["height"] - 20)
    page.page.mouse.down()
    page.page.mouse.move(box["x"] + 90, box["y"] + box["height"] - 50, steps=5)
    page.page.mouse.up()
    page.wait(700)
    assert page.client([0, 0]) == pytest.approx([before[0] + 60, before[1] - 30], abs=0.5)
    assert page.axes == start


def test_a_word_that_grows_stays_in_the_picture_and_the_held_point_at_the_pointer(
    show: Any,
) -> None:
    page = show(vf.Editor("roboto-flex", "mmmmm"))
    text = page.text
    start = [float(v) for v in text.position(text.nearest(5500, 500))]
    x, y = page.client(start)
    page.drag(start, (250, 0), up=False)
    last = page.root.locator("path.vfw-letter").last.bounding_box()
    box = page.root.locator(".vfw-svg").bounding_box()
    assert last["x"] + last["width"] <= box["x"] + box["width"] + 1
    if page.root.locator(".vfw-status").get_attribute("data-status") == "converged":
        assert page.middle(".vfw-handle") == pytest.approx([x + 250, y], abs=1.5)


def test_the_keyboard_does_everything(show: Any) -> None:
    page = show(hand())
    keys = page.page.keyboard
    page.root.locator(".vfw-svg").focus()
    start = page.axes
    keys.press("PageDown")
    for _ in range(5):
        keys.press("Shift+ArrowUp")
    page.wait(500)
    assert page.axes != start
    keys.press("Enter")
    page.wait()
    assert page.root.locator(".vfw-pin").count() == 1
    keys.press("+")
    keys.press("0")
    keys.press("Control+z")
    page.wait()
    assert page.root.locator(".vfw-pin").count() == 0
    keys.press("Control+z")
    page.wait()
    assert page.axes == start


def test_the_status_line_keeps_its_height(show: Any) -> None:
    page = show(vf.Editor("roboto-flex", "no"), width=420)
    line = page.root.locator(".vfw-status")
    before = line.bounding_box()["height"]
    text = page.text
    page.drag([float(v) for v in text.position(text.nearest(1500, 1080))], (-30, -200), up=False)
    assert "cannot reach" in line.inner_text()
    assert line.bounding_box()["height"] == before


def test_a_swipe_scrolls_the_page_and_a_touch_of_the_outline_drags(show: Any) -> None:
    page = show(hand(), width=400, has_touch=True, is_mobile=True)
    session = page.page.context.new_cdp_session(page.page)

    def swipe(x: float, y: float, dx: float, dy: float) -> None:
        def send(kind: str, points: list[Any]) -> None:
            session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

        send("touchStart", [{"x": x, "y": y}])
        for i in range(1, 9):
            send("touchMove", [{"x": x + dx * i / 8, "y": y + dy * i / 8}])
            page.wait(20)
        send("touchEnd", [])
        page.wait(600)

    page.page.evaluate("() => document.body.style.paddingBottom = '1500px'")
    box = page.root.locator(".vfw-svg").bounding_box()
    start = page.axes
    swipe(box["x"] + 8, box["y"] + box["height"] - 6, 0, -120)
    assert page.page.evaluate("() => scrollY") > 40
    assert page.axes == start
    page.page.evaluate("() => scrollTo(0, 0)")
    page.wait(300)
    x, y = page.client(shoulder(page))
    swipe(x, y, 14, 0)
    assert page.page.evaluate("() => scrollY") == 0
    assert page.axes != start


@pytest.mark.parametrize("width", [400, 900])
@pytest.mark.parametrize("theme", ["light", "dark"])
def test_axe_finds_no_violation(show: Any, theme: str, width: int) -> None:
    page = show(hand(theme=theme, height=200, locks=["wght"], teaching=True), width=width)
    page.drag(shoulder(page), (30, 0))
    page.page.evaluate(AXE.read_text(encoding="utf-8"))
    found = page.page.evaluate("() => axe.run('.vfwidget-editor').then(r => r.violations)")
    assert [(v["id"], [n["html"] for n in v["nodes"]]) for v in found] == []
    assert page.page.evaluate("() => document.documentElement.scrollWidth") <= width


def test_less_motion_is_no_motion(show: Any) -> None:
    page = show(hand(), reduced_motion="reduce")
    page.root.locator(".vfw-closer").click()
    before = page.client([0, 0])
    page.root.locator(".vfw-fit").click()
    assert page.client([0, 0]) != before
    landed = page.client([0, 0])
    page.wait(300)
    assert page.client([0, 0]) == landed


def test_pins_become_a_constraint_that_drags_keep_and_that_can_be_removed(show: Any) -> None:
    editor = vf.Editor("roboto-flex", "no")
    text = editor.text
    editor.pins = [text.nearest(150, 500), text.nearest(330, 500)]
    page = show(editor)
    menu = page.root.locator(".vfw-add-constraint")
    assert menu.locator("option[value=Collinear]").is_disabled()
    menu.select_option("Distance")
    page.wait()
    chip = page.root.locator(".vfw-constraint")
    assert "Keep the distance: n, n" in chip.inner_text()
    assert page.root.locator(".vfw-pin").count() == 0

    def width() -> float:
        moved = text.at(axes=page.axes)
        first, second = (moved.position(pin) for pin in editor.pins)
        return float((second - first).norm())

    before, start = width(), page.axes
    page.drag([float(v) for v in text.position(text.nearest(1500, 1080))], (12, -10))
    assert page.axes != start
    assert width() == pytest.approx(before, abs=0.5)
    chip.locator("input").fill(str(before + 60))
    chip.locator("input").press("Enter")
    page.wait(200)
    assert width() == pytest.approx(before + 60, abs=0.5)
    chip.locator("button").click()
    page.wait()
    assert chip.count() == 0
    page.page.keyboard.press("Control+z")
    page.root.locator(".vfw-undo").click()
    page.wait()
    assert chip.count() == 1


def test_the_word_is_saved_as_svg_and_png_and_copied_as_css(show: Any) -> None:
    page = show(hand())
    menu = page.root.locator(".vfw-save")
    with page.page.expect_download() as saved:
        menu.select_option("Save SVG")
    root = ET.parse(saved.value.path()).getroot()
    # An area in font units, from a file that knows nothing of the view.
    area = 0.0
    for path in root.iter("{http://www.w3.org/2000/svg}path"):
        pen = AreaPen()
        parse_path(path.get("d"), pen)
        area += pen.value
    outlines = page.text.points().numpy()[page.text.word.contours.segments]
    x, y = outlines[..., 0], outlines[..., 1]
    assert abs(area) == pytest.approx(abs((x * (y @ AREA.T)).sum()), rel=1e-3)
    with page.page.expect_download() as saved:
        menu.select_option("Save PNG")
    with Image.open(saved.value.path()) as image:
        assert image.height == 1000
        assert image.getchannel("A").getextrema() == (0, 255)
    menu.select_option("Copy CSS")
    page.wait(200)
    assert "Copied" in page.root.locator(".vfw-status").inner_text()


def test_what_a_point_can_reach_is_shown_on_request(show: Any) -> None:
    page = show(hand())
    area = page.root.locator("path.vfw-reachable")
    start = shoulder(page)
    page.root.locator("button.vfw-reach").click()
    page.wait()
    assert "Press a point" in page.root.locator(".vfw-status").inner_text()
    page.drag(start, (12, 0))
    page.page.wait_for_function(
        """() => { const d = document.querySelector('.vfw-reachable').getAttribute('d');
                  const same = d !== '' && d === window.before; window.before = d; return same }""",
        polling=200,
    )
    # Wherever the axes go, the point is on a dot.
    text, pixel = page.text, page.client([1, 0])[0] - page.client([0, 0])[0]
    handle = text.nearest(100, 700)
    dots = [
        [float(n) for n in dot.split()]
        for dot in str(area.get_attribute("d"))[1:].split("M")
        for dot in [dot.removesuffix("h0")]
    ]
    for weight in (300, 500, 1000):
        for slant in (-15, -7, 0):
            axes = {"wght": weight, "slnt": slant, "CASL": 0.5}
            x, y = text.at(axes=axes).position(handle).tolist()
            assert min((x - a) ** 2 + (y + b) ** 2 for a, b in dots) ** 0.5 * pixel < 10
    page.root.locator("button.vfw-reach").click()
    page.wait()
    assert area.get_attribute("d") == ""


def test_letters_that_are_selected_together_share_their_axes(show: Any) -> None:
    page = show(vf.Editor("recursive", "hand", shared=False))
    chips = page.root.locator(".vfw-chip")
    chips.nth(1).click()
    chips.nth(2).click(modifiers=["Shift"])
    page.wait()
    assert chips.evaluate_all("all => all.map(c => c.ariaPressed)") == [
        *("false", "true", "true", "false")
    ]
    page.root.locator("input[type=number][data-tag=wght]").fill("800")
    page.wait()
    assert [axes["wght"] for axes in page.letters()] == [300, 800, 800, 300]
    # A slide over the letters selects them, too; then a drag of one moves all.
    x, y = (chips.nth(i).bounding_box() for i in (0, 2))
    page.page.mouse.move(x["x"] + 5, x["y"] + 5)
    page.page.mouse.down()
    page.page.mouse.move(y["x"] + 5, y["y"] + 5, steps=6)
    page.page.mouse.up()
    page.wait()
    assert chips.nth(0).get_attribute("aria-pressed") == "true"
    assert chips.nth(2).get_attribute("aria-pressed") == "true"
    page.drag([100.0, 700.0], (20, 0))
    values = page.letters()
    assert values[0] == values[1] == values[2] != values[3]
    assert values[0]["slnt"] < 0


def test_the_numbers_are_those_of_python(show: Any) -> None:
    page = show(vf.Editor("recursive", "a", axes={"wght": 650, "CASL": 0.4}, teaching=True))
    lesson = page.root.locator(".vfw-lesson")
    gauges = lesson.locator(".vfw-gauges").first.locator("output")
    effect = page.text.font.axis_effect("a")
    assert [float(n) for n in gauges.all_inner_texts()] == pytest.approx(
        list(effect.values()), abs=0.51
    )
    glyph, theta = page.text.glyphs[0], page.text.theta[0]
    scalars = lesson.locator(".vfw-gauges").nth(1).locator("output").all_inner_texts()
    assert [float(s) for s in scalars] == pytest.approx(glyph.scalars(theta).tolist(), abs=6e-4)
    handle = page.text.nearest(300, 550)
    page.page.mouse.click(*page.client(page.text.position(handle).tolist()))
    page.wait()
    lines = lesson.locator("code").all_inner_texts()
    ends = [float(line.rsplit("= ", 1)[1].replace("−", "-")) for line in lines]
    x, y = page.text.position(handle).tolist()
    assert ends == pytest.approx([x, y], abs=4)
    page.root.locator(".vfw-teaching").uncheck()
    page.wait()
    assert not lesson.is_visible()


def test_letters_on_several_lines_are_named_underlined_and_selected_by_line(show: Any) -> None:
    page = show(vf.Editor("recursive", "ab\nci", shared=False))
    chips = page.root.locator(".vfw-chip")
    assert chips.all_inner_texts() == ["a", "b", "c", "i"]
    layout = page.text.layout
    chips.nth(1).click()
    chips.nth(2).click(modifiers=["Shift"])
    page.wait()
    drawn = page.root.locator(".vfw-selected").get_attribute("d")
    lines = [tuple(map(float, re.split("[ H]", line))) for line in drawn.split("M")[1:]]
    for (left, _, right), letter in zip(lines, layout[1:3], strict=True):
        ends = (letter.x, letter.x + letter.advance)
        assert (left, right) == pytest.approx(ends, abs=0.1)
    assert lines[1][1] - lines[0][1] == pytest.approx(-layout[2].y, abs=30)
    # No outline is beside the stem of the i, above its serif, and only the second line is near.
    page.page.mouse.click(*page.client([layout[3].x + 60, layout[3].y + 250]))
    page.wait()
    pressed = chips.evaluate_all("all => all.map(chip => chip.ariaPressed)")
    assert pressed == ["false", "false", "false", "true"]


def test_lines_are_made_equally_wide(show: Any) -> None:
    page = show(vf.Editor("roboto-flex", "wide\nnarrow", axes={"wdth": 90}))
    page.root.locator(".vfw-add-constraint").select_option(label="Make all lines equally wide")
    page.wait(600)
    assert "Make all lines equally wide" in page.root.locator(".vfw-constraint").inner_text()
    assert page.root.locator(".vfw-constraint-lines").get_attribute("d").count("M") == 2


def test_obstacles_near_the_word_are_in_the_picture(show: Any) -> None:
    above = [(0, 1200), (300, 1200), (300, 1500)]
    page = show(vf.Editor("recursive", "no", obstacles=[above]))
    page.wait(1200)
    picture = page.root.locator(".vfw-svg").bounding_box()
    obstacle = page.root.locator(".vfw-obstacles").bounding_box()
    assert picture["y"] < obstacle["y"]
    assert page.root.locator(".vfw-letter").first.bounding_box()["height"] > 60


def test_a_wall_far_larger_than_the_word_leaves_that_large(show: Any) -> None:
    wall = [(-90_000, -300), (90_000, -300), (90_000, -90_000), (-90_000, -90_000)]
    page = show(vf.Editor("recursive", "no", obstacles=[wall]))
    page.wait(1200)
    assert page.root.locator(".vfw-letter").first.bounding_box()["height"] > 60
