"""The bounded cache."""

from __future__ import annotations

import random
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import pytest

from vfwidget.text.memo import Memo

SECONDS = 4


@pytest.fixture
def busy_threads() -> Iterator[None]:
    """Threads take turns as often as possible."""
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    yield
    sys.setswitchinterval(interval)


def test_the_oldest_results_are_dropped() -> None:
    made: list[int] = []
    memo: Memo[int] = Memo(2)

    def get(key: int) -> int:
        return memo.get(key, lambda: made.append(key) or -key)

    assert [get(key) for key in (1, 2, 1, 3, 2, 1)] == [-1, -2, -1, -3, -2, -1]
    assert made == [1, 2, 3, 1]


def test_several_threads_may_use_a_full_one(busy_threads: None) -> None:
    memo: Memo[int] = Memo(8)

    def use(seed: int) -> None:
        chance, end = random.Random(seed), time.monotonic() + SECONDS
        while time.monotonic() < end:
            for key in chance.choices(range(40), k=100):
                assert memo.get(key, lambda key=key: key + 1) == key + 1

    with ThreadPoolExecutor(6) as pool:
        list(pool.map(use, range(6)))
