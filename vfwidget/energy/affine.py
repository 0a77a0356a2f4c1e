"""Rows of affine terms, compiled: a drag evaluates the same ones at every event."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..arrays import Array, padded_table
from ..text.points import AffineForm
from ..text.word import Word
from .rows import Derivative, PointRows, wrong_rows


class AffineTerm(NamedTuple):
    """A term whose residual is affine in the word's scalars, in Θ and in the letters' offsets.

    Attributes
    ----------
    rows : PointRows
    form : AffineForm
        Its points.
    by : Derivative
        Constant, and so evaluated once.
    constant : (r,) array
        The part of the residual that neither points nor Θ change, weighted.
    """

    rows: PointRows
    form: AffineForm
    by: Derivative
    constant: Array

    @staticmethod
    def of(rows: PointRows, theta: Array) -> AffineTerm | None:
        """The compiled form of a term, or None where it or its points are not affine.

        Raises
        ------
        SolveError
            The derivative does not have one row for each residual.
        """
        form = rows.points.rows
        if form is None or not rows.term.affine:
            return None
        nowhere, default = np.zeros((len(rows.points.letter), 2)), np.zeros(theta.shape)
        by, value = rows.derivative(nowhere, default), rows.value(nowhere, default)
        given = by.points if by.points is not None else by.theta
        size = 0 if given is None else len(given)
        if len(value) != size:
            raise wrong_rows(rows.term.kind, size, len(value))
        return AffineTerm(rows, form, by, rows.root * value)

    @property
    def key(self) -> tuple[int, float, bytes, bytes]:
        """Everything that the compiled rows depend on; the constant part is not in them."""
        return id(self.form), self.rows.root, _bytes(self.by.points), _bytes(self.by.theta)


def _bytes(array: Array | None) -> bytes:
    return b"" if array is None else array.tobytes()


def compiled(word: Word, terms: Sequence[AffineTerm]) -> AffineRows:
    """The rows of affine terms, compiled at the first call for the same derivatives."""
    key = tuple(term.key for term in terms)
    made: AffineRows = word.compiled_rows.get(key, lambda: AffineRows(word, terms))
    return made


class AffineRows:
    """Rows ``base + Σ gain · γ(θ_letter) + T Θ + U b``, without the terms' constants.

    Only the pairs of letter and region that move a row are evaluated.

    Attributes
    ----------
    kinks : (parameters · n, q) array
        Where the rows have kinks, padded with infinity.
    by_block : dict of (r, size) arrays
        U: the derivative by the offsets and by the tracking, b.
    """

    def __init__(self, word: Word, terms: Sequence[AffineTerm]) -> None:
        # The key of the cache names the forms by their id, so they have to stay alive.
        self._word, self._forms = word, [term.form for term in terms]
        size = word.parameters * len(word.font.axes)
        count = word.parameters * len(word.regions.support)
        base, gain, pushed, straight = [], [], [], []
        linear: dict[str, list[Array]] = {}
        for term in terms:
            r, root = len(term.constant), term.rows.root
            by_theta = np.zeros((r, size)) if term.by.theta is None else term.by.theta
            straight.append(root * by_theta.reshape(r, size))
            by_points = np.zeros((r, len(term.form.base)))
            if term.by.points is not None:
                by_points = root * term.by.points.reshape(r, len(term.form.base))
            base.append(by_points @ term.form.base)
            gain.append(by_points @ term.form.gain)
            pushed.append(by_points @ term.form.pushed)
            for name, block in term.rows.points.by_block.items():
                linear.setdefault(name, []).append(
                    by_points @ block.reshape(2 * len(block), block.shape[-1])
                )
        self._base = np.concatenate([np.zeros(0), *base])
        self._straight = np.concatenate([np.zeros((0, size)), *straight])
        self._is_straight = bool(self._straight.any())
        self.by_block = {name: np.concatenate(parts) for name, parts in linear.items()}
        all_gain = np.concatenate([np.zeros((0, count)), *gain])
        self._pushed = np.concatenate([np.zeros((0, len(word.glyphs))), *pushed])
        self._choose_pairs(all_gain, size)
        self._latest: tuple[bytes, tuple[Array, Array]] | None = None

    def _choose_pairs(self, gain: Array, size: int) -> None:
        """Keep the columns of the gain that are not zero, and where their slots read Θ."""
        word = self._word
        vanishing = self._pushed * word.can_vanish
        self._may_vanish = bool(vanishing.any())
        kept = (gain != 0).any(0) | (word.advance_rows(vanishing) != 0).any(0)
        self._pairs = np.flatnonzero(kept)
        self._gain = gain[:, self._pairs]
        letters, regions = np.divmod(self._pairs, len(word.regions.support) or 1)
        self._slots = slots = word.regions.of_letters(letters, regions)
        self.kinks = padded_table(slots.kinks(size))
        if not len(self._pairs):
            return
        # The entries of the slopes (pair, slot), sorted by the coordinate that they read. A
        # coordinate that no slot reads gets an entry that counts 0 times.
        entries = np.flatnonzero(slots.used.ravel())
        columns = slots.axis.ravel()[entries]
        unread = np.setdiff1d(np.arange(size), columns)
        counts = np.concatenate([np.ones(len(entries)), np.zeros(len(unread))])
        entries = np.concatenate([entries, np.zeros_like(unread)])
        columns = np.concatenate([columns, unread])
        order = np.argsort(columns, kind="stable")
        self._entries, self._counts = entries[order], counts[order]
        self._runs = np.searchsorted(columns[order], np.arange(size))
        self._entry_pair = self._entries // slots.axis.shape[1]
        self._entry_gain = self._by_entry(self._gain)

    def _by_entry(self, gain: Array) -> Array:
        """The gain (r, pairs) of each entry of the slopes."""
        return gain[:, self._entry_pair] * self._counts

    def evaluate(self, theta: Array) -> tuple[Array, Array]:
        """The rows at flat Θ, (r,), and their derivative by it, (r, parameters · n).

        The derivative costs little more than the rows and is evaluated next, and a drag goes on
        from where its last solve ended: the latest place is kept.
        """
        place, latest = theta.tobytes(), self._latest
        if latest is None or latest[0] != place:
            self._latest = latest = place, self._evaluate(theta)
        return latest[1]

    def _evaluate(self, theta: Array) -> tuple[Array, Array]:
        if not len(self._pairs):
            return self._base + self._straight.dot(theta), self._straight
        gamma, slopes = self._slots.along(theta)
        rows, gain, by_entry = self._base, self._gain, self._entry_gain
        if self._may_vanish:
            rows, gain = self._hold_advances(theta)
            by_entry = self._by_entry(gain)
        rows = rows + gain.dot(gamma)
        by_entry = by_entry * slopes.ravel().take(self._entries)
        jacobian = np.add.reduceat(by_entry, self._runs, axis=1)
        if self._is_straight:
            rows += self._straight.dot(theta)
            jacobian += self._straight
        return rows, jacobian

    def _hold_advances(self, theta: Array) -> tuple[Array, Array]:
        """Base and gain without the part of those advances that add up to less than zero."""
        word = self._word
        gamma = word.regions.scalars(theta.reshape(word.parameters, -1))
        negative = word.unclipped_advances(gamma) < 0
        if not negative.any():
            return self._base, self._gain
        pushed = self._pushed * negative
        held = word.advance_rows(pushed)[:, self._pairs]
        return self._base - pushed @ word.advance_base, self._gain - held
