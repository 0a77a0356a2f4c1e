"""The minimum of linear residuals and distances under inequalities; scipy is the referee."""

import numpy as np
import pytest
from scipy.optimize import minimize

from vfwidget.overlap.inequalities import WALL, Model, Walls


def model(seed: int) -> Model:
    """A model with up to 12 unknowns, 2 residuals and 4 inequalities.

    Two inequalities are nearly equal, unless there is one only. About half of the models with
    residuals have distances that count for some unknowns only. In a third of them, inequalities
    are steep, as those of slivers, and some are met at the start.
    """
    rng = np.random.default_rng(seed)
    n, rows, count = rng.integers(1, 13), rng.integers(0, 3), rng.integers(1, 5)
    jacobian, slopes = 30 * rng.normal(size=(rows, n)), 30 * rng.normal(size=(count, n))
    slopes[-1] = slopes[0] * 1.001
    least, most = np.full(n, -1.0), np.full(n, 1.0)
    # Some unknowns start at a bound, and some are in a cell between kinks.
    x = rng.choice([-1.0, 0.0, 0.5, 1.0], n)
    lower, upper = np.where(x > 0, 0.0, least), np.where(x < 0, 0.0, most)
    depths = rng.uniform(0, 5, count)
    if seed % 3 == 2:
        slopes *= 10 ** rng.uniform(0, 2.5, (count, 1))
        depths[rng.random(count) < 0.5] = -1e-9
    walls = Walls(
        np.arange(count), slopes, depths - slopes @ x, depths, np.ones(count), np.full(count, 0.5)
    )
    constant = 100 * rng.normal(size=rows)
    weights = rng.choice([0.0, 1.0], n) if seed % 2 and rows else np.ones(n)
    return Model(
        x, lower, upper, least, most, constant, jacobian, weights, x, walls=walls, own=walls
    )


@pytest.mark.parametrize("seed", range(200))
def test_the_minimum_is_that_of_scipy(seed):
    case = model(seed)

    def cost(x):
        beyond, away = case.walls.beyond(x), x - case.reference
        rows = case.constant + case.jacobian @ x
        value = rows @ rows + WALL * beyond @ beyond + case.weights @ away**2
        slope = rows @ case.jacobian + WALL * beyond @ case.walls.slopes + case.weights * away
        return value, 2 * slope

    found = case.minimum()
    assert (found >= case.lower).all() and (found <= case.upper).all()
    bounds = list(zip(case.lower, case.upper, strict=True))
    options = {"maxiter": 5000, "maxfun": 50000, "ftol": 0, "gtol": 1e-6}
    starts = (case.x, found)
    referee = [minimize(cost, x, jac=True, bounds=bounds, options=options) for x in starts]
    assert cost(found)[0] <= min(result.fun for result in referee) * (1 + 1e-6) + 2e-5
