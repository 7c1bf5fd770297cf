"""One damped contact by direct integration: when it ends, and how fast the grain leaves."""

from __future__ import annotations

from typing import Any, Literal, NamedTuple

from scipy.integrate import solve_ivp


class Ended(NamedTuple):
    """The end of a contact that began at speed 1."""

    time: float
    restitution: float


def integrate(
    stiffness: float, mass: float, damping: float, end: Literal["parted", "released"] = "parted"
) -> Ended:
    """Integrate m x'' + gamma x' + k x = 0 from touching at speed 1 m/s until the contact ends.

    It ends when the overlap is gone (``parted``, the attractive tail kept) or when
    the force is (``released``, the tail clipped).
    """

    def at_end(_: float, state: Any) -> float:
        held = state[0] if end == "parted" else stiffness * state[0] + damping * state[1]
        return float(held)

    at_end.terminal, at_end.direction = True, -1  # type: ignore[attr-defined]
    period = (mass / stiffness) ** 0.5
    solution = solve_ivp(
        lambda _, s: [s[1], -(stiffness * s[0] + damping * s[1]) / mass],
        (0.0, 100 * period),
        [1e-13 * period, 1.0],
        events=at_end,
        rtol=1e-11,
        atol=1e-14 * period,
    )
    return Ended(float(solution.t[-1]), -float(solution.y[1, -1]))
