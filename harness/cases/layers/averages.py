"""Means over seeds with their intervals, paired differences, and the fit over the thickness."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar
from scipy.special import stdtrit

from harness.errors import RequestError

RESAMPLES, FITS = 4000, 200
EXPONENTS = (0.05, 4.0)
"""Range of 1/nu in which the fit looks for it."""


@dataclass(frozen=True)
class Mean:
    """A mean over ``count`` seeds with the half width of its 95 % interval; ``scatter`` of one."""

    value: float
    half_width: float
    count: int
    scatter: float = math.nan

    @property
    def low(self) -> float:
        """Return the lower end of the interval."""
        return self.value - self.half_width

    @property
    def high(self) -> float:
        """Return the upper end of the interval."""
        return self.value + self.half_width


def mean_of(values: Sequence[float]) -> Mean:
    """Return the mean of values with its 95 % interval; NaN where fewer than two leave none.

    The interval is the wider of the percentile bootstrap over seeds and Student's t: of a handful
    of seeds the bootstrap alone covers less than it says.
    """
    data = np.asarray(values, dtype=float)
    count = len(data)
    if count < 2:
        return Mean(float(data.mean()) if count else math.nan, math.nan, count)
    scatter = float(data.std(ddof=1))
    student = float(stdtrit(count - 1, 0.975)) * scatter / math.sqrt(count)
    low, high = np.percentile(_resampled(data).mean(axis=1), (2.5, 97.5))
    mean = float(data.mean())
    return Mean(mean, max(student, mean - float(low), float(high) - mean), count, scatter)


def difference_of(one: Mapping[int, float], other: Mapping[int, float]) -> Mean:
    """Return the mean of ``one`` minus ``other``, paired by the seeds that both have."""
    return mean_of([one[seed] - other[seed] for seed in sorted(set(one) & set(other))])


def unpaired(one: Mean, other: Mean) -> Mean:
    """Return the difference of two means whose errors are independent."""
    half = math.hypot(one.half_width, other.half_width)
    return Mean(one.value - other.value, half, min(one.count, other.count))


def extrapolated(x: Sequence[float], means: Sequence[Mean]) -> Mean:
    """Return the value at x = 0 of the weighted line through means, with its 95 % interval.

    Raise RequestError for fewer than three: two would always lie on a line.
    """
    return line_through(x, means)[1]


def line_through(x: Sequence[float], means: Sequence[Mean]) -> tuple[float, Mean]:
    """Return the slope of the weighted line through means, and its value at x = 0.

    Raise RequestError for fewer than three.
    """
    if len(means) < 3:
        raise RequestError(f"an extrapolation needs three values, {len(means)} are there")
    weights = [1.0 / max(one.half_width, 1e-4) for one in means]
    line, covariance = np.polyfit(x, [one.value for one in means], 1, w=weights, cov="unscaled")
    least = min(one.count for one in means)
    return float(line[0]), Mean(float(line[1]), math.sqrt(covariance[1, 1]), least)


@dataclass(frozen=True)
class Fit:
    """theta(h) = limit + amplitude h^-exponent, with 95 % intervals.

    They are those of fits to means drawn from their own intervals.
    """

    limit: float
    amplitude: float
    exponent: float
    limit_interval: tuple[float, float]
    exponent_interval: tuple[float, float]

    def curve(self, layers: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the fitted angle [deg] at a thickness, same shape."""
        return self.limit + self.amplitude * layers**-self.exponent


def fit_over_thickness(angles: Mapping[int, Sequence[float]]) -> Fit:
    """Return the finite-size fit to angles [deg] of seeds, by the number of layers.

    Raise RequestError for fewer than four thicknesses: three unknowns would fit any three.
    """
    layers = np.array(sorted(angles), dtype=float)
    if len(layers) < 4:
        raise RequestError(f"layers: a fit needs four thicknesses, {len(layers)} are there")
    means = [mean_of(angles[int(h)]) for h in layers]
    # of values that are all the same, as of one seed without disorder, nothing is known of errors
    errors = np.maximum([one.half_width / 1.96 for one in means], 1e-4)
    values = np.array([one.value for one in means])
    best = _least_squares(layers, values, 1.0 / errors)
    drawn = np.random.default_rng(0).normal(values, errors, (FITS, len(layers)))
    again = np.array([_least_squares(layers, row, 1.0 / errors) for row in drawn])
    low, high = np.percentile(again, (2.5, 97.5), axis=0)
    ends = [(float(a), float(b)) for a, b in zip(low, high, strict=True)]
    return Fit(*best, limit_interval=ends[0], exponent_interval=ends[2])


def _least_squares(
    layers: NDArray[np.float64], angles: NDArray[np.float64], weights: NDArray[np.float64]
) -> tuple[float, float, float]:
    """Return limit, amplitude and exponent; for a given exponent the others are linear."""

    def linear(exponent: float) -> tuple[NDArray[np.floating[Any]], float]:
        design = np.column_stack([np.ones_like(layers), layers**-exponent]) * weights[:, None]
        found, _, _, _ = np.linalg.lstsq(design, angles * weights, rcond=None)
        return found, float(np.sum((design @ found - angles * weights) ** 2))

    found = minimize_scalar(lambda p: linear(p)[1], bounds=EXPONENTS, method="bounded")
    limit, amplitude = linear(float(found.x))[0]
    return float(limit), float(amplitude), float(found.x)


def _resampled(
    data: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return samples of the data drawn with replacement (RESAMPLES, data), the same every time."""
    chosen = np.random.default_rng(0).integers(0, len(data), (RESAMPLES, len(data)))
    return data[chosen]
