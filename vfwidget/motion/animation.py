"""Frames of one text in time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from ..arrays import Array, ArrayLike, to_array
from ..errors import MotionError
from ..text import Text
from ..text.place import AXES, OFFSETS
from .exports import Exports

Scenery = Sequence[Sequence[Array]]
"""For each frame, the closed contours (s, 4, 2) of the obstacles, in font units."""


class Animation(Exports):
    """One text at T times; it is immutable.

    :func:`~vfwidget.simulate` and :meth:`from_keyframes` make animations.

    Parameters
    ----------
    text : Text
        The animated text, as it was at the start.
    times : (T,) array
        Time of each frame in seconds, increasing; T ≥ 1.
    theta : (T, p, n) array
        Normalized coordinates; p is 1 if the letters share their axes, else l.
    offsets : (T, l, 2) array, optional
        Displacement of each letter from the position that the layout gives it, in font units.
        Default: that of ``text``.
    rotations : (T, l) array, optional
        Rotation of each letter about its own origin, in radians, counterclockwise. Default 0.
    penetration : (T,) array, optional
        Depth of the deepest contact, in font units. Default 0.
    energy : (T,) array, optional
        Total mechanical energy. Default: None, because keyframes have none.
    scenery : sequence of T sequences of (s, 4, 2) arrays, optional
        The contours of the obstacles at each frame. Default: no obstacles.

    Raises
    ------
    MotionError
        A shape is wrong, a number is not finite, or the times do not increase.
    """

    def __init__(
        self,
        text: Text,
        times: ArrayLike,
        theta: ArrayLike,
        offsets: ArrayLike | None = None,
        rotations: ArrayLike | None = None,
        penetration: ArrayLike | None = None,
        energy: ArrayLike | None = None,
        scenery: Scenery | None = None,
    ) -> None:
        if not isinstance(text, Text):
            raise MotionError(f"text must be a Text; received {type(text).__name__}.")
        self.text = text
        self.times = _frozen("times", times)
        count, letters = self.times.size, len(text.glyphs)
        if self.times.ndim != 1 or not count or not (np.diff(self.times) > 0).all():
            raise MotionError(
                f"times must be an increasing sequence of seconds; received {times!r:.200}."
            )
        self.theta = _frozen("theta", theta, (count, *text.coordinates.shape))
        if offsets is None:
            offsets = np.repeat(text.place[OFFSETS][None], count, axis=0)
        self.offsets = _frozen("offsets", offsets, (count, letters, 2))
        if rotations is None:
            rotations = np.zeros((count, letters))
        self.rotations = _frozen("rotations", rotations, (count, letters))
        if penetration is None:
            penetration = np.zeros(count)
        self.penetration = _frozen("penetration", penetration, (count,))
        self.energy = None if energy is None else _frozen("energy", energy, (count,))
        self.scenery = ((),) * count if scenery is None else tuple(map(tuple, scenery))
        if len(self.scenery) != count:
            raise MotionError(
                f"scenery must hold the contours of each of the {count} frames; it has "
                f"{len(self.scenery)} entries."
            )

    def __len__(self) -> int:
        """The number of frames, T."""
        return len(self.times)

    def __getitem__(self, index: Any) -> Any:
        """A frame as a :class:`Text`; a slice of frames as an :class:`Animation`."""
        if not isinstance(index, slice):
            place = {AXES: self.theta[index], OFFSETS: self.offsets[index]}
            return self.text.moved_to({**self.text.place, **place})
        if not len(range(*index.indices(len(self)))) or (index.step or 1) < 0:
            raise MotionError(
                f"A slice of an animation must hold frames in the order of time; received {index}."
            )
        return Animation(
            self.text,
            self.times[index],
            self.theta[index],
            self.offsets[index],
            self.rotations[index],
            self.penetration[index],
            None if self.energy is None else self.energy[index],
            self.scenery[index],
        )

    def __iter__(self) -> Iterator[Text]:
        """The frames in the order of time."""
        return (self[i] for i in range(len(self)))

    @property
    def duration(self) -> float:
        """Seconds from the first frame to the last one."""
        return float(self.times[-1] - self.times[0])

    @property
    def fps(self) -> float:
        """Frames per second, on average; 60 for a single frame."""
        return (len(self) - 1) / self.duration if len(self) > 1 else 60.0

    @cached_property
    def positions(self) -> Array:
        """The origin of each letter as drawn, (T, l, 2), in font units."""
        return np.array([[(g.x, g.y) for g in frame.layout] for frame in self])

    def __repr__(self) -> str:
        return f"<Animation of {self.text.string!r}: {len(self)} frames, {self.duration:.4g} s>"


def _frozen(name: str, values: Any, shape: tuple[int, ...] | None = None) -> Array:
    """A read-only copy as a float64 array.

    Raises
    ------
    MotionError
        The shape is another one, or a number is not finite.
    """
    try:
        array = np.array(to_array(values))
    except (TypeError, ValueError, RuntimeError):
        array = np.full((), np.nan)
    if shape is not None and array.shape != shape:
        raise MotionError(f"{name} must be numbers of shape {shape}; received {array.shape}.")
    if not np.isfinite(array).all():
        raise MotionError(f"{name} must be finite numbers; received {values!r:.200}.")
    array.flags.writeable = False
    return array
