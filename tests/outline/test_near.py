"""Pairs of boxes that overlap: the same pairs as by comparing every box with every other one."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

import vfwidget as vf
from vfwidget.arrays import expand
from vfwidget.outline import near
from vfwidget.outline.arrangement import boundary
from vfwidget.outline.monotone import coefficients

FORMS = [(0, 64, 2**20), (0, 64, 5), (0, 0.25, 2**20), (0, 0.25, 5), (90, 64, 2**20)]
"""By a sweep, by bands, each in one block and in many, and by comparing all."""


def every_pair(low, high, group):
    """By comparing all: pairs in any order, each with its smaller index first."""
    one, other = np.triu_indices(len(group), 1)
    meets = (np.maximum(low[:, one], low[:, other]) < np.minimum(high[:, one], high[:, other])).all(
        0
    )
    meets &= group[one] == group[other]
    return set(zip(one[meets].tolist(), other[meets].tolist(), strict=True))


def found(low, high, group):
    pairs, bottom, top = near.near_pairs(low, high, group)
    pairs, bottom, top = (np.asarray(values) for values in (pairs, bottom, top))
    low, high = np.asarray(low), np.asarray(high)
    np.testing.assert_array_equal(bottom, low[1][pairs].max(0))
    np.testing.assert_array_equal(top, high[1][pairs].min(0))
    listed = [tuple(sorted(pair)) for pair in pairs.T.tolist()]
    assert len(set(listed)) == len(listed)
    return set(listed)


@pytest.mark.parametrize("few, crowded, block", FORMS)
@given(seed=st.integers(0, 2**32 - 1), count=st.integers(1, 90), groups=st.integers(1, 3))
@settings(deadline=None, derandomize=True, max_examples=40)
def test_pairs_by_each_search(few, crowded, block, seed, count, groups):
    rng = np.random.default_rng(seed)
    low = rng.uniform(-50, 50, (2, count))
    # Some are tall, most are not; boxes without width or height overlap with none.
    high = low + rng.choice([0.0, 1.0, 9.0, 80.0], (2, count)) * rng.uniform(size=(2, count))
    group = np.sort(rng.integers(0, groups, count))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(near, "FEW", few)
        patch.setattr(near, "CROWDED", crowded)
        patch.setattr(near, "BLOCK", block)
        want = every_pair(low, high, group)
        kept = found(low, high, group)
        level = (high == low).any(0)
        assert {p for p in kept if not level[list(p)].any()} == {
            p for p in want if not level[list(p)].any()
        }
        tensors = found(*(torch.from_numpy(values) for values in (low, high, group)))
        assert tensors == kept


def test_many_boxes_in_a_column_are_compared_with_their_neighbours_only(monkeypatch):
    """20,000 boxes have 200 million pairs above each other, of which 19,999 overlap."""
    begun = []
    monkeypatch.setattr(near, "expand", lambda *a: begun.append(int(a[1].sum())) or expand(*a))
    y = np.arange(20_000.0)
    low, high = np.stack([0 * y, y]), np.stack([0 * y + 1, y + 1.5])
    pairs, *_ = near.near_pairs(low, high, np.zeros(len(y), dtype=int))
    assert set(abs(pairs[0] - pairs[1]).tolist()) == {1}
    assert pairs.shape == (2, 19_999)
    # The candidates, after the boxes of each band.
    assert sum(begun[1:]) < 2_000_000


def test_too_many_pairs_are_refused(monkeypatch):
    monkeypatch.setattr(vf.limits, "curve_pairs", 2)
    low, high, group = np.zeros((2, 3)), np.ones((2, 3)), np.zeros(3, dtype=int)
    with pytest.raises(vf.OverlapError, match=r"3 pairs.*at most 2 .*raise vf\.limits\.curve_pair"):
        near.near_pairs(low, high, group)
    monkeypatch.setattr(vf.limits, "curve_pairs", 3)
    assert near.near_pairs(low, high, group)[0].shape == (2, 3)


def test_curves_side_by_side_are_refused_too(monkeypatch):
    """Thin bars far from each other, whose boxes do not overlap, are many parts in every slab."""
    count = 300
    x, y = 4.0 * np.arange(count), 0.25 * np.arange(count)
    corners = np.array([(0, 0), (0, 100), (0.1, 100), (0.1, 0)], dtype=float)
    bars = corners + np.stack([x, -y], 1)[:, None]
    sides = np.stack([bars, np.roll(bars, -1, 1)], 2)
    t = np.linspace(0, 1, 4)[:, None]
    curves = coefficients(sides[..., :1, :] * (1 - t) + sides[..., 1:, :] * t)
    assert (boundary(curves, [4] * count).weight != 0).any()
    monkeypatch.setattr(vf.limits, "curve_pairs", 1_000)
    with pytest.raises(vf.OverlapError, match="curve_pairs"):
        boundary(curves, [4] * count)


def test_the_limit_holds_for_each_image_of_a_batch(monkeypatch) -> None:
    text = vf.Text("recursive", "R")
    one = [segments * torch.tensor([0.03, -0.03]) + 28 for segments in text.segments()]
    many = [segments.expand(50, *segments.shape) for segments in one]
    monkeypatch.setattr(vf.limits, "curve_pairs", 400)
    drawn = vf.rasterize(many, size=(32, 32))
    torch.testing.assert_close(drawn[7], vf.rasterize(one, size=(32, 32)))
    monkeypatch.setattr(vf.limits, "curve_pairs", 5)
    with pytest.raises(vf.OverlapError, match="curve_pairs"):
        vf.rasterize(one, size=(32, 32))
