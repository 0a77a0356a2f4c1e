"""The notebook widget that plays an animation.

The view (``js/src/player``) receives the word and the axis values of all frames once. It evaluates
the outlines by itself, so it plays without a kernel. ``js/README.md`` states the contract.
"""

from __future__ import annotations

import os
from typing import Any, overload

import anywidget
import traitlets

from ..errors import MotionError
from ..export.animated_svg import still_picture
from ..export.page import page, view
from ..files import written
from ..motion.animation import Animation
from ..motion.numbers import read_number
from ..motion.tracks import outlines
from ..solver.problem import is_count
from ..text.inputs import read_flag
from .bundle import PAGE_STYLE, built
from .film import describe_film
from .options import checked_height, refuse_foreign, refuse_unknown
from .snapshot import Snapshot
from .word import describe_word

PAGE_TRAITS = ("_word", "_film", "playing", "time", "speed", "loop", "onion", "height", "theme")
"""The traits that a view needs on a page without a kernel."""
VIEW_TRAITS = ["playing", "time", "speed", "loop", "onion"]
"""The traits that the view changes."""
STATE = "application/vnd.vfwidget.player+json"
POSTER_HEIGHT = 180
"""Pixels of the picture that a saved notebook shows."""
SPEEDS = (0.01, 16.0)
MOST_ONION = 20


class Player(anywidget.AnyWidget):
    """Plays an animation, with its axes as curves.

    Show the player by making it the last expression of a cell. Space plays and pauses, the arrow
    keys go to the next frame or the one before, Home and End to the first and the last one. The
    curves show the axes over time. All have one scale: the middle is the default, and the top and
    the bottom are the ends of each axis. Press on the curves to go to a time.

    Parameters
    ----------
    animation : Animation
    playing : bool
        Whether the animation starts by itself. Default False. It never does for readers who prefer
        reduced motion.
    loop : bool
        Whether it repeats without end. Default True.
    speed : float
        1 (the default) is real time; 0.01 to 16.
    onion : int
        How many earlier states are shown as outlines, three frames apart; 0 (the default) to 20.
    height : int, optional
        Greatest height of the picture in pixels, 80 to 4000. Default 320.
    theme : {"auto", "light", "dark"}
        The colours; by default those of the notebook.

    Attributes
    ----------
    animation : Animation
        Set it to show another one.
    playing, loop, speed, onion, height, theme
        As above. All are traits.
    time : float
        Seconds since the first frame, where the player was last stopped or set.
    error : str
        The error message that the player displays; empty if there is no error.

    Raises
    ------
    MotionError
        ``animation`` is no Animation, or an option is out of range. A bad value that is assigned
        later raises the same error and leaves the player as it was.
    TextError
        ``height`` is out of range.
    """

    _esm = built("player.js")
    _css = built("player.css")

    _word = traitlets.Dict().tag(sync=True)
    _film = traitlets.Dict().tag(sync=True)
    playing = traitlets.Any(False).tag(sync=True)
    time = traitlets.Any(0.0).tag(sync=True)
    speed = traitlets.Any(1.0).tag(sync=True)
    loop = traitlets.Any(True).tag(sync=True)
    onion = traitlets.Any(0).tag(sync=True)
    height = traitlets.Any(None).tag(sync=True)
    theme = traitlets.Enum(["auto", "light", "dark"], "auto").tag(sync=True)
    error = traitlets.Unicode().tag(sync=True)
    _snapshot = traitlets.Unicode().tag(sync=True)
    animation = traitlets.Any()

    def __init__(
        self,
        animation: Animation,
        *,
        playing: bool = False,
        loop: bool = True,
        speed: float = 1.0,
        onion: int = 0,
        height: int | None = None,
        theme: str = "auto",
        **unknown: Any,
    ) -> None:
        refuse_unknown(unknown, Player.__init__)
        self._picture = Snapshot(self._poster, "play it")
        super().__init__(
            animation=animation,
            playing=playing,
            loop=loop,
            speed=speed,
            onion=onion,
            height=height,
            theme=theme,
            _snapshot=self._picture.name,
        )

    @overload
    def to_html(self) -> str: ...
    @overload
    def to_html(self, path: str | os.PathLike[str]) -> None: ...
    def to_html(self, path: str | os.PathLike[str] | None = None) -> str | None:
        """Write the player as a page of its own, which needs neither a kernel nor a network.

        Parameters
        ----------
        path : str or path, optional
            The file to write, which is replaced if it exists. Without it, the page is returned.

        Returns
        -------
        str or None

        Raises
        ------
        OSError
            The file cannot be written.
        """
        body = view(self.get_state(PAGE_TRAITS), STATE)
        made = page(self.animation.text.title, body, [self._esm], self._css + PAGE_STYLE)
        return written(made, path)

    def play(self) -> None:
        """Start, or go on from where the player was stopped."""
        self.playing = True

    def pause(self) -> None:
        """Stop."""
        self.playing = False

    def _ipython_display_(self) -> None:
        """Show the player, and below it a picture that a saved notebook keeps."""
        from IPython.display import display

        display(*self._repr_mimebundle_()[:1], raw=True)  # type: ignore[index]
        self._picture.show()

    def _poster(self) -> str:
        """The frame at the present time as an SVG document; the last one if that is the first."""
        animation = self.animation
        times = animation.times - animation.times[0]
        frame = int(abs(times - self.time).argmin()) or len(times) - 1
        letters, obstacles, box, palette = outlines(animation)
        title = animation.text.title
        return still_picture(
            letters,
            obstacles,
            frame,
            title=title,
            box=box,
            palette=palette,
            height=POSTER_HEIGHT,
            background="white",
        )

    @traitlets.validate("animation")
    def _check_animation(self, proposal: Any) -> Animation:
        animation = proposal["value"]
        if not isinstance(animation, Animation):
            raise MotionError(
                f"A Player shows an Animation; received {type(animation).__name__}. "
                "vf.simulate and vf.Animation.from_keyframes make animations."
            )
        return animation

    @traitlets.observe("animation")
    def _on_animation(self, _: Any) -> None:
        with self.hold_sync():
            self._word = describe_word(self.animation.text)
            self._film = describe_film(self.animation)
            self.time = 0.0
        self._picture.expire()

    @traitlets.observe("time")
    def _on_time(self, _: Any) -> None:
        self._picture.expire()

    @traitlets.validate(*VIEW_TRAITS)
    def _check_option(self, proposal: Any) -> Any:
        return self._checked(proposal["trait"].name, proposal["value"])

    def _checked(self, name: str, value: Any) -> Any:
        """The value of a trait that the view may change."""
        if name in ("playing", "loop"):
            return read_flag(name, value, MotionError)
        if name == "onion":
            if not is_count(value) or value > MOST_ONION:
                raise MotionError(
                    f"onion must be a whole number from 0 to {MOST_ONION}; received {value!r:.200}."
                )
            return int(value)
        low, high = (0.0, self.animation.duration) if name == "time" else SPEEDS
        return read_number(name, value, low, high, open_below=False)

    @traitlets.validate("height")
    def _check_height(self, proposal: Any) -> int | None:
        return checked_height(proposal["value"])

    def set_state(self, sync_data: Any) -> None:
        """Apply state from the view. Bad values are refused, and the view shows the error."""
        try:
            sync_data = dict(sync_data)
            refuse_foreign(sync_data, VIEW_TRAITS, MotionError)
            # traitlets checks only after it has assigned, and 1 == True hides that from it.
            for name, value in sync_data.items():
                self._checked(name, value)
        except (TypeError, ValueError) as error:
            self.send_state(VIEW_TRAITS)
            self.error = str(error)
        else:
            super().set_state(sync_data)
            self.error = ""
