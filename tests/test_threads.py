"""Long computations use one thread, and leave the numbers of threads as they were."""

import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import torch
from threadpoolctl import threadpool_info, threadpool_limits

import vfwidget as vf
from vfwidget.threads import one_thread

SQUARE = [(0, -300), (900, -300), (900, -100), (0, -100)]


def numbers_of_threads() -> set[int]:
    return {torch.get_num_threads(), *(library["num_threads"] for library in threadpool_info())}


@pytest.fixture(autouse=True)
def three_threads() -> Iterator[None]:
    """A number that no machine has by itself, so that it is seen to come back."""
    with threadpool_limits(3):
        yield


def test_it_may_be_nested_and_ends_with_an_exception() -> None:
    with pytest.raises(ZeroDivisionError), one_thread:
        with one_thread:
            assert numbers_of_threads() == {1}
        assert numbers_of_threads() == {1}
        _ = 1 // 0
    assert numbers_of_threads() == {3}


def test_several_threads_leave_the_numbers_as_they_were() -> None:
    entered, leave = threading.Event(), threading.Event()

    @one_thread
    def stay() -> None:
        entered.set()
        assert leave.wait(10)
        assert torch.get_num_threads() == 1

    with ThreadPoolExecutor(1) as pool:
        for _ in range(2):
            # The other thread comes while this one is inside, and leaves after it.
            entered.clear()
            leave.clear()
            with one_thread:
                other = pool.submit(stay)
                assert entered.wait(10)
            leave.set()
            other.result()
            assert numbers_of_threads() == {3}
        # And the other way round.
        entered.clear()
        leave.clear()
        other = pool.submit(stay)
        assert entered.wait(10)
        with one_thread:
            leave.set()
            other.result()
        assert numbers_of_threads() == {3}


def test_a_simulation_uses_one_thread() -> None:
    seen = set()

    def obstacle(time: float) -> list[object]:
        seen.update(numbers_of_threads())
        return [SQUARE]

    vf.simulate(vf.Text("dynapuff", "o"), 2, obstacles=obstacle, progress=False)
    assert seen == {1}
    assert numbers_of_threads() == {3}


def test_a_match_uses_one_thread() -> None:
    seen = set()
    text = vf.Text("dynapuff", "o")
    image = 1 - vf.rasterize(text.at({"wght": 600}), (40, 40)).numpy()
    vf.match(image, text, watch=lambda *_: seen.update(numbers_of_threads()), progress=False)
    assert seen == {1}
    assert numbers_of_threads() == {3}


@pytest.mark.parametrize("letters, threads", [(1, 3), (12, 1)])
def test_a_solve_uses_one_thread_unless_it_is_small(
    letters: int, threads: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen = set()
    solve = np.linalg.solve

    def watched(*args: object) -> object:
        seen.update(numbers_of_threads())
        return solve(*args)

    text = vf.Text("roboto-flex", "hamburgefons"[:letters], shared=False)
    handles = [text.handle(i) for i in range(letters)]
    terms = [vf.Target(one, text.position(one).numpy() + 10) for one in handles]
    monkeypatch.setattr(np.linalg, "solve", watched)
    vf.solve(text, [*terms, vf.StayClose()], restarts=0)
    assert seen == {threads}
    assert numbers_of_threads() == {3}


def test_overlaps_are_resolved_in_one_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    seen = set()
    solve = np.linalg.solve

    def watched(*args: object) -> object:
        seen.update(numbers_of_threads())
        return solve(*args)

    text = vf.Text("recursive", "ello", shared=False, tracking=-70)
    monkeypatch.setattr(np.linalg, "solve", watched)
    vf.resolve_overlaps(text.at({"wght": 1000}), [SQUARE])
    assert seen <= {1}
