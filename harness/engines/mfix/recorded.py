"""Recorded output of MFiX-DEM 21.3.2: its contacts, and forces on the grain of a tower.

The folder ``recorded`` beside this file holds the tables, and says where they come from.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib import resources
from typing import TYPE_CHECKING

import numpy as np

from harness.engines.mfix.step import steps_per_contact
from harness.errors import RequestError
from harness.parameters.contact import Contact
from harness.parameters.tower import Tower

if TYPE_CHECKING:
    from numpy.typing import NDArray

CONTACT = Contact(
    name="MFiX", restitution=1e-20, damping_ratio=None, tail="attractive", effective_mass="half"
)
"""The contact of the recorded inclines: m_eff = m/2 also against a fixed sphere, not clipped."""

UNDAMPED = Contact(name="undamped", restitution=1.0, damping_ratio=None, effective_mass="half")
"""The contact of the towers."""

TOWER_STIFFNESS, TOWER_SPEED = 1e5, 2.0
"""[N/m] and [m/s] of the recorded towers: 1 kg, 1 m, undamped, all just touching."""

TOWERS = (50, 5000)
"""``DTSOLID_FACTOR`` of the recorded towers."""


@dataclass(frozen=True)
class RecordedTower:
    """A recorded tower: its case, the factor and step [s], and the force on the grain in time.

    ``time`` (M,) [s] and ``force`` (M,) [N], at the positions of that time, eight digits;
    every step at f = 50, every 100th at f = 5000.
    """

    case: Tower
    factor: int
    step: float
    time: NDArray[np.float64]
    force: NDArray[np.float64]


def recorded_tower(factor: int) -> NDArray[np.void]:
    """Return the recorded force on a tower's grain: ``t_s`` [s], ``F_top_N2`` ... [N].

    Raise RequestError for a factor other than 50 and 5000.
    """
    if factor not in TOWERS:
        raise RequestError(f"f = {factor}: no tower was recorded, must be 50 or 5000")
    return _table(f"tower_k1e5_euler_f{factor}.csv")


def recorded_towers() -> list[RecordedTower]:
    """Return the recorded towers, one for each factor and number of particles."""
    return [
        RecordedTower(case, factor, case.contact_period / steps, table["t_s"], table[column])
        for factor, steps in ((f, steps_per_contact(f, UNDAMPED)) for f in TOWERS)
        for table in (recorded_tower(factor),)
        for column in (table.dtype.names or ())[1:]
        for case in (_tower(int(column.removeprefix("F_top_N"))),)
    ]


def _tower(particles: int) -> Tower:
    return Tower(height=particles - 1, stiffness=TOWER_STIFFNESS, speed=TOWER_SPEED, law="overlap")


def _table(name: str) -> NDArray[np.void]:
    table: NDArray[np.void] = np.genfromtxt(_text(name).splitlines(), delimiter=",", names=True)
    return table


def _text(name: str) -> str:
    return resources.files(__package__).joinpath("recorded", name).read_text(encoding="utf-8")
