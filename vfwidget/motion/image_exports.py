"""What an animation can be written as in pixels: GIF, MP4, WebM and a sequence of PNG files."""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import Any, TypeAlias

from ..errors import MotionError
from ..export.images import gif, over, png, read_colour, video
from ..files import write_numbered, written
from ..text.inputs import read_flag
from .frames import FPS, drawn_frames
from .numbers import read_number

PathLike: TypeAlias = "str | os.PathLike[str]"
GIF_FPS = 25.0
"""GIF keeps whole hundredths of a second, and browsers slow down frames of less than two."""
VIDEO_FPS = 60.0
"""Most frames per second of a video, unless stated otherwise."""


class ImageExports:
    """Methods of :class:`Animation` that draw its frames."""

    fps: Any

    def to_gif(
        self,
        path: PathLike | None = None,
        *,
        height: int = 240,
        fps: float = GIF_FPS,
        loop: bool = True,
        ink: str = "black",
        background: str = "white",
        progress: bool = True,
    ) -> bytes | None:
        """Write an animated GIF.

        Parameters
        ----------
        path : str or path, optional
            The file to write.
        height : int
            Pixels. Default 240.
        fps : float
            Frames per second. Default 25. A frame takes a whole number of
            1/100 s, at least 2.
        loop : bool
            Whether the animation repeats without end. Default True.
        ink, background : str
            Colours as in CSS. Default black on white. Colour glyphs take the first palette of the
            font.
        progress : bool
            Whether to show a progress bar. Default True.

        Raises
        ------
        MotionError
            An option has no meaning, or the animation stands still for more than 655.35 s.
        ImageError
            The images are too large.
        OSError
            The file cannot be written.
        """
        delay = max(round(100 / read_number("fps", fps, *FPS, open_below=False)), 2)
        # Without a background the images would be transparent.
        read_colour("background", background)
        images = self._images(height, 100 / delay, ink, background, progress)
        return written(gif(images, 10 * delay, read_flag("loop", loop, MotionError)), path)

    def to_mp4(
        self,
        path: PathLike | None = None,
        *,
        height: int = 480,
        fps: float | None = None,
        ink: str = "black",
        background: str = "white",
        progress: bool = True,
    ) -> bytes | None:
        """Write an MP4 video (H.264). It needs ffmpeg: ``pip install 'vfwidget[video]'``.

        Parameters
        ----------
        path : str or path, optional
            The file to write.
        height : int
            Pixels, rounded up to an even number. Default 480.
        fps : float, optional
            Frames per second. Default: those of the animation, 60 at most.
        ink, background, progress
            As for :meth:`to_gif`.

        Raises
        ------
        MotionError
            An option has no meaning, or ffmpeg is missing or fails.
        ImageError
            The images are too large.
        OSError
            The file cannot be written.
        """
        return written(self._video("mp4", height, fps, ink, background, progress), path)

    def to_webm(
        self,
        path: PathLike | None = None,
        *,
        height: int = 480,
        fps: float | None = None,
        ink: str = "black",
        background: str | None = None,
        progress: bool = True,
    ) -> bytes | None:
        """Write a WebM video (VP9), transparent unless there is a background.

        Parameters
        ----------
        background : str, optional
            Default: none.
        path, height, fps, ink, progress
            As for :meth:`to_mp4`, which also says what is raised.

        Raises
        ------
        OSError
            The file cannot be written.
        """
        return written(self._video("webm", height, fps, ink, background, progress), path)

    def to_png(
        self,
        folder: PathLike,
        *,
        height: int = 480,
        fps: float | None = None,
        ink: str = "black",
        background: str | None = None,
        progress: bool = True,
    ) -> None:
        """Write every frame as a PNG file, ``frame-0001.png`` and so on, into a folder.

        Parameters
        ----------
        folder : str or path
            It is made if it does not exist. Files of these names are replaced.
        background : str, optional
            Default: none, so that the images are transparent.
        height, fps, ink, progress
            As for :meth:`to_mp4`.

        Raises
        ------
        OSError
            The file cannot be written.
        """
        images = self._images(height, self._rate(fps), ink, background, progress)
        write_numbered(folder, map(png, images), "png")

    def _video(
        self,
        kind: str,
        height: int,
        fps: float | None,
        ink: str,
        background: str | None,
        progress: bool,
    ) -> bytes:
        rate = self._rate(fps)
        return video(self._images(height, rate, ink, background, progress), kind, rate)

    def _rate(self, fps: float | None) -> float:
        return min(self.fps, VIDEO_FPS) if fps is None else fps

    def _images(
        self, height: int, fps: float, ink: str, background: str | None, progress: bool
    ) -> Iterator[Any]:
        front = read_colour("ink", ink)
        back = None if background is None else read_colour("background", background)
        frames = drawn_frames(self, height, fps, front, progress)
        return (over(frame, back) for frame in frames)
