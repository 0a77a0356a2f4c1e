"""The player's model: what it sends, what it refuses, and what a saved notebook keeps."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fontTools.ttLib import TTFont

import vfwidget as vf
from tests.export.test_page import HOSTILE, Page
from tests.motion.films import film
from vfwidget.view.film import describe_film
from vfwidget.view.player import PAGE_TRAITS, STATE


@pytest.fixture(scope="module")
def animation() -> vf.Animation:
    return film("dynapuff", "hi", frames=7)


@pytest.fixture
def player(animation: vf.Animation) -> vf.Player:
    return vf.Player(animation, onion=2)


def test_the_view_receives_every_frame(player: vf.Player) -> None:
    animation, sent = player.animation, describe_film(player.animation)
    assert player._film == sent and player._word["string"] == "hi"
    assert sent["times"] == pytest.approx(np.linspace(0, 1.5, 7))
    axes = np.frombuffer(sent["axes"], "<f4").reshape(7, 2, 2)
    for number in (0, 6):
        expected = [list(values.values()) for values in animation[number].axes]
        assert axes[number] == pytest.approx(np.array(expected), rel=1e-6)
    offsets = np.frombuffer(sent["offsets"], "<f4").reshape(7, 2, 2)
    np.testing.assert_allclose(offsets, animation.offsets, rtol=1e-6)
    assert len(sent["obstacles"]) == 7 and sent["scene"] == list(range(7))


def test_an_obstacle_at_rest_is_sent_once(animation: vf.Animation) -> None:
    moving = animation
    still = vf.Animation(moving.text, moving.times, moving.theta, scenery=[moving.scenery[0]] * 7)
    sent = describe_film(still)
    assert len(sent["obstacles"]) == 1 and sent["scene"] == [0] * 7


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("animation", "hi", "shows an Animation; received str"),
        ("speed", 0, "speed must be a finite number"),
        ("speed", float("nan"), "speed must be a finite number"),
        ("onion", -1, "onion must be a whole number"),
        ("onion", 1.5, "onion must be a whole number"),
        ("onion", 21, "onion must be a whole number"),
        ("time", 99, "time must be a finite number"),
        ("playing", 1, "playing must be True or False"),
        ("height", 3, "height must be"),
    ],
)
def test_a_bad_value_is_refused_and_changes_nothing(
    player: vf.Player, name: str, value: Any, message: str
) -> None:
    before = getattr(player, name)
    with pytest.raises(vf.VFWidgetError, match=message):
        setattr(player, name, value)
    assert getattr(player, name) is before
    if name != "time":
        given = {"animation": player.animation, name: value}
        with pytest.raises(vf.VFWidgetError, match=message):
            vf.Player(given.pop("animation"), **given)


@pytest.mark.parametrize(
    "message",
    [
        {"speed": "fast"},
        {"speed": True},
        {"time": None},
        {"playing": {}},
        {"playing": 0},
        {"onion": [1]},
        {"onion": False},
        {"loop": 3},
        {"loop": 1},
        {"height": float("nan")},
        {"height": 400},
        {"_word": {}},
    ],
)
def test_a_bad_message_of_the_view_is_said_and_undone(
    player: vf.Player, message: dict[str, Any]
) -> None:
    (name,) = message
    before = getattr(player, name)
    player.set_state(message)
    assert getattr(player, name) == before and type(getattr(player, name)) is type(before)
    assert name in player.error
    player.set_state({"speed": 2})
    assert player.speed == 2 and player.error == ""


@pytest.mark.parametrize("message", [None, 5, "ab", [1, 2]])
def test_a_message_that_holds_no_state_is_refused(player: vf.Player, message: Any) -> None:
    before = player.get_state(PAGE_TRAITS)
    player.set_state(message)
    assert player.error
    assert player.get_state(PAGE_TRAITS) == before


def test_another_animation_may_be_shown(player: vf.Player) -> None:
    player.time = 1.0
    player.animation = film("dynapuff", "hop", frames=3)
    assert player._word["string"] == "hop" and len(player._film["times"]) == 3
    assert player.time == 0
    player.play()
    assert player.playing
    player.pause()
    assert not player.playing


def test_a_misspelt_option_is_named(player: vf.Player) -> None:
    with pytest.raises(TypeError, match=r"Player has no option 'sped'; did you mean 'speed'\?"):
        vf.Player(player.animation, sped=1)


def test_the_page_holds_the_state(player: vf.Player) -> None:
    made = Page(player.to_html())
    (kind,) = [a["type"] for tag, a in made.elements if tag == "script" and a["type"] != "module"]
    assert kind == STATE
    assert not any({"src", "href"} & set(attributes) for _, attributes in made.elements)


def test_hostile_names_are_inert(player: vf.Player) -> None:
    font = TTFont(Path(vf.__file__).parent / "fonts" / "dynapuff.woff2")
    for record in font["name"].names:
        record.string = HOSTILE
    bad = vf.Player(film(vf.load_font(font), "h<", frames=3))
    assert Page(bad.to_html()).tags == Page(player.to_html()).tags
    picture = bad._picture.bundle()["text/html"]
    assert Page(picture).tags == ["div", "img", "p"]


def test_the_poster_shows_a_frame_as_drawn(player: vf.Player) -> None:
    picture = player._picture.bundle()
    assert "Run the cell to play it." in picture["text/html"]
    last = player.animation.to_svg().split('class="still">')[1]
    shown = re.findall(' d="(.*?)"', picture["image/svg+xml"])
    assert shown == re.findall(' d="(.*?)"', last)
    player.time = 0.5
    assert player._picture.bundle() != picture
