"""The shortest way on which a letter leaves everything it overlaps, against polygons."""

from __future__ import annotations

import numpy as np
import pytest
from shapely import prepare
from shapely.affinity import translate
from shapely.ops import unary_union

import vfwidget as vf
from tests.overlap.polygons import filled, simple
from vfwidget.overlap.shape import Shape, letters, polygon
from vfwidget.overlap.way_out import way_out

SOME = 2 * np.pi * np.arange(60) / 60


def star(rng):
    """A polygon with reentrant corners around a place near the letters."""
    angles = np.sort(rng.uniform(0, 2 * np.pi, 9))
    out = rng.uniform(60, 900, 9)[:, None] * np.stack([np.cos(angles), np.sin(angles)], 1)
    return Shape(polygon(out + rng.uniform(0, 500, 2)), [9])


@pytest.mark.parametrize("string", ["o", "N", "%"])
@pytest.mark.parametrize("seed", range(4))
def test_the_way_out_is_free_and_none_is_much_shorter(string, seed) -> None:
    rng = np.random.default_rng([seed, ord(string)])
    (letter,) = letters(vf.Text("recursive", string))
    obstacles = [star(rng) for _ in range(1 + seed % 3)]
    # Contours may run either way.
    obstacles[0] = Shape(obstacles[0].segments[::-1, ::-1], obstacles[0].sizes)
    ink, others = filled(simple(letter)), unary_union([filled(simple(one)) for one in obstacles])
    assert ink.intersection(others).area > 100
    out = way_out(letter, obstacles)
    length = np.hypot(*out)
    assert translate(ink, *out).intersection(others).area < 0.5

    # No way is much shorter.
    coarse = others.buffer(-2).simplify(1)
    prepare(coarse)
    unit = np.stack([np.cos(SOME), np.sin(SOME)], 1)
    rough = ink.simplify(1)
    for distance in np.linspace(0, 0.8 * length, 20)[1:]:
        assert all(coarse.intersects(translate(rough, *way)) for way in distance * unit)


def test_a_letter_that_obstacles_surround_leaves_them() -> None:
    (letter,) = letters(vf.Text("dynapuff", "&"))
    low, high = letter.box
    # Many bars between which no letter fits.
    bars = [
        Shape(polygon(np.array([(x, -9e3), (x + 20, -9e3), (x + 20, 9e3), (x, 9e3)])), [4])
        for x in np.arange(low[0] - 2000, high[0] + 3000, 100.0)
    ]
    way = way_out(letter, bars)
    assert np.hypot(*way) == pytest.approx(high[0] - bars[0].box[0, 0], rel=0.01)
    assert way[1] == pytest.approx(0, abs=1)
