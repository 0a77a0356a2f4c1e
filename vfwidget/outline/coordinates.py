"""What callers pass as normalized coordinates, checked once and in one way."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..arrays import ArrayLike, to_tensor
from ..errors import AxisError, warn_clamped

if TYPE_CHECKING:
    import torch


def check_coordinates(w: ArrayLike, n: int) -> torch.Tensor:
    """``w`` as a float64 tensor (..., n) within -1 … 1.

    Raises
    ------
    AxisError
        The last dimension is not n, or an entry is not finite.

    Warns
    -----
    AxisWarning
        An entry lies outside -1 … 1; it is clamped.
    """
    try:
        # In float32 a hair's breadth beside a breakpoint is the breakpoint itself.
        w = to_tensor(w).double()
    except (TypeError, ValueError, RuntimeError):
        raise AxisError(f"Normalized coordinates must be {n} numbers; received {w!r}.") from None
    if w.ndim == 0 or w.shape[-1] != n:
        raise AxisError(f"This font has {n} axes; received coordinates of shape {tuple(w.shape)}.")
    try:
        finite = bool(w.isfinite().all())
        inside = bool((w.abs() <= 1).all())
    except RuntimeError:
        # Under vmap the values cannot be looked at, but they can be clamped.
        return w.clip(-1, 1)
    if not finite:
        raise AxisError("Normalized coordinates must be finite numbers; received NaN or infinity.")
    if not inside:
        warn_clamped("Normalized coordinates outside -1 … 1 were clamped.")
        w = w.clip(-1, 1)
    return w
