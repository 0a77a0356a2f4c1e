"""``python -m benchmarks [--only NAME] [--quick]``: run the benchmarks, print one table."""

from __future__ import annotations

import argparse
from importlib import import_module

import torch

from .table import Printer

NAMES = ("drag", "size", "latency", "study", "reach", "raster", "recovery", "fit", "catalogue")


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("--only", choices=NAMES, help="run this one alone")
    parser.add_argument("--quick", action="store_true", help="fewer rounds, rougher numbers")
    options = parser.parse_args()
    # Eager PyTorch on arrays this small gains nothing from more threads, and is steadier with one.
    torch.set_num_threads(1)
    printer = Printer()
    for name in [options.only] if options.only else NAMES:
        for row in import_module(f"benchmarks.{name}").run(options.quick):
            printer.print(row)


if __name__ == "__main__":
    main()
