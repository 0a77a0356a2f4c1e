"""A self-contained HTML page that shows views without a kernel and loads nothing.

The page contains the state of each view as JSON. The same JavaScript bundle that a notebook uses
reads the state and draws it. The view evaluates Eq. 1–3, so its sliders work.
"""

from __future__ import annotations

import base64
import html
import json
from collections.abc import Mapping, Sequence
from typing import Any

from .css import quoted

STATE = "application/vnd.vfwidget+json"

_PAGE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; {policy}">
<meta name="viewport" content="width=device-width">
<title>{title}</title>
<style>{style}</style>
{scripts}</head>
<body>
{body}
</body>
</html>
"""


_SCRIPT = """<script type="module">
import {{ mount }} from "data:text/javascript;base64,{script}";
mount();
</script>
"""
_SCRIPTED = (
    "script-src 'unsafe-inline' data:; style-src 'unsafe-inline'; img-src data:; media-src data:"
)
_STILL = "style-src 'unsafe-inline'; font-src data:"
"""What a page may use: nothing from elsewhere, and without a view no script at all."""


def view(state: Mapping[str, Any], kind: str = STATE) -> str:
    """Return the HTML element of one view on a page.

    Parameters
    ----------
    state : mapping
        The traits that the view reads. Values are JSON values or bytes.
    kind : str
        Media type by which the script of the page finds its views; by default that of editors.

    Returns
    -------
    str
        HTML in which text from a font cannot act as markup.
    """
    text = json.dumps(state, default=lambda data: base64.b64encode(data).decode("ascii"))
    # Every sequence that can end a script element begins with "<".
    text = text.replace("<", "\\u003c")
    return f'<script type="{kind}">{text}</script>'


def page(title: str, body: str, scripts: Sequence[str], style: str) -> str:
    """Return a whole HTML page.

    Parameters
    ----------
    title : str
        Plain text; markup in it is escaped.
    body : str
        HTML that may contain any number of elements made by :func:`view`.
    scripts : sequence of str
        The bundle of each kind of view; none for a page without views.
    style : str
        The style sheet.
    """
    encoded = [base64.b64encode(script.encode()).decode("ascii") for script in scripts]
    return _PAGE.format(
        title=html.escape(title),
        body=body,
        style=style,
        scripts="".join(_SCRIPT.format(script=script) for script in encoded),
        policy=_SCRIPTED if scripts else _STILL,
    )


def font_face(family: str, file: bytes) -> str:
    """A CSS rule that contains a font.

    Parameters
    ----------
    family : str
        The name by which the style sheet refers to the font.
    file : bytes
        A WOFF2 file.
    """
    data = base64.b64encode(file).decode("ascii")
    return (
        f"@font-face {{ font-family: {quoted(family)}; "
        f'src: url("data:font/woff2;base64,{data}") format("woff2"); }}\n'
    )
