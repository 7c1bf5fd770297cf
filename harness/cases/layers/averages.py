"""Means over seeds, the one test of a difference, limits by several models, the fit over thickness.

Intervals are of 95 %, Student's t. The seed is the unit: it decides base, sizes and places.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy import stats
from scipy.optimize import curve_fit

from harness.errors import RequestError

CONFIDENCE = 0.95

MARGIN_DEG = 0.3
"""Differences within it count as none: what the angles are asked to be known to."""

Word = Literal["the same", "differs", "undecided"]

FEW = 4
"""Seeds below which the scatter of a box is not taken from its own seeds alone."""

BOX_POWERS = (1.0, 2.0, 3.0)
"""Models of a box: the angle is linear in 1/length to one of these powers."""

RATE_POWERS = (1.0, 0.5)
"""Models of the rate of lowering: linear in it, or in its root."""

REJECTED = 0.05
"""A model whose chi-squared is exceeded by chance less often than this is left out."""


@dataclass(frozen=True)
class Mean:
    """A mean over ``count`` seeds with the half width of its 95 % interval; ``scatter`` of one.

    ``freedom``: degrees of freedom by which the scatter is known.
    """

    value: float
    half_width: float
    count: int
    scatter: float = math.nan
    freedom: float = math.nan

    @property
    def low(self) -> float:
        """Return the lower end of the interval."""
        return self.value - self.half_width

    @property
    def high(self) -> float:
        """Return the upper end of the interval."""
        return self.value + self.half_width

    @property
    def word(self) -> Word:
        """Return what the test says of a difference."""
        if self.low >= -MARGIN_DEG and self.high <= MARGIN_DEG:
            return "the same"
        return "differs" if self.low > 0.0 or self.high < 0.0 else "undecided"


def _quantile(freedom: float) -> float:
    return float(stats.t.ppf(0.5 + CONFIDENCE / 2, freedom))


def mean_of(values: Sequence[float]) -> Mean:
    """Return the mean of values with its interval; NaN where fewer than two leave none."""
    data = np.asarray(values, dtype=float)
    count = len(data)
    if count < 2:
        return Mean(float(data.mean()) if count else math.nan, math.nan, count)
    scatter = float(data.std(ddof=1))
    half = _quantile(count - 1) * scatter / math.sqrt(count)
    return Mean(float(data.mean()), half, count, scatter, count - 1.0)


def paired_difference(first: Mapping[int, float], second: Mapping[int, float]) -> Mean:
    """Return the mean of ``first`` minus ``second``, paired by the seeds that both have."""
    return mean_of([first[seed] - second[seed] for seed in sorted(set(first) & set(second))])


def welch(first: Mean, second: Mean) -> Mean:
    """Return the difference of the means of independent samples, with Welch's interval."""
    parts = [mean.scatter**2 / mean.count for mean in (first, second)]
    variance, count = sum(parts), min(first.count, second.count)
    value = first.value - second.value
    if not variance > 0.0:  # no scatter at all, or none that is known
        return Mean(value, variance, count)
    below = sum(part**2 / mean.freedom for part, mean in zip(parts, (first, second), strict=True))
    return Mean(value, _quantile(variance**2 / below) * math.sqrt(variance), count)


def with_scatter_of(mean: Mean, smaller: Mean) -> Mean:
    """Return the mean of a box of few seeds with the scatter of a smaller box, if that is more.

    A larger box averages over more grains and scatters less; of a handful of seeds the scatter is
    hardly known.
    """
    scatter = mean.scatter if mean.count > 1 else 0.0
    if mean.count >= FEW or smaller.count <= mean.count or scatter > smaller.scatter:
        return mean
    half = _quantile(smaller.freedom) * smaller.scatter / math.sqrt(mean.count)
    return Mean(mean.value, half, mean.count, smaller.scatter, smaller.freedom)


@dataclass(frozen=True)
class Model:
    """theta = limit + slope x^power through means; ``chance`` of a larger chi-squared."""

    power: float
    limit: Mean
    slope: float
    chance: float

    def curve(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the angle [deg] at x, same shape."""
        return self.limit.value + self.slope * x**self.power


@dataclass(frozen=True)
class ModelLimit:
    """The value at x = 0 of several models; those that the means do not reject count."""

    models: tuple[Model, ...]

    @property
    def kept(self) -> tuple[Model, ...]:
        """Return the models that are not rejected; all where every one is."""
        return tuple(model for model in self.models if model.chance >= REJECTED) or self.models

    @property
    def mean(self) -> Mean:
        """Return the middle of the intervals of the models that count, and half their range."""
        return covering([model.limit for model in self.kept])


def covering(means: Sequence[Mean]) -> Mean:
    """Return the interval that holds those of all means: the distance between them is in it."""
    low, high = min(mean.low for mean in means), max(mean.high for mean in means)
    return Mean(0.5 * (low + high), 0.5 * (high - low), min(mean.count for mean in means))


def limit_of(means: Mapping[float, Mean], powers: Sequence[float]) -> ModelLimit:
    """Return the limit at x = 0 of means by x, by lines in x to each power.

    Raise RequestError for fewer than three: two would always lie on a line.
    """
    if len(means) < 3:
        raise RequestError(f"an extrapolation needs three values, {len(means)} are there")
    return ModelLimit(tuple(_model(means, power) for power in powers))


def _model(means: Mapping[float, Mean], power: float) -> Model:
    x = np.array([*means]) ** power
    values = np.array([mean.value for mean in means.values()])
    normal = float(stats.norm.ppf(0.5 + CONFIDENCE / 2))
    # t over the normal quantile: what few seeds do not know of their scatter is in the error
    errors = np.maximum([mean.half_width / normal for mean in means.values()], 1e-4)
    (slope, limit), covariance = np.polyfit(x, values, 1, w=1.0 / errors, cov="unscaled")
    squares = float(np.sum(((limit + slope * x - values) / errors) ** 2))
    least = min(mean.count for mean in means.values())
    half = normal * math.sqrt(covariance[1, 1])
    chance = float(stats.chi2.sf(squares, len(x) - 2))
    return Model(power, Mean(float(limit), half, least), float(slope), chance)


@dataclass(frozen=True)
class Fit:
    """theta(h) = limit + amplitude h^-exponent of layers in equal boxes, limits by covariance."""

    limit: Mean
    amplitude: float
    exponent: Mean

    def curve(self, layers: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the fitted angle [deg] at a thickness, same shape."""
        return self.limit.value + self.amplitude * layers**-self.exponent.value


def fit_over_thickness(means: Mapping[int, Mean]) -> Fit:
    """Return the finite-size fit to mean angles [deg] by the number of layers, in equal boxes.

    Raise RequestError for fewer than five thicknesses (three unknowns nearly fit any four), and
    for means that no such law fits.
    """
    if len(means) < 5:
        raise RequestError(f"layers: a fit needs five thicknesses, {len(means)} are there")
    layers = np.array(sorted(means), dtype=float)
    listed = [means[int(h)] for h in layers]
    values = np.array([mean.value for mean in listed])
    errors = np.maximum([mean.half_width / 1.96 for mean in listed], 1e-4)
    start = (values.min(), np.ptp(values), 0.7)
    try:
        best, covariance = curve_fit(
            lambda h, limit, amplitude, exponent: limit + amplitude * h**-exponent,
            layers, values, start, errors, absolute_sigma=True,
        )  # fmt: skip
    except RuntimeError:
        raise RequestError("layers: no law limit + amplitude h^-exponent fits") from None
    half = _quantile(len(layers) - 3) * np.sqrt(np.diag(covariance))
    least = min(mean.count for mean in listed)
    limit, amplitude, exponent = (float(value) for value in best)
    return Fit(Mean(limit, float(half[0]), least), amplitude, Mean(exponent, float(half[2]), least))
