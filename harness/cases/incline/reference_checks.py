"""The third opinion: LAMMPS against the reference DEM, on the runs that are there already.

Same stiffness, step, contact and integration (velocity Verlet): only round-off may
tell them apart. What the integration itself is worth, the adaptive integrator says.
"""

from __future__ import annotations

import math

import numpy as np

from harness.cases.incline.critical_angle import CriticalAngle
from harness.cases.incline.critical_angles import critical_angle
from harness.cases.incline.parameters import Incline
from harness.cases.incline.passage import PHASES
from harness.cases.incline.result import InclineRun
from harness.cases.incline.routes import Start
from harness.comparison.evidence import InclineEvidence
from harness.comparison.tolerances import TOLERANCES
from harness.comparison.verdicts import Check, Kind, failed_run, finding, judge, not_tested
from harness.engines.contract import Engine
from harness.engines.reference.engine import Reference
from harness.errors import EngineError
from harness.parameters.contact import CONTACTS, PLASTIC, SOURCE, Contact
from harness.theory.dashpot import restitution_unclipped
from harness.workflows.verification.levels import Level

STIFFNESSES = (1e5, 1e6, 1e7)
STEPS = {SOURCE.name: 50.0, "clipped": 50.0, PLASTIC.name: 100.0}
"""Steps per contact time at which the contacts are compared."""

HEAD_ON = Contact(name="head-on", restitution=0.5, damping_ratio=None, tail="attractive")


def reference_checks(engine: Engine, level: Level, evidence: InclineEvidence) -> list[Check]:
    """Return the rows of the reference DEM, from the evidence that the incline left.

    An engine other than LAMMPS integrates in its own way: it is not tested here.
    """
    rows = [_restitution()]
    if engine.name != "lammps":
        reason = f"the reference DEM mimics LAMMPS's integration; this is {engine.name!r}"
        return [*rows, not_tested("incline: against the reference DEM", Kind.CROSS_CODE, reason)]
    for name in CONTACTS:
        for stiffness in STIFFNESSES:
            found = _angle_at(evidence, name, stiffness)
            if found is not None:
                rows.append(_angle(found, level))
    rows += [_path(run) for run in evidence.motions]
    if level.name == "full":
        rows += _worth_of_the_step(evidence)
    return rows


def _angle_at(evidence: InclineEvidence, contact: str, stiffness: float) -> CriticalAngle | None:
    for angle in evidence.by_contact.get(contact, []):
        case = angle.case
        same = math.isclose(case.stiffness, stiffness, rel_tol=1e-12)
        if same and case.steps_per_contact == STEPS[contact]:
            return angle
    return None


def _angle(lammps: CriticalAngle, level: Level) -> Check:
    case = lammps.case
    name = (
        f"incline: LAMMPS against the reference DEM, {case.contact.name} contact, "
        f"k = {case.stiffness:.3g} N/m"
    )
    phases = PHASES if case.contact == PLASTIC else level.phases_beside
    try:
        own = critical_angle(case, engine=Reference(), phases=phases)
    except EngineError as error:
        return failed_run(name, Kind.CROSS_CODE, error, "deg")
    tolerance = TOLERANCES["critical angle, reference DEM"]
    return judge(name, Kind.CROSS_CODE, lammps.value_deg, own.value_deg, tolerance)


def _path(lammps: InclineRun) -> Check:
    """Hold the path over the first wells against the reference's, at the same steps."""
    case = lammps.case
    name = f"incline: path at {case.angle:.2f} deg, LAMMPS against the reference DEM"
    assert lammps.trajectory is not None
    path = lammps.trajectory
    every = round(float(path.time_s[1] - path.time_s[0]) / case.step)
    try:
        short = case.replace(time_limit=PATH_TIME)
        (own,) = Reference().inclines([short], "steady", every=every)
    except EngineError as error:
        return failed_run(name, Kind.CROSS_CODE, error, "d")
    if isinstance(own, EngineError):
        return failed_run(name, Kind.CROSS_CODE, own, "d")
    assert own.trajectory is not None
    rows = min(len(path.time_s), len(own.trajectory.time_s))
    apart = np.hypot(
        path.x_m[:rows] - own.trajectory.x_m[:rows], path.y_m[:rows] - own.trajectory.y_m[:rows]
    )
    return judge(
        f"{name}, largest distance",
        Kind.CROSS_CODE,
        float(apart.max()) / case.diameter,
        0.0,
        TOLERANCES["path, reference DEM"],
    )


PATH_TIME = 20.0
"""[sqrt(d/g)] over which paths are compared: rounding grows on every slow crest, by e a unit."""


def _worth_of_the_step(evidence: InclineEvidence) -> list[Check]:
    """Report what the source's step is worth: the same contact without a step."""
    lammps = _angle_at(evidence, SOURCE.name, 1e6)
    if lammps is None:
        return []
    name = "incline: the source's contact at k = 1e6 N/m, LAMMPS against no step at all"
    try:
        exact = critical_angle(lammps.case, engine=Reference("adaptive"), phases=1)
    except EngineError as error:
        return [failed_run(name, Kind.CROSS_CODE, error, "deg")]
    note = "held against the adaptive reference: 50 steps per contact skip the attractive tail"
    return [finding(name, lammps.value_deg, exact.value_deg, "deg", note, lammps.uncertainty_deg)]


def _restitution() -> Check:
    """Hold a head-on collision of the adaptive reference against the closed form."""
    case = Incline(angle=0.0, contact=HEAD_ON, gravity=1e-12)
    start = Start(0.0, case.diameter * (1.0 + 1e-6), 0.0, -1.0)
    name = "reference DEM: restitution head-on, adaptive"
    try:
        path = Reference("adaptive").follow(case, start, 3.0 * case.contact_time, every=150)
    except EngineError as error:
        return failed_run(name, Kind.ANALYTIC, error)
    return judge(
        name,
        Kind.ANALYTIC,
        float(path.vy_m_per_s[-1]),
        restitution_unclipped(case.contact.zeta),
        TOLERANCES["restitution, adaptive"],
    )
