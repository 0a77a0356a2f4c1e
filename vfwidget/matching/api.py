"""``vf.match`` finds the axis values that reproduce a picture of letters (Sec. 5.4)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from typing import Any, Protocol, TypeAlias, TypeVar

from tqdm.auto import tqdm

from ..arrays import ArrayLike
from ..deprecation import renamed
from ..errors import ImageError
from ..font import Font, load_font
from ..font.source import FontSource
from ..solver.problem import is_count
from ..text import AxisValues, Text
from ..threads import one_thread
from .catalogue import match_fonts
from .fit import Options, Watch
from .images import ImageSource, read_image
from .looks import MATCHED, check_fitted
from .match import STAGES, Request, Search, Settings
from .result import Match
from .scene import State

RESOLUTION = 512
LEAST_SIDE = 6
"""Pixels: letters in a smaller picture cannot be recognised."""
MOST_ASPECT = STAGES[0][0]
"""Longer side over shorter side; a narrower picture has no row of pixels at the first stage."""
EVEN, UNEVEN = 1, 6
"""Number of coefficients of the paper's brightness."""
ITERATIONS = {"gauss-newton": 40, "adam": 100}
Source: TypeAlias = "Font | FontSource"
Chosen = TypeVar("Chosen")


class Viewer(Protocol):
    """Anything that shows a text and takes its axis values, as :class:`vfwidget.Editor` does."""

    text: Any
    axes: Any


@renamed(light="background")
@one_thread
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
    background: str = "uneven",
    loss: str = "soft_l1",
    optimizer: str = "gauss-newton",
    max_iterations: int | None = None,
    resolution: int = RESOLUTION,
    watch: Viewer | Callable[[Text, float], None] | None = None,
    progress: bool = True,
) -> Match:
    """Estimate the axis values of the letters in a picture, and rank fonts if given several.

    Parameters
    ----------
    image : (H, W) array or tensor, PIL image, or path
        Floats from 0 (ink) to 1 (paper), or uint8; colour and transparency are read too.
    text : str or Text
        The string in the picture. A Text is matched as it is set: with its features, language,
        script, direction, line height and tracking, its ``shared`` setting, and its font unless
        ``font`` or ``fonts`` is given.
    font : Font, or a source that :func:`load_font` takes; or a sequence of them
    fonts : sequence of those
        In place of ``font``: all are fitted, and the best is returned with the others ranked.
    executor : concurrent.futures.Executor, optional
        Where several fonts are fitted: a process pool with any start method, or Dask's
        ``client.get_executor()``. The results do not depend on it.
    shared : bool
        True (the default) for one axis vector for the word, False for one for each letter.
    axes : axis values, or one for each letter, optional
        The start. By default a coarse search of the design space finds several starts.
    placement : (2, 3) array, optional
        The affine map from the text's font units, y up, to pixels, y down: a similarity. By
        default it is estimated from the ink, and fitted.
    fit : sequence of {"x", "y", "size", "rotation", "blur", "background", "tracking"}, optional
        Quantities fitted in addition to the axes. Default: all of them but ``"tracking"``; with
        ``placement`` only ``"blur"`` and ``"background"``.
    ink : {"auto", "dark", "light"}
        Whether the ink is darker or lighter than the paper. Default: found from the border.
    background : {"uneven", "even"}
        Whether the paper's brightness may vary over the picture, as in photographs. Default
        "uneven".
    loss : {"soft_l1", "linear", "huber", "cauchy", "arctan"}
        How much large residuals count; stains and other marks are outliers. Default "soft_l1".
    optimizer : {"gauss-newton", "adam"}
        Damped Gauss–Newton from several starts, coarse to fine (the default); or Adam from the
        best of them, as in the paper.
    max_iterations : int, optional
        At the last resolution. Default 40, for Adam 100.
    resolution : int
        A larger picture is shrunk to this many pixels at its longer side. Default 512.
    watch : Editor, or callable of (Text, loss), optional
        It is shown every step.
    progress : bool
        Whether to show a progress bar.

    Returns
    -------
    Match
        Judge it by ``match.status``: a picture of something else gives a poor match.

    Raises
    ------
    ImageError
        The image cannot be read, is uniform, too large or too small; the text has no ink; the
        placement is not a similarity; or an option is unknown.
    FontError, GlyphError, TextError, AxisError
        As for :class:`Text`; for several fonts only if none can be fitted.
    SolveError
        The picture has too many pixels for so many axes, by ``limits.step_products``; a smaller
        ``resolution`` helps.

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
    height, width = values.shape
    if min(values.shape) < LEAST_SIDE:
        raise ImageError(
            f"The image is too small: it has {height} × {width} pixels, and each side needs at "
            f"least {LEAST_SIDE}."
        )
    if max(values.shape) > MOST_ASPECT * min(values.shape):
        raise ImageError(
            f"The image is too narrow: it has {height} × {width} pixels, and the longer side can "
            f"be {MOST_ASPECT} times the shorter one at most. Crop it to a part of the text."
        )
    if isinstance(font, Sequence) and not isinstance(font, str | bytes | bytearray):
        font, fonts = None, font
    manner: dict[str, Any] = {}
    lengths: dict[str, float] = {}
    if isinstance(text, Text):
        font = text.font if font is None and fonts is None else font
        manner, lengths = _manner(text)
        shared, text = text.shared, text.string
    if (font is None) == (fonts is None):
        raise ImageError("Give a font, or several as fonts=[…].")
    if fonts is not None and (isinstance(fonts, str | bytes) or not isinstance(fonts, Sequence)):
        raise ImageError(f"fonts must be a sequence of fonts; received {fonts!r:.80}.")
    options = Options(check_fitted(fit, placement is not None, MATCHED), optimizer, loss)
    settings = Settings(
        options=options,
        theta=None,
        placement=None,
        terms=_choice("background", background, {"even": EVEN, "uneven": UNEVEN}),
        dark=_choice("ink", ink, {"auto": None, "dark": True, "light": False}),
        resolution=_at_least(LEAST_SIDE, resolution, "resolution"),
        max_iterations=_at_least(
            0, ITERATIONS[optimizer] if max_iterations is None else max_iterations, "max_iterations"
        ),
    )
    request = Request(text, shared, axes, placement, settings, manner, lengths)
    if fonts is not None:
        return match_fonts(values, fonts, request, executor, progress)
    own = request.text(load_font(font))
    shown = _shown(own, watch)
    with tqdm(total=len(STAGES) + 2, desc="match", leave=False, disable=not progress) as bar:

        def advance(stage: str) -> None:
            bar.set_postfix_str(stage)
            bar.update()

        outcome = Search(own, values, request.settings_for(own), advance, shown).outcome()
    return Match(own.moved_to(outcome.state.place), values, outcome)


def _manner(text: Text) -> tuple[dict[str, Any], dict[str, float]]:
    """How a text is set, as keyword arguments of another one, and its lengths in ems."""
    font, options = text.font, text.composition.options
    manner = {
        "features": options.feature_values,
        "language": options.language,
        "script": options.script,
        "direction": options.direction,
    }
    lengths = {"tracking": text.tracking}
    if text.composition.line_height != font.ascender - font.descender:
        lengths["line_height"] = text.composition.line_height
    return manner, {name: length / font.units_per_em for name, length in lengths.items()}


def _at_least(least: int, value: int, what: str) -> int:
    if not is_count(value) or value < least:
        raise ImageError(f"{what} must be a whole number ≥ {least}; received {value!r}.")
    return int(value)


def _choice(what: str, value: str, choices: Mapping[str, Chosen]) -> Chosen:
    # A value may be of any type, also one that cannot be a key.
    if not isinstance(value, str) or value not in choices:
        raise ImageError(f"{what} must be one of {', '.join(choices)}; received {value!r}.")
    return choices[value]


def _shown(text: Text, watch: Viewer | Callable[[Text, float], None] | None) -> Watch | None:
    """What to do with the state and the loss at every step."""
    if watch is None:
        return None
    if callable(watch):
        return lambda state, loss: watch(text.moved_to(state.place), loss)
    viewer = watch
    if not (hasattr(viewer, "text") and hasattr(viewer, "axes")):
        raise ImageError(
            f"watch must be an Editor, or a function of a text and a loss; received {watch!r:.80}."
        )
    viewer.text = text

    def show(state: State, loss: float) -> None:
        viewer.axes = text.moved(state.theta).axes

    return show
