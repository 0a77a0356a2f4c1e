"""Rows of affine terms, compiled: a drag evaluates the same ones at every event."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..arrays import Array, IntArray, padded_table
from ..text.points import AffinePoints
from ..text.word import Word
from .rows import Derivative, PointRows, wrong_rows


class AffineTerm(NamedTuple):
    """A term whose residual is affine in the word's scalars, in Θ and in the letters' offsets.

    Attributes
    ----------
    points : AffinePoints
    root : float
        The square root of the term's weight.
    by : Derivative
        Constant, and so evaluated once.
    size : int
        The number of residuals.
    origin : tuple of arrays
        Positions and Θ that are zero, where the residual is what they do not change.
    """

    points: AffinePoints
    root: float
    by: Derivative
    size: int
    origin: tuple[Array, Array]

    @staticmethod
    def of(rows: PointRows, theta: Array) -> AffineTerm | None:
        """The compiled form of a term, or None where it or its points are not affine."""
        points = rows.points
        if not isinstance(points, AffinePoints) or not rows.term.affine:
            return None
        origin = np.zeros(points.base.shape), np.zeros(theta.shape)
        # A term may write to its arguments.
        by = rows.derivative(*(part.copy() for part in origin))
        given = by.points if by.points is not None else by.theta
        return AffineTerm(points, rows.root, by, 0 if given is None else len(given), origin)

    @property
    def key(self) -> tuple[int, float, bytes, bytes]:
        """Everything that the compiled rows depend on."""
        return id(self.points), self.root, _bytes(self.by.points), _bytes(self.by.theta)

    def constant(self, rows: PointRows) -> Array:
        """The part of the residual (r,) that neither points nor Θ change, weighted.

        Raises
        ------
        SolveError
            The derivative does not have one row for each residual.
        """
        value = rows.value(*(part.copy() for part in self.origin))
        if len(value) != self.size:
            raise wrong_rows(rows.term.kind, self.size, len(value))
        return self.root * value


def _bytes(array: Array | None) -> bytes:
    return b"" if array is None else array.tobytes()


def compiled(word: Word, terms: Sequence[AffineTerm]) -> AffineRows:
    """The rows of affine terms, compiled at the first call for the same derivatives."""
    key = tuple(term.key for term in terms)
    made: AffineRows = word.compiled_rows.get(key, lambda: AffineRows(word, terms))
    return made


class AffineRows:
    """Rows ``base + Σ gain · γ(θ_letter) + T Θ + U b``, without the terms' constants.

    Only the pairs of axis vector and region that move a row are evaluated. Many rows depend on an
    axis vector in the same way: a letter pushes all letters after it equally far. The distinct
    parts that belong to one axis vector are a product of matrices: its gain (s, P), where P is the
    most regions that any has, and its scalars with their derivatives, (P, n + 1).

    Attributes
    ----------
    kinks : (parameters · n, q) array
        Where the rows have kinks, padded with infinity. The ends of an axis are none: there the
        derivative is that into its range.
    moved_by : (parameters · n,) bool array
        Which axes move a row.
    """

    def __init__(self, word: Word, terms: Sequence[AffineTerm]) -> None:
        # The key of the cache names the points by their id, so they have to stay alive.
        self._word, self._kept = word, [term.points for term in terms]
        self._ends = [np.tile(ends, word.parameters) for ends in word.font.bounds]
        self._sums = _Sums(terms)
        self._straight = _straight(terms, word.parameters * len(word.font.axes))
        self._points = points = _joined(self._kept)
        origins = word.origins
        starts = origins.base.copy()
        starts[:, 0] += origins.pushed @ word.advance_base
        self._base = self._sums.of(points.base + starts[points.origin])
        pushed = origins.pushed[points.origin] * word.can_vanish
        self._pushed: Array | None = None
        if pushed.any():
            self._pushed = self._sums.of(np.stack([pushed, np.zeros_like(pushed)], 1))
            varied = np.where(word.can_vanish[:, None], word.advance_deltas, 0.0)
            self._varied, regions = np.nonzero(varied)
            self._advance_deltas = varied[self._varied, regions]
            vectors = np.zeros_like(self._varied) if word.shared else self._varied
            self._advance_slots = word.regions.of_letters(vectors, regions, self._ends[1])
        self._arrange([self._gain_by(k) for k in range(word.parameters)])
        self._latest: tuple[bytes, tuple[Array, Array]] | None = None

    def by_block(self, name: str) -> Array:
        """U: the derivative by the offsets or by the tracking, (r, size)."""
        return self._sums.of(self._points.by_block[name])

    def _letters(self, k: int) -> slice:
        """The letters that have an axis vector."""
        return slice(None) if self._word.shared else slice(k, k + 1)

    def _gain_by(self, k: int) -> tuple[IntArray, Array, IntArray]:
        """The regions of one axis vector that move a row, (p,), their gain, and whose it is.

        Only distinct rows of the gain are kept, (s, p); each row has one of them, (r,).
        """
        word, points = self._word, self._points
        letters = self._letters(k)
        gain = word.origins.gain(k)
        gain[:, 0] += word.origins.pushed[:, letters] @ word.advance_deltas[letters]
        by_points = gain[points.origin]
        mine = points.vector == k
        by_points[mine] += points.deltas[mine]
        found = self._sums.of(by_points)
        kept = (found != 0).any(0)
        if self._pushed is not None:
            kept |= (self._pushed[:, letters] @ word.advance_deltas[letters] != 0).any(0)
        regions = np.flatnonzero(kept)
        gain, which = found[:, regions], np.arange(len(found))
        if word.parameters > 1:
            gain, which = _distinct(gain)
        return regions, gain, which

    def _arrange(self, parts: Sequence[tuple[IntArray, Array, IntArray]]) -> None:
        """Lay out the gain by axis vector, and say where its factors are found."""
        word, n = self._word, len(self._word.font.axes)
        # A column of zeros belongs to the region M, which does not exist.
        none = len(word.regions.support)
        self._vectors = np.flatnonzero([len(regions) for regions, _, _ in parts])
        parts = [part for part in parts if len(part[0])]
        width = max((len(regions) for regions, _, _ in parts), default=0)
        height = max((len(gain) for _, gain, _ in parts), default=0)
        self._regions = np.full((len(parts), width), none)
        self._gain = np.zeros((len(parts), height, width))
        self._at = np.zeros((len(self._base), len(parts)), dtype=np.intp)
        for i, (regions, gain, which) in enumerate(parts):
            self._regions[i, : len(regions)] = regions
            self._gain[i, : len(gain), : len(regions)] = gain
            self._at[:, i] = i * height + which
        place, within = np.nonzero(self._regions < none)
        letters, regions = self._vectors[place], self._regions[place, within]
        self._slots = slots = word.regions.of_letters(letters, regions, self._ends[1])
        kinks = slots.kinks(word.parameters * n)
        self.moved_by = np.array([len(values) > 0 for values in kinks])
        inner = [k[(low < k) & (k < high)] for k, low, high in zip(kinks, *self._ends, strict=True)]
        self.kinks = padded_table(inner)
        self._used = np.flatnonzero(slots.used)
        self._scalars_at = (place * width + within) * (n + 1) + n
        self._slopes_at = (self._scalars_at[:, None] - n + slots.axis % n).ravel()[self._used]

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
        rows, gain, parameters = self._base, self._gain, self._word.parameters
        n = len(theta) // parameters
        gamma, slopes = self._slots.along(theta)
        factors = np.zeros((len(gain), gain.shape[2], n + 1))
        factors.put(self._scalars_at, gamma)
        factors.put(self._slopes_at, slopes.take(self._used))
        if len(gain) == parameters == 1:
            # A shared word has one product. As a stack of one matrix it would take longer.
            product = gain[0].dot(factors[0])
            rows, jacobian = rows + product[:, n], product[:, :n]
        else:
            products = (gain @ factors).reshape(-1, n + 1)
            rows = rows + np.add.reduce(products[:, n].take(self._at), 1)
            jacobian = moved = products[:, :n].take(self._at, 0)
            if len(gain) < parameters:
                jacobian = np.zeros((len(rows), parameters, n))
                jacobian[:, self._vectors] = moved
            jacobian = jacobian.reshape(len(rows), len(theta))
        if self._pushed is not None:
            rows, jacobian = self._hold_advances(theta, rows, jacobian)
        if self._straight is not None:
            rows = rows + self._straight.dot(theta)
            jacobian += self._straight
        return rows, jacobian

    def _hold_advances(self, theta: Array, rows: Array, jacobian: Array) -> tuple[Array, Array]:
        """Rows and derivative without those advances that add up to less than zero."""
        base, deltas, letters = self._word.advance_base, self._advance_deltas, self._varied
        assert self._pushed is not None
        gamma, slopes = self._advance_slots.along(theta)
        advances = base + np.bincount(letters, deltas * gamma, len(base))
        negative = np.flatnonzero(advances < 0)
        if not len(negative):
            return rows, jacobian
        by_axes = np.zeros((len(advances), len(theta)))
        np.add.at(by_axes, (letters[:, None], self._advance_slots.axis), deltas[:, None] * slopes)
        pushed = self._pushed[:, negative]
        return rows - pushed @ advances[negative], jacobian - pushed @ by_axes[negative]


def _distinct(rows: Array) -> tuple[Array, IntArray]:
    """Zeros and the other distinct rows among rows (r, p); and which of them each row is, (r,)."""
    seen: dict[bytes, int] = {}
    which = np.zeros(len(rows), dtype=np.intp)
    # Most rows are zero, those of the letters before this one.
    moved = rows.any(1).nonzero()[0]
    which[moved] = [seen.setdefault(row.tobytes(), len(seen) + 1) for row in rows[moved]]
    first = np.unique(which[moved], return_index=True)[1]
    return np.concatenate([np.zeros((1, rows.shape[1])), rows[moved[first]]]), which


class _Sums:
    """Rows of several terms as weighted sums over the points of all of them."""

    def __init__(self, terms: Sequence[AffineTerm]) -> None:
        rows, points, weights = [], [], []
        first = self._count = 0
        for term in terms:
            if term.by.points is not None:
                row, point = np.nonzero(term.by.points.any(-1))
                rows.append(row + self._count)
                points.append(point + first)
                weights.append(term.root * term.by.points[row, point])
            self._count += term.size
            first += len(term.points.letter)
        self._point = np.concatenate([np.zeros(0, int), *points])
        self._weights = np.concatenate([np.zeros((0, 2)), *weights])
        self._rows, self._starts = np.unique(
            np.concatenate([np.zeros(0, int), *rows]), return_index=True
        )

    def of(self, values: Array) -> Array:
        """The rows (r, ...) from a value for each coordinate of the points, (p, 2, ...)."""
        by_entry = np.einsum("ec,ec...->e...", self._weights, values[self._point])
        found = np.zeros((self._count, *values.shape[2:]))
        if len(self._rows):
            found[self._rows] = np.add.reduceat(by_entry, self._starts, axis=0)
        return found


def _joined(points: Sequence[AffinePoints]) -> AffinePoints:
    """Points of several sets as one."""
    return AffinePoints(
        np.concatenate([one.letter for one in points]),
        np.concatenate([one.origin for one in points]),
        np.concatenate([one.base for one in points]),
        np.concatenate([one.deltas for one in points]),
        points[0].word,
    )


def _straight(terms: Sequence[AffineTerm], size: int) -> Array | None:
    """T of all rows, (r, size), or None where it is zero."""
    if all(term.by.theta is None for term in terms):
        return None
    parts = [
        np.zeros((term.size, size))
        if term.by.theta is None
        else term.root * term.by.theta.reshape(-1, size)
        for term in terms
    ]
    return np.concatenate(parts)
