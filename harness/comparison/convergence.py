"""Limits of a series of results: step to zero, stiffness to infinity, with observed orders."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import minimize_scalar
from scipy.special import stdtrit

from harness.errors import RequestError

ORDERS = (0.2, 6.0)
"""Range in which an order is looked for."""

CONFIDENCE = 0.95


@dataclass(frozen=True)
class Limit:
    """The limit h -> 0 of y(h), and how it was reached.

    ``uncertainty`` adds the propagated errors of the points and the distance
    between two models: the expected order with the next term, and a free order.
    ``order`` is the observed one, ``order_interval`` what the points' errors allow.
    """

    value: float
    uncertainty: float
    order: float
    order_interval: tuple[float, float]
    h: NDArray[np.float64]
    y: NDArray[np.float64]
    errors: NDArray[np.float64]
    coefficients: NDArray[np.float64]
    exponents: NDArray[np.float64]

    def curve(self, h: ArrayLike) -> NDArray[np.float64]:
        """Return the fitted y at h, shape of h."""
        h = np.asarray(h, dtype=float)
        return self.value + sum(
            (c * h**p for c, p in zip(self.coefficients, self.exponents, strict=True)),
            start=np.zeros_like(h),
        )


def limit(
    h: ArrayLike, y: ArrayLike, errors: ArrayLike, exponents: Sequence[float] = (1.0,)
) -> Limit:
    """Return the limit of y at h -> 0 from y = L + sum_j c_j h^p_j with known exponents p_j.

    ``h``, ``y`` and ``errors`` (the uncertainty of each y, positive) have shape
    (points,). At least one point more than unknowns is needed, else
    RequestError. A second fit, y = L + c h^p, frees the order: it gives the
    observed order, and its distance is the uncertainty by the choice of model.
    """
    h, y, errors = (np.asarray(a, dtype=float) for a in (h, y, errors))
    if len(h) < len(exponents) + 2:
        raise RequestError(
            f"an extrapolation with {len(exponents)} terms needs at least "
            f"{len(exponents) + 2} points, got {len(h)}"
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

    ``h`` and ``error`` (positive) have shape (points,), at least three.
    """
    x, z = np.log(np.asarray(h, dtype=float)), np.log(np.asarray(error, dtype=float))
    slope, offset = np.polyfit(x, z, 1)
    freedom = len(x) - 2
    scatter = float(np.sum((z - slope * x - offset) ** 2)) / freedom
    width = stdtrit(freedom, 0.5 + CONFIDENCE / 2) * np.sqrt(scatter / np.sum((x - x.mean()) ** 2))
    return float(slope), (float(slope - width), float(slope + width))


def _fit(
    h: NDArray[np.float64],
    y: NDArray[np.float64],
    errors: NDArray[np.float64],
    powers: NDArray[np.float64],
) -> tuple[NDArray[np.float64], float]:
    """Return (L, c_1, ...) of the weighted least squares and the propagated error of L.

    The errors are taken as bounds, not as standard deviations: they are half
    ranges of a systematic jitter, so they add up in modulus.
    """
    columns = np.column_stack([np.ones_like(h), *(h**p for p in powers)])
    inverse = np.linalg.pinv(columns / errors[:, None]) / errors[None, :]
    return inverse @ y, float(np.abs(inverse[0]) @ errors)


def _observed_order(
    h: NDArray[np.float64], y: NDArray[np.float64], errors: NDArray[np.float64]
) -> tuple[float, tuple[float, float]]:
    """Return the order that fits best, and the interval of those that the points allow.

    The errors being bounds, an order is allowed when its fit misses no point by
    more than that point's error (or than the best order does, if that is more).
    """
    weights = errors**-2 / np.sum(errors**-2)
    level = y @ weights

    def misses(orders: NDArray[np.float64]) -> NDArray[np.float64]:
        # straight lines in h^order, by their centre: (orders, points)
        powers = h ** orders[:, None]
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
