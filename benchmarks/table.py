"""What a benchmark reports, and the plain table it is printed in."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import astuple, dataclass, fields


@dataclass(frozen=True)
class Row:
    """One workload against one baseline; times are medians."""

    benchmark: str
    case: str
    ours: str
    baseline: str
    ratio: str
    notes: str = ""


def milliseconds(value: float) -> str:
    """A time at a fixed number of digits."""
    return f"{value:.2f} ms"


class Printer:
    """Prints rows as they come, in columns of fixed width."""

    widths = (9, 38, 9, 25, 19, 0)

    def __init__(self) -> None:
        self._line(field.name for field in fields(Row))
        self._line("-" * (width or 5) for width in self.widths)

    def print(self, row: Row) -> None:
        self._line(astuple(row))

    def _line(self, cells: Iterable[str]) -> None:
        padded = (cell.ljust(width) for cell, width in zip(cells, self.widths, strict=True))
        print("  ".join(padded).rstrip(), flush=True)
