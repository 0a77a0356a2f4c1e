"""Features of some characters only; HarfBuzz with the same ranges as referee."""

from __future__ import annotations

import pickle
import random

import fonts
import numpy as np
import pytest
import registry_fonts
import uharfbuzz as hb
from layout_table import difference, locations, setters

import vfwidget as vf
from vfwidget.errors import TextError

ALEF, BET = "\u05d0", "\u05d1"
FEATURES = """
languagesystem DFLT dflt; languagesystem latn dflt; languagesystem hebr dflt;
feature aalt { sub a from [a.alt a.two]; sub alef from [alef.alt a.two]; } aalt;
feature liga { sub a b by a_b; sub alef bet by a_b; } liga;
feature kern { pos a a -50; pos alef alef -70; pos [a.alt a.two] a 30; } kern;
"""


def two_scripts() -> bytes:
    """Latin and Hebrew letters with alternates, ligatures and kerning."""
    letters = {ord("a"): "a", ord("b"): "b", ord(ALEF): "alef", ord(BET): "bet"}
    names = [*letters.values(), "a.alt", "a.two", "alef.alt", "a_b"]
    advances = {name: (400 + 40 * i, 100) for i, name in enumerate(names)}

    def edit(builder) -> None:
        builder.setupCharacterMap(letters)
        builder.addOpenTypeFeatures(FEATURES)

    glyphs = {name: fonts.outline(fonts.SQUARE) for name in names}
    return fonts.build(glyphs, {}, edit=edit, metrics=advances)


def harfbuzz(data: bytes, lines: list[list[str]], features: dict) -> list[tuple]:
    """Glyph id, cluster, x and y of a text that is cut into lines and runs of one direction.

    The runs of each line follow one another from left to right.
    """
    font = hb.Font(hb.Face(data))
    string = "\n".join(map("".join, lines))
    found, start = [], 0
    for number, runs in enumerate(lines):
        pen = 0
        for run in runs:
            buffer = hb.Buffer()
            buffer.add_str(string, start, len(run))
            buffer.guess_segment_properties()
            hb.shape(font, buffer, features)
            for info, p in zip(buffer.glyph_infos, buffer.glyph_positions, strict=True):
                found.append((info.codepoint, info.cluster, pen + p.x_offset, -1000 * number))
                pen += p.x_advance
            start += len(run)
        start += 1
    return found


def random_features(tags: list[str], length: int, rng: random.Random) -> dict:
    """Ranges in both forms, some of which overlap, are empty or go beyond the end."""

    def bounds() -> list[int]:
        return sorted(rng.randrange(length + 3) for _ in range(2))

    features: dict = {rng.choice(tags): rng.choice([0, 1])} if rng.random() < 0.3 else {}
    for tag in rng.sample(tags, 2):
        start, end = bounds()
        features[f"{tag}[{start}:{end}]"] = rng.choice([0, 1, 2, True, False])
    features[rng.choice(tags)] = [(*bounds(), rng.choice([0, 1, 2])) for _ in range(3)]
    return features


def test_ranges_count_through_lines_and_runs() -> None:
    data, rng, changed = two_scripts(), random.Random(0), set()
    for _ in range(200):
        lines = [
            [
                "".join(rng.choices(letters, k=rng.randrange(1, 5)))
                for letters in ("ab", ALEF + BET, "aab")[: rng.randrange(1, 4)]
            ]
            for _ in range(rng.randrange(1, 4))
        ]
        string = "\n".join(map("".join, lines))
        features = random_features(["aalt", "liga", "kern"], len(string), rng)
        text = vf.Text(data, string, features=features, direction="ltr")
        found = [(r.glyph_id, r.cluster, r.x, r.y) for r in text.layout]
        assert found == harfbuzz(data, lines, features), (string, features)
        changed.add(found == harfbuzz(data, lines, {}))
    assert changed == {True, False}


@pytest.mark.parametrize("name", vf.bundled_fonts())
def test_random_ranges_as_harfbuzz_sets_them(name: str) -> None:
    check_random_ranges(name, ["office", "AVATAR fig", "e\u0301x\u0301 0,1/2", "T.V. LT\u00ddo"], 5)


@pytest.mark.slow
@pytest.mark.parametrize("file", registry_fonts.FILES)
def test_random_ranges_in_every_script(file: str) -> None:
    check_random_ranges(str(registry_fonts.path(file)), registry_fonts.words(file), 1)


def check_random_ranges(name: str, words: list[str], times: int) -> None:
    font, setter = setters(name)
    rng = random.Random(1)
    tags = sorted(font._shaper.features | {"kern", "liga", "mark"})
    for word in words * times:
        features = random_features(tags, len(word), rng)
        text = vf.Text(font, word, features=features)
        for w in locations(font, 3):
            assert difference(text.at(theta=w), setter.line(word, w, features)) < 0.02, features


@pytest.mark.parametrize(
    "features",
    [
        {"liga[1:3]": False},
        {"liga[2]": 0},
        {"liga[:3]": 0},
        {"liga[1:]": np.False_},
        {"liga": [(1, 3, False)]},
        {"liga": ((np.int64(2), np.int64(9), 0),)},
        {"liga": 1, "liga[2:3]": 0},
        {"liga": [(0, 6, 0), (3, 6, 1)]},
    ],
    ids=str,
)
def test_every_form_of_a_range_parts_a_ligature(features: dict) -> None:
    text = vf.Text("roboto-flex", "office", features=features)
    assert [record.cluster for record in text.layout] == [0, 1, 2, 3, 4, 5]


@pytest.mark.parametrize("key", ["liga[]", "liga[:]", "liga[0:]", "liga[:6]"])
def test_a_range_of_the_whole_text_is_the_whole_text(key: str) -> None:
    part, whole = (vf.Text("roboto-flex", "office", features={k: 0}) for k in (key, "liga"))
    assert [r.glyph_id for r in part.layout] == [r.glyph_id for r in whole.layout]
    if key != "liga[:6]":
        assert part.to_css() == whole.to_css()


def test_a_range_may_end_within_a_grapheme() -> None:
    """A feature of a mark alone, with tracking, which counts graphemes."""
    features = {"mark[1]": 0, "mark[3]": 0}
    word = "a\u0323b\u0323\u0301c"
    text = vf.Text("recursive", word, features=features, tracking=100)
    plain = vf.Text("recursive", word, tracking=100)
    assert [r.glyph_id for r in text.layout] == [r.glyph_id for r in plain.layout]
    assert text.advance() == plain.advance()
    expected = setters("recursive")[1].line(word, np.zeros(5), features)
    assert difference(text.at(tracking=0), expected) < 0.02


def test_ranges_go_along_with_the_text() -> None:
    features = {"liga[1:3]": False, "liga": [(8, 10, 0)]}
    text = vf.Text("roboto-flex", "office office", features=features)
    wanted = [r.cluster for r in text.layout]
    features.clear()
    for other in (
        text.at({"wght": 900}),
        text.at(shared=False),
        pickle.loads(pickle.dumps(text)),
        vf.Text("roboto-flex", text.string, features=text.composition.options.feature_values),
    ):
        assert other.composition.options == text.composition.options
        assert [r.cluster for r in other.layout] == wanted


def test_css_of_one_element_has_no_ranges() -> None:
    text = vf.Text("roboto-flex", "office", features={"liga[1:3]": False, "kern": False})
    with pytest.raises(TextError, match=r"part of its characters: liga\[1:3\]\. Make a text"):
        text.to_css()


def test_each_element_of_an_animation_has_its_own_features() -> None:
    text = vf.Text("recursive", "000", features={"dnom[1]": True, "kern": False})
    bold = text.at({"wght": 900})
    assert len({glyph.glyph_id for glyph in text.layout}) == 2
    page = vf.Animation.from_keyframes([(0, text), (1, bold)]).to_css()
    own = [rule for rule in page.splitlines() if ":nth-child" in rule]
    assert ['"kern" 0, "dnom" 1' in rule for rule in own] == [False, True, False]


@pytest.mark.parametrize(
    ("features", "message"),
    [
        ({"kren[1:3]": 1}, r"no feature 'kren'\. It has"),
        ({"kern[1-3]": 1}, r"no feature 'kern\[1-3\]'\. Write a range .* 'kern\[1:3\]'"),
        ({"kern[-1:3]": 1}, r"Write a range"),
        ({"kern[1:3]=0": 1}, r"Write a range"),
        ({"kern[3:1]": 1}, r"'kern' goes from one .* later one.* received \(3, 1\)"),
        ({"kern": [(3, 1, 0)]}, r"received \(3, 1\)"),
        ({"kern": [(-1, 1, 0)]}, r"received \(-1, 1\)"),
        ({"kern": [(0.5, 1, 0)]}, r"received \(0.5, 1\)"),
        ({"kern": [(False, True, 0)]}, r"received \(False, True\)"),
        ({"kern": [(0, None, 0)]}, r"received \(0, None\)"),
        ({"kern": [(0, 1)]}, r"must be \(start, end, value\).* received \(0, 1\)"),
        ({"kern": (0, 1, 0)}, r"must be \(start, end, value\).* received 0"),
        ({"kern": ["abc", 1]}, r"received 'abc'"),
        ({"kern": [(0, 1, -1)]}, r"must be on, off or a number; received -1"),
        ({"kern[0:1]": "off"}, r"received 'off'"),
        ({"kern[0:1]": [(0, 1, 1)]}, r"range in its key .* Write \{'kern': \[\(0, 1, 1\)\]\}"),
    ],
    ids=str,
)
def test_wrong_ranges_are_refused(features: dict, message: str) -> None:
    with pytest.raises(TextError, match=message):
        vf.Text("recursive", "abc", features=features)
