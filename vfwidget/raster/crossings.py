r"""Where contours cross or touch, and pieces cut there.

A contour can only be crossed in a pixel that both pass through. There the chords of the pieces
cross as often, modulo two, as the arcs do, for both end on the pixel's border; so the chords
decide what crosses what, and the arcs where exactly. Where arcs cross in other pieces than their
chords do, which takes a loop or a gap smaller than a pixel, they are halved; after a few times the
chords' crossing stands in.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from ..arrays import (
    begins,
    count_up,
    integers,
    like,
    namespace,
    repeat,
    sorting,
    sum_at,
    take,
    where_true,
)
from .cuts import SLOPE, Pieces, evaluate, evaluate_slope

TOUCH = 1e-9
"""In pixels, how near counts as touching."""
ROUNDS = 6
"""Of Newton's method, from where chords cross to where arcs do."""
CROSSED = 1e-10
"""In pixels, how near to each other arcs that cross have come then."""
HALVINGS = 4
"""How often pieces are halved whose chords cross but whose arcs do not."""
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
    curves : (C, 4, 2) array
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
        meetings = _meetings(pieces, *_pairs(pieces, width))
        if not len(meetings.cut):
            break
        t, place, apart = _refine(curves, pieces, meetings)
        if rounds == HALVINGS or not apart.any():
            return pieces, _split(curves, pieces, meetings, t, place)
        # Chords crossed where their arcs do not: shorter ones are nearer to them.
        halved = where_true(apart)
        t = (take(pieces.start, halved) + take(pieces.end, halved)) / 2
        place = evaluate(take(curves, take(pieces.cubic, halved)), t[:, None])
        pieces, _, _ = _cut_at(pieces, halved, t, place)
    count = len(pieces.cell)
    middle = namespace(curves).zeros_like(pieces.start) + 0.5
    return pieces, Split(pieces, count_up(count, pieces.cell), middle, meetings.breaks[:-1])


def expand(begin: Any, end: Any) -> tuple[Any, Any]:
    """All (i, j) with begin[i] ≤ j < end[i]."""
    count = end - begin
    i = repeat(count)
    return i, count_up(len(i), count) - take(count.cumsum(0) - count - begin, i)


def _pairs(pieces: Pieces, width: int) -> tuple[Any, Any]:
    """Pairs of pieces that share a cell; one that lies on a border belongs to both its sides."""
    xp = namespace(pieces.cell)
    piece, cell = count_up(len(pieces.cell), pieces.cell), pieces.cell
    middle = (pieces.first + pieces.last) / 2
    border = xp.round(middle)
    reach = xp.maximum(abs(pieces.first - border), abs(pieces.last - border))
    for axis, step in enumerate((1, width + 2)):
        on = where_true(reach[:, axis] < TOUCH)
        if len(on):
            side = take(middle[:, axis] >= border[:, axis], on)
            piece = xp.concatenate([piece, on])
            cell = xp.concatenate([cell, take(pieces.cell, on) + xp.where(side, -step, step)])
    order = sorting(cell)
    piece, cell = take(piece, order), take(cell, order)
    begin = where_true(begins(cell))
    end = xp.roll(begin, -1)
    end[-1] = len(cell)
    shared = where_true(end - begin > 1)
    end = take(end, shared)
    group, here = expand(take(begin, shared), end)
    first, second = expand(here + 1, take(end, group))
    first, second = take(piece, take(here, first)), take(piece, second)
    return xp.minimum(first, second), xp.maximum(first, second)


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
    place : (M, 2) array
    other : (M,) int array
        Which other entry is of the same crossing, or the entry's own number.
    """

    breaks: Any
    cut: Any
    where: Any
    place: Any
    other: Any


def _meetings(pieces: Pieces, a: Any, b: Any) -> Meetings:
    """Where these pairs meet, but not where one goes on from the other."""
    xp = namespace(pieces.first)
    p, q = take(pieces.first, a), take(pieces.first, b)
    r, s = take(pieces.last, a) - p, take(pieces.last, b) - q
    lengths = xp.stack([xp.hypot(r[:, 0], r[:, 1]), xp.hypot(s[:, 0], s[:, 1])])
    across, beside = _cross(r, s), _cross(q - p, r)
    parallel = abs(across) <= TOUCH * lengths[0] * lengths[1]
    where = xp.stack([_cross(q - p, s), beside]) / xp.where(parallel, 1.0, across)
    slack = TOUCH / xp.clip(lengths, TOUCH, None)
    follows = (b == a + 1) & ~take(pieces.fresh, b)
    crosses = ((where >= -slack) & (where <= 1 + slack)).all(0) & ~parallel & ~follows
    crosses = where_true(crosses)
    pair = xp.stack([take(a, crosses), take(b, crosses)])
    where, near = where[:, crosses], slack[:, crosses]
    place = take(p, crosses) + where[0][:, None] * take(r, crosses)
    at_first, at_last = where <= near, where >= 1 - near

    # One more than there are pieces, for what ends with the last.
    breaks = xp.concatenate([pieces.fresh, pieces.fresh[:1]])
    # At a pixel's corner pieces may cross that share no cell.
    corner = (abs(pieces.first - xp.round(pieces.first)) < TOUCH).all(1)
    breaks[:-1] |= corner
    breaks[pair[at_first]] = True
    breaks[pair[at_last] + 1] = True
    through = ~(at_first | at_last)
    number = xp.where(through, through.reshape(-1).cumsum(0).reshape(through.shape) - 1, -1)
    partner = xp.stack([number[1], number[0]])
    partner = xp.where(partner < 0, number, partner)
    cuts = [(pair[through], where[through], xp.stack([place, place])[through], partner[through])]

    # Pieces that coincide are cut at each other's ends; one that goes straight on does not.
    along = parallel & (abs(beside) <= TOUCH * xp.clip(lengths[0], TOUCH, None))
    along = along & ~(follows & ((r * s).sum(1) > 0))
    along = where_true(along & (lengths > TOUCH).all(0))
    count = len(cuts[0][0])
    if len(along):
        ends = [take(v, along) for v in (p, p + r, q, q + s)]
        for own, base, chord, points in ((a, p, r, ends[2:]), (b, q, s, ends[:2])):
            own, base, chord = take(own, along), take(base, along), take(chord, along)
            breaks[own], breaks[own + 1] = True, True
            square = (chord * chord).sum(1)
            edge = TOUCH / xp.sqrt(square)
            for point in points:
                part = ((point - base) * chord).sum(1) / square
                inner = where_true((part > edge) & (part < 1 - edge))
                numbers = count_up(len(inner), inner) + count
                count += len(inner)
                cuts.append((take(own, inner), take(part, inner), take(point, inner), numbers))
    cut, where, place, other = (xp.concatenate(parts) for parts in zip(*cuts, strict=True))
    return Meetings(breaks, cut, where, place, other)


def _cross(a: Any, b: Any) -> Any:
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


def _split(curves: Any, pieces: Pieces, meetings: Meetings, t: Any, place: Any) -> Split:
    xp = namespace(curves)
    order = sorting(meetings.cut + 0.999999 * meetings.where)
    where = take(meetings.where, order)
    cut, t, place = (take(values, order) for values in (meetings.cut, t, place))
    parts, whole, here = _cut_at(pieces, cut, t, place)
    zero = xp.zeros_like(pieces.start)
    begin, finish = _parted(zero, zero + 1, whole, here, where)
    breaks = take(meetings.breaks, whole)
    breaks[here] = True
    return Split(parts, whole, (begin + finish) / 2, breaks)


def _cut_at(pieces: Pieces, cut: Any, t: Any, place: Any) -> tuple[Pieces, Any, Any]:
    """Pieces cut, in order, at some t and place; which each was part of; which begin at a cut."""
    parts = 1 + sum_at(cut, namespace(t).ones_like(t), len(pieces.cell))
    whole, here = repeat(integers(parts)), cut + count_up(len(cut), cut) + 1
    start, end = _parted(pieces.start, pieces.end, whole, here, t)
    first, last = _parted(pieces.first, pieces.last, whole, here, place)
    fresh = take(pieces.fresh, whole)
    fresh[here] = False
    cubic, cell = take(pieces.cubic, whole), take(pieces.cell, whole)
    return Pieces(cubic, start, end, first, last, cell, fresh), whole, here


def _parted(begin: Any, end: Any, whole: Any, here: Any, at: Any) -> tuple[Any, Any]:
    begin, end = take(begin, whole), take(end, whole)
    begin[here], end[here - 1] = at, at
    return begin, end


def _refine(curves: Any, pieces: Pieces, meetings: Meetings) -> tuple[Any, Any, Any]:
    """Parameters (M,) and places (M, 2) at which arcs meet, from where their chords do.

    Where arcs do not meet in these very pieces, or in another order, the chords' places stay;
    and which pieces (N,) those are.
    """
    xp = namespace(curves)
    cut, other = meetings.cut, meetings.other
    own = take(curves, take(pieces.cubic, cut))
    low, high = take(pieces.start, cut), take(pieces.end, cut)
    t, place, met = _arcs_cross(own, low, high, meetings)
    if met.all():
        beside = t
    else:
        beside = _beside(own, low, high, pieces, meetings)
    order = sorting(cut + 0.999999 * meetings.where)
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
    return settled, xp.where(met[:, None], place, meetings.place), apart


def _arcs_cross(own: Any, low: Any, high: Any, meetings: Meetings) -> tuple[Any, Any, Any]:
    """Where arcs cross, by Newton's method: t (M,), the place (M, 2), and whether they do."""
    xp = namespace(own)
    other, self = meetings.other, count_up(len(low), meetings.other)
    slopes = own[:, 1:] * like(SLOPE, own)
    t = low + meetings.where * (high - low)
    for _ in range(ROUNDS):
        place = evaluate(own, t[:, None])
        gap = take(place, other) - place
        if (abs(gap) < CROSSED).all():
            break
        along = evaluate_slope(slopes, t[:, None])
        across = take(along, other)
        step = _cross(gap, across) / _cross(along, across)
        t = xp.clip(t + xp.nan_to_num(step, posinf=0.0, neginf=0.0), low, high)
    place = evaluate(own, t[:, None])
    # An entry that has no partner is the end of another piece, and its place is known.
    met = (abs(take(place, other) - place) < 2 * CROSSED).all(1) & (other != self)
    # Both of a crossing have one place, so that what is enclosed stays closed.
    return t, take(place, xp.minimum(other, self)), met


def _beside(own: Any, low: Any, high: Any, pieces: Pieces, meetings: Meetings) -> Any:
    """The t (M,) at which an arc comes as far as its chord does, in the direction it goes most."""
    xp = namespace(own)
    chord = take(pieces.last - pieces.first, meetings.cut)
    wide = (abs(chord[:, 0]) > abs(chord[:, 1]))[:, None]
    polynomials = xp.where(wide, own[:, :, 0], own[:, :, 1])
    goal = xp.where(wide[:, 0], meetings.place[:, 0], meetings.place[:, 1])
    slopes = polynomials[:, 1:] * like(SLOPE[:, 0], own)
    t = low + meetings.where * (high - low)
    for _ in range(ROUNDS):
        step = (goal - evaluate(polynomials, t)) / evaluate_slope(slopes, t)
        t = xp.clip(t + xp.nan_to_num(step, posinf=0.0, neginf=0.0), low, high)
    return t
