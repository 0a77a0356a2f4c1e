"""The editor with overlaps avoided, without a browser."""

from __future__ import annotations

import pytest

import vfwidget as vf

WORD = vf.Text("roboto-flex", "l")
RIGHT = float(WORD.segments()[0][..., 0].max())
BAR = [(RIGHT + 60, 100), (RIGHT + 70, 100), (RIGHT + 70, 900), (RIGHT + 60, 900)]


def send(editor, phase, x):
    """One drag message, from the right side of the stem; its answer."""
    answers = []
    editor.send = lambda message, *_: answers.append(message)
    handle = WORD.nearest(RIGHT, 500)
    place = [handle.glyph, handle.contour, handle.segment, handle.t]
    message = {"type": "drag", "view": "v", "seq": 1, "gesture": "g", "phase": phase}
    editor._receive(editor, {**message, "handle": place, "x": x, "y": 500.0}, [])
    return answers[0]


def test_a_drag_stops_at_an_obstacle_and_names_the_contact():
    editor = vf.Editor(WORD, obstacles=[BAR], avoid_overlaps=True)
    send(editor, "down", RIGHT)
    answer = send(editor, "move", RIGHT + 250)
    assert answer["ok"] and answer["status"] == "unreachable"
    assert vf.overlaps(editor.text, [BAR]) == []
    assert answer["contacts"]
    assert RIGHT + 50 < float(editor.text.segments()[0][..., 0].max()) < RIGHT + 61
    editor.avoid_overlaps = False
    assert send(editor, "up", RIGHT + 250)["contacts"] == []
    assert vf.overlaps(editor.text, [BAR])


def test_letters_that_are_tied_together_make_room_together():
    axes = [{"wght": weight} for weight in (300, 300, 900, 100)]
    text = vf.Text("roboto-flex", "noon", axes=axes, shared=False, tracking=40)
    right = float(text.points()[:, 0].max())
    bar = [(right + 15, -3000), (right + 75, -3000), (right + 75, 3000), (right + 15, 3000)]
    editor = vf.Editor(text, obstacles=[bar], avoid_overlaps=True)
    # The view gives all letters of the range the axes of the third one, and the last hits the bar.
    equal = [text.axes[2]] * 4
    assert vf.overlaps(text.at(axes=equal), [bar])
    tip = text.handle(glyph=2, contour=0, segment=3, t=0.5)
    x, y = text.at(axes=equal).position(tip).tolist()
    place = [tip.glyph, tip.contour, tip.segment, tip.t]
    message = {"type": "drag", "view": "v", "gesture": "g", "range": [0, 3], "axes": equal}
    message |= {"handle": place, "y": y}
    reached = []
    for seq, (phase, left) in enumerate((("down", 0), ("move", 15), ("move", 30))):
        editor._receive(editor, {**message, "seq": seq, "phase": phase, "x": x - left}, [])
        assert vf.overlaps(editor.text, [bar]) == []
        assert all(own == editor.axes[0] for own in editor.axes)
        reached.append(float(editor.text.position(tip)[0]))
    # Room makes the letters narrower, and the point goes on to the pointer as far as it can.
    assert reached[0] > reached[1] + 15 > reached[2] + 15 > x


def test_the_switch_makes_room_as_one_step():
    editor = vf.Editor(WORD, obstacles=[BAR])
    send(editor, "down", RIGHT)
    send(editor, "up", RIGHT + 200)
    steps = len(editor.history)
    editor.set_state({"avoid_overlaps": True})
    assert sum(overlap.area for overlap in vf.overlaps(editor.text, [BAR])) <= 1e-3
    assert editor.error == ""
    assert len(editor.history) == steps + 1


def test_a_crowded_word_says_so():
    everywhere = [(-9000, -9000), (9000, -9000), (9000, 9000), (-9000, 9000)]
    editor = vf.Editor(vf.Text("dynapuff", "o"), obstacles=[everywhere], avoid_overlaps=True)
    assert "no axis values were found" in editor.error


def test_a_crowded_word_says_so_for_as_long_as_it_is_crowded():
    everywhere = [(-9000, -9000), (9000, -9000), (9000, 9000), (-9000, 9000)]
    editor = vf.Editor(WORD, obstacles=[everywhere], avoid_overlaps=True)
    for phase, by in (("down", 0), ("move", 40), ("up", 60), ("down", 0)):
        answer = send(editor, phase, RIGHT + by)
        assert answer["ok"] and vf.overlaps(editor.text, everywhere)
        assert "no axis values were found" in editor.error
    editor.undo()
    assert vf.overlaps(editor.text, everywhere) and editor.error
    # With other locks there might be room, but there is none.
    editor.locks = ["slnt"]
    assert editor.error
    editor.avoid_overlaps = False
    assert editor.error == ""
    editor.avoid_overlaps = True
    assert editor.error
    editor.text = WORD.at(offsets=[(20_000, 0)])
    assert vf.overlaps(editor.text, everywhere) == [] and editor.error == ""


def test_crowded_letters_give_way_when_an_axis_is_unlocked():
    text = vf.Text("roboto-flex", "HH", shared=False).at(offsets=[(0, 0), (-900, 0)])
    tags = [axis.tag for axis in text.font.axes]
    editor = vf.Editor(text, locks=tags, avoid_overlaps=True)
    assert vf.overlaps(editor.text) and "no axis values were found" in editor.error
    steps = len(editor.history)
    editor.set_state({"locks": []})
    assert vf.overlaps(editor.text) == [] and editor.error == ""
    assert len(editor.history) == steps + 1
    editor.undo()
    assert vf.overlaps(editor.text) and editor.locks == tags


def test_obstacles_are_checked_and_drawn():
    editor = vf.Editor(WORD, obstacles=BAR)
    assert editor._obstacles.startswith("M")
    assert editor._obstacles in editor.to_html()
    with pytest.raises(vf.OverlapError, match="must be finite"):
        editor.obstacles = [[(0, 0), (1, float("nan")), (2, 0)]]
    assert editor.obstacles == BAR
    editor.obstacles = ()
    assert editor._obstacles == ""


@pytest.mark.parametrize("wrong", [7, "a string", [7], [None], {"a": 1}, [[(0, 0), (1e300, 0)]]])
def test_wrong_obstacles_are_refused_and_the_former_ones_stay(wrong):
    editor = vf.Editor(WORD, obstacles=[BAR], avoid_overlaps=True)
    drawn = editor._obstacles
    with pytest.raises(vf.OverlapError):
        editor.obstacles = wrong
    assert editor.obstacles == [BAR] and editor._obstacles == drawn


def test_obstacles_that_change_in_a_drag():
    editor = vf.Editor(WORD, avoid_overlaps=True)
    send(editor, "down", RIGHT)
    editor.obstacles = vf.Artwork(
        f'<svg xmlns="http://www.w3.org/2000/svg"><rect x="{RIGHT + 60}" y="-900" width="10" '
        'height="800"/></svg>'
    )
    assert send(editor, "move", RIGHT + 250)["contacts"]
    assert vf.overlaps(editor.text, editor.obstacles) == []
    editor.obstacles = ()
    assert send(editor, "up", RIGHT + 250)["contacts"] == []
    assert float(editor.text.segments()[0][..., 0].max()) > RIGHT + 70


def test_a_text_and_a_wall_over_the_whole_word_are_obstacles():
    editor = vf.Editor(WORD, avoid_overlaps=True)
    editor.obstacles = vf.Text("recursive", "x", offsets=[(2000, 0)])
    assert editor.error == ""
    editor.obstacles = [(-9000, -9000), (9000, -9000), (9000, 9000), (-9000, 9000)]
    assert "no axis values were found" in editor.error
    send(editor, "down", RIGHT)
    assert send(editor, "move", RIGHT + 20)["ok"]


def test_letters_give_way_to_artwork_that_is_moved_into_them():
    editor = vf.Editor(WORD, obstacles=[BAR], avoid_overlaps=True)
    weight = editor.axes["wght"]
    # Between drags, each move is one step of the history.
    for closer in (70, 90):
        moved = [(x - closer, y) for x, y in BAR]
        steps = len(editor.history)
        editor.obstacles = [moved]
        assert vf.overlaps(editor.text, [moved]) == [] and editor.error == ""
        assert float(editor.text.segments()[0][..., 0].max()) < moved[0][0] + 0.01
        assert len(editor.history) == steps + 1
    assert editor.axes["wght"] < weight
    # In the middle of a drag, the next event sets out from where the letter has given way.
    send(editor, "down", RIGHT)
    for closer in (95, 100, 105):
        moved = [(x - closer, y) for x, y in BAR]
        editor.obstacles = [moved]
        answer = send(editor, "move", RIGHT + 50)
        assert answer["contacts"] and vf.overlaps(editor.text, [moved]) == []
    editor.obstacles = [BAR]
    assert not send(editor, "move", RIGHT + 30)["contacts"]
