"""The solver on problems with published answers, and from the same starts as scipy."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import scipy.optimize
import torch
from problems.mgh import CASES, Case
from problems.nist import REGRESSIONS

import vfwidget as vf

ITERATIONS = 1000
DIGITS = 4
AT_ITS_BEST = dict(x_scale="jac", xtol=1e-15, ftol=1e-15, gtol=1e-15, max_nfev=ITERATIONS)
LONG = ("Bennett5", "Thurber", "MGH10", "MGH09", "ENSO", "Eckerle4", "MGH17")
"""Regressions that take torch a second or more."""
RUNS = [(name, start) for name in REGRESSIONS for start in (0, 1)]


@cache
def our_digits(name: str, start: int) -> float:
    regression = REGRESSIONS[name]
    found = vf.least_squares(
        regression.residual, regression.starts[start], max_iterations=ITERATIONS
    )
    return regression.digits(found.x)


@cache
def scipy_digits(name: str, start: int, method: str) -> float:
    """Of scipy at its best, which has exact derivatives too, by complex steps."""
    regression = REGRESSIONS[name]

    def jacobian(b):
        steps = 1e-30j * np.eye(len(b))
        return regression.residual(b + steps).imag.T / 1e-30

    with np.errstate(all="ignore"):
        found = scipy.optimize.least_squares(
            regression.residual, regression.starts[start], jacobian, method=method, **AT_ITS_BEST
        )
    return regression.digits(found.x)


@pytest.mark.parametrize("name", REGRESSIONS)
def test_the_models_are_those_of_nist(name: str) -> None:
    regression = REGRESSIONS[name]
    cost = (regression.residual(np.array(regression.parameters)) ** 2).sum()
    # Lanczos 1 is without noise: parameters of eleven digits leave more than its own 1e-25.
    assert cost == pytest.approx(regression.cost, rel=1e-9, abs=1e-20)


@pytest.mark.parametrize(("name", "start"), RUNS)
def test_parameters_are_found_wherever_scipy_finds_them(name: str, start: int) -> None:
    theirs = max(scipy_digits(name, start, method) for method in ("lm", "trf"))
    assert our_digits(name, start) >= DIGITS or theirs < DIGITS


def test_no_method_of_scipys_solves_more_regressions() -> None:
    ours = [run for run in RUNS if our_digits(*run) >= DIGITS]
    for method in ("lm", "trf"):
        assert len(ours) >= sum(scipy_digits(*run, method) >= DIGITS for run in RUNS)


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=[pytest.mark.slow] * (n in LONG)) for n in REGRESSIONS]
)
def test_tensors_and_both_starts_at_once(name: str) -> None:
    regression = REGRESSIONS[name]
    starts = torch.tensor(regression.starts, dtype=torch.float64)
    found = vf.least_squares(regression.residual, starts, max_iterations=ITERATIONS)
    # Derivatives are exact here.
    digits = [regression.digits(x) for x in found.x]
    assert min(digits) >= DIGITS + 2


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_the_known_cost_is_reached_within_the_bounds(case: Case) -> None:
    found = vf.least_squares(
        case.residual, case.start, bounds=case.bounds, max_iterations=ITERATIONS
    )
    assert found.cost <= case.cost * (1 + 1e-5) + 1e-15
    if case.bounds is not None:
        lower, upper = case.bounds
        assert (found.x >= lower).all() and (found.x <= upper).all()


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_tensors_reach_it_too(case: Case) -> None:
    start = torch.tensor(case.start, dtype=torch.float64)
    found = vf.least_squares(case.residual, start, bounds=case.bounds, max_iterations=ITERATIONS)
    assert found.cost <= case.cost * (1 + 1e-5) + 1e-15


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_arrays_tensors_and_batches_give_one_residual(case: Case) -> None:
    x = np.array(case.start, dtype=float)
    points = np.stack([x, 0.9 * x + 0.01])
    rows = np.stack([case.residual(point) for point in points])
    assert case.residual(points) == pytest.approx(rows, rel=1e-12, abs=1e-12)
    tensors = case.residual(torch.tensor(points)).numpy()
    assert tensors == pytest.approx(rows, rel=1e-12, abs=1e-12)
