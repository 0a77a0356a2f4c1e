"""Exported animations in Chromium: at ten times what it draws is what the frames hold."""

from __future__ import annotations

import io
import json
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import registry_fonts
from PIL import Image
from scipy.ndimage import binary_dilation

import vfwidget as vf
from tests.motion.films import coloured, film, without_sweep
from vfwidget.export.animated_svg import still_picture
from vfwidget.export.track import shapes_at
from vfwidget.motion.tracks import drawn_box, letter_tracks, obstacle_tracks, outlines

pytestmark = [pytest.mark.browser, pytest.mark.timeout(180)]

EM = 100
"""Pixels of an em."""
SCALE = 4
"""Pixels of the screen for each pixel of the page, so that half a pixel can be seen."""
CSS = f"e => {{ e.style.cssText = 'position: absolute; left: 0; top: 0; font-size: {EM}px' }}"
"""Puts an element into the corner of a page."""


class Stage:
    """An animation on a page, beside the outlines of its frames."""

    def __init__(self, page: Any, animation: Any) -> None:
        self.page, self.animation = page, animation
        tracks = letter_tracks(animation)
        self.box = drawn_box(animation, tracks)
        self.letters = [track for row in tracks for track in row]
        self.obstacles = obstacle_tracks(animation)
        em = animation.text.font.units_per_em
        left, bottom, right, top = self.box
        self.size = ((right - left) * EM / em, (top - bottom) * EM / em)
        self.k = SCALE * EM / em

    def shown(self) -> np.ndarray:
        """What the browser draws, as darkness 0 … 1."""
        width, height = map(int, self.size)
        clip = {"x": 0, "y": 0, "width": width, "height": height}
        image = Image.open(io.BytesIO(self.page.screenshot(clip=clip))).convert("L")
        return 1 - np.asarray(image) / 255

    def find_baseline(self) -> None:
        """Take from the page how far the baseline lies below the upper edge, in pixels."""
        height = (
            "parseFloat(getComputedStyle(document.querySelector('.vf-text'), '::before').height)"
        )
        em = self.animation.text.font.units_per_em
        self.box = (*self.box[:3], self.page.evaluate(height) * em / EM)

    def agrees(self, number: int, tolerance: float = 0.5) -> None:
        """Assert that no edge is farther from that of the frame than so many pixels of the page."""
        shown = self.shown() > 0.6  # obstacles are lighter
        placement = np.array(
            [[self.k, 0, -self.k * self.box[0]], [0, -self.k, self.k * self.box[3]]]
        )
        shapes = shapes_at(self.letters, number)
        contours = [contour for shape in shapes for contour in shape.contours]
        expected = vf.rasterize(contours, shown.shape, placement).numpy() > 0.5
        radius = round(tolerance * SCALE)
        disk = np.hypot(*np.mgrid[-radius : radius + 1, -radius : radius + 1]) <= radius
        assert expected.mean() > 0.05
        assert not (shown & ~binary_dilation(expected, disk)).any()
        assert not (expected & ~binary_dilation(shown, disk)).any()

    def numbers(self) -> list[int]:
        """Ten frames, evenly spaced."""
        return [int(i) for i in np.linspace(0, len(self.animation) - 1, 10)]

    def seconds(self, number: int) -> float:
        time = self.animation.times[number] - self.animation.times[0]
        # The end of one run is the start of the next.
        return float(min(time, self.animation.duration - 1e-6))


@pytest.fixture
def open_page(browser: Any) -> Iterator[Callable[..., Any]]:
    """Open a file without a network; nothing may go wrong on the page."""
    troubles: list[str] = []
    contexts = []

    def open_it(file: Path, **options: Any) -> Any:
        context = browser.new_context(
            viewport={"width": 900, "height": 500},
            device_scale_factor=SCALE,
            offline=True,
            **options,
        )
        contexts.append(context)
        page = context.new_page()
        page.on("console", lambda message: troubles.append(message.text))
        page.on("pageerror", lambda error: troubles.append(str(error)))
        page.goto(file.as_uri())
        page.evaluate("document.fonts.ready")
        return page

    yield open_it
    for context in contexts:
        context.close()
    assert not troubles


def play_css(page: Any, seconds: float) -> None:
    """Hold all CSS animations at a time."""
    page.evaluate(
        "t => document.getAnimations().forEach(a => { a.pause(); a.currentTime = t })",
        1000 * seconds,
    )


@pytest.mark.parametrize(
    ("font", "string"),
    [
        ("recursive", "AVog"),
        # Glyphs that depend on their neighbours; marks, lines and brackets; letters that join.
        pytest.param("shantell-sans", "oooo", marks=pytest.mark.slow),
        pytest.param("recursive", "e\u0301ñ\n(b)", marks=pytest.mark.slow),
        pytest.param("vazirmatn/vazirmatn-arabic-wght-normal", "سلام", marks=pytest.mark.slow),
        pytest.param("rubik/rubik-hebrew-wght-normal", "שלום", marks=pytest.mark.slow),
    ],
)
def test_the_page_draws_the_frames_with_the_font_of_the_browser(
    open_page: Callable[..., Any], tmp_path: Path, font: str, string: str
) -> None:
    animation = film(registry_fonts.path(font) if "/" in font else font, string)
    animation.to_html(tmp_path / "page.html")
    page = open_page(tmp_path / "page.html")
    text = page.locator(".vf-text")
    text.evaluate(CSS)
    stage = Stage(page, animation)
    stage.find_baseline()
    for number in stage.numbers():
        play_css(page, stage.seconds(number))
        stage.agrees(number)
    assert text.inner_text().replace("\u200d", "") == string.replace("\n", "")
    assert page.get_by_role("img", name=" ".join(string.split())).count() == 1


def test_the_style_sheet_works_in_a_page_that_has_the_font(
    open_page: Callable[..., Any], tmp_path: Path
) -> None:
    animation = film(string="To", shared=True)
    css = animation.to_css()
    element = css[2 : css.index("*/")]
    font = Path(vf.__file__).parent / "fonts" / "recursive.woff2"
    shutil.copy(font, tmp_path / "font.woff2")
    family = animation.text.font.family_name
    face = f'@font-face {{ font-family: "{family}"; src: url(font.woff2) }}'
    (tmp_path / "page.html").write_text(f"<style>{face}{css}</style>{element}")
    page = open_page(tmp_path / "page.html")
    page.locator(".vf-text").evaluate(CSS)
    stage = Stage(page, animation)
    stage.find_baseline()
    for number in stage.numbers()[::3]:
        play_css(page, stage.seconds(number))
        stage.agrees(number)


def test_reduced_motion_shows_the_last_frame(open_page: Callable[..., Any], tmp_path: Path) -> None:
    animation = film()
    animation.to_html(tmp_path / "page.html")
    page = open_page(tmp_path / "page.html", reduced_motion="reduce")
    page.locator(".vf-text").evaluate(CSS)
    assert page.evaluate("document.getAnimations().length") == 0
    stage = Stage(page, animation)
    stage.find_baseline()
    stage.agrees(len(animation) - 1)
    animation.to_svg(tmp_path / "picture.svg")
    page = open_page(tmp_path / "picture.svg", reduced_motion="reduce")
    assert page.evaluate("getComputedStyle(document.querySelector('.moving')).display") == "none"
    assert page.evaluate("getComputedStyle(document.querySelector('.still')).display") == "inline"


def test_the_animated_svg_draws_the_frames(open_page: Callable[..., Any], tmp_path: Path) -> None:
    animation = film()
    animation.to_svg(tmp_path / "picture.svg")
    page = open_page(tmp_path / "picture.svg")
    # A picture takes whole pixels, and the test needs an em of exactly so many.
    page.evaluate(
        """em => {
          const root = document.documentElement, { x, y, width, height } = root.viewBox.baseVal;
          const [w, h] = [width, height].map(side => Math.ceil(em * side / 1000));
          root.setAttribute('viewBox', [x, y, 1000 * w / em, 1000 * h / em].join(' '));
          root.setAttribute('width', w);
          root.setAttribute('height', h);
          root.pauseAnimations();
        }""",
        EM,
    )
    stage = Stage(page, animation)
    for number in stage.numbers():
        page.evaluate("t => document.documentElement.setCurrentTime(t)", stage.seconds(number))
        stage.agrees(number)


def screenshot(page: Any) -> np.ndarray:
    return np.asarray(Image.open(io.BytesIO(page.screenshot())).convert("RGB")) / 255


def agrees_with_pictures(
    page: Any, pictures: Any, animation: Any, show: Callable[..., Any]
) -> None:
    """Assert that a page shows the colours of the still pictures of all frames, on another page."""
    letters, obstacles, box, palette = outlines(animation)
    for number in range(len(animation) - 1):
        show(number)
        look = {"title": "", "box": box, "palette": palette, "height": TALL}
        pictures.evaluate(
            "made => { document.body.innerHTML = made }",
            still_picture(letters, obstacles, number, **look),
        )
        expected, shown = screenshot(pictures), screenshot(page)
        assert np.ptp(expected, axis=2).max() > 0.3
        assert np.quantile(abs(shown - expected), 0.999) < 0.02


PLAY = """([data, width, height]) => {
  stage.style.width = width + 'px'; stage.style.height = height + 'px';
  window.film = lottie.loadAnimation({container: stage, renderer: 'svg', loop: false,
    autoplay: false, animationData: data});
}"""
"""Loads a Lottie document into a page."""
TALL = 400
"""Pixels of the pictures that are compared."""
BARE = "<style>body { margin: 0 } svg { display: block }</style><body>"


@pytest.mark.slow
def test_the_svg_of_colour_glyphs_shows_every_frame(
    open_page: Callable[..., Any], tmp_path: Path
) -> None:
    animation = coloured()
    (tmp_path / "page.html").write_text(BARE + str(animation.to_svg(height=TALL)))
    (tmp_path / "pictures.html").write_text(BARE)
    page, pictures = (open_page(tmp_path / f"{name}.html") for name in ("page", "pictures"))
    page.evaluate("document.querySelector('svg').pauseAnimations()")

    def show(number: int) -> None:
        seconds = float(animation.times[number]) + 1e-4
        page.evaluate("t => document.querySelector('svg').setCurrentTime(t)", seconds)

    agrees_with_pictures(page, pictures, animation, show)


@pytest.mark.slow
def test_the_lottie_of_colour_glyphs_shows_every_frame(
    open_page: Callable[..., Any], tmp_path: Path
) -> None:
    player = registry_fonts.package("lottie-web") / "build" / "player" / "lottie_svg.min.js"
    animation = coloured(without_sweep)
    (tmp_path / "page.html").write_text(BARE + "<div id=stage></div>")
    (tmp_path / "pictures.html").write_text(BARE)
    page, pictures = (open_page(tmp_path / f"{name}.html") for name in ("page", "pictures"))
    page.add_script_tag(path=player)
    document = json.loads(str(animation.to_lottie()))
    page.evaluate(PLAY, [document, TALL * document["w"] / document["h"], TALL])
    agrees_with_pictures(
        page,
        pictures,
        animation,
        lambda number: page.evaluate("frame => window.film.goToAndStop(frame, true)", number),
    )


@pytest.mark.slow
def test_the_lottie_drawn_by_a_player_agrees_with_the_frames(
    open_page: Callable[..., Any], tmp_path: Path
) -> None:
    player = registry_fonts.package("lottie-web") / "build" / "player" / "lottie_svg.min.js"
    animation = film()
    data = animation.to_lottie()
    (tmp_path / "page.html").write_text(
        "<style>body { margin: 0 } #stage { position: absolute }</style><div id=stage></div>"
    )
    page = open_page(tmp_path / "page.html")
    page.add_script_tag(path=player)
    document = json.loads(data)
    scale = EM / animation.text.font.units_per_em
    page.evaluate(
        PLAY,
        [document, scale * document["w"], scale * document["h"]],
    )
    stage = Stage(page, animation)
    for number in stage.numbers():
        page.evaluate("frame => window.film.goToAndStop(frame, true)", number)
        stage.agrees(number)
