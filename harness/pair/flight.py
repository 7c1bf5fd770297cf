"""When bodies in free flight meet next, in closed form: the first root of a polynomial."""

from __future__ import annotations

import math

import numpy as np

from harness.pair.records import BODY, Floats, System

NEVER = 1e300
"""[s] or a power of it."""


def next_contact(y: Floats, system: System) -> tuple[float, int]:
    """Return the time until two bodies first touch [s] and which contact it is; inf for none.

    A contact that overlaps and closes begins at once.
    """
    found = [(_time_to(y, system, c), c) for c in range(len(system.contacts))]
    return min(found, default=(math.inf, -1))


def flown(y: Floats, system: System, time: float) -> Floats:
    """Return the state after a flight: parabolas and steady rotation."""
    result = y.copy()
    for b in range(len(system.bodies)):
        at = BODY * b
        velocity, gravity = y[at + 3 : at + 6], system.bodies[b]["gravity"]
        result[at : at + 3] += velocity * time + 0.5 * gravity * time**2
        result[at + 3 : at + 6] += gravity * time
    return result


def _time_to(y: Floats, system: System, contact: int) -> float:
    i, j = system.contacts[contact]["first"], system.contacts[contact]["second"]
    place, velocity = y[BODY * i : BODY * i + 3], y[BODY * i + 3 : BODY * i + 6]
    gravity = system.bodies[i]["gravity"]
    if j < 0:
        n = system.planes[-1 - j]["normal"]
        gap = (place - system.planes[-1 - j]["point"]) @ n - system.bodies[i]["radius"]
        return _first_fall([0.5 * gravity @ n, velocity @ n, gap])
    apart = place - y[BODY * j : BODY * j + 3]
    velocity = velocity - y[BODY * j + 3 : BODY * j + 6]
    gravity = gravity - system.bodies[j]["gravity"]
    reach = system.bodies[i]["radius"] + system.bodies[j]["radius"]
    distance = float(np.sqrt(apart @ apart))
    return _first_fall(
        [
            0.25 * gravity @ gravity,
            gravity @ velocity,
            velocity @ velocity + gravity @ apart,
            2.0 * float(velocity @ apart),
            (distance - reach) * (distance + reach),
        ]
    )


def _first_fall(polynomial: list[float]) -> float:
    """Return the first time from 0 on at which a polynomial falls through 0; inf for none."""
    coefficients = np.trim_zeros(np.array(polynomial, dtype=float), "f")
    # a factor so small has its root beyond any time, and overflows on the way there
    while len(coefficients) > 1 and abs(coefficients[0]) * NEVER < np.abs(coefficients[1:]).max():
        coefficients = coefficients[1:]
    slopes = np.polyder(coefficients) if len(coefficients) > 1 else np.zeros(1)
    if polynomial[-1] <= 0.0 and _falls_at_once(polynomial):
        return 0.0
    if len(coefficients) < 2:
        return math.inf
    roots = np.roots(coefficients)
    real = np.sort(roots[np.abs(roots.imag) <= 1e-7 * np.abs(roots)].real)
    for root in real[real > 0.0]:
        if np.polyval(slopes, root) < 0.0:
            return float(root - np.polyval(coefficients, root) / np.polyval(slopes, root))
    return math.inf


def _falls_at_once(polynomial: list[float]) -> bool:
    """Return whether the first derivative that is not 0 at time 0 is negative."""
    moving = [c for c in reversed(polynomial[:-1]) if c != 0.0]
    return bool(moving) and moving[0] < 0.0
