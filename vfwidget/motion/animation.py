"""Frames of one text in time."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from ..arrays import Array, ArrayLike
from ..energy import Term, solve
from ..errors import MotionError
from ..outline.coordinates import check_coordinates
from ..text import Text
from ..text.place import AXES, OFFSETS, ROTATIONS
from .diagnostics import Diagnostics
from .exports import Exports
from .keyframes import Easing, check_same, read_delays, read_easing, read_keyframes, transitions
from .numbers import check_frames, read_array, read_count, read_number, read_scenery
from .tracks import offsets_of

Scenery = Sequence[Sequence[Array]]
"""For each frame, the closed contours (s, 4, 2) of the obstacles, in font units."""


class Animation(Diagnostics, Exports):
    """One text at T times; it is immutable.

    :func:`~vfwidget.simulate`, :meth:`from_keyframes` and :meth:`from_terms` make animations.
    ``animation[i]`` is frame i as a :class:`Text`, and a slice of frames is an Animation. All
    parameters are attributes too.

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
        Rotation of each letter about its own origin, in radians, counterclockwise. Default:
        that of ``text``.
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

    Warns
    -----
    AxisWarning
        A number of ``theta`` lies outside -1 … 1; it is clamped.
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
        self.times = read_array("times", times)
        count, letters = self.times.size, len(text.glyphs)
        if self.times.ndim != 1 or not count or not (self.times[1:] > self.times[:-1]).all():
            raise MotionError(
                f"times must be an increasing sequence of seconds; received {times!r:.200}."
            )
        theta = read_array("theta", theta, (count, *text.coordinates.shape))
        self.theta = read_array("theta", check_coordinates(theta, theta.shape[-1]))
        if offsets is None:
            offsets = np.repeat(text.place[OFFSETS][None], count, axis=0)
        self.offsets = read_array("offsets", offsets, (count, letters, 2))
        if rotations is None:
            rotations = np.repeat(text.rotations[None], count, axis=0)
        self.rotations = read_array("rotations", rotations, (count, letters))
        if penetration is None:
            penetration = np.zeros(count)
        self.penetration = read_array("penetration", penetration, (count,), math.inf)
        self.energy = None
        if energy is not None:
            self.energy = read_array("energy", energy, (count,), math.inf)
        self.scenery = read_scenery(((),) * count if scenery is None else scenery, count)

    def __len__(self) -> int:
        """The number of frames, T."""
        return len(self.times)

    def __getitem__(self, index: Any) -> Any:
        """A frame as a :class:`Text`; a slice of frames as an :class:`Animation`."""
        try:
            found: Any = range(len(self))[index]
        except (TypeError, ValueError, IndexError):
            found = None
        if isinstance(index, slice):
            if not found or found.step < 0:
                raise MotionError(
                    "A slice of an animation must hold frames in the order of time; "
                    f"received {index}."
                )
            return self._picked(index, self.times[index])
        if found is None:
            raise MotionError(
                f"The animation has frames 0 to {len(self) - 1}, which may also be counted "
                f"from the end, -1; received {index!r:.200}."
            )
        unknowns = {AXES: self.theta, OFFSETS: self.offsets, ROTATIONS: self.rotations}
        place = {name: values[found] for name, values in unknowns.items()}
        return self.text.moved_to({**self.text.place, **place})

    def __iter__(self) -> Iterator[Text]:
        """The frames in the order of time."""
        return (self[i] for i in range(len(self)))

    def at(self, time: float) -> Text:
        """The text at a time in seconds, interpolated between two frames.

        Before the first frame and after the last one, it stands still.

        Raises
        ------
        MotionError
            The time is not a finite number.
        """
        return self._sampled(np.array([read_number("time", time, -math.inf, math.inf, False)]))[0]

    @classmethod
    def from_keyframes(
        cls,
        keyframes: Sequence[tuple[float, Text]],
        easing: Easing = "ease-in-out",
        delay: Any = 0.0,
        fps: float = 60.0,
    ) -> Animation:
        """An animation that passes through given states, such as the results of solves.

        Parameters
        ----------
        keyframes : sequence of (seconds, Text)
            States of one text, in the order of time. Axes, offsets and rotations are interpolated.
        easing : str, four numbers or function
            How each transition speeds up and slows down: "linear", "ease", "ease-in", "ease-out",
            "ease-in-out" (the default) or the numbers of ``cubic-bezier``, as in CSS. A function
            maps the part of the time to the part of the way. Axes that would leave their range
            stay at its end.
        delay : float or (l,) array
            Seconds by which each letter starts after the one before, or its own delay. Letters
            that share their axes get axes of their own then. Default 0.
        fps : float
            Frames per second. Default 60.

        Raises
        ------
        MotionError
            The texts are not states of one text, the times do not increase, or another argument
            is not what is described above.

        Examples
        --------
        >>> import vfwidget as vf
        >>> thin = vf.Text("recursive", "wave", axes={"wght": 300})
        >>> wave = vf.Animation.from_keyframes(
        ...     [(0, thin), (0.5, thin.at(axes={"wght": 900})), (1, thin)], delay=0.1)
        >>> wave
        <Animation of 'wave': 79 frames, 1.3 s>
        """
        times, texts = read_keyframes(keyframes)
        rate = read_number("fps", fps, 0.0, math.inf, True)
        delays = read_delays(delay, len(texts[0].glyphs))
        if delays.any() and texts[0].shared:
            texts = [text.at(shared=False) for text in texts]
        return cls(texts[0], *transitions(times, texts, delays, easing, rate))

    @classmethod
    def from_terms(
        cls,
        text: Text,
        terms: Callable[[float], Term | Sequence[Term]],
        duration: float,
        fps: float = 60.0,
        free: Sequence[str] = (AXES,),
    ) -> Animation:
        """An animation in which every frame is solved for, such as a target that moves.

        Parameters
        ----------
        text : Text
            Where the first solve starts.
        terms : function of the time
            Returns the terms at a time in seconds, as for :func:`~vfwidget.solve`. Each solve
            starts from the frame before.
        duration, fps : float
            Seconds, and frames per second (default 60).
        free : sequence of str
            The blocks of unknowns that may move, as for :func:`~vfwidget.solve`.

        Raises
        ------
        MotionError
            The duration or ``fps`` is not a number > 0, or ``terms`` is not a function.
        SolveError
            A term is not valid for this text.
        """
        length = read_number("duration", duration, 0.0, math.inf, True)
        rate = read_number("fps", fps, 0.0, math.inf, True)
        if not callable(terms):
            raise MotionError(
                "terms must be a function of the time in seconds that returns terms; received "
                f"{terms!r:.200}. Terms that stay the same can be written as lambda time: terms."
            )
        check_frames(length * rate + 1)
        times = np.arange(int(length * rate + 1e-9) + 1) / rate
        frames = [text]
        for time in times:
            frames.append(solve(frames[-1], terms(float(time)), free=free, restarts=0).text)
        theta = [frame.coordinates for frame in frames[1:]]
        return cls(
            text, times, np.array(theta), np.array([offsets_of(f, text) for f in frames[1:]])
        )

    def chain(self, *others: Animation) -> Animation:
        """Put other animations of the same text after this one; each starts one frame later.

        Raises
        ------
        MotionError
            An argument is not an Animation, or the animations show different texts.
        """
        result = self
        for other in others:
            self._check_other(other)
            start = result.times[-1] + 1 / result.fps - other.times[0]
            result = result._joined(other._retimed(other.times + start))
        return result

    def overlay(self, other: Animation) -> Animation:
        """Add the motion of another animation of the same text.

        The motion is the difference from the first frame of the other animation. Axes that would
        leave their range stay at its end.

        Raises
        ------
        MotionError
            ``other`` is not an Animation, or the animations show different texts.
        """
        self._check_other(other)
        times = np.union1d(self.times, other.times)
        base, more = self._sampled(times), other._sampled(times)
        theta, offsets, rotations = (
            getattr(base, name) + getattr(more, name) - getattr(other, name)[0]
            for name in ("theta", "offsets", "rotations")
        )
        theta = np.clip(theta, *self.text.font.bounds)
        return Animation(self.text, times, theta, offsets, rotations, scenery=base.scenery)

    def loop(self, count: int = 2) -> Animation:
        """Repeat the animation, so that it runs ``count`` times.

        Raises
        ------
        MotionError
            ``count`` is not a whole number ≥ 1.
        """
        times = read_count("count", count)
        check_frames(len(self) * times)
        return self.chain(*[self] * (times - 1))

    def reverse(self) -> Animation:
        """Run the animation backwards, over the same time."""
        order = np.arange(len(self))[::-1]
        return self._picked(order, self.times[0] + self.times[-1] - self.times[order])

    def retime(
        self,
        duration: float | None = None,
        easing: Easing = "linear",
        fps: float | None = None,
    ) -> Animation:
        """Run the animation at another speed.

        Parameters
        ----------
        duration : float, optional
            Seconds from the first to the last frame. Default: as before.
        easing : as for :meth:`from_keyframes`
            Maps the part of the new time to the part of the old one. Default "linear".
        fps : float, optional
            Frames per second. Default: as before.

        Raises
        ------
        MotionError
            A number is not > 0, or the easing is unknown.
        """
        rate = self.fps if fps is None else read_number("fps", fps, 0.0, math.inf, True)
        length = self.duration
        if duration is not None:
            length = read_number("duration", duration, 0.0, math.inf, True)
        check_frames(length * rate + 1)
        parts = np.linspace(0, 1, max(round(length * rate), 1) + 1)
        if length == 0:
            return self
        there = self.times[0] + np.clip(read_easing(easing)(parts), 0, 1) * self.duration
        return self._sampled(there)._retimed(self.times[0] + parts * length)

    def _check_other(self, other: Any) -> None:
        if not isinstance(other, Animation):
            raise MotionError(f"Pass another Animation; received {type(other).__name__}.")
        check_same(self.text, other.text)

    def _sampled(self, times: Array) -> Animation:
        """The animation at given times, interpolated; the result keeps their order as indices."""
        times = np.clip(times, self.times[0], self.times[-1])
        after = np.clip(np.searchsorted(self.times, times), 1, max(len(self) - 1, 1))
        after = np.minimum(after, len(self) - 1)
        before = np.maximum(after - 1, 0)
        span = self.times[after] - self.times[before]
        part = np.clip((times - self.times[before]) / np.where(span > 0, span, 1), 0, 1)

        def mixed(values: Array) -> Array:
            share = part.reshape(-1, *[1] * (values.ndim - 1))
            return np.asarray((1 - share) * values[before] + share * values[after])

        nearest = np.where(part < 0.5, before, after)
        return Animation(
            self.text,
            np.arange(len(times)),
            mixed(self.theta),
            mixed(self.offsets),
            mixed(self.rotations),
            mixed(self.penetration),
            None if self.energy is None else mixed(self.energy),
            [self.scenery[i] for i in nearest],
        )

    def _picked(self, index: Any, times: Array) -> Animation:
        """Some frames at given times."""
        return Animation(
            self.text,
            times,
            self.theta[index],
            self.offsets[index],
            self.rotations[index],
            self.penetration[index],
            None if self.energy is None else self.energy[index],
            [self.scenery[i] for i in np.arange(len(self))[index]],
        )

    def _retimed(self, times: Array) -> Animation:
        return self._picked(slice(None), times)

    def _joined(self, other: Animation) -> Animation:
        times, theta, offsets, rotations, penetration = (
            np.concatenate([getattr(one, name) for one in (self, other)])
            for name in ("times", "theta", "offsets", "rotations", "penetration")
        )
        energy = None
        if self.energy is not None and other.energy is not None:
            energy = np.concatenate([self.energy, other.energy])
        scenery = [*self.scenery, *other.scenery]
        return Animation(self.text, times, theta, offsets, rotations, penetration, energy, scenery)

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
