"""Fonts as objects: copies and pickles, threads, instances."""

from __future__ import annotations

import copy
import pickle
from concurrent.futures import ThreadPoolExecutor

import fonts
import numpy as np
import pytest
import torch

import vfwidget as vf
from vfwidget.font.cache import GlyphCache
from vfwidget.font.glyf import GlyfReader
from vfwidget.font.source import open_font


def test_a_font_is_pickled_by_its_file_and_once():
    font = vf.load_font("dynapuff")
    font.glyph("a")
    data = pickle.dumps([font, font])
    one, other = pickle.loads(data)
    assert one is other
    assert len(data) < len(pickle.dumps(font)) + 100
    w = [0.25, -0.5]
    assert torch.equal(one.glyph("a").points(w), font.glyph("a").points(w))


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy])
def test_a_copy_of_a_font_is_the_font_itself(copied):
    font = vf.load_font("dynapuff")
    assert copied(font) is font


def test_a_font_stays_as_it_was_when_the_open_font_it_came_from_is_edited():
    opened = open_font("dynapuff")
    font = vf.load_font(opened)
    opened["hmtx"]["a"] = (5000, 0)
    del opened["gvar"].variations["a"]
    fresh = vf.load_font("dynapuff").glyph("a")
    assert torch.equal(font.glyph("a").points([1, 1]), fresh.points([1, 1]))
    assert opened.flavor == "woff2"


def test_an_open_font_is_read_as_it_was_edited():
    opened = fonts.open_font(fonts.phantom_points())
    opened["hmtx"]["c"] = (123, -20)
    assert vf.load_font(opened).glyph("c").advance([0, 0]).item() == 123


def test_an_open_font_that_cannot_be_saved():
    opened = fonts.open_font(fonts.phantom_points())
    opened["head"].unitsPerEm = "many"
    with pytest.raises(vf.FontError, match="The open font cannot be saved"):
        vf.load_font(opened)


def test_an_iterator_that_is_not_at_its_end_keeps_no_thread_waiting():
    font = vf.load_font("dynapuff")
    glyphs = iter(font)
    first = next(glyphs)
    pool = ThreadPoolExecutor(1)
    try:
        found = pool.submit(font.glyph, "a").result(timeout=20)
    finally:
        glyphs.close()
        pool.shutdown()
    assert (first.name, found.name) == (".notdef", "a")


def test_threads_may_read_one_font():
    want = vf.load_font("dynapuff")
    names = want.glyph_names[:200]
    font = vf.load_font("dynapuff")
    with ThreadPoolExecutor(8) as pool:
        rows = [pool.map(font.glyph, names) for _ in range(8)]
        for row in rows:
            for name, glyph in zip(names, row, strict=True):
                assert torch.equal(glyph.default, want.glyph(name).default)


def test_an_instance_is_a_location():
    font = vf.load_font("recursive")
    bold = next(instance for instance in font.instances if "Bold" in instance.name)
    assert torch.equal(font.normalize(bold), font.normalize(bold.axes))


def test_an_instance_of_another_font_is_refused():
    foreign = vf.load_font("recursive").instances[0]
    with pytest.raises(vf.AxisError, match="is an instance of another font; this font has"):
        vf.load_font("dynapuff").normalize(foreign)


def test_a_font_walks_its_glyphs_in_order():
    font = vf.load_font("dynapuff")
    assert [glyph.name for glyph in font] == list(font.glyph_names)
    assert len(font) == len(font.glyph_names)
    assert "a" in font and 0 in font and "no-such-glyph" not in font and None not in font


def test_the_glyphs_that_a_font_keeps_are_bounded(monkeypatch):
    font = vf.load_font("recursive")
    held = font.glyph("a")
    assert font.glyph("a") is held
    monkeypatch.setattr(vf.limits, "glyph_cache_bytes", 4 * held.nbytes)
    names = font.glyph_names[:40]
    kept = {name: font.glyph(name) for name in names}
    again = [font.glyph(name) is kept[name] for name in reversed(names)]
    assert again[0] and not all(again)
    assert font._glyphs._bytes == sum(glyph.nbytes for glyph in font._glyphs._items.values())
    assert torch.equal(font.glyph("a").deltas, held.deltas)


def test_a_walk_over_all_glyphs_that_takes_long_shows_its_progress(monkeypatch, capsys):
    font = vf.load_font(fonts.build(*fonts.base_glyphs()))
    assert len(list(font)) == 3
    assert capsys.readouterr().err == ""
    monkeypatch.setattr("vfwidget.font.font.PROGRESS_SECONDS", 0)
    assert len(list(font)) == 3
    assert "glyphs" in capsys.readouterr().err


def test_a_component_of_several_glyphs_is_read_once(monkeypatch):
    read = []
    one = GlyfReader._read_simple

    def noted(reader, name, glyph):
        read.append(name)
        return one(reader, name, glyph)

    monkeypatch.setattr(GlyfReader, "_read_simple", noted)
    glyphs, deltas = fonts.base_glyphs()
    glyphs |= {name: fonts.composite(fonts.component("a", 10, 20)) for name in "cd"}
    font = vf.load_font(fonts.build(glyphs, deltas))
    read.clear()
    for name in "cdcd":
        font.glyph(name).points([0.5, 0])
    assert read == ["a"]


def test_the_memory_for_components_is_bounded(monkeypatch):
    monkeypatch.setattr(vf.limits, "glyph_cache_bytes", 8 * 1000)
    cache = GlyphCache(1 / 8)
    for name in "abcdef":
        cache.add(name, np.zeros(50))
    assert [name for name in "abcdef" if cache.get(name) is not None] == ["e", "f"]
