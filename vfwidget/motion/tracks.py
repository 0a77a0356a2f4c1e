"""An animation as plain arrays, one track for each outline: what the exports write."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..arrays import Array, to_array
from ..export.svg import MARGIN
from ..export.track import Track
from ..outline.paint import Palette
from ..text import Text
from ..text.colours import palette_of
from ..text.place import OFFSETS, TRACKING

if TYPE_CHECKING:
    from ..font import Font, Glyph

Box = tuple[float, float, float, float]
"""Left, bottom, right and top, in font units, y up."""


class Outlines(NamedTuple):
    """Everything that an animation draws.

    Attributes
    ----------
    letters, obstacles : list of Track
        From back to front; a colour glyph has one for each layer.
    box : (left, bottom, right, top)
        See :func:`drawn_box`.
    palette : palette
        The first one of the font.
    """

    letters: list[Track]
    obstacles: list[Track]
    box: Box
    palette: Palette


def outlines(animation: Any) -> Outlines:
    """The outlines of all frames, with their paint."""
    tracks = letter_tracks(animation)
    letters = [layer for row in tracks for track in row for layer in track.painted]
    palette = palette_of(animation.text.font, 0)
    return Outlines(letters, obstacle_tracks(animation), drawn_box(animation, tracks), palette)


def letter_tracks(animation: Any) -> list[list[Track]]:
    """For each letter its tracks, one for each row of frames in which it keeps its glyph.

    Parameters
    ----------
    animation : Animation
    """
    frames = list(animation)
    layouts = [frame.layout for frame in frames]
    users = user_coordinates(animation)
    letters = []
    for letter in range(max(map(len, layouts))):
        glyphs = [row[letter].glyph_id if letter < len(row) else None for row in layouts]
        # A ligature that is made or dissolved changes which letter has this number.
        kinds = list(zip(glyphs, map(len, layouts), strict=True))
        letters.append(
            [
                _letter_track(animation, layouts, users, letter, span)
                for span in _spans(kinds)
                if glyphs[span.start] is not None
            ]
        )
    return letters


def user_coordinates(animation: Any) -> Array:
    """User coordinates of the axes at each frame, (T, 1 or l, n)."""
    axes, theta = animation.text.font.axes, animation.theta
    users = [
        [axis.denormalize(float(w)) for w in theta[..., i].flat] for i, axis in enumerate(axes)
    ]
    return np.reshape(np.transpose(users), theta.shape)


def offsets_of(frame: Text, text: Text) -> Array:
    """The offsets (l, 2) with which the letters of a text stand as in a frame.

    A frame with another tracking is one with other offsets, because all frames of an animation have
    the tracking of its text.
    """
    plain = text.moved_to({**frame.place, TRACKING: text.place[TRACKING]})
    pairs = zip(frame.layout, plain.layout, strict=True)
    shifts = np.array([(own.x - other.x, own.y - other.y) for own, other in pairs])
    return np.asarray(frame.place[OFFSETS] + shifts)


def obstacle_tracks(animation: Any) -> list[Track]:
    """The contours of the obstacles; one track as long as they correspond."""
    sizes = [tuple(len(contour) for contour in contours) for contours in animation.scenery]
    times = animation.times - animation.times[0]
    tracks = []
    for span in _spans(sizes):
        if sizes[span.start]:
            rows = [animation.scenery[i] for i in range(span.start, span.stop)]
            points = [np.concatenate([c[:, :3].reshape(-1, 2) for c in row]) for row in rows]
            zeros = np.zeros((len(rows), 3))
            tracks.append(
                Track(
                    span.start,
                    times[span],
                    sizes[span.start],
                    np.array(points),
                    zeros[:, :2],
                    zeros[:, 2],
                    zeros[:, :0],
                )
            )
    return tracks


def drawn_box(animation: Any, tracks: Sequence[Sequence[Track]]) -> Box:
    """The part of the plane that all letters and the first line reach, with a margin.

    Parameters
    ----------
    animation : Animation
    tracks : sequence of sequences of Track
        As :func:`letter_tracks` gives them.
    """
    font = animation.text.font
    line = np.array([[0.0, font.descender], [0.0, font.ascender]])
    painted = [layer for row in tracks for track in row for layer in track.painted]
    points = np.concatenate([line, *(track.drawn.reshape(-1, 2) for track in painted)])
    margin = MARGIN * (font.ascender - font.descender)
    left, bottom, right, top = map(float, [*points.min(0) - margin, *points.max(0) + margin])
    return left, bottom, right, top


def _spans(kinds: list[Any]) -> Iterator[slice]:
    """Maximal rows of equal entries."""
    start = 0
    for end in range(1, len(kinds) + 1):
        if end == len(kinds) or kinds[end] != kinds[start]:
            yield slice(start, end)
            start = end


def _letter_track(
    animation: Any, layouts: list[Any], users: Array, letter: int, span: slice
) -> Track:
    placed = [row[letter] for row in layouts[span]]
    font, glyph = animation.text.font, placed[0].glyph
    own = 0 if animation.text.shared else letter
    theta = animation.theta[span, own]
    track = Track(
        span.start,
        animation.times[span] - animation.times[0],
        tuple(glyph.contours),
        to_array(glyph.points(theta)),
        np.array([(one.x, one.y) for one in placed]),
        animation.rotations[span, min(letter, animation.rotations.shape[1] - 1)],
        users[span, own],
        _Outline(font, glyph),
    )
    layers = [
        replace(
            track,
            sizes=tuple(layer.glyph.contours),
            points=to_array(layer.glyph.points(theta)),
            evaluate=_Outline(font, layer.glyph),
            fills=[layer.paint.at(w) for w in theta],
        )
        for layer in glyph.layers
    ]
    return replace(track, layers=tuple(layers))


class _Outline:
    """The control points of a glyph at user coordinates."""

    def __init__(self, font: Font, glyph: Glyph) -> None:
        self._axes, self._glyph = font.axes, glyph

    def __call__(self, users: Array) -> Array:
        columns = [
            [axis.normalize(float(value)) for value in column]
            for axis, column in zip(self._axes, users.T, strict=True)
        ]
        return to_array(self._glyph.points(np.array(columns).T))
