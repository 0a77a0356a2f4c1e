"""Outlines, advances and derivatives of many fonts, held against HarfBuzz.

``python tests/conformance.py`` compares the fonts and prints the table of docs/conformance.md. The
fonts of other scripts are fetched by npm, and those of public test suites lie beside the checkout.
"""

from __future__ import annotations

import argparse
import sys
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from itertools import islice, product
from pathlib import Path

import colour_fonts
import formats
import numpy as np
import registry_fonts
import varc_fonts
import variation_tables
from referee import F2DOT14, HarfBuzz, outline_error
from rendering_cases import CASES, TOLERANCE, differences

import vfwidget as vf
from vfwidget.font.source import open_font
from vfwidget.outline.composed import Composed
from vfwidget.outline.varying import Varying

RANDOM_PLACES, MOST_CORNERS, MOST_PEAKS = 8, 64, 64
STEP = 1e-5
"""Of a central difference, in normalized units."""
OUTLINE, ADVANCE, JACOBIAN = 0.002, 0.501, 1e-6
"""The tolerances: font units (in proportion above 2048 units per em), HarfBuzz's rounding of an
advance, and the share of the greatest derivative."""
COMPONENT_AXES = 0.02
"""HarfBuzz rounds the axis values of a component to 1/16384, so VARC is held to this many units."""


@dataclass
class Row:
    """The comparison of one font; differences are the worst of all glyphs and places."""

    font: str
    covers: str
    glyphs: int = 0
    places: int = 0
    outline: float = 0.0
    advance: float = 0.0
    jacobian: float = 0.0
    tolerance: float = OUTLINE

    @property
    def holds(self) -> bool:
        """Whether every difference is within its tolerance."""
        near = self.outline <= self.tolerance and self.advance <= ADVANCE
        return self.glyphs > 0 and near and self.jacobian <= JACOBIAN

    def __str__(self) -> str:
        return (
            f"| {self.font} | {self.covers} | {self.glyphs} | {self.places:,} | {self.outline:.0e} "
            f"| {self.advance:.3f} | {self.jacobian:.0e} |"
        )


HEADER = (
    "| Font | Covers | Glyphs | Locations | Outline | Advance | Derivative |\n"
    "| --- | --- | --: | --: | --: | --: | --: |"
)


MADE_UP = {
    formats.random_cff2: "CFF2: every operator, blend",
    formats.cff2_with_subroutines: "CFF2: subroutines",
    formats.cff2_with_two_sets_of_regions: "CFF2: vsindex",
    formats.cff2_closing_only_at_the_default: "CFF2: implied closing lines",
    formats.cubic_glyf: "cubic curves in GLYF",
    formats.beyond_64k: "GLYF, GVAR, HMTX",
    variation_tables.avar_2: "avar 2",
    varc_fonts.varc: "VARC",
    colour_fonts.coloured: "COLR 1",
    colour_fonts.flat_colours: "COLR 0",
}
"""Functions that build a font, and the feature that each stands for."""
CJK = "manimgx_fonts_cjk"
"""A package that holds Noto Sans CJK; its font is compared where the package is installed."""


def sources() -> Iterator[tuple[str, str, Callable[[], bytes]]]:
    """The name of each font, the features that it stands for, and its file."""
    package = Path(vf.__file__).parent / "fonts"
    for name in vf.bundled_fonts():
        yield name, "glyf, HVAR, avar", (package / f"{name}.woff2").read_bytes
    for file in registry_fonts.FILES:
        yield (
            file.partition("/")[2].removesuffix("-normal"),
            "glyf",
            registry_fonts.path(file).read_bytes,
        )
    for build, covers in MADE_UP.items():
        yield build.__name__, covers, build
    package = find_spec(CJK)
    if package and package.origin:
        collection = Path(package.origin).parent / "NotoSansCJK-VF.otf.ttc"
        yield "NotoSansCJK-VF", "CFF2, collection, 65,535 glyphs", collection.read_bytes
    for folder, covers in ("formats", "public test suites"), ("trt-fonts", "text-rendering-tests"):
        for path in sorted((formats.CONFORMANCE / folder).glob("*.[ot]tf")):
            yield path.stem, covers, path.read_bytes


def corners(lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    """Corners of the design space: all of them, or as many as are asked for."""
    sides = list(zip(lower, upper, strict=True))
    if 2 ** len(sides) <= MOST_CORNERS:
        return np.array(list(product(*sides)))
    choice = np.random.default_rng(1).integers(0, 2, (MOST_CORNERS, len(sides)))
    return np.where(choice, upper, lower)


def places(font: vf.Font, glyph: vf.Glyph, count: int) -> np.ndarray:
    """Random places, corners and peaks of regions, on the grid that HarfBuzz can be told."""
    lower, upper = font.bounds
    rng = np.random.default_rng(glyph.glyph_id)
    found = [rng.uniform(lower, upper, (RANDOM_PLACES, len(lower))), corners(lower, upper)]
    outline = glyph.outline
    if glyph.is_affine:
        found.append(np.unique(outline.support[..., 1], axis=0)[:MOST_PEAKS])
    return np.round(np.concatenate(found)[:count] * F2DOT14) / F2DOT14


def over_final(quantity: Varying, font: vf.Font) -> Varying:
    """A quantity over the coordinates that HarfBuzz is told, those after avar 2."""
    return quantity.outer if font.moves_axes and isinstance(quantity, Composed) else quantity


def derivative_error(glyph: vf.Glyph, bounds: tuple[np.ndarray, np.ndarray]) -> float:
    """The difference of the Jacobian from a central difference, as a share of its greatest entry.

    It is measured at a random place, where no kink is within the step.
    """
    lower, upper = bounds
    if not glyph.contours or (lower == upper).any():
        return 0.0
    rng = np.random.default_rng(glyph.glyph_id)
    w = lower + rng.uniform(0.01, 0.99, len(lower)) * (upper - lower)
    if any(
        (abs(b - x) < 2 * STEP).any() for b, x in zip(glyph.outline.breakpoints, w, strict=True)
    ):
        return 0.0
    jacobian = glyph.outline.value_and_jacobian(w)[1]
    steps = STEP * np.eye(len(w))
    ahead, behind = (glyph.outline.value(w + side * steps) for side in (1, -1))
    difference = np.moveaxis(ahead - behind, 0, -1) / (2 * STEP)
    return float(abs(jacobian - difference).max() / max(abs(jacobian).max(), 1.0))


def compare(name: str, covers: str, data: bytes, glyphs: int, count: int = 10**6) -> Row | None:
    """Compare as many glyphs of a font, spread over all, each at ``count`` places at most.

    None for a static font.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", vf.FontWarning)
        font = vf.load_font(data, static=True)
        referee = HarfBuzz(open_font(data))
        row = Row(name, covers)
        row.tolerance *= max(1.0, font.units_per_em / 2048)
        if not font.axes:
            return None
        if covers == "VARC":
            row.tolerance = COMPONENT_AXES
        chosen = font.glyph_names[:: max(1, len(font) // glyphs)]
        for glyph in islice(map(font.glyph, chosen), glyphs):
            try:
                _compare_glyph(row, font, glyph, referee, places(font, glyph, count))
            except AssertionError as error:
                raise AssertionError(f"{name}, glyph {glyph.name}") from error
            row.glyphs += 1
            row.jacobian = max(row.jacobian, derivative_error(glyph, font.bounds))
    return row


def _compare_glyph(
    row: Row, font: vf.Font, glyph: vf.Glyph, referee: HarfBuzz, where: np.ndarray
) -> None:
    row.places += len(where)
    points = over_final(glyph.outline, font).value(where)
    advances = over_final(glyph.advance_width, font).value(where).clip(0)
    for w, p, advance in zip(where, points, advances, strict=True):
        referee.locate(w)
        # A component that is not shown is a point.
        ours = [c for c in glyph.contours.split(p) if np.ptp(c, axis=(0, 1)).any()]
        off = outline_error(ours, referee.contours(glyph.glyph_id))
        row.outline = max(row.outline, off)
        row.advance = max(row.advance, abs(float(advance) - referee.advance(glyph.glyph_id)))


def print_rendering_cases() -> bool:
    """Print the table of the text-rendering-tests; false if one is too far away."""
    groups: dict[str, list[tuple[float, float]]] = {}
    for case in CASES:
        groups.setdefault(case["id"].partition("/")[0], []).append(differences(case))
    print("\n| Group | Cases | Outline | Advance |\n| --- | --: | --: | --: |")
    for name, found in groups.items():
        outline, advance = np.max(found, axis=0)
        print(f"| {name} | {len(found)} | {outline:.2f} | {advance:.2f} |")
    worst = [pair for found in groups.values() for pair in found] or [(np.inf, np.inf)]
    outline, advance = np.max(worst, axis=0)
    print(f"| all | {len(CASES)} | {outline:.2f} | {advance:.2f} |")
    return bool(max(outline, advance) <= TOLERANCE)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--glyphs", type=int, default=60, help="glyphs of each font (default 60)")
    options = parser.parse_args()
    print(HEADER)
    held = True
    for name, covers, read in sources():
        row = compare(name, covers, read(), options.glyphs)
        if row is None:
            continue
        held &= row.holds
        print(row if row.holds else f"{row} **too far**", flush=True)
    held &= print_rendering_cases()
    sys.exit(not held)


if __name__ == "__main__":
    main()
