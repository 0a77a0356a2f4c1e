"""What a finished motion should be doubted for: deep contacts, and letters that were thrown."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from ..arrays import Array
from ..errors import MotionWarning, warn_caller
from .animation import Animation
from .start import DEEP

THROWN = 10.0
"""A letter that is so many times as fast as all causes of its speed together was squeezed out."""
LEAST_THROW = 20.0
"""Em per second. No slower letter counts as thrown."""


def warn_of_depth(animation: Animation) -> None:
    """Say which frame has the deepest contact, if it is deeper than what counts as resolved."""
    deep = np.flatnonzero(animation.penetration > DEEP)
    if len(deep):
        worst = int(animation.penetration.argmax())
        warn_caller(
            f"In {len(deep)} of {len(animation)} frames, shapes enter each other by more than "
            f"{DEEP} font units: by {animation.penetration[worst]:.3g} in frame {worst} (at "
            f"{animation.times[worst]:.4g} s). Give the letters more room or a shorter dt.",
            MotionWarning,
        )


def warn_of_throws(animation: Animation, gains: Array) -> None:
    """Say which letter left closing obstacles at a speed that nothing but the squeeze explains.

    Parameters
    ----------
    animation : Animation
    gains : (T,) array
        The speed that forces and impulses can have added until each frame.
    """
    if len(animation) < 2:
        return
    moved = [_largest_motion(*pair) for pair in pairwise(animation.scenery)]
    if not any(moved):
        # The positions of letters in all frames take long to compute.
        return
    intervals = np.diff(animation.times)
    steps = np.linalg.norm(np.diff(animation.positions, axis=0), axis=2)
    speeds = (steps / intervals[:, None]).max(1)
    # Letters that an obstacle covers when it appears are moved out at once.
    same = np.array([motion is not None for motion in moved])
    walls = np.maximum.accumulate([motion or 0.0 for motion in moved] / intervals)
    least = LEAST_THROW * animation.text.font.units_per_em
    limit = np.maximum(THROWN * (walls + gains[1:]), least)
    frames = np.flatnonzero((speeds > limit) & (walls > 0) & same)
    if len(frames):
        frame = int(frames[0])
        letter = int(steps[frame].argmax())
        name = animation.text.word.letter_names[letter]
        warn_caller(
            f"Obstacles that close in squeezed letter {letter} ({name!r}) out at "
            f"{speeds[frame]:.3g} font units per second, {speeds[frame] / walls[frame]:.0f} times "
            f"as fast as any of them moves, in frame {frame + 1} (at "
            f"{animation.times[frame + 1]:.4g} s). The later frames are not plausible. Leave room "
            "for the letters between the obstacles.",
            MotionWarning,
        )


def _largest_motion(before: Sequence[Array], after: Sequence[Array]) -> float | None:
    """How far the fastest point of the obstacles moves; None if they are not the same ones."""
    if [one.shape for one in before] != [one.shape for one in after]:
        return None
    pairs = zip(before, after, strict=True)
    motions = [np.linalg.norm(b - a, axis=2).max() for a, b in pairs if a is not b]
    return float(max(motions, default=0.0))
