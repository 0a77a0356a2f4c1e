"""Letters that fall onto a floor, for tests of simulations."""

from __future__ import annotations

from typing import Any

import vfwidget as vf

FLOOR = [(-3000, -600), (4000, -600), (4000, 0), (-3000, 0)]
G = 6000.0
"""Font units per s²."""


def simulated(text: vf.Text, steps: int, **options: Any) -> vf.Animation:
    """A simulation without a progress bar."""
    return vf.simulate(text, steps, progress=False, **options)


def fallen(text: vf.Text, steps: int, **options: Any) -> vf.Animation:
    """Letters that move freely under gravity above the floor."""
    usual = {"forces": (0, -G), "obstacles": [FLOOR], "positions": True}
    return simulated(text, steps, **{**usual, **options})
