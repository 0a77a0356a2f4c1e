"""Solutions of terms that are located again after every step."""

from __future__ import annotations

import numpy as np
import pytest

import vfwidget as vf


@pytest.mark.parametrize("name, pull", [("shantell-sans", (60, 10)), ("recursive", (60, 10))])
def test_restarts_do_not_spoil_what_is_asked_later(name: str, pull: tuple[int, int]) -> None:
    text = vf.Text(name, "n")
    apart = vf.NoOverlap(np.array([(0.0, 250), (450, 260), (450, 420), (0, 300)]), gap=30)
    handle = text.nearest(100, 500)
    terms = [vf.Target(handle, text.position(handle).numpy() + pull), apart]
    found, alone = vf.solve(text, terms, restarts=3), vf.solve(text, terms, restarts=0)
    assert found.theta.equal(alone.theta)
    # In the meantime restarts have located the planes between the shapes elsewhere.
    assert found.active.any()
    assert np.array_equal(found.active, alone.active)
    assert found.report() == alone.report()
