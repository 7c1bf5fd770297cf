"""Section Background: the shock in the well, equations (7) to (9)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from harness.reproduction import as_printed
from harness.reproduction.as_printed import Printed
from harness.reproduction.claims import Statement, compare
from harness.reproduction.source import SOURCES
from harness.theory.critical_angle import critical_angle

_RESTITUTIONS = np.linspace(0.0, 1.0, 21)


def statements(printed: Printed) -> list[Statement]:
    """Return the rows of this part."""
    before = np.array([math.sqrt(3) / 2, -0.5])  # unit speed, 60 deg off the new tangent
    after = [collide(before, e) for e in _RESTITUTIONS]
    speeds = [float(np.hypot(*v)) for v in after]
    kept = [float(v @ v) / float(before @ before) for v in after]
    return [
        _ratio(speeds, kept, before, after),
        compare(
            SOURCES["eq-8"],
            printed=[as_printed.velocity_after(1.0, e) for e in _RESTITUTIONS],
            found=speeds,
            computed="speed after one collision in vectors, e_n from 0 to 1",
        ),
        compare(
            SOURCES["text-substitution"],
            printed=[as_printed.shock_of_restitution(e) for e in _RESTITUTIONS],
            found=[
                as_printed.shock_of_velocities(7.0, as_printed.velocity_after(7.0, e))
                for e in _RESTITUTIONS
            ],
            computed="eq. (8) put into eq. (7) at v' = 7 m/s (the text says: into eq. (8))",
        ),
        compare(
            SOURCES["eq-9"],
            printed=[as_printed.shock_of_restitution(e) for e in _RESTITUTIONS],
            found=kept,
            computed="energy after over before in vectors, e_n from 0 to 1: right at e_n = 0 only; "
            "at e_n = 1, where nothing is lost, the formula gives 0",
            corrected=[0.25 + 0.75 * e**2 for e in _RESTITUTIONS],
        ),
        _without_rebound(printed, before),
    ]


def collide(velocity: NDArray[np.float64], restitution: float) -> NDArray[np.float64]:
    """Return the velocity after the grain meets the next sphere, in vectors.

    The new contact's normal stands 60 deg off the old one's; the normal part of
    the velocity is turned back and multiplied by ``restitution``.
    """
    normal = np.array([-1.0, 0.0])
    approach = float(velocity @ normal)
    return np.asarray(velocity - (1 + restitution) * approach * normal)


def _ratio(
    speeds: list[float],
    kept: list[float],
    before: NDArray[np.float64],
    after: list[NDArray[np.float64]],
) -> Statement:
    vector = float(np.sum((before - after[0]) ** 2))
    return compare(
        SOURCES["eq-7"],
        printed=[as_printed.shock_of_velocities(1.0, speed) for speed in speeds],
        found=kept,
        computed=f"a collision in vectors at {len(speeds)} restitutions from 0 to 1: energy after "
        f"over before is (v/v')^2; the formula is built from the speed lost and agrees at v = v'/2 "
        f"(e = 0) only; with velocities taken as vectors it would be {vector:.2f} there, "
        f"and theta_c {critical_angle(vector):.2f} deg",
        corrected=[speed**2 for speed in speeds],
    )


def _without_rebound(printed: Printed, before: NDArray[np.float64]) -> Statement:
    found = float(np.sum(collide(before, 0.0) ** 2))
    return compare(
        SOURCES["text-shock"],
        printed=printed.shock,
        found=found,
        computed=f"energy left by a collision in vectors without rebound: {found:.6f}",
    )
