"""Texts, handles and terms that are pickled apart belong together."""

from __future__ import annotations

import pickle
import subprocess
import sys

import torch

import vfwidget as vf

OTHER_PROCESS = """
import pickle, sys
import vfwidget as vf
text, term, handle = map(pickle.loads, pickle.load(sys.stdin.buffer))
assert term.handle == handle
print(vf.solve(text, [term, vf.StayClose()]).cost)
"""


def test_a_text_and_its_terms_may_be_pickled_apart() -> None:
    text = vf.Text("dynapuff", "no", shared=False)
    handle = text.nearest(100, 300)
    x, y = text.position(handle).tolist()
    term = vf.Target(handle, (x + 30, y))
    found = vf.solve(text, [term, vf.StayClose()])
    data = [pickle.dumps(one) for one in (text, term, handle)]
    twin, other, same = map(pickle.loads, data)
    assert same == handle and hash(same) == hash(handle)
    for one in (text, twin):
        assert torch.equal(vf.solve(one, [other, vf.StayClose()]).theta, found.theta)
    # The same holds in another process, as for the workers of a pool.
    done = subprocess.run(
        [sys.executable, "-c", OTHER_PROCESS],
        input=pickle.dumps(data),
        capture_output=True,
        check=True,
    )
    assert float(done.stdout) == found.cost


def test_texts_that_were_made_twice_stay_apart() -> None:
    text, other = vf.Text("dynapuff", "n"), vf.Text("dynapuff", "n")
    twin = pickle.loads(pickle.dumps(other))
    assert twin.owns(other.nearest(0, 0)) and not twin.owns(text.nearest(0, 0))
