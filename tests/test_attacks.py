"""No attack makes the package fail: each input is read, or refused with a clear error."""

from __future__ import annotations

import logging
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests import attacks


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("attack", attacks.ATTACKS, ids=lambda attack: attack.__name__)
def test_a_few_inputs_of_each_attack(attack, caplog):
    caplog.set_level(logging.CRITICAL)
    result = attack(max(2, _count(attack) // 400))
    assert result.failures == []
    assert result.tried == result.refused + result.read > 0


@pytest.mark.slow
def test_the_command_prints_a_row_of_the_table():
    """As docs/security.md has it, and not in the process of the tests, which find more modules."""
    command = [sys.executable, "-m", "tests.attacks", "--only", "odd_arrays", "--share", "0.01"]
    root = Path(__file__).parents[1]
    done = subprocess.run(command, cwd=root, capture_output=True, text=True, check=True)
    assert re.search(r"^\| arrays and tensors \| 20 \| \d+ \| \d+ \| 0 \|", done.stdout, re.M)


@pytest.mark.slow
@pytest.mark.timeout(1500)
@pytest.mark.parametrize("attack", attacks.ATTACKS, ids=lambda attack: attack.__name__)
def test_all_inputs_of_each_attack(attack):
    result = attacks.run_apart(attack, _count(attack))
    assert result.holds, result


SHARES = {
    attacks.format_mutants: 20,
    attacks.dense_artwork: 3,
    attacks.junk_for_motion: 5,
    attacks.hostile_names: 5,
}
"""Attacks that take long: the tests try one of so many inputs, and the command tries all."""


def _count(attack):
    return attacks.ATTACKS[attack] // SHARES.get(attack, 1)
