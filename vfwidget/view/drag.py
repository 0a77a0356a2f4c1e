"""One drag event as an energy: a target, pins and a weak pull to the press (Sec. 5.1)."""

from __future__ import annotations

from typing import Any

from ..energy.handle_terms import Pin, Target
from ..energy.solve import solve
from ..energy.term import Term
from ..energy.tied import Ties
from ..energy.word_terms import StayClose
from ..errors import SolveError
from ..overlap.follow import Followed, Held, follow
from ..overlap.no_overlap import NoOverlap
from ..text import Handle, Text
from .constraints import terms
from .state import State

CALM = 0.001
"""√λ of Sec. 5.1, in ems: a drag moves an axis over its range only if it gains more than this."""
MOVE_ITERATIONS = 30
RELEASE_ITERATIONS = 200
RELEASE_SUBSTEPS = 3
RESTARTS = 8
RESTART_SECONDS = 0.15
"""The search for a better result ends after this time, so that the kernel stays ready."""


def solve_drag(
    state: State,
    press: Text,
    target: Target | None = None,
    *,
    released: bool = False,
    keep: NoOverlap | None = None,
    ties: Ties = (),
    held: Held | None = None,
) -> Followed:
    """Solve for the axis values that bring the outline to where it is dragged.

    Everything is measured from the press, so that the path of the pointer does not matter.

    Parameters
    ----------
    state : State
        The text from which the solver sets out, and the pins, locks and constraints.
    press : Text
        The text when the pointer was pressed. Pins hold their positions there.
    target : Target, optional
        Without it, the axes only move to meet the constraints.
    released : bool
        Whether the pointer was released. Only then does the solver also look for a better result
        farther away, because while the pointer moves, the letter must not jump.
    keep : NoOverlap, optional
        What must not overlap. The text then moves only as far as its way is free.
    ties : sequence of sequences of int
        Letters that share one axis vector, as for :func:`solve`.
    held : Held, optional
        What the text pressed against at the last event, as for :func:`.follow`.

    Returns
    -------
    Followed
    """
    wanted: list[Term] = [] if target is None else [target]
    wanted.append(StayClose((CALM * press.font.units_per_em) ** 2, press.theta))
    dragged = None if target is None else target.handle
    wanted += [Pin(pin, press.position(pin)) for pin in state.pins if pin != dragged]
    wanted += terms(state.constraints, state.text)
    iterations = RELEASE_ITERATIONS if released else MOVE_ITERATIONS
    if keep is not None:
        return follow(
            state.text,
            wanted,
            keep,
            locks=state.locks,
            ties=ties,
            max_iterations=iterations,
            substeps=RELEASE_SUBSTEPS if released else 1,
            held=held,
        )
    solution = solve(
        state.text,
        wanted,
        locks=state.locks,
        ties=ties,
        max_iterations=iterations,
        restarts=RESTARTS if released else 0,
        restart_seconds=RESTART_SECONDS,
    )
    return Followed(solution)


class Drags:
    """Solves the drag messages of the view, and remembers where each drag began.

    Parameters
    ----------
    text : Text
        The text of the editor when it is made.
    """

    def __init__(self, text: Text) -> None:
        self._gesture: Any = None
        self._press = text
        self._held: Held | None = None

    def solve(
        self, message: dict[str, Any], state: State, keep: NoOverlap | None = None
    ) -> tuple[Followed, Handle]:
        """Solve one message.

        Parameters
        ----------
        message : dict
            As ``js/README.md`` describes it.
        state : State
            The state from which the solver sets out.
        keep : NoOverlap, optional
            As for :func:`solve_drag`.

        Returns
        -------
        Followed, Handle
            What was found, and the point that is dragged.

        Raises
        ------
        SolveError
            The message is malformed.
        """
        try:
            phase, gesture = message.get("phase"), (message.get("view"), message["handle"])
            goes_on = phase != "down" and gesture == self._gesture
            press = self._press if goes_on else state.text
            if press.composition is not state.text.composition:
                press = state.text
            # A glyph may change during a drag; the view names the point as it was at the press.
            handle = press.handle(*message["handle"])
            target = Target(handle, (float(message["x"]), float(message["y"])))
            ties = ties_of(message, state.text)
        except (KeyError, TypeError, ValueError) as error:
            raise SolveError(
                f"This drag message is malformed ({type(error).__name__}: {error})."
            ) from error
        self._gesture, self._press = gesture, press
        released = phase == "up"
        followed = solve_drag(
            state,
            self._press,
            target,
            released=released,
            keep=keep,
            ties=ties,
            held=self._held if goes_on else None,
        )
        self._held = followed.held
        return followed, handle


def ties_of(message: dict[str, Any], text: Text) -> Ties:
    """The letters that share one axis vector by a drag message.

    Raises
    ------
    SolveError
        The range is not two whole numbers.
    """
    try:
        first, last = message.get("range", (0, 0))
        return [range(len(text.glyphs))[first : last + 1]]
    except (TypeError, ValueError) as error:
        raise SolveError(
            "The range of a drag message must be the first and the last letter; "
            f"received {message.get('range')!r:.200}."
        ) from error


def answer(followed: Followed, handle: Handle) -> dict[str, Any]:
    """What the view is told of a drag, besides the axes: ``js/README.md`` describes it."""
    solution = followed.solution
    return {
        "status": solution.status,
        "message": solution.message,
        "elsewhere": None if solution.elsewhere is None else solution.elsewhere.axes,
        "point": solution.text.position(handle).tolist(),
        "contacts": followed.contacts.tolist(),
    }
