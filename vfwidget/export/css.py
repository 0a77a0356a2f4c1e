"""The axes of a text as CSS."""

from __future__ import annotations

import json
from collections.abc import Mapping

from ..text import Text


def to_css(text: Text) -> str:
    """Write the declarations that set a text in its font at its axes.

    Parameters
    ----------
    text : Text

    Returns
    -------
    str
        ``font-family`` and ``font-variation-settings``. With an axis vector for each letter there
        is one rule for each letter, ``.letter-1`` and so on.
    """
    family = f"font-family: {json.dumps(text.font.family_name, ensure_ascii=False)};"
    if text.shared:
        return f"{family}\nfont-variation-settings: {_settings(text.axes)};"
    rules = [
        f".letter-{index} {{ font-variation-settings: {_settings(axes)}; }}"
        for index, axes in enumerate(text.axes, start=1)
    ]
    return "\n".join([family, *rules])


def _settings(axes: Mapping[str, float]) -> str:
    return ", ".join(f'"{tag}" {round(value, 4):g}' for tag, value in axes.items())
