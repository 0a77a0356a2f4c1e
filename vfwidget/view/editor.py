"""The notebook widget: events in, terms and a solve, axes out.

The view (``js/``) draws from the axes by itself, so the kernel only answers drags. Each drag
message carries a sequence number and is answered exactly once, with the solved axes or with an
error; the view keeps one in flight. ``js/README.md`` states the contract.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from importlib import resources
from pathlib import Path
from typing import Any, overload

import anywidget
import numpy as np
import traitlets

from ..energy.handle_terms import Pin, Target
from ..energy.solve import solve
from ..energy.term import Term
from ..energy.word_terms import StayClose
from ..errors import SolveError, TextError, VFWidgetError
from ..export.page import page, view
from ..font import Font
from ..font.source import FontSource
from ..text import AxisValues, Handle, Text
from ..text.word import Word

CALM = 0.001
"""√λ of Sec. 5.1, in ems: a drag moves an axis over its range only if it gains more than this."""
MOVE_ITERATIONS = 30
RELEASE_ITERATIONS = 200
RESTARTS = 8

PAGE_TRAITS = ("_word", "axes", "shared", "_pins")
"""The traits that a view needs on a page without a kernel."""
PAGE_STYLE = """
:root { color-scheme: light dark; }
body { max-width: 1000px; margin: 24px auto; padding: 0 16px; --vfw-height: 60vh; }
"""


def _static(name: str) -> str:
    file = resources.files("vfwidget") / "static" / name
    if not file.is_file():
        raise ImportError(
            f"vfwidget/static/{name} is missing: the view is bundled when the package is "
            "installed. Run `pip install .` (or `npm ci && npm run build` in js/)."
        )
    return file.read_text(encoding="utf-8")


class Editor(anywidget.AnyWidget):
    """A word to drag by its outline, with a slider for every axis.

    Hover shows the nearest outline point; press and drag moves it, click pins or unpins it. Show
    it by making it the last expression of a cell.

    Parameters
    ----------
    font : Font, Text, or what :func:`load_font` takes
    string : str
        The word; not given when ``font`` is a Text.
    axes : mapping of tag to user value, or one per letter, optional
    shared : bool
        One axis vector for the word, or one for each letter.

    Attributes
    ----------
    axes : dict, or list of one dict per letter
        User coordinates of every axis, as :attr:`Text.axes`. Set a part of them and the others
        go to their defaults.
    text : Text
        The word at those axes. Set it to edit another.
    pins : list of Handle
        Points that drags leave where they are. Set it to pin from code.
    shared : bool
    error : str
        What the view shows as gone wrong; empty when nothing has.

    All of them are traits: ``editor.observe(callback, "axes")`` follows a drag.

    Raises
    ------
    FontError, GlyphError, TextError, AxisError
        As :func:`load_font` and :class:`Text`. A bad value assigned later raises the same and
        leaves the widget as it was.
    """

    _esm = _static("editor.js")
    _css = _static("editor.css")

    _word = traitlets.Dict().tag(sync=True)
    axes = traitlets.Any().tag(sync=True, echo_update=False)
    shared = traitlets.Bool().tag(sync=True, echo_update=False)
    _pins: traitlets.List[Any] = traitlets.List().tag(sync=True, echo_update=False)
    error = traitlets.Unicode().tag(sync=True)
    text = traitlets.Instance(Text)
    pins = traitlets.Any()

    def __init__(
        self,
        font: Font | Text | FontSource,
        string: str | None = None,
        axes: AxisValues | Sequence[AxisValues] | None = None,
        shared: bool = True,
    ) -> None:
        if isinstance(font, Text):
            if string is not None or axes is not None:
                raise TextError("A Text already has its string and its axes: give it alone.")
            text = font
        elif string is None:
            raise TextError('An Editor needs a text to set: vf.Editor(font, "NT").')
        else:
            text = Text(font, string, axes=axes, shared=shared)
        self._lock = threading.RLock()
        self._adopting = False
        self._pressed: tuple[Any, Text] = (None, text)
        with self._adoption():
            super().__init__(
                _word=describe_word(text.word),
                axes=text.axes,
                shared=text.shared,
                text=text,
                pins=[],
            )
        self.on_msg(self._answer)

    @overload
    def to_html(self) -> str: ...
    @overload
    def to_html(self, path: str | os.PathLike[str]) -> None: ...
    def to_html(self, path: str | os.PathLike[str] | None = None) -> str | None:
        """Write the editor as a page of its own, which needs neither a kernel nor a network.

        The page starts at the present axes. The outline can be dragged as in the notebook, because
        the page contains the solver for targets and pins.

        Parameters
        ----------
        path : str or path, optional
            The file to write. Without it, the page is returned.

        Returns
        -------
        str or None
        """
        with self._lock:
            body = view(self.get_state(PAGE_TRAITS))
            title = f"{self.text.string} in {self.text.font.family_name}"
        made = page(title, body, self._esm, self._css + PAGE_STYLE)
        if path is None:
            return made
        Path(path).write_text(made, encoding="utf-8")
        return None

    @contextmanager
    def _adoption(self) -> Iterator[None]:
        """While traits are being made to agree, their observers rest."""
        with self._lock:
            before, self._adopting = self._adopting, True
            try:
                yield
            finally:
                self._adopting = before

    def _adopt(self, text: Text, pins: Sequence[Handle]) -> None:
        """Make a text and its pins the state, and every trait say so."""
        # A pin that was made before the letters got separate axes, or shared ones, is still valid.
        pins = [text.handle(p.glyph, p.contour, p.segment, p.t) for p in pins]
        with self._adoption(), self.hold_sync():
            if text.word is not self.text.word:
                self._word = describe_word(text.word)
            self.text = text
            self.shared = text.shared
            self.axes = text.axes
            self.pins = pins
            self._pins = [[p.glyph, p.contour, p.segment, p.t] for p in pins]
            self.error = ""

    @traitlets.validate("axes")
    def _check_axes(self, proposal: Any) -> Any:
        return proposal["value"] if self._adopting else self._moved(proposal["value"]).axes

    @traitlets.validate("pins")
    def _check_pins(self, proposal: Any) -> list[Handle]:
        if not isinstance(proposal["value"], list | tuple):
            raise SolveError(f"Pins are a list of handles, not {proposal['value']!r}.")
        pins = [pin.handle if isinstance(pin, Pin) else pin for pin in proposal["value"]]
        for pin in pins:
            if not isinstance(pin, Handle) or not self.text.owns(pin):
                raise SolveError(f"{pin!r} is not a handle of this editor's text.")
        return pins

    def _moved(self, axes: Any) -> Text:
        """The text at other axes, with letters joined or set apart as ``shared`` says."""
        if self.shared == self.text.shared:
            return self.text.at(axes=axes)
        if self.shared and not isinstance(axes, Mapping):
            axes = axes[0]
        return Text(self.text.font, self.text.string, axes=axes, shared=self.shared)

    @traitlets.observe("axes", "shared")
    def _on_axes(self, _: Any) -> None:
        if not self._adopting:
            self._adopt(self._moved(self.axes), self.pins)

    @traitlets.observe("text")
    def _on_text(self, change: Any) -> None:
        if not self._adopting:
            same = change["old"].string == self.text.string
            same = same and change["old"].font is self.text.font
            with self._adoption():
                # The old word is compared with the new one to see what the view must be sent.
                self._word = describe_word(self.text.word)
            self._adopt(self.text, self.pins if same else [])

    @traitlets.observe("pins")
    def _on_pins(self, _: Any) -> None:
        if not self._adopting:
            self._adopt(self.text, self.pins)

    @traitlets.observe("_pins")
    def _on_pins_of_view(self, _: Any) -> None:
        if not self._adopting:
            pins = [self.text.handle(*place) for place in self._pins if len(place) == 4]
            if len(pins) < len(self._pins):
                raise SolveError(f"A pin is [glyph, contour, segment, t]; got {self._pins}.")
            self._adopt(self.text, pins)

    def set_state(self, sync_data: Any) -> None:
        """Take state from the view; what cannot be taken is shown there and undone."""
        with self._lock:
            try:
                super().set_state(sync_data)
            except Exception as error:
                self._adopt(self.text, self.pins)
                self.send_state(["axes", "shared", "_pins"])
                self.error = _in_words(error)
                if not isinstance(error, VFWidgetError | TypeError):
                    raise

    def _answer(self, _: Any, content: Any, buffers: Any) -> None:
        """Answer a message of the view, whatever it holds, exactly once."""
        content = content if isinstance(content, dict) else {}
        reply = {"type": "drag", "view": content.get("view"), "seq": content.get("seq")}
        try:
            with self._lock:
                reply |= self._drag(content)
        except Exception as error:
            reply |= {"ok": False, "error": _in_words(error)}
        self.send(reply)

    def _drag(self, content: dict[str, Any]) -> dict[str, Any]:
        """Solve one drag event, from where the view has predicted it, and move the text there."""
        if content.get("type") != "drag":
            raise SolveError(f"The kernel has no answer to a message {content.get('type')!r}.")
        try:
            start = self._moved(content["axes"]) if "axes" in content else self.text
            handle = start.handle(*content["handle"])
            target = Target(handle, (float(content["x"]), float(content["y"])))
        except (KeyError, TypeError, ValueError) as error:
            raise SolveError(f"This drag message is malformed ({_in_words(error)}).") from error
        gesture, (former, press) = (content.get("view"), handle), self._pressed
        if content.get("phase") == "down" or gesture != former or press.word is not start.word:
            press = start
            self._pressed = (gesture, press)
        # Everything is measured from the press, so that the path of the pointer does not matter.
        em = self.text.font.units_per_em
        terms: list[Term] = [target, StayClose((CALM * em) ** 2, press.theta)]
        terms += [Pin(pin, press.position(pin)) for pin in self.pins if pin != handle]
        released = content.get("phase") == "up"
        solution = solve(
            start,
            terms,
            max_iterations=RELEASE_ITERATIONS if released else MOVE_ITERATIONS,
            # While the pointer moves, the letter moves with it and never jumps.
            restarts=RESTARTS if released else 0,
        )
        self._adopt(solution.text, self.pins)
        return {
            "ok": True,
            "axes": self.axes,
            "status": solution.status,
            "message": solution.message,
            "point": solution.text.position(handle).tolist(),
        }


def _in_words(error: Exception) -> str:
    if isinstance(error, VFWidgetError):
        return str(error)
    return f"{type(error).__name__}: {error}"


def describe_word(word: Word) -> dict[str, Any]:
    """What the view needs to evaluate Eq. 1–3 by itself, tensors as float32 buffers.

    Regions are those of the word, once; a glyph that occurs twice is sent once. A glyph's
    ``points`` are its default outline (k, 2), then its delta sets (k, 2) each.
    """
    glyphs: list[dict[str, Any]] = []
    index: dict[int, int] = {}
    for letter, glyph in enumerate(word.glyphs):
        if glyph.glyph_id in index:
            continue
        index[glyph.glyph_id] = len(glyphs)
        affine = glyph.affine
        layers = np.concatenate([affine.base[None], np.moveaxis(affine.deltas, -1, 0)])
        glyphs.append(
            {
                "name": glyph.name,
                "contours": list(glyph.contours),
                "points": layers.astype("<f4").tobytes(),
                "regions": word.outline_regions[letter].tolist(),
                "advance": {
                    "default": affine.advance_base,
                    "regions": word.advance_regions[letter].tolist(),
                    "deltas": affine.advance_deltas.tolist(),
                },
            }
        )
    font = word.font
    support = word.regions.support
    return {
        "family": font.family_name,
        "string": word.string,
        "units_per_em": font.units_per_em,
        "ascender": font.ascender,
        "descender": font.descender,
        "axes": [
            {
                "tag": axis.tag,
                "name": axis.name,
                "minimum": axis.minimum,
                "default": axis.default,
                "maximum": axis.maximum,
                "hidden": axis.hidden,
                "map": [list(pair) for pair in axis.segment_map],
            }
            for axis in font.axes
        ],
        "regions": {"count": len(support), "data": support.astype("<f4").tobytes()},
        "glyphs": glyphs,
        "order": [index[glyph.glyph_id] for glyph in word.glyphs],
        "offsets": word.fixed_offsets.tolist(),
    }
