"""The head-on impact with Hertz's spring and a viscous dashpot, integrated for its restitution.

In units of the largest overlap without damping, (5 m v^2 / 4 K)^(2/5), and of the speed v,

    x'' = -5/4 (x^(3/2) + a sqrt(x) x'),   x(0) = 0,   x'(0) = 1,

with the one parameter a = A v / overlap. (The viscous law: Brilliantov et al., Phys. Rev. E 53,
5382 (1996).) Its limits have closed forms. For a -> 0 the loss of first order is
1 - e = a B(3/5, 3/2), with Euler's beta function. For a -> infinity the dashpot alone stops the
grain, x' = 1 - 5/6 a x^(3/2), at x = (6 / 5a)^(2/3). Clipped, it leaves at x' = -x/a where
the force vanishes, hence e = (6/5)^(2/3) a^(-5/3). Unclipped it creeps, x' = -x/a, until its
damping ratio (about a x^(1/4)) is no longer large, at x of order a^-4: e falls as a^-5.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.special import beta

from harness.errors import RequestError

MOST_DAMPING = 1000.0
"""The largest a: creeping takes 4 a ln(a) units of time."""

TOLERANCE = 1e-11


class Impact(NamedTuple):
    """Restitution [-] and duration [overlap / speed] of a head-on impact."""

    restitution: float
    duration: float


def impact(damping: float, *, clipped: bool) -> Impact:
    """Return the impact for a = A v / overlap; it ends where the force does, or where x = 0.

    Clipped: the end of the force, x + a x' = 0. Raise RequestError for an a outside 0 to 1000.
    """
    if not 0.0 <= damping <= MOST_DAMPING:
        raise RequestError(f"damping = {damping!r}: must be from 0 to {MOST_DAMPING:g}")

    def rates(_: float, state: NDArray[np.float64]) -> tuple[float, float]:
        x = max(float(state[0]), 0.0)
        return float(state[1]), -1.25 * math.sqrt(x) * (x + damping * float(state[1]))

    def end(time: float, state: NDArray[np.float64]) -> float:
        x, v = float(state[0]), float(state[1])
        if time == 0.0:
            return 1.0
        return x + damping * v if clipped else x

    end.terminal = True  # type: ignore[attr-defined]
    end.direction = -1  # type: ignore[attr-defined]
    longest = 100.0 + 10.0 * damping * (1.0 + math.log1p(damping))
    found = solve_ivp(
        rates,
        (0.0, longest),
        (0.0, 1.0),
        method="DOP853",
        rtol=TOLERANCE,
        atol=1e-3 * TOLERANCE / (1.0 + damping) ** 5,
        max_step=0.1 * (1.0 + damping),
        events=end,
    )
    return Impact(-float(found.y[1, -1]), float(found.t[-1]))


def first_order_loss() -> float:
    """Return d(1 - e)/da at a = 0: the work of the dashpot on the undamped motion."""
    return float(beta(0.6, 1.5))
