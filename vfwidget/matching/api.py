"""``vf.match``: a picture of letters in, the axes that reproduce it out (Sec. 5.4)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from typing import Any, Protocol, TypeAlias

from tqdm.auto import tqdm

from ..arrays import Array, ArrayLike, to_array
from ..errors import ImageError
from ..font import Font, load_font
from ..font.source import FontSource
from ..text import AxisValues, Text
from .catalogue import match_fonts
from .fit import FITTED, Options
from .images import ImageSource, read_image
from .match import STAGES, Request, Search, Settings
from .result import Match

RESOLUTION = 512
LEAST_SIDE = 6
"""Pixels of a picture in which letters could be told."""
MOST_ASPECT = STAGES[0][0]
"""Longer side over shorter side; a narrower picture has no row of pixels at the first stage."""
EVEN, UNEVEN = 1, 6
"""Terms of the paper's brightness."""
ITERATIONS = {"gauss-newton": 40, "adam": 100}
Source: TypeAlias = "Font | FontSource"


class Viewer(Protocol):
    """Anything that shows a text and takes its axis values, as :class:`vfwidget.Editor` does."""

    text: Any
    axes: Any


def match(
    image: ImageSource,
    text: str | Text,
    font: Source | Sequence[Source] | None = None,
    *,
    fonts: Sequence[Source] | None = None,
    executor: Executor | None = None,
    shared: bool = True,
    axes: AxisValues | Sequence[AxisValues] | None = None,
    placement: ArrayLike | None = None,
    fit: Sequence[str] | None = None,
    ink: str = "auto",
    light: str = "uneven",
    loss: str = "soft_l1",
    optimizer: str = "gauss-newton",
    max_iterations: int | None = None,
    resolution: int = RESOLUTION,
    watch: Viewer | Callable[[Text, float], None] | None = None,
    progress: bool = True,
) -> Match:
    """Find the instance of a variable font, or of which of many, that a picture of letters shows.

    Parameters
    ----------
    image : (H, W) array or tensor, PIL image, or path
        Floats 0 ink … 1 paper, or uint8; colour and transparency are read too.
    text : str or Text
        What it says. A Text brings its font, unless another is given, and whether its letters
        share their axes.
    font : Font or what :func:`load_font` takes; or a sequence of them
    fonts : sequence of those
        In place of ``font``: all are fitted, and the best is returned, with the others ranked.
    executor : concurrent.futures.Executor, optional
        Where to fit several fonts: a process pool with any start method, or Dask's
        ``client.get_executor()``. The
        results are those of one process.
    shared : bool
        One axis vector for the word, or one for each letter.
    axes : mapping, or one per letter, optional
        Where to start. By default a sweep of the design space finds several starts.
    placement : (2, 3) array, optional
        The affine map from the text's font units, y up, to pixels, y down: a similarity. By
        default it is estimated from the ink, and fitted.
    fit : sequence of {"x", "y", "size", "turn", "blur", "light"}, optional
        What is fitted beside the axes: by default all of it, but with ``placement`` only
        ``"blur"`` and ``"light"``.
    ink : {"auto", "dark", "light"}
        Whether ink is darker than paper.
    light : {"uneven", "even"}
        Whether the paper's brightness may vary over the picture, as in photographs.
    loss : {"soft_l1", "linear", "huber", "cauchy", "arctan"}
        How much large residuals count. Stains and what else is no letter are outliers.
    optimizer : {"gauss-newton", "adam"}
        Damped Gauss–Newton from several starts, coarse to fine; or Adam from the best of them,
        as in the paper.
    max_iterations : int, optional
        At the last resolution: by default 40, of Adam 100.
    resolution : int
        A larger picture is made smaller, to this many pixels at its longer side.
    watch : Editor, or callable of (Text, loss), optional
        Shown every step as it is taken.
    progress : bool
        Show a progress bar.

    Returns
    -------
    Match
        Judge it by ``match.status``: a picture of something else gives a poor one.

    Raises
    ------
    ImageError
        An image that cannot be read, is uniform, too large or too small; a text without ink; a
        placement that is no similarity; unknown options.
    FontError, GlyphError, TextError, AxisError
        As :class:`Text`; of several fonts only when none can be fitted.

    Notes
    -----
    Paper, Sec. 5.4, which uses diffvg and Adam. Here the picture and its Jacobian are exact
    (:mod:`vfwidget.raster.coverage`), which makes Gauss–Newton possible.

    Examples
    --------
    >>> import vfwidget as vf
    >>> text = vf.Text("recursive", "a", axes={"wght": 700})
    >>> found = vf.match(1 - vf.rasterize(text, (64, 64)), "a", "recursive", progress=False)
    >>> found.status, round(found.axes["wght"])
    ('matched', 700)
    """
    values = read_image(image)
    if min(values.shape) < LEAST_SIDE:
        raise ImageError(f"Letters cannot be told in a picture of {values.shape} pixels.")
    if max(values.shape) > MOST_ASPECT * min(values.shape):
        raise ImageError(
            f"The image is too narrow: it has {values.shape[0]} × {values.shape[1]} pixels, and "
            f"the longer side can be {MOST_ASPECT} times the shorter one at most. Crop it to a "
            "part of the text."
        )
    if isinstance(font, Sequence) and not isinstance(font, str | bytes | bytearray):
        font, fonts = None, font
    if isinstance(text, Text):
        font = text.font if font is None and fonts is None else font
        shared, text = text.shared, text.string
    if (font is None) == (fonts is None):
        raise ImageError("Give a font, or several as fonts=[…].")
    if fit is None:
        fit = FITTED if placement is None else ("blur", "light")
    if isinstance(fit, str) or not isinstance(fit, Sequence):
        raise ImageError(f"fit is a sequence of names of {', '.join(FITTED)}, not {fit!r}.")
    options = Options(tuple(fit), optimizer, loss)
    settings = Settings(
        options=options,
        theta=None,
        placement=None,
        terms={"even": EVEN, "uneven": UNEVEN}[_one_of(light, ("even", "uneven"), "light")],
        dark={"auto": None, "dark": True, "light": False}[
            _one_of(ink, ("auto", "dark", "light"), "ink")
        ],
        resolution=_at_least(LEAST_SIDE, resolution, "resolution"),
        max_iterations=_at_least(
            0, ITERATIONS[optimizer] if max_iterations is None else max_iterations, "max_iterations"
        ),
    )
    request = Request(text, shared, axes, _matrix(placement), settings)
    if fonts is not None:
        return match_fonts(values, fonts, request, executor, progress)
    own = request.text(load_font(font))
    shown = _shown(own, watch)
    with tqdm(total=len(STAGES) + 2, desc="match", leave=False, disable=not progress) as bar:

        def advance(stage: str) -> None:
            bar.set_postfix_str(stage)
            bar.update()

        outcome = Search(own, values, request.settings_for(own), advance, shown).outcome()
    return Match(own.moved(outcome.state.theta), values, outcome)


def _matrix(placement: ArrayLike | None) -> Array | None:
    try:
        return None if placement is None else to_array(placement)
    except (TypeError, ValueError, RuntimeError) as error:
        raise ImageError(f"A placement is a (2, 3) array of numbers ({error}).") from None


def _at_least(least: int, value: int, what: str) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or value < least:
        raise ImageError(f"{what} is a whole number from {least} on, not {value!r}.")
    return value


def _one_of(value: str, names: Sequence[str], what: str) -> str:
    if value not in names:
        raise ImageError(f"{what} is one of {', '.join(names)}, not {value!r}.")
    return value


def _shown(
    text: Text, watch: Viewer | Callable[[Text, float], None] | None
) -> Callable[[Array, float], None] | None:
    """What to do with Θ and the loss at every step."""
    if watch is None:
        return None
    if callable(watch):
        return lambda theta, loss: watch(text.moved(theta), loss)
    viewer = watch
    viewer.text = text

    def show(theta: Array, loss: float) -> None:
        viewer.axes = text.moved(theta).axes

    return show
