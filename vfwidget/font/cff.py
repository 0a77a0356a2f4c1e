"""PostScript outlines (CFF and CFF2) as cubic control points and delta sets.

fontTools decodes the charstrings. An operand that ``blend`` varies is an array of its default and
its deltas here, and path operators only add operands up, so that one run gives all layers.

Adobe Technical Note 5177 ("The Type 2 Charstring Format"); OpenType, "CFF2 CharString Format".
"""

from __future__ import annotations

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
        check_size(name, len(path.moves), len(support))
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


class _Path:
    """Contours as relative moves, each number a default or an array of 1 + m layers.

    Attributes
    ----------
    moves : list of (dx, dy)
        From each point to the next.
    outer : int or None
        The part of the variation store that the moves vary by.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self.moves: list[tuple[Any, Any]] = []
        self.outer: int | None = None
        self.tokens = 0
        self._contours: list[list[tuple[int, int, int, int, int]]] = []
        self._origins: set[int] = set()

    def move(self, origin: tuple[Any, Any]) -> None:
        """Go to a point that is given from the origin, before a glyph begins."""
        self._origins.add(len(self.moves))
        self.moves.append(origin)

    def begin(self, step: Any) -> None:
        """Begin a contour."""
        self.moves.append(tuple(step))
        self._contours.append([])

    def line(self, step: Any) -> None:
        """Add a line."""
        here = len(self.moves) - 1
        self.moves.append(tuple(step))
        self._contours[-1].append((here, here + 1, here, here + 1, 1))

    def curve(self, *steps: Any) -> None:
        """Add a cubic by its three steps."""
        here = len(self.moves) - 1
        self.moves += [tuple(step) for step in steps]
        self._contours[-1].append((here, here + 1, here + 2, here + 3, 3))

    def cubics(self, sets: int) -> tuple[Array, list[int]]:
        """Control points (1 + m, 3 s, 2) and the segments of each contour."""
        steps = np.zeros((len(self.moves), 2, 1 + sets))
        for i, move in enumerate(self.moves):
            for j, number in enumerate(move):
                if isinstance(number, np.ndarray):
                    steps[i, j] = number
                else:
                    steps[i, j, 0] = number
        starts = sorted(self._origins)
        points = np.concatenate([part.cumsum(0) for part in np.split(steps, starts[1:])])
        layers = np.moveaxis(points, 2, 0)
        segments, contours = [], []
        for contour in filter(None, self._contours):
            start, end = contour[0][0], contour[-1][3]
            if (points[start] != points[end]).any():
                # Every contour is closed, by a line where it does not end at its start.
                contour.append((end, start, end, start, 1))
            segments += contour
            contours.append(len(contour))
        return chain(layers, segments), contours


class _Extractor(T2OutlineExtractor):
    """Runs one charstring; the path receives relative moves whose numbers may be arrays."""

    def __init__(self, string: Any, path: _Path, store: VariationStore, varies: bool) -> None:
        private = string.private
        if varies and "Subrs" in private.rawDict:
            _check_index(private.file.getvalue(), private.offset + private.rawDict["Subrs"])
        self.path, self.store, self.varies = path, store, varies
        self.accent: list[Any] | None = None
        self.depth = 0
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
        index = 0
        while True:
            token, is_operator, index = string.getToken(index)
            if token is None:
                break
            if not is_operator:
                self.push(token)
                continue
            self.path.tokens += 1 + len(self.operandStack)
            if self.path.tokens > MAX_TOKENS:
                raise self._error(f"it has more than {MAX_TOKENS} operators and operands")
            if len(self.operandStack) > MAX_STACK:
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
        wide = abs(_default(dx)) > abs(_default(dy))
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
        self.path.outer = int(self.pop())

    def op_blend(self, index: int) -> None:
        """Replace n defaults and n rows of deltas by n arrays."""
        if self.path.outer is None:
            self.path.outer = int(getattr(self.private, "vsindex", 0))
        regions = len(self.store.support(self.path.outer))
        count = int(self.pop())
        operands = self.operandStack[len(self.operandStack) - count * (regions + 1) :]
        if count < 1 or len(operands) != count * (regions + 1):
            raise self._error("blend lacks operands")
        del self.operandStack[-len(operands) :]
        numbers = np.array(operands, dtype=np.float64)
        deltas = numbers[count:].reshape(count, regions)
        self.operandStack += list(np.column_stack([numbers[:count], deltas]))

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


def _sum(numbers: list[Any]) -> Any:
    """The sum of numbers and arrays of layers; a plain number counts in the default only."""
    arrays = [number for number in numbers if isinstance(number, np.ndarray)]
    plain = sum(number for number in numbers if not isinstance(number, np.ndarray))
    if not arrays:
        return plain
    total = np.sum(arrays, 0)
    total[0] += plain
    return total


def _default(number: Any) -> float:
    return float(number[0] if isinstance(number, np.ndarray) else number)
