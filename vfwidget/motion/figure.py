"""An animation as curves over time."""

from __future__ import annotations

from typing import Any

from ..errors import MotionError


def draw_animation(animation: Any, axes: Any = None) -> Any:
    """Axes, heights, energy and penetration; see :meth:`vfwidget.Animation.plot`."""
    import matplotlib.pyplot as plt
    import numpy as np

    if axes is None:
        _, axes = plt.subplots(2, 2, figsize=(10, 5.4), layout="constrained", sharex=True)
    try:
        panels = np.ravel(np.asarray(axes, dtype=object))
    except (TypeError, RuntimeError):
        panels = np.ravel([])
    if len(panels) != 4 or not all(hasattr(panel, "set_title") for panel in panels):
        raise MotionError(f"axes must be four matplotlib Axes; received {axes!r:.200}.")
    theta, height, energy, depth = panels
    times = animation.times
    for i, axis in enumerate(animation.text.font.axes):
        values = animation.theta[..., i]
        if np.ptp(values, axis=0).max() > 0:
            lines = theta.plot(times, values, color=f"C{i % 10}", lw=1.2)
            lines[0].set_label(axis.tag)
    if theta.lines:
        theta.legend(fontsize="small", ncols=2)
    theta.set_title("axes, normalized")
    names = animation.text.word.distinct_names
    for letter, name in enumerate(names):
        (line,) = height.plot(times, animation.positions[:, letter, 1], lw=1.2)
        line.set_label(name)
    if len(names) <= 8:
        height.legend(fontsize="small", ncols=2)
    height.set_title("height of the origins, font units")
    if animation.energy is not None:
        energy.plot(times, animation.energy - animation.energy.min(), color="#0072b2", lw=1.2)
    energy.set_title("energy above its least value")
    depth.plot(times, animation.penetration, color="#d55e00", lw=1.2)
    depth.set_ylim(0, max(0.5, 1.1 * float(animation.penetration.max())))
    depth.set_title("deepest contact, font units")
    for panel in (energy, depth):
        panel.set_xlabel("seconds")
    return panels
