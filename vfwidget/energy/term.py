r"""The terms of an energy over points of a text: :math:`E(\Theta) = \sum \|F_i\|^2` (Eq. 4).

A term names the handles it touches, its residual as a function of their positions (and of Θ),
and that residual's derivative. The chain rule through the text (Eq. 3) is the solver's, so a
term costs what its few handles cost, not what the outline does.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..arrays import Array
from ..errors import SolveError
from ..text import Text
from ..text.word import Handle, PointSet


@dataclass(frozen=True)
class Derivative:
    """What a term's residual (r,) depends on.

    Attributes
    ----------
    points : (r, p, 2) array, optional
        By the positions of the term's points.
    theta : (r, parameters, n) array, optional
        By Θ directly.
    """

    points: Array | None = None
    theta: Array | None = None

    @property
    def size(self) -> int:
        """How many residuals, r."""
        by = self.points if self.points is not None else self.theta
        return 0 if by is None else len(by)


class Term:
    """One sum of squares in the energy; subclass it for new ones.

    Attributes
    ----------
    weight : float
        Multiplies the term's squares.
    handles : tuple of Handle
    affine : bool
        Whether the residual is affine in the points and in Θ, and so its derivative constant.
    """

    weight: float
    affine: ClassVar[bool] = False
    handles: tuple[Handle, ...] = ()

    def bind(self, text: Text) -> Term:
        """The term with whatever it takes from the text a solve starts from.

        Raises
        ------
        SolveError
            A handle of another text, or numbers that are not finite.
        """
        if not (math.isfinite(self.weight) and self.weight > 0):
            raise SolveError(f"A weight is a finite number > 0, not {self.weight!r}.")
        for handle in self.handles:
            if not isinstance(handle, Handle) or not text.owns(handle):
                raise SolveError(f"{handle!r} is not a handle of the text {text.string!r}.")
        return self

    def key(self) -> Hashable:
        """What an affine term's derivative depends on, its kind included."""
        return type(self), self.weight, self.handles

    def label(self) -> str:
        """Its kind, and the letters it touches, for a report."""
        letters = [handle.word.glyphs[handle.glyph].name for handle in self.handles]
        return " ".join([type(self).__name__, *letters])

    def points(self, text: Text) -> PointSet:
        """The points of the text that :meth:`residual` is given."""
        return text.point_set(self.handles)

    def residual(self, points: Array, theta: Array) -> Array:
        """Residual (r,) at positions (p, 2) and Θ (parameters, n)."""
        raise NotImplementedError

    def derivative(self, points: Array, theta: Array) -> Derivative:
        """Derivative of :meth:`residual`."""
        raise NotImplementedError

    def miss(self, residual: Array) -> float | None:
        """How far, in font units, the term is from being met; None where it has no such goal.

        Parameters
        ----------
        residual : (r,) array
            Its own, weight included.
        """
        return None


@dataclass(frozen=True)
class Account:
    """What a term comes to at some place.

    Attributes
    ----------
    term : Term
    miss : float or None
        How far its goal is missed, in font units; None for a term that only leans one way.
    cost : float
        Its share of E, in squared font units.
    """

    term: Term
    miss: float | None
    cost: float


class Energy:
    """Terms bound to a text: stacked residuals and their Jacobian, as functions of flat Θ.

    The residuals of affine terms are affine in the scaling factors and in Θ, once for all
    (:class:`AffineRows`); the other terms are evaluated from their points.
    """

    def __init__(self, text: Text, terms: Sequence[Term]) -> None:
        if not terms or not all(isinstance(term, Term) for term in terms):
            raise SolveError("solve needs a list of terms, such as [vf.Target(handle, (x, y))].")
        self._text = text
        self._shape = text.coordinates.shape
        bound = [term.bind(text) for term in terms]
        pairs = [(term, term.points(text)) for term in bound]
        affine = [pair for pair in pairs if pair[0].affine]
        # A drag brings the same terms at every event; only what they ask for changes.
        key = tuple(term.key() for term, _ in affine)
        self._rows = text.word.remember(key, lambda: AffineRows(text, affine))
        self._constant = self._rows.constant(affine)
        self._curved = [pair for pair in pairs if not pair[0].affine]
        self._terms = bound

    @property
    def kinks(self) -> Array:
        """Where each coordinate of flat Θ has a kink that some term feels, (parameters · n, q)."""
        felt = np.ones_like(self._rows.felt) if self._curved else self._rows.felt
        return self._text.word.kinks(felt)

    def residual(self, x: Array) -> Array:
        """All residuals (r,) at flat Θ: those of affine terms, then those of the others."""
        theta = x.reshape(self._shape)
        residual = self._constant + self._rows.evaluate(theta)[0]
        if not self._curved:
            return residual
        return np.concatenate([residual, *self._curved_residuals(theta)])

    def _curved_residuals(self, theta: Array) -> list[Array]:
        return [t.residual(self._text.positions(p, theta), theta) for t, p in self._curved]

    def jacobian(self, x: Array) -> Array:
        """Derivative of the residuals by flat Θ, (r, parameters · n)."""
        theta = x.reshape(self._shape)
        jacobian = self._rows.evaluate(theta)[1]
        if not self._curved:
            return jacobian
        return np.concatenate([jacobian, *(self._chain(t, p, theta) for t, p in self._curved)])

    def _chain(self, term: Term, points: PointSet, theta: Array) -> Array:
        """The chain rule: what its points do to a term, times what Θ does to them."""
        places, moves = self._text.positions_and_jacobian(points, theta)
        by = term.derivative(places, theta)
        block = np.zeros(())
        if by.points is not None:
            flat = moves.reshape(places.size, theta.size)
            block = by.points.reshape(len(by.points), places.size) @ flat
        if by.theta is not None:
            block = block + by.theta.reshape(len(by.theta), theta.size)
        return block

    def accounts(self, x: Array, residual: Array) -> list[Account]:
        """What each term comes to at flat Θ, in the order the terms were given."""
        theta = x.reshape(self._shape)
        own = self._rows.split(residual)
        curved = self._curved_residuals(theta)
        accounts = []
        for term in self._terms:
            part = (own if term.affine else curved).pop(0)
            accounts.append(Account(term, term.miss(part), float(part @ part)))
        return accounts


class AffineRows:
    """What affine terms keep while their goals change: ``Σ_letters G γ(θ_letter) + T Θ``.

    Rows that no point moves come last, and are left out of G.

    Attributes
    ----------
    felt : (M,) bool array
        Which of the word's regions any of the terms depends on.
    """

    def __init__(self, text: Text, terms: Sequence[tuple[Term, PointSet]]) -> None:
        self._word = word = text.word
        zero = np.zeros_like(text.coordinates)
        # Being constant, their derivatives are asked for once, at nowhere.
        parts = [term.derivative(np.zeros((len(p.letter), 2)), zero) for term, p in terms]
        offset, straight = [np.zeros(0)], [np.zeros((0, zero.size))]
        gain = [np.zeros((0, len(zero) * len(word.regions.support)))]
        pushed = [np.zeros((0, len(word.glyphs)))]
        self._slices = [slice(0)] * len(parts)
        end = 0
        for index in sorted(range(len(parts)), key=lambda i: parts[i].points is None):
            by, size = parts[index], parts[index].size
            self._slices[index] = slice(end, end + size)
            end += size
            own = np.zeros((size, zero.size)) if by.theta is None else by.theta
            straight.append(own.reshape(size, zero.size))
            if by.points is None:
                offset.append(np.zeros(size))
                continue
            rows = terms[index][1].rows
            flat = by.points.reshape(size, len(rows.base))
            offset.append(flat @ rows.base)
            gain.append(flat @ rows.gain)
            pushed.append(flat @ rows.pushed)
        self._offset, self._straight = np.concatenate(offset), np.concatenate(straight)
        self._gain, self._pushed = np.concatenate(gain), np.concatenate(pushed)
        felt = (self._gain != 0).any(0).reshape(len(zero), len(word.regions.support))
        self.felt = felt.any(0)
        self._may_vanish = bool((self._pushed != 0)[:, word.can_vanish].any())
        self._latest: tuple[bytes, tuple[Array, Array]] | None = None

    def constant(self, terms: Sequence[tuple[Term, PointSet]]) -> Array:
        """What their present goals add to the rows, (r,)."""
        zero = np.zeros((self._word.parameters, len(self._word.font.axes)))
        constant = self._offset.copy()
        for (term, points), part in zip(terms, self._slices, strict=True):
            constant[part] += term.residual(np.zeros((len(points.letter), 2)), zero)
        return constant

    def split(self, residual: Array) -> list[Array]:
        """Each term's part of the residual, in the order the terms were given."""
        return [residual[part] for part in self._slices]

    def evaluate(self, theta: Array) -> tuple[Array, Array]:
        """The rows at Θ, (r,), and their derivative by flat Θ, (r, parameters · n).

        The derivative comes almost free with the rows and is asked for next, and a drag goes on
        from where its last solve ended: the latest place is kept.
        """
        place, latest = theta.tobytes(), self._latest
        if latest is None or latest[0] != place:
            self._latest = latest = place, self._evaluate(theta)
        return latest[1]

    def _evaluate(self, theta: Array) -> tuple[Array, Array]:
        regions, gain = self._word.regions, self._gain
        gamma, slopes = regions.scalars_and_slopes(theta)
        moving = slice(len(gain))
        rows = self._straight.dot(theta.ravel())
        if self._may_vanish:
            rows[moving], gain = self._hold_advances(rows[moving], gamma)
        rows[moving] += gain.dot(gamma.ravel())
        # (row, letter, region · slot) times the one-hot matrix of the slots' axes.
        q = slopes.shape[-1]
        weighted = gain[..., None] * slopes.reshape(-1, q)
        one_hot = regions.one_hot.reshape(-1, theta.shape[-1])
        by_axis = weighted.reshape(len(gain), len(theta), len(one_hot)) @ one_hot
        jacobian = self._straight.copy()
        jacobian[moving] += by_axis.reshape(len(gain), theta.size)
        return rows, jacobian

    def _hold_advances(self, rows: Array, gamma: Array) -> tuple[Array, Array]:
        """Take out again what advances below zero would push: they are held at zero."""
        word = self._word
        negative = word.unclipped_advances(gamma) < 0
        if not negative.any():
            return rows, self._gain
        pushed = self._pushed * negative
        return rows - pushed @ word.advance_base, self._gain - word.advance_rows(pushed)
