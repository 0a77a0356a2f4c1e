"""Computing in one thread, for products of matrices that are too small to divide.

NumPy's BLAS and torch divide a product among threads as soon as it takes some tens of
microseconds. The threads then wait for one another. On a machine that has other work, or that lends
only a part of a processor, as servers of notebooks do, this takes many times as long as the product
itself.
"""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable
from contextlib import ExitStack
from functools import lru_cache, wraps
from typing import Any, TypeVar, cast

from threadpoolctl import ThreadpoolController

Function = TypeVar("Function", bound=Callable[..., Any])


class _OneThread:
    """See :data:`one_thread`."""

    def __init__(self) -> None:
        self._blas = threading.Lock()
        self._own = threading.local()

    def __enter__(self) -> None:
        depth = getattr(self._own, "depth", 0)
        if depth == 0:
            self._own.limits = limits = ExitStack()
            limits.enter_context(_libraries("openmp", "torch" in sys.modules).limit(limits=1))
            # OpenMP has a number of threads for each thread that calls it, and BLAS one for all of
            # them. The first one to come sets that, and takes it back.
            if self._blas.acquire(blocking=False):
                limits.callback(self._blas.release)
                limits.enter_context(_libraries("blas", "torch" in sys.modules).limit(limits=1))
        self._own.depth = depth + 1

    def __exit__(self, *_: object) -> None:
        self._own.depth -= 1
        if self._own.depth == 0:
            self._own.limits.close()

    def __call__(self, function: Function) -> Function:
        @wraps(function)
        def alone(*args: Any, **kwargs: Any) -> Any:
            with self:
                return function(*args, **kwargs)

        return cast(Function, alone)


@lru_cache
def _libraries(kind: str, with_torch: bool) -> Any:
    """The libraries of a kind that are loaded; torch, which loads on first use, brings some."""
    return ThreadpoolController().select(user_api=kind)


one_thread = _OneThread()
"""Lets BLAS and torch compute in one thread: ``with one_thread:``, or ``@one_thread`` before a
function. It may be nested, and used in several threads at once."""
