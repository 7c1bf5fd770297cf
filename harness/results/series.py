"""Series of results: their limit with its order, and their first divergence from a reference."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import minimize_scalar

from harness.errors import RequestError
from harness.results.rows import Failure

Floats = NDArray[np.float64]
ORDERS = (0.2, 6.0)  # in which an order is searched
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


def first_divergence(
    time: Floats,
    columns: Mapping[str, Floats],
    reference_time: Floats,
    reference: Mapping[str, Floats],
    band: float,
) -> tuple[Failure, str]:
    """Return class and place of the first difference from a reference by more than ``band``.

    Without any it is ``Failure.NONE``. Times [s] and columns have shape (samples,); both series
    have the same times, nothing is interpolated. NaN is outside the band. Raise ValueError for
    other times.
    """
    record = float(np.ptp(reference_time)) if reference_time.size else 0.0
    same = time.shape == reference_time.shape
    if not (same and np.all(np.abs(time - reference_time) <= SAME_TIME * record)):
        raise ValueError(f"{time.size} samples at other times than {reference_time.size} expected")
    starts = {}  # sample of each column that leaves the band
    for name, expected in reference.items():
        outside = ~(np.abs(columns[name] - expected) <= band)
        if outside.any():
            starts[name] = int(outside.argmax())
    if not starts:
        return Failure.NONE, ""
    name = min(starts, key=lambda column: starts[column])
    failure = Failure.FROM_FIRST_STEP if starts[name] <= 1 else Failure.LATE
    largest = float(np.max(np.abs(columns[name] - reference[name])))
    place = f"{name} at {time[starts[name]]:.6g} s, by up to {largest:.3g}"
    return failure, f"{failure}: {place}"
