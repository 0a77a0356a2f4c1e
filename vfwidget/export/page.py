"""A self-contained HTML page that shows views without a kernel and loads nothing.

The page contains the state of each view as JSON. The same JavaScript bundle that a notebook uses
reads the state and draws it. The view evaluates Eq. 1–3, so its sliders work.
"""

from __future__ import annotations

import base64
import html
import json
from collections.abc import Mapping
from typing import Any

STATE = "application/vnd.vfwidget+json"

_PAGE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; \
script-src 'unsafe-inline' data:; style-src 'unsafe-inline'; img-src data:; media-src data:">
<meta name="viewport" content="width=device-width">
<title>{title}</title>
<style>{style}</style>
<script type="module">
import {{ mount }} from "data:text/javascript;base64,{script}";
mount();
</script>
</head>
<body>
{body}
</body>
</html>
"""


def view(state: Mapping[str, Any]) -> str:
    """Return the HTML element of one view on a page.

    Parameters
    ----------
    state : mapping
        The traits that the view reads. Values are JSON values or bytes.

    Returns
    -------
    str
        HTML in which text from a font cannot act as markup.
    """
    text = json.dumps(state, default=lambda data: base64.b64encode(data).decode("ascii"))
    # Every sequence that can end a script element begins with "<".
    text = text.replace("<", "\\u003c")
    return f'<script type="{STATE}">{text}</script>'


def page(title: str, body: str, script: str, style: str) -> str:
    """Return a whole HTML page.

    Parameters
    ----------
    title : str
        Plain text; markup in it is escaped.
    body : str
        HTML that may contain any number of elements made by :func:`view`.
    script, style : str
        The bundle of the views, and the style sheet.
    """
    return _PAGE.format(
        title=html.escape(title),
        body=body,
        style=style,
        script=base64.b64encode(script.encode()).decode("ascii"),
    )
