"""The shape of an outline: which control points each segment and each contour has."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

import vfwidget as vf
from vfwidget.outline.contours import Contours


def test_segments_of_a_contour_share_ends_and_the_last_one_closes_it():
    shape = Contours([2, 1])
    assert shape.segments.tolist() == [[0, 1, 2, 3], [3, 4, 5, 0], [6, 7, 8, 6]]
    assert shape.owners.tolist() == [0, 0, 1]
    assert shape.point_count == 9
    assert shape == (2, 1)


def test_an_outline_without_contours():
    shape = Contours()
    assert shape.segments.shape == (0, 4)
    assert (shape.point_count, shape.indices, shape.split(np.zeros((0, 2)))) == (0, [], [])


@given(st.lists(st.integers(1, 9), max_size=6))
def test_every_control_point_begins_or_bends_exactly_one_segment(counts):
    shape = Contours(counts)
    assert shape.segments[:, :3].ravel().tolist() == list(range(shape.point_count))
    assert np.bincount(shape.owners, minlength=len(counts)).tolist() == counts
    np.testing.assert_array_equal(
        np.concatenate([np.empty((0, 4)), *shape.indices]), shape.segments
    )


@pytest.mark.parametrize("make", [np.ones, torch.ones])
def test_control_points_are_split_into_contours(make):
    parts = Contours([2, 3]).split(make((7, 15, 2)))
    assert [tuple(part.shape) for part in parts] == [(7, 2, 4, 2), (7, 3, 4, 2)]


@pytest.mark.parametrize(
    "copied", [copy.copy, copy.deepcopy, lambda x: pickle.loads(pickle.dumps(x))]
)
def test_a_copy_is_of_the_same_kind(copied):
    shape = Contours([2, 1])
    twin = copied(shape)
    assert type(twin) is Contours and twin == shape and twin.segments.shape == (3, 4)


@pytest.mark.parametrize(
    "counts, message",
    [
        ([0], "at least one segment"),
        ([2, -1], "at least one segment"),
        ([1.5], "number of segments"),
        ("ab", "number of segments"),
        (3, "number of segments"),
        (None, "number of segments"),
    ],
)
def test_what_is_no_number_of_segments(counts, message):
    with pytest.raises(vf.GlyphError, match=message):
        Contours(counts)
