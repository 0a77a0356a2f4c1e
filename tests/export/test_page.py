"""The exported page shows the state of the editor, and text from a font is never markup."""

from __future__ import annotations

import base64
import json
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest
from fontTools.ttLib import TTFont

import vfwidget as vf
from vfwidget.export.page import STATE, page, view
from vfwidget.view.word import describe_word

HOSTILE = "</script></title><!--<script>alert(1)</script><img src=x onerror=alert(2)>&lt;"


class Page(HTMLParser):
    """Elements in order, and the text of each."""

    def __init__(self, source: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.texts: list[str] = []
        self.feed(source)
        self.close()

    def handle_starttag(self, tag: str, attributes: Any) -> None:
        self.elements.append((tag, dict(attributes)))
        self.texts.append("")

    def handle_data(self, data: str) -> None:
        if self.texts:
            self.texts[-1] += data

    @property
    def tags(self) -> list[str]:
        return [tag for tag, _ in self.elements]

    def states(self) -> list[Any]:
        found = zip(self.elements, self.texts, strict=True)
        return [json.loads(text) for (_, with_), text in found if with_.get("type") == STATE]


def binary(value: Any) -> Any:
    """Base64, where the widget has bytes, as bytes."""
    if isinstance(value, dict):
        return {
            key: base64.b64decode(inner)
            if key in ("points", "data") and isinstance(inner, str)
            else binary(inner)
            for key, inner in value.items()
        }
    return [binary(inner) for inner in value] if isinstance(value, list) else value


@pytest.mark.parametrize("shared", [True, False])
def test_the_state_of_the_editor_is_on_the_page(shared: bool) -> None:
    axes = {"wght": 620, "wdth": 90} if shared else [{"wght": 620}, {"wdth": 80}]
    editor = vf.Editor("dynapuff", "hi", axes=axes, shared=shared)
    (state,) = Page(editor.to_html()).states()
    assert binary(state["_word"]) == describe_word(editor.text)
    assert (state["axes"], state["shared"]) == (editor.axes, shared)


def test_the_page_is_as_of_now() -> None:
    editor = vf.Editor("dynapuff", "hi")
    editor.axes = {"wght": 650}
    assert Page(editor.to_html()).states()[0]["axes"]["wght"] == 650
    editor.text = vf.Text("dynapuff", "ho")
    assert Page(editor.to_html()).states()[0]["_word"]["string"] == "ho"


def test_a_path_is_written(tmp_path: Path) -> None:
    editor = vf.Editor("dynapuff", "hi")
    assert editor.to_html(tmp_path / "page.html") is None
    assert (tmp_path / "page.html").read_text(encoding="utf-8") == editor.to_html()


def test_nothing_is_fetched() -> None:
    made = Page(vf.Editor("dynapuff", "hi").to_html())
    assert made.tags == [
        *("html", "head", "meta", "meta", "meta", "title", "style", "script", "body", "script"),
    ]
    assert not any({"src", "href"} & set(attributes) for _, attributes in made.elements)
    (policy,) = [a["content"] for _, a in made.elements if "http-equiv" in a]
    assert policy and policy.startswith("default-src 'none'; ")


def test_hostile_names_are_inert() -> None:
    source = Path(vf.__file__).parent / "fonts" / "dynapuff.woff2"
    font = TTFont(source)
    for record in font["name"].names:
        record.string = HOSTILE
    made = Page(vf.Editor(vf.load_font(font), "hi<&").to_html())
    plain = Page(vf.Editor("dynapuff", "hi<&").to_html())
    assert made.tags == plain.tags
    assert made.texts[made.tags.index("title")].strip() == f"hi<& in {HOSTILE}"
    (state,) = made.states()
    assert state["_word"]["family"] == HOSTILE
    assert {axis["name"] for axis in state["_word"]["axes"]} == {HOSTILE}


def test_several_views_share_a_page() -> None:
    body = f"<h1>Two</h1>{view({'n': 1})}<p>{view({'n': HOSTILE, 'data': b'<&>'})}</p>"
    made = Page(page("Two", body, ["export const mount = () => {}; // </script>"], "p {}"))
    assert [state["n"] for state in made.states()] == [1, HOSTILE]
    assert made.tags.count("script") == 3
