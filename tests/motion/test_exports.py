"""Every export of an animation holds its frames, and nothing hostile gets out of names."""

from __future__ import annotations

import base64
import io
import json
import re
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import colour_fonts
import numpy as np
import pytest
from fontTools.ttLib import TTFont
from PIL import Image, ImageSequence

import vfwidget as vf
from tests.export.test_page import HOSTILE, Page
from tests.motion.films import coloured, film, without_sweep
from vfwidget.export.track import blended, keyframes
from vfwidget.motion.frames import drawn_frames
from vfwidget.motion.tracks import letter_tracks, outlines

SVG = "{http://www.w3.org/2000/svg}"
WRITERS = ("css", "html", "svg", "lottie", "gif", "json")


@pytest.fixture(scope="module")
def moving() -> Any:
    return film()


@pytest.mark.parametrize("by_axes", [False, True])
def test_keyframes_give_every_frame_within_the_tolerance(moving: Any, by_axes: bool) -> None:
    for row in letter_tracks(moving):
        for track in row:
            keys = keyframes(track, 2.0, by_axes)
            off = blended(track, keys, track.times, by_axes) - track.drawn
            assert np.linalg.norm(off, axis=-1).max() <= 2.0
            assert len(keyframes(track, 8.0, by_axes)) < len(keys) < len(track.times)


def test_tracks_are_the_outlines_of_the_frames(moving: Any) -> None:
    tracks = letter_tracks(moving)
    for number in (0, 14, 15, 30):
        present = [t for row in tracks for t in row if t.start <= number < t.start + len(t.times)]
        drawn = np.concatenate([t.drawn[number - t.start] for t in present])
        np.testing.assert_allclose(drawn, moving[number].points().numpy(), atol=1e-9)
    # The a of Recursive has another glyph where it is cursive.
    assert sorted(len(row) for row in tracks)[-1] == 2


def test_json_holds_the_axes_and_positions_of_every_frame(moving: Any) -> None:
    data = json.loads(moving.to_json())
    assert data["text"] == "AVog" and data["units_per_em"] == 1000
    np.testing.assert_allclose(data["times"], moving.times, atol=1e-5)
    for number in (0, 20):
        for index, letter in enumerate(data["letters"]):
            axes = {tag: values[number] for tag, values in letter["axes"].items()}
            assert axes == pytest.approx(moving[number].axes[index], abs=1e-5)
            x, y = moving.positions[number, index]
            assert (letter["x"][number], letter["y"][number]) == pytest.approx((x, y), abs=1e-5)


def test_the_gif_shows_the_frames(moving: Any) -> None:
    data = moving.to_gif(height=40, fps=10, progress=False)
    images = [i.convert("L") for i in ImageSequence.Iterator(Image.open(io.BytesIO(data)))]
    assert Image.open(io.BytesIO(data)).info["duration"] == 100
    expected = coverages(moving, 40, 10)
    assert len(images) == len(expected) == 16
    for image, coverage in zip(images, expected, strict=True):
        np.testing.assert_allclose(np.asarray(image) / 255, 1 - coverage, atol=0.005)


def test_png_files_are_numbered_and_transparent(moving: Any, tmp_path: Path) -> None:
    moving.to_png(tmp_path / "frames", height=40, fps=2, ink="#ff0000", progress=False)
    files = sorted((tmp_path / "frames").iterdir())
    assert [file.name for file in files] == [f"frame-{i:04d}.png" for i in (1, 2, 3, 4)]
    pixels = np.asarray(Image.open(files[0]))
    assert pixels.shape[2] == 4 and (pixels[..., :3] == [255, 0, 0]).all()
    assert set(pixels[..., 3].ravel()) >= {0, 255}


def coverages(animation: Any, height: int, fps: float) -> list[np.ndarray]:
    return [i[..., 3] for i in drawn_frames(animation, height, fps, (0, 0, 0), progress=False)]


def decoded(video: bytes, kind: str, size: tuple[int, int]) -> list[np.ndarray]:
    """The frames of a video, (H, W, 4) each."""
    from imageio_ffmpeg import get_ffmpeg_exe

    # Another decoder of VP9 leaves transparency out.
    decoder = ["-c:v", "libvpx-vp9"] if kind == "webm" else []
    command = [*decoder, "-i", "-", "-f", "rawvideo", "-pix_fmt", "rgba", "-"]
    done = subprocess.run(
        [get_ffmpeg_exe(), *command], input=video, capture_output=True, check=True
    )
    return list(np.frombuffer(done.stdout, np.uint8).reshape(-1, *size, 4))


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["mp4", "webm"])
def test_videos_decoded_again_agree(moving: Any, tmp_path: Path, kind: str) -> None:
    # ffmpeg would take such a name for an option.
    name = tmp_path / f"-i http:{'x' if kind == 'webm' else ''}.{kind}"
    getattr(moving, f"to_{kind}")(name, height=120, progress=False)
    expected = coverages(moving, 120, moving.fps)
    images = decoded(name.read_bytes(), kind, expected[0].shape)
    assert len(images) == len(expected) == len(moving)
    for image, coverage in zip(images, expected, strict=True):
        ink = image[..., 3] / 255 if kind == "webm" else 1 - image[..., 0] / 255
        assert np.abs(ink - coverage).mean() < 0.01
        assert np.quantile(np.abs(ink - coverage), 0.99) < 0.1


def test_a_missing_ffmpeg_names_the_extra(moving: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(vf.MotionError, match=re.escape("pip install 'vfwidget[video]'")):
        moving.to_mp4()


def test_the_svg_is_valid_and_shows_one_glyph_at_a_time(moving: Any) -> None:
    root = ET.fromstring(moving.to_svg())
    assert root.find(f"{SVG}title").text == "AVog in Recursive Sans Linear Light"  # type: ignore[union-attr]
    for element in root.iter():
        if "keyTimes" in element.attrib:
            times = [float(t) for t in element.attrib["keyTimes"].split(";")]
            assert times[0] == 0 and times == sorted(times) and times[-1] <= 1
            assert len(element.attrib["values"].split(";")) == len(times)
    switches = [e for e in root.iter() if e.attrib.get("attributeName") == "visibility"]
    assert len(switches) % 2 == 0 and len(switches) >= 2


def test_a_static_letter_takes_no_keyframes() -> None:
    text = vf.Text("dynapuff", "h")
    still = vf.Animation(text, [0, 1, 2], np.repeat(text.theta.numpy()[None], 3, axis=0))
    assert "@property" not in still.to_css()
    assert 'attributeName="d"' not in still.to_svg()
    (layer,) = json.loads(still.to_lottie())["layers"]
    assert layer["ks"]["p"]["a"] == 0


def test_a_single_frame_can_be_exported() -> None:
    text = vf.Text("dynapuff", "h")
    single = vf.Animation(text, [0], text.theta.numpy()[None])
    for kind in WRITERS:
        options = {"progress": False} if kind == "gif" else {}
        assert getattr(single, f"to_{kind}")(**options)


def test_the_page_contains_the_font_and_no_script(moving: Any) -> None:
    made = Page(moving.to_html())
    assert "script" not in made.tags
    (policy,) = [a["content"] for _, a in made.elements if "http-equiv" in a]
    assert policy == "default-src 'none'; style-src 'unsafe-inline'; font-src data:"
    assert (
        made.texts[made.tags.index("span") :] == ["A", "V", "o", "g\n"]
        or "".join(made.texts[made.tags.index("span") :]).strip() == "AVog"
    )


def test_hostile_names_and_texts_are_inert() -> None:
    font = TTFont(Path(vf.__file__).parent / "fonts" / "dynapuff.woff2")
    for record in font["name"].names:
        record.string = HOSTILE
    for entry in font["fvar"].axes:
        entry.axisTag = {"wght": "wght", "wdth": '";}<'}[entry.axisTag]
    for instance in font["fvar"].instances:
        instance.coordinates = {
            entry.axisTag: value
            for entry, value in zip(font["fvar"].axes, instance.coordinates.values(), strict=True)
        }
    font["avar"].segments = {
        entry.axisTag: segments
        for entry, segments in zip(
            font["fvar"].axes, list(font["avar"].segments.values()), strict=True
        )
    }
    bad = film(vf.load_font(font), "*/<i&", frames=4)
    good = film("dynapuff", "*/<i&", frames=4)
    assert Page(bad.to_html()).tags == Page(good.to_html()).tags
    css = bad.to_css()
    assert css.count("*/") == 1 and "<script" not in css and '";}<' not in css
    assert ET.fromstring(bad.to_svg()).find(f"{SVG}title").text.endswith(HOSTILE)  # type: ignore[union-attr]
    assert json.loads(bad.to_lottie())["nm"].endswith(HOSTILE)
    assert json.loads(bad.to_json())["family"] == HOSTILE


@pytest.mark.parametrize("kind", WRITERS)
def test_a_path_is_written_and_an_existing_file_replaced(tmp_path: Path, kind: str) -> None:
    short = film("dynapuff", "hi", frames=3)
    options = {"progress": False} if kind == "gif" else {}
    write = getattr(short, f"to_{kind}")
    (tmp_path / kind).write_text("before")
    assert write(tmp_path / kind, **options) is None
    content = write(**options)
    data = content.encode() if isinstance(content, str) else content
    assert (tmp_path / kind).read_bytes() == data


def test_a_glyph_that_depends_on_its_neighbours_is_refused_with_a_remedy() -> None:
    # Shantell Sans alternates the shapes of repeated letters.
    animation = film("shantell-sans", "oooo", frames=3)
    with pytest.raises(vf.MotionError, match=r"features=\{'rlig': False\}"):
        animation.to_css()
    assert film("shantell-sans", "oooo", frames=3, features={"rlig": False}).to_css()


def test_the_font_of_a_page_has_the_tables_that_browsers_require() -> None:
    file = io.BytesIO()
    bare = TTFont(Path(vf.__file__).parent / "fonts" / "dynapuff.woff2")
    bare.flavor = None
    for tag in ("name", "post", "OS/2"):
        del bare[tag]
    bare.save(file)
    text = vf.Text(vf.load_font(file.getvalue()), "ab")
    found = re.search(r"base64,(.*?)\"", vf.Animation.from_keyframes([(0, text)]).to_html())
    assert found
    font = TTFont(io.BytesIO(base64.b64decode(found[1])))
    assert {"name", "post", "OS/2", "cmap", "head", "hhea", "hmtx", "maxp"} <= set(font.keys())


@pytest.mark.parametrize("moved", [{"offsets": [(0, 0), (0, 90)]}, {"rotations": [0.5, 0.5]}])
def test_a_mark_that_leaves_its_letter_is_refused_with_a_remedy(moved: Any) -> None:
    text = vf.Text("recursive", "x\u0308")
    together = vf.Animation.from_keyframes([(0, text), (1, text.at(offsets=[(0, 90)] * 2))])
    assert together.to_css() and together.to_html()
    apart = vf.Animation.from_keyframes([(0, text), (1, text.at(**moved))])
    for write in (apart.to_css, apart.to_html):
        with pytest.raises(vf.MotionError, match=r"by themselves.*to_svg"):
            write()
    assert apart.to_svg() and apart.to_lottie()


def test_the_font_of_a_page_chooses_glyphs_that_depend_on_their_neighbours() -> None:
    animation = film("shantell-sans", "oooo", frames=3)
    html = animation.to_html()
    found = re.search(r"base64,(.*?)\"", html)
    assert found
    font = vf.load_font(base64.b64decode(found[1]))
    for index, glyph in enumerate(animation.text.glyphs, start=1):
        settings = re.search(rf'nth-child\({index}\) {{[^}}]*"vfwd" (\d)', html)
        features = {"vfwd": int(settings[1])} if settings else {}
        (shaped,) = vf.Text(font, "o", features=features).glyphs
        np.testing.assert_array_equal(shaped.default, glyph.default)


def test_images_of_colour_glyphs_are_those_of_the_frames(tmp_path: Path) -> None:
    animation = coloured()
    animation.to_png(tmp_path, height=60, fps=4, background="white", progress=False)
    box = outlines(animation).box
    scale = 60 / (box[3] - box[1])
    for number, file in enumerate(sorted(tmp_path.iterdir())):
        pixels = np.asarray(Image.open(file)) / 255
        height, width, _ = pixels.shape
        x = (width - scale * (box[2] - box[0])) / 2 - scale * box[0]
        placement = [[scale, 0, x], [0, -scale, scale * box[3]]]
        drawn = vf.rasterize(animation[number], (height, width), placement, palette=0).numpy()
        alpha = drawn[..., 3:]
        np.testing.assert_allclose(pixels, drawn[..., :3] * alpha + 1 - alpha, atol=0.005)
    assert np.ptp(pixels, axis=2).max() > 0.3
    gif = Image.open(io.BytesIO(animation.to_gif(height=60, fps=4, progress=False)))
    gif.seek(gif.n_frames - 1)
    assert abs(np.asarray(gif.convert("RGB")) / 255 - pixels).mean() < 0.02


def test_the_svg_of_colour_glyphs_has_the_paint_of_every_frame() -> None:
    animation = coloured()
    made = animation.to_svg()
    groups = list(ET.fromstring(made).iter(f"{SVG}linearGradient"))
    # One for each frame, because the gradient varies, and one for readers of still pictures.
    assert len(groups) == len(animation) + 1
    names = re.findall(r' id="([^"]*)"', made)
    assert len(names) == len(set(names))
    assert set(re.findall(r"url\(#([^)]*)\)", made)) == set(names)
    text = vf.Text(vf.load_font(colour_fonts.flat_colours()), "b")
    still = vf.Animation(text, [0, 1], np.repeat(text.theta.numpy()[None], 2, axis=0))
    assert still.to_svg().count("fill-opacity") == 2 * text.to_svg().count("fill-opacity") == 4


def test_lottie_has_the_gradients_and_names_those_that_it_lacks() -> None:
    with pytest.raises(vf.MotionError, match="Lottie has no sweep gradients"):
        coloured().to_lottie()
    animation = coloured(without_sweep)
    layers = json.loads(animation.to_lottie())["layers"]
    # The first layer is the topmost; the plain letter has one, the colour glyph three.
    fills = [layer["shapes"][0]["it"][-2] for layer in layers]
    assert [fill["ty"] for fill in fills] == ["gf", "fl", "fl", "fl"]
    (*_, layer) = animation.text.glyphs[1].layers[:3]
    for number, key in enumerate(fills[0]["s"]["k"]):
        fill = layer.paint.at(animation.theta[number, 1])
        start = fill.matrix[:, :2] @ fill.geometry[:2] + fill.matrix[:, 2]
        np.testing.assert_allclose(key["s"], start * [1, -1], atol=0.06)


def test_a_layer_of_lottie_ends_when_the_next_one_begins() -> None:
    text = vf.Text("recursive", "a")
    # The glyph changes with the axis CRSV, between frames at uneven times.
    theta = [text.at(axes={"CRSV": value}).coordinates for value in (0, 0, 1, 1, 0)]
    document = json.loads(vf.Animation(text, [2, 2.1, 2.15, 2.9, 3], theta).to_lottie())
    spans = sorted((layer["ip"], layer["op"]) for layer in document["layers"])
    assert len(spans) == 3
    assert [end for _, end in spans] == [*(start for start, _ in spans[1:]), document["op"]]
    assert document["fr"] == 4 and document["op"] == 5


def test_a_gif_that_stands_still_for_too_long_is_refused_with_a_remedy() -> None:
    text = vf.Text("recursive", "a")
    theta = np.repeat(text.coordinates[None], 2, axis=0)
    small = {"height": 10, "fps": 0.1, "progress": False}
    assert vf.Animation(text, [0, 600], theta).to_gif(**small)
    with pytest.raises(vf.MotionError, match=r"655\.35 s\. Use to_mp4"):
        vf.Animation(text, [0, 700], theta).to_gif(**small)


def test_too_many_images_are_refused_before_any_is_drawn() -> None:
    text = vf.Text("dynapuff", "h")
    long = vf.Animation(text, [0, 1e6], np.repeat(text.theta.numpy()[None], 2, axis=0))
    with pytest.raises(vf.MotionError, match="25,000,001 images"):
        long.to_gif()


@pytest.mark.parametrize(
    ("kind", "options", "message"),
    [
        ("css", {"tolerance": -1}, "tolerance"),
        ("css", {"name": "a b"}, "name must be a letter"),
        ("css", {"name": '"></style><script>'}, "name must be a letter"),
        ("svg", {"tolerance": float("nan")}, "tolerance"),
        ("svg", {"tolerance": 10**400}, "tolerance"),
        ("svg", {"height": float("nan")}, "height"),
        ("svg", {"height": -1}, "height"),
        ("svg", {"height": "tall"}, "height"),
        ("svg", {"background": 7}, "background"),
        ("svg", {"loop": "yes"}, "loop must be True or False"),
        ("css", {"loop": np.zeros(2)}, "loop must be True or False"),
        ("gif", {"loop": 3}, "loop must be True or False"),
        ("gif", {"height": 10**400}, "height"),
        ("lottie", {"ink": "nothing"}, "opaque colour"),
        ("gif", {"background": "#12345600"}, "opaque colour"),
        ("gif", {"fps": 0}, "fps"),
        ("gif", {"fps": "many"}, "fps"),
        ("gif", {"height": 0}, "height"),
        ("svg", {"height": -1}, "height must be"),
    ],
)
def test_options_without_a_meaning_are_refused(
    moving: Any, kind: str, options: dict[str, Any], message: str
) -> None:
    with pytest.raises(vf.MotionError, match=message):
        getattr(moving, f"to_{kind}")(**options)


@pytest.mark.parametrize("string", ["a b", " "])
def test_a_text_with_spaces_can_be_exported(string: str) -> None:
    moving = film(string=string, frames=5)
    ET.fromstring(moving.to_svg())
    for row in letter_tracks(moving):
        for track in row:
            shown = blended(track, keyframes(track, 0.0), track.times)
            np.testing.assert_allclose(shown, track.drawn, atol=1e-6)
    assert len(json.loads(moving.to_json())["letters"]) == len(string)
    json.loads(moving.to_lottie())
    assert moving.to_gif(progress=False).startswith(b"GIF89a")


@pytest.mark.parametrize("duration", [3e-6, 2e-9])
def test_a_very_short_animation_keeps_its_duration(duration) -> None:
    text = vf.Text("recursive", "A")
    short = vf.Animation.from_keyframes(
        [(0, text), (duration, text.at(axes={"wght": 900}))], fps=4 / duration
    )
    assert json.loads(short.to_json())["times"][-1] == pytest.approx(duration, rel=1e-2)
    assert f'dur="{duration:.9f}'.rstrip("0") + 's"' in short.to_svg()
    assert f"animation: {duration:.9f}".rstrip("0") + "s linear" in short.to_css()
