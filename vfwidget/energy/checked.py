"""What users give to a solve, checked: locks, and the results of the methods of terms."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np

from ..arrays import Array, to_array
from ..errors import AxisError, SolveError
from ..font import Font
from ..solver.problem import Proximity, is_number
from ..text import Text
from ..text.place import AXES, Block, Unknowns
from .rows import PointRows, Rows, too_few_points
from .term import Term
from .word_terms import StayClose


def bound(term: Term, text: Text) -> Term:
    """The term, bound to a text.

    Raises
    ------
    SolveError
        It is no term, or ``bind`` returns none or finds the term not valid for this text.
    """
    if not isinstance(term, Term):
        raise SolveError(
            f"Each term must be a Term, such as vf.Target(handle, (x, y)); received {term!r:.80}."
        )
    found = term.bind(text)
    if not isinstance(found, Term):
        raise SolveError(
            f"bind() of {term.kind} must return a term, such as self; "
            f"received {type(found).__name__}."
        )
    return found


def locked_axes(font: Font, locks: Any) -> list[bool]:
    """Which axes of a font are locked.

    Raises
    ------
    AxisError
        ``locks`` are no tags of axes.
    """
    tags = [axis.tag for axis in font.axes]
    listed = isinstance(locks, Collection) and not isinstance(locks, str)
    try:
        locked = set(locks) if listed else {None}
    except TypeError:
        locked = {None}
    if not locked <= set(tags):
        raise AxisError(f"locks must be tags of axes ({', '.join(tags)}); received {locks!r}.")
    return [tag in locked for tag in tags]


def no_terms() -> SolveError:
    """The error for a solve without terms."""
    return SolveError("solve needs a list of terms, such as [vf.Target(handle, (x, y))].")


def blocks_of(term: Term, text: Text) -> Mapping[str, Block]:
    """The unknowns that a term adds.

    Raises
    ------
    SolveError
        ``blocks`` returns no mapping of names to blocks, or a block's numbers do not fit together.
    """
    blocks = term.blocks(text)
    if type(blocks) is not dict and not isinstance(blocks, Mapping):
        raise SolveError(
            f"blocks() of {term.kind} must return a mapping of names to blocks; "
            f"received {blocks!r:.80}."
        )
    for name, block in blocks.items():
        if not (isinstance(name, str) and isinstance(block, Block) and _is_sound(block)):
            raise SolveError(
                f"blocks() of {term.kind} must give each name a Block of finite float64 numbers, "
                f"with bounds around them of the same shape, and kinks of the shape (size, q); "
                f"received {name!r}: {block!r:.200}."
            )
    return blocks


def all_blocks(text: Text, terms: Sequence[Term]) -> tuple[dict[str, Block], list[str]]:
    """The blocks of the text and of its terms, and the names of the latter.

    Raises
    ------
    SolveError
        As :func:`blocks_of`; or two blocks have one name.
    """
    blocks, added = text.blocks, []
    for term in terms:
        for name, block in blocks_of(term, text).items():
            if name in blocks:
                raise SolveError(
                    f"Two terms bring unknowns called {name!r}; give one of them another name."
                )
            blocks[name] = block
            added.append(name)
    return blocks, added


def _is_sound(block: Block) -> bool:
    value, kinks = block.value, block.kinks
    sides = [side for side in (block.lower, block.upper) if side is not None]
    numbers = [value, *sides, *([] if kinks is None else [kinks])]
    if not all(isinstance(one, np.ndarray) and one.dtype == np.float64 for one in numbers):
        return False
    if any(side.shape != value.shape for side in sides) or not np.isfinite(value).all():
        return False
    if kinks is not None and (kinks.ndim != 2 or len(kinks) != value.size):
        return False
    below = block.lower is None or bool((block.lower <= value).all())
    return below and (block.upper is None or bool((value <= block.upper).all()))


def located(term: Term, text: Text) -> Rows | None:
    """The rows of a term at a text.

    Raises
    ------
    SolveError
        ``locate`` returns neither rows nor None, or reads a point that the term does not have.
    """
    try:
        rows = term.locate(text)
    except IndexError as error:
        raise too_few_points("locate", term, len(term.points(text).letter), error) from error
    if rows is None or isinstance(rows, PointRows):
        return rows
    if not all(callable(getattr(rows, name, None)) for name in _METHODS):
        raise SolveError(
            f"locate() of {term.kind} must return None or an object with the methods "
            f"{', '.join(_METHODS)}; received {rows!r:.80}."
        )
    return rows


_METHODS = ("residual", "own_residual", "jacobian")


def proximity_of(term: Term, text: Text, unknowns: Unknowns) -> Proximity | None:
    """A term's proximity over the free unknowns, or None if it has none.

    Raises
    ------
    SolveError
        ``proximity`` returns something else than pairs of arrays by block, their shapes differ
        from those of the blocks, a weight is negative, or a number is not finite.
    """
    own = term.proximity(text)
    if type(own) is dict and not own:
        return None
    try:
        weights = unknowns.flat({name: to_array(pair[0]) for name, pair in own.items()})
        reference = unknowns.flat({name: to_array(pair[1]) for name, pair in own.items()})
        # One number shows whether all are finite.
        sound = min(weights.tolist()) >= 0 and math.isfinite(weights.dot(reference))
    except (AttributeError, IndexError, KeyError, TypeError, ValueError):
        sound = False
    if not sound:
        raise SolveError(
            f"proximity() of {term.kind} must give blocks of this solve two arrays of the block's "
            f"shape, weights ≥ 0 and a reference, all of them finite; received {own!r:.200}."
        )
    return Proximity(weights, reference)


def fixed_cost(term: Term, pull: Proximity | None, text: Text, unknowns: Unknowns) -> float | None:
    """What squares of unknowns that are not free add to the cost; None if a term has none."""
    if pull is None:
        return None
    fixed = {n: pair for n, pair in term.proximity(text).items() if n not in unknowns.slices}
    place = unknowns.place(unknowns.start)
    away = [to_array(w) * (place[n] - to_array(r)) ** 2 for n, (w, r) in fixed.items()]
    return float(sum(part.sum() for part in away)) if away else None


def proximity_around(term: Term, pull: Proximity | None, unknowns: Unknowns) -> Proximity | None:
    """The proximity of a bound term whose form is that of another one, which has this proximity."""
    if pull is None or not isinstance(term, StayClose):
        return None
    return Proximity(pull.weights, unknowns.flat({AXES: to_array(term.theta)}))


def miss_of(term: Term, residual: Array) -> float | None:
    """By how much a term misses its goal.

    Raises
    ------
    SolveError
        ``miss`` returns neither None nor a number.
    """
    miss: Any = term.miss(residual)
    if miss is None:
        return None
    if not is_number(miss) or math.isnan(miss):
        raise SolveError(f"miss() of {term.kind} must return a number or None; received {miss!r}.")
    return float(miss)
