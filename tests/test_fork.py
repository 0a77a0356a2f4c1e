"""Processes made by fork, spawn and forkserver compute the same results as their parent."""

from __future__ import annotations

import asyncio
import multiprocessing
from concurrent.futures import ProcessPoolExecutor
from typing import Any

import pytest
import torch

import vfwidget as vf

METHODS = multiprocessing.get_all_start_methods()
SECONDS = 100


def drawn(weight: float) -> Any:
    """A large picture, so that torch would use several threads."""
    text = vf.Text("recursive", "a", axes={"wght": weight})
    return vf.rasterize(text, (512, 512)).sum().item()


def matched(weight: float) -> Any:
    text = vf.Text("dynapuff", "a", axes={"wght": weight})
    picture = 1 - vf.rasterize(text, (64, 64))
    return vf.match(picture, "a", "dynapuff", progress=False).axes


@pytest.mark.filterwarnings("ignore:This process .* is multi-threaded:DeprecationWarning")
@pytest.mark.parametrize(
    "method",
    [
        pytest.param(method, marks=[] if method == "fork" else pytest.mark.slow)
        for method in METHODS
    ],
)
def test_workers_finish_and_agree_after_the_parent_has_used_threads(method):
    threads = torch.get_num_threads()
    torch.set_num_threads(4)
    try:
        # The parent's thread pools exist from here on.
        expected = [drawn(500), matched(600)]
        context = multiprocessing.get_context(method)
        with ProcessPoolExecutor(2, mp_context=context) as pool:
            futures = [pool.submit(drawn, 500), pool.submit(matched, 600)]
            try:
                found = [future.result(SECONDS) for future in futures]
            except TimeoutError:
                for process in list(pool._processes.values()):
                    process.kill()
                raise
    finally:
        torch.set_num_threads(threads)
    assert found[0] == pytest.approx(expected[0], rel=1e-12)
    assert found[1] == pytest.approx(expected[1], rel=1e-6)


def test_tasks_of_asyncio_agree():
    """Four tasks at a time, each in a thread of the event loop's pool."""

    async def together() -> list[Any]:
        tasks = [asyncio.to_thread(drawn, weight) for weight in (400, 500, 600, 700)]
        return await asyncio.gather(*tasks)

    assert asyncio.run(together()) == [drawn(weight) for weight in (400, 500, 600, 700)]
