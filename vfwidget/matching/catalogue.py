"""One picture and many fonts: a coarse search in all of them, and a fit of the best."""

from __future__ import annotations

import io
import warnings
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, Future, as_completed
from dataclasses import replace
from pathlib import Path
from typing import Any

from fontTools.ttLib import TTFont
from tqdm.auto import tqdm

from ..arrays import Array
from ..errors import ImageError, VFWidgetError
from ..font import Font, load_font
from ..font.source import FontSource
from ..threads import one_thread
from .match import Outcome, Request, Search
from .result import Match

KEPT = 12
"""How many fonts, the best of the coarse search, are fitted."""
CHUNK = 4
"""Fonts that a worker receives at a time."""
TRIES = 3
"""How often a chunk is sent to workers before it is computed in this process."""

Answer = tuple[float | Outcome | None, str]
"""A result; or None and the reason."""


def match_fonts(
    image: Array,
    fonts: Sequence[Font | FontSource],
    request: Request,
    executor: Executor | None,
    progress: bool,
) -> Match:
    """The best of several fonts, with the others ranked.

    Raises
    ------
    ImageError
        There are no fonts, or none could be fitted.
    """
    sources = [font if executor is None else _portable(font) for font in fonts]
    names = _names(fonts)
    if not sources:
        raise ImageError("There are no fonts to match.")
    with tqdm(total=len(sources), desc="match", leave=False, disable=not progress) as bar:
        order: Sequence[int] = range(len(sources))
        left_out: dict[str, str] = {}
        if len(sources) > KEPT:
            searched = _run(search_one, image, sources, order, request, executor, lambda: None)
            unexplained: dict[int, float] = {}
            for i in order:
                share, why = searched[i]
                if isinstance(share, float):
                    unexplained[i] = share
                else:
                    left_out[names[i]] = why
            good = sorted(unexplained, key=unexplained.__getitem__)
            for i in good[KEPT:]:
                explained = 100 * (1 - unexplained[i])
                left_out[names[i]] = f"the coarse search explains {explained:.0f} % of the ink"
            order = good[:KEPT]
            bar.total = len(order)
        fitted = _run(fit_one, image, sources, order, request, executor, bar.update)
    matches = []
    for i in order:
        outcome, why = fitted[i]
        if isinstance(outcome, Outcome):
            text = request.text(load_font(sources[i])).moved_to(outcome.state.place)
            matches.append(Match(text, image, outcome))
        else:
            left_out[names[i]] = why
    if not matches:
        raise ImageError(f"No font could be fitted: {next(iter(left_out.values()))}")
    # Fonts that match equally well keep their order, whichever worker fitted them.
    matches.sort(key=lambda one: -one.score)
    return replace(matches[0], ranking=tuple(matches), left_out=left_out)


def _names(fonts: Sequence[Font | FontSource]) -> list[str]:
    """A name for each font; all are different."""
    names: list[str] = []
    for i, font in enumerate(fonts):
        if isinstance(font, Font):
            name = font.family_name
        else:
            name = str(font) if isinstance(font, str | Path) else f"fonts[{i}]"
        names.append(f"{name}, fonts[{i}]" if name in names else name)
    return names


def _portable(font: Font | FontSource) -> Any:
    """A font in a form that can be sent to another process."""
    ttfont = font._ttfont if isinstance(font, Font) else font
    if not isinstance(ttfont, TTFont):
        return ttfont
    file = io.BytesIO()
    # To compress it takes longer than to fit it.
    flavor, ttfont.flavor = ttfont.flavor, None
    try:
        ttfont.save(file)
    finally:
        ttfont.flavor = flavor
    return file.getvalue()


def search_one(request: Request, image: Array, source: Any) -> float:
    """The share of the ink that the coarse search in one font leaves unexplained."""
    text = request.text(load_font(source))
    return Search(text, image, request.settings_for(text)).unexplained()


def fit_one(request: Request, image: Array, source: Any) -> Outcome:
    """The fit of one font."""
    text = request.text(load_font(source))
    return Search(text, image, request.settings_for(text)).outcome()


Work = Callable[[Request, Array, Any], Any]


@one_thread
def _chunk(work: Work, request: Request, image: Array, sources: Sequence[Any]) -> list[Answer]:
    return [_try(work, request, image, source) for source in sources]


def _try(work: Work, request: Request, image: Array, source: Any) -> Answer:
    """A font that lacks a letter, or is none, does not stop the others."""
    try:
        return work(request, image, source), ""
    except VFWidgetError as error:
        return None, str(error)


def _run(
    work: Work,
    image: Array,
    sources: Sequence[Any],
    order: Sequence[int],
    request: Request,
    executor: Executor | None,
    done: Callable[[], Any],
) -> dict[int, Answer]:
    """Each font's answer by its number."""
    chunks = [order[i : i + CHUNK] for i in range(0, len(order), CHUNK)]
    answers: dict[int, Answer] = {}

    def collect(chunk: Sequence[int], found: list[Answer]) -> None:
        answers.update(zip(chunk, found, strict=True))
        for _ in chunk:
            done()

    waiting = list(chunks)
    for _ in range(TRIES):
        if executor is None or not waiting:
            break
        lost = []
        for chunk, future in _submit(executor, work, image, sources, request, waiting):
            try:
                collect(chunk, future.result())
            except VFWidgetError:
                raise
            except Exception as error:
                # A worker was lost, and only its own chunk with it.
                lost.append(chunk)
                warnings.warn(f"A worker was lost ({error!r}); trying again.", stacklevel=4)
        waiting = lost
    for chunk in waiting:
        collect(chunk, _chunk(work, request, image, [sources[i] for i in chunk]))
    return answers


def _submit(
    executor: Executor,
    work: Work,
    image: Array,
    sources: Sequence[Any],
    request: Request,
    chunks: Sequence[Sequence[int]],
) -> Iterator[tuple[Sequence[int], Future[list[Answer]]]]:
    futures = {}
    for chunk in chunks:
        try:
            future = executor.submit(_chunk, work, request, image, [sources[i] for i in chunk])
        except Exception as error:
            # A broken pool accepts no more work.
            future = Future()
            future.set_exception(error)
        futures[future] = chunk
    for future in as_completed(futures):
        yield futures[future], future
