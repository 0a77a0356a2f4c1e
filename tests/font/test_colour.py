"""Colour glyphs (COLR and CPAL): their layers and paints, against HarfBuzz."""

from __future__ import annotations

import itertools
import pickle
import warnings
from xml.etree import ElementTree

import colour_fonts
import fonts
import formats
import numpy as np
import pytest
import registry_fonts
import torch
import uharfbuzz as hb
import variation_tables
from fontTools.ttLib.tables.otTables import CompositeMode
from referee import OUTLINE_TOLERANCE, HarfBuzz, outline_error

import vfwidget as vf
from vfwidget.arrays import to_array
from vfwidget.outline.glyph import Layer
from vfwidget.raster.colours import radial

REAL = formats.CONFORMANCE / "formats" / "test_glyphs-glyf_colr_1_variable.ttf"
FOREGROUND = hb.Color(1, 2, 3, 255)
F2DOT14 = 16384
OPAQUE = {
    CompositeMode.CLEAR: lambda source, backdrop: [],
    CompositeMode.SRC: lambda source, backdrop: source,
    CompositeMode.DEST: lambda source, backdrop: backdrop,
    CompositeMode.SRC_OVER: lambda source, backdrop: backdrop + source,
    CompositeMode.DEST_OVER: lambda source, backdrop: source + backdrop,
}
"""The layers, from back to front, that a composition of two groups of layers comes to."""
MOST_EMS = 20
"""HarfBuzz computes the tangent of a skew near 90 degrees in float32."""


class Painted:
    """What HarfBuzz paints: (glyph id, its map, kind, numbers, stops, its map) of each layer."""

    def __init__(self, referee: HarfBuzz) -> None:
        self.font, self.layers = referee.font, []
        self.matrices, self.glyphs, self.boxes = [np.eye(3)], [], []
        self.groups, self.unlike = [], []
        functions = self.functions = hb.PaintFuncs()
        functions.set_push_transform_func(self._push)
        functions.set_pop_transform_func(lambda _: self.matrices.pop())
        functions.set_push_clip_glyph_func(self._clip)
        functions.set_push_clip_rectangle_func(self._box)
        functions.set_pop_clip_func(lambda _: self.glyphs.pop())
        functions.set_color_func(self._solid)
        functions.set_linear_gradient_func(lambda line, *n: self._paint("linear", n, line))
        functions.set_radial_gradient_func(lambda line, *n: self._paint("radial", n, line))
        functions.set_sweep_gradient_func(lambda line, *n: self._paint("sweep", n, line))
        functions.set_push_group_func(self._open)
        functions.set_pop_group_func(self._compose)

    def of(self, glyph_id: int, palette: int = 0) -> list:
        self.layers, self.boxes = [], []
        self.font.paint_glyph(glyph_id, self.functions, None, palette, FOREGROUND)
        return self.layers

    def _push(self, xx, yx, xy, yy, dx, dy, _):
        self.matrices.append(self.matrices[-1] @ [[xx, xy, dx], [yx, yy, dy], [0, 0, 1]])

    def _clip(self, glyph_id, _):
        self.glyphs.append((glyph_id, self.matrices[-1]))

    def _box(self, *numbers):
        self.glyphs.append(None)
        self.boxes.append(numbers[:4])

    def _solid(self, colour, _is_foreground, *_):
        self._add("solid", [], [(0.0, colour)], 0)

    def _paint(self, kind, numbers, line):
        numbers = list(numbers[:-1])
        if kind == "sweep":
            numbers[2:] = np.degrees(numbers[2:])
        stops = [(stop.offset, stop.color) for stop in line.color_stops]
        self._add(kind, numbers, stops, int(line.extend))

    def _open(self, _):
        self.groups.append(self.layers)
        self.layers = []

    def _compose(self, mode, _):
        mode = CompositeMode(int(mode))
        source, backdrop = self.layers, self.groups.pop()
        if mode not in OPAQUE:
            self.unlike.append(mode.name)
        self.layers = OPAQUE.get(mode, OPAQUE[CompositeMode.SRC_OVER])(source, backdrop)

    def _add(self, kind, numbers, stops, extend):
        clip = [glyph for glyph in self.glyphs if glyph][-1:]
        self.layers.append((clip, kind, numbers, stops, extend, self.matrices[-1]))


def stated(layer: Layer, w: np.ndarray):
    """A paint's numbers as the font states them: geometry, offsets and alphas."""
    numbers, count = layer.paint.numbers.value(w), len(layer.paint.entries)
    return np.split(numbers, [len(numbers) - 2 * count, len(numbers) - count])


def rgba(colours) -> np.ndarray:
    return np.array([[c.red, c.green, c.blue, c.alpha] for c in colours], dtype=float)


def distance(one: np.ndarray, other: np.ndarray) -> float:
    return float(np.abs(one - other).max()) if one.shape == other.shape else np.inf


def agree(font: vf.Font, referee: HarfBuzz, name: str, w: np.ndarray) -> int:
    glyph = font.glyph(name)
    referee.locate(w)
    painted = Painted(referee).of(glyph.glyph_id)
    if not glyph.layers:
        return 0
    assert len(glyph.layers) == len(painted), name
    left = list(glyph.layers)

    def painted_colours(layer):
        return 255 * layer.paint.at(w).colours(font.palettes[0], (1 / 255, 2 / 255, 3 / 255, 1.0))

    for clip, kind, numbers, stops, extend, matrix in painted:
        # HarfBuzz states the lower part of a composition first, also where it is painted last.
        want = rgba(colour for _, colour in sorted(stops, key=lambda stop: stop[0]))
        apart = [
            np.abs(one.paint.at(w).matrix - matrix[:2]).sum() + distance(painted_colours(one), want)
            for one in left
        ]
        layer = left.pop(int(np.argmin(apart)))
        [(glyph_id, outer)] = clip
        plain = referee.contours(glyph_id)
        theirs = [c @ outer[:2, :2].T + outer[:2, 2] for c in plain]
        ours = [c.numpy() for c in layer.glyph.segments(w)]
        size = max([1.0, *(np.abs(c).max() / 1000 for c in theirs if c.size)])
        if size > MOST_EMS:
            continue
        if ours:
            assert outline_error(ours, theirs) < OUTLINE_TOLERANCE * size, name
        geometry, offsets, _ = stated(layer, w)
        assert layer.paint.kind == kind
        np.testing.assert_allclose(geometry, numbers, atol=0.01, rtol=1e-5)
        np.testing.assert_allclose(np.sort(offsets), sorted(o for o, _ in stops), atol=1e-4)
        frame = layer.paint.frame.value(w)
        corners = np.array([[0, 0, 1], [1, 0, 1], [0, 1, 1]]) @ matrix[:2].T
        np.testing.assert_allclose(frame, corners, atol=2e-3 * size, rtol=1e-5)
        assert ["pad", "repeat", "reflect"].index(layer.paint.extend) == extend
        assert distance(painted_colours(layer), want) < 1.01
    return len(painted)


def check_layers(data: bytes, names: list[str], places: int) -> int:
    font, referee = vf.load_font(data), HarfBuzz(fonts.open_font(data))
    rng = np.random.default_rng(3)
    lower, upper = font.bounds
    count = 0
    for name in names:
        random = rng.uniform(lower, upper, (places, len(font.axes)))
        for w in [np.zeros(len(font.axes)), *np.round(random * F2DOT14) / F2DOT14]:
            count += agree(font, referee, name, w)
    return count


def test_every_kind_of_paint_varies_as_harfbuzz_has_it():
    assert check_layers(colour_fonts.coloured(), ["a"], 8) == 5 * 9


def test_flat_layers_are_those_of_harfbuzz():
    assert check_layers(colour_fonts.flat_colours(), ["a", "b"], 4) == 2 * 5


@formats.needs_conformance
@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::vfwidget.FontWarning")
def test_every_layer_of_a_font_of_a_public_test_suite():
    data = REAL.read_bytes()
    unlike = "cycle", "clip"
    names = [n for n in vf.load_font(data).glyph_names if not any(part in n for part in unlike)]
    assert check_layers(data, names, 2) > 500


@formats.needs_conformance
def test_composite_modes_are_drawn_or_named():
    data = REAL.read_bytes()
    font, referee = vf.load_font(data), HarfBuzz(fonts.open_font(data))
    w = np.zeros(len(font.axes))
    referee.locate(w)
    drawn, named = [], []
    for mode in CompositeMode:
        glyph = font.glyph(f"composite_{mode.name}")
        painted = Painted(referee)
        theirs = painted.of(glyph.glyph_id)
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            ours = glyph.layers
        if painted.unlike:
            assert painted.unlike == [mode.name]
            [warning] = said
            assert f"the composite mode {mode.name}." in str(warning.message)
            named.append(mode)
            continue
        assert said == []
        black = (0.0, 0.0, 0.0, 1.0)
        mine = [255 * layer.paint.at(w).colours(font.palettes[0], black) for layer in ours]
        assert len(mine) == len(theirs)
        for colours, (_, _, _, stops, _, _) in zip(mine, theirs, strict=True):
            assert distance(colours, rgba(colour for _, colour in stops)) < 1.01
        drawn.append(mode)
    assert drawn == list(OPAQUE)
    assert len(named) == 23


@pytest.mark.slow
@pytest.mark.parametrize("name", ["nabla/nabla-latin-full", "foldit/foldit-latin-wght"])
def test_every_layer_of_the_letters_of_a_colour_family(name):
    data = registry_fonts.path(f"{name}-normal").read_bytes()
    assert check_layers(data, list("ABRaeg"), 3) > 50


def test_a_font_without_axes_has_colours_too():
    data = colour_fonts.static_colours()
    font, referee = vf.load_font(data, static=True), HarfBuzz(fonts.open_font(data))
    assert agree(font, referee, "a", np.zeros(0)) == 3


def test_clip_boxes_are_those_of_harfbuzz():
    data = colour_fonts.coloured()
    font, referee = vf.load_font(data), HarfBuzz(fonts.open_font(data))
    reader = font._reader._colours
    for name, w in itertools.product("ae", [(0, 0), (0.5, 0.25), (-1, 0.75), (1, 1)]):
        referee.locate(w)
        painted = Painted(referee)
        painted.of(font.glyph(name).glyph_id)
        origin, right, top = reader.clip_box(name, ()).value(np.array(w, dtype=float))
        # HarfBuzz rounds a box outwards to whole units.
        np.testing.assert_allclose([(*origin, right[0], top[1])], painted.boxes, atol=1)


def test_a_clip_box_that_cuts_a_glyph_is_named():
    font = vf.load_font(colour_fonts.coloured())
    with pytest.warns(vf.FontWarning, match="'e' has colours .*: a clip box that cuts a part off"):
        assert len(font.glyph("e").layers) == 1
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert len(font.glyph("a").layers) == 5


@pytest.mark.parametrize("edit", [lambda _: None, variation_tables.add_avar_2])
def test_the_numbers_of_a_paint_have_derivatives(edit):
    rng = np.random.default_rng(8)
    step = 1e-6
    for layer in vf.load_font(colour_fonts.coloured(edit)).glyph("a").layers:
        for quantity in layer.paint.numbers, layer.paint.frame:
            for w in rng.uniform(-0.9, 0.9, (4, 2)):
                value, jacobian = quantity.value_and_jacobian(w)
                assert jacobian.shape == (*value.shape, 2)
                ahead, behind = (quantity.value(w + s * step * np.eye(2)) for s in (1, -1))
                slope = np.moveaxis(ahead - behind, 0, -1) / (2 * step)
                np.testing.assert_allclose(jacobian, slope, rtol=1e-6, atol=1e-4)
                tensor = torch.tensor(w)
                autograd = torch.autograd.functional.jacobian(quantity.value, tensor)
                torch.testing.assert_close(autograd, torch.as_tensor(jacobian))


def test_the_outline_of_a_layer_has_a_derivative():
    glyph = vf.load_font(colour_fonts.coloured()).glyph("a")
    w = torch.tensor([0.3, 0.4], dtype=torch.float64)
    assert glyph.layers
    for layer in glyph.layers:
        autograd = torch.autograd.functional.jacobian(layer.glyph.points, w)
        torch.testing.assert_close(layer.glyph.jacobian(w), autograd)


def test_what_is_not_drawn_is_named():
    font = vf.load_font(colour_fonts.coloured())
    with pytest.warns(vf.FontWarning, match="'c' has colours .* asks: the composite mode XOR"):
        assert len(font.glyph("c").layers) == 2


def test_a_colour_glyph_is_pickled_with_its_layers():
    glyph = vf.load_font(colour_fonts.flat_colours()).glyph("b")
    twin = pickle.loads(pickle.dumps(glyph))
    assert len(twin.layers) == 2
    assert torch.equal(twin.layers[0].glyph.default, glyph.layers[0].glyph.default)


def test_paints_without_end_are_refused():
    font = vf.load_font(colour_fonts.coloured())
    with pytest.raises(vf.FontError, match="COLR table is damaged: the paints of glyph 'd' nest"):
        len(font.glyph("d").layers)
    # Its outline is read nevertheless.
    assert font.glyph("d").contours == (3,)


def test_palettes_and_the_tables_that_are_read():
    font = vf.load_font(colour_fonts.coloured())
    assert len(font.palettes) == 2 and font.palettes[1][0] == (0, 1, 0, 1)
    assert vf.load_font("dynapuff").palettes == ()
    assert "COLR, CPAL" in repr(font.describe())


# Drawings


def text() -> vf.Text:
    return vf.Text(colour_fonts.coloured(), "aba", axes={"wght": 600})


def test_an_svg_has_a_path_for_every_layer():
    root = ElementTree.fromstring(text().to_svg(palette=1))
    tags = [element.tag.split("}")[1] for element in root.iter()]
    assert {"linearGradient", "radialGradient", "clipPath"} <= set(tags)
    fills = [element.get("fill") for element in root.iter() if element.get("fill")]
    assert fills.count("currentColor") == 4
    assert {e.get("stop-color") for e in root.iter()} == {None, "#00ff00", "#ffffff"}
    names = [element.get("id") for element in root.iter() if element.get("id")]
    assert len(set(names)) == len(names) == 6
    used = {f[5:-1] for f in fills if f.startswith("url(#")}
    clips = {e.get("id") for e in root.iter() if e.tag.endswith("clipPath")}
    assert used | clips == set(names) and not used & clips


def test_an_svg_of_other_texts_has_one_path():
    svg = vf.Text("dynapuff", "ab").to_svg()
    assert svg.count("<path") == 1
    assert "fill=" not in svg


def test_a_raster_paints_one_layer_over_the_other():
    drawn = vf.Text(colour_fonts.flat_colours(), "b")
    image = vf.rasterize(drawn, (64, 64), palette=0)
    assert image.shape == (64, 64, 4)
    both = [vf.rasterize(layer.glyph.segments([0, 0]), (64, 64), vf.raster.frame(drawn, (64, 64)))
            for layer in drawn.glyphs[0].layers]  # fmt: skip
    half = drawn.font.palettes[0][1][3]
    lower, upper = half * both[0], both[1]
    torch.testing.assert_close(image[..., 3], upper + lower * (1 - upper))
    only = (both[0] == 1) & (both[1] == 0)
    assert only.any()
    assert image[only].numpy() == pytest.approx(np.tile([0, 0, 1, half], (int(only.sum()), 1)))
    assert image[both[1] > 1 - 1e-12].numpy()[..., 3].min() == pytest.approx(1)
    assert image[both[1] > 1 - 1e-12].numpy()[..., :3].max() == pytest.approx(0)


@pytest.mark.parametrize(
    "geometry, x, y, want",
    [
        ((0, 0, 0, 0, 0, 10), 5, 0, 0.5),
        ((0, 0, 2, 10, 0, 2), 4, 2, 0.4),
        ((0, 0, 0, 10, 0, 5), -20, 0, np.nan),
        ((0, 0, 5, 10, 0, 5), 0, 9, np.nan),
    ],
)
def test_a_radial_gradient_by_hand(geometry, x, y, want):
    found = radial(np.array(geometry, dtype=float), np.array([[x]]), np.array([[y]]))
    np.testing.assert_allclose(found, [[want]])


@pytest.mark.parametrize("palette", [2, -1, [(1, 0, 0)], "red", [(1, 0, 0, 2)], None])
def test_a_palette_that_the_font_does_not_have(palette):
    with pytest.raises(vf.TextError, match="palette"):
        text().to_svg(palette=palette)


def test_a_palette_needs_a_text():
    with pytest.raises(vf.ImageError, match="A palette needs a Text"):
        vf.rasterize(text().segments(), (9, 9), palette=0)


def test_a_gradient_goes_on_beyond_its_stops():
    *_, line = (layer.paint.at(np.zeros(2)) for layer in text().glyphs[0].layers)
    assert (line.kind, line.extend) == ("sweep", "repeat")
    # The stops at a quarter and three quarters of 30 … 200 degrees are 0 and 1 now.
    np.testing.assert_allclose(line.geometry[2:], [72.5, 157.5], rtol=1e-4)
    ramp = line.colours([(0, 0, 0, 1), (1, 1, 1, 1)])
    t = line.sweep(np.array([72.51, 115, 72.5 + 85 * 1.25]))
    np.testing.assert_allclose(line.between_stops(t, ramp)[:, 0], [0, 0.5, 0.25], atol=1e-3)


def test_a_text_of_a_colour_font_with_axes_that_move_others_is_drawn():
    font = vf.load_font(colour_fonts.coloured(variation_tables.add_avar_2))
    w = np.array([0.6, 0.5])
    inner = to_array(font.final_coordinates(w))
    ours, plain = font.glyph("a").layers, vf.load_font(colour_fonts.coloured()).glyph("a").layers
    assert len(ours) == len(plain) == 5
    for layer, other in zip(ours, plain, strict=True):
        assert np.allclose(layer.paint.frame.value(w), other.paint.frame.value(inner))
        assert np.allclose(layer.paint.numbers.value(w), other.paint.numbers.value(inner))
