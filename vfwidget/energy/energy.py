"""An energy over a place: located terms, stacked as one residual of the free unknowns (Eq. 4)."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from functools import cached_property
from itertools import repeat
from typing import Any

import numpy as np

from ..arrays import Array, BoolArray
from ..solver.problem import check_size, pooled
from ..text import Text
from ..text.place import AXES, OFFSETS, TRACKING, Unknowns
from .affine import AffineTerm, compiled
from .checked import (
    all_blocks,
    bound,
    fixed_cost,
    located,
    locked_axes,
    miss_of,
    no_terms,
    proximity_around,
    proximity_of,
)
from .rows import PointRows, changed_rows, joined, wrong_rows
from .term import MET, Term, TermResult


class Energy:
    """Terms bound to a text: the residual and its Jacobian as functions of the free unknowns.

    The residuals of affine terms come first, compiled (:mod:`.affine`); the others are evaluated
    from their rows. Squares of the unknowns themselves, such as those of :class:`StayClose`, are
    no residuals; they are collected in :attr:`proximity`.

    Parameters
    ----------
    text : Text
        Where the solve starts.
    terms : sequence of Term
    free : collection of str
        Blocks of the text's unknowns that may move. Blocks that terms add are always free.
    locks : collection of str
        Tags of axes that keep their values.
    followers : int
        Letters whose axes are those of another letter, and so are no unknowns (:mod:`.tied`).

    Attributes
    ----------
    terms : list of Term
        Bound to the text.
    unknowns : Unknowns
    lower, upper : (N,) arrays
        Bounds of the free unknowns, which coincide for locked axes.
    kinks : (N, q) array
        Padded with infinity.
    proximity : Proximity
        The energy contains Σ weights · (x − reference)².
    options : tuple
        ``free``, ``locks`` and ``followers``.
    constant : float
        What the energy contains besides, because terms pull one unknown to different references,
        or pull unknowns that are not free.
    moves : bool
        Whether a term has to be located again between the steps of the solver.
    row_count : int, optional
        The number of residuals, if all of them are compiled.
    has_form : bool
        Whether :meth:`at` can keep what is compiled: all rows are compiled, and the form of every
        term is known.

    Raises
    ------
    SolveError
        There are no terms, one of them is not valid for this text, or there are too many for
        ``limits.step_products``.
    AxisError
        A lock is no tag of the font.
    """

    def __init__(
        self,
        text: Text,
        terms: Sequence[Term],
        free: Collection[str] = (AXES,),
        locks: Collection[str] = (),
        followers: int = 0,
    ) -> None:
        if not terms:
            raise no_terms()
        self.text = text
        self.terms = [bound(term, text) for term in terms]
        blocks, added = all_blocks(text, self.terms)
        self.unknowns = unknowns = Unknowns(blocks, free, added)
        # An array of several tags is neither true nor false.
        none = locks is None or (type(locks) is tuple and not locks)
        self._locks = None if none else self._each(locked_axes(text.font, locks))
        # Copies: a list may change later.
        self.options = tuple(free), () if none else tuple(locks), followers
        self._check_size()
        self._set_bounds()
        self._pulls = [proximity_of(term, text, unknowns) for term in self.terms]
        self._fixed = list(map(fixed_cost, self.terms, self._pulls, repeat(text), repeat(unknowns)))
        self._fixed_cost = sum(cost or 0.0 for cost in self._fixed)
        self._collect_proximity()
        self._rows = [located(term, text) for term in self.terms]
        self.moves = any(term.moving for term in self.terms)
        self._compile()
        same = not self._others and all(cost is None for cost in self._fixed)
        self.has_form = same and self._rebound(text, terms) is not None
        if self.has_form and not followers:
            text.word.latest_energy = self

    def at(self, text: Text, terms: Sequence[Term]) -> Energy:
        """An energy with the same free blocks and locks, at another place of the text.

        If the terms differ from those of this energy only in their goals, as in a drag, what is
        compiled is kept. For other glyphs it is that of the latest energy of those glyphs.
        """
        known = self if text.word is self.text.word else text.word.latest_energy
        alike = known is not None and known.has_form and known.options == self.options
        kept = known._rebound(text, terms) if alike else None
        if kept is None:
            return Energy(text, terms, *self.options)
        other = object.__new__(Energy)
        other.__dict__.update(known.__dict__)
        blocks, before = text.blocks, known.unknowns.blocks
        other.text, other.terms, other.unknowns = text, kept, known.unknowns.at(blocks)
        other._set_bounds()
        other._pulls = list(map(proximity_around, kept, known._pulls, repeat(other.unknowns)))
        other._collect_proximity()
        offsets, tracking = before[OFFSETS].value, before[TRACKING].value
        if blocks[OFFSETS].value is not offsets or blocks[TRACKING].value is not tracking:
            other._find_shift()
        # The rows of compiled terms are not asked again.
        other._set_constant(
            [
                affine.root * term.residual(*affine.origin)
                for affine, term in zip(known._affine, kept, strict=True)
                if affine is not None
            ]
        )
        return other

    def _rebound(self, text: Text, terms: Sequence[Term]) -> list[Term] | None:
        """The terms, bound to a text, if they differ from those of the energy in goals only.

        None if they do not, or if the text has other glyphs, or rotated letters, whose points are
        not affine.
        """
        here = self.text
        upright = text.rotations is here.rotations or not np.count_nonzero(text.rotations)
        if text.word is not here.word or not upright or len(terms) != len(self.terms):
            return None
        kept: list[Term] = []
        for term, known in zip(terms, self.terms, strict=True):
            found = term.rebound(known, text) if isinstance(term, Term) else None
            if found is None:
                return None
            kept.append(found)
        return kept

    def _check_size(self) -> None:
        """Refuse too many terms: most have at least one residual, and each takes memory later."""
        tied = self.options[2] * len(self.text.font.axes) if AXES in self.unknowns.slices else 0
        check_size(len(self.terms), len(self.unknowns.start) - tied)

    def _set_bounds(self) -> None:
        """Take the bounds from the unknowns; locked ones have one value."""
        self.lower, self.upper = self.unknowns.lower, self.unknowns.upper
        if self._locks is not None:
            self.lower = np.where(self._locks, self.unknowns.start, self.lower)
            self.upper = np.where(self._locks, self.unknowns.start, self.upper)

    @cached_property
    def locked(self) -> BoolArray:
        """Which unknowns, (N,), are axes that are locked, or that have one value in the font.

        A box in which the glyphs stay may be as narrow as one value too, but a solve may leave it.
        """
        single = self._each(np.equal(*self.text.font.bounds))
        return single if self._locks is None else single | self._locks

    def _each(self, by_axis: Any) -> BoolArray:
        """Truth values for each axis, (n,), or entry of Θ, as one for each unknown, (N,)."""
        found = np.zeros(len(self.unknowns.start), dtype=bool)
        if AXES in self.unknowns.slices:
            axes = found[self.unknowns.slices[AXES]].reshape(self.text.coordinates.shape)
            axes[:] = np.asarray(by_axis).reshape(-1, len(self.text.font.axes))
        return found

    def _collect_proximity(self) -> None:
        pulls = [pull for pull in self._pulls if pull is not None]
        if len(pulls) == 1:
            self.proximity, self.constant = pulls[0], self._fixed_cost
            return
        weights, reference = np.array(pulls).reshape(-1, 2, len(self.lower)).swapaxes(0, 1)
        owner = np.tile(np.arange(len(self.lower)), len(pulls))
        self.proximity, apart = pooled(weights.ravel(), reference.ravel(), owner, len(self.lower))
        self.constant = self._fixed_cost + apart

    def _compile(self) -> None:
        """Separate the affine rows from the others."""
        theta = self.text.coordinates
        self._affine = [
            AffineTerm.of(rows, theta) if isinstance(rows, PointRows) else None
            for rows in self._rows
        ]
        self._others = [
            rows
            for rows, affine in zip(self._rows, self._affine, strict=True)
            if rows is not None and affine is None
        ]
        terms = [affine for affine in self._affine if affine is not None]
        self._compiled = compiled(self.text.word, terms) if terms else None
        self._sizes: list[int] | None = None
        # A drag: everything is compiled, and Θ is all that moves.
        self._only_axes = bool(terms) and not self._others and self.unknowns.is_only(AXES)
        self._linear: dict[str, Array] = {}
        axes = self.text.word.kinks
        if self._compiled is not None:
            axes = axes if self._others else self._compiled.kinks
            free = [name for name in (OFFSETS, TRACKING) if name in self.unknowns.slices]
            self._linear = {name: self._compiled.by_block(name) for name in free}
        self._kinks = self.unknowns.kinks(axes)
        self._find_shift()
        self._set_constant(
            [
                affine.constant(rows)
                for affine, rows in zip(self._affine, self._rows, strict=True)
                if affine is not None and isinstance(rows, PointRows)
            ]
        )
        self.row_count = None if self._others else len(self._constant)

    def _find_shift(self) -> None:
        """Find what fixed unknowns add to the affine rows; None if they are zero."""
        self._shift: Array | None = None
        for name in (OFFSETS, TRACKING):
            fixed = self.unknowns.value(name, self.unknowns.start)
            if self._compiled and name not in self._linear and np.count_nonzero(fixed):
                part = self._compiled.by_block(name) @ fixed.ravel()
                self._shift = part if self._shift is None else self._shift + part

    def _set_constant(self, parts: Sequence[Array]) -> None:
        """Add up what the goals (``parts``) and the fixed unknowns add to the affine rows."""
        self._constant = joined(parts) if parts else np.zeros(0)
        if self._shift is not None:
            self._constant = self._constant + self._shift

    @cached_property
    def least_goal(self) -> float:
        """What it costs to miss a goal by its tolerance, for the goal of which this is least.

        The unit is the same cost of a usual goal, whose weight is 1 and whose tolerance is half a
        font unit. 1 if there is no goal.
        """
        goals = [t.weight * (t.tolerance / MET) ** 2 for t in self.terms if t.tolerance is not None]
        return min(goals, default=1.0)

    def by_letter(self, values: Any) -> Any:
        """An array for the free unknowns (N,), as that of the axes in the shape of Θ."""
        return values[self.unknowns.slices[AXES]].reshape(self.text.coordinates.shape)

    @property
    def kinks(self) -> Array:
        """See the attributes of the class."""
        return self._kinks

    @property
    def varied(self) -> BoolArray:
        """Which unknowns, (N,), are axes that affect a term."""
        known = None if self._others else self._compiled
        moved = np.isfinite(self.text.word.kinks).any(1) if known is None else known.moved_by
        return self._each(moved)

    @property
    def all_kinks(self) -> Array:
        """As :attr:`kinks`, also of axes that affect no term, and with those at ends of axes."""
        return self.unknowns.kinks(self.text.word.kinks)

    def by_unknowns(self, slopes: Array) -> Array:
        """Derivatives by the free unknowns (r, N), from those by all axes (r, size of Θ)."""
        found = np.zeros((len(slopes), len(self.lower)))
        if AXES in self.unknowns.slices:
            found[:, self.unknowns.slices[AXES]] = slopes
        return found

    def residual(self, x: Array) -> Array:
        """All residuals (r,) at the free unknowns x (N,).

        Raises
        ------
        SolveError
            A term whose number of residuals may not change has another number than before.
        """
        if self._only_axes and self._compiled is not None:
            return self._constant + self._compiled.evaluate(x)[0]
        if self.row_count == 0:
            return self._constant
        place = self.unknowns.place(x)
        parts = [rows.residual(place) for rows in self._others]
        self._check_sizes(parts)
        return joined([self._affine_residual(place), *parts])

    def _affine_residual(self, place: Mapping[str, Array]) -> Array:
        if self._compiled is None:
            return self._constant
        residual = self._constant + self._compiled.evaluate(place[AXES].ravel())[0]
        for name, block in self._linear.items():
            residual = residual + block @ place[name].ravel()
        return residual

    def _check_sizes(self, parts: Sequence[Array], derivative: bool = False) -> None:
        sizes = [len(part) for part in parts]
        if self._sizes is None:
            self._sizes = sizes
        if sizes != self._sizes:
            changed = next(i for i, size in enumerate(sizes) if size != self._sizes[i])
            others = [t for t, r in zip(self.terms, self._rows, strict=True) if r in self._others]
            # Where torch differentiates the residual, it is the residual that has changed.
            if derivative and not getattr(self._others[changed], "automatic", False):
                raise wrong_rows(others[changed].kind, sizes[changed], self._sizes[changed])
            raise changed_rows(others[changed].kind, sizes[changed], self._sizes[changed])

    def jacobian(self, x: Array) -> Array:
        """Derivative of the residuals by the free unknowns, (r, N)."""
        if self._only_axes and self._compiled is not None:
            return self._compiled.evaluate(x)[1]
        if self.row_count == 0:
            return np.zeros((0, len(x)))
        place, slices = self.unknowns.place(x), self.unknowns.slices
        parts = [rows.jacobian(place, slices) for rows in self._others]
        self._check_sizes(parts, derivative=True)
        if self._compiled is not None or not parts:
            parts.insert(0, self._affine_jacobian(place))
        return joined(parts)

    def _affine_jacobian(self, place: Mapping[str, Array]) -> Array:
        slices, size = self.unknowns.slices, len(self.lower)
        if self._compiled is None:
            return np.zeros((0, size))
        by_axes = self._compiled.evaluate(place[AXES].ravel())[1]
        jacobian = np.zeros((len(by_axes), size))
        if AXES in slices:
            jacobian[:, slices[AXES]] = by_axes
        for name, block in self._linear.items():
            jacobian[:, slices[name]] = block
        return jacobian

    def renew(self, x: Array) -> Array:
        """Locate the moving terms again at x (N,); the residual there."""
        here = self.text.moved_to(self.unknowns.place(x))
        self._rows = [
            located(term, here) if term.moving else rows
            for term, rows in zip(self.terms, self._rows, strict=True)
        ]
        self._compile()
        return self.residual(x)

    def results(self, x: Array, residual: Array | None = None) -> list[TermResult]:
        """Every term at the free unknowns x, in the order given.

        Parameters
        ----------
        x : (N,) array
        residual : (r,) array, optional
            The residual there, if it is known.
        """
        residual = self.residual(x) if residual is None else residual
        begun, others, sizes = 0, len(self._constant), iter(self._sizes or ())
        found = []
        for term, rows, affine, pull, fixed in zip(
            self.terms, self._rows, self._affine, self._pulls, self._fixed, strict=True
        ):
            cost, miss = fixed or 0.0, None
            if affine is not None:
                part = residual[begun : begun + affine.size]
                begun += affine.size
                cost, miss = cost + float(part.dot(part)), miss_of(term, part / affine.root)
            elif rows is not None:
                part = residual[others : others + next(sizes)]
                others += len(part)
                cost += float(part.dot(part))
                if isinstance(rows, PointRows):
                    own = part / rows.root
                else:
                    own = rows.own_residual(self.unknowns.place(x))
                miss = miss_of(term, own)
            if pull is not None:
                away = x - pull.reference
                cost += float(away.dot(pull.weights * away))
            found.append(TermResult(term, miss, cost))
        return found
