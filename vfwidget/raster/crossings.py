r"""Where contours cross or touch, and pieces cut there.

A contour can only be crossed in a pixel that both pass through. There the chords of the pieces
cross as often, modulo two, as the arcs do, for both end on the pixel's border; so the chords
decide what crosses what, and the arcs where exactly. Bent arcs may cross twice where their chords
do not, and arcs may cross in other pieces than their chords do, in loops or gaps smaller than a
pixel: such pieces are halved until their chords are close to them. What then may be overlooked
is a lens as thin as :data:`BENT`; and after a few times the chords' crossing stands in.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from ..arrays import (
    between,
    count_up,
    integers,
    namespace,
    repeat,
    stacked,
    sum_at,
    take,
    where_true,
)
from .cuts import BEFORE_NEXT, Pieces, evaluate, evaluate_slope

TOUCH = 1e-9
"""In pixels, how near counts as touching."""
ROUNDS = 6
"""Of Newton's method, from where chords cross to where arcs do."""
CROSSED = 1e-10
"""In pixels, how near to each other arcs that cross have come then."""
BENT = 0.02
"""In pixels, how far from its chord an arc may be in the middle when it meets others."""
HALVINGS = 6
"""How often pieces are halved that are bent, or whose chords cross but whose arcs do not."""
TRIES = 4
"""How often crossings that come in a wrong order are taken back."""


class Split(NamedTuple):
    """Pieces cut in two, or more, where others cross or touch them.

    Attributes
    ----------
    pieces : Pieces
    whole : (N,) int array
        Which of the uncut pieces each was, or was a part of.
    middle : (N,) array
        How far along that one's chord its own middle is.
    breaks : (N,) bool array
        Whether a run begins with it.
    """

    pieces: Pieces
    whole: Any
    middle: Any
    breaks: Any


def split(curves: Any, pieces: Pieces, width: int) -> tuple[Pieces, Split]:
    """Cut pieces where others cross or touch them.

    Parameters
    ----------
    curves : (4, 2, C) array
    pieces : Pieces
    width : int
        Columns of an image.

    Returns
    -------
    pieces : Pieces
        The pieces that were cut, some of them halved beforehand.
    split : Split
    """
    for rounds in range(HALVINGS + 1):
        pairs = _pairs(pieces, width)
        halved = _bent(curves, pieces, *pairs)
        if rounds == HALVINGS or not len(halved):
            meetings = _meetings(pieces, *pairs)
            if not len(meetings.cut):
                break
            t, place, halved = _refine(curves, pieces, meetings)
            if rounds == HALVINGS or not len(halved):
                return pieces, _split(pieces, meetings, t, place)
        # Shorter chords are nearer to their arcs.
        pieces, _, _ = _cut_at(pieces, halved, *_halfway(curves, pieces, halved))
    middle = namespace(curves).zeros_like(pieces.start) + 0.5
    whole = count_up(len(pieces.row), pieces.row)
    return pieces, Split(pieces, whole, middle, meetings.breaks[:-1])


def _bent(curves: Any, pieces: Pieces, a: Any, b: Any) -> Any:
    """Which pieces of these pairs are so bent that they may cross where their chords do not."""
    xp = namespace(curves)
    paired = xp.concatenate([a, b])
    chord = (take(pieces.first, paired) + take(pieces.last, paired)) / 2
    away = _halfway(curves, pieces, paired)[1] - chord
    bent = xp.zeros_like(pieces.fresh)
    bent[take(paired, where_true(_dot(away, away) > BENT**2))] = True
    return where_true(bent)


def _halfway(curves: Any, pieces: Pieces, which: Any) -> tuple[Any, Any]:
    """T (P,) in the middle of some pieces, and the places (2, P) on their arcs."""
    t = (take(pieces.start, which) + take(pieces.end, which)) / 2
    return t, evaluate(take(curves, take(pieces.cubic, which)), t)


def _pairs(pieces: Pieces, width: int) -> tuple[Any, Any]:
    """Pairs of pieces that share a cell; one that lies on a border belongs to both its sides.

    Not those of which one goes on from the other, unless straight back: they meet only there.
    """
    xp = namespace(pieces.row)
    # With a row more above, and columns at the sides, for what lies on a border.
    piece = count_up(len(pieces.row), pieces.row)
    cell = (pieces.row + 1) * (width + 2) + pieces.column + 1
    middle = (pieces.first + pieces.last) / 2
    border = xp.round(middle)
    along = (abs(pieces.first - border) < TOUCH) & (abs(pieces.last - border) < TOUCH)
    if along.any():
        for axis, step in enumerate((1, width + 2)):
            on = where_true(along[axis])
            side = take(middle[axis] >= border[axis], on)
            piece = xp.concatenate([piece, on])
            cell = xp.concatenate([cell, take(cell, on) + xp.where(side, -step, step)])
    shared = where_true(take(xp.bincount(cell), cell) > 1)
    piece, cell = take(piece, shared), take(cell, shared)
    order = cell.argsort()
    piece, cell = take(piece, order), take(cell, order)
    # Those next to each other in this order, then those next but one, and so on.
    here, apart = where_true(cell[1:] == cell[:-1]), 1
    nearer, farther = [here], [here + 1]
    while len(here):
        apart += 1
        here = take(here, where_true(here + apart < len(cell)))
        here = take(here, where_true(take(cell, here) == take(cell, here + apart)))
        nearer.append(here)
        farther.append(here + apart)
    one, other = take(piece, xp.concatenate(nearer)), take(piece, xp.concatenate(farther))
    a, b = xp.minimum(one, other), xp.maximum(one, other)

    begin, finish = take(pieces.first, a), take(pieces.last, b)
    r, s = take(pieces.last, a) - begin, finish - take(pieces.first, b)
    follows = (b == a + 1) & ~take(pieces.fresh, b)
    # As does a contour's first piece from its last.
    ended = xp.concatenate([pieces.fresh[1:], pieces.fresh[:1]])
    closes = (begin == finish).all(0) & take(pieces.fresh, a) & take(ended, b)
    aligned = _cross(r, s) ** 2 <= TOUCH**2 * _dot(r, r) * _dot(s, s)
    told = where_true(~(follows | closes) | (aligned & (_dot(r, s) <= 0)))
    return take(a, told), take(b, told)


class Meetings(NamedTuple):
    """Where chords meet, as seen from each.

    Attributes
    ----------
    breaks : (N + 1,) bool array
        Before which pieces runs have to begin, for they meet others there.
    cut : (M,) int array
        A piece to be cut.
    where : (M,) array
        How far along its chord, 0 … 1.
    place : (2, M) array
    other : (M,) int array
        Which other entry is of the same crossing, or the entry's own number.
    """

    breaks: Any
    cut: Any
    where: Any
    place: Any
    other: Any


def _meetings(pieces: Pieces, a: Any, b: Any) -> Meetings:
    """Where these pairs meet."""
    xp = namespace(pieces.first)
    # One more than there are pieces, for what ends with the last.
    breaks = xp.concatenate([pieces.fresh, pieces.fresh[:1]])
    # At a pixel's corner pieces may cross that share no cell.
    corner = abs(pieces.first - xp.round(pieces.first)) < TOUCH
    breaks[:-1] |= corner[0] & corner[1]
    if not len(a):
        return Meetings(breaks, a, pieces.start[:0], pieces.first[:, :0], a)

    p, q = take(pieces.first, a), take(pieces.first, b)
    r, s = take(pieces.last, a) - p, take(pieces.last, b) - q
    lengths = xp.sqrt(stacked([_dot(r, r), _dot(s, s)]))
    across, beside = _cross(r, s), _cross(q - p, r)
    parallel = abs(across) <= TOUCH * lengths[0] * lengths[1]
    where = stacked([_cross(q - p, s), beside]) / xp.where(parallel, 1.0, across)
    slack = TOUCH / xp.clip(lengths, TOUCH, None)
    crosses = where_true(((where >= -slack) & (where <= 1 + slack)).all(0) & ~parallel)
    pair = stacked([take(a, crosses), take(b, crosses)])
    where, near = take(where, crosses), take(slack, crosses)
    place = take(p, crosses) + where[0] * take(r, crosses)
    at_first, at_last = where <= near, where >= 1 - near
    breaks[pair[at_first]] = True
    breaks[pair[at_last] + 1] = True
    through = ~(at_first | at_last)
    number = xp.where(through, through.reshape(-1).cumsum(0).reshape(through.shape) - 1, -1)
    partner = stacked([number[1], number[0]])
    partner = xp.where(partner < 0, number, partner)
    places = xp.stack([place, place], 1)[:, through]
    cuts = [(pair[through], where[through], places, partner[through])]

    # Pieces that coincide are cut at each other's ends.
    along = parallel & (abs(beside) <= TOUCH * xp.clip(lengths[0], TOUCH, None))
    along = where_true(along & (lengths > TOUCH).all(0))
    if not len(along):
        return Meetings(breaks, *cuts[0])
    count = len(cuts[0][0])
    ends = [take(v, along) for v in (p, p + r, q, q + s)]
    for own, base, chord, points in ((a, p, r, ends[2:]), (b, q, s, ends[:2])):
        own, base, chord = take(own, along), take(base, along), take(chord, along)
        breaks[own], breaks[own + 1] = True, True
        square = _dot(chord, chord)
        edge = TOUCH / xp.sqrt(square)
        for point in points:
            part = _dot(point - base, chord) / square
            inner = where_true((part > edge) & (part < 1 - edge))
            numbers = count_up(len(inner), inner) + count
            count += len(inner)
            cuts.append((take(own, inner), take(part, inner), take(point, inner), numbers))
    return Meetings(breaks, *(xp.concatenate(parts, -1) for parts in zip(*cuts, strict=True)))


def _cross(a: Any, b: Any) -> Any:
    return a[0] * b[1] - a[1] * b[0]


def _dot(a: Any, b: Any) -> Any:
    return a[0] * b[0] + a[1] * b[1]


def _split(pieces: Pieces, meetings: Meetings, t: Any, place: Any) -> Split:
    order = (meetings.cut + BEFORE_NEXT * meetings.where).argsort()
    where = take(meetings.where, order)
    cut, t, place = (take(values, order) for values in (meetings.cut, t, place))
    parts, whole, here = _cut_at(pieces, cut, t, place)
    zero = namespace(t).zeros_like(pieces.start)
    begin, finish = _parted(zero, zero + 1, whole, here, where)
    breaks = take(meetings.breaks[:-1], whole)
    breaks[here] = True
    return Split(parts, whole, (begin + finish) / 2, breaks)


def _cut_at(pieces: Pieces, cut: Any, t: Any, place: Any) -> tuple[Pieces, Any, Any]:
    """Pieces cut, in order, at some t and place; which each was part of; which begin at a cut."""
    parts = 1 + sum_at(cut, namespace(t).ones_like(t), len(pieces.row))
    whole, here = repeat(integers(parts)), cut + count_up(len(cut), cut) + 1
    start, end = _parted(pieces.start, pieces.end, whole, here, t)
    first, last = _parted(pieces.first, pieces.last, whole, here, place)
    fresh = take(pieces.fresh, whole)
    fresh[here] = False
    cubic, row, column = take(stacked([pieces.cubic, pieces.row, pieces.column]), whole)
    return Pieces(cubic, start, end, first, last, row, column, fresh), whole, here


def _parted(begin: Any, end: Any, whole: Any, here: Any, at: Any) -> tuple[Any, Any]:
    begin, end = take(begin, whole), take(end, whole)
    begin[..., here], end[..., here - 1] = at, at
    return begin, end


def _refine(curves: Any, pieces: Pieces, meetings: Meetings) -> tuple[Any, Any, Any]:
    """Parameters (M,) and places (2, M) at which arcs meet, from where their chords do.

    Where arcs do not meet in these very pieces, or in another order, the chords' places stay;
    and which pieces those are.
    """
    xp = namespace(curves)
    cut, other = meetings.cut, meetings.other
    own = take(curves, take(pieces.cubic, cut))
    low, high = take(pieces.start, cut), take(pieces.end, cut)
    t, place, met = _arcs_cross(own, low, high, meetings)
    beside = t if met.all() else _beside(own, low, high, pieces, meetings)
    order = (cut + BEFORE_NEXT * meetings.where).argsort()
    for _ in range(TRIES):
        settled = xp.where(met, t, beside)
        in_turn, piece = take(settled, order), take(cut, order)
        wrong = where_true((piece[1:] == piece[:-1]) & (in_turn[1:] < in_turn[:-1] - TOUCH))
        if not len(wrong):
            break
        spoiled = xp.zeros_like(pieces.fresh)
        spoiled[take(piece, wrong)] = True
        met = met & ~take(spoiled, cut)
        met = met & take(met, other)
        beside = _beside(own, low, high, pieces, meetings)
    apart = xp.zeros_like(pieces.fresh)
    apart[take(cut, where_true(~met & (other != count_up(len(cut), cut))))] = True
    return settled, xp.where(met, place, meetings.place), where_true(apart)


def _arcs_cross(own: Any, low: Any, high: Any, meetings: Meetings) -> tuple[Any, Any, Any]:
    """Where arcs cross, by Newton's method: t (M,), the place (2, M), and whether they do."""
    xp = namespace(own)
    other, self = meetings.other, count_up(len(low), meetings.other)
    t = low + meetings.where * (high - low)
    for rounds in range(ROUNDS + 1):
        place = evaluate(own, t)
        gap = take(place, other) - place
        near = abs(gap) < CROSSED
        if rounds == ROUNDS or near.all():
            break
        along = evaluate_slope(own, t)
        across = take(along, other)
        t = _advanced(t, _cross(gap, across) / _cross(along, across), low, high)
    # An entry that has no partner is the end of another piece, and its place is known.
    met = near[0] & near[1] & (other != self)
    # Both of a crossing have one place, so that what is enclosed stays closed.
    return t, take(place, xp.minimum(other, self)), met


def _beside(own: Any, low: Any, high: Any, pieces: Pieces, meetings: Meetings) -> Any:
    """The t (M,) at which an arc comes as far as its chord does, in the direction it goes most."""
    xp = namespace(own)
    chord = abs(take(pieces.last - pieces.first, meetings.cut))
    wide = chord[0] > chord[1]
    polynomials = xp.where(wide, own[:, 0], own[:, 1])
    goal = xp.where(wide, meetings.place[0], meetings.place[1])
    t = low + meetings.where * (high - low)
    for _ in range(ROUNDS):
        step = (goal - evaluate(polynomials, t)) / evaluate_slope(polynomials, t)
        t = _advanced(t, step, low, high)
    return t


def _advanced(t: Any, step: Any, low: Any, high: Any) -> Any:
    """One step of Newton's method, none where it has no end."""
    xp = namespace(t)
    return between(t + xp.where(xp.isfinite(step), step, 0.0), low, high)
