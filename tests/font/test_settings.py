"""The boxes in which a text has one row of glyphs, against HarfBuzz at random locations."""

from __future__ import annotations

import fonts
import numpy as np
import pytest
from fontTools.fontBuilder import FontBuilder
from fontTools.ttLib.tables import otTables

import vfwidget as vf
from vfwidget.errors import TextError
from vfwidget.font.settings import F2DOT14, Settings


def settings(font: vf.Font, string: str) -> Settings:
    return font.settings(string, font.shaping_options())


def random_places(font: vf.Font, count: int) -> np.ndarray:
    rng = np.random.default_rng(11)
    return rng.uniform(*font.bounds, (count, len(font.axes)))


@pytest.mark.parametrize(
    ("name", "string", "rows"),
    [
        ("recursive", "k", 2),
        ("recursive", "Hello, figs", 5),
        ("recursive", "HTO", 1),
        ("roboto-flex", "a$", 2),
        ("dynapuff", "$k", 1),
    ],
)
def test_rows_are_those_of_harfbuzz(name: str, string: str, rows: int) -> None:
    font = vf.load_font(name)
    found = settings(font, string)
    assert len(found.rows) == rows
    options = font.shaping_options()
    places = random_places(font, 300)
    # On both sides of each edge, one unit of F2Dot14 apart.
    for axis, edges in enumerate(found.edges):
        for edge in edges:
            for side in (-0.5, 0.5):
                beside = random_places(font, 6)
                beside[:, axis] = edge + side / F2DOT14
                places = np.concatenate([places, beside])
    for w in places:
        expected = font.shape_at(string, w, options, lambda _: 0.0)
        assert found.rows[found.row_at(w)] == expected
    assert np.array_equal(found.row_at(places), [found.row_at(w) for w in places])
    lower, upper = found.box_at(places)
    for w, low, high in zip(places, lower, upper, strict=True):
        assert ((low <= np.round(w * F2DOT14) / F2DOT14) & (w <= high + 1 / F2DOT14)).all()
        assert found.row_at(low) == found.row_at(high) == found.row_at(w)


def test_the_first_row_is_that_of_the_default() -> None:
    for string in ("k", "$", "fig"):
        font = vf.load_font("recursive")
        assert settings(font, string).row_at(np.zeros(5)) == 0


def test_only_axes_that_change_the_text_have_edges() -> None:
    font = vf.load_font("recursive")
    tags = [axis.tag for axis in font.axes]
    edges = dict(zip(tags, settings(font, "k").edges, strict=True))
    assert {tag for tag, found in edges.items() if len(found)} == {"CRSV", "slnt"}
    assert not any(map(len, settings(font, "HTO").edges))


@pytest.mark.parametrize("string", ["k", "Hello, figs"])
def test_boxes_cover_the_design_space_once(string: str) -> None:
    font = vf.load_font("recursive")
    found = settings(font, string)
    boxes = [(row, box) for row in range(len(found.rows)) for box in found.boxes(row)]
    volume = sum(np.prod(upper - lower) for _, (lower, upper) in boxes)
    lower, upper = font.bounds
    assert volume == pytest.approx(np.prod(upper - lower), rel=1e-12)
    for w in random_places(font, 200):
        inside = [row for row, (low, high) in boxes if (low <= w).all() and (w <= high).all()]
        assert inside == [found.row_at(w)]


def test_overlapping_boxes_and_empty_sides() -> None:
    boxes = [{"wght": (0.25, 0.5)}, {"wght": (0.5, 1), "wdth": (-1, 0)}, {"wdth": (1, 1)}]
    font = vf.load_font(fonts.swapping(boxes))
    found = settings(font, "a")
    for wght in np.linspace(-1, 1, 17):
        for wdth in np.linspace(-1, 1, 17):
            inside = any(
                all(
                    low <= {"wght": wght, "wdth": wdth}[tag] <= high
                    for tag, (low, high) in box.items()
                )
                for box in boxes
            )
            row = found.rows[found.row_at(np.array([wght, wdth]))]
            assert font.glyph_names[row.glyph_ids[0]] == ("bowl" if inside else "a")


def test_a_condition_that_is_no_range_is_refused() -> None:
    def edit(builder: FontBuilder) -> None:
        variations = builder.font["GSUB"].table.FeatureVariations
        condition = variations.FeatureVariationRecord[0].ConditionSet.ConditionTable[0]
        negation = otTables.ConditionTable()
        negation.Format = 5
        negation.ConditionTable = condition
        variations.FeatureVariationRecord[0].ConditionSet.ConditionTable[0] = negation

    font = vf.load_font(fonts.swapping([{"wght": (0.25, 0.5)}], edit))
    with pytest.raises(TextError, match="condition of format 5"):
        settings(font, "a")


def test_too_many_pieces_are_refused() -> None:
    conditions = np.zeros((400, 2, 2), dtype=np.intp)
    conditions[:, :, 0] = np.arange(400)[:, None] * 20
    conditions[:, :, 1] = conditions[:, :, 0] + 10
    bounds = -np.ones(2), np.ones(2)
    with pytest.raises(TextError, match="more than 100000 pieces"):
        Settings((conditions, conditions[:0]), bounds, lambda w: pytest.fail("shaped"))
