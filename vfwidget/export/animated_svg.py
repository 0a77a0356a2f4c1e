"""Outlines in motion as an animated SVG (SMIL), which runs without a script."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arrays import Array
from ..outline.paint import Palette
from .css import number, seconds
from .paint import filled
from .svg import drawn, path_data, plain
from .track import Track, keyframes, shapes_at

OBSTACLE_OPACITY = 0.35
"""Obstacles are drawn lighter than letters."""
SHADE = f' opacity="{OBSTACLE_OPACITY}"'


def animated_picture(
    letters: Sequence[Track],
    obstacles: Sequence[Track],
    *,
    title: str,
    box: tuple[float, float, float, float],
    times: Array,
    tolerance: float,
    loop: bool,
    palette: Palette = (),
    height: float | None = None,
    background: str | None = None,
) -> str:
    """Write an SVG document whose outlines move.

    Parameters
    ----------
    letters, obstacles : sequences of Track
    title : str
        Plain text; markup in it is escaped.
    box : (left, bottom, right, top)
        The part of the plane that the picture shows, in font units, y up.
    times : (T,) array
        Seconds from the start to each frame.
    tolerance : float
        As in :func:`~vfwidget.export.track.keyframes`.
    loop : bool
        Whether the animation repeats without end.
    palette : palette, optional
        The colours that paints refer to.
    height : float, optional
        Height of the picture in pixels. By default the picture takes the size of its container.
    background : str, optional
        A CSS colour. By default the picture is transparent.

    Returns
    -------
    str
        A reader who prefers reduced motion sees the last frame.
    """
    clock = _Clock(times, loop)
    layers = [(SHADE, obstacles), ("", letters)]
    moving = []
    for shade, tracks in layers:
        paths = [
            clock.shape(track, tolerance, palette, f"layer-{i}") for i, track in enumerate(tracks)
        ]
        if paths:
            moving.append(f"<g{shade}>{''.join(paths)}</g>")
    body = (
        "<style>.still { display: none } "
        "@media (prefers-reduced-motion: reduce) { .still { display: inline } "
        f'.moving {{ display: none }} }}</style><g class="moving">{"".join(moving)}</g>'
        f'<g class="still">{_frame(layers, len(times) - 1, palette)}</g>'
    )
    return _document(body, title, box, height, background)


def still_picture(
    letters: Sequence[Track],
    obstacles: Sequence[Track],
    frame: int,
    *,
    title: str,
    box: tuple[float, float, float, float],
    palette: Palette = (),
    height: float | None = None,
    background: str | None = None,
) -> str:
    """Write one frame as an SVG document; see :func:`animated_picture`."""
    body = _frame([(SHADE, obstacles), ("", letters)], frame, palette)
    return _document(body, title, box, height, background)


def _document(
    body: str,
    title: str,
    box: tuple[float, float, float, float],
    height: float | None,
    background: str | None,
) -> str:
    left, bottom, right, top = box
    wide, tall = right - left, top - bottom
    size = f' width="{height * wide / tall:.0f}" height="{height:.0f}"' if height else ""
    view = " ".join(map(number, (left, -top, wide, tall)))
    back = (
        f'<rect x="{number(left)}" y="{number(-top)}" width="100%" height="100%" '
        f'fill="{plain(background)}"/>'
        if background is not None
        else ""
    )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{view}"{size} role="img">'
        f"<title>{plain(title)}</title>{back}{body}</svg>"
    )


def _frame(layers: Sequence[tuple[str, Sequence[Track]]], frame: int, palette: Palette) -> str:
    """One group for each layer."""
    return "".join(
        f"<g{shade}>{drawn(shapes_at(tracks, frame), palette, f'still-{frame}')}</g>"
        for shade, tracks in layers
    )


class _Clock:
    """The timing that all animated attributes share."""

    def __init__(self, times: Array, loop: bool) -> None:
        self.times, self.duration = times, float(times[-1]) or 1.0
        self.run = f'dur="{seconds(self.duration)}" ' + (
            'repeatCount="indefinite"' if loop else 'fill="freeze"'
        )

    def shape(self, track: Track, tolerance: float, palette: Palette, name: str) -> str:
        """A path that moves, turns and changes, and shows only while its track lasts."""
        if not track.constant_fill:
            return self._flipped(track, palette, name)
        keys = keyframes(track, tolerance)
        times = track.times[keys] / self.duration
        places = [f"{number(x)} {number(-y)}" for x, y in track.origins[keys]]
        moves = self._transform("translate", "replace", places, times)
        angles = [number(-np.degrees(angle)) for angle in track.rotations[keys]]
        if any(angle != "0" for angle in angles):
            moves += self._transform("rotate", "sum", angles, times)
        paths = [path_data(track.local(key)) for key in keys]
        form = self._animate('animate attributeName="d"', paths, times)
        shown = self._visibility(track.start, len(track.times))
        if track.fills is None:
            return f'<path d="{paths[0]}">{shown}{moves}{form}</path>'
        contours = [contour for key in keys for contour in track.local(key)]
        layer = filled(paths[0], contours, track.fills[0], palette, name, form)
        return f"<g>{shown}{moves}{layer}</g>"

    def _flipped(self, track: Track, palette: Palette, name: str) -> str:
        """One picture for each frame, because SVG cannot animate every number of a gradient."""
        frames = range(track.start, track.start + len(track.times))
        return "".join(
            f"<g>{self._visibility(frame, 1)}"
            f"{drawn([track.shape(frame)], palette, f'{name}-{frame}')}</g>"
            for frame in frames
        )

    def _transform(self, kind: str, additive: str, values: list[str], times: Array) -> str:
        name = f'animateTransform attributeName="transform" type="{kind}" additive="{additive}"'
        return self._animate(name, values, times, always=True)

    def _animate(self, what: str, values: list[str], times: Array, always: bool = False) -> str:
        """An animation element through values at shares of the duration."""
        if len(set(values)) == 1:
            if not always:
                return ""
            values, times = values[:1] * 2, np.array([0.0, 1.0])
        at = [number(time) for time in times]
        # The list has to reach from 0 to 1.
        if at[0] != "0":
            values, at = [values[0], *values], ["0", *at]
        if at[-1] != "1":
            values, at = [*values, values[-1]], [*at, "1"]
        return f'<{what} values="{";".join(values)}" keyTimes="{";".join(at)}" {self.run}/>'

    def _visibility(self, first: int, count: int) -> str:
        """Hides a path before and after some frames; each is shown until the next one begins."""
        begins, ends = first == 0, first + count == len(self.times)
        if begins and ends:
            return ""
        start = 0.0 if begins else self.times[first] / self.duration
        end = 1.0 if ends else self.times[first + count] / self.duration
        states = [("hidden", 0.0)] if start > 0 else []
        states += [("visible", start), *([("hidden", end)] if end < 1 else [])]
        values = ";".join(state for state, _ in states)
        at = ";".join(number(time) for _, time in states)
        return (
            f'<animate attributeName="visibility" calcMode="discrete" values="{values}" '
            f'keyTimes="{at}" {self.run}/>'
        )
