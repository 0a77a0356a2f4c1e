"""How a drawing of Chromium differs from artwork."""

from __future__ import annotations

import base64
import io
from typing import Any

import numpy as np
import torch
from PIL import Image

import vfwidget as vf

SIZE = 200
HALF_COVERED = 0.4
"""A pixel differs if its coverage differs by more; edges differ by less."""


def differing(body: str, browser: Any) -> int:
    """Pixels of a document of SIZE × SIZE that differ; it must have an area."""
    size = f'width="{SIZE}" height="{SIZE}"'
    source = f'<svg xmlns="http://www.w3.org/2000/svg" {size}>{body}</svg>'
    page = browser.new_page(viewport={"width": SIZE, "height": SIZE})
    page.goto("data:image/svg+xml;base64," + base64.b64encode(source.encode()).decode())
    drawn = coverage(page.screenshot(omit_background=True))
    page.close()
    contours = [torch.tensor(contour) for contour in vf.Artwork(source).contours]
    down = np.array([[1.0, 0, 0], [0, -1, 0]])
    ours = vf.rasterize(contours, size=(SIZE, SIZE), transform=down).numpy()
    assert drawn.sum() > 1000
    return int((abs(ours - drawn) > HALF_COVERED).sum())


def coverage(image: bytes) -> np.ndarray:
    """The ink of a picture, black on nothing, in 0 … 1."""
    pixels = np.asarray(Image.open(io.BytesIO(image)).convert("RGBA")) / 255
    return pixels[..., 3] * (1 - pixels[..., :3].min(-1))
