"""Arrays in, tensors out: numpy inside for speed on small problems, torch at the public surface.

The maths is written once, in operations that numpy and torch spell alike; :func:`namespace`
says which of the two an array belongs to. torch loads on first use.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from types import ModuleType
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from .errors import VFWidgetError

if TYPE_CHECKING:
    import torch

Array: TypeAlias = npt.NDArray[np.float64]
"""A float64 numpy array."""
IntArray: TypeAlias = npt.NDArray[np.intp]
"""A numpy array of indices."""
BoolArray: TypeAlias = npt.NDArray[np.bool_]
"""A numpy mask."""
ArrayLike: TypeAlias = "npt.ArrayLike | torch.Tensor"
"""Anything a caller may pass for numbers: lists, arrays, tensors."""


def _use_one_thread_after_fork() -> None:
    """Let torch compute in one thread in a forked process.

    Threads do not survive a fork. If torch has used several in the parent process, it would wait
    for them in the child for ever. torch's own data loader takes the same measure.
    """
    torch = sys.modules.get("torch")
    if torch is not None:
        torch.set_num_threads(1)


if hasattr(os, "register_at_fork"):  # not on Windows
    os.register_at_fork(after_in_child=_use_one_thread_after_fork)


def is_tensor(value: Any) -> bool:
    """Whether ``value`` is a torch tensor, without importing torch to find out."""
    torch = sys.modules.get("torch")
    return torch is not None and isinstance(value, torch.Tensor)


def namespace(value: Any) -> ModuleType:
    """The module whose functions work on ``value``: ``torch`` for a tensor, else ``numpy``."""
    if type(value) is np.ndarray:
        return np
    return sys.modules["torch"] if is_tensor(value) else np


def to_tensor(value: Any) -> torch.Tensor:
    """``value`` as a float64 tensor; a floating-point tensor passes through with its graph.

    Raises
    ------
    VFWidgetError
        The numbers are complex.
    """
    import torch

    if isinstance(value, torch.Tensor):
        if value.is_complex():
            raise _complex(value.dtype)
        return value if value.is_floating_point() else value.double()
    # A copy of its own, for torch warns of arrays that are read-only.
    return torch.from_numpy(np.array(to_array(value)))


def to_array(value: Any) -> Array:
    """``value`` as a float64 numpy array, cut from any autograd graph.

    Raises
    ------
    VFWidgetError
        The numbers are complex, too large for floating point, or on a device without memory.
    """
    if type(value) is np.ndarray and value.dtype == np.float64:
        return value
    if is_tensor(value):
        if value.is_meta:
            raise VFWidgetError("Numbers must have values; received a tensor of the meta device.")
        value = value.detach().cpu().numpy()
    array = np.asarray(value)
    if array.dtype.kind == "c":
        raise _complex(array.dtype)
    try:
        return array.astype(np.float64, copy=False)
    except OverflowError:
        raise VFWidgetError("Numbers must be below 1.8e308; received a larger integer.") from None


def _complex(dtype: Any) -> VFWidgetError:
    return VFWidgetError(f"Numbers must be real; received numbers of type {dtype}.")


def like(value: Any, reference: Any) -> Any:
    """``value`` as an array of the kind, dtype and device of ``reference``."""
    # Arrays among arrays are the hot path of a drag.
    if type(reference) is np.ndarray and type(value) is np.ndarray:
        return value
    if not is_tensor(reference):
        return to_array(value)
    import torch

    return torch.as_tensor(value, dtype=reference.dtype, device=reference.device)


def padded_table(rows: Sequence[Array]) -> Array:
    """Rows of numbers as one table, (n, q), padded with infinity; the last column is infinite."""
    table = np.full((len(rows), max((len(row) for row in rows), default=0) + 1), np.inf)
    for i, row in enumerate(rows):
        table[i, : len(row)] = row
    return table


def rotation_matrices(angles: Any) -> Array:
    """The matrices (..., 2, 2) of counter-clockwise rotations by angles (...) in radians."""
    cos, sin = np.cos(angles), np.sin(angles)
    return np.stack([cos, -sin, sin, cos], -1).reshape(*np.shape(angles), 2, 2)


def holds_anywhere(mask: BoolArray) -> bool:
    """Whether a mask of any shape holds somewhere; for a small one much quicker than ``any``."""
    return True in mask.tobytes()


def holds_everywhere(mask: BoolArray) -> bool:
    """Whether a mask of any shape holds everywhere; for a small one much quicker than ``all``."""
    return False not in mask.tobytes()


def integers(value: Any) -> Any:
    """Whole numbers as indices."""
    return value.astype(np.intp) if type(value) is np.ndarray else value.long()


def count_up(length: int, reference: Any) -> Any:
    """The indices 0 … length - 1, where ``reference`` lives."""
    if type(reference) is np.ndarray:
        return np.arange(length)
    return namespace(reference).arange(length, device=reference.device)


def zeros(length: int, reference: Any) -> Any:
    """As many zeros, of the type and where ``reference`` is."""
    if type(reference) is np.ndarray:
        return np.zeros(length, reference.dtype)
    return reference.new_zeros(length)


def take(values: Any, index: Any) -> Any:
    """``values[..., index]``, the quickest way there is."""
    if type(values) is np.ndarray:
        return values.take(index, -1)
    return values.index_select(-1, index)


def rows_of(values: Any, index: IntArray) -> Any:
    """``values[..., index, :]``, which is much quicker this way in numpy."""
    if type(values) is np.ndarray:
        return values.take(index, -2)
    return values[..., index, :]


def stacked(parts: Sequence[Any]) -> Any:
    """Values (…) side by side along a new first dimension; quicker than numpy's own stack."""
    if type(parts[0]) is np.ndarray:
        return np.array(parts)
    return namespace(parts[0]).stack(parts)


def at_least_zero(values: Any) -> Any:
    """0 in place of what is negative."""
    return np.maximum(values, 0.0) if type(values) is np.ndarray else values.clamp(0)


def between(values: Any, low: Any, high: Any) -> Any:
    """The nearest to each value of what is between two others; twice as fast as numpy's clip."""
    if type(values) is np.ndarray:
        return np.minimum(np.maximum(values, low), high)
    return values.clamp(low, high)


def following(values: Any) -> Any:
    """Each value's follower along the last dimension; the last one's is the first."""
    return namespace(values).concatenate([values[..., 1:], values[..., :1]], -1)


def where_true(mask: Any) -> Any:
    """The indices (p,) at which a mask (q,) holds."""
    return mask.nonzero()[0] if type(mask) is np.ndarray else mask.nonzero()[:, 0]


def begins(values: Any) -> Any:
    """Where a run of equal values (q,) begins, a mask (q,)."""
    if type(values) is np.ndarray:
        mask = np.empty(len(values), dtype=bool)
        mask[:1] = True
        np.not_equal(values[1:], values[:-1], mask[1:])
        return mask
    mask = values != namespace(values).concatenate([values[:1], values[:-1]])
    mask[:1] = True
    return mask


def ascending(values: Any) -> Any:
    """The order (q,) that sorts values (q,); numpy's stable sort is quick where runs are sorted."""
    return values.argsort(kind="stable") if type(values) is np.ndarray else values.argsort()


def lexicographic(major: Any, minor: Any) -> Any:
    """The order (q,) that sorts by ``major`` (q,), and where that is equal by ``minor`` (q,)."""
    if type(minor) is np.ndarray:
        return np.lexsort((minor, major))
    order = minor.argsort(stable=True)
    return take(order, take(major, order).argsort(stable=True))


def repeat(counts: Any) -> Any:
    """Each index i, ``counts[i]`` times over."""
    if type(counts) is np.ndarray:
        return np.arange(len(counts)).repeat(counts)
    return namespace(counts).repeat_interleave(counts)


def expand(begin: Any, counts: Any) -> tuple[Any, Any]:
    """All (i, begin[i] + k) with 0 ≤ k < counts[i], in order."""
    i = repeat(counts)
    before = counts.cumsum(0) - counts
    return i, take(begin - before, i) + count_up(len(i), counts)


def sum_at(index: Any, values: Any, length: int) -> Any:
    """Sums (…, length) of the values (…, q) that have the same index (q,)."""
    if type(values) is not np.ndarray:
        return values.new_zeros((*values.shape[:-1], length)).index_add_(-1, index, values)
    if values.ndim == 1:
        return np.bincount(index, values, length)
    if not len(index):
        return np.zeros((*values.shape[:-1], length), values.dtype)
    rows = values.reshape(-1, values.shape[-1])
    flat = index + length * np.arange(len(rows))[:, None]
    sums = np.bincount(flat.ravel(), rows.ravel(), length * len(rows))
    return sums.reshape(*values.shape[:-1], length)


def sum_runs(index: Any, values: Any, length: int) -> Any:
    """As :func:`sum_at`, for indices in ascending order, which numpy sums twice as fast."""
    if type(values) is not np.ndarray or not len(index):
        return sum_at(index, values, length)
    run = where_true(begins(index))
    sums = np.zeros((*values.shape[:-1], length), values.dtype)
    sums[..., take(index, run)] = np.add.reduceat(values, run, -1)
    return sums


def add_at(sums: Any, index: Any, values: Any) -> None:
    """Add the values (q,) to those sums (p,) that the index (q,) names, in place."""
    if type(sums) is np.ndarray:
        np.add.at(sums, index, values)
    else:
        sums.index_add_(0, index, values)


def running_maximum(values: Any) -> Any:
    """Largest values up to each place along the first dimension."""
    if type(values) is np.ndarray:
        return np.maximum.accumulate(values)
    return values.cummax(0).values


def running_sum(values: Any, low: float, high: float) -> None:
    """Put sums up to each place along the last dimension, limited to low … high, in place.

    numpy's own functions take three times as long.
    """
    if type(values) is np.ndarray:
        import torch

        values = torch.from_numpy(values)
    values.cumsum_(-1).clamp_(low, high)
