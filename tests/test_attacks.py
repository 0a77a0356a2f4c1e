"""No attack makes the package fail: each input is read, or refused with a clear error."""

from __future__ import annotations

import logging

import pytest

from tests import attacks


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("attack", attacks.ATTACKS, ids=lambda attack: attack.__name__)
def test_a_few_inputs_of_each_attack(attack, caplog):
    caplog.set_level(logging.CRITICAL)
    result = attack(max(4, _count(attack) // 400))
    assert result.failures == []
    assert result.tried == result.refused + result.read > 0


@pytest.mark.slow
@pytest.mark.timeout(1500)
@pytest.mark.parametrize("attack", attacks.ATTACKS, ids=lambda attack: attack.__name__)
def test_all_inputs_of_each_attack(attack):
    result = attacks.run_apart(attack, _count(attack))
    assert result.holds, result


def _count(attack):
    """How many inputs to try; the command tries all of those that take long."""
    return attacks.ATTACKS[attack] // (20 if attack is attacks.format_mutants else 1)
