"""Settings of every test run."""

from __future__ import annotations

import torch

# The tensors are small: on a busy machine further threads only wait for one another.
torch.set_num_threads(1)
