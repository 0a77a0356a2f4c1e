"""A picture of text that is kerned, tracked or set in another way is matched as it is set."""

from __future__ import annotations

import numpy as np
import pytest
from pictures import CLEAN, axis_error, draw, match

import vfwidget as vf
from vfwidget.matching.looks import FITTED

SIZE = (96, 192)
TRACKED = (*FITTED, "tracking")


@pytest.mark.parametrize(
    "options",
    [
        {"features": {"kern": False}},
        {"features": {"kern[0:2]": False}},
        {"tracking": 120},
        {"direction": "rtl"},
    ],
    ids=str,
)
def test_a_text_is_matched_as_it_is_set(options):
    string = "AVA!" if "direction" in options else "AVA"
    text = vf.Text("afacad-flux", string, **options)
    truth = text.at({"wght": 620})
    plain = vf.Text("afacad-flux", string)
    assert [r.x for r in text.layout] != [r.x for r in plain.layout]
    found = vf.match(draw(truth, SIZE), text, progress=False)
    assert found.status == "matched" and axis_error(found, truth) < CLEAN
    assert found.text.composition.options == text.composition.options
    assert found.text.tracking == text.tracking


def test_lengths_are_scaled_to_the_em_of_another_font():
    text = vf.Text("afacad-flux", "a\nb", tracking=50, line_height=1500)
    fonts = "afacad-flux", "roboto-flex"
    units = [vf.load_font(name).units_per_em for name in fonts]
    assert units[0] != units[1]
    for found in vf.match(draw(text, SIZE), text, fonts=fonts, progress=False).ranking:
        em = found.text.font.units_per_em
        assert found.text.tracking == pytest.approx(50 * em / units[0])
        assert found.text.composition.line_height == pytest.approx(1500 * em / units[0])


@pytest.mark.parametrize("tracking", [-30, 60])
@pytest.mark.parametrize("optimizer", ["gauss-newton", "adam"])
def test_tracking_is_fitted(tracking, optimizer):
    truth = vf.Text("afacad-flux", "AVA", axes={"wght": 620}, tracking=tracking)
    picture = draw(truth, SIZE)
    seen = []
    found = match(
        picture,
        "AVA",
        "afacad-flux",
        fit=TRACKED,
        optimizer=optimizer,
        watch=lambda text, loss: seen.append(text.tracking),
    )
    accuracy = 0.5 if optimizer == "gauss-newton" else 10
    assert found.text.tracking == pytest.approx(tracking, abs=accuracy)
    assert seen[-1] == pytest.approx(tracking, abs=accuracy)
    assert f"tracking {found.text.tracking:10.4g}" in found.report()
    assert abs(found.residual).mean() < 0.02
    # Adam does not end at its best state.
    assert min(loss for _, loss in found.history) == pytest.approx(found.loss, rel=1e-6)


def test_tracking_of_letters_with_axes_of_their_own_is_fitted():
    truth = vf.Text("dynapuff", "So", shared=False, tracking=80).at([{"wght": 650}, {"wdth": 85}])
    found = match(draw(truth, (96, 128)), "So", "dynapuff", shared=False, fit=TRACKED)
    assert found.text.tracking == pytest.approx(80, abs=1)
    assert axis_error(found, truth) < CLEAN


def test_a_single_letter_does_not_show_its_tracking():
    truth = vf.Text("dynapuff", "S", axes={"wght": 620})
    found = match(draw(truth, (96, 96)), "S", "dynapuff", fit=TRACKED)
    assert found.status == "matched" and found.text.tracking == 0


def test_looks_take_tracking_among_the_free_blocks():
    text = vf.Text("dynapuff", "So")
    image = draw(text.at(tracking=40), SIZE)
    with pytest.raises(vf.ImageError, match=r"'tracking' cannot be fitted.*free=\['tracking'\]"):
        vf.solve(text, vf.Looks(image, fit=("tracking",)))
    found = vf.solve(text, vf.Looks(image), free=["axes", "tracking"])
    assert found.text.tracking == pytest.approx(40, abs=1)
    assert np.abs(found.theta.numpy()).max() < 0.02
