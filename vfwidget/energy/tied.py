"""Letters that share one axis vector: an energy of fewer unknowns.

The energy of a text with one axis vector for each letter is taken at Θ = E z, where z has one
axis vector for each group of letters. The chain rule gives the Jacobian J E.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np

from ..arrays import Array, BoolArray, IntArray, padded_table
from ..errors import SolveError
from ..solver.problem import is_count, pooled
from ..text import Text
from ..text.place import AXES, Unknowns
from .checked import bound
from .energy import Energy
from .term import Term, TermResult
from .word_terms import StayClose

Ties = Sequence[Sequence[int]]
"""Groups of letters; the letters of a group share one axis vector."""


def energy_of(
    text: Text,
    terms: Sequence[Term],
    free: Collection[str] = (AXES,),
    locks: Collection[str] = (),
    ties: Ties = (),
) -> Energy:
    """An energy as :class:`Energy`, with the letters of each group tied together.

    Raises
    ------
    SolveError
        As :class:`Energy`; or ``ties`` are no groups of letters, or a letter is in two of them.
    """
    if not isinstance(ties, tuple | list) or ties:
        leaders = _leaders(ties, len(text.glyphs))
        followers = int(np.count_nonzero(leaders != np.arange(len(leaders))))
        if followers and not text.shared:
            grouped = text.moved(text.coordinates[leaders])
            # The terms hold on to what they find at the text, also where a group starts elsewhere;
            # only the axes to stay close to are those of the start.
            terms = [bound(term, grouped if _is_close(term) else text) for term in terms]
            whole = Energy(grouped, terms, free, locks, followers)
            return TiedEnergy(whole, leaders) if AXES in whole.unknowns.slices else whole
    # A drag asks for the same energy at every event, with another goal.
    latest: Energy | None = text.word.latest_energy
    if latest is not None and _is_over(latest, free, locks):
        return latest.at(text, terms)
    return Energy(text, terms, free, locks)


def _is_close(term: Any) -> bool:
    """Whether a term keeps axes near those of the start of the solve."""
    return isinstance(term, StayClose) and term.theta is None


def _is_over(energy: Energy, free: Collection[str], locks: Collection[str]) -> bool:
    """Whether an energy has these free blocks and locks, and no followers."""
    known, locked, followers = energy.options
    return not followers and _are(free, known) and _are(locks, locked)


def _are(given: Any, tags: tuple[str, ...]) -> bool:
    """Whether what a caller gives are these strings, in a tuple or a list."""
    if given is tags:
        return True
    # Arrays are not equal as a whole.
    listed = type(given) in (tuple, list) and all(type(tag) is str for tag in given)
    return listed and tuple(given) == tags


def _leaders(ties: Ties, letters: int) -> IntArray:
    """The letter whose axis vector each letter has: the first one of its group."""
    leaders = np.arange(letters)
    try:
        groups: list[list[Any]] = [list(group) for group in ties]
    except TypeError:
        groups = [[None]]
    if not all(is_count(letter) or type(letter) is int for group in groups for letter in group):
        raise SolveError(
            f"ties must be groups of letters, such as [(0, 1, 2)]; received {ties!r:.200}."
        )
    seen: set[int] = set()
    for group in groups:
        wrong = [i for i in group if not 0 <= i < letters or i in seen]
        if wrong or len(set(group)) < len(group):
            raise SolveError(
                f"Each letter (0 to {letters - 1}) may be in one group of ties once; "
                f"received {ties!r:.200}."
            )
        seen.update(group)
        leaders[group] = group[:1]
    return leaders


class TiedUnknowns:
    """The free unknowns of an energy without those of the letters that follow others.

    Parameters
    ----------
    whole : Unknowns
    kept : (k,) array
        The indices of the unknowns that remain.
    source : (N,) array
        For each unknown of the whole, the index in ``kept`` of the one that it equals.
    """

    def __init__(self, whole: Unknowns, kept: IntArray, source: IntArray) -> None:
        self._whole, self._kept, self._source = whole, kept, source
        self.start = whole.start[kept]
        bounds = [np.searchsorted(kept, (s.start, s.stop)) for s in whole.slices.values()]
        self.slices = {
            name: slice(int(a), int(b)) for name, (a, b) in zip(whole.slices, bounds, strict=True)
        }

    def is_only(self, name: str) -> bool:
        """As :meth:`Unknowns.is_only`."""
        return self._whole.is_only(name)

    def value(self, name: str, z: Array) -> Array:
        """As :meth:`Unknowns.value`: the axes of all letters."""
        return self._whole.value(name, z[self._source])

    def place(self, z: Array) -> dict[str, Array]:
        """As :meth:`Unknowns.place`."""
        return self._whole.place(z[self._source])

    def kept(self, values: Any) -> Any:
        """The values (k,) of the unknowns that remain, from those of all (N,)."""
        return values[self._kept]

    def flat(self, values: Mapping[str, Array]) -> Array:
        """As :meth:`Unknowns.flat`; of the letters of a group the first one counts."""
        return self.kept(self._whole.flat(values))


class TiedEnergy(Energy):
    """An energy over the axis vectors of groups of letters; the attributes are those of Energy.

    A group counts once in :class:`StayClose`, as the one axis vector of a whole word does.

    Parameters
    ----------
    whole : Energy
        Of a text with one axis vector for each letter.
    leaders : (l,) array
        The letter whose axis vector each letter has.
    """

    unknowns: Any

    def __init__(self, whole: Energy, leaders: IntArray) -> None:
        self._whole, self._leaders = whole, leaders
        self.text, self.terms, self.moves = whole.text, whole.terms, whole.moves
        self.row_count = whole.row_count
        axes = whole.unknowns.slices[AXES]
        count = len(whole.text.font.axes)
        lead = np.arange(len(whole.lower))
        lead[axes] = (axes.start + count * leaders[:, None] + np.arange(count)).ravel()
        kept, self._source = np.unique(lead, return_inverse=True)
        self.unknowns = TiedUnknowns(whole.unknowns, kept, self._source)
        self.lower, self.upper = np.full(len(kept), -np.inf), np.full(len(kept), np.inf)
        np.maximum.at(self.lower, self._source, whole.lower)
        np.minimum.at(self.upper, self._source, whole.upper)
        # There is a square for each letter of a group.
        self.proximity, apart = pooled(*whole.proximity, self._source, len(kept))
        self.constant = whole.constant + apart

    def at(self, text: Text, terms: Sequence[Term]) -> Energy:
        """As :meth:`Energy.at`."""
        return TiedEnergy(self._whole.at(text, terms), self._leaders)

    @property
    def varied(self) -> BoolArray:
        """As :attr:`Energy.varied`."""
        return np.bincount(self._source, self._whole.varied) > 0

    @property
    def locked(self) -> BoolArray:
        """As :attr:`Energy.locked`."""
        return self.unknowns.kept(self._whole.locked)

    @property
    def kinks(self) -> Array:
        """Those of all letters of a group."""
        return self._merged(self._whole.kinks)

    @property
    def all_kinks(self) -> Array:
        """As :attr:`Energy.all_kinks`."""
        return self._merged(self._whole.all_kinks)

    def _merged(self, kinks: Array) -> Array:
        return padded_table([np.unique(kinks[self._source == i]) for i in range(len(self.lower))])

    def by_letter(self, values: Any) -> Any:
        """As :meth:`Energy.by_letter`."""
        return self._whole.by_letter(values[self._source])

    def residual(self, x: Array) -> Array:
        """As :meth:`Energy.residual`."""
        return self._whole.residual(x[self._source])

    def jacobian(self, x: Array) -> Array:
        """As :meth:`Energy.jacobian`, by the chain rule."""
        return self._summed(self._whole.jacobian(x[self._source]))

    def by_unknowns(self, slopes: Array) -> Array:
        """As :meth:`Energy.by_unknowns`."""
        return self._summed(self._whole.by_unknowns(slopes))

    def _summed(self, whole: Array) -> Array:
        jacobian = np.zeros((len(whole), len(self.lower)))
        np.add.at(jacobian.T, self._source, whole.T)
        return jacobian

    def renew(self, x: Array) -> Array:
        """As :meth:`Energy.renew`."""
        return self._whole.renew(x[self._source])

    def results(self, x: Array, residual: Array | None = None) -> list[TermResult]:
        """As :meth:`Energy.results`."""
        return self._whole.results(x[self._source], residual)
