"""Draw a contact sheet of each kind of motion: ``python docs/motion.py site/motion``.

The command simulates every scene, writes one PNG file for each and a page that shows them all with
their deepest contact and their largest gain of energy. The files are not committed.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from html import escape
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import vfwidget as vf
from vfwidget.export.page import page

ROOT = Path(__file__).parents[1]
FLOOR = [(-2000, -300), (4000, -300), (4000, 0), (-2000, 0)]
STYLE = "body { max-width: 60rem; margin: 2rem auto; font-family: sans-serif } img { width: 100% }"


def bounce() -> vf.Animation:
    """A letter falls, is squashed by the floor, and bounces (Fig. 1 and 12b of the paper)."""
    text = vf.Text("roboto-flex", "O", axes={"wght": 600}, offsets=[(0, 900)])
    return _simulated(text, 80, forces=(0, -6000), restitution=0.7, stiffness=60)


def stack() -> vf.Animation:
    """Three letters fall onto each other, stay, and come to rest (Fig. 12a)."""
    text = vf.Text("recursive", "HEO", axes={"wght": 800}, shared=False)
    places = [(30 * (-1) ** i - g.x, 20 + 740 * i) for i, g in enumerate(text.layout)]
    return _simulated(text.at(offsets=places), 60, forces=(0, -4000), restitution=0.1)


def push() -> vf.Animation:
    """A bar pushes a word aside (Fig. 12c)."""

    def bar(time: float) -> list[list[tuple[float, float]]]:
        x = -200 + min(1500 * time, 600)
        return [[(x - 100, 60), (x, 60), (x, 420), (x - 100, 420)], FLOOR]

    text = vf.Text("recursive", "in", axes={"wght": 500}, shared=False)
    return _simulated(text, 36, forces=(0, -4000), obstacles=bar)


def topple() -> vf.Animation:
    """A letter lands on its corner, tips over and comes to rest; its axes and its angle move."""
    text = vf.Text("recursive", "H", offsets=[(0, 700)], rotations=[0.4])
    return _simulated(text, 110, forces=(0, -6000), rotations=True)


def keyframes() -> vf.Animation:
    """A solved edit is a keyframe, and a delay sends it through the word as a wave (Fig. 10c)."""
    rest = vf.Text("roboto-flex", "hello", axes={"wght": 500})
    top = rest.nearest(100, 1500)
    x, y = rest.position(top).tolist()
    lifted = vf.solve(rest, [vf.Target(top, (x, y + 120)), vf.StayClose()]).text
    return vf.Animation.from_keyframes([(0, rest), (0.4, lifted), (0.8, rest)], delay=0.12)


SCENES: tuple[Callable[[], vf.Animation], ...] = (bounce, stack, push, topple, keyframes)


def _simulated(text: vf.Text, steps: int, **options: object) -> vf.Animation:
    options.setdefault("obstacles", [FLOOR])
    return vf.simulate(text, steps, positions=True, progress=False, **options)


def build(target: Path) -> None:
    """Write a PNG file for each scene, and ``index.html``."""
    target.mkdir(parents=True, exist_ok=True)
    parts = ["<h1>Type that moves</h1>"]
    for scene in SCENES:
        animation = scene()
        vf.plot.frames(animation, 12)
        plt.gcf().savefig(target / f"{scene.__name__}.png", dpi=150)
        plt.close("all")
        about = escape(scene.__doc__ or "")
        numbers = f"{len(animation)} frames, {animation.duration:.2f} s"
        if animation.energy is not None:
            gain = max(np.diff(animation.energy).max() / np.ptp(animation.energy), 0.0)
            numbers += f"; deepest contact {animation.penetration.max():.3f} font units"
            # A bar that pushes letters gives them energy.
            if scene is not push:
                numbers += f"; largest gain of energy in a frame {gain:.1e} of its range"
        print(f"{scene.__name__}: {numbers}", flush=True)
        parts.append(
            f'<h2>{scene.__name__}</h2><p>{about} {numbers}.</p><img src="{scene.__name__}.png" '
            f'alt="{about}">'
        )
    made = page("Type that moves: contact sheets", f"<main>{''.join(parts)}</main>", [], STYLE)
    (target / "index.html").write_text(made, encoding="utf-8")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("target", type=Path, nargs="?", default=ROOT / "site" / "motion")
    build(parser.parse_args().target)
