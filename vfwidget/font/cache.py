"""What a font keeps of the glyphs that it has unpacked, up to a limit of memory."""

from __future__ import annotations

from collections import OrderedDict
from typing import Generic, Protocol, TypeVar

from ..limits import limits


class Sized(Protocol):
    """Data whose memory in bytes is known."""

    @property
    def nbytes(self) -> int:
        """Memory in bytes."""


Item = TypeVar("Item", bound=Sized)


class GlyphCache(Generic[Item]):
    """Data of glyphs by name; those used least recently are forgotten first.

    It grows up to a share of ``limits.glyph_cache_bytes``, and always holds the latest item.

    Parameters
    ----------
    share : float
        Default 1.
    """

    def __init__(self, share: float = 1.0) -> None:
        self._share = share
        self._items: OrderedDict[str, Item] = OrderedDict()
        self._bytes = 0

    def get(self, name: str) -> Item | None:
        """An item that is kept."""
        if name in self._items:
            self._items.move_to_end(name)
        return self._items.get(name)

    def add(self, name: str, item: Item) -> None:
        """Keep an item that is not kept yet."""
        self._items[name] = item
        self._bytes += item.nbytes
        while self._bytes > self._share * limits.glyph_cache_bytes and len(self._items) > 1:
            _, forgotten = self._items.popitem(last=False)
            self._bytes -= forgotten.nbytes
