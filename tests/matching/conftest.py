"""A picture of a letter at known axes, and the match of it."""

from __future__ import annotations

import numpy as np
import pytest
from pictures import SIZE, draw, match

import vfwidget as vf
from vfwidget.matching import Match


@pytest.fixture(scope="module")
def text() -> vf.Text:
    return vf.Text("dynapuff", "S", axes={"wght": 620, "wdth": 84})


@pytest.fixture(scope="module")
def image(text) -> np.ndarray:
    return draw(text, SIZE)


@pytest.fixture(scope="module")
def found(image) -> Match:
    return match(image, "S", "dynapuff")
