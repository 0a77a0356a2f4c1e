"""Physics decides the frames: momentum, elasticity and contact (Sec. 5.3)."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from tqdm.auto import tqdm

from ..arrays import Array
from ..errors import MotionError, MotionWarning, SolveError, warn_caller
from ..text import Text
from ..text.colours import as_drawn
from ..text.inputs import read_flag
from ..text.place import AXES, OFFSETS, ROTATIONS, Place
from ..threads import one_thread
from .animation import Animation
from .body import Body
from .cautions import warn_of_depth, warn_of_throws
from .flight import Flight
from .inputs import (
    over_time,
    read_impulses,
    read_masses,
    read_rates,
    read_rest,
    read_vectors,
)
from .laws import Laws, State
from .numbers import read_count, read_number
from .scene import NEARBY, Scene
from .start import apart, deepest
from .steps import BlockedError, Stepper

SLOW, PATIENCE = 5e-3, 0.5
"""A text that moves by less than so many em a second for so many seconds falls asleep."""
STILL = 1e-9
"""Em per second. A letter that touches nothing stops by no friction, so it is at rest only if it
is slower than this."""
SAME_TIME = 1e-9
"""Seconds, and part of a frame: times that differ by less are equal."""
FARTHEST = 1e7
"""Font units: letters that are farther away have exploded."""


@one_thread
def simulate(
    text: Text,
    steps: int = 120,
    dt: float = 1 / 60,
    *,
    rest: Any = None,
    stiffness: Any = 400.0,
    mass: Any = 1.0,
    damping: Any = 4.0,
    forces: Any = (0.0, 0.0),
    impulses: Any = (),
    obstacles: Any = (),
    positions: bool = False,
    rotations: bool = False,
    restitution: float = 0.3,
    friction: float = 0.5,
    substeps: int | str = "auto",
    progress: bool = True,
) -> Animation:
    """Let a text move by the laws of mechanics, within the design space of its font (Sec. 5.3).

    Parameters
    ----------
    text : Text
        Where the motion starts, at rest. It is not changed.
    steps : int
        Number of frames after the first one. Default 120.
    dt : float
        Seconds from one frame to the next. Default 1/60.
    rest : optional
        The state to which the springs pull the axes: axis values, a Text, normalized coordinates,
        an :class:`Animation`, or a function of the time that returns one of the first three.
        Default: the axes of ``text``.
    stiffness : number, mapping of tag to number, (n,), (p, 1) or (p, n) array
        Squared angular frequency of each axis, in 1/s²: 0 for no spring. It is a rate, so letters
        of all fonts and masses swing equally fast. Default 400, which is about three swings a
        second.
    mass : number or (l,) array
        Mass of each letter. Default 1. Only the ratios of the masses matter.
    damping : as ``stiffness``
        Damping rate of each axis, in 1/s. The swings of an axis decay like exp(−damping · t / 2).
        The steps of the computation damp them, too: they add stiffness · dt / substeps to this
        rate. Default 4.
    forces : (2,) or (l, 2) array, or function of the time
        Acceleration of all letters, or of each one, in font units per s². Default none. Gravity
        that suits an em of 1,000 units is (0, -4000).
    impulses : sequence of (seconds, (2,) or (l, 2) array)
        Sudden changes of velocity, in font units per second. With time 0 it is the velocity at the
        start. If letters rotate, a vector may have a third number, which changes the angular
        velocity, in radians per second.
    obstacles : as for :func:`~vfwidget.overlaps`, an Animation, or a function of the time
        Shapes that the letters cannot enter. A function returns the obstacles at a time in
        seconds; they push the letters. Their number may change over time. Of the obstacles with
        equal numbers of segments, those before and after a change correspond in their order if
        they are equally many; otherwise the nearest ones correspond. Letters that a new obstacle
        covers are moved out at once, and keep their velocity. An obstacle that vanishes is there
        until the first frame without it.
    positions : bool
        Whether the letters move freely. Otherwise only their axes move. Default False.
    rotations : bool
        Whether the letters also rotate: they roll, topple and spin. It needs ``positions=True``.
        Default False.
    restitution : float
        Ratio of the speeds after and before an impact, 0 to 1. Default 0.3.
    friction : float
        Coulomb's coefficient, ≥ 0. Default 0.5. If letters rotate, it also resists rolling, with
        4 % of an em as the arm of its torque.
    substeps : "auto" or int
        Steps of the computation for each frame. "auto" adapts them, so that no letter or obstacle
        passes through a stroke unseen. It takes up to 64 steps, and shorter ones on the way to a
        contact.
    progress : bool
        Whether to show a progress bar. Default True.

    Returns
    -------
    Animation
        ``steps + 1`` frames. If the computation is interrupted (Ctrl-C), the frames so far.

    Raises
    ------
    MotionError
        An argument is not what is described above; an obstacle is less than one font unit thick;
        an overlap at the start cannot be resolved; letters cannot get out of the way of an
        obstacle; or the motion has exploded. If some frames have been computed before the error,
        ``error.animation`` holds them.

    Warns
    -----
    MotionWarning
        Letters overlapped each other or an obstacle at the start, and were moved apart; or a
        contact of some frame is deeper than 0.5 font units; or obstacles that close in on letters
        squeezed one out, at more than 10 times the speed that anything else explains.

    Notes
    -----
    A step minimises the sum of three energies over the text's place, as in the paper: inertia of
    the control points, springs on the axes, and contact. The same input gives the same result.

    Examples
    --------
    >>> import vfwidget as vf
    >>> floor = [(-500, -100), (1500, -100), (1500, 0), (-500, 0)]
    >>> text = vf.Text("recursive", "O", offsets=[(0, 300)])
    >>> fall = vf.simulate(text, 20, forces=(0, -4000), obstacles=[floor], positions=True,
    ...                    progress=False)
    >>> len(fall), bool(fall.positions[-1, 0, 1] < 100), bool(fall.penetration.max() < 0.5)
    (21, True, True)
    """
    if not isinstance(text, Text):
        raise MotionError(f"simulate needs a Text first; received {type(text).__name__}.")
    letters, drawn = len(text.glyphs), as_drawn(text)
    if not any(glyph.contours for glyph in drawn.glyphs):
        raise MotionError(f"The text {text.string!r} has no outlines, so nothing can move.")
    steps = read_count("steps", steps)
    auto = isinstance(substeps, str) and substeps == "auto"
    laws = Laws(
        stiffness=read_rates("stiffness", stiffness, text),
        damping=read_rates("damping", damping, text),
        restitution=read_number("restitution", restitution, 0.0, 1.0, False),
        friction=read_number("friction", friction, 0.0, math.inf, False),
        frame=read_number("dt", dt, 0.0, math.inf, True),
        substeps=None if auto else read_count('substeps, unless "auto",', substeps),
    )
    positions = read_flag("positions", positions, MotionError)
    rotations = read_flag("rotations", rotations, MotionError)
    if rotations and not positions:
        raise MotionError(
            "rotations=True needs positions=True, because a letter rotates about its centre of "
            "mass, which then moves its origin."
        )
    masses = read_masses(mass, letters)
    pushes = read_impulses(impulses, letters, rotations)
    outside = _Influences(text, over_time(rest), over_time(forces))
    outside.at(0.0)
    scene = Scene(drawn, over_time(obstacles))
    body = Body(drawn, masses, positions, rotations)
    start = apart(body, scene)
    laws = replace(
        laws, stiffness=laws.stiffness * body.inertia, damping=laws.damping * body.inertia
    )
    run = _Run(body, scene, laws, outside, pushes, start)
    with tqdm(total=steps, desc="simulate", leave=False, disable=not progress) as bar:
        try:
            for _ in range(steps):
                run.advance()
                bar.update()
        except KeyboardInterrupt:
            warn_caller(
                f"The simulation was interrupted after {run.time:.4g} s; the frames so far are "
                "returned.",
                MotionWarning,
            )
        except MotionError as error:
            # The obstacles, the forces or the rest state of a later time cannot be read.
            error.animation = run.animation()
            raise
        except _StoppedError as error:
            failure = MotionError(
                f"After {run.time:.4g} s {error} error.animation holds the frames so far."
            )
            failure.animation = run.animation()
            raise failure from error
    made = run.animation()
    warn_of_depth(made)
    warn_of_throws(made, np.array(run.gains))
    return made


class _StoppedError(Exception):
    """The motion cannot go on."""


class _Influences:
    """The rest state and the accelerations as functions of the time."""

    def __init__(self, text: Text, rest: Any, forces: Any) -> None:
        self.text, self._rest, self._forces = text, rest, forces
        self.changing = callable(rest) or callable(forces)

    def at(self, time: float) -> tuple[Array, Array]:
        """Accelerations (l, 2) and the rest state (p, n)."""
        forces = self._forces(time) if callable(self._forces) else self._forces
        rest = self._rest(time) if callable(self._rest) else self._rest
        return (
            read_vectors("forces", forces, len(self.text.glyphs)),
            self.text.coordinates if rest is None else read_rest(rest, self.text),
        )


@dataclass
class _Run:
    """A simulation: the present state, and what each frame has recorded."""

    body: Body
    scene: Scene
    laws: Laws
    outside: _Influences
    impulses: list[tuple[float, Array]]
    start: Place
    frames: list[tuple[Place, float, float]] = field(default_factory=list)
    gains: list[float] = field(default_factory=list)
    quiet: float = 0.0

    def __post_init__(self) -> None:
        self.stepper = Stepper(self.body, self.scene, self.laws)
        count = len(self.body.rows)
        velocity = np.zeros(len(self.body.lift))
        self.state = State(self.start, velocity, np.zeros(count, dtype=bool))
        self._asleep: list[Array] | None = None
        self._gain = 0.0
        self._push(0.0)
        self._record()

    @property
    def time(self) -> float:
        """Seconds since the start."""
        return max(len(self.frames) - 1, 0) * self.laws.frame

    @np.errstate(over="ignore", invalid="ignore")
    def _push(self, time: float) -> None:
        """Apply the impulses whose time has come."""
        due = np.zeros_like(self.state.velocity)
        while self._is_due(time):
            change = self.impulses.pop(0)[1]
            self._gain += float(np.hypot(*change[:, :2].T).max(initial=0.0))
            due = due + self.body.force(change[:, :2])
            if self.body.rotates:
                due = due + Flight(self.body, self.state.place, due).rotation(change[:, 2])
        self.state = replace(self.state, velocity=self.state.velocity + due)

    def _is_due(self, time: float) -> bool:
        """Whether an impulse is left that acts at a time or before."""
        return bool(self.impulses) and self.impulses[0][0] <= time + SAME_TIME

    def _move(self, acceleration: Array, rest: Array) -> None:
        """Lead the state to the next frame, and let impulses act on the way."""
        now, end = self.time, self.time + self.laws.frame
        while end - now > SAME_TIME * self.laws.frame:
            self._push(now)
            until = min(end, self.impulses[0][0]) if self.impulses else end
            self.state = self.stepper.moved(self.state, now, until, acceleration, rest)
            now = until

    def advance(self) -> None:
        """Compute the next frame."""
        time = self.time
        acceleration, rest = self.outside.at(time)
        self._gain += self.laws.frame * float(np.hypot(*acceleration.T).max(initial=0.0))
        pushed = self._is_due(time + self.laws.frame)
        around = [acceleration, rest, self.scene.at(time + self.laws.frame)[1]]
        if self._asleep is not None:
            same = all(map(np.array_equal, self._asleep, around))
            if same and not pushed:
                self.frames.append(self.frames[-1])
                self.gains.append(self._gain)
                return
            self._asleep, self.quiet = None, 0.0
        before = self.body.positions(self.state.place)
        try:
            with np.errstate(over="ignore", invalid="ignore"):
                self._move(acceleration, rest)
        except BlockedError as error:
            raise _StoppedError(
                f"letters cannot get out of the way of each other or an obstacle (depth "
                f"{error.args[0]:.3g} font units). Make room for them"
                + ("." if OFFSETS in self.body.free else ", or pass positions=True.")
            ) from error
        except (SolveError, np.linalg.LinAlgError) as error:
            raise _StoppedError(
                "the motion exploded: a step has no finite solution. Use weaker forces or a "
                "shorter dt."
            ) from error
        after = self.body.positions(self.state.place)
        farthest = float(abs(after).max(initial=0.0))
        if not farthest < FARTHEST:
            raise _StoppedError(
                f"the motion exploded: a letter is {farthest:.3g} font units away. Use weaker "
                "forces or a shorter dt."
            )
        speed = self.body.by_letter(after - before) / self.laws.frame
        limit = np.where(self.state.touching, SLOW, STILL) * self.body.text.font.units_per_em
        self.quiet = self.quiet + self.laws.frame if (speed <= limit).all() else 0.0
        if self.quiet >= PATIENCE and not pushed:
            self._asleep = around
            self.state = replace(self.state, velocity=np.zeros_like(self.state.velocity))
        self._record()

    def _record(self) -> None:
        place, velocity = self.state.place, self.state.velocity
        time = self.time if not self.frames else self.time + self.laws.frame
        acceleration, rest = self.outside.at(time)
        points = self.body.positions(place)
        outlines, obstacles = self.scene.at(time)
        segments = np.concatenate([points[self.body.controls], obstacles])
        gaps = self.scene.gaps(outlines, segments, NEARBY)
        depth = max(0.0, -float(gaps.gap.min(initial=0.0)))
        if outlines.boxes_overlap(segments, NEARBY):
            # A deeper contact is beyond the reach of the gaps.
            depth = max(depth, deepest(self.body.text.moved_to(place), self.scene.shapes(time)))
        with np.errstate(over="ignore", invalid="ignore"):
            stretch = self.laws.stiffness * (place[AXES] - rest) ** 2
            energy = (
                0.5 * float(velocity @ velocity)
                + 0.5 * float(stretch.sum())
                - float(self.body.force(acceleration) @ self.body.reduced_at(place))
            )
        if not math.isfinite(energy):
            raise MotionError(
                f"At {time:.4g} s the energy of the motion is larger than any number. Use weaker "
                "forces or impulses, or a smaller mass."
            )
        self.frames.append((place, depth, energy))
        self.gains.append(self._gain)

    def animation(self) -> Animation:
        """The frames so far."""
        places, penetration, energy = zip(*self.frames, strict=True)
        times = self.laws.frame * np.arange(len(places))
        return Animation(
            self.outside.text.moved_to(places[0]),
            times,
            np.array([place[AXES] for place in places]),
            np.array([place[OFFSETS] for place in places]),
            None if not self.body.rotates else np.array([place[ROTATIONS] for place in places]),
            penetration=np.array(penetration),
            energy=np.array(energy),
            scenery=[self.scene.contours(time) for time in times],
        )
