"""Limits on input: files, texts, solves, downloads, images and artwork."""

from __future__ import annotations

from dataclasses import dataclass
from numbers import Real

from .errors import VFWidgetError


@dataclass(slots=True)
class Limits:
    """Bounds on the memory and the time that one input can take.

    A larger input raises an exception of the package before it is read or unpacked. To raise a
    limit, assign a new value in the process that reads the input, for example
    ``vf.limits.image_pixels = 2**28``. A value that is no number above 0 raises VFWidgetError.
    """

    font_file_bytes: int = 64 * 2**20
    """Size of a font file. Large fonts for Chinese, Japanese and Korean have up to 50 MB."""
    font_unpacked_bytes: int = 256 * 2**20
    """Size of a WOFF or WOFF2 file after unpacking. Fonts shrink to about a quarter at best."""
    glyph_points: int = 4_000_000
    """Points × (1 + delta sets) of a glyph, 64 MB. The largest glyphs known need a tenth of it, and
    a hostile file of a few kilobytes could state a thousand times more."""
    glyph_cache_bytes: int = 64 * 2**20
    """Memory for the unpacked glyphs that a font keeps. A glyph that is in use stays anyway."""
    text_characters: int = 4_000
    """Characters of a text. Each origin depends on the advance widths before it, so memory grows
    with the square: this many take about 1 GB. A page of a book has 3,000."""
    step_products: int = 2**32
    """Residuals × unknowns × the smaller of both, the multiplications of a step of the solver. This
    many take about two seconds. They grow with the cube of the number of letters that have axes of
    their own, because these also move all letters after them: 600 letters of five axes, with a
    target for each, need as many."""
    download_seconds: float = 60.0
    """Time of a whole download, whatever the server does. 64 MB arrive in time at 9 Mbit/s."""
    image_pixels: int = 2**26
    """Pixels of an image that is read, 8,192 × 8,192. Reading it takes about 0.8 GB of memory."""
    raster_pixels: int = 2**25
    """Pixels of a drawn image, 5,800 × 5,800. Drawing needs several arrays of this size."""
    svg_bytes: int = 4 * 2**20
    """Size of an SVG file for artwork."""
    svg_elements: int = 5_000
    """Elements of an SVG after every ``use`` is expanded. Nested ones multiply."""
    svg_curves: int = 25_000
    """Curves of an SVG. A stroke counts as its outline, which has about 20 curves for each curve
    of its path. To read and join this many takes about a second."""
    curve_pairs: int = 120_000
    """Pairs of curves near enough to cross, of outlines that are drawn in one image or joined. A
    text has about five for each letter. This many take about a second and 0.6 GB of memory, and a
    hostile SVG of 100 kB could state a thousand times more."""

    def __setattr__(self, name: str, value: float) -> None:
        # A limit of NaN would refuse nothing, because no number is greater than NaN.
        if isinstance(value, bool) or not (isinstance(value, Real) and value > 0):
            raise VFWidgetError(f"limits.{name} must be a number > 0; received {value!r:.100}.")
        object.__setattr__(self, name, value)


limits = Limits()
"""The limits of this process."""
