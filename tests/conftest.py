"""Settings of every test run."""

from __future__ import annotations

import os

# The arrays are small: on a busy machine further threads of BLAS and torch only wait for one
# another. NumPy reads the variable when it is loaded.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import matplotlib as mpl
import torch

# Figures need no window. The environment would tell kernels as well, whose figures are inline.
mpl.use("Agg")
torch.set_num_threads(1)
