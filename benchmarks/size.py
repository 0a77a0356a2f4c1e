"""One update of a drag on small to large glyphs; the time should not depend on k."""

from __future__ import annotations

from collections.abc import Iterator

import vfwidget as vf

from .drag import EVENTS, Drag, Ours
from .table import Row, milliseconds
from .timing import interleave

FONT = "recursive"
CHARACTERS = "ʻ“FGW@¾"
"""Small to large glyphs with the same number of delta sets and drags of about three steps."""


def run(quick: bool) -> Iterator[Row]:
    """Compare each glyph with the smallest one."""
    texts = [vf.Text(FONT, character) for character in CHARACTERS]
    contestants = [Ours(Drag.reachable(text)) for text in texts]
    times = interleave(contestants, EVENTS, rounds=2 if quick else 20)
    for i, (text, ours) in enumerate(zip(texts, contestants, strict=True)):
        k, _, m = text.glyphs[0].deltas.shape
        yield Row(
            benchmark="size",
            case=f"{FONT} {text.string}, k={k} m={m}",
            ours=milliseconds(times.median(i)),
            baseline=f"{CHARACTERS[0]} {milliseconds(times.median(0))}",
            ratio=str(times.ratio(i, 0)),
            notes=f"steps {ours.steps.mean():.1f}",
        )
