"""Series of results: their limit with its order, and their first divergence from a reference."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import minimize_scalar
from scipy.special import stdtrit

from harness.errors import RequestError
from harness.results.rows import Failure

Floats = NDArray[np.float64]
ORDERS = (0.2, 6.0)  # in which an order is searched
CONFIDENCE = 0.95
RETURN = 0.05  # [-] part of the record inside the band after which a series has come back
SAME_TIME = 1e-9  # [-] of the record: differences of times that round-off makes


@dataclass(frozen=True)
class Limit:
    """The limit of y(h) at h -> 0, with the points and the fit behind it.

    ``uncertainty`` adds the errors of the points, passed on by the fit, and the distance between
    two models: known exponents, and one free order. ``order`` is that free order.
    """

    value: float
    uncertainty: float
    order: float
    order_interval: tuple[float, float]
    h: Floats
    y: Floats
    errors: Floats
    coefficients: Floats
    exponents: Floats

    def curve(self, h: ArrayLike) -> Floats:
        """Return the fitted y at h, in the shape of h."""
        powers = np.asarray(h, dtype=float)[..., None] ** self.exponents
        return np.asarray(self.value + powers @ self.coefficients)


def limit(
    h: ArrayLike, y: ArrayLike, errors: ArrayLike, exponents: Sequence[float] = (1.0,)
) -> Limit:
    """Return the limit of y at h -> 0 from y = L + sum_j c_j h^p_j with known exponents p_j.

    ``h``, ``y`` and ``errors`` (bounds of the error of each y, positive) have the shape (points,).
    Raise RequestError for fewer points than exponents and two.
    """
    h, y, errors = (np.asarray(column, dtype=float) for column in (h, y, errors))
    if len(h) < len(exponents) + 2:
        raise RequestError(
            f"an extrapolation with {len(exponents)} terms needs at least {len(exponents) + 2} "
            f"points, not {len(h)}"
        )
    powers = np.asarray(exponents, dtype=float)
    coefficients, spread = _fit(h, y, errors, powers)
    order, interval = _observed_order(h, y, errors)
    free, _ = _fit(h, y, errors, np.array([order]))
    uncertainty = float(spread + abs(free[0] - coefficients[0]))
    return Limit(float(coefficients[0]), uncertainty, order, interval, h, y, errors,
                 coefficients[1:], powers)  # fmt: skip


def slope_order(h: ArrayLike, error: ArrayLike) -> tuple[float, tuple[float, float]]:
    """Return the order p of error ~ h^p and its 95 % interval, from a line through the logarithms.

    ``h`` and ``error`` (positive) have the shape (points,), at least three.
    """
    x, z = np.log(np.asarray(h, dtype=float)), np.log(np.asarray(error, dtype=float))
    slope, offset = np.polyfit(x, z, 1)
    scatter = float(np.sum((z - slope * x - offset) ** 2)) / (len(x) - 2)
    error_of_slope = np.sqrt(scatter / np.sum((x - x.mean()) ** 2))
    width = float(stdtrit(len(x) - 2, 0.5 + CONFIDENCE / 2.0) * error_of_slope)
    return float(slope), (float(slope) - width, float(slope) + width)


def _fit(h: Floats, y: Floats, errors: Floats, powers: Floats) -> tuple[Floats, float]:
    """Return (L, c_1, ...) by weighted least squares, and the bound of the error of L.

    Errors are bounds of a systematic jitter and no standard deviations: they add up in modulus.
    """
    columns = np.column_stack([np.ones_like(h), *(h**p for p in powers)])
    inverse = np.linalg.pinv(columns / errors[:, None]) / errors[None, :]
    return inverse @ y, float(np.abs(inverse[0]) @ errors)


def _observed_order(h: Floats, y: Floats, errors: Floats) -> tuple[float, tuple[float, float]]:
    """Return the order that fits best, and the interval of orders that the errors allow.

    An allowed order misses no point by more than its error, or than the best order does.
    """
    weights = errors**-2 / np.sum(errors**-2)
    level = y @ weights

    def misses(orders: Floats) -> Floats:
        powers = h ** orders[:, None]  # straight lines in h^order, by their centre
        x = powers - (powers @ weights)[:, None]
        slope = ((x * y) @ weights) / ((x * x) @ weights)
        return np.asarray((level + slope[:, None] * x - y) / errors)

    best = minimize_scalar(
        lambda order: float(np.sum(misses(np.array([order])) ** 2)),
        bounds=ORDERS,
        method="bounded",
        options={"xatol": 1e-10},
    )
    order = float(best.x)
    allowed = max(1.0, float(np.abs(misses(np.array([order]))).max()))
    grid = np.linspace(*ORDERS, 400)
    inside = [float(p) for p in grid[np.abs(misses(grid)).max(axis=1) <= allowed]]
    return order, (min([order, *inside]), max([order, *inside]))


# ---- divergence


@dataclass(frozen=True)
class Divergence:
    """The place at which a column leaves the band about its reference.

    ``time`` [s] is the first sample of the excursion, ``largest`` the largest difference of the
    whole series in the unit of the column.
    """

    column: str
    time: float
    largest: float
    failure: Failure

    @property
    def note(self) -> str:
        """Return the place and the size in words."""
        return f"{self.failure}: {self.column} at {self.time:.6g} s, by up to {self.largest:.3g}"


def first_divergence(
    time: ArrayLike,
    columns: Mapping[str, ArrayLike],
    reference: Mapping[str, ArrayLike],
    *,
    reference_time: ArrayLike | None = None,
    relative: float = 0.0,
    absolute: float = 0.0,
) -> Divergence | None:
    """Return the earliest divergence of any column of the reference, None without any.

    ``time`` [s] and each column have shape (samples,); both series have the same times, nothing is
    interpolated. The difference of two runs crosses zero while they diverge, and an event that is
    seen a sample later leaves a spike: so the divergence is the start of the last excursion from
    the band, or of the first one where the series came back. The band is ``absolute`` plus
    ``relative`` times the largest value of the reference's column; NaN is outside. Raise
    ValueError for a column that the run lacks, and for other times.
    """
    seconds = np.asarray(time, dtype=float)
    _check_times(seconds, seconds if reference_time is None else np.asarray(reference_time))
    divergences = []
    for name, target in reference.items():
        if name not in columns:
            raise ValueError(f"the series has no column {name!r}")
        expected = np.asarray(target, dtype=float)
        difference = np.abs(np.asarray(columns[name], dtype=float) - expected)
        band = absolute + relative * float(np.max(np.abs(expected)))
        start = excursion_start(seconds, ~(difference <= band))
        if start is not None:
            failure = Failure.FROM_FIRST_STEP if start <= 1 else Failure.LATE
            largest = float(np.max(difference))
            divergences.append(Divergence(name, float(seconds[start]), largest, failure))
    return min(divergences, key=lambda divergence: divergence.time, default=None)


def excursion_start(time: Floats, outside: NDArray[np.bool_]) -> int | None:
    """Return the first sample of the last excursion from the band, None without any.

    Of a series that came back for :data:`RETURN` of the record at its end, it is the first sample
    of the first excursion.
    """
    places = np.flatnonzero(outside)
    if places.size == 0:
        return None
    long = RETURN * float(time[-1] - time[0])
    new = np.flatnonzero(np.diff(time[places]) > long) + 1
    starts = places[np.concatenate([[0], new])]
    stays = time[-1] - time[places[-1]] <= long
    return int(starts[-1] if stays else starts[0])


def _check_times(time: Floats, reference: Floats) -> None:
    if time.shape != reference.shape:
        raise ValueError(f"{time.size} samples, and {reference.size} of the reference")
    record = float(np.ptp(reference)) if reference.size else 0.0
    if not np.all(np.abs(time - reference) <= SAME_TIME * record):
        raise ValueError("the samples have other times than those of the reference")
