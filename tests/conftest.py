"""Settings of every test run."""

from __future__ import annotations

import os

# The arrays are small: on a busy machine further threads of BLAS and torch only wait for one
# another. NumPy reads the variable when it is loaded.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# Figures need no window.
os.environ["MPLBACKEND"] = "Agg"

import torch

torch.set_num_threads(1)
