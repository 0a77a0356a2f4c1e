"""The browser's own text, in the same font at the same settings, covers the editor's drawing."""

from __future__ import annotations

import base64
import io
import os
from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import registry_fonts
from PIL import Image

import vfwidget as vf

pytestmark = [pytest.mark.browser, pytest.mark.slow, pytest.mark.timeout(180)]

PIXELS = 100
"""Height of the em."""
ZOOM = 4
"""Pixels of a screenshot for one pixel of the page: half a pixel is two of these."""
HALF = ZOOM // 2

CASES = {
    "recursive": (
        "recursive",
        "fikag",
        [{"CRSV": 0.95}, {"MONO": 0.7, "wght": 820, "slnt": -14.9}],
    ),
    "roboto-flex": ("roboto-flex", "AV$To", [{"wght": 650}, {"wght": 240, "wdth": 60}]),
    "fraunces": (
        "fraunces/fraunces-latin-full-normal",
        "hnbfit",
        [{"opsz": 140, "WONK": 1}, {"wght": 850, "opsz": 9, "SOFT": 100}],
    ),
    "inter, Cyrillic": (
        "inter/inter-cyrillic-opsz-normal",
        "ГАУДИ",
        [{"wght": 150, "opsz": 32}, {"wght": 870}],
    ),
    "Noto Sans Arabic": (
        "noto-sans-arabic/noto-sans-arabic-arabic-standard-normal",
        "مَرْحَبًا",
        [{"wght": 830, "wdth": 70}, {"wght": 120}],
    ),
    "Noto Sans Devanagari": (
        "noto-sans-devanagari/noto-sans-devanagari-devanagari-standard-normal",
        "क्षेत्र र्कि",
        [{"wght": 800}, {"wght": 130, "wdth": 64}],
    ),
}


class Browser:
    """An editor's page without a network, and the same text set by the browser."""

    def __init__(self, context: Any, folder: Path) -> None:
        self.context, self.folder = context, folder
        self.page = context.new_page()

    def open(self, editor: vf.Editor) -> None:
        editor.to_html(self.folder / "page.html")
        self.page.goto((self.folder / "page.html").as_uri())
        self.page.wait_for_selector(".vfw-letter[d]", state="attached")

    def slide(self, tag: str, value: float) -> None:
        """Set a slider, as a person does."""
        self.page.locator(f"input[type=range][data-tag={tag}]").first.evaluate(
            """(input, value) => {
              input.value = value;
              input.dispatchEvent(new Event('input', { bubbles: true }));
            }""",
            value,
        )
        self.page.wait_for_timeout(50)

    @property
    def letters(self) -> list[list[str]]:
        """Path data and transformation of each letter that the editor has drawn."""
        found = self.page.locator(".vfw-letter").evaluate_all(
            "all => all.map(p => [p.getAttribute('d'), p.getAttribute('transform')])"
        )
        return list(found)

    def pictures(self, text: vf.Text, data: bytes) -> list[npt.NDArray[Any]]:
        """Ink of the browser's text and of the editor's paths, in pixels of a screenshot."""
        page = self.context.new_page()
        values = ", ".join(f'"{tag}" {value}' for tag, value in text.axes.items())
        paths = "".join(f'<path d="{d}" transform="{at}"/>' for d, at in self.letters)
        scale = PIXELS / text.font.units_per_em
        width = int(text.advance() * scale) + 120
        page.set_content(
            f"""<style>body {{ margin: 0 }} #box {{ position: relative; width: {width}px;
              height: 240px }} #text {{ position: absolute; left: 60px; top: 0; white-space: pre;
              font: {PIXELS}px/240px referee; font-variation-settings: {values};
              font-optical-sizing: none; text-rendering: geometricPrecision;
              unicode-bidi: plaintext }} svg {{ position: absolute; left: 60px; top: 0;
              overflow: visible }}</style><div id="box"><span id="text">{text.string}<i
              style="display: inline-block"></i></span><svg width="1" height="1"><g>{paths}</g>
              </svg></div>"""
        )
        page.evaluate(
            """async ([data, scale]) => {
              const bytes = Uint8Array.from(atob(data), c => c.charCodeAt(0));
              const face = new FontFace('referee', bytes.buffer, { weight: '1 1000',
                stretch: '1% 1000%', style: 'oblique -90deg 90deg' });
              document.fonts.add(await face.load());
              await document.fonts.ready;
              const base = document.querySelector('i').getBoundingClientRect().bottom;
              document.querySelector('g').setAttribute('transform',
                `translate(0 ${base}) scale(${scale})`);
            }""",
            [base64.b64encode(data).decode(), scale],
        )
        shown = []
        for hidden in ("svg", "#text"):
            page.add_style_tag(content=f"svg, #text {{ opacity: 1 }} {hidden} {{ opacity: 0 }}")
            picture = Image.open(io.BytesIO(page.locator("#box").screenshot()))
            shown.append(np.asarray(picture.convert("L")) < 128)
        page.close()
        return shown


@pytest.fixture
def opened(browser: Any, tmp_path: Path) -> Iterator[Browser]:
    size = {"width": 1000, "height": 700}
    context = browser.new_context(viewport=size, device_scale_factor=ZOOM, offline=True)
    yield Browser(context, tmp_path)
    context.close()


def grown(ink: npt.NDArray[Any], by: int) -> npt.NDArray[Any]:
    """Ink and what lies within ``by`` pixels of it."""
    y, x = np.mgrid[-by : by + 1, -by : by + 1]
    wide = np.zeros_like(ink)
    for dy, dx in zip(*(part[np.hypot(x, y) <= by].tolist() for part in (y, x)), strict=True):
        wide |= np.roll(ink, (dy, dx), (0, 1))
    return wide


def check(opened: Browser, text: vf.Text, data: bytes, name: str) -> None:
    own, drawn = opened.pictures(text, data)
    keep = os.environ.get("VFWIDGET_OVERLAYS")
    if keep:
        both = 255 - 85 * np.stack([2 * drawn, own + drawn, 2 * own], -1).astype(np.uint8)
        Image.fromarray(both).save(Path(keep) / f"{name}.png")
    assert own.sum() > 5000
    assert agree(own, drawn)
    assert not agree(own, np.roll(drawn, ZOOM, 1))


def agree(a: npt.NDArray[Any], b: npt.NDArray[Any]) -> bool:
    """Whether each pixel of ink is within half a pixel of ink in the other picture, as is paper."""
    pairs = ((a, b), (b, a), (~a, ~b), (~b, ~a))
    return not any((one & ~grown(other, HALF)).any() for one, other in pairs)


def font_file(name: str) -> Path:
    if "/" in name:
        return registry_fonts.path(name)
    return Path(str(files("vfwidget") / "fonts" / f"{name}.woff2"))


@pytest.mark.parametrize("case", CASES)
def test_the_browsers_text_covers_the_drawing(case: str, opened: Browser) -> None:
    name, string, places = CASES[case]
    path = font_file(name)
    font = vf.load_font(path)
    for i, axes in enumerate(places):
        text = vf.Text(font, string, axes=axes)
        opened.open(vf.Editor(text))
        check(opened, text, path.read_bytes(), f"{case} {i}")


def test_a_slider_that_crosses_a_boundary_swaps_the_glyph(opened: Browser) -> None:
    path = font_file("recursive")
    text = vf.Text(vf.load_font(path), "ok", axes={"CRSV": 0.5, "wght": 500})
    opened.open(vf.Editor(text))
    before = opened.letters
    seen = []
    for cursive in (0.5, 0.85, 0.89, 0.91, 0.95, 0.89):
        opened.slide("CRSV", cursive)
        seen.append(opened.letters[1][0] == before[1][0])
        assert opened.letters[0] == before[0]
        if cursive in (0.89, 0.91):
            check(opened, text.at({"CRSV": cursive, "wght": 500}), path.read_bytes(), f"{cursive}")
    assert seen == [True, True, True, False, False, True]


def test_a_drag_that_crosses_a_boundary_swaps_the_glyph(opened: Browser) -> None:
    """The bar of a dollar sign ends at the S from weight 600 on; no kernel takes part."""
    path = font_file("roboto-flex")
    text = vf.Text(vf.load_font(path), "$", axes={"wght": 560})
    editor = vf.Editor(text)
    editor.locks = [axis.tag for axis in text.font.axes if axis.tag != "wght"]
    opened.open(editor)
    edge = text.nearest(1060, 380)
    start, goal = (text.at({"wght": w}).position(edge).tolist() for w in (560, 660))
    root = opened.page.locator(".vfwidget-editor")
    (x, y), (to_x, to_y) = (
        root.evaluate("(r, p) => { const c = r.__vfw.toClient(...p); return [c.x, c.y] }", point)
        for point in (start, goal)
    )
    opened.page.mouse.move(x, y)
    opened.page.mouse.down()
    for i in range(1, 11):
        opened.page.mouse.move(x + i / 10 * (to_x - x), y + i / 10 * (to_y - y))
        opened.page.wait_for_timeout(40)
    weight = root.locator("input[type=range][data-tag=wght]").first
    reached = weight.evaluate("input => input.valueAsNumber")
    assert reached > 601
    check(opened, text.at({"wght": reached}), path.read_bytes(), "dragged")
    opened.page.mouse.up()
