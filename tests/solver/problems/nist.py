"""The nonlinear regressions of NIST's Statistical Reference Datasets.

27 models, two starts each, parameters and residual sums of squares certified to eleven digits.
``nist.json`` holds the numbers as https://www.itl.nist.gov/div898/strd/ publishes them (works of
the US government, free of copyright); the models are written as they are there.

``residual`` takes parameters (..., n), arrays or tensors, and gives residuals (..., m).
"""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from math import pi
from pathlib import Path

import numpy as np

from vfwidget.arrays import like, namespace


def rational(degree, b, x):
    """A quotient of polynomials of one degree; the denominator begins with 1."""
    above = sum(b[i] * x**i for i in range(degree + 1))
    return above / (1 + sum(b[degree + i] * x**i for i in range(1, degree + 1)))


def exponentials(xp, b, x):
    return sum(b[i] * xp.exp(-b[i + 1] * x) for i in range(0, len(b), 2))


def two_peaks(xp, b, x):
    """Two Gaussians on a falling exponential."""
    peaks = (b[i] * xp.exp(-(((x - b[i + 1]) / b[i + 2]) ** 2)) for i in (2, 5))
    return b[0] * xp.exp(-b[1] * x) + sum(peaks)


def chwirut(xp, b, x):
    return xp.exp(-b[0] * x) / (b[1] + b[2] * x)


def cycles(xp, b, x):
    periods = ((12, b[1], b[2]), (b[3], b[4], b[5]), (b[6], b[7], b[8]))
    waves = ((2 * pi * x / period, cosine, sine) for period, cosine, sine in periods)
    return b[0] + sum(cosine * xp.cos(a) + sine * xp.sin(a) for a, cosine, sine in waves)


MODELS = {
    "Misra1a": lambda xp, b, x: b[0] * (1 - xp.exp(-b[1] * x)),
    "Chwirut2": chwirut,
    "Chwirut1": chwirut,
    "Lanczos3": exponentials,
    "Gauss1": two_peaks,
    "Gauss2": two_peaks,
    "DanWood": lambda xp, b, x: b[0] * x ** b[1],
    "Misra1b": lambda xp, b, x: b[0] * (1 - (1 + b[1] * x / 2) ** -2),
    "Kirby2": lambda xp, b, x: rational(2, b, x),
    "Hahn1": lambda xp, b, x: rational(3, b, x),
    "Nelson": lambda xp, b, x: b[0] - b[1] * x[0] * xp.exp(-b[2] * x[1]),
    "MGH17": lambda xp, b, x: b[0] + b[1] * xp.exp(-x * b[3]) + b[2] * xp.exp(-x * b[4]),
    "Lanczos1": exponentials,
    "Lanczos2": exponentials,
    "Gauss3": two_peaks,
    "Misra1c": lambda xp, b, x: b[0] * (1 - (1 + 2 * b[1] * x) ** -0.5),
    "Misra1d": lambda xp, b, x: b[0] * b[1] * x / (1 + b[1] * x),
    "Roszman1": lambda xp, b, x: b[0] - b[1] * x - xp.arctan(b[2] / (x - b[3])) / pi,
    "ENSO": cycles,
    "MGH09": lambda xp, b, x: b[0] * (x**2 + x * b[1]) / (x**2 + x * b[2] + b[3]),
    "Thurber": lambda xp, b, x: rational(3, b, x),
    "BoxBOD": lambda xp, b, x: b[0] * (1 - xp.exp(-b[1] * x)),
    "Rat42": lambda xp, b, x: b[0] / (1 + xp.exp(b[1] - b[2] * x)),
    "MGH10": lambda xp, b, x: b[0] * xp.exp(b[1] / (x + b[2])),
    "Eckerle4": lambda xp, b, x: b[0] / b[1] * xp.exp(-(((x - b[2]) / b[1]) ** 2) / 2),
    "Rat43": lambda xp, b, x: b[0] / (1 + xp.exp(b[1] - b[2] * x)) ** (1 / b[3]),
    "Bennett5": lambda xp, b, x: b[0] * (b[1] + x) ** (-1 / b[2]),
}


@dataclass(frozen=True)
class Regression:
    """A model, what was measured, and the certified answer."""

    name: str
    difficulty: str
    starts: list[list[float]]
    parameters: list[float]
    cost: float
    y: list[float] = field(repr=False)
    x: list[float] | list[list[float]] = field(repr=False)

    def residual(self, b):
        x, y = like(np.array(self.x), b), like(np.array(self.y), b)
        if self.name == "Nelson":
            y = namespace(y).log(y)
        columns = [b[..., i, None] for i in range(b.shape[-1])]
        with np.errstate(all="ignore"):
            return MODELS[self.name](namespace(b), columns, x) - y

    def digits(self, b) -> float:
        """The fewest correct significant digits of any parameter."""
        error = np.abs((np.asarray(b) - self.parameters) / self.parameters)
        return float(-np.log10(np.clip(error, 1e-11, None)).min())


REGRESSIONS = {
    name: Regression(name, **entry)
    for name, entry in json.loads(Path(__file__).with_name("nist.json").read_text()).items()
}
