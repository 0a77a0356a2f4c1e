"""Arrays in, tensors out: numpy inside for speed on small problems, torch at the public surface.

The maths is written once, in operations that numpy and torch spell alike; :func:`namespace`
says which of the two an array belongs to. torch loads on first use.
"""

from __future__ import annotations

import sys
from types import ModuleType
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

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
    """``value`` as a float64 tensor; a floating-point tensor passes through with its graph."""
    import torch

    if isinstance(value, torch.Tensor):
        return value if value.is_floating_point() else value.double()
    return torch.tensor(np.asarray(value, dtype=np.float64))


def to_array(value: Any) -> Array:
    """``value`` as a float64 numpy array, cut from any autograd graph."""
    if is_tensor(value):
        value = value.detach().cpu().numpy()
    return np.asarray(value, dtype=np.float64)


def like(value: Any, reference: Any) -> Any:
    """``value`` as an array of the kind, dtype and device of ``reference``."""
    # Arrays among arrays are the hot path of a drag.
    if type(reference) is np.ndarray and type(value) is np.ndarray:
        return value
    if not is_tensor(reference):
        return to_array(value)
    import torch

    return torch.as_tensor(value, dtype=reference.dtype, device=reference.device)
