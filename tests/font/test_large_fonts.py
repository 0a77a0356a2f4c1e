"""A font of the size of those for Chinese, Japanese and Korean, walked glyph by glyph."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import fonts
import pytest

GLYPHS = 15_000
STROKES = 12
MOST_MEBIBYTES = 300
WALK = """
import resource, sys
import vfwidget as vf

vf.Text("dynapuff", "a").points()
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
font = vf.load_font(sys.argv[1])
points = sum(len(glyph.default) for glyph in font)
after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
print(len(font), points, (after - before) // 1024)
"""


def strokes_of(number: int) -> tuple[fonts.glyf.Glyph, list[fonts.DeltaSet]]:
    """A character of twelve strokes, which become heavier and wider, all different."""
    contours, moves = [], []
    for stroke in range(STROKES):
        x, y = 70 * stroke, (37 * number * (stroke + 1)) % 800
        contours.append([(x, y), (x + 300, y, 0), (x + 320, y + 40), (x + 20, y + 60, 0)])
        moves += [(-stroke, 0), (5 + stroke, number % 17), (9, 30), (0, 25)]
    still = [(0, 0), (20, 0), (0, 0), (0, 0)]
    sets = [
        (fonts.BOLD, [*moves, *still]),
        (fonts.WIDE, [*moves[::-1], *still]),
        ({**fonts.BOLD, **fonts.WIDE}, [*moves, *still]),
    ]
    return fonts.outline(*contours), sets


@pytest.mark.slow
def test_a_font_of_15000_glyphs_is_walked_in_little_memory(tmp_path: Path) -> None:
    drawn = {f"cid{number:05}": strokes_of(number) for number in range(GLYPHS)}
    glyphs = {name: glyph for name, (glyph, _) in drawn.items()}
    file = tmp_path / "cjk.ttf"
    file.write_bytes(fonts.build(glyphs, {name: sets for name, (_, sets) in drawn.items()}))
    # A process of its own, whose greatest memory is that of the walk.
    run = subprocess.run(
        [sys.executable, "-c", WALK, str(file)], capture_output=True, text=True, check=True
    )
    count, points, mebibytes = map(int, run.stdout.split())
    assert count == GLYPHS + 1
    # A stroke is two curves of three control points each.
    assert points == GLYPHS * STROKES * 2 * 3
    assert mebibytes < MOST_MEBIBYTES
