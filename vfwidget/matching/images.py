"""Pictures of letters as arrays: read, made smaller, and parted into paper and ink."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from PIL import Image, ImageOps

from ..arrays import Array, is_tensor
from ..errors import ImageError
from ..limits import limits

if TYPE_CHECKING:
    import torch

ImageSource: TypeAlias = "Array | torch.Tensor | Image.Image | str | os.PathLike[str]"

FORMATS = (
    *("PNG", "JPEG", "JPEG2000", "GIF", "BMP", "TIFF", "WEBP", "AVIF", "PPM", "TGA"),
    *("ICO", "PCX", "QOI", "DDS", "SGI"),
)
"""Formats of image files that are read. EPS is not, because Pillow runs Ghostscript to read it."""
STRIP_PIXELS = 2**20
"""Pixels that are converted at a time."""
SHAPES = "An image is (H, W) or (H, W, 3 or 4)"
LEAST_CONTRAST = 0.02
"""Of full range; less is no picture of letters."""
LUMA = np.array([0.2126, 0.7152, 0.0722])
"""Of red, green and blue (ITU-R BT.709)."""
SAMPLES = 64
"""Rows and columns, at least, by which noise is told."""
GAUSSIAN_MEDIAN = 0.6745
"""Of a standard normal variable's size."""
ROUNDS, MOST_INK = 12, 0.9
"""Of telling ink from paper, and the share of ink beyond which there is no paper to tell."""


def read_image(image: ImageSource) -> Array:
    """Read an image as grey levels (H, W) in 0 … 1, where 1 is white.

    Parameters
    ----------
    image : (H, W), (H, W, 3) or (H, W, 4) array or tensor, PIL image, or path
        Floats are in 0 … 1; unsigned integers fill the range of their type. Colour becomes
        luminance, and transparent pixels become white.

    Raises
    ------
    ImageError
        The file is not an image, the image has no pixels or more than ``limits.image_pixels``, a
        value is NaN or out of range, or the shape is wrong.
    """
    if isinstance(image, str | os.PathLike):
        return _read_file(Path(image))
    if isinstance(image, Image.Image):
        return _read_pil(image)
    return _read_array(_from_tensor(image) if is_tensor(image) else image)


def _read_file(path: Path) -> Array:
    try:
        # A pipe or a device may never end.
        if path.exists() and not path.is_file():
            raise OSError("it is not a regular file")
        with warnings.catch_warnings():
            # The size is checked here, against our own limit.
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)
            with Image.open(path, formats=FORMATS) as image:
                # Before the pixels are unpacked.
                _check_size(image.height, image.width)
                return _read_pil(ImageOps.exif_transpose(image))
    except ImageError:
        raise
    except Exception as error:
        # A damaged file can fail anywhere in the decoder, with any exception.
        raise ImageError(f"{path} cannot be read as an image ({error}).") from error


def _read_pil(image: Image.Image) -> Array:
    _check_size(image.height, image.width)
    whole = image.mode.startswith("I")

    def strip(top: int, bottom: int) -> Any:
        part = image.crop((0, top, image.width, bottom))
        values = np.asarray(part if whole or image.mode == "F" else part.convert(_channels(image)))
        if whole and (values.min() < 0 or values.max() > 0xFFFF):
            raise ImageError("Integers of a PIL image have 16 bits: 0 … 65,535.")
        return values.astype(np.uint16) if whole else values

    try:
        return _by_strips(strip, image.height, image.width)
    except ImageError:
        raise
    except Exception as error:
        raise ImageError(f"The image is damaged or truncated ({error}).") from error


def _channels(image: Image.Image) -> str:
    """The mode with the fewest channels that keeps all that is visible."""
    if "transparency" in image.info:
        return "RGBA"
    if image.mode in ("1", "L"):
        return "L"
    return "RGB" if image.mode in ("RGB", "CMYK", "YCbCr") else "RGBA"


def _from_tensor(image: Any) -> Any:
    if image.is_nested:
        raise ImageError(
            "A nested tensor cannot be read as an image. Convert it to a dense tensor (H, W)."
        )
    # An expanded tensor can have any shape without using memory, but its copy needs the memory.
    _check_shape(tuple(image.shape))
    try:
        image = image.detach().cpu()
        # numpy has no bfloat16.
        return (image.double() if image.is_floating_point() else image).numpy()
    except (TypeError, ValueError, RuntimeError, NotImplementedError) as error:
        raise ImageError(
            f"A tensor of type {image.dtype} and layout {image.layout} on device {image.device} "
            "cannot be read as an image. Convert it to a dense tensor on the CPU."
        ) from error


def _read_array(image: Any) -> Array:
    try:
        values = np.asarray(image)
    except (TypeError, ValueError) as error:
        raise ImageError(f"{SHAPES}, not ragged ({error}).") from error
    _check_shape(values.shape)
    return _by_strips(lambda top, bottom: values[top:bottom], *values.shape[:2])


def _by_strips(strip: Callable[[int, int], Any], height: int, width: int) -> Array:
    """Grey levels of an image that is converted a few rows at a time, because this saves memory.

    ``strip(top, bottom)`` returns the values of some rows.
    """
    grey = np.empty((height, width))
    rows = max(1, STRIP_PIXELS // width)
    for top in range(0, height, rows):
        bottom = min(top + rows, height)
        grey[top:bottom] = _to_grey(_to_unit(strip(top, bottom)))
    return grey


def _to_grey(values: Array) -> Array:
    """Grey levels (H, W) of values with up to four channels; what is transparent is white."""
    if values.ndim == 3 and values.shape[-1] in (2, 4):
        # The luminance of a blend is the blend of the luminances.
        opacity = values[..., -1]
        return _to_grey(values[..., :-1]) * opacity + 1 - opacity
    if values.ndim == 3:
        return values @ LUMA if values.shape[-1] == 3 else values[..., 0]
    return values


def _to_unit(values: Any) -> Array:
    if values.dtype == bool:
        return values.astype(np.float64)
    if np.issubdtype(values.dtype, np.unsignedinteger):
        return np.asarray(values / float(np.iinfo(values.dtype).max))
    try:
        # numpy would drop the imaginary part of complex numbers.
        values = values.astype(np.float64, casting="same_kind")
    except (TypeError, ValueError):
        raise ImageError(f"An image holds numbers, not {values.dtype}.") from None
    if not np.isfinite(values).all():
        raise ImageError("The image holds NaN or infinity.")
    if values.min() < -0.5 or values.max() > 1.5:
        raise ImageError(
            f"Grey levels are floats in 0 … 1, or whole numbers of an unsigned type such as "
            f"uint8; these run from {values.min():.4g} to {values.max():.4g}."
        )
    return np.asarray(values)


def _check_shape(shape: tuple[int, ...]) -> None:
    if len(shape) not in (2, 3) or shape[2:] not in ((), (1,), (2,), (3,), (4,)):
        raise ImageError(f"{SHAPES}, not {shape}.")
    _check_size(*shape[:2])


def _check_size(height: int, width: int) -> None:
    if height < 1 or width < 1:
        raise ImageError(f"An image of {height} × {width} has no pixels.")
    if height * width > limits.image_pixels:
        raise ImageError(
            f"An image of {height} × {width} is larger than the limit of "
            f"{limits.image_pixels:,} pixels: make it smaller first, or raise "
            "vfwidget.limits.image_pixels."
        )


def shrink(image: Array, factor: int) -> Array:
    """The mean of every ``factor`` × ``factor`` pixels; the last are repeated to fill up."""
    if factor == 1:
        return image
    height, width = image.shape
    padded = np.pad(image, ((0, -height % factor), (0, -width % factor)), mode="edge")
    rows, columns = (side // factor for side in padded.shape)
    # Several times as fast as a mean over two dimensions.
    return np.einsum("rico->rc", padded.reshape(rows, factor, columns, factor)) / factor**2


def noise_variance(image: Array) -> float:
    """Of the noise that differs from pixel to pixel, (H, W), wherever most of an image is smooth.

    From the median of what the difference of two Laplacians (Immerkær 1996) leaves of it.
    """
    # Some thousands of pixels tell it as well as all.
    step = max(1, min(image.shape) // SAMPLES)
    rows = image[:-2:step] - 2 * image[1:-1:step] + image[2::step]
    left = (rows[:, :-2] - 2 * rows[:, 1:-1] + rows[:, 2:])[:, ::step]
    return float(np.median(abs(left)) / GAUSSIAN_MEDIAN) ** 2 / 36


@lru_cache(maxsize=8)
def basis(height: int, width: int, terms: int) -> Array:
    """The first of 1, u, v, u v, u², v² over the image, (H, W, terms), u and v in -1 … 1."""
    v, u = np.meshgrid(_centred(height), _centred(width), indexing="ij")
    values = np.stack([np.ones_like(u), u, v, u * v, u * u, v * v][:terms], -1)
    values.flags.writeable = False
    return values


def _centred(count: int) -> Array:
    return (2 * np.arange(count) + 1) / count - 1


@dataclass(frozen=True)
class Levels:
    """Paper and ink of an image.

    Attributes
    ----------
    light : (terms,) array
        Of the paper's brightness, in :func:`basis`.
    ink : float
    """

    light: Array
    ink: float

    def paper(self, height: int, width: int) -> Array:
        """The paper's brightness, (H, W)."""
        if not self.light[1:].any():
            return np.full((height, width), self.light[0])
        return basis(height, width, len(self.light)) @ self.light


def part(image: Array, terms: int, dark: bool | None) -> tuple[Levels, Array]:
    """Paper and ink of an image, and how much ink is in each pixel, (H, W) in 0 … 1, roughly.

    Parameters
    ----------
    image : (H, W) array
        Small, so that noise is averaged out.
    terms : int
        Of the paper's brightness: 1 for even light, 3 or 6 for uneven.
    dark : bool, optional
        Whether ink is darker than paper; by default what the image's border is not.

    Raises
    ------
    ImageError
        The image is uniform.
    """
    height, width = image.shape
    over = basis(height, width, terms)
    border = np.concatenate([image[0], image[-1], image[:, 0], image[:, -1]])
    low, high = np.quantile(image, [0.01, 0.99])
    if high - low < LEAST_CONTRAST:
        raise ImageError("The image is uniform: there is no ink in it to match.")
    if dark is None:
        dark = bool(np.median(border) > (low + high) / 2)
    sign = -1.0 if dark else 1.0
    # Paper is what is left when what stands out towards the ink is put aside, again and again.
    aside = (sign * (image - np.median(border)) > (high - low) / 4).ravel()
    flat, values = over.reshape(-1, terms), image.ravel()
    for _ in range(ROUNDS):
        if aside.mean() > MOST_INK:
            break
        light = np.linalg.lstsq(flat[~aside], values[~aside], rcond=None)[0]
        out = sign * (values - flat @ light)
        spread = np.median(abs(out[~aside])) * 1.5
        before, aside = aside, out > max(4 * spread, (high - low) / 8)
        if (aside == before).all():
            break
    if aside.mean() <= MOST_INK:
        aside = out > max(4 * spread, (high - low) / 4)
    if aside.mean() > MOST_INK or not aside.any():
        light = np.zeros(terms)
        light[0] = np.median(border)
        out = sign * (values - light[0])
    strength = float(np.quantile(out, 1 - min(0.3 * max(aside.mean(), 1e-3), 0.5)))
    if strength < LEAST_CONTRAST / 2:
        kind = "darker" if dark else "lighter"
        raise ImageError(f"There is no ink in the image that is {kind} than its paper.")
    ink = float(np.median(flat @ light) + sign * strength)
    amount = np.clip(out / strength, 0, 1).reshape(image.shape)
    return Levels(light, ink), np.where(amount > 0.25, amount, 0.0)
