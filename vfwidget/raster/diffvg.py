"""The paper's rasteriser behind the same call: diffvg (Li, Lukáč, Gharbi, Ragan-Kelley 2020)."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from types import ModuleType

import torch
from torch import Tensor

from ..errors import ImageError

SAMPLES = 2
"""Per pixel, in x and in y: the paper's own setting."""


def render(points: Tensor, sizes: Sequence[int], height: int, width: int) -> Tensor:
    """Images (B, H, W) of points (B, S, 4, 2), from random samples; gradients pass.

    Raises
    ------
    ImageError
        ``pydiffvg`` cannot be imported.
    """
    pydiffvg = _import()
    pydiffvg.set_use_gpu(points.device.type == "cuda")
    images = [_render(pydiffvg, image, sizes, height, width) for image in points.float()]
    return torch.stack(images).to(points.dtype)


def _import() -> ModuleType:
    try:
        return import_module("pydiffvg")
    except ImportError as error:
        raise ImageError(
            'backend="diffvg" needs pydiffvg, which no package index offers: build it from '
            'github.com/BachiLi/diffvg. backend="exact" needs nothing and is faster.'
        ) from error


def _render(
    pydiffvg: ModuleType, points: Tensor, sizes: Sequence[int], height: int, width: int
) -> Tensor:
    # One path for each contour, in one group: windings add up across them.
    paths = [
        pydiffvg.Path(
            num_control_points=torch.full((len(contour),), 2, dtype=torch.int32),
            points=contour[:, :3].reshape(-1, 2).contiguous(),
            is_closed=True,
            stroke_width=torch.tensor(0.0),
        )
        for contour in points.split(list(sizes))
    ]
    group = pydiffvg.ShapeGroup(
        shape_ids=torch.arange(len(paths)), fill_color=torch.ones(4), use_even_odd_rule=False
    )
    scene = pydiffvg.RenderFunction.serialize_scene(width, height, paths, [group])
    image = pydiffvg.RenderFunction.apply(width, height, SAMPLES, SAMPLES, 0, None, *scene)
    return image[..., 3]
