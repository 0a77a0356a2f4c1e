"""A page that shows views without a kernel: HTML in one piece, which fetches nothing.

The state of each view lies in the page as JSON. The bundle that a notebook runs finds it there
and draws from it; the view evaluates Eq. 1–3 by itself, so its sliders go on working.
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
    """The place of one view on a page.

    Parameters
    ----------
    state : mapping
        The traits that the view reads: what JSON can hold, and bytes.

    Returns
    -------
    str
        HTML, in which text from a font is inert whatever it says.
    """
    text = json.dumps(state, default=lambda data: base64.b64encode(data).decode("ascii"))
    # Whatever could end a script element begins with "<".
    text = text.replace("<", "\\u003c")
    return f'<script type="{STATE}">{text}</script>'


def page(title: str, body: str, script: str, style: str) -> str:
    """A whole page.

    Parameters
    ----------
    title : str
        Text, not markup.
    body : str
        HTML, with as many places of a :func:`view` as wanted.
    script, style : str
        The bundle of the views, and the style sheet.
    """
    return _PAGE.format(
        title=html.escape(title),
        body=body,
        style=style,
        script=base64.b64encode(script.encode()).decode("ascii"),
    )
