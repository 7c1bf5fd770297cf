"""What was recorded of the incline with MFiX-DEM 21.3.2: paths and critical angles.

The tables lie in the engine's folder ``recorded``, which says where they come from.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass
from importlib import resources

import numpy as np

from harness.cases.incline.parameters import Incline
from harness.engines.mfix.step import steps_per_contact
from harness.errors import RequestError
from harness.observables.trajectory import Trajectory
from harness.parameters.contact import Contact

CONTACT = Contact(
    name="MFiX", restitution=1e-20, damping_ratio=None, tail="attractive", effective_mass="half"
)
"""The contact of the recorded inclines: m_eff = m/2 also against a fixed sphere, not clipped."""

STIFFNESS = 1e6
"""[N/m] of the recorded paths."""

START_SPEED = 1.5
"""[m/s] in a well, along the tangent of the sphere ahead."""

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
    text = _text(f"quartier_k1e6_euler_f{factor}_th{angle:.2f}.csv")
    table = np.genfromtxt(text.splitlines(), delimiter=",", names=True)
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


def _text(name: str) -> str:
    folder = resources.files("harness.engines.mfix").joinpath("recorded")
    return folder.joinpath(name).read_text(encoding="utf-8")
