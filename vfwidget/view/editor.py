"""The notebook widget turns a drag into terms, solves for the axes and returns them.

The view (``js/``) draws from the axes by itself and predicts the result of a drag. The kernel
solves each drag event again and has the last word. Each drag message carries a sequence number
and is answered exactly once, with the solved axes or with an error; the view keeps one message in
flight. ``js/README.md`` states the contract.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import anywidget
import traitlets

from ..errors import SolveError, VFWidgetError
from ..font import Font
from ..font.source import FontSource
from ..text import AxisValues, Text
from .apart import KeepsApart
from .bundle import built
from .constraints import checked_constraints
from .drag import Drags, answer, solve_drag
from .exports import Exports
from .frozen import frozen
from .history import History
from .options import checked_height, refuse_foreign, refuse_unknown, text_to_show, upright
from .snapshot import Snapshot
from .state import State, checked_locks, checked_pins, set_as
from .steps import Steps
from .word import describe_word

PLACES = ("axes", "shared", "_pins", "locks", "constraints")
"""The traits in which the view changes what undo brings back."""
ALIASES = {"value": "axes", "_pins": "pins"}
"""Traits with the same content as another one."""
STATE_TRAITS = [*PLACES, "avoid_overlaps"]
"""The traits that the view is told again when it has sent something that is not valid."""
VIEW_TRAITS = {*STATE_TRAITS, "teaching", "_gesture"}
"""All traits that the view may set."""
SNAPSHOT_HEIGHT = 180
"""Pixels of the picture that a saved notebook shows."""


class Editor(Exports, KeepsApart, Steps, anywidget.AnyWidget):
    """A word to drag by its outline, with a slider for every axis.

    Hover over the outline to see the nearest point; press and drag to move it; click to pin or
    unpin it. Show the editor by making it the last expression of a cell.

    Parameters
    ----------
    font : Font, Text, or an argument of :func:`load_font`
    string : str
        The word; not given if ``font`` is a Text.
    axes : mapping of tag to user value, or one per letter, optional
    shared : bool, optional
        One axis vector for the word (default), or one for each letter. Omit it for a Text.
    locks : sequence of str
        Tags of axes that drags leave as they are.
    obstacles : obstacle, or sequence of obstacles
        Drawn behind the word, and avoided by drags; as for :func:`overlaps`. Default: none.
    avoid_overlaps : bool
        Whether drags keep letters apart from each other and from the obstacles. When it is turned
        on, or the obstacles change while it is on, letters that overlap give way. Default False.
    height : int, optional
        Height of the picture in pixels, 80 to 4000. By default it follows the width.
    theme : {"auto", "light", "dark"}
        The colours; by default those of the notebook.
    teaching : bool
        Whether the editor shows the numbers behind the selected letter: how far each axis moves it,
        the scalars of its delta sets, and Eq. 1 for the held point. Default False.
    throttle : int
        The least number of milliseconds between two moves that the view sends to the kernel while
        it draws a drag by itself. Default 500, because a notebook spends more time on a message
        than on a frame. Choose 100 where Python follows a drag, for example to redraw a figure.
        Drags that avoid overlaps send every move, because only the kernel solves these.

    Attributes
    ----------
    axes : dict, or list of one dict per letter
        User coordinates of every axis, as :attr:`Text.axes`. If you set a part of them, the others
        take their default values.
    value
        The same as ``axes``, under the name that ipywidgets expects.
    text : Text
        The word at those axes. Set it to edit another one.
    pins : list of Handle
        Points that drags leave where they are. Set it to pin from code.
    locks : list of str
    constraints : list of dict
        What drags keep: points that share x or y, points on a line, a distance, the width of the
        word. Each is JSON, such as ``{"kind": "Distance", "handles": [[0, 0, 3, 0.5], [0, 0, 9,
        0]], "value": 60.0}``; you can also assign the terms :class:`SharedX`, :class:`SharedY`,
        :class:`Collinear`, :class:`Distance` and :class:`Width`. The axes move to meet them, and
        each has the weight of a pin.
    shared : bool
    obstacles
    avoid_overlaps : bool
        If you set it to True where letters overlap, the axes move to the nearest values at which
        nothing overlaps. A drag then goes only as far as its way is free, and neighbours give way.
    height : int or None
    theme : str
    teaching : bool
    throttle : int
    history : list of Text
        The states up to the present one, oldest first.
    error : str
        The error message that the editor displays; empty if there is no error.

    All of them except ``history`` are traits: ``editor.observe(callback, "axes")`` follows a drag.

    Raises
    ------
    FontError, GlyphError, TextError, AxisError
        As :func:`load_font` and :class:`Text`. A bad value that is assigned later raises the same
        error and leaves the editor as it was.
    """

    _esm = built("editor.js")
    _css = built("editor.css")

    _word = traitlets.Dict().tag(sync=True)
    axes = traitlets.Any().tag(sync=True, echo_update=False)
    shared = traitlets.Bool().tag(sync=True, echo_update=False)
    _pins: traitlets.List[Any] = traitlets.List().tag(sync=True, echo_update=False)
    locks = traitlets.Any().tag(sync=True, echo_update=False)
    constraints = traitlets.Any().tag(sync=True, echo_update=False)
    height = traitlets.Any(None).tag(sync=True)
    theme = traitlets.Enum(["auto", "light", "dark"], "auto").tag(sync=True)
    teaching = traitlets.Bool(False).tag(sync=True)
    throttle = traitlets.Int(500, min=0, max=10_000).tag(sync=True)
    error = traitlets.Unicode().tag(sync=True)
    _steps = traitlets.List([0, 0]).tag(sync=True)
    _gesture = traitlets.Unicode().tag(sync=True, echo_update=False)
    _snapshot = traitlets.Unicode().tag(sync=True)
    text = traitlets.Instance(Text)
    pins = traitlets.Any()
    value = traitlets.Any()

    def __init__(
        self,
        font: Font | Text | FontSource,
        string: str | None = None,
        axes: AxisValues | Sequence[AxisValues] | None = None,
        shared: bool | None = None,
        *,
        locks: Sequence[str] = (),
        obstacles: Any = (),
        avoid_overlaps: bool = False,
        height: int | None = None,
        theme: str = "auto",
        teaching: bool = False,
        throttle: int = 500,
        **unknown: Any,
    ) -> None:
        refuse_unknown(unknown, Editor.__init__)
        text = text_to_show(font, string, axes, shared)
        state = State(text, (), checked_locks(locks, text))
        self._lock = threading.RLock()
        self._adopting = False
        self._naming: str | None = None
        self._history = History(state)
        self._drags = Drags(text)
        self._on_release: list[Callable[[Editor], object]] = []
        self._picture = Snapshot(
            lambda: self.text.to_svg(height=SNAPSHOT_HEIGHT, background="white")
        )
        with self._adoption():
            super().__init__(
                text=text,
                pins=frozen(state.pins),
                _word=describe_word(text),
                axes=frozen(text.axes),
                value=frozen(text.axes),
                shared=text.shared,
                locks=frozen(state.locks),
                constraints=frozen(state.constraints),
                height=height,
                theme=theme,
                teaching=teaching,
                throttle=throttle,
                _snapshot=self._picture.name,
                obstacles=obstacles,
            )
        self.avoid_overlaps = avoid_overlaps
        self.on_msg(self._receive)

    def on_change(self, callback: Callable[[Editor], object]) -> None:
        """Call a function after every change of the axes, also while a point is dragged.

        Parameters
        ----------
        callback : callable
            It receives the editor.
        """
        self.observe(lambda _: callback(self), "axes")

    def on_release(self, callback: Callable[[Editor], object]) -> None:
        """Call a function when a drag has ended.

        Parameters
        ----------
        callback : callable
            It receives the editor. If it raises, the view shows the error.
        """
        self._on_release.append(callback)

    def _ipython_display_(self) -> None:
        """Show the editor, and below it a picture that a saved notebook keeps."""
        from IPython.display import display

        display(*self._repr_mimebundle_()[:1], raw=True)  # type: ignore[index]
        self._picture.show()

    @contextmanager
    def _adoption(self) -> Iterator[None]:
        """Keep the observers from running while the traits are made to agree."""
        with self._lock:
            before, self._adopting = self._adopting, True
            try:
                yield
            finally:
                self._adopting = before

    def _adopt(self, state: State) -> None:
        """Make this the state, as a step of the history."""
        try:
            self._history.record(state, self._naming)
        finally:
            self._show()

    def notify_change(self, change: Any) -> None:
        """Tell observers and the view of a change, or undo it if that fails or is interrupted."""
        try:
            super().notify_change(change)
        except BaseException:
            if not self._adopting:
                self._show()
            raise

    def _show(self) -> None:
        """Make every trait agree with the present state, even if that is interrupted once."""
        try:
            self._agree()
        except BaseException:
            self._adopting = False
            self._agree()
            raise

    def _agree(self) -> None:
        state = self._history.present
        text = state.text
        with self._adoption(), self.hold_sync():
            if text.composition is not self.text.composition or set_as(text) != set_as(self.text):
                self._word = describe_word(text)
            self.text = text
            self.shared = text.shared
            self.axes = self.value = frozen(text.axes)
            self.pins = frozen(state.pins)
            self._pins = state.pin_places
            self.locks = frozen(state.locks)
            self.constraints = frozen(state.constraints)
            self._steps = [len(self._history.past), len(self._history.future)]
            self.error = self._complaint(state)
        self._picture.expire()

    @traitlets.validate("axes", "value")
    def _check_axes(self, proposal: Any) -> Any:
        value = proposal["value"]
        return value if self._adopting else frozen(self._moved(value).axes)

    @traitlets.validate("text")
    def _check_text(self, proposal: Any) -> Text:
        return upright(proposal["value"])

    @traitlets.validate("pins")
    def _check_pins(self, proposal: Any) -> list[Any]:
        return frozen(checked_pins(proposal["value"], self.text))

    @traitlets.validate("locks")
    def _check_locks(self, proposal: Any) -> list[str]:
        return frozen(checked_locks(proposal["value"], self.text))

    @traitlets.validate("constraints")
    def _check_constraints(self, proposal: Any) -> list[Any]:
        return frozen(checked_constraints(proposal["value"], self.text))

    @traitlets.validate("height")
    def _check_height(self, proposal: Any) -> int | None:
        return checked_height(proposal["value"])

    def _moved(self, axes: Any, shared: bool | None = None) -> Text:
        """The text at other axes, shared by its letters or not."""
        shared = self.shared if shared is None else shared
        if shared == self.text.shared:
            return self.text.at(axes=axes)
        if shared and not isinstance(axes, Mapping):
            axes = axes[0]
        return self.text.at(axes=axes, shared=shared)

    def _with(self, changes: Mapping[str, Any]) -> State:
        """The present state with new values of some traits, all at once."""
        state = self._history.present
        if "axes" in changes or "shared" in changes:
            state = state.at(self._moved(changes.get("axes", self.axes), changes.get("shared")))
        if "pins" in changes:
            state = replace(state, pins=checked_pins(changes["pins"], state.text))
        if "locks" in changes:
            state = replace(state, locks=checked_locks(changes["locks"], state.text))
        if "constraints" in changes:
            constraints = checked_constraints(changes["constraints"], state.text)
            state = replace(state, constraints=constraints)
            if constraints:
                followed = solve_drag(state, state.text, keep=self._keep)
                state = replace(state, text=followed.solution.text)
        return self._relieved(state)

    @traitlets.observe("axes", "shared", "value", "pins", "_pins", "locks", "constraints")
    def _on_state(self, change: Any) -> None:
        if not self._adopting:
            name = change["name"]
            self._adopt(self._with({ALIASES.get(name, name): getattr(self, name)}))

    @traitlets.observe("text")
    def _on_text(self, change: Any) -> None:
        if not self._adopting:
            with self._adoption():
                # `_show` compares the word with that of the old text, which this trait has left.
                self._word = describe_word(self.text)
            self._adopt(self._history.present.at(self.text))

    def set_state(self, sync_data: Any) -> None:
        """Apply state from the view. A change that fails is undone, and its error shown."""
        with self._lock:
            try:
                sync_data = dict(sync_data)
                refuse_foreign(sync_data, VIEW_TRAITS, SolveError)
                name = sync_data.get("_gesture")
                self._naming = name if isinstance(name, str) else None
                # Pins and the constraint that takes their place, say, are one change.
                mine = {key: sync_data.pop(key) for key in PLACES if key in sync_data}
                if mine:
                    with self._lock_property(**mine):
                        self._adopt(self._with({ALIASES.get(k, k): v for k, v in mine.items()}))
                super().set_state(sync_data)
            except Exception as error:
                self._show()
                self.send_state(STATE_TRAITS)
                self.error = _in_words(error)
                if not isinstance(
                    error, VFWidgetError | TypeError | ValueError | traitlets.TraitError
                ):
                    raise
            finally:
                self._naming = None

    def _receive(self, _: Any, content: Any, buffers: Any) -> None:
        """Answer a message of the view, whatever it contains, exactly once."""
        content = content if isinstance(content, dict) else {}
        kind = content.get("type")
        reply = {"type": kind, "view": content.get("view"), "seq": content.get("seq")}
        try:
            with self._lock:
                if kind == "drag":
                    reply |= self._drag(content)
                elif kind == "tools":
                    reply["script"] = built("tools.js")
                elif kind in ("undo", "redo", "restart"):
                    getattr(self, kind)()
                    reply["ok"] = True
                else:
                    raise SolveError(f"The editor does not know messages of type {kind!r}.")
        except Exception as error:
            reply |= {"ok": False, "error": _in_words(error)}
        self.send(reply)

    def _drag(self, content: dict[str, Any]) -> dict[str, Any]:
        """Solve one drag event, from where the view has predicted it, and move the text there."""
        state, keep = self._origin(content), self._keep
        followed, handle = self._drags.solve(content, state, keep)
        self._naming = str(content.get("gesture") or "")
        try:
            self._adopt(state.at(followed.solution.text))
        finally:
            self._naming = None
        if content.get("phase") == "up":
            for callback in self._on_release:
                callback(self)
        return {"ok": True, "axes": self.axes, **answer(followed, handle)}


def _in_words(error: Exception) -> str:
    if isinstance(error, VFWidgetError):
        return str(error)
    return f"{type(error).__name__}: {error}"
