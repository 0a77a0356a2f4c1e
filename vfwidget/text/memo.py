"""A bounded cache: a drag asks for the same things at every event."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Generic, TypeVar

Made = TypeVar("Made")
MOST_KEPT = 256


class Memo(Generic[Made]):
    """Results by key; the key has to hold everything that the result depends on.

    Parameters
    ----------
    most : int
        Results that are kept at most. The oldest are dropped first. Default 256.
    """

    def __init__(self, most: int = MOST_KEPT) -> None:
        self._most = most
        self._kept: dict[Hashable, Made] = {}

    def get(self, key: Hashable, make: Callable[[], Made]) -> Made:
        """The result for this key, made at the first call."""
        found = self._kept.get(key)
        if found is None:
            while len(self._kept) >= self._most:
                # Other threads may drop the same one or add others; a tuple is made in one go.
                for oldest in tuple(self._kept)[:1]:
                    self._kept.pop(oldest, None)
            found = self._kept[key] = make()
        return found
