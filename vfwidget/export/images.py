"""Images, frame after frame, as PNG, GIF, MP4 and WebM."""

from __future__ import annotations

import io
import tempfile
from collections.abc import Generator, Iterable
from pathlib import Path

import numpy as np
import numpy.typing as npt

from ..arrays import Array
from ..errors import MotionError

Colour = tuple[int, int, int]
Pixels = npt.NDArray[np.uint8]

CODECS = {
    "mp4": ("libx264", "yuv420p", ["-crf", "16", "-movflags", "+faststart"]),
    "webm": (
        "libvpx-vp9",
        "yuva420p",
        ["-crf", "20", "-b:v", "0", "-auto-alt-ref", "0", "-cpu-used", "4", "-row-mt", "1"],
    ),
}
"""Codec, pixel format and options of ffmpeg for each kind of file."""


def read_colour(name: str, value: str) -> Colour:
    """A colour as CSS writes it, such as ``"#d4380d"`` or ``"tomato"``.

    Raises
    ------
    MotionError
        It is no colour, or a transparent one.
    """
    from PIL import ImageColor

    try:
        parts = ImageColor.getrgb(value)
    except (ValueError, TypeError, AttributeError):
        parts = ()  # type: ignore[assignment]
    if len(parts) != 3:
        raise MotionError(
            f"{name} must be an opaque colour such as 'black' or '#1f6feb'; received {value!r}."
        )
    return parts


def over(image: Array, background: Colour | None) -> Pixels:
    """An image over a background, (H, W, 3), or without one, (H, W, 4).

    Parameters
    ----------
    image : (H, W, 4) array
        Red, green, blue and alpha, 0 to 1 each, not premultiplied.
    background : (red, green, blue), 0 to 255 each, or None
    """
    if background is None:
        return _bytes(255 * image)
    alpha = image[..., 3:]
    return _bytes(255 * image[..., :3] * alpha + np.array(background) * (1 - alpha))


def _bytes(values: Array) -> Pixels:
    return np.round(values).clip(0, 255).astype(np.uint8)


def png(pixels: Pixels) -> bytes:
    """A PNG file."""
    from PIL import Image

    file = io.BytesIO()
    Image.fromarray(pixels).save(file, "PNG")
    return file.getvalue()


def gif(frames: Iterable[Pixels], delay: int, loop: bool) -> bytes:
    """An animated GIF file, with at most 256 colours in each frame.

    Parameters
    ----------
    frames : iterable of (H, W, 3) arrays
    delay : int
        Milliseconds for which each frame is shown; GIF keeps whole hundredths of a second.
    loop : bool
        Whether the animation repeats without end.

    Raises
    ------
    MotionError
        Equal frames follow each other for more than 655.35 s.
    """
    from PIL import Image

    images = [Image.fromarray(pixels).quantize(dither=Image.Dither.NONE) for pixels in frames]
    file = io.BytesIO()
    repeats = {"loop": 0} if loop else {}
    try:
        images[0].save(
            file, "GIF", save_all=True, append_images=images[1:], duration=delay, optimize=False,
            **repeats,
        )  # fmt: skip
    except OverflowError:
        # Frames that are equal become one, and its duration is a number of two bytes.
        raise MotionError(
            "The animation stands still for longer than a GIF can show one picture, which is "
            "655.35 s. Use to_mp4 or to_webm, or slices of the animation."
        ) from None
    return file.getvalue()


def video(frames: Iterable[Pixels], kind: str, fps: float) -> bytes:
    """An MP4 (H.264) or WebM (VP9, with transparency) file.

    Parameters
    ----------
    frames : iterable of (H, W, 3) or (H, W, 4) arrays
        H and W are even.
    kind : {"mp4", "webm"}
    fps : float
        Frames per second.

    Raises
    ------
    MotionError
        ffmpeg is not installed, or fails.
    """
    try:
        import imageio_ffmpeg

        imageio_ffmpeg.get_ffmpeg_exe()
    except (ImportError, RuntimeError):
        raise MotionError(
            "MP4 and WebM are written by ffmpeg, which is not installed. Install it with "
            "`pip install 'vfwidget[video]'`, or use to_gif."
        ) from None
    codec, pixel_format, options = CODECS[kind]
    with tempfile.TemporaryDirectory() as folder:
        # ffmpeg takes some names for options or addresses, so it never sees one that was given.
        file = Path(folder) / f"animation.{kind}"
        writer: Generator[None, Pixels, None] | None = None
        try:
            for pixels in frames:
                if writer is None:
                    height, width, channels = pixels.shape
                    writer = imageio_ffmpeg.write_frames(
                        str(file),
                        (width, height),
                        pix_fmt_in="rgba" if channels == 4 else "rgb24",
                        pix_fmt_out=pixel_format,
                        fps=fps,
                        codec=codec,
                        quality=None,
                        macro_block_size=2,
                        output_params=options,
                    )
                    next(writer)
                writer.send(np.ascontiguousarray(pixels))
        except OSError as error:
            raise MotionError(f"ffmpeg could not write the video: {error}") from error
        finally:
            if writer is not None:
                writer.close()
        if not file.is_file():
            raise MotionError(f"ffmpeg could not write the video with the codec {codec}.")
        return file.read_bytes()
