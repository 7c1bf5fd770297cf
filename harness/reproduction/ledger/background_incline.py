"""Section Background: the incline in MFiX and LAMMPS, and the angle of rest."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from harness.cases.incline.critical_angle import CriticalAngle
from harness.cases.incline.critical_angles import critical_angle as measured_critical_angle
from harness.cases.incline.parameters import Incline
from harness.cases.incline.recorded import recorded_angles
from harness.engines.contract import Engine
from harness.errors import EngineError
from harness.parameters.contact import SOURCE, Contact
from harness.reproduction import as_printed
from harness.reproduction.as_printed import Printed
from harness.reproduction.claims import Statement, claim, compare, untestable
from harness.reproduction.ledger.contact import integrate
from harness.reproduction.source import SOURCES
from harness.theory.critical_angle import critical_angle

Recorded = dict[float, dict[int, float]]

_STEPS = (50.0, 100.0, 200.0, 400.0)  # per contact time
_REBOUND = 0.1
_WITHOUT = "no engine was given to run the incline in"
_OF_THE_ENGINE = ("text-lammps-angle", "text-lammps-step", "text-restitution-angle")


def statements(printed: Printed, engine: Engine | None) -> list[Statement]:
    """Return the rows of this part."""
    return [_restitution(printed), *_mfix(printed), *_lammps(printed, engine), _rest(printed)]


def angles_by_step() -> Recorded:
    """Return MFiX's recorded critical angles [deg] by stiffness [N/m] and steps per contact."""
    found: Recorded = {}
    for angle in recorded_angles():
        found.setdefault(angle.stiffness, {})[angle.factor] = angle.value_deg
    return found


def _restitution(printed: Printed) -> Statement:
    full = SOURCE.replace(restitution=printed.restitution).zeta
    half = full * np.sqrt(0.5)
    found = integrate(1.0, 1.0, 2 * half).restitution
    return compare(
        SOURCES["text-restitution"],
        printed=printed.restitution,
        found=found,
        computed=f"MFiX takes m/2 for the effective mass, against a base that is merely held too: "
        f"the damping ratio is {half:.4f} in place of {full:.4f}, and the grain rebounds with "
        f"e = {found:.4f} (contact integrated)",
    )


def _mfix(printed: Printed) -> list[Statement]:
    angles, exact = angles_by_step(), critical_angle()
    coarse = {k: min(by_step) for k, by_step in angles.items()}
    off = {k: angles[k][coarse[k]] - exact for k in angles}
    stiffest = max(angles)
    finest = {k: by_step[max(by_step)] - exact for k, by_step in angles.items()}
    return [
        compare(
            SOURCES["text-mfix-angle"],
            printed=printed.critical_angle_deg,
            found=angles[stiffest][coarse[stiffest]],
            tolerance=printed.simulated_within_deg,
            computed="recorded runs at MFiX's default step (contact time / 50) lie "
            + ", ".join(f"{off[k]:+.4f} deg off at {k:.0e} N/m" for k in off)
            + f"; compared is {stiffest:.0e} N/m (the source does not give its stiffness)",
        ),
        claim(
            SOURCES["text-mfix-validation"],
            holds=all(abs(finest[k]) <= abs(off[k]) for k in off),
            computed="with a step a hundred times finer the same runs lie "
            + ", ".join(f"{finest[k]:+.4f} deg off at {k:.0e} N/m" for k in finest)
            + ": errors of step and stiffness cancel at the default step",
        ),
    ]


def _lammps(printed: Printed, engine: Engine | None) -> list[Statement]:
    if engine is None:
        return [untestable(SOURCES[key], _WITHOUT) for key in _OF_THE_ENGINE]
    try:
        found = [_measured(steps, engine) for steps in _STEPS]
        rebounding = _measured(_STEPS[0], engine, Contact(restitution=_REBOUND))
    except EngineError as error:
        return [untestable(SOURCES[key], f"the engine failed: {error}") for key in _OF_THE_ENGINE]
    coarse, fine = found[0], found[-1]
    return [
        compare(
            SOURCES["text-lammps-angle"],
            printed=printed.critical_angle_deg,
            found=coarse.value_deg,
            tolerance=printed.simulated_within_deg,
            computed=f"{coarse.value_deg:.4f} +- {coarse.uncertainty_deg:.4f} deg in the source's "
            f"contact (e = 1e-20, tail kept) at {_STEPS[0]:g} steps per contact, passage",
        ),
        claim(
            SOURCES["text-lammps-step"],
            holds=abs(fine.value_deg - coarse.value_deg) <= printed.simulated_within_deg,
            computed=", ".join(
                f"{a.value_deg:.4f} +- {a.uncertainty_deg:.4f} deg at {s:g} steps per contact"
                for s, a in zip(_STEPS, found, strict=True)
            ),
        ),
        _rebound(rebounding),
    ]


def _measured(steps: float, engine: Engine, contact: Contact = SOURCE) -> CriticalAngle:
    case = Incline(steps_per_contact=steps, contact=contact)
    return measured_critical_angle(case, engine=engine)


def _rebound(found: CriticalAngle) -> Statement:
    lost, kept = (
        critical_angle(shock)
        for shock in (
            as_printed.shock_of_restitution(_REBOUND),
            as_printed.velocity_after(1.0, _REBOUND) ** 2,
        )
    )
    return compare(
        SOURCES["text-restitution-angle"],
        printed=lost,
        found=found.value_deg,
        computed=f"{lost:.3f} deg by eq. (9), {kept:.3f} deg by 1/4 + 3/4 e^2, "
        f"{found.value_deg:.4f} +- {found.uncertainty_deg:.4f} deg in LAMMPS: the "
        "grain bounces several times in a well, and what is normal to the contact is lost all the "
        "same",
        corrected=kept,
    )


def _rest(printed: Printed) -> Statement:
    def upper_contact(angle_deg: float) -> float:
        """Return the force [m g] on the contact uphill of a grain at rest in a well."""
        directions = np.radians([60.0, 120.0])  # from the row, downhill, to the grain
        normals = np.array([np.cos(directions), np.sin(directions)])
        tilt = np.radians(angle_deg)
        return float(np.linalg.solve(normals, [-np.sin(tilt), np.cos(tilt)])[0])

    found = float(brentq(upper_contact, 0.0, 60.0))
    return compare(
        SOURCES["text-rest-angle"],
        printed=printed.rest_angle_deg,
        found=found,
        computed=f"equilibrium of the two contacts: the upper one is without force at "
        f"{found:.4f} deg, {found - critical_angle():.2f} deg above the angle of motion",
    )
