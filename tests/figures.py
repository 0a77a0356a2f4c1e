"""What a figure holds, for the tests of figures."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.patches import PathPatch
from matplotlib.quiver import Quiver

import vfwidget as vf

FONTS = vf.bundled_fonts()
BLUE, VERMILLION, GREEN, ORANGE = "#0072b2", "#d55e00", "#009e73", "#e69f00"


def normalized(font, **axes):
    return font.normalize(axes).numpy()


def index(font, tag):
    return [axis.tag for axis in font.axes].index(tag)


def some_place(font):
    """User values off the default, inside and at the ends, by turns."""
    parts = [0.3, 1, 0.8, 0]
    return {
        axis.tag: axis.minimum + parts[i % 4] * (axis.maximum - axis.minimum)
        for i, axis in enumerate(font.axes)
    }


def filled(ax):
    return [patch for patch in ax.patches if isinstance(patch, PathPatch)]


def vertices(contours):
    """Contours (s, 4, 2) as the points a pen goes through, back at the start."""
    parts = [np.zeros((0, 2))]
    for cubics in contours:
        cubics = np.asarray(cubics)
        parts += [cubics[0, :1], cubics[:, 1:].reshape(-1, 2), cubics[0, :1]]
    return np.concatenate(parts)


def arrows(ax, colour=None):
    """Where arrows start and what they are, (p, 2) each, of one colour."""
    found = [c for c in ax.collections if isinstance(c, Quiver)]
    found = [c for c in found if colour is None or to_hex(c.get_facecolor()[0]) == colour]
    return (
        np.concatenate([c.XY for c in found]),
        np.concatenate([np.stack([c.U, c.V], -1) for c in found]),
    )


def heading(ax):
    """Title and notes of a figure of one Axes, or of what panels are in."""
    if isinstance(ax, Axes):
        return ax.get_title(), ax.get_xlabel()
    return ax[0].figure.get_suptitle(), ax[0].figure.get_supxlabel()
