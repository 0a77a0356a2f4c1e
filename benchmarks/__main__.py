"""``python -m benchmarks [--only NAME] [--quick]``: run the benchmarks, print one table."""

from __future__ import annotations

import argparse
from importlib import import_module

import torch

from .table import Printer

NAMES = (
    "drag",
    "size",
    "latency",
    "smooth",
    "study",
    "reach",
    "overlap",
    "motion",
    "raster",
    "recovery",
    "fit",
    "catalogue",
    "loading",
)


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("--only", choices=NAMES, help="run only this benchmark")
    parser.add_argument("--quick", action="store_true", help="fewer rounds, less precise numbers")
    options = parser.parse_args()
    # More threads do not help PyTorch with arrays this small, and make the times less stable.
    torch.set_num_threads(1)
    printer = Printer()
    for name in [options.only] if options.only else NAMES:
        for row in import_module(f"benchmarks.{name}").run(options.quick):
            printer.print(row)


if __name__ == "__main__":
    main()
