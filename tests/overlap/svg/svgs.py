"""Documents of SVG around a few shapes."""

from __future__ import annotations

import vfwidget as vf
from vfwidget.overlap.shape import read_obstacles

NAMESPACES = 'xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink"'
ONE = '<rect id="one" width="1" height="1"/>'
"""A square that every document draws, so that it is not empty."""
MANY = '<use href="#p"/>' * 2000
"""So many uses of a shape."""


def artwork(body, attributes=""):
    return vf.Artwork(f"<svg {NAMESPACES} {attributes}>{body}</svg>")


def area(body, attributes=""):
    return read_obstacles([artwork(body, attributes)])[0].area()
