"""The unknowns of a solve: named blocks of numbers, each with its bounds and kinks.

A text stands at a place: the axis values of its letters (``"axes"``, Θ in normalized coordinates),
a displacement of each letter from where the layout sets it (``"offsets"``, in font units) and the
space between letters (``"tracking"``, in font units).
A term may add blocks of its own, such as the placement of a picture. In a solve each block is
free or fixed; the solver sees one flat vector of the free ones.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..errors import SolveError

AXES, OFFSETS, TRACKING = "axes", "offsets", "tracking"
"""The three blocks that every text has."""
ROTATIONS = "rotations"
"""The angles of the letters (l,) in radians. Only a simulation has them as unknowns."""


class Place(Mapping[str, Array]):
    """Values of blocks of unknowns by name; it is immutable.

    Parameters
    ----------
    values : mapping of str to array
        The place gives read-only views of the arrays.
    """

    __slots__ = ("_values",)

    def __init__(self, values: Mapping[str, Array]) -> None:
        self._values = dict(values)

    def __getitem__(self, name: str) -> Array:
        value = self._values[name].view()
        value.flags.writeable = False
        return value

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __repr__(self) -> str:
        shapes = ", ".join(f"{name} {value.shape}" for name, value in self.items())
        return f"<Place: {shapes}>"


class Block(NamedTuple):
    """A group of unknowns that are free or fixed together.

    Attributes
    ----------
    value : array of any shape
        Where the unknowns start.
    lower, upper : arrays of the same shape, optional
        Bounds; without them the unknowns are unbounded.
    kinks : (size, q) array, optional
        Values at which each unknown has a kink, padded with infinity.
    """

    value: Array
    lower: Array | None = None
    upper: Array | None = None
    kinks: Array | None = None

    @property
    def with_bounds(self) -> tuple[Array, Array, Array]:
        """The value, and both bounds as arrays; they are infinite where the block has none."""
        value, lower, upper, _ = self
        return (
            value,
            np.full(value.shape, -np.inf) if lower is None else lower,
            np.full(value.shape, np.inf) if upper is None else upper,
        )


class Unknowns:
    """The free blocks of a solve as one flat vector.

    Parameters
    ----------
    blocks : mapping of str to Block
        All blocks, free and fixed.
    free : collection of str
        Names of the free blocks.
    added : collection of str
        Names of blocks that are free as well, because a term has added them.

    Attributes
    ----------
    blocks : mapping of str to Block
    start, lower, upper : (N,) arrays
    slices : dict of str to slice
        Where each free block lies in the flat vector, in the order of ``blocks``.

    Raises
    ------
    SolveError
        ``free`` names a block that does not exist, or no block at all.
    """

    def __init__(
        self, blocks: Mapping[str, Block], free: Collection[str], added: Collection[str] = ()
    ) -> None:
        try:
            # A solve may read them several times, which an iterator does not allow.
            listed = isinstance(free, Collection) and not isinstance(free, str)
            names = {*free, *added} if listed else set()
        except TypeError:
            names = set()
        if not names or not names <= blocks.keys():
            raise SolveError(
                f"free must be a sequence of names of blocks of unknowns; received {free!r}. "
                f"This solve has {', '.join(map(repr, blocks))}."
            )
        self.slices: dict[str, slice] = {}
        end = 0
        for name, block in blocks.items():
            if name in names:
                self.slices[name] = slice(end, end + block.value.size)
                end += block.value.size
        self._take(blocks)

    def at(self, blocks: Mapping[str, Block]) -> Unknowns:
        """The same unknowns with other values, bounds and kinks."""
        other = object.__new__(Unknowns)
        other.slices = self.slices
        other._take(blocks)
        return other

    def _take(self, blocks: Mapping[str, Block]) -> None:
        self.blocks = blocks
        free = [blocks[name].with_bounds for name in self.slices]
        # Mostly there is one block, and a drag comes here at every event.
        parts = free[0] if len(free) == 1 else map(_joined, zip(*free, strict=True))
        self.start, self.lower, self.upper = [part.ravel() for part in parts]

    def is_only(self, name: str) -> bool:
        """Whether this block is the only free one."""
        return len(self.slices) == 1 and name in self.slices

    def value(self, name: str, x: Array) -> Array:
        """The values of one block where the free ones are x (N,)."""
        value, part = self.blocks[name].value, self.slices.get(name)
        return value if part is None else x[part].reshape(value.shape)

    def place(self, x: Array) -> dict[str, Array]:
        """The values of all blocks where the free ones are x (N,)."""
        place = {name: block.value for name, block in self.blocks.items()}
        for name, part in self.slices.items():
            place[name] = x[part].reshape(place[name].shape)
        return place

    def flat(self, values: Mapping[str, Array]) -> Array:
        """A number for each free unknown, (N,), from arrays by block; 0 in blocks left out.

        Raises
        ------
        ValueError
            There is no such block, or it has another shape.
        """
        for name, value in values.items():
            if name not in self.blocks or value.shape != self.blocks[name].value.shape:
                raise ValueError(f"There is no block {name!r} of shape {value.shape}.")
        return _joined(
            [values[n] if n in values else np.zeros_like(self.blocks[n].value) for n in self.slices]
        )

    def kinks(self, axes: Array) -> Array:
        """The kinks of every free unknown, (N, q), padded with infinity.

        Parameters
        ----------
        axes : (size, q) array
            Those of the axes, which depend on the terms of a solve.
        """
        if self.is_only(AXES):
            return axes
        tables = {n: axes if n == AXES else self.blocks[n].kinks for n in self.slices}
        widths = [table.shape[1] for table in tables.values() if table is not None]
        width = max(widths, default=1)
        padded = np.full((len(self.start), width), np.inf)
        for name, table in tables.items():
            if table is not None:
                padded[self.slices[name], : table.shape[1]] = table
        return padded


def _joined(parts: Sequence[Array]) -> Array:
    return parts[0].ravel() if len(parts) == 1 else np.concatenate([part.ravel() for part in parts])
