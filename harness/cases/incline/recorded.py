"""What was recorded of the incline with MFiX-DEM 21.3.2, and its check against the reference DEM.

The tables lie in the engine's folder ``recorded``, which says where they come from.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass

import numpy as np

from harness.cases.contract import LevelName
from harness.cases.incline.critical_angle import CriticalAngle
from harness.cases.incline.critical_angles import critical_angle
from harness.cases.incline.engine_angle import SOURCE_ROLE, EngineAngle, Rules
from harness.cases.incline.parameters import Incline
from harness.cases.incline.routes import start_in_well
from harness.cases.incline.runs import steady_runs
from harness.cases.incline.steady import COARSE_WELLS, critical_angle_by_steady_motion
from harness.cases.incline.tolerances import RECORDED
from harness.cases.parts import failed_part
from harness.cases.runs import recorded_text
from harness.comparison.verdicts import Check, Kind, finding, judge, not_tested
from harness.engines.mfix.step import steps_per_contact
from harness.engines.reference.engine import Reference
from harness.errors import EngineError, RequestError
from harness.observables.trajectory import Trajectory
from harness.parameters.contact import Contact
from harness.theory.critical_angle import critical_angle as closed_form

MFIX = "mfix"
RECORDED_NAME = "mfix (recorded)"

EULER = "mfix-euler"

TOLERANCE_DEG = 1e-3

FINE = 1000
"""Factor from which a passage will do: where in a step a contact begins is worth 1e-4 deg."""

COARSE = 50
"""Factor of 4.8 steps per contact: how long one waits decides there on what lasts."""

WELLS = 20
"""Wells to pass in steady motion, beyond those of ``COARSE``, whose jitter asks for more."""

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


def recorded_path(factor: int, angle: float) -> Trajectory:
    """Return a recorded path, six digits; raise RequestError for one that is not in ``PATHS``.

    It starts at x = 0.5 d, from the centre of a fixed sphere as everywhere in the harness.
    """
    if (factor, angle) not in PATHS:
        known = ", ".join(f"f = {f} at {a:.2f} deg" for f, a in PATHS)
        raise RequestError(
            f"f = {factor} at {angle:g} deg was not recorded: must be one of {known}"
        )
    text = recorded_text(MFIX, f"quartier_k1e6_euler_f{factor}_th{angle:.2f}.csv")
    t, x, y, vx, vy = np.loadtxt(
        text.splitlines(), delimiter=",", skiprows=1, usecols=range(5), unpack=True
    )
    return Trajectory(t, x - FIRST_CENTRE, y, vx, vy)


def recorded_angles() -> list[RecordedAngle]:
    """Return the recorded critical angles, by stiffness and factor."""
    rows = csv.DictReader(recorded_text(MFIX, "critical_angles_euler.csv").splitlines())
    return [
        RecordedAngle(
            float(row["stiffness_N_per_m"]),
            int(row["dtsolid_factor"]),
            float(row["critical_angle_deg"]),
            float(row["uncertainty_deg"]),
        )
        for row in rows
    ]


SHOWN: dict[LevelName, tuple[tuple[float, int], ...]] = {
    "quick": ((1e6, 500),),
    "default": ((1e6, 500), (1e6, 5000)),
}
"""Stiffness [N/m] and ``DTSOLID_FACTOR`` by level; all of them in a full one."""


def recorded_checks(level: LevelName, angles: list[EngineAngle]) -> list[Check]:
    """Return the rows of MFiX's recorded angles; add to ``angles``."""
    chosen = SHOWN.get(level)
    with Reference(EULER) as engine:
        return [
            _angle(found, engine, angles)
            for found in recorded_angles()
            if chosen is None or (found.stiffness, found.factor) in chosen
        ]


def angle_in_scheme(stiffness: float, factor: int, engine: Reference) -> CriticalAngle | None:
    """Return the critical angle at a stiffness [N/m] and factor; None for an unstable step.

    Coarse steps by steady motion from MFiX's own start (1.5 m/s in a well), as the
    recorded angles were found; fine ones by passage, which is the same there and
    asks for a tenth of the steps.
    """
    wells = COARSE_WELLS if factor <= COARSE else WELLS
    case = case_at(10.2, stiffness, factor).replace(wells=wells, time_limit=100.0 * wells)
    try:
        if factor >= FINE:
            return critical_angle(case, engine=engine)
        return critical_angle_by_steady_motion(
            lambda cases: steady_runs(engine, cases, start_in_well(case, START_SPEED)),
            case,
            tolerance_deg=TOLERANCE_DEG,
        )
    except RequestError:
        return None


def _angle(found: RecordedAngle, engine: Reference, angles: list[EngineAngle]) -> Check:
    """Hold a recorded angle against the reference DEM, by the same route from the same start."""
    case = found.case
    name = (
        f"{RECORDED_NAME}: critical angle against the reference DEM, k = {found.stiffness:g} N/m, "
        f"{case.steps_per_contact:.3g} steps"
    )
    try:
        own = angle_in_scheme(found.stiffness, found.factor, engine)
    except EngineError as error:
        return failed_part(name, error, "deg")
    if own is None:
        return not_tested(name, Kind.CROSS_CODE, "the step is unstable in the scheme", "deg")
    angles.append(
        EngineAngle(
            engine=RECORDED_NAME,
            role=SOURCE_ROLE,
            contact="source, m_eff m/2",
            rules=Rules(case.contact.tail, case.contact.effective_mass, "linear"),
            stiffness=found.stiffness,
            steps_per_contact=case.steps_per_contact,
            value_deg=found.value_deg,
            uncertainty_deg=found.uncertainty_deg,
            closed_form_deg=closed_form(),
            integrator=EULER,
            reference_deg=own.value_deg,
            recorded=True,
        )
    )
    if found.factor == COARSE:
        note = "4.8 steps per contact: how long one waits decides on what lasts"
        return finding(name, found.value_deg, own.value_deg, "deg", note)
    return judge(
        name,
        Kind.CROSS_CODE,
        found.value_deg,
        own.value_deg,
        RECORDED,
        uncertainty=found.uncertainty_deg,
        note=f"MFiX 21.3.2; reference DEM: {EULER}",
    )
