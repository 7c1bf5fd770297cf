"""Oblique elastic impact with partial slip: Maw, Barber and Fawcett, Wear 38, 101 (1976).

A solid elastic sphere on a half-space of the same material: the contact circle sticks inside and
slips outside. Computed by springs that do not know each other, which is the same problem (Lyashenko
and Popov, Scientific Reports 5, 8479 (2015)): one at x is pressed by delta - x^2 / R, moves with
the body while it sticks, and carries at most mu times its normal force.

Dimensionless, the incidence and the one parameter of a solid sphere are

    psi = kappa / mu * u / v,    kappa = 2 (1 - nu) / (2 - nu),    chi = 7/4 kappa

with u and v the tangential and normal velocity at the contact. Sliding throughout, from psi =
4 chi - 1 on, the rebound is psi - 4 chi.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import solve_ivp

Array = NDArray[np.float64]

SPRINGS, STEPS = 200, 2000
"""On half of the largest contact, and of the impact."""

POINTS = 48
"""Of a curve up to where all slides."""


def stiffness_ratio(poisson: float) -> float:
    """Return kappa, tangential over normal stiffness of a contact that sticks."""
    return 2.0 * (1.0 - poisson) / (2.0 - poisson)


def rebound(
    psi: ArrayLike, poisson: float, springs: int = SPRINGS, steps: int = STEPS
) -> NDArray[np.float64]:
    """Return psi of the rebound for psi of the incidence, any shape; without spin before.

    ``springs`` on half of the contact and ``steps`` of the impact: the error falls with the step.
    """
    psi = np.asarray(psi, dtype=float)
    chi = 1.75 * stiffness_ratio(poisson)
    time, overlaps = _normal_motion(steps)
    h = time[1] - time[0]
    places = (np.arange(springs) + 0.5) / springs * np.sqrt(overlaps.max())
    width = 2.0 * (places[1] - places[0])  # both halves
    speed = psi.reshape(-1, 1).copy()
    strains = np.zeros((speed.size, springs))
    force = np.zeros_like(speed)
    for overlap in overlaps[1:]:
        speed -= h * chi * force
        limit = np.maximum(overlap - places**2, 0.0)
        strains = spring_strains(strains + h * speed, limit)
        force = width * strains.sum(axis=1, keepdims=True)
        speed -= h * chi * force
    return np.asarray(speed.reshape(psi.shape))


@lru_cache(maxsize=64)
def rebounds(poisson: float, points: int = POINTS) -> tuple[Array, Array]:
    """Return psi of the incidence and of the rebound up to where all slides, each (points,).

    Beyond, the rebound is psi - 4 chi. The arrays are not to be written to.
    """
    psi = np.linspace(0.0, 7.0 * stiffness_ratio(poisson) - 1.0, points + 1)[1:]
    return psi, rebound(psi, poisson)


def spring_strains(strains: Array, limit: Array) -> Array:
    """Return strains cut back to Coulomb's limit; a spring that has left carries nothing."""
    return np.clip(strains, -limit, limit)


@lru_cache(maxsize=8)
def _normal_motion(steps: int) -> tuple[Array, Array]:
    """Return times and overlaps of a Hertzian impact with E* = R = m = v = 1, (steps + 1,)."""

    def rates(_: float, y: Array) -> list[float]:
        return [y[1], -4.0 / 3.0 * max(y[0], 0.0) ** 1.5]

    def parts(_: float, y: Array) -> float:
        return float(y[0])

    parts.terminal, parts.direction = True, -1.0  # type: ignore[attr-defined]
    found = solve_ivp(
        rates, (0.0, 10.0), [0.0, 1.0], events=parts, dense_output=True, rtol=1e-11, atol=1e-13
    )
    assert found.t_events is not None
    assert found.sol is not None
    time = np.linspace(0.0, found.t_events[0][0], steps + 1)
    return time, np.maximum(found.sol(time)[0], 0.0)
