"""Derivatives of a term's residual by torch, for terms that define none."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arrays import Array, is_tensor, to_array, to_tensor
from ..errors import SolveError

if TYPE_CHECKING:
    import torch

Function = Callable[[Any, Any], Any]


def value_of(residual: Function, points: Array, theta: Array, kind: str) -> Array:
    """The residual (r,) of a term that is written in torch operations.

    Raises
    ------
    SolveError
        The result is no tensor.
    """
    return to_array(_as_vector(residual(to_tensor(points), to_tensor(theta)), kind))


def derivative_of(
    residual: Function, points: Array, theta: Array, kind: str
) -> tuple[Array, Array]:
    """Derivatives of a residual (r,) by the points, (r, p, 2), and by Θ, (r, l, n).

    Forward mode where there are fewer inputs than residuals, else reverse mode.

    Raises
    ------
    SolveError
        The residual is not computed from its arguments by torch operations.
    """
    import torch

    # Jupyter may run this on a thread whose grad mode was never set.
    with torch.enable_grad():
        inputs = tuple(to_tensor(values).clone().requires_grad_() for values in (points, theta))
        value = _as_vector(_in_torch(residual, inputs, kind), kind)
        if not len(value):
            return np.zeros((0, *points.shape)), np.zeros((0, *theta.shape))
        if not value.requires_grad:
            raise SolveError(
                f"The residual of {kind} does not depend on its arguments through torch "
                "operations, so it cannot be differentiated. Compute it from points and theta "
                "without detach(), item() or torch.tensor(), or define derivative()."
            )
        if len(value) <= points.size + theta.size:
            rows = [_backward(entry, inputs) for entry in value]
            by_points, by_theta = (torch.stack(side) for side in zip(*rows, strict=True))
        else:
            vector = _vector_function(residual, kind)
            plain = tuple(values.detach() for values in inputs)
            by_points, by_theta = torch.func.jacfwd(vector, argnums=(0, 1))(*plain)
    return to_array(by_points), to_array(by_theta)


def _in_torch(residual: Function, inputs: tuple[torch.Tensor, ...], kind: str) -> Any:
    """The residual at tensors that require a gradient.

    Raises
    ------
    SolveError
        It makes arrays of them, which torch refuses.
    """
    try:
        return residual(*inputs)
    except RuntimeError as error:
        if "numpy()" not in str(error):
            raise
        raise SolveError(
            f"The residual of {kind} uses numpy, which cannot be differentiated. Write it in torch "
            "operations, such as torch.sin for np.sin, or define derivative()."
        ) from error


def _backward(entry: torch.Tensor, inputs: tuple[torch.Tensor, ...]) -> tuple[torch.Tensor, ...]:
    import torch

    return torch.autograd.grad(
        entry, inputs, retain_graph=True, allow_unused=True, materialize_grads=True
    )


def _vector_function(residual: Function, kind: str) -> Function:
    return lambda points, theta: _as_vector(residual(points, theta), kind)


def _as_vector(value: Any, kind: str) -> torch.Tensor:
    if not is_tensor(value):
        raise SolveError(
            f"The residual of {kind} must return a tensor, not {type(value).__name__}: {kind} "
            "defines no derivative, so it is called with tensors and differentiated by torch."
        )
    if value.is_complex():
        raise SolveError(f"The residual of {kind} must be real numbers, not {value.dtype}.")
    tensor: torch.Tensor = value.reshape(-1)
    return tensor
