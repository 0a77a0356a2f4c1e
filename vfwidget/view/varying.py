"""Quantities that vary, in the form in which the view evaluates them (js/src/word/varying.js)."""

from __future__ import annotations

from functools import singledispatchmethod
from typing import Any

import numpy as np

from ..arrays import Array
from ..outline.composed import Composed, Displaced
from ..outline.conditions import AllOf, At, InRange, Not, Positive
from ..outline.placed import Joined, Placed, Replaced, Shown, Transformation
from ..outline.varying import Affine

Node = list[Any]
"""The name of a kind of quantity, and its parts."""


class Regions:
    """All regions that a word uses, each once."""

    def __init__(self) -> None:
        self._indices: dict[bytes, int] = {}
        self._regions: list[Array] = []

    def indices(self, support: Array) -> list[int]:
        """The indices of the regions of a support (m, n, 3)."""
        found = []
        for region in support:
            index = self._indices.setdefault(region.tobytes(), len(self._regions))
            if index == len(self._regions):
                self._regions.append(region)
            found.append(index)
        return found

    def data(self) -> dict[str, Any]:
        """Their number, and start, peak and end on every axis as float32 bytes."""
        packed = np.array(self._regions, dtype="<f4").tobytes()
        return {"count": len(self._regions), "data": packed}

    @singledispatchmethod
    def node(self, quantity: Any) -> Node:
        """A quantity as nested lists of names and parts."""
        raise TypeError(f"The view cannot evaluate {type(quantity).__name__}.")

    @node.register
    def _(self, quantity: Affine) -> Node:
        layers = np.concatenate([quantity.base[None], np.moveaxis(quantity.deltas, -1, 0)])
        packed = layers.astype("<f4").tobytes()
        return ["affine", packed, self.indices(quantity.support), quantity.base.size]

    @node.register
    def _(self, quantity: Composed) -> Node:
        return ["composed", self.node(quantity.outer), self.node(quantity.inner)]

    @node.register
    def _(self, quantity: At) -> Node:
        return ["composed", self.node(quantity.part), self.node(quantity.inner)]

    @node.register
    def _(self, quantity: Displaced) -> Node:
        return ["displaced", self.node(quantity.displacement)]

    @node.register
    def _(self, quantity: Replaced) -> Node:
        base, values = self.node(quantity.base), self.node(quantity.values)
        return ["replaced", base, quantity.axes.tolist(), values]

    @node.register
    def _(self, quantity: Transformation) -> Node:
        return ["turned", self.node(quantity.parameters)]

    @node.register
    def _(self, quantity: Placed) -> Node:
        return ["placed", self.node(quantity.outline), self.node(quantity.matrix)]

    @node.register
    def _(self, quantity: Shown) -> Node:
        return ["shown", self.node(quantity.outline), self.node(quantity.condition)]

    @node.register
    def _(self, quantity: Joined) -> Node:
        return ["joined", *map(self.node, quantity.parts)]

    @node.register
    def _(self, condition: InRange) -> Node:
        return ["range", condition.axis, condition.low, condition.high]

    @node.register
    def _(self, condition: Positive) -> Node:
        return ["positive", self.node(condition.quantity)]

    @node.register
    def _(self, condition: AllOf) -> Node:
        return ["all", *map(self.node, condition.parts)]

    @node.register
    def _(self, condition: Not) -> Node:
        return ["not", self.node(condition.part)]
