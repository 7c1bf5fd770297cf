"""Section Background: the incline in MFiX and LAMMPS, and the angle of rest."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from harness.cases.incline.critical_angle import CriticalAngle
from harness.cases.incline.critical_angles import critical_angle as measured_critical_angle
from harness.cases.incline.parameters import Incline
from harness.engines.contract import Engine
from harness.engines.mfix.recorded import recorded_angles
from harness.errors import EngineError
from harness.parameters.contact import SOURCE, Contact
from harness.reproduction import as_printed
from harness.reproduction.as_printed import Printed
from harness.reproduction.claims import (
    Source,
    Statement,
    Width,
    claim,
    compare,
    untestable,
)
from harness.reproduction.ledger.contact import integrate
from harness.reproduction.ledger.widths import last_digit
from harness.theory.critical_angle import critical_angle

Recorded = dict[float, dict[int, float]]

_STEPS = (50.0, 100.0, 200.0, 400.0)  # per contact time
_REBOUND = 0.1
_WITHOUT = "no engine was given to run the incline in"


def statements(printed: Printed, engine: Engine | None) -> list[Statement]:
    """Return the rows in the order of the text."""
    return [
        _restitution(printed),
        *_mfix(printed),
        *_lammps(printed, engine),
        _rest(printed),
    ]


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
        Source(
            "text-restitution",
            "Background, on the MFiX runs",
            "normal restitution is nearly zero (1e-20)",
        ),
        printed=printed.restitution,
        found=found,
        width=Width(1e-4, "1", "the energy kept is 1/4 + 3/4 e^2: below 1e-4 e moves it by 1e-8"),
        computed=f"MFiX takes m/2 for the effective mass, against a base that is merely held too: "
        f"the damping ratio is {half:.4f} in place of {full:.4f}, and the grain rebounds with "
        f"e = {found:.4f} (contact integrated)",
        correction="the effective mass against a fixed sphere is m, not m/2",
        evidence=("tests/theory/test_dashpot.py",),
    )


def _mfix(printed: Printed) -> list[Statement]:
    angles, exact = angles_by_step(), critical_angle()
    coarse = {k: min(by_step) for k, by_step in angles.items()}
    off = {k: angles[k][coarse[k]] - exact for k in angles}
    stiffest = max(angles)
    finest = {k: by_step[max(by_step)] - exact for k, by_step in angles.items()}
    source = "Background, on the MFiX runs, and Fig. 4"
    return [
        compare(
            Source(
                "text-mfix-angle",
                source,
                "the smallest angle of steady motion in MFiX is theta_c to a hundredth of a degree",
            ),
            printed=printed.critical_angle_deg,
            found=angles[stiffest][coarse[stiffest]],
            width=Width(printed.simulated_within_deg, "deg", "what the source claims"),
            computed="recorded runs at MFiX's default step (contact time / 50) lie "
            + ", ".join(f"{off[k]:+.4f} deg off at {k:.0e} N/m" for k in off)
            + f"; compared is {stiffest:.0e} N/m (the source does not give its stiffness)",
            evidence=("tests/verbs/reproduction/ledger/test_background.py",),
        ),
        claim(
            Source("text-mfix-validation", source, "the agreement validates the analysis"),
            holds=all(abs(finest[k]) <= abs(off[k]) for k in off),
            computed="with a step a hundred times finer the same runs lie "
            + ", ".join(f"{finest[k]:+.4f} deg off at {k:.0e} N/m" for k in finest)
            + ": errors of step and stiffness cancel at the default step",
            correction="take the step to zero first, then the stiffness to infinity",
            evidence=("tests/verbs/reproduction/ledger/test_background.py",),
            why="a refined step must not lie further off",
        ),
    ]


def _lammps(printed: Printed, engine: Engine | None) -> list[Statement]:
    place = "Background, on the MFiX runs; LAMMPS in its place"
    first = Source("text-lammps-angle", place, "theta_c to a hundredth of a degree, 1e6 N/m")
    second = Source("text-lammps-step", place, "the angle does not depend on the step")
    third = Source(
        "text-restitution-angle",
        "Background, eqs. (6) and (9); LAMMPS in MFiX's place",
        f"at e_n = {_REBOUND:g} theta_c follows from the shock of eq. (9)",
    )
    if engine is None:
        return [untestable(one, _WITHOUT) for one in (first, second, third)]
    try:
        found = [_measured(steps, engine) for steps in _STEPS]
        rebounding = _measured(_STEPS[0], engine, Contact(restitution=_REBOUND))
    except EngineError as error:
        return [untestable(one, f"the engine failed: {error}") for one in (first, second, third)]
    coarse, fine = found[0], found[-1]
    evidence = ("tests/engines/lammps/test_engine.py", "tests/cli/test_critical_angle.py")
    return [
        compare(
            first,
            printed=printed.critical_angle_deg,
            found=coarse.value_deg,
            width=Width(printed.simulated_within_deg, "deg", "what the source claims"),
            computed=f"{coarse.value_deg:.4f} +- {coarse.uncertainty_deg:.4f} deg in the source's "
            f"contact (e = 1e-20, tail kept) at {_STEPS[0]:g} steps per contact, passage",
            evidence=evidence,
        ),
        claim(
            second,
            holds=abs(fine.value_deg - coarse.value_deg) <= printed.simulated_within_deg,
            computed=", ".join(
                f"{a.value_deg:.4f} +- {a.uncertainty_deg:.4f} deg at {s:g} steps per contact"
                for s, a in zip(_STEPS, found, strict=True)
            ),
            correction="extrapolate step and stiffness, with a contact without tail and rebound",
            evidence=evidence,
            why="the agreement claimed, a hundredth of a degree",
        ),
        _rebound(third, rebounding, evidence),
    ]


def _measured(steps: float, engine: Engine, contact: Contact = SOURCE) -> CriticalAngle:
    case = Incline(steps_per_contact=steps, contact=contact)
    return measured_critical_angle(case, engine=engine)


def _rebound(source: Source, found: CriticalAngle, evidence: tuple[str, ...]) -> Statement:
    lost, kept = (
        critical_angle(shock)
        for shock in (
            as_printed.shock_of_restitution(_REBOUND),
            as_printed.velocity_after(1.0, _REBOUND) ** 2,
        )
    )
    return compare(
        source,
        printed=lost,
        found=found.value_deg,
        width=Width(0.05, "deg", "what step and stiffness do at 1e6 N/m (text-lammps-step)"),
        computed=f"{lost:.3f} deg by eq. (9), {kept:.3f} deg by 1/4 + 3/4 e^2, "
        f"{found.value_deg:.4f} +- {found.uncertainty_deg:.4f} deg in LAMMPS: the "
        "grain bounces several times in a well, and what is normal to the contact is lost all the "
        "same",
        corrected=kept,
        correction="neither reading: theta_c stays that of e_n = 0 as long as the rebounds end "
        "within a well",
        evidence=evidence,
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
        Source(
            "text-rest-angle",
            "Background, last paragraphs",
            "at rest the grain starts above 30 deg only: hysteresis",
        ),
        printed=printed.rest_angle_deg,
        found=found,
        width=last_digit(1.0, "deg"),
        computed=f"equilibrium of the two contacts: the upper one is without force at "
        f"{found:.4f} deg, {found - critical_angle():.2f} deg above the angle of motion",
        evidence=("tests/theory/test_critical_angle.py",),
    )
