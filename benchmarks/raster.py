"""Rendering outlines: time compared with diffvg, growth, accuracy, and batches.

Times are elapsed times for one image and its gradient with respect to the control points. diffvg
uses all cores and ours uses one. The notes therefore also give the ratio of processor times, which
does not depend on the number of free cores.
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
"""Glyphs with few to many segments."""
SIZES = ((256, 256), (512, 576), (640, 640))
SIDES = (128, 256, 512, 1024)
FONT, WORD = "recursive", "variable"
LETTERS = (1, 2, 4, 8, 16, 32)
LINE = (128, 2048)
"""Image size that holds the longest text; all texts have the same scale."""
CHARACTERS = "AQRSWXagkt48&@$%éöß§"
"""Characters of every bundled font that are used to measure accuracy."""
LINES = 256
REPEATS = 10
"""Number of runs of ours for one run of diffvg, which takes hundreds of times longer."""

Contours = list[Tensor]
Run = Callable[[], None]


def run(quick: bool) -> Iterator[Row]:
    """Measure three glyphs at three sizes, growth, accuracy and batches."""
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
    """Return the contours of a text in pixels; the text fills the image."""
    text = vf.Text(font, string)
    return [_put(segments, frame(text, size)) for segments in text.segments()]


def _put(segments: Tensor, placement: Tensor) -> Tensor:
    return segments @ placement[:, :2].T + placement[:, 2]


def _line(letters: int) -> vf.Text:
    return vf.Text(FONT, (WORD * letters)[:letters])


def render(segments: Contours, size: tuple[int, int], backend: str = "exact") -> Run:
    """Return a function that draws contours and computes a gradient with respect to them."""
    leaves = [contour.clone().requires_grad_() for contour in segments]
    batch = segments[0].shape[:-3]
    # The gradient with respect to the image varies from pixel to pixel.
    slope = torch.linspace(-1, 1, size[0] * size[1]).reshape(size).to(leaves[0])
    slope = slope.expand(*batch, *size).contiguous()

    def once() -> None:
        image = vf.rasterize(leaves, size, backend=backend)
        torch.autograd.grad(image, leaves, slope)
        if image.is_cuda:
            torch.cuda.synchronize()

    return once


def in_turns(contestants: list[Run], rounds: int, repeats: list[int]) -> tuple[Times, Times]:
    """Return elapsed seconds and processor seconds of contestants that take turns.

    A different contestant begins each round. In its turn each runs ``repeats`` times, and the
    median counts. One untimed round precedes the others.
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
    """Compare each case with the first one."""
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
    """Compare glyphs at random locations of the design space with a scanline rasteriser."""
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
    """Draw one letter at many positions in one batch."""
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
