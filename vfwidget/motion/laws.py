"""The constants of a simulation, and the state that its steps lead on."""

from __future__ import annotations

from dataclasses import dataclass

from ..arrays import Array, BoolArray
from ..text.place import Place


@dataclass(frozen=True)
class State:
    """Place and velocity of a body.

    Attributes
    ----------
    place : Place
    velocity : (r,) array
        In reduced coordinates.
    touching : (l,) bool array
        The letters that were in contact in the last step.
    depth : float
        The deepest contact that the last step left, in font units.
    """

    place: Place
    velocity: Array
    touching: BoolArray
    depth: float = 0.0


@dataclass(frozen=True)
class Laws:
    """The constants of a simulation.

    Attributes
    ----------
    stiffness, damping : (p, n) arrays
        Springs and damping of the axes, times their inertia.
    restitution, friction : float
    frame : float
        Seconds between two frames.
    substeps : int or None
        Equal steps of a frame; None for steps that adapt.
    """

    stiffness: Array
    damping: Array
    restitution: float
    friction: float
    frame: float
    substeps: int | None
