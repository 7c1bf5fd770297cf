"""Recorded output of MFiX-DEM 21.3.2: paths over the incline, critical angles, tower forces.

The folder ``recorded`` beside this file holds the tables, and says where they come from.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass
from importlib import resources
from typing import TYPE_CHECKING

import numpy as np

from harness.cases.incline.parameters import Incline
from harness.engines.mfix.step import steps_per_contact
from harness.errors import RequestError
from harness.observables.trajectory import Trajectory
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

STIFFNESS = 1e6
"""[N/m] of the recorded paths."""

START_SPEED = 1.5
"""[m/s] in a well, along the tangent of the sphere ahead."""

TOWER_STIFFNESS, TOWER_SPEED = 1e5, 2.0
"""[N/m] and [m/s] of the recorded towers: 1 kg, 1 m, undamped, all just touching."""

TOWERS = (50, 5000)
"""``DTSOLID_FACTOR`` of the recorded towers."""

FIRST_CENTRE = 0.5
"""[m] x of the first fixed sphere in the recorded paths: they count from the row's left edge."""

PATHS = ((50, 10.20), (500, 10.20), (500, 10.22))
"""``DTSOLID_FACTOR`` and angle [deg] of the recorded paths."""


@dataclass(frozen=True)
class RecordedPath:
    """A recorded path and its conditions: ``case`` (step, angle, stiffness, contact), factor f.

    The trajectory starts at x = 0.5 d, from the centre of a fixed sphere as
    everywhere in the harness; six digits were recorded.
    """

    case: Incline
    factor: int
    trajectory: Trajectory


@dataclass(frozen=True)
class RecordedAngle:
    """A critical angle [deg] that was found by bisecting MFiX runs, to ``uncertainty_deg``."""

    stiffness: float  # [N/m]
    factor: int
    value_deg: float
    uncertainty_deg: float

    @property
    def case(self) -> Incline:
        """Return the incline at this angle, as MFiX ran it."""
        return case_at(self.value_deg, self.stiffness, self.factor)


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


def case_at(angle: float, stiffness: float, factor: float) -> Incline:
    """Return the incline (1 m, 1 kg) as MFiX ran it at an angle [deg], k [N/m] and factor."""
    return Incline(
        angle=angle,
        stiffness=stiffness,
        contact=CONTACT,
        steps_per_contact=steps_per_contact(factor, CONTACT),
        spheres=10,
    )


def recorded_path(factor: int, angle: float) -> RecordedPath:
    """Return a recorded path; raise RequestError for one that is not in ``PATHS``."""
    if (factor, angle) not in PATHS:
        known = ", ".join(f"f = {f} at {a:.2f} deg" for f, a in PATHS)
        raise RequestError(
            f"f = {factor} at {angle:g} deg was not recorded: must be one of {known}"
        )
    table = _table(f"quartier_k1e6_euler_f{factor}_th{angle:.2f}.csv")
    trajectory = Trajectory(
        table["t_s"],
        table["x_m"] - FIRST_CENTRE,
        table["y_m"],
        table["vx_m_s"],
        table["vy_m_s"],
    )
    return RecordedPath(case_at(angle, STIFFNESS, factor), factor, trajectory)


def recorded_angles() -> list[RecordedAngle]:
    """Return the recorded critical angles, by stiffness and factor."""
    rows = csv.DictReader(_text("critical_angles_euler.csv").splitlines())
    return [
        RecordedAngle(
            float(row["stiffness_N_per_m"]),
            int(row["dtsolid_factor"]),
            float(row["critical_angle_deg"]),
            float(row["uncertainty_deg"]),
        )
        for row in rows
    ]


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
