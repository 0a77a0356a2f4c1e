"""The lines that a benchmark reports, and the table that prints them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import astuple, dataclass, fields


@dataclass(frozen=True)
class Row:
    """Compares one workload with one baseline; times are medians."""

    benchmark: str
    case: str
    ours: str
    baseline: str
    ratio: str
    notes: str = ""


def milliseconds(value: float) -> str:
    """Format a time with a fixed number of digits."""
    return f"{value:.2f} ms"


class Printer:
    """Prints each row at once, in columns of fixed width."""

    widths = (9, 38, 9, 25, 19, 0)

    def __init__(self) -> None:
        self._line(field.name for field in fields(Row))
        self._line("-" * (width or 5) for width in self.widths)

    def print(self, row: Row) -> None:
        self._line(astuple(row))

    def _line(self, cells: Iterable[str]) -> None:
        padded = (cell.ljust(width) for cell, width in zip(cells, self.widths, strict=True))
        print("  ".join(padded).rstrip(), flush=True)
