"""Former names of keywords still work, with a warning at the caller's line."""

from __future__ import annotations

from dataclasses import dataclass

import pytest

from vfwidget.deprecation import renamed


@renamed(measure="width")
def fit(width: float, weight: float = 1.0) -> tuple[float, float]:
    return width, weight


def test_a_former_name_does_as_the_present_one_and_warns() -> None:
    with pytest.warns(DeprecationWarning, match="measure= is now called width=") as caught:
        assert fit(measure=3, weight=2) == fit(width=3, weight=2) == (3, 2)
    assert [warning.filename for warning in caught] == [__file__]


@renamed(on="handles")
@dataclass(frozen=True)
class Line:
    handles: tuple[int, ...]


def test_a_class_takes_and_shows_a_former_name() -> None:
    with pytest.warns(DeprecationWarning, match="on= is now called handles="):
        line = Line(on=(1, 2))
    assert line == Line(handles=(1, 2))
    with pytest.warns(DeprecationWarning, match="on is now called handles"):
        assert line.on == (1, 2)


def test_both_names_at_once_are_an_error() -> None:
    with pytest.raises(TypeError, match="width= and its former name measure="):
        fit(width=3, measure=3)


def test_other_keywords_are_refused_as_ever() -> None:
    with pytest.raises(TypeError, match="unexpected keyword"):
        fit(3, wide=3)
