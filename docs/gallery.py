"""Run notebooks and render them as pages that need no kernel: ``python docs/gallery.py site``.

The editors and players work on their pages. Outputs that need a kernel are shown as they were after
the run. A page loads nothing from the network, because equations are MathML, and figures and views
are part of the page.
"""

from __future__ import annotations

import argparse
import re
import shutil
import time
from collections.abc import Iterator, Sequence
from html import escape
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import nbformat
from jinja2 import pass_context
from latex2mathml.converter import convert
from nbclient import NotebookClient
from nbconvert import HTMLExporter
from nbconvert.filters.markdown_mistune import IPythonRenderer, MarkdownWithMath
from nbformat import NotebookNode
from nbformat.v4 import new_output
from pygments.formatters import HtmlFormatter
from traitlets.config import Config

from vfwidget.export.page import STATE as EDITOR
from vfwidget.export.page import page, view
from vfwidget.view import player
from vfwidget.view.bundle import built
from vfwidget.view.editor import Editor
from vfwidget.view.exports import PAGE_TRAITS
from vfwidget.view.player import Player
from vfwidget.view.snapshot import SNAPSHOT

ROOT = Path(__file__).parents[1]
STYLE = Path(__file__).with_suffix(".css").read_text(encoding="utf-8")
SECONDS = 90
"""Time limit of a cell; a whole notebook takes less."""
WIDGET_VIEW = "application/vnd.jupyter.widget-view+json"
WIDGET_STATE = "application/vnd.jupyter.widget-state+json"


def _name(widget: type) -> str:
    return f"{widget.__module__}.{widget.__qualname__}"


VIEWS = {_name(Editor): (EDITOR, PAGE_TRAITS), _name(Player): (player.STATE, player.PAGE_TRAITS)}
"""The kind of view and its traits for each widget that works on a page."""


def run(path: Path) -> NotebookNode:
    """Run a notebook and return it with its outputs; its metadata hold the state of its widgets."""
    notebook = nbformat.read(path, as_version=4)
    with TemporaryDirectory() as folder:
        resources = {"metadata": {"path": folder}}
        config = sockets_in(folder)
        NotebookClient(notebook, timeout=SECONDS, resources=resources, config=config).execute()
    return notebook


def sockets_in(folder: str) -> Config:
    """Let a kernel be reached by sockets in a folder.

    By default it chooses free ports, which another process may take before it does.
    """
    return Config(KernelManager={"transport": "ipc", "ip": f"{folder}/kernel"})


def mathml(latex: str, display: str = "inline") -> str:
    """Convert an equation; row spacing and tags, which latex2mathml cannot read, are replaced."""
    latex = re.sub(r"(\\\\)\s*\[\s*-?[\d.]+\s*[a-z]{2}\s*\]", r"\1 ", latex)
    latex = re.sub(r"\\tag\s*\{([^{}]*)\}", r"\\qquad\\text{(\1)}", latex)
    return convert(latex, display=display)


class Markdown(IPythonRenderer):
    """Renders Markdown with equations as MathML, and links to notebooks as links to their pages."""

    def block_math(self, body: str) -> str:
        return mathml(body, "block")

    def inline_math(self, body: str) -> str:
        return mathml(body)

    def latex_environment(self, name: str, body: str) -> str:
        return mathml(f"\\begin{{{name}}}{body}\\end{{{name}}}", "block")

    def link(self, text: str, url: str, title: str | None = None) -> str:
        return super().link(text, re.sub(r"^([\w./-]+)\.ipynb\b", r"\1.html", url), title)


def render(markdown: str, attachments: Any = None) -> str:
    renderer = Markdown(escape=False, attachments=attachments)
    return str(MarkdownWithMath(renderer=renderer).render(markdown))


TEMPLATE = """
{%- extends 'basic/index.html.j2' -%}
{% block input_group %}
{%- set folded = cell.metadata.get("jupyter", {}).get("source_hidden") -%}
{% if folded %}<details><summary>Answer code</summary>{% endif %}
{{ super() }}
{% if folded %}</details>{% endif %}
{% endblock input_group %}
"""


class Exporter(HTMLExporter):
    """Renders the body of a page with nbconvert's basic template and the renderer above.

    Cells whose source is hidden in the notebook are folded.
    """

    @pass_context
    def markdown2html(self, context: Any, source: str) -> str:
        return render(source, context.get("cell", {}).get("attachments"))


class Widgets:
    """Converts the widgets of a notebook that has run into outputs that need no kernel."""

    def __init__(self, notebook: NotebookNode) -> None:
        state = notebook.metadata.pop("widgets", {}).get(WIDGET_STATE, {})
        self.models: dict[str, Any] = state.get("state", {})
        for model in self.models.values():
            for buffer in model.get("buffers", []):
                *parents, last = buffer["path"]
                target = model["state"]
                for key in parents:
                    target = target[key]
                target[last] = buffer["data"]

    def settle(self, output: NotebookNode) -> Iterator[NotebookNode]:
        """Yield the outputs that replace one output."""
        data = output.get("data", {})
        if SNAPSHOT in data.get("text/html", ""):
            return  # the page has the live view
        if WIDGET_VIEW in data:
            yield from self.show(data[WIDGET_VIEW]["model_id"])
            return
        if "text/latex" in data and "text/html" not in data:
            output.data = NotebookNode({"text/markdown": data["text/latex"]})
        yield output

    def show(self, name: str) -> Iterator[NotebookNode]:
        """Yield a live view, the content of a box, the last picture of a widget, or a note."""
        model = self.models[name]
        state = model["state"]
        if state.get("_anywidget_id") in VIEWS:
            kind, traits = VIEWS[state["_anywidget_id"]]
            yield _html(view({trait: state[trait] for trait in traits}, kind))
        elif "children" in state:
            for child in state["children"]:
                yield from self.show(child.removeprefix("IPY_MODEL_"))
        elif "outputs" in state:
            for output in nbformat.from_dict(state["outputs"]):
                yield from self.settle(output)
        elif model["model_name"] == "ImageModel" and state["format"] in ("png", "jpeg"):
            yield new_output("display_data", {f"image/{state['format']}": state["value"]})
            yield _html('<p class="control">Drawing this again needs a kernel: open in Jupyter</p>')
        elif model["model_name"] in ("HTMLModel", "HTMLMathModel"):
            yield _html(state["value"])
        elif model["model_name"] == "LabelModel":
            yield _html(f"<p>{escape(state['value'])}</p>")
        else:
            yield _html(_placeholder(model["model_name"].removesuffix("Model"), state))


def _html(text: str) -> NotebookNode:
    return new_output("display_data", {"text/html": text})


def _placeholder(kind: str, state: dict[str, Any]) -> str:
    value = state.get("value")
    if "_options_labels" in state and state.get("index") is not None:
        value = state["_options_labels"][state["index"]]
    shown = "" if value is None else f" <b>{escape(str(value))}</b>"
    label = escape(state.get("description") or kind)
    return f'<p class="control">{label}{shown} <small>needs a kernel: open in Jupyter</small></p>'


def body_of(notebook: NotebookNode) -> str:
    widgets = Widgets(notebook)
    for cell in notebook.cells:
        if cell.cell_type == "code":
            cell.outputs = [new for old in cell.outputs for new in widgets.settle(old)]
    exporter = Exporter(
        raw_template=TEMPLATE, exclude_input_prompt=True, exclude_output_prompt=True
    )
    return str(exporter.from_notebook_node(notebook)[0])


def script(widget: type[Editor] | type[Player]) -> str:
    """The script that shows a widget on a page."""
    return built("page.js") if widget is Editor else str(widget._esm)


def write(path: Path, title: str, body: str) -> None:
    used = [Editor, Player] if player.STATE in body else [Editor]
    style = (
        "".join(widget._css for widget in used)
        + HtmlFormatter().get_style_defs(".highlight")
        + STYLE
    )
    path.write_text(page(title, body, [script(widget) for widget in used], style), encoding="utf-8")


def first_words(path: Path) -> tuple[str, str]:
    """Return the title of a notebook and its first paragraph."""
    source = nbformat.read(path, as_version=4).cells[0].source
    found = re.match(r"# (.+)\n*(.*)", source)
    return (re.sub(r"[`*$]", "", found[1]), found[2]) if found else (path.stem, "")


def build(target: Path, notebooks: Sequence[Path]) -> None:
    """Write a page for each notebook, in this order, and an index of the pages."""
    target.mkdir(parents=True, exist_ok=True)
    words = [first_words(path) for path in notebooks]
    links = [
        f'<a href="{path.stem}.html">{escape(title)}</a>'
        for path, (title, _) in zip(notebooks, words, strict=True)
    ]
    for i, path in enumerate(notebooks):
        began = time.perf_counter()
        before = f"<span>← {links[i - 1]}</span>" if i > 0 else "<span></span>"
        after = f"<span>{links[i + 1]} →</span>" if i + 1 < len(links) else "<span></span>"
        around = f'<nav>{before}<a href="index.html">All notebooks</a>{after}</nav>'
        note = (
            '<p class="note">Editors and players work on this page. To run code, open '
            f'<a href="{path.name}" download>the notebook</a> in Jupyter.</p>'
        )
        body = f"{around}\n{note}\n<main>{body_of(run(path))}</main>\n{around}"
        write(target / f"{path.stem}.html", words[i][0], body)
        shutil.copyfile(path, target / path.name)
        size = (target / f"{path.stem}.html").stat().st_size
        print(f"{path.stem}: {time.perf_counter() - began:.0f} s, {size / 1e6:.1f} MB", flush=True)
    entries = [
        f"<li>{link}{render(start)}</li>" for link, (_, start) in zip(links, words, strict=True)
    ]
    about = "Drag a letter of a variable font by its outline; vfwidget computes the axis values."
    index = f'<main class="index"><h1>vfwidget</h1><p>{about}</p><ol>{"".join(entries)}</ol></main>'
    write(target / "index.html", "vfwidget: the notebooks", index)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("target", type=Path, nargs="?", default=ROOT / "site")
    parser.add_argument("notebooks", type=Path, nargs="*")
    given = parser.parse_args()
    build(given.target, given.notebooks or sorted((ROOT / "notebooks").glob("*.ipynb")))


if __name__ == "__main__":
    main()
