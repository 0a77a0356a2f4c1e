"""An editor with a simulated front end."""

from __future__ import annotations

from typing import Any

import pytest
from front_end import FrontEnd

import vfwidget as vf


@pytest.fixture
def editor(monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.setattr("comm.create_comm", FrontEnd)
    made = vf.Editor("roboto-flex", "no")
    assert isinstance(made.comm, FrontEnd)
    return made
