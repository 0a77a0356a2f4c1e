"""Settings of every test run."""

from __future__ import annotations

import os

# The arrays are small: on a busy machine further threads of BLAS and torch only wait for one
# another. NumPy reads the variable when it is loaded.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import matplotlib as mpl
import pytest
import torch

import vfwidget as vf

# Figures need no window. The environment would tell kernels as well, whose figures are inline.
mpl.use("Agg")
torch.set_num_threads(1)


@pytest.fixture(scope="module")
def font() -> vf.Font:
    """A font, for tests that give it wrong input."""
    return vf.load_font("recursive")


@pytest.fixture(scope="module")
def text(font: vf.Font) -> vf.Text:
    """A text, for tests that give it wrong input."""
    return vf.Text(font, "ab")
