"""Section Background: the incline in MFiX and LAMMPS, and the angle of rest."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.optimize import brentq

from harness.cases.incline.critical_angle import CriticalAngle
from harness.cases.incline.critical_angles import critical_angle as measured_critical_angle
from harness.cases.incline.parameters import Incline
from harness.cases.incline.recorded import recorded_angles
from harness.engines.contract import Engine
from harness.errors import EngineError
from harness.parameters.contact import SOURCE, Contact
from harness.reproduction.as_printed import Printed
from harness.reproduction.claims import Statement, claim, compare, untestable
from harness.reproduction.ledger.contact import integrate
from harness.reproduction.source import SOURCES
from harness.theory.critical_angle import critical_angle

_STEPS = (50.0, 100.0, 200.0, 400.0)  # per contact time
_REBOUND = 0.1
_OF_THE_ENGINE = ("text-lammps-angle", "text-lammps-step", "text-restitution-angle")


def statements(printed: Printed, engine: Engine | None) -> Iterator[Statement]:
    """Yield the rows of this part."""
    full = SOURCE.replace(restitution=printed.restitution).zeta
    half = full * np.sqrt(0.5)
    found = integrate(1.0, 1.0, 2 * half).restitution
    yield compare(
        "text-restitution", printed=printed.restitution, found=found, half=half, full=full
    )
    yield from _mfix(printed)
    try:
        if engine is None:
            raise EngineError("no engine was given to run the incline in")
        yield from _lammps(printed, engine)
    except EngineError as error:
        why = str(error) if engine is None else f"the engine failed: {error}"
        yield from (untestable(key, why) for key in _OF_THE_ENGINE)
    rest = float(brentq(_upper_contact, 0.0, 60.0))
    yield compare(
        "text-rest-angle", printed=printed.rest_angle_deg, found=rest, above=rest - critical_angle()
    )


def _upper_contact(angle_deg: float) -> float:
    """Return the force [m g] on the contact uphill of a grain at rest in a well."""
    directions = np.radians([60.0, 120.0])  # from the row, downhill, to the grain
    normals = np.array([np.cos(directions), np.sin(directions)])
    tilt = np.radians(angle_deg)
    return float(np.linalg.solve(normals, [-np.sin(tilt), np.cos(tilt)])[0])


def angles_by_step() -> dict[float, dict[int, float]]:
    """Return MFiX's recorded critical angles [deg] by stiffness [N/m] and steps per contact."""
    found: dict[float, dict[int, float]] = {}
    for angle in recorded_angles():
        found.setdefault(angle.stiffness, {})[angle.factor] = angle.value_deg
    return found


def _mfix(printed: Printed) -> Iterator[Statement]:
    angles = angles_by_step()
    off = {
        pick: np.array([steps[pick(steps)] for steps in angles.values()]) - critical_angle()
        for pick in (min, max)
    }
    coarse, fine = (
        [f"{d:+.4f} deg off at {k:.0e} N/m" for d, k in zip(off[pick], angles, strict=True)]
        for pick in (min, max)
    )
    stiffest = max(angles)
    yield compare(
        "text-mfix-angle",
        printed=printed.critical_angle_deg,
        found=angles[stiffest][min(angles[stiffest])],
        tolerance=printed.simulated_within_deg,
        told=coarse,
        stiffest=stiffest,
    )
    yield claim("text-mfix-validation", coarse=off[min], fine=off[max], told=fine)


def _lammps(printed: Printed, engine: Engine) -> Iterator[Statement]:
    def measured(steps: float, contact: Contact = SOURCE) -> CriticalAngle:
        case = Incline(steps_per_contact=steps, contact=contact)
        return measured_critical_angle(case, engine=engine)

    found = [measured(steps) for steps in _STEPS]
    rebound = measured(_STEPS[0], Contact(restitution=_REBOUND))
    angles = [f"{angle.value_deg:.4f} +- {angle.uncertainty_deg:.4f} deg" for angle in found]
    yield compare(
        "text-lammps-angle",
        printed=printed.critical_angle_deg,
        found=found[0].value_deg,
        tolerance=printed.simulated_within_deg,
        angle=angles[0],
        steps=_STEPS[0],
    )
    yield claim(
        "text-lammps-step",
        found=found,
        within=printed.simulated_within_deg,
        angles=[f"{a} at {s:g} steps per contact" for s, a in zip(_STEPS, angles, strict=True)],
    )
    yield compare(
        "text-restitution-angle",
        printed=critical_angle(SOURCES["eq-9"].printed(e=_REBOUND)),
        found=rebound.value_deg,
        corrected=critical_angle(SOURCES["eq-9"].corrected(e=_REBOUND)),
        uncertainty=rebound.uncertainty_deg,
    )
