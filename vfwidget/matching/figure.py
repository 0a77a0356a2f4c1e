"""How a match came out, as a figure."""

from __future__ import annotations

from typing import Any


def draw_match(match: Any, axes: Any = None) -> Any:
    """The picture, the fit, the residual and the loss; see :meth:`vfwidget.Match.plot`."""
    import matplotlib.pyplot as plt
    import numpy as np
    from matplotlib.ticker import LogLocator, MaxNLocator, NullLocator

    if axes is None:
        _, axes = plt.subplots(1, 4, figsize=(13, 3.4), layout="constrained")
    given, fitted, left, loss = np.ravel(axes)
    grey = {"cmap": "gray", "vmin": 0, "vmax": 1}
    given.imshow(match.target, **grey)
    given.set_title("picture")
    fitted.imshow(match.image.numpy(), **grey)
    fitted.set_title(f"{match.text.font.family_name}: {100 * match.score:.1f} % explained")
    most = max(0.05, float(match.residual.abs().max()))
    drawn = left.imshow(match.residual.numpy(), cmap="RdBu", vmin=-most, vmax=most)
    left.figure.colorbar(drawn, ax=left, shrink=0.8)
    left.set_title("fit − picture")
    for panel in (given, fitted, left):
        panel.set_axis_off()
    losses = [value for _, value in match.history]
    loss.semilogy(losses, marker=".", color="#0072b2")
    loss.yaxis.set_major_locator(LogLocator(numticks=6))
    loss.yaxis.set_minor_locator(NullLocator())
    loss.xaxis.set_major_locator(MaxNLocator(5, integer=True))
    loss.set_xlabel("step")
    loss.set_title("loss")
    return np.ravel(axes)
