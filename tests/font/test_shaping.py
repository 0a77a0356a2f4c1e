"""Shaping at a location, with features, language, script and direction; HarfBuzz as referee."""

from __future__ import annotations

import sys
from itertools import product
from string import ascii_uppercase
from types import FrameType

import fonts
import numpy as np
import pytest
import uharfbuzz as hb
from fontTools.ttLib.tables._n_a_m_e import _WINDOWS_LANGUAGES

import vfwidget as vf
from vfwidget.errors import GlyphError, TextError


def names(font: vf.Font, string: str, w=None, **options) -> list[str]:
    w = np.zeros(len(font.axes)) if w is None else np.asarray(w)
    row = font.shape_at(string, w, font.shaping_options(**options), lambda _: 0.0)
    return [font.glyph_names[g] for g in row.glyph_ids]


def hebrew_and_latin(features: str = "") -> vf.Font:
    letters = {0x5D0: "alef", 0x5D1: "bet", 0x28: "left", 0x29: "right", 0x20: "space"}
    letters |= {ord(c): c for c in "ab12"}
    glyphs = {name: fonts.outline(fonts.SQUARE) for name in [*letters.values(), "a.alt"]}

    def edit(builder) -> None:
        builder.setupCharacterMap(letters)
        if features:
            builder.addOpenTypeFeatures(features)

    return vf.load_font(fonts.build(glyphs, {}, edit=edit))


def test_glyphs_depend_on_the_location() -> None:
    font = vf.load_font("recursive")
    assert names(font, "k") == ["k"]
    place = font.normalize({"CRSV": 1.0}).numpy()
    assert names(font, "k", place) == ["k.italic"]


def test_positions_are_not_rounded() -> None:
    font = vf.load_font("recursive")
    options = font.shaping_options()
    row = font.shape_at("ab", np.zeros(5), options, lambda g: 500.25 + g / 1024)
    assert row.positions[:, 0].tolist() == [500.25 + g / 1024 for g in row.glyph_ids]


def test_features_are_switched_on_and_off() -> None:
    font = vf.load_font("roboto-flex")
    assert names(font, "afi") == ["uni0061", "uniFB01"]
    for off in (False, 0, np.False_, np.int64(0)):
        parted = names(font, "afi", features={"liga": off})
        assert parted == ["uni0061", "uni0066", "uni0069"]


def test_language_and_script_choose_lookups() -> None:
    font = hebrew_and_latin(
        """
        languagesystem DFLT dflt; languagesystem latn dflt; languagesystem latn SRB;
        languagesystem hebr dflt; feature ccmp { sub b by b; } ccmp;
        feature locl { script latn; language SRB; sub a by a.alt; } locl;
        """
    )
    assert names(font, "a") == ["a"]
    assert names(font, "a", language="sr") == ["a.alt"]
    assert names(font, "a", language="sr", script="Hebr") == ["a"]


def test_each_script_of_a_line_is_shaped_by_its_own_rules() -> None:
    """A vowel that follows its consonant in the string stands before it on the line."""
    letters = {0x915: "ka", 0x93F: "i", 0x20: "space", 0x627: "alif", 0x628: "beh", 0x5D0: "alef"}
    letters |= {ord("a"): "a", ord("b"): "b", 0x412: "ve"}
    glyphs = {name: fonts.outline(fonts.SQUARE) for name in [*letters.values(), "beh.init"]}

    def edit(builder) -> None:
        builder.setupCharacterMap(letters)
        builder.addOpenTypeFeatures(
            """
            languagesystem DFLT dflt; languagesystem dev2 dflt; languagesystem arab dflt;
            feature ccmp { sub b by b; } ccmp;
            feature init { script arab; sub beh by beh.init; } init;
            feature kern { pos b ve -50; } kern;
            """
        )

    font = vf.load_font(fonts.build(glyphs, {}, edit=edit))
    assert names(font, "\u0915\u093f") == ["i", "ka"]
    assert names(font, "ab \u0915\u093f") == ["a", "b", "space", "i", "ka"]
    assert names(font, "\u0915\u093f ab\u0915\u093f") == ["i", "ka", "space", "a", "b", "i", "ka"]
    assert names(font, "ab \u0915\u093f", script="Latn")[3:] == ["ka", "i"]
    # Two scripts from right to left, in one run of direction.
    arabic = ["alif", "beh.init"]
    assert names(font, "\u05d0 \u0628\u0627") == [*arabic, "space", "alef"]
    assert names(font, "\u0628\u0627 \u05d0") == ["alef", "space", *arabic]
    # Scripts of the same rules are kerned with each other, as in hb-shape.
    row = font.shape_at("b\u0412", np.zeros(2), font.shaping_options(), lambda _: 600.0)
    assert row.positions[:, 0].tolist() == [550, 600]


def test_the_language_of_the_machine_has_no_effect(monkeypatch: pytest.MonkeyPatch) -> None:
    font = hebrew_and_latin("feature locl { script latn; language SRB; sub a by a.alt; } locl;")
    monkeypatch.setenv("LC_ALL", "sr_RS.UTF-8")
    assert names(font, "a") == ["a"]


def test_mixed_directions_stand_in_the_order_of_reading() -> None:
    font = hebrew_and_latin()
    assert names(font, "\u05d0\u05d1 12") == ["1", "2", "space", "bet", "alef"]
    assert names(font, "ab \u05d0\u05d1") == ["a", "b", "space", "bet", "alef"]
    # In a run from right to left brackets are mirrored.
    assert names(font, "(\u05d0)") == ["left", "alef", "right"]
    assert names(font, "a \u05d0", direction="rtl") == ["alef", "space", "a"]


def test_clusters_and_lines_count_through_the_string() -> None:
    font = hebrew_and_latin()
    row = font.shape_at("ab\n\n\u05d0\u05d1a", np.zeros(2), font.shaping_options(), lambda _: 0.0)
    assert row.clusters == (0, 1, 6, 5, 4)
    assert row.lines == (0, 0, 2, 2, 2)
    assert row.rtl == (False, False, False, True, True)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"features": {"kren": True}}, "no feature 'kren'. It has: .*kern"),
        ({"features": {1: True}}, "no feature 1"),
        ({"features": ["kern"]}, "must be a mapping .* received"),
        ({"features": {"kern": "off"}}, "'kern' must be on, off or a number; received 'off'"),
        ({"features": {"kern": -1}}, "received -1"),
        ({"features": {"kern": 2**32}}, "received 4294967296"),
        ({"features": {"kern": 10**30}}, "received 1000000"),
        ({"features": {"kern": float("nan")}}, "received nan"),
        ({"script": "Latin"}, "ISO 15924 .* received 'Latin'"),
        ({"script": 7}, "received 7"),
        ({"language": "English"}, "BCP 47 .* received 'English'"),
        ({"language": "qq"}, "received 'qq'"),
        ({"language": "xyz"}, "registered codes.* received 'xyz'.* write 'x-'"),
        ({"language": "en-Latm"}, "received 'en-Latm'"),
        ({"language": "en-AB"}, "received 'en-AB'"),
        ({"language": "zh-xyz"}, "received 'zh-xyz'"),
        ({"language": "de-2025"}, "received 'de-2025'"),
        ({"language": "en_US"}, "received 'en_US'"),
        ({"language": ""}, "received ''"),
        ({"language": "en-x-"}, "received 'en-x-'"),
        ({"language": "en us"}, "received 'en us'"),
        ({"language": 3}, "received 3"),
        ({"direction": "ttb"}, "'ltr' or 'rtl'; received 'ttb'"),
    ],
)
def test_wrong_options_are_refused(options: dict, message: str) -> None:
    with pytest.raises(TextError, match=message):
        vf.load_font("recursive").shaping_options(**options)


@pytest.mark.parametrize(
    "language",
    "en EN-us sr-Latn zh-Hant-HK zh-yue es-419 de-1996 sl-rozaj ckb hbs urd und i-klingon "
    "ar-u-nu-arab x-hbsc en-x-hbotABCD qaa qtz-Latn qaa-Qaaa-QM-x-mine".split(),
)
def test_language_tags_of_every_form_are_taken(language: str) -> None:
    assert names(vf.load_font("recursive"), "a", language=language) == ["a"]


def test_languages_that_fonttools_and_harfbuzz_name_are_taken() -> None:
    font = vf.load_font("recursive")
    tags = (a + b + c + " " for a, b, c in product("ADKMSTZ", "AEIMRU", ascii_uppercase))
    of_harfbuzz = {hb.ot_tag_to_language(tag) for tag in tags}
    # HarfBuzz writes a tag that it has no language for in this way.
    known = {language for language in of_harfbuzz if "x-hbot" not in language}
    known |= set(_WINDOWS_LANGUAGES.values())
    assert len(known) > 250
    assert [font.shaping_options(language=name).language for name in known] == list(known)


def test_bad_strings_are_refused() -> None:
    font = vf.load_font("recursive")
    for string in ("", "\n", "\u200b"):
        with pytest.raises(TextError, match="no visible character"):
            names(font, string)
    with pytest.raises(TextError, match="must be a string; received bytes"):
        vf.Text(font, b"ab")
    with pytest.raises(GlyphError, match=r"'\\t' \(U\+0009\)"):
        names(font, "a\tb")
    with pytest.raises(GlyphError, match=r"U\+D800"):
        names(hebrew_and_latin(), "\u05d0\ud800")


def test_every_character_of_the_bundled_fonts_as_hb_shape() -> None:
    """One long line of all characters of a direction, kerned, against a plain HarfBuzz font."""
    for name in vf.bundled_fonts():
        font = vf.load_font(name)
        string = "".join(chr(c) for c in sorted(font._cmap) if chr(c) not in "\r\n")
        row = font.shape_at(string, np.zeros(len(font.axes)), font.shaping_options(), lambda _: 0.0)
        buffer = hb.Buffer()
        buffer.cluster_level = hb.BufferClusterLevel.MONOTONE_CHARACTERS
        buffer.add_str(string)
        buffer.flags = hb.BufferFlags.REMOVE_DEFAULT_IGNORABLES
        buffer.script, buffer.direction, buffer.language = "Latn", "ltr", "und"
        face = hb.Face.create_for_tables(
            lambda _f, tag, tables: tables.get(tag, b""), font._shaper._tables
        )
        hb.shape(hb.Font(face), buffer)
        assert row.glyph_ids == tuple(info.codepoint for info in buffer.glyph_infos)


@pytest.mark.parametrize("function", ["_tell_advance", "_table"])
def test_an_interrupt_in_a_function_that_harfbuzz_calls_is_raised(function: str) -> None:
    font = vf.load_font("dynapuff")

    def trace(frame: FrameType, event: str, _: object) -> None:
        # At the call itself, where no code of the function can catch it.
        if event == "call" and frame.f_code.co_name == function:
            raise KeyboardInterrupt

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        with pytest.raises(KeyboardInterrupt):
            vf.Text(font, "Sa")
    finally:
        sys.settrace(before)
    wanted = vf.Text("dynapuff", "Sa").layout
    assert [glyph.x for glyph in vf.Text(font, "Sa").layout] == [glyph.x for glyph in wanted]
