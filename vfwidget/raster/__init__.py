"""Outlines to images: exact coverage with exact gradients, and an adapter to diffvg."""

from .rasterize import frame, image_and_jacobian, rasterize

__all__ = ["frame", "image_and_jacobian", "rasterize"]
