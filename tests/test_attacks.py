"""No attack makes the package fail: each input is read, or refused with a clear error."""

from __future__ import annotations

import logging

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
