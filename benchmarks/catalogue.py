"""Time that one font needs: to load and unpack it, for the coarse search, and for the fit.

Each bundled font is matched with a picture of a letter and of a word in that font. The last line
adds up the times for a thousand such fonts, of which ``vf.match`` fits only the best few.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from time import perf_counter

import numpy as np

import vfwidget as vf
from vfwidget.matching.catalogue import KEPT, fit_one, search_one
from vfwidget.matching.fit import Options
from vfwidget.matching.looks import FITTED
from vfwidget.matching.match import Request, Settings

from .table import Row

STRINGS = ("g", "hand")
SIDE = 160
FONTS = 1000


def run(quick: bool) -> Iterator[Row]:
    """Yield a line for each font, and one for a thousand fonts."""
    costs = []
    for name in vf.bundled_fonts():
        for string in STRINGS:
            costs.append(_cost(name, string, rounds=1 if quick else 3))
            load, sweep, fit = costs[-1]
            yield Row(
                benchmark="catalogue",
                case=f"{name} {string}",
                ours=f"{sweep:.2f} s",
                baseline="",
                ratio="",
                notes=f"search, including {load:.2f} s to load; the fit takes another {fit:.2f} s",
            )
    _, sweep, fit = np.mean(costs, axis=0)
    yield Row(
        benchmark="catalogue",
        case=f"{FONTS} fonts, one process",
        ours=f"{(FONTS * sweep + KEPT * fit) / 60:.1f} min",
        baseline=f"all fitted {FONTS * (sweep + fit) / 60:.1f} min",
        ratio=f"{(sweep + fit) / (sweep + fit * KEPT / FONTS):.1f}×",
        notes=f"{FONTS} searches and {KEPT} fits, from the means above",
    )


def _cost(name: str, string: str, rounds: int) -> tuple[float, float, float]:
    """Seconds to load, to search (including the load) and to fit (without the search)."""
    text = vf.Text(name, string)
    lower, upper = text.font.bounds
    place = np.random.default_rng(4).uniform(lower, upper)[None]
    image = 1 - vf.rasterize(text.at(theta=place), (SIDE, SIDE)).numpy()
    options = Options(FITTED)
    settings = Settings(options, None, None, terms=6, dark=None, resolution=512, max_iterations=40)
    request = Request(string, True, None, None, settings)

    def seconds(work: Callable[[], object]) -> float:
        times = []
        for _ in range(rounds):
            begun = perf_counter()
            work()
            times.append(perf_counter() - begun)
        return float(np.median(times))

    load = seconds(lambda: request.text(vf.load_font(name)))
    sweep = seconds(lambda: search_one(request, image, name))
    return load, sweep, seconds(lambda: fit_one(request, image, name)) - sweep
