"""The spheres of a contact as MFiX takes them, and what a run leaves of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from harness.engines.mfix.read import particle, row_of
from harness.engines.mfix.vtp import Frame
from harness.engines.output import Table
from harness.errors import EngineNaNError, EngineOutputError

if TYPE_CHECKING:
    from harness.engines.mfix.contact_input import ContactInput

COLUMNS = (
    *("x_m", "y_m", "z_m", "vx_m_per_s", "vy_m_per_s", "vz_m_per_s"),
    *("wx_rad_per_s", "wy_rad_per_s", "wz_rad_per_s"),
)

SPHERE = ("radius", "mass", "x", "z", "vx", "vz")


@dataclass(frozen=True)
class Ball:
    """A sphere in the plane of a scene; SI."""

    radius: float
    mass: float
    x: float
    z: float
    vx: float
    vz: float
    held: bool

    @property
    def kind(self) -> tuple[float, float]:
        """Return diameter and density, which make a phase."""
        return 2.0 * self.radius, self.mass * 0.75 / math.pi / self.radius**3


@dataclass(frozen=True)
class Couple:
    """What two phases, or a phase and a wall, have as they meet: m* [kg] and R* [m]."""

    mass: float
    radius: float
    meets: bool


def contact_table(contact: ContactInput, frames: Sequence[Frame]) -> Table:
    """Return the samples; raise EngineOutputError where some are missing.

    MFiX writes no forces. A held sphere is not written: it rests.
    """
    numbers = range(0, contact.steps + 1, contact.every)
    clock = {round(frame.time / contact.step): frame for frame in frames}
    if missing := [number for number in numbers if number not in clock]:
        raise EngineOutputError(f"MFiX wrote no particles at step {missing[0]}")
    table = {"step": np.array(numbers, dtype=np.float64)}
    states = np.array([_state(contact, clock[number]) for number in numbers])
    if not np.isfinite(states).all():
        raise EngineNaNError("MFiX wrote values that are not numbers")
    for column, name in enumerate(COLUMNS):
        table[name] = states[:, :, column]
    return table


def _state(contact: ContactInput, frame: Frame) -> list[list[float]]:
    x0, y0 = contact.origin
    rows = []
    for number, ball in enumerate(contact.balls, 1):
        if ball.held:
            rows.append([ball.x, 0.0, ball.z, *[0.0] * 6])
            continue
        x, y, vx, vy = particle(frame, number)
        # x, y, z of MFiX are x, z, -y of the scene
        spin = -frame.arrays["Angular_velocity"][row_of(frame, number)][2]
        rows.append([x - x0, 0.0, y - y0, vx, 0.0, vy, 0.0, spin, 0.0])
    return rows
