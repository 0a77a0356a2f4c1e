"""PostScript outlines (CFF and CFF2) as cubic control points and delta sets.

fontTools decodes the charstrings. An operand that ``blend`` varies is a number here that brings its
deltas along, and path operators only add operands up, so that one run gives all layers.

Adobe Technical Note 5177 ("The Type 2 Charstring Format"); OpenType, "CFF2 CharString Format".
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from fontTools.cffLib import TopDictDecompiler
from fontTools.encodings.StandardEncoding import StandardEncoding
from fontTools.misc.psCharStrings import T2OutlineExtractor
from fontTools.ttLib import TTFont

from ..arrays import Array
from ..errors import FontError
from .gvar import check_size
from .unpacked import Unpacked, chain
from .varstore import VariationStore

MAX_SUBROUTINE_DEPTH = 16
"""The format allows 10."""
MAX_TOKENS = 400_000
"""Operators and operands of one glyph. The largest glyphs known have some thousands, and nested
subroutines could ask for billions."""
MAX_STACK = 513
"""Operands at a time, as the CFF2 format allows."""


class CffReader:
    """The PostScript outlines of a font.

    Parameters
    ----------
    font : TTFont
        With a CFF2 or a CFF table.
    axis_count : int
    """

    def __init__(self, font: TTFont, axis_count: int) -> None:
        self._varies = "CFF2" in font
        if self._varies:
            _check_indexes(font.reader["CFF2"])
        cff = font["CFF2" if self._varies else "CFF "].cff
        self._strings = cff[0].CharStrings
        store = getattr(getattr(self._strings, "varStore", None), "otVarStore", None)
        self._store = VariationStore(store, axis_count, "CFF2")
        self._no_regions = np.zeros((0, axis_count, 3))

    def read(self, name: str) -> Unpacked:
        """Unpack one glyph.

        Raises
        ------
        FontError
            Subroutines nest without end, or an operator is unknown or lacks operands.
        """
        if name not in self._strings:
            return Unpacked(np.zeros((1, 0, 2)), self._no_regions, [])
        path = _Path(name)
        self._run(name, path, (0, 0), accents=True)
        support = self._no_regions if path.outer is None else self._store.support(path.outer)
        check_size(name, len(path.steps) // 2, len(support))
        points, contours = path.cubics(len(support))
        return Unpacked(points, support, contours)

    def _run(self, name: str, path: _Path, origin: tuple[Any, Any], accents: bool) -> None:
        """Add a glyph's contours to a path, the accent of a composed glyph included."""
        string = self._strings[name]
        extractor = _Extractor(string, path, self._store, self._varies)
        path.move(origin)
        extractor.execute(string)
        if extractor.accent and accents:
            dx, dy, base, accent = extractor.accent
            self._run(StandardEncoding[int(base)], path, (0, 0), accents=False)
            self._run(StandardEncoding[int(accent)], path, (dx, dy), accents=False)


class _Blended(float):
    """The default of an operand that ``blend`` varies, with its deltas."""

    __slots__ = ("deltas",)
    deltas: list[float]

    def __new__(cls, default: float, deltas: list[float]) -> _Blended:
        number = super().__new__(cls, default)
        number.deltas = deltas
        return number

    def __neg__(self) -> _Blended:
        return _Blended(-float(self), [-delta for delta in self.deltas])


class _Path:
    """Contours as relative moves, whose numbers may be blended.

    Attributes
    ----------
    steps : list of float
        dx, dy of the move to the first point, then of those from each point to the next.
    outer : int or None
        The part of the variation store that the moves vary by.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self.steps: list[float] = []
        self.outer: int | None = None
        self.tokens = 0
        self._contours: list[list[tuple[int, int, int, int, int]]] = []
        self._origins: list[int] = []

    def move(self, origin: tuple[float, float]) -> None:
        """Go to a point that is given from the origin, before a glyph begins."""
        self._origins.append(len(self.steps) // 2)
        self.steps += origin

    def begin(self, step: Sequence[float]) -> None:
        """Begin a contour."""
        self.steps += step
        self._contours.append([])

    def line(self, step: Sequence[float]) -> None:
        """Add a line."""
        here = len(self.steps) // 2 - 1
        self.steps += step
        self._contours[-1].append((here, here + 1, here, here + 1, 1))

    def curve(self, one: Sequence[float], two: Sequence[float], end: Sequence[float]) -> None:
        """Add a cubic by its three steps."""
        here = len(self.steps) // 2 - 1
        self.steps += (*one, *two, *end)
        self._contours[-1].append((here, here + 1, here + 2, here + 3, 3))

    def cubics(self, sets: int) -> tuple[Array, list[int]]:
        """Control points (1 + m, 3 s, 2) and the segments of each contour."""
        steps = np.zeros((1 + sets, len(self.steps)))
        steps[0] = self.steps
        varying = {i: n.deltas for i, n in enumerate(self.steps) if isinstance(n, _Blended)}
        if varying:
            steps[1:, list(varying)] = np.transpose(list(varying.values()))
        parts = np.split(steps.reshape(1 + sets, -1, 2), self._origins[1:], axis=1)
        points = np.concatenate([part.cumsum(1) for part in parts], axis=1)
        segments, contours = [], []
        for contour in filter(None, self._contours):
            start, end = contour[0][0], contour[-1][3]
            if (points[:, start] != points[:, end]).any():
                # Every contour is closed, by a line where it does not end at its start.
                contour.append((end, start, end, start, 1))
            segments += contour
            contours.append(len(contour))
        return chain(points, segments), contours


class _Extractor(T2OutlineExtractor):
    """Runs one charstring; the path receives relative moves whose numbers may be arrays."""

    def __init__(self, string: Any, path: _Path, store: VariationStore, varies: bool) -> None:
        private = string.private
        if varies and "Subrs" in private.rawDict:
            _check_index(private.file.getvalue(), private.offset + private.rawDict["Subrs"])
        self.path, self.store, self.varies = path, store, varies
        self.accent: list[Any] | None = None
        self.depth = 0
        self.regions: int | None = None
        super().__init__(
            None, getattr(private, "Subrs", []), string.globalSubrs, 0, 0, private=private
        )
        # A CFF charstring may begin with the advance width; one of CFF2 never does.
        self.gotWidth = varies

    def execute(self, string: Any) -> None:
        """Run a charstring or a subroutine."""
        self.depth += 1
        if self.depth > MAX_SUBROUTINE_DEPTH:
            raise self._error("its subroutines nest too deeply")
        stack, index = self.operandStack, 0
        while True:
            index = _push_short_numbers(stack, string.bytecode, index)
            token, is_operator, index = string.getToken(index)
            if not is_operator:
                if token is None and index:
                    raise self._error("it has an unknown operator")
                if token is None:
                    break
                stack.append(token)
                continue
            self.path.tokens += 1 + len(stack)
            if self.path.tokens > MAX_TOKENS:
                raise self._error(f"it has more than {MAX_TOKENS} operators and operands")
            if len(stack) > MAX_STACK:
                raise self._error(f"it has more than {MAX_STACK} operands in a row")
            handler = getattr(self, f"op_{token}", None)
            if handler is None:
                raise self._error(f"the operator {token} is unknown")
            self.callingStack.append(string)
            _, index = handler(index) or (None, index)
            self.callingStack.pop()
        self.depth -= 1

    def rMoveTo(self, step: Any) -> None:
        """Begin a contour."""
        self.path.begin(step)
        self.sawMoveTo = 1

    def rLineTo(self, step: Any) -> None:
        """Draw a line."""
        if not self.sawMoveTo:
            self.rMoveTo((0, 0))
        self.path.line(step)

    def rCurveTo(self, *steps: Any) -> None:
        """Draw a cubic."""
        if not self.sawMoveTo:
            self.rMoveTo((0, 0))
        self.path.curve(*steps)

    def closePath(self) -> None:
        """End a contour."""
        self.sawMoveTo = 0

    def op_endchar(self, index: int) -> None:
        """End the glyph; four operands ask for an accented letter (seac)."""
        self.endPath()
        operands = self.popallWidth()
        if operands:
            self.accent = operands[-4:]

    def op_flex1(self, index: int) -> None:
        """Two curves whose end is level with their start on one axis."""
        *steps, last = self.popall()
        dx, dy = _sum(steps[0::2]), _sum(steps[1::2])
        wide = abs(dx) > abs(dy)
        self.operandStack[:] = [*steps, last, -dy] if wide else [*steps, -dx, last]
        self.op_rrcurveto(index)

    def op_hflex1(self, index: int) -> None:
        """Two curves that end at the height at which they start."""
        dx1, dy1, dx2, dy2, dx3, dx4, dx5, dy5, dx6 = self.popall()
        back = -_sum([dy1, dy2, dy5])
        self.operandStack[:] = [dx1, dy1, dx2, dy2, dx3, 0, dx4, 0, dx5, dy5, dx6, back]
        self.op_rrcurveto(index)

    def op_vsindex(self, index: int) -> None:
        """Choose the part of the variation store."""
        self.path.outer, self.regions = int(self.pop()), None

    def op_blend(self, index: int) -> None:
        """Give n defaults their rows of deltas."""
        if self.regions is None:
            if self.path.outer is None:
                self.path.outer = int(getattr(self.private, "vsindex", 0))
            self.regions = len(self.store.support(self.path.outer))
        regions, count, stack = self.regions, int(self.pop()), self.operandStack
        first = len(stack) - count * (regions + 1)
        if count < 1 or first < 0:
            raise self._error("blend lacks operands")
        deltas = stack[first + count :]
        stack[first:] = [
            _Blended(default, deltas[i * regions : (i + 1) * regions])
            for i, default in enumerate(stack[first : first + count])
        ]

    def _error(self, problem: str) -> FontError:
        table = "CFF2" if self.varies else "CFF"
        return FontError(f"Glyph {self.path.name!r} of the {table} table is damaged: {problem}.")


def _check_indexes(data: bytes) -> None:
    """See that the lists of a CFF2 table are no longer than the table, before they are unpacked."""
    start, size = data[2], int.from_bytes(data[3:5], "big")
    top = TopDictDecompiler(None)
    top.decompile(data[start : start + size])
    stated = top.getDict()
    places = [start + size, *(stated.get(name) for name in ("CharStrings", "FDArray"))]
    for at in places:
        if at is not None:
            _check_index(data, at)


def _check_index(data: bytes, at: int) -> None:
    """An INDEX of CFF2 has a count of four bytes, which could ask for billions of items."""
    count = int.from_bytes(data[at : at + 4], "big")
    if count and (data[at + 4 : at + 5] < b"\1" or count > len(data) - at):
        raise FontError(f"The CFF2 table is damaged: it states a list of {count} items.")


def _push_short_numbers(stack: list[float], data: bytes, index: int) -> int:
    """Push the numbers of one or two bytes that come next, and return where they end.

    fontTools would decode them, too, but nearly all tokens of a glyph are such numbers.
    """
    while index < len(data) and 32 <= (first := data[index]) < 255:
        if first < 247:
            stack.append(first - 139)
            index += 1
        else:
            high, second = (first - 247) % 4 * 256 + 108, data[index + 1]
            stack.append(high + second if first < 251 else -high - second)
            index += 2
    return index


def _sum(numbers: list[float]) -> float:
    """The sum of numbers, blended or not."""
    rows = [number.deltas for number in numbers if isinstance(number, _Blended)]
    total = sum(map(float, numbers))
    return _Blended(total, [sum(column) for column in zip(*rows, strict=True)]) if rows else total
