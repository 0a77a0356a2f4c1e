"""Outlines to images: time beside diffvg, growth, accuracy, and batches.

Times are of one image and its gradient by the control points, and of the clock on the wall. diffvg
computes in as many threads as there are cores, ours in one, so that beside it the ratio of the
processors' times is told as well: the one that does not depend on how many cores are free.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from importlib.util import find_spec
from time import perf_counter, process_time

import numpy as np
import torch
from torch import Tensor

import vfwidget as vf
from tests.scan import scan
from vfwidget.raster import frame

from .table import Row, milliseconds
from .timing import Array, Times

GLYPHS = (("dynapuff", "o"), ("roboto-flex", "R"), ("recursive", "@"))
"""Of few segments to many."""
SIZES = ((256, 256), (512, 576), (640, 640))
SIDES = (128, 256, 512, 1024)
FONT, WORD = "recursive", "variable"
LETTERS = (1, 2, 4, 8, 16, 32)
LINE = (128, 2048)
"""Room for the longest text, at one scale for all."""
CHARACTERS = "AQRSWXagkt48&@$%éöß§"
"""Of every bundled font, for accuracy."""
LINES = 256
REPEATS = 10
"""How often ours runs while diffvg runs once, which takes as long as hundreds."""

Contours = list[Tensor]
Run = Callable[[], None]


def run(quick: bool) -> Iterator[Row]:
    """Three glyphs at three sizes; pixels, segments and batches; a hundred glyphs' errors."""
    for size in SIZES:
        for name, letter in GLYPHS:
            yield _beside_diffvg(name, letter, size, rounds=1 if quick else 5)
    rounds = 5 if quick else 30
    yield from _growth(
        [
            (f"{side} × {side} pixels", render(contours(WORD, (side, side)), (side, side)))
            for side in SIDES
        ],
        rounds,
    )
    scale = frame(_line(LETTERS[-1]), LINE)
    lines = [(_line(letters), letters) for letters in LETTERS]
    yield from _growth(
        [
            (
                f"letters: {letters}, segments: {sum(map(len, text.segments()))}",
                render([_put(s, scale) for s in text.segments()], LINE),
            )
            for text, letters in lines
        ],
        rounds,
    )
    yield _accuracy(glyphs=2 if quick else len(CHARACTERS))
    yield from _batches("cpu", (1, 64), rounds=2 if quick else 10)
    if torch.cuda.is_available():
        yield from _batches("cuda", (1, 64, 4096), rounds=2 if quick else 10)


def contours(string: str, size: tuple[int, int], font: str = FONT) -> Contours:
    """A text's contours in pixels, framed."""
    text = vf.Text(font, string)
    return [_put(segments, frame(text, size)) for segments in text.segments()]


def _put(segments: Tensor, placement: Tensor) -> Tensor:
    return segments @ placement[:, :2].T + placement[:, 2]


def _line(letters: int) -> vf.Text:
    return vf.Text(FONT, (WORD * letters)[:letters])


def render(segments: Contours, size: tuple[int, int], backend: str = "exact") -> Run:
    """An image of these contours, and from some slope by the image that by their control points."""
    leaves = [contour.clone().requires_grad_() for contour in segments]
    batch = segments[0].shape[:-3]
    # Not the same everywhere.
    slope = torch.linspace(-1, 1, size[0] * size[1]).reshape(size).to(leaves[0])
    slope = slope.expand(*batch, *size).contiguous()

    def once() -> None:
        image = vf.rasterize(leaves, size, backend=backend)
        torch.autograd.grad(image, leaves, slope)
        if image.is_cuda:
            torch.cuda.synchronize()

    return once


def in_turns(contestants: list[Run], rounds: int, repeats: list[int]) -> tuple[Times, Times]:
    """Seconds on the wall, and of all processors together; contestants in turns.

    A different one begins each time. Each runs several times at its turn, of which the median
    counts; one round goes before.
    """
    count = len(contestants)
    seconds: Array = np.zeros((2, count, rounds + 1))
    for turn in range(rounds + 1):
        for place in range(count):
            who = (place + turn) % count
            times = [_timed(contestants[who]) for _ in range(repeats[who])]
            seconds[:, who, turn] = np.median(times, axis=0)
    wall, processors = seconds[:, :, 1:]
    return Times(wall), Times(processors)


def _timed(contestant: Run) -> tuple[float, float]:
    begun = perf_counter(), process_time()
    contestant()
    return perf_counter() - begun[0], process_time() - begun[1]


def _beside_diffvg(name: str, letter: str, size: tuple[int, int], rounds: int) -> Row:
    segments = contours(letter, size, name)
    present = find_spec("pydiffvg") is not None
    backends = ["exact", "diffvg"] if present else ["exact"]
    runs = [render(segments, size, backend) for backend in backends]
    times, processors = in_turns(runs, rounds, [REPEATS, 1])
    count = f"{sum(map(len, segments))} segments"
    return Row(
        benchmark="raster",
        case=f"{name} {letter}, {size[0]} × {size[1]}",
        ours=milliseconds(times.median(0)),
        baseline=f"diffvg {milliseconds(times.median(1))}" if present else "no pydiffvg here",
        ratio=str(times.ratio(1, 0)) if present else "",
        notes=f"{count}, {processors.ratio(1, 0)} by processor time" if present else count,
    )


def _growth(cases: list[tuple[str, Run]], rounds: int) -> Iterator[Row]:
    """Each case against the first."""
    times, _ = in_turns([contestant for _, contestant in cases], rounds, [1] * len(cases))
    for i, (case, _) in enumerate(cases):
        yield Row(
            benchmark="raster",
            case=case,
            ours=milliseconds(times.median(i)),
            baseline=f"the first {milliseconds(times.median(0))}",
            ratio=str(times.ratio(i, 0)),
        )


def _accuracy(glyphs: int) -> Row:
    """Errors against scanlines, of glyphs at random places of their fonts' design spaces."""
    size, rng = (256, 256), np.random.default_rng(0)
    means, most = [], []
    for name in vf.bundled_fonts():
        for letter in CHARACTERS[:glyphs]:
            text = vf.Text(name, letter)
            text = text.at(theta=rng.uniform(*text.font.bounds)[None])
            segments = [_put(s, frame(text, size)) for s in text.segments()]
            error = abs(vf.rasterize(segments, size).numpy() - scan(segments, *size, lines=LINES))
            means.append(error.mean())
            most.append(error.max())
    return Row(
        benchmark="raster",
        case=f"{len(means)} glyphs, {size[0]} × {size[1]}",
        ours=f"{np.mean(means):.1e}",
        baseline=f"{LINES} scanlines a pixel",
        ratio="",
        notes=f"mean error; of a glyph at most {max(means):.1e}, of a pixel {max(most):.1e}",
    )


def _batches(device: str, counts: tuple[int, ...], rounds: int) -> Iterator[Row]:
    """Images of one letter at many places, all at once."""
    size, (name, letter) = (256, 256), GLYPHS[1]
    segments = [contour.to(device) for contour in contours(letter, size, name)]
    alone = 0.0
    for count in counts:
        shift = 8 * torch.rand(count, 1, 1, 2, dtype=torch.float64).to(device)
        times, _ = in_turns([render([s + shift for s in segments], size)], rounds, [1])
        each = times.median(0) / count
        alone = alone or each
        yield Row(
            benchmark="raster",
            case=f"{name} {letter}, {size[0]} × {size[1]}, {count} at once",
            ours=milliseconds(each),
            baseline=f"one alone {milliseconds(alone)}",
            ratio="",
            notes=f"an image, on {_name(device)}",
        )


def _name(device: str) -> str:
    return "the CPU" if device == "cpu" else torch.cuda.get_device_name()
