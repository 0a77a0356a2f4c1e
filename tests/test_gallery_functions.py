"""How the gallery converts equations and cells, without a browser."""

from __future__ import annotations

import importlib.util
import re
from html import unescape
from pathlib import Path
from types import ModuleType

import pytest
from nbformat.v4 import new_code_cell, new_notebook, new_output


@pytest.fixture(scope="module")
def gallery() -> ModuleType:
    path = Path(__file__).parents[1] / "docs" / "gallery.py"
    spec = importlib.util.spec_from_file_location("gallery", path)
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def read(html: str) -> str:
    return unescape(re.sub(r"<[^>]*>", "", html))


@pytest.mark.parametrize("spacing", ["[2ex]", "[0.5ex]", " [-2pt]"])
def test_spacing_after_a_row_is_not_shown(gallery: ModuleType, spacing: str) -> None:
    rows = r"$$\begin{cases} 1 & x = 0 \\SPACING 0 & x > 0 \end{cases}$$"
    with_it, without = (gallery.render(rows.replace("SPACING", s)) for s in (spacing, ""))
    assert with_it == without and "<mtable" in with_it


def test_a_row_may_start_with_a_bracket(gallery: ModuleType) -> None:
    shown = read(gallery.render(r"$$\begin{matrix} 0, 1 \\ [2, 3] \end{matrix}$$"))
    assert "0,1" in shown and "[2,3]" in shown


def test_a_tag_stands_apart_in_brackets(gallery: ModuleType) -> None:
    html = gallery.render("$$x = y \\tag{Eq. 2}$$\n\n\\begin{equation}x\\tag{3}\\end{equation}")
    assert read(html).count("tag") == 0
    assert re.search(r"<mspace[^>]*><mtext>\(Eq.&#x000A0;2\)</mtext>", html)
    assert "<mtext>(3)</mtext>" in html


def test_source_that_a_notebook_hides_is_folded(gallery: ModuleType) -> None:
    printed = new_output("stream", name="stdout", text="answers checked")
    cells = [
        new_code_cell("shown = 1"),
        new_code_cell(
            "hidden = 1", outputs=[printed], metadata={"jupyter": {"source_hidden": True}}
        ),
    ]
    body = gallery.body_of(new_notebook(cells=cells))
    folded = re.findall(r"<details><summary>Answer code</summary>(.*?)</details>", body, re.S)
    assert [re.sub(r"\s+", " ", read(source)).strip() for source in folded] == ["hidden = 1"]
    outside = read(body.replace(folded[0], ""))
    assert "shown = 1" in outside and "answers checked" in outside
