"""The test problems of Moré, Garbow and Hillstrom, free and bounded.

J. J. Moré, B. S. Garbow, K. E. Hillstrom, "Testing unconstrained optimization software", ACM
Transactions on Mathematical Software 7 (1981): functions in the order and notation given there.
``mgh.json`` holds starts, measurements, bounds and least known costs, and says where each is from.

``residual`` takes points (..., n), arrays or tensors, and gives residuals (..., m).
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from math import exp, pi, prod
from pathlib import Path

import numpy as np

from vfwidget.arrays import like, namespace

TABLE = json.loads(Path(__file__).with_name("mgh.json").read_text())
DATA = {name: np.array(values) for name, values in TABLE["measured"].items()}


def count(first, last, x):
    """The whole numbers from first to last as an array of the kind of x."""
    return like(np.arange(first, last + 1.0), x)


def columns(x):
    return [x[..., i, None] for i in range(x.shape[-1])]


def total(x):
    return x.sum(-1)[..., None]


def rosenbrock(xp, x):
    return 10 * (x[..., 1::2] - x[..., ::2] ** 2), 1 - x[..., ::2]


def freudenstein_roth(xp, x):
    a, b = columns(x)
    return -13 + a + ((5 - b) * b - 2) * b, -29 + a + ((b + 1) * b - 14) * b


def powell_badly_scaled(xp, x):
    a, b = columns(x)
    return 1e4 * a * b - 1, xp.exp(-a) + xp.exp(-b) - 1.0001


def brown_badly_scaled(xp, x):
    a, b = columns(x)
    return a - 1e6, b - 2e-6, a * b - 2


def beale(xp, x):
    a, b = columns(x)
    return 1.5 - a * (1 - b), 2.25 - a * (1 - b**2), 2.625 - a * (1 - b**3)


def jennrich_sampson(xp, x):
    i = count(1, 10, x)
    a, b = columns(x)
    return (2 + 2 * i - (xp.exp(i * a) + xp.exp(i * b)),)


def helical_valley(xp, x):
    a, b, c = columns(x)
    turn = xp.arctan(b / a) / (2 * pi) + xp.where(a < 0, 0.5, 0.0)
    return 10 * (c - 10 * turn), 10 * (xp.sqrt(a**2 + b**2) - 1), c


def bard(xp, x):
    u, v = count(1, 15, x), 16 - count(1, 15, x)
    a, b, c = columns(x)
    return (like(DATA["bard"], x) - (a + u / (v * b + xp.minimum(u, v) * c)),)


def gaussian(xp, x):
    t = (8 - count(1, 15, x)) / 2
    a, b, c = columns(x)
    return (a * xp.exp(-b * (t - c) ** 2 / 2) - like(DATA["gaussian"], x),)


def meyer(xp, x):
    t = 45 + 5 * count(1, 16, x)
    a, b, c = columns(x)
    return (a * xp.exp(b / (t + c)) - like(DATA["meyer"], x),)


def gulf(xp, x, m):
    # The paper prints the product of y, m, i and x2 for y - x2; only this has its answer.
    t = count(1, m, x) / 100
    a, b, c = columns(x)
    return (xp.exp(-(abs(25 + (-50 * xp.log(t)) ** (2 / 3) - b) ** c) / a) - t,)


def box(xp, x, m):
    t = count(1, m, x) / 10
    a, b, c = columns(x)
    return (xp.exp(-t * a) - xp.exp(-t * b) - c * (xp.exp(-t) - xp.exp(-10 * t)),)


def powell_singular(xp, x):
    a, b, c, d = (x[..., i::4] for i in range(4))
    return a + 10 * b, 5**0.5 * (c - d), (b - 2 * c) ** 2, 10**0.5 * (a - d) ** 2


def wood(xp, x):
    a, b, c, d = columns(x)
    rosenbrocks = 10 * (b - a**2), 1 - a, 90**0.5 * (d - c**2), 1 - c
    return *rosenbrocks, 10**0.5 * (b + d - 2), 10**-0.5 * (b - d)


def kowalik_osborne(xp, x):
    u, y = like(DATA["kowalik_osborne"], x)
    a, b, c, d = columns(x)
    return (y - a * (u**2 + u * b) / (u**2 + u * c + d),)


def brown_dennis(xp, x):
    t = count(1, 20, x) / 5
    a, b, c, d = columns(x)
    return ((a + t * b - xp.exp(t)) ** 2 + (c + d * xp.sin(t) - xp.cos(t)) ** 2,)


def osborne_1(xp, x):
    t = 10 * count(0, 32, x)
    a, b, c, d, e = columns(x)
    return (like(DATA["osborne_1"], x) - (a + b * xp.exp(-t * d) + c * xp.exp(-t * e)),)


def biggs(xp, x):
    t = count(1, 13, x) / 10
    y = xp.exp(-t) - 5 * xp.exp(-10 * t) + 3 * xp.exp(-4 * t)
    a, b, c, d, e, f = columns(x)
    return (c * xp.exp(-t * a) - d * xp.exp(-t * b) + f * xp.exp(-t * e) - y,)


def osborne_2(xp, x):
    t = count(0, 64, x) / 10
    a = columns(x)
    peaks = sum(a[i] * xp.exp(-((t - a[i + 7]) ** 2) * a[i + 4]) for i in (1, 2, 3))
    return (like(DATA["osborne_2"], x) - a[0] * xp.exp(-t * a[4]) - peaks,)


def watson(xp, x):
    j, t = count(0, x.shape[-1] - 1, x), count(1, 29, x)[:, None] / 29
    values, slopes = x @ (t**j).T, x[..., 1:] @ (j[1:] * t ** j[:-1]).T
    a, b = columns(x)[:2]
    return slopes - values**2 - 1, a, b - a**2 - 1


def penalty_1(xp, x):
    return 1e-5**0.5 * (x - 1), total(x**2) - 0.25


def penalty_2(xp, x):
    n = x.shape[-1]
    i = count(1, n, x)
    excess, single = xp.exp(x / 10) - xp.exp(i / 10), xp.exp(x[..., 1:] / 10) - exp(-0.1)
    pairs = excess[..., 1:] + excess[..., :-1]
    last = total((n + 1 - i) * x**2) - 1
    return x[..., :1] - 0.2, 1e-5**0.5 * pairs, 1e-5**0.5 * single, last


def variably_dimensioned(xp, x):
    s = total(count(1, x.shape[-1], x) * (x - 1))
    return x - 1, s, s**2


def trigonometric(xp, x):
    n = x.shape[-1]
    return (n - total(xp.cos(x)) + count(1, n, x) * (1 - xp.cos(x)) - xp.sin(x),)


def brown_almost_linear(xp, x):
    return x[..., :-1] + total(x) - (x.shape[-1] + 1), prod(columns(x)) - 1


def discrete_boundary_value(xp, x):
    h = 1 / (x.shape[-1] + 1)
    t = h * count(1, x.shape[-1], x)
    edge = xp.zeros_like(x[..., :1])
    left, right = xp.concatenate([edge, x[..., :-1]], -1), xp.concatenate([x[..., 1:], edge], -1)
    return (2 * x - left - right + h**2 * (x + t + 1) ** 3 / 2,)


def discrete_integral(xp, x):
    h = 1 / (x.shape[-1] + 1)
    t = h * count(1, x.shape[-1], x)
    kernel = xp.minimum(t[:, None], t) * (1 - xp.maximum(t[:, None], t))
    return (x + h / 2 * (x + t + 1) ** 3 @ kernel,)


def broyden_tridiagonal(xp, x):
    edge = xp.zeros_like(x[..., :1])
    left, right = xp.concatenate([edge, x[..., :-1]], -1), xp.concatenate([x[..., 1:], edge], -1)
    return ((3 - 2 * x) * x - left - 2 * right + 1,)


def broyden_banded(xp, x):
    i = np.arange(x.shape[-1])
    ahead = i - i[:, None]
    band = like((ahead >= -5.0) & (ahead <= 1) & (ahead != 0), x)
    return (x * (2 + 5 * x**2) + 1 - (x * (1 + x)) @ band.T,)


def linear_full_rank(xp, x, m):
    mean = 2 / m * total(x)
    return x - mean - 1, -mean - 1 + xp.zeros_like(count(x.shape[-1] + 1, m, x))


def linear_rank_1(xp, x, m):
    return (count(1, m, x) * total(count(1, x.shape[-1], x) * x) - 1,)


def linear_rank_1_with_zeros(xp, x, m):
    inner = total(count(2, x.shape[-1] - 1, x) * x[..., 1:-1])
    return count(1, m - 2, x) * inner - 1, 0 * x[..., :2] - 1


def chebyquad(xp, x):
    before, now, parts = 1 + 0 * x, 2 * x - 1, []
    for i in range(1, x.shape[-1] + 1):
        parts.append(total(now) / x.shape[-1] + (1 / (i**2 - 1) if i % 2 == 0 else 0))
        before, now = now, 2 * (2 * x - 1) * now - before
    return parts


@dataclass(frozen=True)
class Case:
    """A function, a start, bounds perhaps, and the least cost known to be reached from there."""

    function: str
    start: list[float]
    cost: float
    source: str
    m: int | None = None
    lower: list[float] | None = None
    upper: list[float] | None = None

    @property
    def name(self) -> str:
        size = len(self.start) if self.m is None else f"{len(self.start)}x{self.m}"
        return f"{self.function}-{size}{'' if self.lower is None else '-bounded'}"

    @property
    def bounds(self) -> tuple[list[float], list[float]] | None:
        return None if self.lower is None else (self.lower, self.upper)

    def residual(self, x):
        xp = namespace(x)
        sizes = () if self.m is None else (self.m,)
        with np.errstate(all="ignore"):
            return xp.concatenate([*globals()[self.function](xp, x, *sizes)], -1)


CASES = [Case(**case) for case in TABLE["cases"]]
