"""Limits of a series of results: step to zero, stiffness to infinity, with observed orders."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import minimize_scalar
from scipy.special import stdtrit

from harness.errors import RequestError

Floats = NDArray[np.float64]
ORDERS = (0.2, 6.0)  # in which an order is looked for
CONFIDENCE = 0.95


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
    return Limit(
        value=float(coefficients[0]),
        uncertainty=float(spread + abs(free[0] - coefficients[0])),
        order=order,
        order_interval=interval,
        h=h,
        y=y,
        errors=errors,
        coefficients=coefficients[1:],
        exponents=powers,
    )


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
